#include "lists.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "errors.h"
#include "arena.h"
#include "maker.h"

void nsdae_contact_list_clear(nsdae_contact_list *list)
{
  list->status = NSDAE_OK;
  list->count = 0;
  list->taken = (nsdae_room){0};
}

int nsdae_contact_list_reads_omega(const nsdae_contact_list *list)
{
  return !list->without_omega;
}

static int refuse_contact(nsdae_contact_list *list, const nsdae_contact *c, int status,
                          const char *field, double value, const char *range)
{
  if (list->status < 0) return status; /* the first is reported */
  list->status = status;
  return nsdae_error_set(list->error, status, "nsdae_contact_add", field,
                         "contact of id %ld: %s = %g is outside its range: it must be %s", c->id,
                         field, value, range);
}

/* Conditions are written so that NaN fails. */
static int check_contact(nsdae_contact_list *list, const nsdae_contact *c)
{
  if (!isfinite(c->gap)) return refuse_contact(list, c, NSDAE_E_NONFINITE, "gap", c->gap, "finite");
  if (!(c->mu >= 0 && c->mu <= 1e300))
    return refuse_contact(list, c, NSDAE_E_ARGUMENT, "mu", c->mu, "at least 0, finite");
  if (c->mu > 0 && list->nt == 0)
    return refuse_contact(list, c, NSDAE_E_ARGUMENT, "mu", c->mu,
                          "0 where dims.nt = 0: there is no tangential direction");
  if (!(c->e_n >= 0 && c->e_n <= 1))
    return refuse_contact(list, c, NSDAE_E_ARGUMENT, "e_n", c->e_n, "0 .. 1");
  if (!(c->e_t >= 0 && c->e_t <= 1))
    return refuse_contact(list, c, NSDAE_E_ARGUMENT, "e_t", c->e_t, "0 .. 1");
  for (int d = 0; d <= list->nt; d++)
    if (!isfinite(c->w[d]))
      return refuse_contact(list, c, NSDAE_E_NONFINITE, "w", c->w[d], "finite");
  if (c->omega_given != 0 && c->omega_given != 1)
    return refuse_contact(list, c, NSDAE_E_ARGUMENT, "omega_given", c->omega_given, "0 or 1");
  for (int d = 0; d <= list->nt && c->omega_given; d++)
    if (!isfinite(c->omega[d]))
      return refuse_contact(list, c, NSDAE_E_NONFINITE, "omega", c->omega[d], "finite");
  for (int s = 0; s < 2; s++) {
    int b = c->block[s];
    if (b < -1 || b >= list->blocks->count)
      return refuse_contact(list, c, NSDAE_E_ARGUMENT, "block", b, "a block, or -1: the ground");
    if (b >= 0 && nsdae_blocks_size(list->blocks, b) > NSDAE_CONTACT_WIDTH && !c->wide[s])
      return refuse_contact(list, c, NSDAE_E_ARGUMENT, "wide", 0,
                            "the directions of a block of more than 6 velocities");
  }
  if (c->block[0] == c->block[1])
    return refuse_contact(list, c, NSDAE_E_ARGUMENT, "block", c->block[1],
                          "another block than the first");
  return NSDAE_OK;
}

/* Directions of one block: size x (1 + nt). The sum of products with zero is NaN where one is not
 * finite. */
static int copy_part(nsdae_contact_list *list, const nsdae_contact *c, int s, size_t at)
{
  size_t n = (size_t)nsdae_blocks_size(list->blocks, c->block[s]);
  double *to = list->value + at, sum = 0;
  for (int d = 0; d <= list->nt; d++, to += n) {
    const double *from = c->wide[s] ? c->wide[s] + (size_t)d * n : c->direction[s][d];
    for (size_t j = 0; j < n; j++) {
      to[j] = from[j];
      sum += 0 * from[j];
    }
  }
  return sum == 0 ? NSDAE_OK
                  : refuse_contact(list, c, NSDAE_E_NONFINITE, "direction", sum, "finite");
}

/* Counts a contact; where it goes in value, or SIZE_MAX where there is no room. */
static size_t take(nsdae_contact_list *list, const int *block)
{
  size_t at = list->taken.values;
  for (int s = 0; s < 2; s++)
    if (block[s] >= 0)
      list->taken.values +=
          (size_t)nsdae_blocks_size(list->blocks, block[s]) * (size_t)(1 + list->nt);
  list->taken.entries++;
  return nsdae_room_enough(&list->room, &list->taken) ? at : (size_t)-1;
}

