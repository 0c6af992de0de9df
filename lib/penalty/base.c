#include "base.h"

/* The base behind the warm start of the contacts. */
static void lay(nsdae_penalty_base *b, const nsdae_stepper *s, nsdae_memory_part *part)
{
  const nsdae_dims *d = &s->system->dims;
  size_t k = (size_t)d->k;
  double **of_contact[] = {&b->since, &b->start_rate, &b->mass, &b->impulse, &b->peak};
  b->t = nsdae_memory_reals(part, 1);
  b->first = nsdae_memory_reals(part, 1);
  b->qv = nsdae_memory_reals(part, (size_t)d->nq + (size_t)d->nv);
  for (int i = 0; i < 5; i++) *of_contact[i] = nsdae_memory_reals(part, k);
  b->impulse_t = nsdae_memory_reals(part, k * (size_t)d->nt);
  nsdae_memory_wholes(part, nsdae_contacts_memory_size(&s->contacts));
  b->steps = nsdae_memory_wholes(part, 1);
  b->is_stiff = nsdae_memory_wholes(part, 1);
  b->closed = nsdae_memory_wholes(part, k);
}

void nsdae_penalty_base_sizes(const nsdae_stepper *s, size_t *reals, size_t *wholes)
{
  nsdae_penalty_base base;
  nsdae_memory_part part = {0};
  lay(&base, s, &part);
  *reals = part.reals;
  *wholes = part.wholes;
}

void nsdae_penalty_base_find(nsdae_penalty_base *b, const nsdae_stepper *s, nsdae_memory *memory)
{
  nsdae_memory_part part = {.real = memory->real, .whole = memory->whole};
  lay(b, s, &part);
}
