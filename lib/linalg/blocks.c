#include "blocks.h"

#include <math.h>
#include <string.h>

#include "dense.h"
#include "vector.h"

size_t nsdae_blocks_largest(const nsdae_blocks *blocks)
{
  size_t most = 0;
  for (int b = 0; b < blocks->count; b++) {
    size_t square = blocks->square[b + 1] - blocks->square[b];
    if (square > most) most = square;
  }
  return most;
}

void nsdae_blocks_add_product(const nsdae_blocks *blocks, const double *M, const double *x,
                              double *y)
{
  for (int b = 0; b < blocks->count; b++) {
    size_t n = (size_t)nsdae_blocks_size(blocks, b);
    const double *block = M + blocks->square[b], *end = x + blocks->first[b + 1];
    for (const double *from = x + blocks->first[b]; from < end; from++, block += n) {
      double *restrict to = y + blocks->first[b], by = *from;
      for (size_t i = 0; i < n; i++) to[i] += block[i] * by;
    }
  }
}

double nsdae_blocks_square(const nsdae_blocks *blocks, const double *M, const double *x)
{
  double sum = 0;
  for (int b = 0; b < blocks->count; b++) {
    int n = nsdae_blocks_size(blocks, b);
    const double *at = x + blocks->first[b], *column = M + blocks->square[b];
    for (int j = 0; j < n; j++, column += n) sum += at[j] * nsdae_dot(n, column, at);
  }
  return sum;
}

static int is_diagonal(size_t n, const double *M)
{
  for (size_t j = 0; j < n; j++)
    for (size_t i = j + 1; i < n; i++)
      if (M[j * n + i] != 0) return 0;
  return 1;
}

int nsdae_blocks_factor(const nsdae_blocks *blocks, int b, const double *M,
                        nsdae_block_factor *factor)
{
  size_t n = (size_t)nsdae_blocks_size(blocks, b);
  const double *block = M + blocks->square[b];
  factor->size = (int)n;
  factor->diagonal = is_diagonal(n, block);
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
    nsdae_la_solve_lower(n, 1, factor->L, n, x, n);
    nsdae_la_solve_lower_transposed(n, 1, factor->L, n, x, n);
    return;
  }
  for (int j = 0; j < n; j++) x[j] /= factor->L[j];
}