/* Where the parts of the last contact begin. */
static void place_parts(nsdae_contact_list *list, int i, size_t at)
{
  for (int s = 0; s < 2; s++) {
    int b = list->block[2 * i + s];
    list->at[2 * i + s] = at;
    if (b >= 0) at += (size_t)nsdae_blocks_size(list->blocks, b) * (size_t)(1 + list->nt);
  }
}

int nsdae_contact_add(nsdae_contact_list *list, const nsdae_contact *c)
{
  if (!list || !c) return NSDAE_E_ARGUMENT;
  int status = check_contact(list, c);
  if (status < 0) return status;
  size_t at = take(list, c->block);
  if (at == (size_t)-1) return NSDAE_OK;
  int i = list->count++;
  list->id[i] = c->id;
  list->gap[i] = c->gap;
  list->law[i] = (nsdae_coefficients){c->mu, c->e_n, c->e_t, 1};
  memcpy(list->block + 2 * (size_t)i, c->block, sizeof c->block);
  list->omega_given[i] = c->omega_given;
  for (int d = 0; d <= list->nt; d++) {
    list->w[i * (1 + list->nt) + d] = c->w[d];
    list->omega[i * (1 + list->nt) + d] = c->omega_given ? c->omega[d] : 0;
  }
  place_parts(list, i, at);
  for (int s = 0; s < 2 && status == NSDAE_OK; s++)
    if (c->block[s] >= 0) status = copy_part(list, c, s, list->at[2 * (size_t)i + (size_t)s]);
  return status;
}

double nsdae_contact_list_velocity(const nsdae_contact_list *l, int i, int d, const double *v)
{
  double u = l->w[i * (1 + l->nt) + d];
  for (int side = 2 * i; side < 2 * i + 2; side++) {
    int b = l->block[side], n = b < 0 ? 0 : nsdae_blocks_size(l->blocks, b);
    const double *W = l->value + l->at[side] + (size_t)d * (size_t)n;
    for (int j = 0; j < n; j++) u += W[j] * v[l->blocks->first[b] + j];
  }
  return u;
}

/* Contacts from i on to place j, but where their values are. */
static void copy_contacts(nsdae_contact_list *to, size_t j, const nsdae_contact_list *from,
                          size_t i, size_t count)
{
  memcpy(to->id + j, from->id + i, count * sizeof *to->id);
  memcpy(to->gap + j, from->gap + i, count * sizeof *to->gap);
  memcpy(to->law + j, from->law + i, count * sizeof *to->law);
  memcpy(to->block + 2 * j, from->block + 2 * i, 2 * count * sizeof *to->block);
  memcpy(to->omega_given + j, from->omega_given + i, count * sizeof *to->omega_given);
  size_t columns = (size_t)(1 + to->nt);
  memcpy(to->w + columns * j, from->w + columns * i, columns * count * sizeof *to->w);
  memcpy(to->omega + columns * j, from->omega + columns * i, columns * count * sizeof *to->omega);
}

void nsdae_contact_list_copy(nsdae_contact_list *list, const nsdae_contact_list *from, int i,
                             double gap)
{
  size_t at = list->taken.values, begin = from->at[2 * (size_t)i];
  if (take(list, from->block + 2 * (size_t)i) == (size_t)-1) return;
  int new = list->count++;
  copy_contacts(list, (size_t) new, from, (size_t)i, 1);
  list->gap[new] = gap;
  place_parts(list, new, at);
  memcpy(list->value + at, from->value + begin, (list->taken.values - at) * sizeof *list->value);
}

/* By contact, and the values. */
enum { BY_CONTACT = 8 };

#define CONTACT_ARRAYS(l)                                                                    \
  {                                                                                          \
    NSDAE_ARRAY((l)->id, 1), NSDAE_ARRAY((l)->block, 2), NSDAE_ARRAY((l)->gap, 1),           \
        NSDAE_ARRAY((l)->law, 1), NSDAE_ARRAY((l)->at, 2), NSDAE_ARRAY((l)->w, 1 + (l)->nt), \
        NSDAE_ARRAY((l)->omega, 1 + (l)->nt), NSDAE_ARRAY((l)->omega_given, 1),              \
        NSDAE_ARRAY((l)->value, 1)                                                           \
  }

