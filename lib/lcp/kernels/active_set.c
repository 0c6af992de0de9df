#include "active_set.h"

#include <math.h>
#include <stddef.h>
#include <string.h>

#include "dense.h"

int nsdae_lcp_gather(int n, const double *A, int lda, const int *basis, double *lu, int *index)
{
  int size = 0;
  for (int i = 0; i < n; i++)
    if (basis[i]) index[size++] = i;
  for (int j = 0; j < size; j++) {
    const double *column = A + (size_t)index[j] * (size_t)lda;
    for (int i = 0; i < size; i++) *lu++ = column[index[i]];
  }
  return size;
}

double nsdae_lcp_active_set(int n, const double *a, int lda, const double *b, const int *basis,
                            double *x, double *lu, int *pivot, int *index)
{
  int size = nsdae_lcp_gather(n, a, lda, basis, lu, index);
  for (int j = 0; j < size; j++) x[j] = -b[index[j]];
  if (size > 0 && nsdae_la_lu(size, lu, size, pivot) != 0) {
    memset(x, 0, (size_t)n * sizeof *x);
    return 0;
  }
  if (size > 0) nsdae_la_lu_solve(size, lu, size, pivot, x);
  for (int i = n, k = size; i-- > 0;) x[i] = basis[i] ? x[--k] : 0;
  /* The least pivot, relative to the largest entry above it. */
  double least = 1;
  for (int j = 0; j < size; j++) {
    const double *column = lu + (size_t)j * (size_t)size;
    double largest = 0;
    for (int i = 0; i <= j; i++) largest = fmax(largest, fabs(column[i]));
    least = fmin(least, fabs(column[j]) / largest);
  }
  return least;
}
