#include "global_problem.h"

#include <float.h>
#include <limits.h>
#include <math.h>
#include <stdint.h>
#include <stdio.h>
#include <string.h>

#include "dense.h"
#include "disjoint_sets.h"
#include "vector.h"

/* The problem as the caller gives it: ranges first, so that nothing after it can overflow. */

int nsdae_fc_refuse(nsdae_error *error, int status, const char *argument, int index,
                    const char *text)
{
  if (!error) return status;
  *error = (nsdae_error){.status = status, .index = index, .time = NAN};
  snprintf(error->argument, sizeof error->argument, "%s", argument);
  snprintf(error->where, sizeof error->where, "nsdae_friction_check");
  snprintf(error->text, sizeof error->text, "%s", text);
  return status;
}

static int refuse_int(nsdae_error *error, const char *argument, int index, int value,
                      const char *bound)
{
  char text[200];
  if (index < 0)
    snprintf(text, sizeof text, "%s = %d: must be %s", argument, value, bound);
  else
    snprintf(text, sizeof text, "%s[%d] = %d: must be %s", argument, index, value, bound);
  return nsdae_fc_refuse(error, NSDAE_E_ARGUMENT, argument, index, text);
}

static int missing(nsdae_error *error, const char *argument)
{
  char text[200];
  snprintf(text, sizeof text, "%s is NULL and must not be here", argument);
  return nsdae_fc_refuse(error, NSDAE_E_ARGUMENT, argument, -1, text);
}

/* ---- sizes and pattern */

/* NSDAE_OK if entries first to n - 1 are finite and not below least. */
static int check_values(nsdae_error *error, const char *argument, size_t first, size_t n,
                        const double *a, double least)
{
  char text[200];
  if (n == first || (least < 0 && nsdae_all_finite(n - first, a + first))) return NSDAE_OK;
  for (size_t i = first; i < n; i++) {
    if (fabs(a[i]) <= DBL_MAX && a[i] >= least) continue;
    int status = fabs(a[i]) <= DBL_MAX ? NSDAE_E_ARGUMENT : NSDAE_E_NONFINITE;
    snprintf(text, sizeof text, "%s[%zu] = %g: must be %s", argument, i, a[i],
             status == NSDAE_E_ARGUMENT ? ">= 0" : "finite");
    return nsdae_fc_refuse(error, status, argument, i <= INT_MAX ? (int)i : -1, text);
  }
  return NSDAE_OK;
}

/* Counts, and arrays, that fit what indexes them: 3 contacts + bilateral + 3 and all sums in int.
 */
static int check_counts(const nsdae_friction_problem *p, nsdae_error *error)
{
  if (p->form != NSDAE_FRICTION_GLOBAL && p->form != NSDAE_FRICTION_LOCAL)
    return refuse_int(error, "form", -1, p->form, "NSDAE_FRICTION_GLOBAL or NSDAE_FRICTION_LOCAL");
  if (p->contacts < 0 || p->contacts > INT_MAX / 8)
    return refuse_int(error, "contacts", -1, p->contacts, "in [0, 268435455]");
  if (p->bilateral < 0 || p->bilateral > INT_MAX / 8)
    return refuse_int(error, "bilateral", -1, p->bilateral, "in [0, 268435455]");
  if (p->blocks < 0 || (p->form == NSDAE_FRICTION_LOCAL && p->blocks > 0))
    return refuse_int(error, "blocks", -1, p->blocks, p->blocks < 0 ? ">= 0" : "0 in local form");
  int items = p->contacts + p->bilateral;
  if (p->contacts > 0 && !p->mu) return missing(error, "mu");
  if (items > 0 && !p->w) return missing(error, "w");
  if (items > 0 && !p->first) return missing(error, "first");
  if (p->blocks > 0 && !p->size) return missing(error, "size");
  if (p->blocks > 0 && !p->M) return missing(error, "M");
  if (p->blocks > 0 && !p->f) return missing(error, "f");
  if (items > 0 && p->first[items] > 0 && !p->block) return missing(error, "block");
  if (items > 0 && p->first[items] > 0 && !p->value) return missing(error, "value");
  int most = p->form == NSDAE_FRICTION_GLOBAL ? p->blocks : items;
  if (items > 0 && p->first[0] != 0) return refuse_int(error, "first", 0, p->first[0], "0");
  for (int i = 0; i < items; i++)
    if (p->first[i + 1] < p->first[i] || p->first[i + 1] - p->first[i] > most)
      return refuse_int(error, "first", i + 1, p->first[i + 1],
                        "not below the one before, and above it by no more than there are blocks");
  return NSDAE_OK;
}