int nsdae_contact_list_grow(nsdae_contact_list *l, const nsdae_room *room)
{
  const nsdae_room new = nsdae_room_larger(&l->room, room);
  const nsdae_array all[] = CONTACT_ARRAYS(l);
  int status = nsdae_arrays_grow(all, BY_CONTACT, new.entries);
  if (status == NSDAE_OK) status = nsdae_arrays_grow(&all[BY_CONTACT], 1, new.values);
  if (status == NSDAE_OK) l->room = new;
  for (int i = 0; l->shares && l->shares->part && i < nsdae_thread_pool_size(l->shares->pool) &&
                  status == NSDAE_OK;
       i++) {
    l->shares->part[i].nt = l->nt;
    l->shares->part[i].blocks = l->blocks;
    status = nsdae_contact_list_grow(&l->shares->part[i], &new);
  }
  return status;
}

void nsdae_contact_list_release(nsdae_contact_list *l)
{
  const nsdae_array all[] = CONTACT_ARRAYS(l);
  nsdae_arrays_release(all, BY_CONTACT + 1);
  l->room = (nsdae_room){0};
}

/* ---- a list filled by several threads */

int nsdae_contact_shares_make(nsdae_contact_shares *s, nsdae_thread_pool *pool)
{
  size_t size = (size_t)nsdae_thread_pool_size(pool);
  s->pool = pool;
  if (size == 1) return NSDAE_OK;
  s->part = calloc(size, sizeof *s->part);
  s->error = calloc(size, sizeof *s->error);
  return s->part && s->error ? NSDAE_OK : NSDAE_E_MEMORY;
}

void nsdae_contact_shares_release(nsdae_contact_shares *s)
{
  for (int i = 0; s->part && i < nsdae_thread_pool_size(s->pool); i++)
    nsdae_contact_list_release(&s->part[i]);
  free(s->part);
  free(s->error);
  s->part = NULL;
  s->error = NULL;
}

/* Ranges of passes, each by one thread; passes of a range at least. */
enum { RANGES = 256, PASSES = 4 };

/* Where the contacts of a range begin in the list of its thread, and in the whole; how many they
 * are or, in a full list, would be. */
typedef struct piece {
  int worker;
  nsdae_room from, at, room;
} piece;

typedef struct sharing {
  nsdae_contact_list *list;
  nsdae_contact_pass *add;
  void *to;
  int count, grain;
  piece piece[RANGES];
} sharing;

static int fill_range(void *object, int worker, int range)
{
  sharing *s = object;
  nsdae_contact_list *part = &s->list->shares->part[worker];
  piece *p = &s->piece[range];
  int status = 0, end = (range + 1) * s->grain < s->count ? (range + 1) * s->grain : s->count;
  *p = (piece){.worker = worker, .from = part->taken};
  for (int i = range * s->grain; i < end && status >= 0; i++) status = s->add(s->to, part, i);
  p->room.entries = part->taken.entries - p->from.entries;
  p->room.values = part->taken.values - p->from.values;
  return status;
}

static int copy_range(void *object, int worker, int range)
{
  const sharing *s = object;
  const piece *p = &s->piece[range];
  nsdae_contact_list *to = s->list;
  const nsdae_contact_list *from = &to->shares->part[p->worker];
  size_t i = p->from.entries, j = p->at.entries, count = p->room.entries;
  (void)worker;
  copy_contacts(to, j, from, i, count);
  for (size_t k = 0; k < 2 * count; k++)
    to->at[2 * j + k] = from->at[2 * i + k] - p->from.values + p->at.values;
  memcpy(to->value + p->at.values, from->value + p->from.values,
         p->room.values * sizeof *to->value);
  return 0;
}

/* The first refusal, as on one thread. */
static int failed(sharing *s, int range)
{
  nsdae_contact_list *list = s->list;
  int worker = s->piece[range].worker;
  list->status = list->shares->part[worker].status;
  if (list->status < 0 && list->error) *list->error = list->shares->error[worker];
  return -1;
}

int nsdae_contact_list_share(nsdae_contact_list *list, int count, nsdae_contact_pass *add, void *to)
{
  nsdae_contact_shares *shares = list->shares;
  int status = 0;
  if (!shares || !shares->part || count < 2 * PASSES) {
    for (int i = 0; i < count && status >= 0; i++) status = add(to, list, i);
    return status;
  }
  sharing s = {.list = list, .add = add, .to = to, .count = count};
  s.grain = (count - 1) / RANGES + 1 > PASSES ? (count - 1) / RANGES + 1 : PASSES;
  int ranges = (count - 1) / s.grain + 1;
  for (int i = 0; i < nsdae_thread_pool_size(shares->pool); i++) {
    nsdae_contact_list *part = &shares->part[i];
    part->without_omega = list->without_omega;
    part->error = &shares->error[i];
    nsdae_contact_list_clear(part);
  }
  int bad = nsdae_thread_pool_run(shares->pool, 0, ranges, 1, fill_range, &s);
  if (bad >= 0) return failed(&s, bad);
  for (int i = 0; i < ranges; i++) {
    s.piece[i].at = list->taken;
    list->taken.entries += s.piece[i].room.entries;
    list->taken.values += s.piece[i].room.values;
  }
  if (!nsdae_room_enough(&list->room, &list->taken)) return NSDAE_OK; /* as nsdae_contact_add */
  nsdae_thread_pool_run(shares->pool, 0, ranges, 8, copy_range, &s);
  list->count = (int)list->taken.entries;
  return NSDAE_OK;
}

