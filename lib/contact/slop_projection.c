#include "slop_projection.h"

#include <math.h>
#include <string.h>

#include "dynamic_array.h"

enum { SWEEPS = 40 }; /* forwards and backwards in turn */

/* Depth up to which a contact stays, relative to the slop. */
static const double deep = 1.1;

enum { ARRAYS = 5 };

#define EACH(s)                                                                                 \
  {                                                                                             \
    NSDAE_ARRAY((s)->missing, 1), NSDAE_ARRAY((s)->weight, 1), NSDAE_ARRAY((s)->multiplier, 1), \
        NSDAE_ARRAY((s)->gap, 1), NSDAE_ARRAY((s)->at, 1)                                       \
  }

void nsdae_slop_layout(nsdae_slop_projection *s, const nsdae_system *system, nsdae_arena *arena)
{
  s->free = NSDAE_ARENA_DOUBLES(arena, system->dims.nv);
  s->change = NSDAE_ARENA_DOUBLES(arena, system->dims.nv);
  s->factor.L = NSDAE_ARENA_DOUBLES(arena, nsdae_blocks_largest(&system->blocks));
}

int nsdae_slop_grow(nsdae_slop_projection *s, const nsdae_system *system,
                    const nsdae_room *contacts, const nsdae_room *rows)
{
  const nsdae_array each[ARRAYS] = EACH(s), values[] = {NSDAE_ARRAY(s->inverse, 1)};
  size_t m = (size_t)system->dims.m, of_rows = m * (size_t)system->dims.nv;
  nsdae_room all = nsdae_terms_room(system, contacts);
  if (system->call.constraint_rows) of_rows = rows->values;
  int status = nsdae_arrays_grow(each, ARRAYS, all.entries + m);
  return status < 0 ? status : nsdae_arrays_grow(values, 1, all.values + of_rows);
}

void nsdae_slop_release(nsdae_slop_projection *s)
{
  const nsdae_array each[ARRAYS] = EACH(s), values[] = {NSDAE_ARRAY(s->inverse, 1)};
  nsdae_arrays_release(each, ARRAYS);
  nsdae_arrays_release(values, 1);
}

/* ---- rows of an island */

/* x := M_b^-1 x; M was factored in the step. */
static void solve_block(nsdae_slop_projection *s, const nsdae_terms *T, int b, double *x)
{
  if (s->factored != b) nsdae_blocks_factor(&T->system->blocks, b, T->M, &s->factor);
  s->factored = b;
  nsdae_blocks_solve(&s->factor, x);
}

/* Appends a row, with M^-1 W from the value `at` on; returns where the next one begins. */
static size_t append(nsdae_slop_projection *s, const nsdae_terms *T, const nsdae_rows *rows, int i,
                     double missing, size_t at)
{
  const nsdae_blocks *blocks = &T->system->blocks;
  int row = s->count++;
  s->missing[row] = missing;
  s->weight[row] = s->multiplier[row] = 0;
  s->at[row] = at;
  for (int p = rows->first[i]; p < rows->first[i + 1]; p++) {
    int b = rows->block[p], n = nsdae_blocks_size(blocks, b);
    const double *W = rows->value + rows->at[p];
    double *inverse = s->inverse + at;
    for (int j = 0; j < n; j++) inverse[j] = W[(size_t)j * rows->stride];
    solve_block(s, T, b, inverse);
    for (int j = 0; j < n; j++) s->weight[row] += W[(size_t)j * rows->stride] * inverse[j];
    at += (size_t)n;
  }
  return at;
}

/* sum_b |W_ib^T M_b^-1 F_b| */
static double drive(const nsdae_slop_projection *s, const nsdae_terms *T, int i)
{
  const nsdae_rows *rows = &T->by.normal;
  double sum = 0;
  for (int p = rows->first[i]; p < rows->first[i + 1]; p++) {
    const double *W = rows->value + rows->at[p];
    int b = rows->block[p];
    double along = 0;
    for (int j = T->system->blocks.first[b]; j < T->system->blocks.first[b + 1]; j++)
      along += s->free[j] * *W, W += rows->stride;
    sum += fabs(along);
  }
  return sum;
}