/* Sizes of the blocks; those of M must add up to less than a size_t and those of v to an int. Each
 * item touches blocks that exist, each once: lists are short, no marks are kept. */
static int check_sizes(const nsdae_friction_problem *p, nsdae_error *error)
{
  int nv = 0;
  for (int i = 0; i < p->contacts && p->rows; i++)
    if (p->rows[i] < 1 || p->rows[i] > 3)
      return refuse_int(error, "rows", i, p->rows[i], "1, 2 or 3 (no rolling friction)");
  for (int b = 0; b < p->blocks; b++) {
    if (p->size[b] < 1) return refuse_int(error, "size", b, p->size[b], ">= 1");
    if (p->size[b] > INT_MAX / 2 - nv)
      return refuse_int(error, "size", b, p->size[b], "less: the sizes overflow");
    nv += p->size[b];
  }
  size_t of_mass = 0;
  for (int b = 0; b < p->blocks; b++) {
    size_t n = (size_t)p->size[b];
    if (n > SIZE_MAX / 32 / n || n * n > SIZE_MAX / 32 - of_mass)
      return refuse_int(error, "size", b, p->size[b], "less: M overflows");
    of_mass += n * n;
  }
  int items = p->contacts + p->bilateral;
  int most = p->form == NSDAE_FRICTION_GLOBAL ? p->blocks : items;
  for (int i = 0; i < items; i++)
    for (int e = p->first[i]; e < p->first[i + 1]; e++) {
      if (p->block[e] < 0 || p->block[e] >= most)
        return refuse_int(error, "block", e, p->block[e], "a block that exists");
      for (int k = p->first[i]; k < e; k++)
        if (p->block[k] == p->block[e])
          return refuse_int(error, "block", e, p->block[e], "named once in an item");
    }
  return NSDAE_OK;
}

/* ---- data */

/* Entries of the part of an item in a block. */
static size_t part(const nsdae_friction_problem *p, int item, int block)
{
  int other = p->form == NSDAE_FRICTION_GLOBAL ? p->size[block] : nsdae_fc_rows(p, block);
  return (size_t)other * (size_t)nsdae_fc_rows(p, item);
}

/* What the problem in view->p has. */
static void count(nsdae_fc_view *view)
{
  const nsdae_friction_problem *p = view->p;
  view->items = p->contacts + p->bilateral;
  view->entries = view->items > 0 ? p->first[view->items] : 0;
  view->m = view->nv = 0;
  view->mass = view->values = 0;
  for (int b = 0; b < p->blocks; b++) {
    view->nv += p->size[b];
    view->mass += (size_t)p->size[b] * (size_t)p->size[b];
  }
  for (int i = 0; i < view->items; i++) {
    view->m += nsdae_fc_rows(p, i);
    for (int e = p->first[i]; e < p->first[i + 1]; e++) view->values += part(p, i, p->block[e]);
  }
}

static int check_data(const nsdae_friction_problem *p, nsdae_error *error)
{
  nsdae_fc_view view = {.p = p};
  count(&view);
  size_t nv = (size_t)view.nv, m = (size_t)view.m;
  for (int i = 0; i < p->contacts; i++) {
    if (nsdae_fc_rows(p, i) == 1) continue;
    int status = check_values(error, "mu", (size_t)i, (size_t)i + 1, p->mu, 0);
    if (status != NSDAE_OK) return status;
  }
  int status = check_values(error, "w", 0, m, p->w, -INFINITY);
  if (status == NSDAE_OK && p->compliance)
    status = check_values(error, "compliance", 0, m, p->compliance, 0);
  if (status == NSDAE_OK) status = check_values(error, "f", 0, nv, p->f, -INFINITY);
  if (status == NSDAE_OK) status = check_values(error, "M", 0, view.mass, p->M, -INFINITY);
  if (status != NSDAE_OK || m == 0) return status;
  return check_values(error, "value", 0, view.values, p->value, -INFINITY);
}

