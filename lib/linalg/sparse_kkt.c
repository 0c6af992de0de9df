#include "sparse_kkt.h"

#include <float.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include <nsdae/status.h>

#include "dynamic_array.h"
#include "vector.h"

enum { ROUNDS = 200 };

static const double enough = 1e-9; /* of a residual, to be a solution at all */

/* What is looked at in one call. */
typedef struct part {
  const nsdae_blocks *blocks;
  const nsdae_rows *J;
  const double *M, *r;
  const int *block, *row;
  int blocks_count, rows_count;
  double scale; /* s */
} part;

static int reserve(nsdae_sparse_kkt *s, const part *p)
{
  int all = p->blocks->count, order = p->blocks->first[all];
  const nsdae_array by_block[] = {NSDAE_ARRAY(s->number, 1), NSDAE_ARRAY(s->size, 1),
                                  NSDAE_ARRAY(s->begin, 1),  NSDAE_ARRAY(s->first, 1),
                                  NSDAE_ARRAY(s->mark, 1),   NSDAE_ARRAY(s->by_block, 1)};
  const nsdae_array by_entry[] = {NSDAE_ARRAY(s->x, 1), NSDAE_ARRAY(s->g, 1)};
  const nsdae_array by_row[] = {NSDAE_ARRAY(s->rest, 3)};
  const nsdae_array by_part[] = {NSDAE_ARRAY(s->of_block, 1)};
  int parts = p->J->first[p->J->count];
  if (s->blocks >= all && s->rows >= p->J->count && s->parts >= parts && s->order >= order)
    return NSDAE_OK;
  int status = nsdae_arrays_grow(by_block, sizeof by_block / sizeof *by_block, (size_t)all + 2);
  if (status == NSDAE_OK) status = nsdae_arrays_grow(by_entry, 2, (size_t)order);
  if (status == NSDAE_OK) status = nsdae_arrays_grow(by_row, 1, (size_t)p->J->count);
  if (status == NSDAE_OK) status = nsdae_arrays_grow(by_part, 1, (size_t)parts);
  if (status < 0) return status;
  s->blocks = all;
  s->rows = p->J->count;
  s->parts = parts;
  s->order = order;
  return NSDAE_OK;
}

void nsdae_sparse_kkt_release(nsdae_sparse_kkt *s)
{
  const nsdae_array all[] = {
      NSDAE_ARRAY(s->number, 1),   NSDAE_ARRAY(s->size, 1), NSDAE_ARRAY(s->begin, 1),
      NSDAE_ARRAY(s->first, 1),    NSDAE_ARRAY(s->mark, 1), NSDAE_ARRAY(s->by_block, 1),
      NSDAE_ARRAY(s->x, 1),        NSDAE_ARRAY(s->g, 1),    NSDAE_ARRAY(s->rest, 1),
      NSDAE_ARRAY(s->of_block, 1), NSDAE_ARRAY(s->index, 1)};
  nsdae_arrays_release(all, sizeof all / sizeof *all);
  nsdae_multifrontal_release(&s->fronts);
}

static int ascending(const void *a, const void *b)
{
  int x = *(const int *)a, y = *(const int *)b;
  return (x > y) - (x < y);
}

static int push(nsdae_sparse_kkt *s, int at, int value)
{
  if (at >= s->index_room) {
    const nsdae_array index[] = {NSDAE_ARRAY(s->index, 1)};
    int room = at < 64 ? 128 : 2 * at;
    if (nsdae_arrays_grow(index, 1, (size_t)room) < 0) return NSDAE_E_MEMORY;
    s->index_room = room;
  }
  s->index[at] = value;
  return NSDAE_OK;
}

/* The neighbours of each block: those of the rows that touch it. */
static int graph(nsdae_sparse_kkt *s, const part *p)
{
  int count = 0;
  for (int b = 0; b < p->blocks_count; b++) s->mark[b] = -1;
  for (int b = 0; b < p->blocks_count; b++) {
    s->first[b] = count;
    s->mark[b] = b;
    for (int l = s->by_block[b]; l < s->by_block[b + 1]; l++) {
      int row = p->row[s->of_block[l]];
      for (int e = p->J->first[row]; e < p->J->first[row + 1]; e++) {
        int other = s->number[p->J->block[e]];
        if (s->mark[other] == b) continue;
        s->mark[other] = b;
        if (push(s, count++, other) < 0) return NSDAE_E_MEMORY;
      }
    }
    qsort(s->index + s->first[b], (size_t)(count - s->first[b]), sizeof *s->index, ascending);
  }
  s->first[p->blocks_count] = count;
  return NSDAE_OK;
}

