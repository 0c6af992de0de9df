/* Enumeration of all 2^n bases of an LCP, for small n. */
#include "enumerate.h"

#include <float.h>
#include <math.h>
#include <nsdae/kernels.h>
#include <string.h>

#include "dense.h"
#include "finite.h"

/* Principal pivoting: blocks (Kostreva, Linear Algebra Appl. 21 (1978) 213; Judice and Pires,
 * Comput. Oper. Res. 21 (1994) 587), then the least index (Murty). */

static int pivot_to_the_end(const nsdae_lcp_point *p, double tol, int block, int max_pivots,
                            int *basis, int *pivots, double *residual)
{
  int fewest = p->n + 1, left = block;
  for (*pivots = 0;; ++*pivots) {
    int size = nsdae_lcp_active_set(p);
    if (nsdae_lcp_point_residual(p, residual) != 0 || size < 0) return 1;
    if (*residual <= tol) return 0;
    /* The indices of which x_i, or y_i if x_i is not basic, is below zero by more than tol. */
    int count = 0;
    for (int i = 0; i < p->n; i++) {
      const double *column = p->a + (size_t)i * (size_t)p->lda;
      if ((p->basis[i] ? p->x[i] : p->y[i]) < 0 &&
          nsdae_lcp_entry_error(p->n, column, i, p->x[i], p->y[i], p->sizes) < -tol)
        p->index[count++] = i;
    }
    if (count == 0) return 1;
    if (*pivots == max_pivots) return 2;
    if (count < fewest) {
      fewest = count;
      left = block;
    } else if (left > 0)
      left--;
    if (left == 0) count = 1;
    for (int k = 0; k < count; k++) basis[p->index[k]] ^= 1;
  }
}

int nsdae_dlcpppm(int n, const double *a, int lda, const double *b, double tol, int block,
                  int max_pivots, double *x, int *basis, int *pivots, double *residual,
                  double *work, int lwork, int *iwork)
{
  if (n < 0 || n > 32000) return -1; /* n (n + 2) is an int */
  if (!work) return -12;
  if (lwork == -1) {
    work[0] = (double)n * (n + 2);
    return 0;
  }
  if (lda < 1 || lda < n) return -3;
  if (!nsdae_lcp_finite(n, n, a, lda)) return -2;
  if (!nsdae_lcp_finite(n, 1, b, n)) return -4;
  if (!(tol >= 0)) return -5;
  if (block < 0) return -6;
  if (max_pivots < 0) return -7;
  if (!x && n > 0) return -8;
  if (!basis && n > 0) return -9;
  for (int i = 0; i < n; i++)
    if (basis[i] != 0 && basis[i] != 1) return -9;
  if (!pivots) return -10;
  if (!residual) return -11;
  if (lwork < n * (n + 2)) return -13;
  if (!iwork) return -14;
  double *y = work + (size_t)n * (size_t)n;
  const nsdae_lcp_point p = {n, lda, a, b, x, work, y, y + n, basis, iwork, iwork + n};
  int info = pivot_to_the_end(&p, tol, block, max_pivots, basis, pivots, residual);
  if (info != 0) return info;
  /* Rounding below zero off; the residual is that of what is returned. */
  for (int i = 0; i < n; i++) x[i] = fmax(0, x[i]);
  nsdae_lcp_point_residual(&p, residual);
  return *residual <= tol ? 0 : 1;
}

/* ---- active set */

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

/* Of the factors of that size, the least pivot relative to its column of U: 1 for an empty set, of
 * rounding size if A_FF is singular to rounding. */
static double least_pivot(const nsdae_lcp_point *p, int size)
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

enum { LARGEST = 20 };

static double residual_of(const nsdae_lcp_point *p)
{
  double residual;
  return nsdae_lcp_point_residual(p, &residual) == 0 ? residual : INFINITY;
}

int nsdae_dlcpenum(int n, const double *a, int lda, const double *b, double tol, int *set,
                   double *x, double *residual, double *work, int lwork, int *iwork)
{
  if (n < 0 || n > LARGEST) return -1;
  if (!work) return -9;
  if (lwork == -1) {
    work[0] = (double)n * (n + 2);
    return 0;
  }
  if (lda < 1 || lda < n) return -3;
  if (!nsdae_lcp_finite(n, n, a, lda)) return -2;
  if (!nsdae_lcp_finite(n, 1, b, n)) return -4;
  if (!(tol >= 0)) return -5;
  if (!set || *set < 0 || *set > 1 << n) return -6;
  if (!x && n > 0) return -7;
  if (!residual) return -8;
  if (lwork < n * (n + 2)) return -10;
  if (!iwork) return -11;
  double *y = work + (size_t)n * (size_t)n;
  const nsdae_lcp_point p = {n, lda, a, b, x, work, y, y + n, iwork, iwork + n, iwork + 2 * n};
  int singular = 0;
  *residual = INFINITY;
  for (; *set < 1 << n; ++*set) {
    for (int i = 0; i < n; i++) iwork[i] = *set >> i & 1;
    int size = nsdae_lcp_active_set(&p);
    singular |= size < 0 || !(least_pivot(&p, size) > 64 * n * DBL_EPSILON);
    double fresh = residual_of(&p);
    /* A solution without its rounding below zero. A set with a negative x_i is none even where x_i
     * = 0 makes one: that one belongs to another set. */
    if (fresh <= tol) {
      for (int i = 0; i < n; i++) x[i] = fmax(0, x[i]);
      fresh = residual_of(&p);
    }
    if (fresh < *residual) *residual = fresh;
    if (fresh <= tol) return 0;
  }
  return singular ? 2 : 1;
}
