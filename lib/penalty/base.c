#include "equations.h"

static void lay(nsdae_penalty_base *b, nsdae_tracking *tracking, const nsdae_stepper *s,
                nsdae_memory_part *part)
{
  const nsdae_dims *d = &s->system->dims;
  double **of_contact[] = {&b->since, &b->start_rate, &b->mass, &b->impulse, &b->peak};
  b->t = nsdae_memory_reals(part, 1);
  b->first = nsdae_memory_reals(part, 1);
  b->qv = nsdae_memory_reals(part, (size_t)d->nq + (size_t)d->nv);
  for (int i = 0; i < 5; i++) *of_contact[i] = nsdae_memory_slot_reals(part, 1);
  b->impulse_t = nsdae_memory_slot_reals(part, (size_t)d->nt);
  b->steps = nsdae_memory_wholes(part, 1);
  b->is_stiff = nsdae_memory_wholes(part, 1);
  b->closed = nsdae_memory_slot_wholes(part, 1);
  if (s->system->tracked) nsdae_tracking_lay(tracking, s->system, part);
}

void nsdae_penalty_base_lay(const nsdae_stepper *s, nsdae_memory_part *part)
{
  nsdae_penalty_base base;
  nsdae_tracking tracking;
  lay(&base, &tracking, s, part);
}

void nsdae_penalty_base_find(nsdae_penalty_base *b, nsdae_tracking *tracking,
                             const nsdae_stepper *s, nsdae_memory *memory)
{
  nsdae_memory_part part = {
      .real = memory->real, .whole = memory->whole, .slots = (size_t)s->system->dims.k};
  lay(b, tracking, s, &part);
}
