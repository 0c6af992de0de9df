#include "impulses.h"

#include <stdint.h>
#include <string.h>

#include "vector.h"

/* All doubles and all integers are in one piece each, so that they are cleared at once. */
static size_t doubles(const nsdae_dims *d)
{
  return 3 * ((size_t)d->k * (size_t)(2 + d->nt) + (size_t)d->f);
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
  r->linear = r->tangential + kt;
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
  const size_t size[] = {n, n, n, t, t, t, f, f, f, 3 * n};
  double *const into[] = {to->before,       to->after,       to->normal,
                          to->before_t,     to->after_t,     to->tangential,
                          to->slide_before, to->slide_after, to->frictional_joint_impulse,
                          to->linear};
  double *const of[] = {from->before,       from->after,       from->normal,
                        from->before_t,     from->after_t,     from->tangential,
                        from->slide_before, from->slide_after, from->frictional_joint_impulse,
                        from->linear};
  nsdae_impulses_clear(to, dims);
  for (int i = 0; i < 10; i++)
    if (size[i] > 0) memcpy(into[i], of[i], size[i] * sizeof *into[i]);
  if (n > 0) memcpy(to->impact, from->impact, n * sizeof *to->impact);
  if (n > 0) memcpy(to->mode, from->mode, n * sizeof *to->mode);
  if (f > 0) memcpy(to->frictional_joint_mode, from->frictional_joint_mode, f * sizeof(int));
}

/* ---- closed */

enum { ARRAYS = 14 };

static void list_arrays(nsdae_closed *c, nsdae_impulses *r, nsdae_array all[ARRAYS])
{
  const nsdae_array list[ARRAYS] = {NSDAE_ARRAY(c->id, 1),
                                    NSDAE_ARRAY(c->block, 2),
                                    NSDAE_ARRAY(c->gap, 1),
                                    NSDAE_ARRAY(c->fresh, 1),
                                    NSDAE_ARRAY(c->basis, c->rows),
                                    NSDAE_ARRAY(r->impact, 1),
                                    NSDAE_ARRAY(r->mode, 1),
                                    NSDAE_ARRAY(r->before, 1),
                                    NSDAE_ARRAY(r->before_t, c->nt),
                                    NSDAE_ARRAY(r->after, 1),
                                    NSDAE_ARRAY(r->after_t, c->nt),
                                    NSDAE_ARRAY(r->normal, 1),
                                    NSDAE_ARRAY(r->tangential, c->nt),
                                    NSDAE_ARRAY(r->linear, 3)};
  memcpy(all, list, sizeof list);
}

int nsdae_closed_grow(nsdae_closed *c, nsdae_impulses *r, int room)
{
  nsdae_array all[ARRAYS];
  list_arrays(c, r, all);
  int status = nsdae_arrays_grow(all, ARRAYS, (size_t)room);
  if (status == NSDAE_OK) c->room = room;
  return status;
}

void nsdae_closed_release(nsdae_closed *c, nsdae_impulses *r)
{
  nsdae_array all[ARRAYS];
  list_arrays(c, r, all);
  nsdae_arrays_release(all, ARRAYS);
  c->room = 0;
}

void nsdae_closed_clear(const nsdae_closed *c, nsdae_impulses *r)
{
  size_t k = (size_t)c->count, kt = k * (size_t)c->nt;
  memset(r->impact, 0, k * sizeof *r->impact);
  memset(r->mode, 0, k * sizeof *r->mode);
  memset(r->linear, 0, 3 * k * sizeof *r->linear);
  double *const by_contact[] = {r->before, r->after, r->normal};
  double *const by_tangent[] = {r->before_t, r->after_t, r->tangential};
  for (int i = 0; i < 3; i++) {
    memset(by_contact[i], 0, k * sizeof(double));
    memset(by_tangent[i], 0, kt * sizeof(double));
  }
}

int nsdae_ids_grow(nsdae_ids *ids, int room)
{
  size_t slots = 16;
  while (slots < 2 * (size_t)room) slots *= 2;
  const nsdae_array table[] = {NSDAE_ARRAY(ids->slot, 1)};
  int status = nsdae_arrays_grow(table, 1, slots);
  if (status == NSDAE_OK) ids->slots = slots;
  return status;
}

void nsdae_ids_release(nsdae_ids *ids)
{
  const nsdae_array table[] = {NSDAE_ARRAY(ids->slot, 1)};
  nsdae_arrays_release(table, 1);
}

/* Fibonacci's multiplier spreads neighbours; the high bits are the good ones. */
static size_t first_slot(const nsdae_ids *ids, long id)
{
  uint64_t mixed = (uint64_t)id * UINT64_C(11400714819323198485);
  return (size_t)(mixed ^ mixed >> 32) & (ids->slots - 1);
}

int nsdae_ids_fill(nsdae_ids *ids, int count, const long *id)
{
  int twice = -1;
  ids->id = id;
  memset(ids->slot, -1, ids->slots * sizeof *ids->slot);
  for (int i = count - 1; i >= 0; i--) {
    size_t s = first_slot(ids, id[i]);
    while (ids->slot[s] >= 0 && id[ids->slot[s]] != id[i]) s = (s + 1) & (ids->slots - 1);
    if (ids->slot[s] >= 0) twice = i;
    ids->slot[s] = i;
  }
  return twice;
}

int nsdae_ids_find(const nsdae_ids *ids, long id)
{
  for (size_t s = first_slot(ids, id); ids->slot[s] >= 0; s = (s + 1) & (ids->slots - 1))
    if (ids->id[ids->slot[s]] == id) return ids->slot[s];
  return -1;
}
