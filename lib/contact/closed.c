#include "closed.h"

#include <stdint.h>
#include <string.h>

#include "dynamic_array.h"

enum { ARRAYS = 13 };

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
                                    NSDAE_ARRAY(r->tangential, c->nt)};
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
