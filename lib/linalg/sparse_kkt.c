#include "sparse_kkt.h"

#include <float.h>
#include <math.h>
#include <nsdae/status.h>
#include <string.h>

#include "dense.h"
#include "vector.h"

/* The analysis of sparse_kkt.h: the graph of S, its order of elimination. */

/* Enters a number of the pattern; returns whether it was there. */
static int put(nsdae_kkt_pattern *p, int *at, int value)
{
  int same = *at < p->used && p->list[*at] == value;
  p->list[(*at)++] = value;
  return same;
}

static void lay_out_part(void *object, nsdae_arena *arena)
{
  nsdae_sparse_kkt *k = object;
  nsdae_kkt_nodes *n = &k->nodes;
  nsdae_kkt_values *a = &k->at;
  long blocks = k->part.block_count, rows = k->part.row_count, parts = n->parts;
  long squares = 0, order = 0;
  for (int b = 0; b < blocks; b++) {
    long size = k->pattern.list[2 + b];
    order += size;
    squares += size * size;
  }
  nsdae_arena_ints(arena, rows + 1, (int **[]){&n->row, &n->part, &n->size, &n->of_row, NULL});
  n->block = NSDAE_ARENA_INTS(arena, parts);
  n->at = nsdae_arena_take(arena, parts, sizeof *n->at);
  a->blocks.first = NSDAE_ARENA_INTS(arena, blocks + 1);
  a->blocks.square = nsdae_arena_take(arena, blocks + 1, sizeof *a->blocks.square);
  nsdae_arena_doubles(arena, squares, (double **[]){&a->M, &a->L, NULL});
  nsdae_arena_doubles(arena, (long)n->values, (double **[]){&a->J, &a->Y, NULL});
  nsdae_arena_doubles(arena, order, (double **[]){&a->x, &a->r, &a->g, &a->z, &a->size, NULL});
  nsdae_arena_doubles(arena, rows, (double **[]){&a->l, &a->c, &a->d, &a->h, &a->u, &a->p, NULL});
}

static void find_nodes(nsdae_sparse_kkt *k)
{
  nsdae_kkt_nodes *n = &k->nodes;
  const int *row = k->pattern.list + 2 + k->part.block_count, *last = NULL;
  n->count = n->part[0] = 0;
  for (int i = 0; i < k->part.row_count; i++, last = row, row += *row + 1) {
    n->of_row[i] = n->count - 1;
    if (last && *last == *row && memcmp(last, row, ((size_t)*row + 1) * sizeof *row) == 0) continue;
    n->of_row[i] = n->count;
    n->row[n->count] = i;
    memcpy(n->block + n->part[n->count], row + 1, (size_t)*row * sizeof *row);
    n->part[n->count + 1] = n->part[n->count] + *row;
    n->count++;
  }
  n->row[n->count] = k->part.row_count;
  size_t used = 0;
  for (int i = 0; i < n->count; i++) {
    n->size[i] = n->row[i + 1] - n->row[i];
    for (int p = n->part[i]; p < n->part[i + 1]; p++) {
      n->at[p] = used;
      used += (size_t)n->size[i] * (size_t)nsdae_blocks_size(&k->at.blocks, n->block[p]);
    }
  }
}

static int analyse(nsdae_sparse_kkt *k)
{
  nsdae_kkt_nodes *n = &k->nodes;
  nsdae_blocks *b = &k->at.blocks;
  /* ---- entries and values of J */
  const int *size = k->pattern.list + 2, *row = size + k->part.block_count;
  n->parts = 0;
  n->values = 0;
  for (int i = 0; i < k->part.row_count; i++, row += *row + 1) {
    n->parts += *row;
    for (int e = 1; e <= *row; e++) n->values += (size_t)size[row[e]];
  }
  if (nsdae_arena_fit(&k->pattern.memory, lay_out_part, k) != NSDAE_OK) return NSDAE_E_MEMORY;
  b->count = k->part.block_count;
  b->first[0] = 0;
  b->square[0] = 0;
  for (int i = 0; i < b->count; i++) {
    b->first[i + 1] = b->first[i] + size[i];
    b->square[i + 1] = b->square[i] + (size_t)size[i] * (size_t)size[i];
  }
  find_nodes(k);
  const nsdae_joined touched = {n->count, n->part, n->block};
  int status = nsdae_adjacency_build(&k->graph, &touched, k->part.block_count, 1);
  return status < 0 ? status
                    : nsdae_multifrontal_analyse(&k->schur, n->count, n->size, k->graph.first,
                                                 k->graph.index);
}

