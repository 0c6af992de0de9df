#include "active_set.h"

#include <math.h>
#include <nsdae/kernels.h>
#include <string.h>

#include "dense.h"
#include "vector.h"

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

int nsdae_lcp_active_set(const nsdae_lcp_point *p)
{
  int n = p->n, size = nsdae_lcp_gather(n, p->a, p->lda, p->basis, p->lu, p->index);
  double *x = p->x;
  for (int j = 0; j < size; j++) x[j] = -p->b[p->index[j]];
  if (size > 0 && nsdae_la_lu(size, p->lu, size, p->pivot) != 0) {
    memset(x, 0, (size_t)n * sizeof *x);
    return -1;
  }
  if (size > 0) nsdae_la_lu_solve(size, p->lu, size, p->pivot, x);
  for (int i = n, k = size; i-- > 0;) x[i] = p->basis[i] ? x[--k] : 0;
  return size;
}

double nsdae_lcp_least_pivot(const nsdae_lcp_point *p, int size)
{
  double least = 1;
  for (int j = 0; j < size; j++) {
    const double *column = p->lu + (size_t)j * (size_t)size;
    least = fmin(least, fabs(column[j]) / nsdae_largest(j + 1, column));
  }
  return least;
}

int nsdae_lcp_point_residual(const nsdae_lcp_point *p, double *residual)
{
  return nsdae_dlcpres(p->n, p->a, p->lda, p->b, p->x, p->y, residual, p->sizes);
}
