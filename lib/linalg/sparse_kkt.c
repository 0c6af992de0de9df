#include "sparse_kkt.h"

#include <float.h>
#include <math.h>
#include <string.h>

#include <nsdae/status.h>

#include "dense.h"
#include "sparse_rank.h"
#include "vector.h"

enum { REFINEMENTS = 10 };

/* Largest backward error of a solution. Refinement ends at a few DBL_EPSILON; sums of 1000 terms
 * remain below this. */
static const double ENOUGH = 1e-12;

/* ---- the factors */

/* M + D = L L^T. */
static int factor_masses(nsdae_sparse_kkt *k, const double *M, const double *D)
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
  return NSDAE_OK;
}

/* J, and Y = L^-1 J^T. */
static void gather_rows(nsdae_sparse_kkt *k)
{
  const nsdae_kkt_nodes *n = &k->nodes;
  const nsdae_rows *J = k->part.J;
  for (int i = 0; i < n->count; i++)
    for (int p = n->part[i]; p < n->part[i + 1]; p++) {
      int size = nsdae_blocks_size(&k->at.blocks, n->block[p]);
      double *to = k->at.J + n->at[p], *Y = k->at.Y + n->at[p];
      for (int row = n->row[i]; row < n->row[i + 1]; row++) {
        int entry = J->first[k->part.row[row]] + p - n->part[i];
        const double *value = J->value + J->at[entry];
        for (int j = 0; j < size; j++) *to++ = value[(size_t)j * J->stride];
      }
      memcpy(Y, k->at.J + n->at[p], (size_t)(n->size[i] * size) * sizeof *Y);
      nsdae_la_solve_lower(size, n->size[i], k->at.L + k->at.blocks.square[n->block[p]], size, Y,
                           size);
    }
}

/* Entry of the graph: the place of block `to` among the neighbours of `from`. */
static size_t graph_place(const nsdae_sparse_kkt *s, int from, int to)
{
  for (int c = 0; c < columns; c++, B += size, C += rows)
    for (int r = 0; r < rows; r++) C[r] += nsdae_dot(size, A + (size_t)r * (size_t)size, B);
  return 0;
}

/* The block of S in the rows of node a and the columns of node b. */
static void form_block(const nsdae_sparse_kkt *k, int a, int b, double *C)
{
  const nsdae_kkt_nodes *n = &k->nodes;
  const double *Y = k->at.Y;
  int rows = n->size[a], columns = n->size[b];
  memset(C, 0, (size_t)(rows * columns) * sizeof *C);
  for (int p = n->part[a]; p < n->part[a + 1]; p++)
    for (int q = n->part[b]; q < n->part[b + 1]; q++) {
      int size = nsdae_blocks_size(&k->at.blocks, n->block[p]);
      if (n->block[p] != n->block[q])
        continue;
      else if (size == 6) /* a body in space, as the compiler may know */
        add_gram(6, rows, columns, Y + n->at[p], Y + n->at[q], C);
      else
        add_gram(size, rows, columns, Y + n->at[p], Y + n->at[q], C);
    }
}

/* S = Y^T Y: its diagonal blocks, and those whose rows are eliminated after their columns. */
static void form_schur(nsdae_sparse_kkt *k)
{
  const nsdae_kkt_nodes *n = &k->nodes;
  const nsdae_multifrontal *f = &k->schur;
  for (int i = 0; i < n->count; i++) {
    form_block(k, i, i, f->A + f->graph.diagonal[i]);
    for (int e = n->first[i]; e < n->first[i + 1]; e++)
      if (f->tree.number[n->index[e]] > f->tree.number[i])
        form_block(k, n->index[e], i, f->A + f->graph.at[e]);
  }
}

int nsdae_sparse_kkt_factor(nsdae_sparse_kkt *k, const double *M, const double *D)
{
  int status = factor_masses(k, M, D);
  if (status < 0) return status;
  gather_rows(k);
  form_schur(k);
  return nsdae_sparse_kkt_find_rank(k);
}

/* out [rows] = J x, or Y^T x */
void nsdae_sparse_kkt_times(const nsdae_sparse_kkt *k, const double *J, const double *x,
                            double *out)
{
  const nsdae_kkt_nodes *n = &k->nodes;
  memset(out, 0, (size_t)k->part.row_count * sizeof *out);
  for (int i = 0; i < n->count; i++)
    for (int p = n->part[i]; p < n->part[i + 1]; p++) {
      int size = nsdae_blocks_size(&k->at.blocks, n->block[p]);
      const double *value = J + n->at[p], *of = x + k->at.blocks.first[n->block[p]];
      for (int row = n->row[i]; row < n->row[i + 1]; row++, value += size)
        out[row] += nsdae_dot(size, value, of);
    }
}