int nsdae_fc_problem_check(const nsdae_friction_problem *p, nsdae_error *error)
{
  if (error) *error = (nsdae_error){.index = -1, .time = NAN};
  if (!p) return missing(error, "problem");
  int status = check_counts(p, error);
  if (status == NSDAE_OK) status = check_sizes(p, error);
  return status == NSDAE_OK ? check_data(p, error) : status;
}

/* ---- view by parts */

void nsdae_fc_view_layout(nsdae_fc_view *view, nsdae_arena *arena)
{
  const nsdae_friction_problem *p = view->p;
  count(view);
  view->row = NSDAE_ARENA_INTS(arena, view->items + 1);
  view->offset = NSDAE_ARENA_INTS(arena, p->blocks + 1);
  view->mass_at = nsdae_arena_take(arena, (long)p->blocks + 1, sizeof(size_t));
  view->at = nsdae_arena_take(arena, (long)view->entries + 1, sizeof(size_t));
}

void nsdae_fc_view_fill(nsdae_fc_view *view)
{
  const nsdae_friction_problem *p = view->p;
  view->row[0] = view->offset[0] = 0;
  view->mass_at[0] = view->at[0] = 0;
  for (int i = 0; i < view->items; i++) view->row[i + 1] = view->row[i] + nsdae_fc_rows(p, i);
  for (int b = 0; b < p->blocks; b++) {
    view->offset[b + 1] = view->offset[b] + p->size[b];
    view->mass_at[b + 1] = view->mass_at[b] + (size_t)p->size[b] * (size_t)p->size[b];
  }
  for (int i = 0; i < view->items; i++)
    for (int e = p->first[i]; e < p->first[i + 1]; e++)
      view->at[e + 1] = view->at[e] + part(p, i, p->block[e]);
}

void nsdae_fc_global_layout(void *object, nsdae_arena *arena)
{
  nsdae_fc_global *c = object;
  const nsdae_friction_problem *p = c->view.p;
  nsdae_fc_view_layout(&c->view, arena);
  long nv = c->view.nv, m = c->view.m;
  int global = p->form == NSDAE_FRICTION_GLOBAL;
  c->L = NSDAE_ARENA_DOUBLES(arena, c->view.mass);
  c->diagonal = NSDAE_ARENA_INTS(arena, p->blocks);
  c->J = NSDAE_ARENA_DOUBLES(arena, global ? c->view.values : 0);
  c->d = NSDAE_ARENA_DOUBLES(arena, c->view.items);
  nsdae_arena_doubles(arena, m, (double **[]){&c->q, &c->r, &c->r_low, &c->u, NULL});
  nsdae_arena_doubles(arena, nv, (double **[]){&c->v, &c->low, NULL});
  nsdae_fc_islands *all = &c->islands;
  nsdae_arena_ints(arena, c->view.items + 2L,
                   (int **[]){&all->label, &all->member, &all->start, &all->listed_start, NULL});
  all->number = NSDAE_ARENA_INTS(arena, global ? p->blocks : c->view.items);
  all->parent = NSDAE_ARENA_INTS(arena, c->view.items + (long)p->blocks);
  all->listed = NSDAE_ARENA_INTS(arena, p->blocks);
}

/* ---- factors of the masses */

/* The first entry above the diagonal, as an index of M, without
 *
 *   |M_ij - M_ji| <= 1e-10 sqrt(M_ii M_jj),
 *
 * or 0. */
static size_t find_asymmetry(int n, const double *M)
{
  size_t lda = (size_t)n;
  for (size_t j = 0; j < lda; j++)
    for (size_t i = 0; i < j; i++)
      if (M[j * lda + i] != M[i * lda + j] &&
          !(fabs(M[j * lda + i] - M[i * lda + j]) <=
            1e-10 * sqrt(fabs(M[j * lda + j])) * sqrt(fabs(M[i * lda + i]))))
        return j * lda + i;
  return 0;
}

