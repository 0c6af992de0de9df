#include "listed.h"

#include <stdio.h>
#include <string.h>

#include "errors.h"
#include "arena.h"

/* The status, with what the system's maker knows of the failure of the callback. */
static int explain(nsdae_terms *T, const char *callback, int status)
{
  if (!T->error) return status;
  const nsdae_error as = *T->error;
  snprintf(T->error->argument, sizeof T->error->argument, "%s", callback);
  if (!nsdae_system_explain(T->system, nsdae_terms_time(T), T->q, T->v, T->error)) *T->error = as;
  return status;
}

/* A callback's code, what it was refused with, whether there was room. */
static int listed(nsdae_terms *T, int code, int refused, const char *callback,
                  const nsdae_room *room, const nsdae_room *taken)
{
  int of_rows = taken != &T->by.list.taken;
  if (refused < 0) {
    if (T->error) T->error->time = nsdae_terms_time(T);
    return explain(T, callback, refused);
  }
  int status = nsdae_system_callback_status(code, callback, nsdae_terms_time(T), T->error);
  if (status < 0) return explain(T, callback, status);
  return nsdae_differences_room(T->differences, of_rows, room, taken);
}

/* The velocity whose column in its block the error's entry of M is in. */
static int name_column(const nsdae_terms *T, int status)
{
  const nsdae_blocks *blocks = &T->system->blocks;
  if (!T->error) return status;
  size_t at = (size_t)T->error->index;
  int b = 0;
  while (blocks->square[b + 1] <= at) b++;
  int column = (int)(at - blocks->square[b]) / nsdae_blocks_size(blocks, b);
  nsdae_system_name_item(T->system, NSDAE_NAME_VELOCITY, blocks->first[b] + column, T->error);
  T->error->index = (int)at;
  return status;
}

int nsdae_terms_mass_blocks(nsdae_terms *T)
{
  const nsdae_system *s = T->system;
  size_t squares = s->blocks.square[s->blocks.count];
  memset(T->M, 0, squares * sizeof *T->M);
  T->evals->mass++;
  int status =
      nsdae_system_callback_status(s->call.mass_blocks(nsdae_terms_time(T), T->q, T->M, s->user),
                                   "mass_blocks", nsdae_terms_time(T), T->error);
  if (status < 0) return status;
  status =
      nsdae_system_finite(s, T->M, (int)squares, 1, "mass_blocks", nsdae_terms_time(T), T->error);
  return status < 0 ? name_column(T, status) : NSDAE_OK;
}

int nsdae_terms_rows(nsdae_terms *T, nsdae_row_list *list)
{
  const nsdae_system *s = T->system;
  int constraints = list->kind == NSDAE_NAME_CONSTRAINT;
  double t = nsdae_terms_time(T);
  list->error = T->error;
  nsdae_row_list_clear(list);
  T->evals->jacobian += constraints;
  int code = constraints
                 ? s->call.constraint_rows(t, T->q, list, s->user)
                 : s->call.joint_friction_rows(t, T->q, list, T->frictional_joint.w, s->user);
  nsdae_row_list_close(list);
  return listed(T, code, list->status, constraints ? "constraint_rows" : "joint_friction_rows",
                &list->room, &list->taken);
}

int nsdae_terms_contacts(nsdae_terms *T, double reach)
{
  const nsdae_system *s = T->system;
  nsdae_contact_list *list = &T->by.list;
  if ((T->have & NSDAE_TERM_CONTACTS) && T->by.reach >= reach) return NSDAE_OK;
  T->have &= ~(unsigned)NSDAE_TERM_CONTACTS;
  if (s->tracked) nsdae_terms_forget_slots(T);
  list->error = T->error;
  list->without_omega = !s->tracked;
  nsdae_contact_list_clear(list);
  int code = s->call.contacts
                 ? s->call.contacts(nsdae_terms_time(T), T->q, T->v, reach, list, s->user)
                 : 0;
  int status = listed(T, code, list->status, "contacts", &list->room, &list->taken);
  if (status < 0) return status;
  T->by.reach = reach;
  T->have |= NSDAE_TERM_CONTACTS;
  return NSDAE_OK;
}

nsdae_room nsdae_terms_room(const nsdae_system *s, const nsdae_room *list)
{
  size_t k = (size_t)s->dims.k;
  return s->by_list ? *list : (nsdae_room){k, k * (size_t)(1 + s->dims.nt) * (size_t)s->dims.nv};
}

int nsdae_terms_find(nsdae_terms *T, double reach, const nsdae_contact_list **list)
{
  *list = T->system->by_list ? &T->by.list : NULL;
  return *list ? nsdae_terms_contacts(T, reach) : NSDAE_OK;
}

