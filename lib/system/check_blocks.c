/* Entries of M against the transposed ones, of Phi_q against differences of Phi along each
 * velocity, and the rate of each gap in a list, W_N v + w, against differences of the gap of the
 * same id along two trial velocities: what is listed at the point, within a tenth of 1 + max |q|.
 */
#include "check_blocks.h"

#include <float.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "errors.h"
#include "lists.h"

typedef struct context {
  nsdae_system *s;
  nsdae_differences *d;
  double t;
  const double *q, *v;
  nsdae_check *worst;
  nsdae_row_list rows; /* into */
  nsdae_rows jacobian;
  nsdae_contact_list list, ahead, back;
  double *M, *column, *rate, *trial, *moved;
} context;

void nsdae_check_keep(nsdae_check *worst, const char *term, int row, int column, double given,
                      double difference)
{
  double error = fabs(given - difference) / (1 + fabs(difference));
  if (error <= worst->error) return; /* so that NaN is kept as the worst */
  *worst = (nsdae_check){.row = row,
                         .column = column,
                         .given = given,
                         .difference = difference,
                         .error = isnan(error) ? INFINITY : error};
  snprintf(worst->term, sizeof worst->term, "%s", term);
}

static int blocks_failed(context *c, int code, const char *callback)
{
  return nsdae_system_callback_status(code, callback, c->t, &c->s->error);
}

/* The rows, with as much room as they take. */
static int list_rows(context *c)
{
  for (int round = 0; round < 2; round++) {
    nsdae_row_list_clear(&c->rows);
    int code = c->s->call.constraint_rows(c->t, c->q, &c->rows, c->s->user);
    nsdae_row_list_close(&c->rows);
    if (c->rows.status < 0) return c->rows.status;
    int status = blocks_failed(c, code, "constraint_rows");
    if (status < 0 || nsdae_room_enough(&c->rows.room, &c->rows.taken)) return status;
    status = nsdae_row_list_grow(&c->rows, &c->rows.taken);
    if (status < 0) return status;
  }
  return nsdae_error_set(&c->s->error, NSDAE_E_CALLBACK, "nsdae_system_check", "constraint_rows",
                         "constraint_rows gave more rows when it was called again");
}

/* Column j of Phi_q, dense. */
static void gather_column(context *c, int j)
{
  const nsdae_rows *rows = &c->jacobian;
  const int *first = c->s->blocks.first;
  for (int i = 0; i < rows->count; i++) {
    c->column[i] = 0;
    for (int p = rows->first[i]; p < rows->first[i + 1]; p++) {
      int b = rows->block[p];
      if (first[b] <= j && j < first[b + 1])
        c->column[i] = rows->value[rows->at[p] + (size_t)(j - first[b])];
    }
  }
}

static int check_rows(context *c)
{
  int status = list_rows(c);
  for (int j = 0; j < c->s->dims.nv && status == NSDAE_OK; j++) {
    memset(c->trial, 0, (size_t)c->s->dims.nv * sizeof *c->trial);
    c->trial[j] = 1;
    int code = nsdae_differences_along(c->d, c->s->call.constraint, c->s->dims.m, c->t, c->q,
                                       c->trial, c->rate);
    status = blocks_failed(c, code, code && c->d->failed ? c->d->failed : "constraint");
    gather_column(c, j);
    for (int i = 0; i < c->s->dims.m && status == NSDAE_OK; i++)
      nsdae_check_keep(c->worst, "constraint_rows", i, j, c->column[i], c->rate[i]);
  }
  return status;
}

/* A list, with as much room as it takes. */
static int list_contacts(context *c, nsdae_contact_list *list, double t, const double *q,
                         double reach)
{
  for (int round = 0; round < 2; round++) {
    nsdae_contact_list_clear(list);
    int code = c->s->call.contacts(t, q, c->v, reach, list, c->s->user);
    if (list->status < 0) return list->status;
    int status = blocks_failed(c, code, "contacts");
    if (status < 0 || nsdae_room_enough(&list->room, &list->taken)) return status;
    status = nsdae_contact_list_grow(list, &list->taken);
    if (status < 0) return status;
  }
  return nsdae_error_set(&c->s->error, NSDAE_E_CALLBACK, "nsdae_system_check", "contacts",
                         "contacts gave a longer list when it was called again");
}

static int find_contact(const nsdae_contact_list *list, long id, int likely)
{
  if (likely < list->count && list->id[likely] == id) return likely;
  for (int i = 0; i < list->count; i++)
    if (list->id[i] == id) return i;
  return -1;
}

/* W_N . v + w of entry i. */
static double given_rate(const context *c, int i)
{
  const nsdae_contact_list *l = &c->list;
  double rate = l->w[(size_t)i * (size_t)(1 + l->nt)];
  for (size_t s = 2 * (size_t)i; s < 2 * (size_t)i + 2; s++) {
    int b = l->block[s];
    for (int j = 0; b >= 0 && j < nsdae_blocks_size(l->blocks, b); j++)
      rate += l->value[l->at[s] + (size_t)j] * c->trial[l->blocks->first[b] + j];
  }
  return rate;
}