/* L of a diagonal block is inverted. */
static int factor_masses(nsdae_fc_global *c, nsdae_error *error)
{
  const nsdae_friction_problem *p = c->view.p;
  char text[200];
  memcpy(c->L, p->M, c->view.mass_at[p->blocks] * sizeof *c->L);
  for (int b = 0; b < p->blocks; b++) {
    double *L = c->L + c->view.mass_at[b];
    int n = p->size[b], pivot = 0;
    size_t lda = (size_t)n, entry = find_asymmetry(n, L), i = entry % lda, j = entry / lda;
    if (entry == 0 && (pivot = nsdae_la_cholesky(n, L, n)) == 0) {
      c->diagonal[b] = nsdae_la_is_diagonal(n, L, n);
      for (int k = 0; k < n && c->diagonal[b]; k++, L += n + 1) *L = 1 / *L;
      continue;
    }
    const double *M = p->M + c->view.mass_at[b];
    if (entry > 0)
      snprintf(text, sizeof text,
               "block %d of M is not symmetric to 1e-10 of its diagonal: (%zu, %zu) is %g, "
               "(%zu, %zu) is %g",
               b, i, j, M[entry], j, i, M[i * lda + j]);
    else
      snprintf(text, sizeof text,
               "block %d of M is not positive definite: pivot %d, of the diagonal entry %g, is not "
               "above rounding",
               b, pivot - 1, M[(size_t)(pivot - 1) * (lda + 1)]);
    return nsdae_fc_refuse(error, NSDAE_E_MASS, "M", b, text);
  }
  return NSDAE_OK;
}

/* B := L^-1 B of block b; most masses are diagonal. */
static void solve_lower(const nsdae_fc_global *c, int b, int columns, double *B)
{
  const double *L = c->L + c->view.mass_at[b];
  int n = c->view.p->size[b];
  if (!c->diagonal[b])
    nsdae_la_solve_lower(n, columns, L, n, B, n);
  else
    for (int j = 0; j < columns; j++, B += n)
      for (int i = 0; i < n; i++) B[i] *= L[(size_t)i * (size_t)(n + 1)];
}

/* J and q of items from .. to - 1. */
static void free_items(void *object, int from, int to)
{
  const nsdae_fc_global *c = object;
  const nsdae_friction_problem *p = c->view.p;
  size_t at = c->view.at[p->first[from]], end = c->view.at[p->first[to]];
  memcpy(c->J + at, p->value + at, (end - at) * sizeof *c->J);
  for (int i = from; i < to; i++)
    for (int e = p->first[i]; e < p->first[i + 1]; e++) {
      int b = p->block[e], n = p->size[b], rows = nsdae_fc_rows(p, i);
      double *J = c->J + c->view.at[e];
      solve_lower(c, b, rows, J);
      nsdae_add_transposed(n, rows, 1, J, c->v + c->view.offset[b], c->q + c->view.row[i]);
    }
}

/* J = L^-1 H, L^-1 f in v, and q. */
static void free_velocity(nsdae_fc_global *c)
{
  const nsdae_friction_problem *p = c->view.p;
  memcpy(c->v, p->f, (size_t)c->view.nv * sizeof *c->v);
  for (int b = 0; b < p->blocks; b++) solve_lower(c, b, 1, c->v + c->view.offset[b]);
  nsdae_thread_pool_for(c->pool, c->view.items, NSDAE_FC_GRAIN, free_items, c);
}

/* ---- diagonal and symmetry */

/* Mean of the diagonal of W + C: of the global form the mean square length of the columns of J. */
static void diagonals(void *object, int from, int to)
{
  const nsdae_fc_global *c = object;
  const nsdae_friction_problem *p = c->view.p;
  for (int i = from; i < to; i++) {
    int rows = nsdae_fc_rows(p, i);
    double sum = 0;
    for (int k = 0; k < rows && p->compliance; k++) sum += p->compliance[c->view.row[i] + k];
    for (int e = p->first[i]; e < p->first[i + 1]; e++) {
      const double *J = c->J + c->view.at[e], *W = p->value + c->view.at[e];
      int n = p->form == NSDAE_FRICTION_GLOBAL ? p->size[p->block[e]] : 0;
      if (p->form == NSDAE_FRICTION_GLOBAL)
        for (int k = 0; k < rows; k++, J += n) sum += nsdae_dot(n, J, J);
      else if (p->block[e] == i)
        for (int k = 0; k < rows; k++) sum += W[k * rows + k];
    }
    c->d[i] = sum / rows;
  }
}