/* Entry of the graph: the place of block `to` among the neighbours of `from`. */
static size_t graph_place(const nsdae_sparse_kkt *s, int from, int to)
{
  if (from == to) return s->fronts.graph.diagonal[from];
  int low = s->first[from], high = s->first[from + 1] - 1;
  while (low < high) {
    int middle = (low + high) / 2;
    if (s->index[middle] < to)
      low = middle + 1;
    else
      high = middle;
  }
  return s->fronts.graph.at[low];
}

/* The block of A in block row `a`, block column `b` gets s J_a^T J_b of one row. */
static void add_outer(nsdae_sparse_kkt *s, const part *p, int row)
{
  const nsdae_rows *J = p->J;
  for (int e = J->first[row]; e < J->first[row + 1]; e++)
    for (int g = J->first[row]; g < J->first[row + 1]; g++) {
      int a = s->number[J->block[e]], b = s->number[J->block[g]];
      double *A = s->fronts.A + graph_place(s, b, a);
      const double *left = J->value + J->at[e], *right = J->value + J->at[g];
      for (int j = 0; j < s->size[b]; j++)
        for (int i = 0; i < s->size[a]; i++)
          A[(size_t)j * (size_t)s->size[a] + (size_t)i] +=
              p->scale * left[(size_t)i * J->stride] * right[(size_t)j * J->stride];
    }
}

static int factor_part(nsdae_sparse_kkt *s, const part *p)
{
  memset(s->fronts.A, 0, s->fronts.values * sizeof *s->fronts.A);
  for (int i = 0; i < p->blocks_count; i++) {
    size_t square = (size_t)s->size[i] * (size_t)s->size[i];
    memcpy(s->fronts.A + s->fronts.graph.diagonal[i], p->M + p->blocks->square[p->block[i]],
           square * sizeof *p->M);
  }
  for (int i = 0; i < p->rows_count; i++) add_outer(s, p, p->row[i]);
  return nsdae_multifrontal_factor(&s->fronts, 1) == 0 ? NSDAE_OK : NSDAE_E_MASS;
}

/* s: 1e5 over the mean of the diagonal of J M^-1 J^T, by the diagonal of M. */
static double scale_of(const part *p)
{
  double sum = 0;
  for (int i = 0; i < p->rows_count; i++)
    for (int e = p->J->first[p->row[i]]; e < p->J->first[p->row[i] + 1]; e++) {
      int b = p->J->block[e], n = nsdae_blocks_size(p->blocks, b);
      for (int j = 0; j < n; j++) {
        double entry = p->J->value[p->J->at[e] + (size_t)j * p->J->stride];
        sum += entry * entry / p->M[p->blocks->square[b] + (size_t)j * (size_t)(n + 1)];
      }
    }
  return sum > 0 ? 1e5 * p->rows_count / sum : 1;
}

/* sum |J_ij x_j| */
static double size_of_terms(const part *p, int row, const double *x)
{
  double sum = 0;
  for (int e = p->J->first[row]; e < p->J->first[row + 1]; e++) {
    const double *value = p->J->value + p->J->at[e], *at = x + p->blocks->first[p->J->block[e]];
    for (int j = 0; j < nsdae_blocks_size(p->blocks, p->J->block[e]); j++)
      sum += fabs(value[(size_t)j * p->J->stride] * at[j]);
  }
  return sum;
}

/* g := r - M x - J^T l and d := c - J x; returns the larger of the two, each relative to the terms
 * that it is a sum of. */
static double kkt_residual(nsdae_sparse_kkt *s, const part *p, const double *c, const double *l,
                           const double *x)
{
  double worst = 0, size = 0, worst_row = 0, size_row = 0, *d = s->rest + 2 * p->rows_count;
  for (int i = 0; i < p->blocks_count; i++) {
    int b = p->block[i], at = p->blocks->first[b], n = s->size[i];
    for (int j = 0; j < n; j++) s->g[at + j] = -x[at + j];
    memset(s->x, 0, (size_t)n * sizeof *s->x);
    nsdae_add_product(n, n, p->M + p->blocks->square[b], s->g + at, s->x);
    for (int j = 0; j < n; j++) {
      size = fmax(size, fmax(fabs(p->r[at + j]), fabs(s->x[j])));
      s->g[at + j] = p->r[at + j] + s->x[j];
    }
  }
  for (int i = 0; i < p->rows_count; i++) {
    double rate = nsdae_rows_dot(p->blocks, p->J, p->row[i], x);
    nsdae_rows_add(p->blocks, p->J, p->row[i], -l[i], s->g);
    d[i] = c[i] - rate;
    worst_row = fmax(worst_row, fabs(d[i]));
    size_row = fmax(size_row, fmax(fabs(c[i]), size_of_terms(p, p->row[i], x)));
  }
  for (int i = 0; i < p->blocks_count; i++)
    for (int j = p->blocks->first[p->block[i]]; j < p->blocks->first[p->block[i] + 1]; j++)
      worst = fmax(worst, isfinite(s->g[j]) ? fabs(s->g[j]) : HUGE_VAL);
  for (int i = 0; i < p->rows_count; i++)
    if (!isfinite(d[i])) worst = HUGE_VAL; /* fmax passes over NaN */
  if (!(worst < HUGE_VAL)) return worst;
  worst = size > 0 ? worst / size : worst;
  return fmax(worst, size_row > 0 ? worst_row / size_row : worst_row);
}