int nsdae_sparse_kkt_analyse(nsdae_sparse_kkt *k, const nsdae_kkt_part *part)
{
  nsdae_kkt_pattern *p = &k->pattern;
  int room = 2 + part->blocks->count + part->J->count + part->J->first[part->J->count];
  const nsdae_array lists[] = {NSDAE_ARRAY(p->list, 1), NSDAE_ARRAY(p->number, 1)};
  if (room > p->room && nsdae_arrays_grow(lists, 2, (size_t)room) < 0) return NSDAE_E_MEMORY;
  if (room > p->room) p->room = room;
  k->part = *part;
  /* ---- the pattern; same: it is that of the last call */
  int at = 0, same = put(p, &at, part->block_count);
  const nsdae_rows *J = part->J;
  same &= put(p, &at, part->row_count);
  for (int i = 0; i < part->block_count; i++) {
    p->number[part->block[i]] = i;
    same &= put(p, &at, nsdae_blocks_size(part->blocks, part->block[i]));
  }
  for (int i = 0; i < part->row_count; i++) {
    int row = part->row[i];
    same &= put(p, &at, J->first[row + 1] - J->first[row]);
    for (int e = J->first[row]; e < J->first[row + 1]; e++)
      same &= put(p, &at, p->number[J->block[e]]);
  }
  p->used = at;
  if (same && k->ready) return NSDAE_OK;
  k->whole.ready = 0;
  int status = analyse(k);
  k->ready = status == NSDAE_OK;
  return status;
}

void nsdae_sparse_kkt_release(nsdae_sparse_kkt *k)
{
  nsdae_kkt_pattern *p = &k->pattern;
  const nsdae_array all[] = {NSDAE_ARRAY(p->list, 1), NSDAE_ARRAY(p->number, 1)};
  nsdae_arrays_release(all, 2);
  nsdae_arena_release(&k->pattern.memory);
  nsdae_adjacency_release(&k->graph);
  nsdae_multifrontal_release(&k->schur);
  nsdae_multifrontal_release(&k->whole.fronts);
  nsdae_adjacency_release(&k->whole.graph);
  nsdae_arena_release(&k->whole.arena);
}

enum { REFINEMENTS = 10 };

/* Largest backward error of a solution. Refinement ends at a few DBL_EPSILON; sums of 1000 terms
 * remain below this. */
static const double ENOUGH = 1e-12;

int nsdae_sparse_kkt_factor(nsdae_sparse_kkt *k, const double *M)
{
  int status = nsdae_sparse_kkt_form_schur(k, M);
  return status < 0 ? status : nsdae_sparse_kkt_find_rank(k);
}

int nsdae_sparse_kkt_factor_in(nsdae_sparse_kkt *k, const double *M, const double *keep)
{
  int status = nsdae_sparse_kkt_form_schur(k, M);
  return status < 0 ? status : nsdae_sparse_kkt_keep_rank(k, keep);
}

void nsdae_sparse_kkt_kept(const nsdae_sparse_kkt *k, double *keep)
{
  for (int row = 0; row < k->part.row_count; row++)
    keep[row] = !nsdae_sparse_kkt_is_dropped(k, row);
}

int nsdae_sparse_kkt_common(const nsdae_sparse_kkt *k, const double *keep)
{
  int common = 0;
  for (int row = 0; row < k->part.row_count; row++)
    common += keep[row] != 0 && !nsdae_sparse_kkt_is_dropped(k, row);
  return common;
}

/* ---- the solution */