/* Item i of a mean diagonal below 0: C >= 0, so an entry of W is. */
static int refuse_negative(const nsdae_fc_global *c, int i, nsdae_error *error)
{
  const nsdae_friction_problem *p = c->view.p;
  char text[80];
  int e = p->first[i], k = 0, n = nsdae_fc_rows(p, i);
  while (p->block[e] != i) e++;
  const double *W = p->value + c->view.at[e];
  while (!(W[k * (n + 1)] < 0)) k++;
  snprintf(text, sizeof text, "W(%d, %d) = %g: must be >= 0", c->view.row[i] + k,
           c->view.row[i] + k, W[k * (n + 1)]);
  return nsdae_fc_refuse(error, NSDAE_E_ARGUMENT, "value", e, text);
}

/* |W_jk - W_kj| <= 1e-10 sqrt(d_j d_k), as rounding leaves it; a zero d needs zeros, or W would not
 * be positive semidefinite: there the entries themselves are compared. */
static int check_symmetry(const nsdae_fc_global *c, nsdae_error *error)
{
  const nsdae_friction_problem *p = c->view.p;
  char text[200];
  for (int i = 0; i < c->view.items; i++)
    for (int e = p->first[i]; e < p->first[i + 1]; e++) {
      if (c->d[i] < 0) return refuse_negative(c, i, error);
      int j = p->block[e], ni = nsdae_fc_rows(p, i), nj = nsdae_fc_rows(p, j);
      const double *W = p->value + c->view.at[e], *T = NULL;
      for (int f = p->first[j]; f < p->first[j + 1] && !T; f++)
        if (p->block[f] == i) T = p->value + c->view.at[f];
      double off = 0, bound = 1e-10 * sqrt(fmax(c->d[i], 0)) * sqrt(fmax(c->d[j], 0));
      int fixed = !(c->d[i] > 0 && c->d[j] > 0);
      for (int k = 0; k < ni * nj; k++)
        off = fmax(off, fabs(W[k] - (T && !fixed ? T[k % nj * ni + k / nj] : 0)));
      if (off <= bound) continue;
      snprintf(text, sizeof text, "W of items %d and %d: off %s by %g, bound %g", i, j,
               fixed ? "zero, as the diagonal is zero," : "symmetry", off, bound);
      return nsdae_fc_refuse(error, NSDAE_E_ARGUMENT, "value", e, text);
    }
  return NSDAE_OK;
}

/* ---- islands */

int nsdae_fc_touches(const nsdae_fc_global *c, int e)
{
  const double *value = c->view.p->value + c->view.at[e];
  size_t n = c->view.at[e + 1] - c->view.at[e];
  for (size_t k = 0; k < n; k++)
    if (value[k] != 0) return 1;
  return 0;
}

/* Disjoint sets of items and, after them, of blocks (local form: of items) that they touch; their
 * labels, in the order of the least items that something moves. The root of a set is its least
 * item; start has the label of that, then where the items of each island begin (counting sort). */
static void find_islands(nsdae_fc_global *c)
{
  const nsdae_friction_problem *p = c->view.p;
  nsdae_fc_islands *all = &c->islands;
  int *start = all->start, *label = all->label;
  int items = c->view.items, after = p->form == NSDAE_FRICTION_LOCAL ? 0 : items;
  nsdae_sets_begin(all->parent, items + p->blocks);
  for (int i = 0; i < items; i++)
    for (int e = p->first[i]; e < p->first[i + 1]; e++)
      if (nsdae_fc_touches(c, e)) nsdae_sets_join(all->parent, i, after + p->block[e]);
  all->count = 0;
  for (int i = 0; i < items; i++) start[i] = label[i] = -1;
  for (int i = 0; i < items; i++) {
    int root = nsdae_sets_root(all->parent, i);
    if (!(c->d[i] > 0)) continue;
    if (start[root] < 0) start[root] = all->count++;
    label[i] = start[root];
  }
  memset(start, 0, ((size_t)all->count + 2) * sizeof *start);
  for (int i = 0; i < items; i++)
    if (label[i] >= 0) start[label[i] + 2]++;
  for (int k = 0; k < all->count; k++) start[k + 2] += start[k + 1];
  for (int i = 0; i < items; i++)
    if (label[i] >= 0) all->member[start[label[i] + 1]++] = i;
}