/* out [nv] += scale J^T l, or Y l; size, if not NULL, += |J^T| |l| */
void nsdae_sparse_kkt_add_transposed(const nsdae_sparse_kkt *k, const double *J, double scale,
                                     const double *l, double *out, double *size)
{
  const nsdae_kkt_nodes *n = &k->nodes;
  for (int i = 0; i < n->count; i++)
    for (int p = n->part[i]; p < n->part[i + 1]; p++) {
      int at = k->at.blocks.first[n->block[p]], end = k->at.blocks.first[n->block[p] + 1];
      const double *value = J + n->at[p];
      for (int row = n->row[i]; row < n->row[i + 1]; row++)
        for (int j = at; j < end; j++, value++) {
          out[j] += scale * l[row] * *value;
          if (size) size[j] += fabs(l[row] * *value);
        }
    }
}

void nsdae_sparse_kkt_solve_schur(nsdae_sparse_kkt *k, double *h)
{
  if (k->by_ldl)
    nsdae_sparse_ldl_solve(&k->ldl, &k->schur, h);
  else
    nsdae_multifrontal_solve(&k->schur, h);
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

/* worst / size; not finite if a number is not. */
static double part_of(double worst, double size)
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
  return a <= most || isnan(most) ? most : a; /* NaN stays */
}

/* g = r - (M + D) x - J^T l, divided by the largest |r| + |(M + D) x| + |J^T| |l| */
static double error_of_forces(const nsdae_sparse_kkt *k)
{
  const nsdae_kkt_values *a = &k->at;
  int n = a->blocks.first[a->blocks.count];
  double worst = 0, size = 0;
  memset(a->g, 0, (size_t)n * sizeof *a->g);
  nsdae_blocks_add_product(&a->blocks, a->M, a->x, a->g);
  for (int j = 0; j < n; j++) {
    a->size[j] = fabs(a->r[j]) + fabs(a->g[j]);
    a->g[j] = a->r[j] - a->g[j];
  }
  nsdae_sparse_kkt_add_transposed(k, a->J, -1, a->l, a->g, a->size);
  for (int j = 0; j < n; j++) {
    worst = larger(worst, fabs(a->g[j]));
    size = larger(size, a->size[j]);
  }
  return part_of(worst, size);
}

/* d = c - J x of the rows that count, divided by the largest |c| + |J| |x|. */
static double error_of_rows(const nsdae_sparse_kkt *k)
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
        for (int j = 0; j < m; j++) terms += fabs(value[j] * x[j]);
      }
      a->d[row] = a->c[row] - a->d[row];
      size = larger(size, terms);
      if (!nsdae_sparse_kkt_is_dropped(k, i, row)) worst = larger(worst, fabs(a->d[row]));
    }
  return part_of(worst, size);
}

static double residual(const nsdae_sparse_kkt *k)
{
  double forces = error_of_forces(k), rows = error_of_rows(k);
  return larger(forces, rows);
}

/* g := r - M x - J^T l and d := c - J x; returns the larger of the two, each relative to the terms
 * that it is a sum of. */
static double kkt_residual(nsdae_sparse_kkt *s, const part *p, const double *c, const double *l,
                           const double *x)
{
  nsdae_kkt_values *a = &k->at;
  int n = a->blocks.first[a->blocks.count], m = k->part.row_count;
  memcpy(a->z, a->g, (size_t)n * sizeof *a->z);
  solve_masses(k, 0, a->z);
  nsdae_sparse_kkt_times(k, a->Y, a->z, a->h);
  nsdae_add(m, -1, a->d, a->h);
  nsdae_sparse_kkt_solve_schur(k, a->h);
  nsdae_sparse_kkt_add_transposed(k, a->Y, -1, a->h, a->z, NULL);
  solve_masses(k, 1, a->z);
  nsdae_add(n, 1, a->z, a->x);
  nsdae_add(m, 1, a->h, a->l);
}

/* Corrections until the error no longer falls; returns it. A last one that made it larger is
 * undone. */
static double refine(nsdae_sparse_kkt *k)
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
    correct(k);
    now = residual(k);
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