/* ---- rows of Phi_q and of frictional joints */

void nsdae_row_list_clear(nsdae_row_list *list)
{
  list->status = NSDAE_OK;
  list->last = -1;
  list->taken = (nsdae_room){0};
}

static int refuse_row(nsdae_row_list *list, int status, const char *argument, int row,
                      const char *what)
{
  if (list->status < 0) return status;
  list->status = status;
  nsdae_error_set(list->error, status, "nsdae_row_add", argument, "row %d of %s: %s", row,
                  list->kind == NSDAE_NAME_CONSTRAINT ? "Phi_q" : "W_S^T", what);
  nsdae_system_name_item(list->system, list->kind, row, list->error);
  return status;
}

/* Rows up to and with this one begin here. */
static void open_rows(nsdae_row_list *list, int row)
{
  for (; list->last < row; list->last++)
    list->rows->first[list->last + 1] = (int)list->taken.entries;
}

int nsdae_row_add(nsdae_row_list *l, int row, int block, const double *value)
{
  if (!l) return NSDAE_E_ARGUMENT;
  if (row < 0 || row >= l->rows->count || row < l->last)
    return refuse_row(l, NSDAE_E_ARGUMENT, "row", row,
                      l->kind == NSDAE_NAME_CONSTRAINT ? "rows are 0 .. m-1, in ascending order"
                                                       : "rows are 0 .. f-1, in ascending order");
  if (block < 0 || block >= l->blocks->count)
    return refuse_row(l, NSDAE_E_ARGUMENT, "block", row, "there is no such block");
  if (!value) return refuse_row(l, NSDAE_E_ARGUMENT, "value", row, "value is NULL");
  for (int j = 0; j < nsdae_blocks_size(l->blocks, block); j++)
    if (!isfinite(value[j]))
      return refuse_row(l, NSDAE_E_NONFINITE, "value", row, "an entry is not finite");
  if (l->x) {
    l->last = row;
    l->product[row] +=
        nsdae_dot(nsdae_blocks_size(l->blocks, block), value, l->x + l->blocks->first[block]);
    return NSDAE_OK;
  }
  open_rows(l, row);
  size_t at = l->taken.values, part = l->taken.entries;
  size_t n = (size_t)nsdae_blocks_size(l->blocks, block);
  l->taken.values += n;
  l->taken.entries++;
  if (!nsdae_room_enough(&l->room, &l->taken)) return NSDAE_OK;
  for (int p = l->rows->first[row]; p < (int)part; p++)
    if (l->rows->block[p] == block)
      return refuse_row(l, NSDAE_E_ARGUMENT, "block", row, "a block occurs twice");
  l->rows->block[part] = block;
  l->rows->at[part] = at;
  memcpy(l->rows->value + at, value, n * sizeof *value);
  return NSDAE_OK;
}

void nsdae_row_list_close(nsdae_row_list *list)
{
  open_rows(list, list->rows->count);
}

/* By entries, and the values. */
#define ROW_ARRAYS(l)                                                \
  {                                                                  \
    NSDAE_ARRAY((l)->rows->block, 1), NSDAE_ARRAY((l)->rows->at, 1), \
        NSDAE_ARRAY((l)->rows->value, 1)                             \
  }

int nsdae_row_list_grow(nsdae_row_list *l, const nsdae_room *room)
{
  const nsdae_room new = nsdae_room_larger(&l->room, room);
  const nsdae_array all[] = ROW_ARRAYS(l);
  int status = nsdae_arrays_grow(all, 2, new.entries);
  if (status == NSDAE_OK) status = nsdae_arrays_grow(&all[2], 1, new.values);
  if (status == NSDAE_OK) l->room = new;
  return status;
}

void nsdae_row_list_release(nsdae_row_list *l)
{
  if (!l->rows) return;
  const nsdae_array all[] = ROW_ARRAYS(l);
  nsdae_arrays_release(all, 3);
  l->room = (nsdae_room){0};
}