/* Blocks in the order in which the items of their island come to them; items as they stand. */
static void number_blocks(nsdae_fc_global *c)
{
  const nsdae_friction_problem *p = c->view.p;
  nsdae_fc_islands *all = &c->islands;
  int local = p->form == NSDAE_FRICTION_LOCAL, sets = local ? c->view.items : p->blocks;
  for (int b = 0; b < sets; b++) all->number[b] = -1;
  all->listed_start[0] = 0;
  for (int island = 0; island < all->count; island++) {
    int count = 0, from = all->listed_start[island];
    for (int k = all->start[island]; k < all->start[island + 1]; k++) {
      int i = all->member[k];
      if (local) all->number[i] = k - all->start[island];
      for (int e = p->first[i]; e < p->first[i + 1] && !local; e++) {
        int b = p->block[e];
        if (!nsdae_fc_touches(c, e) || all->number[b] >= 0) continue;
        all->listed[from + count] = b;
        all->number[b] = count++;
      }
    }
    all->listed_start[island + 1] = from + count;
  }
}

/* ---- what a problem needs */

/* A largest q of at most this many roundings of its terms, J y of the free velocity, is none:
 * bodies that fall freely in contact. */
static const double ROUNDINGS = 64;

static int measure(nsdae_fc_global *c, nsdae_error *error)
{
  double s = 0, terms = 0;
  c->most_d = 0;
  for (int k = 0; k < c->view.m; k++) {
    if (!(fabs(c->q[k]) <= DBL_MAX))
      return nsdae_fc_refuse(error, NSDAE_E_NONFINITE, "q", k, "q = H^T M^-1 f + w overflows");
    s = fmax(s, fabs(c->q[k]));
  }
  for (int i = 0; i < c->view.items; i++) {
    if (!(fabs(c->d[i]) <= DBL_MAX))
      return nsdae_fc_refuse(error, NSDAE_E_NONFINITE, "value", i, "the diagonal of W overflows");
    c->most_d = fmax(c->most_d, c->d[i]);
  }
  if (c->view.p->form == NSDAE_FRICTION_GLOBAL && c->view.items > 0)
    terms =
        nsdae_largest(c->view.m, c->view.p->w) + sqrt(c->most_d) * nsdae_largest(c->view.nv, c->v);
  c->scale = s > ROUNDINGS * DBL_EPSILON * terms ? s : 1;
  return NSDAE_OK;
}

/* Nothing moves an item, exactly, if its parts of H (W) and C are zeros, so that u = q whatever r
 * is. */
int nsdae_fc_global_blocked(const nsdae_fc_global *c)
{
  const nsdae_friction_problem *p = c->view.p;
  for (int i = 0; i < c->view.items; i++) {
    double q = c->q[c->view.row[i]];
    int blocked = i < p->contacts ? q < 0 : q != 0;
    for (int e = p->first[i]; e < p->first[i + 1] && blocked; e++)
      blocked = !nsdae_fc_touches(c, e);
    for (int k = c->view.row[i]; k < c->view.row[i + 1] && p->compliance && blocked; k++)
      blocked = !(p->compliance[k] > 0);
    if (blocked) return i;
  }
  return -1;
}

int nsdae_fc_global_fill(nsdae_fc_global *c, nsdae_error *error)
{
  const nsdae_friction_problem *p = c->view.p;
  int status = NSDAE_OK, local = p->form == NSDAE_FRICTION_LOCAL;
  nsdae_fc_view_fill(&c->view);
  if (c->view.m > 0) memcpy(c->q, p->w, (size_t)c->view.m * sizeof *c->q);
  if (p->blocks > 0) status = factor_masses(c, error);
  if (status == NSDAE_OK && p->blocks > 0 && c->view.items > 0) free_velocity(c);
  if (status != NSDAE_OK) return status;
  nsdae_thread_pool_for(c->pool, c->view.items, NSDAE_FC_GRAIN, diagonals, c);
  status = measure(c, error);
  if (status == NSDAE_OK && local) status = check_symmetry(c, error);
  if (status != NSDAE_OK) return status;
  find_islands(c);
  number_blocks(c);
  return NSDAE_OK;
}

void nsdae_fc_divide_by_mass(const nsdae_fc_global *c, int b, double *v)
{
  int n = c->view.p->size[b];
  solve_lower(c, b, 1, v);
  if (c->diagonal[b])
    solve_lower(c, b, 1, v);
  else
    nsdae_la_solve_lower_transposed(n, 1, c->L + c->view.mass_at[b], n, v, n);
}