static int move(context *c, double s)
{
  for (int i = 0; i < c->s->dims.nq; i++) c->moved[i] = c->q[i] + s * c->d->qdot[i];
  return NSDAE_OK;
}

/* The rates along one trial velocity; a contact that is not in all three lists says nothing. */
static int check_rates(context *c, double reach)
{
  int nq = c->s->dims.nq;
  int status =
      blocks_failed(c, nsdae_kinematics(c->s, c->t, c->q, c->trial, c->d->qdot), "kinematics");
  if (status < 0) return status;
  double s = nsdae_differences_step(nq, c->t, c->q, c->d->qdot, cbrt(DBL_EPSILON));
  move(c, s);
  status = list_contacts(c, &c->ahead, c->t + s, c->moved, reach);
  move(c, -s);
  if (status == NSDAE_OK) status = list_contacts(c, &c->back, c->t - s, c->moved, reach);
  for (int i = 0; i < c->list.count && status == NSDAE_OK; i++) {
    int a = find_contact(&c->ahead, c->list.id[i], i), b = find_contact(&c->back, c->list.id[i], i);
    if (a < 0 || b < 0) continue;
    nsdae_check_keep(c->worst, "contacts", i, 0, given_rate(c, i),
                     (c->ahead.gap[a] - c->back.gap[b]) / (2 * s));
  }
  return status;
}

static int check_contacts(context *c)
{
  double largest = 0;
  for (int i = 0; i < c->s->dims.nq; i++) largest = fmax(largest, fabs(c->q[i]));
  double reach = 0.1 * (1 + largest);
  int status = list_contacts(c, &c->list, c->t, c->q, reach);
  for (int number = 0; number < 2 && status == NSDAE_OK; number++) {
    for (int j = 0; j < c->s->dims.nv; j++) c->trial[j] = cos(1 + number + 2.399963 * (j + 1));
    status = check_rates(c, reach);
  }
  return status;
}

static void layout_blocks_check(void *object, nsdae_arena *arena)
{
  context *c = object;
  const nsdae_dims *d = &c->s->dims;
  c->M = NSDAE_ARENA_DOUBLES(arena, c->s->blocks.square[c->s->blocks.count]);
  c->column = NSDAE_ARENA_DOUBLES(arena, d->m);
  c->rate = NSDAE_ARENA_DOUBLES(arena, d->m);
  c->trial = NSDAE_ARENA_DOUBLES(arena, d->nv);
  c->moved = NSDAE_ARENA_DOUBLES(arena, d->nq);
  c->jacobian.first = NSDAE_ARENA_INTS(arena, d->m + 1L);
}

int nsdae_system_check_lists(nsdae_system *system, nsdae_differences *differences, double t,
                             const double *q, const double *v, nsdae_check *worst)
{
  context c = {.s = system, .d = differences, .t = t, .q = q, .v = v, .worst = worst};
  nsdae_arena arena;
  if (nsdae_arena_build(&arena, layout_blocks_check, &c) < 0)
    return nsdae_error_memory(&system->error, "nsdae_system_check");
  /* The lists that the callbacks fill. */
  nsdae_contact_list *const lists[] = {&c.list, &c.ahead, &c.back};
  for (int i = 0; i < 3; i++) {
    lists[i]->blocks = &c.s->blocks;
    lists[i]->nt = c.s->dims.nt;
    lists[i]->error = &c.s->error;
  }
  c.rows.system = c.s;
  c.rows.blocks = &c.s->blocks;
  c.rows.error = &c.s->error;
  c.rows.rows = &c.jacobian;
  c.jacobian.count = c.s->dims.m;
  c.jacobian.stride = 1;
  /* The mass against its transpose. */
  const nsdae_blocks *blocks = &c.s->blocks;
  int status = blocks_failed(&c, c.s->call.mass_blocks(c.t, c.q, c.M, c.s->user), "mass_blocks");
  for (int b = 0; b < blocks->count && status == NSDAE_OK; b++) {
    int n = nsdae_blocks_size(blocks, b), at = blocks->first[b];
    const double *M = c.M + blocks->square[b];
    for (int j = 0; j < n; j++)
      for (int i = 0; i < n; i++)
        nsdae_check_keep(worst, "mass_blocks", at + i, at + j, M[j * n + i], M[i * n + j]);
  }
  if (status == NSDAE_OK && system->call.constraint_rows) status = check_rows(&c);
  if (status == NSDAE_OK && system->call.contacts) status = check_contacts(&c);
  if (status == NSDAE_E_MEMORY)
    nsdae_error_set(&system->error, status, "nsdae_system_check", "", "out of memory");
  nsdae_contact_list_release(&c.list);
  nsdae_contact_list_release(&c.ahead);
  nsdae_contact_list_release(&c.back);
  nsdae_row_list_release(&c.rows);
  nsdae_arena_release(&arena);
  return status;
}
