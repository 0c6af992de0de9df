#include "impulses.h"

#include <string.h>

#include "vector.h"

/* All doubles and all integers are in one piece each, so that they are cleared at once. */
static size_t doubles(const nsdae_dims *d)
{
  return 3 * ((size_t)d->k * (size_t)(1 + d->nt) + (size_t)d->f);
}

static size_t wholes(const nsdae_dims *d)
{
  return 2 * (size_t)d->k + (size_t)d->f;
}

void nsdae_impulses_layout(nsdae_impulses *r, const nsdae_dims *dims, nsdae_arena *arena)
{
  size_t k = (size_t)dims->k, kt = k * (size_t)dims->nt, f = (size_t)dims->f;
  double *real = NSDAE_ARENA_DOUBLES(arena, doubles(dims));
  int *whole = NSDAE_ARENA_INTS(arena, wholes(dims));
  if (!real || !whole) return; /* measuring */
  r->before = real;
  r->before_t = r->before + k;
  r->after = r->before_t + kt;
  r->after_t = r->after + k;
  r->normal = r->after_t + kt;
  r->tangential = r->normal + k;
  r->slide_before = r->tangential + kt;
  r->slide_after = r->slide_before + f;
  r->frictional_joint_impulse = r->slide_after + f;
  r->impact = whole;
  r->mode = r->impact + k;
  r->frictional_joint_mode = r->mode + k;
}

void nsdae_impulses_clear(nsdae_impulses *r, const nsdae_dims *dims)
{
  memset(r->before, 0, doubles(dims) * sizeof *r->before);
  memset(r->impact, 0, wholes(dims) * sizeof *r->impact);
}

double nsdae_impulses_work(const nsdae_impulses *r, int nt, int count, const int *contact)
{
  double work = 0;
  for (int a = 0; a < count; a++) {
    int i = contact ? contact[a] : a;
    work += r->normal[i] * (r->after[i] + r->before[i]) / 2;
    for (int j = i * nt; j < (i + 1) * nt; j++)
      work += r->tangential[j] * (r->after_t[j] + r->before_t[j]) / 2;
  }
  return work;
}

void nsdae_impulses_blend(nsdae_impulses *to, const nsdae_dims *dims, double share,
                          const nsdae_impulses *from)
{
  nsdae_blend((int)doubles(dims), share, from->before, to->before);
}
