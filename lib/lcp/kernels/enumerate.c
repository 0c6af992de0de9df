/* Enumeration of all 2^n bases of an LCP, for small n. */
#include <float.h>
#include <math.h>
#include <nsdae/kernels.h>

#include "active_set.h"
#include "finite.h"

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
    singular |= size < 0 || !(nsdae_lcp_least_pivot(&p, size) > 64 * n * DBL_EPSILON);
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
