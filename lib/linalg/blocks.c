#include "blocks.h"

#include <string.h>

#include "dense.h"
#include "vector.h"

void nsdae_blocks_add_product(const nsdae_blocks *blocks, const double *M, const double *x,
                              double *y)
{
  for (int b = 0; b < blocks->count; b++) {
    int n = nsdae_blocks_size(blocks, b), at = blocks->first[b];
    nsdae_add_product(n, n, M + blocks->square[b], x + at, y + at);
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

int nsdae_blocks_factor(const nsdae_blocks *blocks, int b, const double *M, double *L)
{
  int n = nsdae_blocks_size(blocks, b);
  memcpy(L, M + blocks->square[b], (size_t)n * (size_t)n * sizeof *L);
  return nsdae_la_cholesky(n, L, n);
}

void nsdae_blocks_solve(int size, const double *L, double *x)
{
  nsdae_la_solve_lower(size, 1, L, size, x, size);
  nsdae_la_solve_lower_transposed(size, 1, L, size, x, size);
}