/* The parts of entry i are those of one more row, of its direction d; of i = -1: none. In the order
 * of the blocks, as in rows of fixed contacts, so that both have the same sums. */
static void add_row(nsdae_rows *rows, const nsdae_contact_list *list, int i, size_t d)
{
  int part = rows->first[rows->count];
  const int *block = list->block + 2 * (size_t)(i < 0 ? 0 : i);
  for (size_t n = 0, other = i >= 0 && block[0] > block[1]; i >= 0 && n < 2; n++) {
    size_t s = 2 * (size_t)i + (n ^ other);
    int b = list->block[s];
    if (b < 0) continue;
    rows->block[part] = b;
    rows->at[part++] = list->at[s] + d * (size_t)nsdae_blocks_size(list->blocks, b);
  }
  rows->first[++rows->count] = part;
}

void nsdae_terms_select(nsdae_terms *T, int count, const int *item)
{
  nsdae_by_blocks *by = &T->by;
  const nsdae_contact_list *list = &by->list;
  size_t nt = (size_t)list->nt;
  by->normal.count = by->tangent.count = 0;
  by->normal.value = by->tangent.value = list->value;
  by->normal.first[0] = by->tangent.first[0] = 0;
  for (int a = 0; a < count; a++) {
    int i = item ? item[a] : a;
    static const double none[3];
    const double *w = i < 0 ? none : list->w + (size_t)i * (1 + nt);
    T->gap[a] = i < 0 ? NSDAE_FAR : list->gap[i];
    T->w_N[a] = w[0];
    memcpy(T->w_T + (size_t)a * nt, w + 1, nt * sizeof *w);
    add_row(&by->normal, list, i, 0);
    for (size_t d = 1; d <= nt; d++) add_row(&by->tangent, list, i, d);
  }
}

void nsdae_terms_select_all(nsdae_terms *T)
{
  if (T->system->by_list) nsdae_terms_select(T, T->by.list.count, NULL);
}

/* ---- contacts by slot */

enum {
  OF_LIST = NSDAE_TERM_GAP | NSDAE_TERM_NORMAL | NSDAE_TERM_TANGENT | NSDAE_TERM_BIAS,
  OF_SLOTS = OF_LIST | NSDAE_TERM_ACCELERATION
};

void nsdae_terms_forget_slots(nsdae_terms *T)
{
  T->have &= ~(unsigned)OF_SLOTS;
}

int nsdae_terms_slots(nsdae_terms *T)
{
  const nsdae_tracked *tracked = T->system->tracked;
  const nsdae_contact_list *list = &T->by.list;
  int k = T->system->dims.k, *place = T->by.place;
  int status = nsdae_terms_contacts(T, tracked->reach);
  if (status < 0) return status;
  for (int i = 0; i < k; i++) place[i] = -1;
  for (int i = 0, slot = -1; i < list->count; i++) {
    if (list->gap[i] > tracked->reach) continue; /* of a list that was asked for more */
    int found = nsdae_tracked_find(tracked, k, list->id[i], slot + 1);
    if (found >= 0 && place[found] >= 0) return nsdae_terms_id_twice(T, list->id[i]);
    if (found >= 0) status = nsdae_terms_same_blocks(T, i, found);
    if (status < 0) return status;
    if (found >= 0) place[slot = found] = i;
  }
  nsdae_terms_select(T, k, place);
  T->have |= OF_LIST;
  return NSDAE_OK;
}

int nsdae_terms_slot_accelerations(nsdae_terms *T)
{
  const nsdae_system *s = T->system;
  const nsdae_contact_list *list = &T->by.list;
  nsdae_differences *d = T->differences;
  int any = 0, nt = s->dims.nt, status = nsdae_terms_contacts(T, s->tracked->reach);
  if (status == NSDAE_OK) status = nsdae_terms_need(T, OF_LIST);
  for (int i = 0; i < s->dims.k && status == NSDAE_OK; i++)
    any |= T->by.place[i] >= 0 && !list->omega_given[T->by.place[i]];
  if (any) {
    int code = nsdae_differences_by_id(d, nsdae_terms_time(T), T->q, T->v, T->omega.N, T->omega.T);
    status = nsdae_differences_status(d, code, "contacts", nsdae_terms_time(T), T->error);
    if (status < 0 && status != NSDAE_ARRAYS_GROW) status = explain(T, d->failed, status);
  }
  for (int i = 0; i < s->dims.k && status == NSDAE_OK; i++) {
    int entry = T->by.place[i];
    if (entry >= 0 && any && !list->omega_given[entry]) continue;
    const double *given = list->omega + (size_t)(entry >= 0 ? entry : 0) * (size_t)(1 + nt);
    T->omega.N[i] = entry >= 0 ? given[0] : 0;
    for (int j = 0; j < nt; j++) T->omega.T[i * nt + j] = entry >= 0 ? given[1 + j] : 0;
  }
  return status;
}