/* x += A^-1 (g + s J^T d) = x + y,  l += s (J y - d). */
static void correct(nsdae_sparse_kkt *s, const part *p, double *l, double *x)
{
  const double *d = s->rest + 2 * p->rows_count;
  for (int i = 0; i < p->rows_count; i++)
    nsdae_rows_add(p->blocks, p->J, p->row[i], p->scale * d[i], s->g);
  for (int i = 0; i < p->blocks_count; i++)
    memcpy(s->x + s->begin[i], s->g + p->blocks->first[p->block[i]],
           (size_t)s->size[i] * sizeof *x);
  nsdae_multifrontal_solve(&s->fronts, s->x);
  for (int i = 0; i < p->blocks_count; i++) {
    int at = p->blocks->first[p->block[i]];
    memcpy(s->g + at, s->x + s->begin[i], (size_t)s->size[i] * sizeof *x);
    for (int j = 0; j < s->size[i]; j++) x[at + j] += s->g[at + j];
  }
  for (int i = 0; i < p->rows_count; i++)
    l[i] += p->scale * (nsdae_rows_dot(p->blocks, p->J, p->row[i], s->g) - d[i]);
}

/* Rounds until the residual no longer falls, from zero. */
static int refine_solution(nsdae_sparse_kkt *s, const part *p, double *v, double *lambda)
{
  double last = INFINITY, *c = s->rest, *l = s->rest + p->rows_count;
  for (int i = 0; i < p->rows_count; i++) {
    c[i] = lambda[p->row[i]];
    l[i] = 0;
  }
  for (int i = 0; i < p->blocks_count; i++)
    memset(v + p->blocks->first[p->block[i]], 0, (size_t)s->size[i] * sizeof *v);
  for (int round = 0; round < ROUNDS; round++) {
    double now = kkt_residual(s, p, c, l, v);
    if (!(now < INFINITY)) return NSDAE_E_CONVERGENCE;
    if (now <= DBL_EPSILON || (round > 2 && now >= last / 2 && now < enough)) break;
    last = now;
    correct(s, p, l, v);
  }
  if (!(kkt_residual(s, p, c, l, v) < enough)) return NSDAE_E_CONVERGENCE;
  for (int i = 0; i < p->rows_count; i++) lambda[p->row[i]] = l[i];
  return NSDAE_OK;
}

static int analyse(nsdae_sparse_kkt *s, const part *p)
{
  for (int i = 0, at = 0; i < p->blocks_count; i++) {
    s->number[p->block[i]] = i;
    s->size[i] = nsdae_blocks_size(p->blocks, p->block[i]);
    s->begin[i] = at;
    at += s->size[i];
  }
  /* Rows (their places in the part's list) by the blocks that they touch. */
  memset(s->by_block, 0, ((size_t)p->blocks_count + 2) * sizeof *s->by_block);
  for (int i = 0; i < p->rows_count; i++)
    for (int e = p->J->first[p->row[i]]; e < p->J->first[p->row[i] + 1]; e++)
      s->by_block[s->number[p->J->block[e]] + 2]++;
  for (int b = 0; b < p->blocks_count; b++) s->by_block[b + 2] += s->by_block[b + 1];
  for (int i = 0; i < p->rows_count; i++)
    for (int e = p->J->first[p->row[i]]; e < p->J->first[p->row[i] + 1]; e++)
      s->of_block[s->by_block[s->number[p->J->block[e]] + 1]++] = i;
  if (push(s, 0, 0) < 0 || graph(s, p) < 0) return NSDAE_E_MEMORY;
  return nsdae_multifrontal_analyse(&s->fronts, p->blocks_count, s->size, s->first, s->index);
}

int nsdae_sparse_kkt_solve(nsdae_sparse_kkt *s, const nsdae_blocks *blocks, const nsdae_rows *J,
                           const double *M, int block_count, const int *block, int row_count,
                           const int *row, const double *r, double *v, double *lambda)
{
  part p = {blocks, J, M, r, block, row, block_count, row_count, 0};
  int status = reserve(s, &p);
  if (status == NSDAE_OK) status = analyse(s, &p);
  if (status < 0) return status;
  p.scale = scale_of(&p);
  status = factor_part(s, &p);
  return status < 0 ? status : refine_solution(s, &p, v, lambda);
}