/* z := L^-1 z, or L^-T z */
static void solve_masses(const nsdae_sparse_kkt *k, int transposed, double *z)
{
  const nsdae_blocks *b = &k->at.blocks;
  for (int i = 0; i < b->count; i++) {
    int n = nsdae_blocks_size(b, i);
    const double *L = k->at.L + b->square[i];
    if (transposed)
      nsdae_la_solve_lower_transposed(n, 1, L, n, z + b->first[i], n);
    else
      nsdae_la_solve_lower(n, 1, L, n, z + b->first[i], n);
  }
}

void nsdae_sparse_kkt_solve_mass(const nsdae_sparse_kkt *k, double *v)
{
  for (int i = 0; i < k->at.blocks.count; i++)
    nsdae_la_solve_cholesky(nsdae_blocks_size(&k->at.blocks, i), k->at.L + k->at.blocks.square[i],
                            v + k->part.blocks->first[k->part.block[i]]);
}

/* worst / size; not finite if a number is not. */
static double part_of(double worst, double size)
{
  return worst == 0 ? 0 : worst / size;
}

static double max_with_nan(double most, double a)
{
  return a <= most || isnan(most) ? most : a; /* NaN stays */
}

/* g = r - M x - J^T l, divided by the largest |r| + |M x| + |J^T| |l| */
static double error_of_forces(const nsdae_sparse_kkt *k)
{
  const nsdae_kkt_values *a = &k->at;
  int n = a->blocks.first[a->blocks.count];
  double worst = 0, size = 0;
  memset(a->g, 0, (size_t)n * sizeof *a->g);
  nsdae_blocks_add_product(&a->blocks, a->M, a->x, a->g);
  if (k->coupled) nsdae_sparse_whole_add_product(k, a->x, a->g);
  for (int j = 0; j < n; j++) {
    a->size[j] = fabs(a->r[j]) + fabs(a->g[j]);
    a->g[j] = a->r[j] - a->g[j];
  }
  nsdae_sparse_kkt_add_transposed(k, a->J, -1, a->l, a->g, a->size);
  for (int j = 0; j < n; j++) {
    worst = max_with_nan(worst, fabs(a->g[j]));
    size = max_with_nan(size, a->size[j]);
  }
  return part_of(worst, size);
}

/* d = c - J x of the rows that count, divided by the largest |c| + |J| |x|; or, of terms, with
 * |x| + s / diag(M) for |x|: x is M^-1 (r - J^T l), with the sizes s of these terms of
 * error_of_forces. It may be zero. */
static double error_of_rows(const nsdae_sparse_kkt *k, int of_terms)
{
  const nsdae_kkt_values *a = &k->at;
  const nsdae_kkt_nodes *n = &k->nodes;
  double worst = 0, size = 0;
  nsdae_sparse_kkt_times(k, a->J, a->x, a->d);
  for (int i = 0; i < n->count; i++)
    for (int row = n->row[i]; row < n->row[i + 1]; row++) {
      double terms = fabs(a->c[row]);
      for (int p = n->part[i]; p < n->part[i + 1]; p++) {
        int m = nsdae_blocks_size(&a->blocks, n->block[p]);
        const double *value = a->J + n->at[p] + (size_t)((row - n->row[i]) * m);
        const double *x = a->x + a->blocks.first[n->block[p]];
        const double *s = a->size + a->blocks.first[n->block[p]];
        const double *M = a->M + a->blocks.square[n->block[p]];
        for (int j = 0; j < m; j++)
          terms += fabs(value[j]) * (fabs(x[j]) + (of_terms ? s[j] / M[j * (m + 1)] : 0));
      }
      a->d[row] = a->c[row] - a->d[row];
      size = max_with_nan(size, terms);
      if (!nsdae_sparse_kkt_is_dropped(k, row)) worst = max_with_nan(worst, fabs(a->d[row]));
    }
  return part_of(worst, size);
}

static double residual_of_groups(const nsdae_sparse_kkt *k)
{
  double forces = error_of_forces(k), rows = error_of_rows(k, 0);
  return max_with_nan(forces, rows);
}

