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
  r->slide_before = real;
  r->slide_after = r->slide_before + f;
  r->frictional_joint_impulse = r->slide_after + f;
  r->frictional_joint_mode = whole;
  if (k == 0) return; /* those of a list grow with it */
  r->before = r->frictional_joint_impulse + f;
  r->before_t = r->before + k;
  r->after = r->before_t + kt;
  r->after_t = r->after + k;
  r->normal = r->after_t + kt;
  r->tangential = r->normal + k;
  r->impact = r->frictional_joint_mode + f;
  r->mode = r->impact + k;
}

void nsdae_impulses_clear(nsdae_impulses *r, const nsdae_dims *dims)
{
  if (dims->k + dims->f == 0) return;
  memset(r->slide_before, 0, doubles(dims) * sizeof *r->slide_before);
  memset(r->frictional_joint_mode, 0, wholes(dims) * sizeof *r->frictional_joint_mode);
}

double nsdae_impulses_work(const nsdae_impulses *r, int nt, int contacts, const int *contact,
                           int joints, const int *joint)
{
  double work = 0;
  for (int a = 0; a < contacts; a++) {
    int i = contact[a];
    work += r->normal[i] * (r->after[i] + r->before[i]) / 2;
    for (int j = i * nt; j < (i + 1) * nt; j++)
      work += r->tangential[j] * (r->after_t[j] + r->before_t[j]) / 2;
  }
  for (const int *end = joint + joints; joint < end; joint++)
    work += r->frictional_joint_impulse[*joint] *
            (r->slide_after[*joint] + r->slide_before[*joint]) / 2;
  return work;
}

void nsdae_impulses_blend(nsdae_impulses *to, const nsdae_dims *dims, double share,
                          const nsdae_impulses *from)
{
  nsdae_blend((int)doubles(dims), share, from->slide_before, to->slide_before);
}

void nsdae_impulses_carry(nsdae_impulses *to, const nsdae_dims *dims, int count,
                          const nsdae_impulses *from)
{
  size_t n = (size_t)count, t = n * (size_t)dims->nt, f = (size_t)dims->f;
  const size_t size[] = {n, n, n, t, t, t, f, f, f};
  double *const into[] = {to->before,       to->after,       to->normal,
                          to->before_t,     to->after_t,     to->tangential,
                          to->slide_before, to->slide_after, to->frictional_joint_impulse};
  double *const of[] = {from->before,       from->after,       from->normal,
                        from->before_t,     from->after_t,     from->tangential,
                        from->slide_before, from->slide_after, from->frictional_joint_impulse};
  nsdae_impulses_clear(to, dims);
  for (int i = 0; i < 9; i++)
    if (size[i] > 0) memcpy(into[i], of[i], size[i] * sizeof *into[i]);
  if (n > 0) memcpy(to->impact, from->impact, n * sizeof *to->impact);
  if (n > 0) memcpy(to->mode, from->mode, n * sizeof *to->mode);
  if (f > 0) memcpy(to->frictional_joint_mode, from->frictional_joint_mode, f * sizeof(int));
}