/* The slop, and the rows if a contact is deeper. */
static int begin_island(nsdae_slop_projection *s, const nsdae_contact_islands *is, int island,
                        const nsdae_terms *T, double h)
{
  const nsdae_blocks *blocks = &T->system->blocks;
  const int *first = is->contact.first + island, *row = is->row.first + island;
  double touch = nsdae_terms_touch(T), lowest = 0, driven = 0;
  for (int a = first[0]; a < first[1]; a++) lowest = fmin(lowest, s->gap[is->contact.of[a]]);
  if (!(lowest < -deep * touch)) return 0;
  /* ---- slop */
  for (int i = is->block.first[island]; i < is->block.first[island + 1]; i++) {
    int b = is->blocks == 1 ? 0 : is->block.of[i], at = blocks->first[b];
    size_t bytes = (size_t)nsdae_blocks_size(blocks, b) * sizeof *s->free;
    memcpy(s->free + at, T->F + at, bytes);
    solve_block(s, T, b, s->free + at);
  }
  for (int a = first[0]; a < first[1]; a++) driven = fmax(driven, drive(s, T, is->contact.of[a]));
  s->slop = fmax(touch, h * h * driven);
  if (!(lowest < -deep * s->slop)) return 0;
  /* ---- rows */
  size_t at = 0;
  s->count = 0;
  for (int a = first[0]; a < first[1]; a++) {
    int i = is->contact.of[a];
    at = append(s, T, &T->by.normal, i, s->gap[i] + s->slop, at);
  }
  s->contacts = s->count;
  for (int i = row[0]; i < row[1]; i++) at = append(s, T, &T->by.jacobian, is->row.of[i], 0, at);
  return 1;
}

/* ---- projected Gauss-Seidel */

/* d += (M^-1 W) by, of row i of its rows. */
static void add(const nsdae_slop_projection *s, const nsdae_blocks *blocks, const nsdae_rows *rows,
                int i, int row, double by, double *change)
{
  const double *inverse = s->inverse + s->at[row];
  for (int p = rows->first[i]; p < rows->first[i + 1]; p++) {
    int b = rows->block[p];
    for (int j = blocks->first[b]; j < blocks->first[b + 1]; j++) change[j] += *inverse++ * by;
  }
}

/* One row; returns how far its contact is beyond the slop. */
static double relax(nsdae_slop_projection *s, const nsdae_contact_islands *is, int island,
                    const nsdae_terms *T, int row)
{
  int contact = row < s->contacts;
  const nsdae_rows *rows = contact ? &T->by.normal : &T->by.jacobian;
  int i = contact ? is->contact.of[is->contact.first[island] + row]
                  : is->row.of[is->row.first[island] + row - s->contacts];
  const nsdae_blocks *blocks = &T->system->blocks;
  double residual = nsdae_rows_add_dot(blocks, rows, i, s->change, s->missing[row]);
  double was = s->multiplier[row];
  if (!(s->weight[row] > 0)) return 0;
  double next = was - residual / s->weight[row];
  if (contact && !(next > 0)) next = 0;
  s->multiplier[row] = next;
  if (next != was) add(s, blocks, rows, i, row, next - was, s->change);
  return contact ? -residual : 0;
}

static void solve_island(nsdae_slop_projection *s, const nsdae_contact_islands *is, int island,
                         const nsdae_terms *T)
{
  double beyond = INFINITY;
  for (int sweep = 0; sweep < SWEEPS && beyond > (deep - 1) * s->slop; sweep++) {
    beyond = 0;
    for (int n = 0; n < s->count; n++)
      beyond = fmax(beyond, relax(s, is, island, T, sweep % 2 ? s->count - 1 - n : n));
  }
  for (int a = is->contact.first[island]; a < is->contact.first[island + 1]; a++) {
    int i = is->contact.of[a];
    s->gap[i] = nsdae_rows_add_dot(&T->system->blocks, &T->by.normal, i, s->change, s->gap[i]);
  }
}

int nsdae_slop_find(nsdae_slop_projection *s, const nsdae_problem *p, const nsdae_terms *T,
                    const double *v, double rest, double h)
{
  const nsdae_contact_islands *is = &p->dispatch.islands;
  int moved = 0;
  s->factored = -1;
  memset(s->change, 0, (size_t)p->system->dims.nv * sizeof *s->change);
  for (int a = 0; a < p->count; a++) {
    int i = p->number[a];
    s->gap[i] = T->gap[i] + rest * nsdae_terms_normal_rate(T, i, v);
  }
  for (int island = 0; island < is->count; island++) {
    if (!begin_island(s, is, island, T, h)) continue;
    moved++;
    solve_island(s, is, island, T);
  }
  if (p->closed->count > 0)
    memcpy(p->closed->gap, s->gap, (size_t)p->closed->count * sizeof *s->gap);
  return moved;
}
