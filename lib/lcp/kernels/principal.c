/* Principal pivoting: blocks (Kostreva, Linear Algebra Appl. 21 (1978) 213; Judice and Pires,
 * Comput. Oper. Res. 21 (1994) 587), then the least index (Murty). */
#include <math.h>
#include <nsdae/kernels.h>

#include "active_set.h"
#include "finite.h"

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
