#include "base.h"

#include <math.h>

#include "places.h"

int nsdae_stretches_add(nsdae_stretches *s, double grid, double dt, double t_end)
{
  int last = *s->count - 1, next = last + 1;
  if (last >= 0 && nsdae_stretches_end(s, last, s->steps[last] - 1, dt) == t_end) return 1;
  if (*s->ends == NSDAE_ENDS_MAX) return 0;
  if (last >= 0 && nsdae_stretches_end(s, last, s->steps[last], dt) == t_end) {
    s->steps[last]++;
    ++*s->ends;
    return 1;
  }
  if (next == NSDAE_STRETCHES_MAX) return 0;
  s->origin[next] = grid;
  s->number[next] = round((t_end - grid) / dt);
  if (nsdae_stretches_end(s, next, 0, dt) != t_end) s->origin[next] = t_end, s->number[next] = 0;
  s->steps[next] = 1;
  ++*s->count;
  ++*s->ends;
  return 1;
}

/* The base behind the warm start of the contacts. */
static void lay(nsdae_penalty_base *b, const nsdae_stepper *s, nsdae_memory_part *part)
{
  const nsdae_dims *d = &s->system->dims;
  size_t k = (size_t)d->k;
  double **of_contact[] = {&b->since, &b->start_rate, &b->mass, &b->impulse, &b->peak};
  b->t = nsdae_memory_reals(part, 1);
  b->y = nsdae_memory_reals(part, (size_t)nsdae_penalty_size(d));
  for (int i = 0; i < 5; i++) *of_contact[i] = nsdae_memory_reals(part, k);
  b->impulse_t = nsdae_memory_reals(part, k * (size_t)d->nt);
  b->since_then.origin = nsdae_memory_reals(part, NSDAE_STRETCHES_MAX);
  b->since_then.number = nsdae_memory_reals(part, NSDAE_STRETCHES_MAX);
  nsdae_memory_wholes(part, nsdae_contacts_memory_size(&s->contacts));
  b->since_then.steps = nsdae_memory_wholes(part, NSDAE_STRETCHES_MAX);
  b->since_then.count = nsdae_memory_wholes(part, 1);
  b->since_then.ends = nsdae_memory_wholes(part, 1);
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