/* x += z and l += h with the solution of g and d. */
static void correct(const nsdae_sparse_kkt *k)
{
  const nsdae_kkt_values *a = &k->at;
  int n = a->blocks.first[a->blocks.count], m = k->part.row_count;
  if (k->coupled) {
    nsdae_sparse_whole_solve(k);
  } else {
    memcpy(a->z, a->g, (size_t)n * sizeof *a->z);
    solve_masses(k, 0, a->z);
    nsdae_sparse_kkt_times(k, a->Y, a->z, a->h);
    nsdae_add(m, -1, a->d, a->h);
    nsdae_multifrontal_solve(&k->schur, a->h);
    nsdae_sparse_kkt_add_transposed(k, a->Y, -1, a->h, a->z, NULL);
    solve_masses(k, 1, a->z);
  }
  nsdae_add(n, 1, a->z, a->x);
  nsdae_add(m, 1, a->h, a->l);
}

/* The error at which refinement ended, or if that is large, relative to the terms of x. */
static double final_error(const nsdae_sparse_kkt *k, double error)
{
  if (error <= ENOUGH) return error;
  double forces = error_of_forces(k), rows = error_of_rows(k, 1);
  return max_with_nan(forces, rows);
}

/* Corrections until the error is small or no longer falls; returns it. A last one that made it
 * larger is undone. Small is a few roundings; of a matrix of Newton's method, which has larger
 * errors itself, what is enough. */
static double refine(const nsdae_sparse_kkt *k)
{
  const nsdae_kkt_values *a = &k->at;
  double last = INFINITY, now = residual_of_groups(k),
         small = fmax(k->coupled ? ENOUGH : 16 * DBL_EPSILON, k->enough);
  for (int i = 0; i < REFINEMENTS && now > small && now < last / 2; i++) {
    last = now;
    correct(k);
    now = residual_of_groups(k);
  }
  if (now <= last || !(last < INFINITY)) return final_error(k, now);
  nsdae_add(a->blocks.first[a->blocks.count], -1, a->z, a->x);
  nsdae_add(k->part.row_count, -1, a->h, a->l);
  return final_error(k, residual_of_groups(k));
}

int nsdae_sparse_kkt_solve(const nsdae_sparse_kkt *k, const double *r, double *v, double *lambda)
{
  const nsdae_kkt_values *a = &k->at;
  size_t n = (size_t)a->blocks.first[a->blocks.count], m = (size_t)k->part.row_count;
  for (int i = 0; i < a->blocks.count; i++)
    memcpy(a->r + a->blocks.first[i], r + k->part.blocks->first[k->part.block[i]],
           (size_t)nsdae_blocks_size(&a->blocks, i) * sizeof *r);
  for (int i = 0; i < k->part.row_count; i++) a->c[i] = lambda[k->part.row[i]];
  /* It is the residual of x = 0, l = 0. */
  memcpy(a->g, a->r, n * sizeof *a->g);
  memcpy(a->d, a->c, m * sizeof *a->d);
  memset(a->x, 0, n * sizeof *a->x);
  memset(a->l, 0, m * sizeof *a->l);
  correct(k);
  double error = refine(k);
  if (error <= fmax(ENOUGH, k->enough) && k->rank.count < k->part.row_count && !k->coupled) {
    if (!k->rank.chosen && !nsdae_sparse_kkt_consistent(k)) return NSDAE_E_CONVERGENCE;
    nsdae_sparse_kkt_shorten(k);
    error = refine(k);
  }
  if (!(error <= fmax(ENOUGH, k->enough))) return NSDAE_E_CONVERGENCE;
  for (int i = 0; i < a->blocks.count; i++)
    memcpy(v + k->part.blocks->first[k->part.block[i]], a->x + a->blocks.first[i],
           (size_t)nsdae_blocks_size(&a->blocks, i) * sizeof *v);
  for (int i = 0; i < k->part.row_count; i++) lambda[k->part.row[i]] = a->l[i];
  return NSDAE_OK;
}
