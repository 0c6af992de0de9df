#include "rows.h"

#include <math.h>
#include <string.h>

#include "dense.h"
#include "vector.h"

/* ---- blocks */

size_t nsdae_blocks_largest(const nsdae_blocks *blocks)
{
  size_t most = 0;
  for (int b = 0; b < blocks->count; b++) {
    size_t square = blocks->square[b + 1] - blocks->square[b];
    if (square > most) most = square;
  }
  return most;
}

/* Blocks are mostly those of a body in the plane or in space: f(n, ...) with these n known has no
 * loops, and takes a third of the instructions. */
#define OF_SIZE(n, f, ...) \
  ((n) == 3 ? f(3, __VA_ARGS__) : (n) == 6 ? f(6, __VA_ARGS__) : f(n, __VA_ARGS__))

/* y [n] += M x */
static inline int add_product(int n, const double *M, const double *x, double *restrict y)
{
  for (int j = 0; j < n; j++, M += n)
    for (int i = 0; i < n; i++) y[i] += M[i] * x[j];
  return n;
}

static inline double square(int n, const double *M, const double *x)
{
  double sum = 0;
  for (int j = 0; j < n; j++, M += n) sum += x[j] * nsdae_dot(n, M, x);
  return sum;
}

static inline double change(int n, const double *M, const double *from, const double *v,
                            const double *u)
{
  double sum = 0;
  for (int j = 0; j < n; j++, M += n, from += n) {
    double column = 0;
    for (int i = 0; i < n; i++) column += (M[i] - from[i]) * (v[i] + u[i]);
    sum += column * (v[j] + u[j]);
  }
  return sum;
}

void nsdae_blocks_add_product(const nsdae_blocks *blocks, const double *M, const double *x,
                              double *y)
{
  for (int b = 0; b < blocks->count; b++) {
    int first = blocks->first[b], n = nsdae_blocks_size(blocks, b);
    (void)OF_SIZE(n, add_product, M + blocks->square[b], x + first, y + first);
  }
}

double nsdae_blocks_square(const nsdae_blocks *blocks, const double *M, const double *x)
{
  double sum = 0;
  for (int b = 0; b < blocks->count; b++) {
    int n = nsdae_blocks_size(blocks, b);
    sum += OF_SIZE(n, square, M + blocks->square[b], x + blocks->first[b]);
  }
  return sum;
}

double nsdae_blocks_change(const nsdae_blocks *blocks, const double *M, const double *from,
                           const double *v, const double *u)
{
  double sum = 0;
  for (int b = 0; b < blocks->count; b++) {
    int n = nsdae_blocks_size(blocks, b), first = blocks->first[b];
    size_t at = blocks->square[b];
    sum += OF_SIZE(n, change, M + at, from + at, v + first, u + first);
  }
  return sum;
}

int nsdae_blocks_factor(const nsdae_blocks *blocks, int b, const double *M,
                        nsdae_block_factor *factor)
{
  size_t n = (size_t)nsdae_blocks_size(blocks, b);
  const double *block = M + blocks->square[b];
  factor->size = (int)n;
  factor->diagonal = nsdae_la_is_diagonal((int)n, block, (int)n);
  if (!factor->diagonal) {
    memcpy(factor->L, block, n * n * sizeof *block);
    return nsdae_la_cholesky((int)n, factor->L, (int)n);
  }
  for (size_t j = 0; j < n; j++) {
    factor->L[j] = block[j * (n + 1)];
    if (!(factor->L[j] > 0) || !isfinite(factor->L[j])) return (int)j + 1;
  }
  return 0;
}

void nsdae_blocks_solve(const nsdae_block_factor *factor, double *x)
{
  int n = factor->size;
  if (!factor->diagonal) {
    nsdae_la_solve_cholesky(n, factor->L, x);
    return;
  }
  for (int j = 0; j < n; j++) x[j] /= factor->L[j];
}

void nsdae_rows_gather(const nsdae_blocks *blocks, const nsdae_rows *rows, int i, const int *place,
                       double *out, size_t stride)
{
  for (int p = rows->first[i]; p < rows->first[i + 1]; p++) {
    int b = rows->block[p], n = nsdae_blocks_size(blocks, b);
    const double *value = rows->value + rows->at[p];
    double *to = out + (size_t)place[b] * stride;
    for (int j = 0; j < n; j++) to[(size_t)j * stride] = value[(size_t)j * rows->stride];
  }
}

double nsdae_rows_largest(const nsdae_blocks *blocks, const nsdae_rows *rows, int i)
{
  double most = 0;
  for (int p = rows->first[i]; p < rows->first[i + 1]; p++)
    for (int j = 0; j < nsdae_blocks_size(blocks, rows->block[p]); j++)
      most = fmax(most, fabs(rows->value[rows->at[p] + (size_t)j * rows->stride]));
  return most;
}

double nsdae_rows_dot_sizes(const nsdae_blocks *blocks, const nsdae_rows *rows, int i,
                            const double *x)
{
  double sum = 0;
  for (int p = rows->first[i]; p < rows->first[i + 1]; p++) {
    const double *value = rows->value + rows->at[p];
    int at = blocks->first[rows->block[p]], end = blocks->first[rows->block[p] + 1];
    for (int j = at; j < end; j++, value += rows->stride) sum += fabs(*value * (x ? x[j] : 1));
  }
  return sum;
}