int nsdae_terms_same_blocks(const nsdae_terms *T, int i, int slot)
{
  const int *now = T->by.list.block + 2 * (size_t)i, *was = T->system->tracked->block + 2 * slot;
  double t = nsdae_terms_time(T);
  if ((now[0] == was[0] && now[1] == was[1]) || (now[0] == was[1] && now[1] == was[0]))
    return NSDAE_OK;
  nsdae_error_set(T->error, NSDAE_E_CALLBACK, "nsdae_contact_add", "block",
                  "the contact of id %ld is between blocks %d and %d at t = %g, and was between "
                  "%d and %d: an id is of one pair of bodies, use another id for another pair",
                  T->by.list.id[i], now[0], now[1], t, was[0], was[1]);
  long id = T->by.list.id[i];
  return nsdae_error_at(T->error, NSDAE_E_CALLBACK, id >= 0 && id <= INT_MAX ? (int)id : -1, t);
}

int nsdae_terms_id_twice(const nsdae_terms *T, long id)
{
  double t = nsdae_terms_time(T);
  nsdae_error_set(T->error, NSDAE_E_ARGUMENT, "nsdae_contact_add", "id",
                  "two contacts of one list have the id %ld at t = %g", id, t);
  return nsdae_error_at(T->error, NSDAE_E_ARGUMENT, -1, t);
}

const char *nsdae_terms_called(const nsdae_terms *T, int kind, int i, char text[NSDAE_CALLED_SIZE])
{
  if (kind == NSDAE_NAME_CONTACT && T->system->by_list)
    return nsdae_system_called_id(T->system, T->by.list.id[i], text);
  return nsdae_system_called(T->system, kind, i, text);
}

enum { ARRAYS = 9 };

static void list_selected(nsdae_terms *T, nsdae_array each[ARRAYS])
{
  nsdae_by_blocks *by = &T->by;
  int nt = by->list.nt;
  const nsdae_array list[ARRAYS] = {NSDAE_ARRAY(T->gap, 1),
                                    NSDAE_ARRAY(T->w_N, 1),
                                    NSDAE_ARRAY(T->w_T, nt),
                                    NSDAE_ARRAY(by->normal.first, 1),
                                    NSDAE_ARRAY(by->normal.block, 2),
                                    NSDAE_ARRAY(by->normal.at, 2),
                                    NSDAE_ARRAY(by->tangent.first, 1 + nt),
                                    NSDAE_ARRAY(by->tangent.block, 2 * nt),
                                    NSDAE_ARRAY(by->tangent.at, 2 * nt)};
  memcpy(each, list, sizeof list);
}

int nsdae_terms_grow(nsdae_terms *T, const nsdae_room *contacts, const nsdae_room *rows)
{
  int status = T->by.rows.rows ? nsdae_row_list_grow(&T->by.rows, rows) : NSDAE_OK;
  if (status == NSDAE_OK && T->by.joint_rows.rows)
    status = nsdae_row_list_grow(&T->by.joint_rows, rows);
  if (status < 0 || !(T->system->by_list || T->system->tracked)) return status;
  /* the list last: all of it can be selected */
  nsdae_array each[ARRAYS];
  list_selected(T, each);
  if (!T->system->tracked) status = nsdae_arrays_grow(each, ARRAYS, contacts->entries + 1);
  if (status == NSDAE_OK) status = nsdae_differences_grow(T->differences, contacts, T->error);
  if (status == NSDAE_OK) status = nsdae_contact_list_grow(&T->by.list, contacts);
  T->by.normal.value = T->by.tangent.value = T->by.list.value; /* what moved has its place again */
  return status;
}

void nsdae_terms_release(nsdae_terms *T)
{
  nsdae_by_blocks *by = &T->by;
  nsdae_row_list_release(&by->rows);
  nsdae_row_list_release(&by->joint_rows);
  nsdae_contact_list_release(&by->list);
  if (T->differences) nsdae_contact_list_release(&T->differences->by_id.list);
  if (!T->system || !T->system->by_list) return;
  nsdae_array each[ARRAYS];
  list_selected(T, each);
  nsdae_arrays_release(each, ARRAYS);
}
