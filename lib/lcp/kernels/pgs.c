/* Projected Gauss-Seidel, with relaxation projected SOR: Cryer, SIAM J. Control 9 (1971) 385. */
#include <limits.h>
#include <math.h>
#include <nsdae/kernels.h>

#include "finite.h"

/* One sweep; y = A x + b goes along with x, column by column. */
static void sweep(int n, const double *a, int lda, double omega, double *x, double *y)
{
  for (int i = 0; i < n; i++) {
    const double *column = a + (size_t)i * (size_t)lda;
    double next = x[i] - omega * y[i] / column[i];
    if (next < 0) next = 0; /* a NaN stays */
    double change = next - x[i];
    if (change == 0) continue;
    for (int k = 0; k < n; k++) y[k] += change * column[k];
    x[i] = next;
  }
}

int nsdae_dlcppgs(int n, const double *a, int lda, const double *b, double omega, double tol,
                  int max_iter, double *x, int *iterations, double *residual, double *work,
                  int lwork)
{
  if (n < 0 || n > INT_MAX / 2) return -1;
  if (!work) return -11;
  if (lwork == -1) {
    work[0] = 2.0 * n;
    return 0;
  }
  if (lda < 1 || lda < n) return -3;
  if (!nsdae_lcp_finite(n, n, a, lda)) return -2;
  if (!nsdae_lcp_finite(n, 1, b, n)) return -4;
  if (!(omega > 0 && omega < 2)) return -5;
  if (!(tol >= 0)) return -6;
  if (max_iter < 0) return -7;
  if (!nsdae_lcp_finite(n, 1, x, n)) return -8;
  if (!iterations) return -9;
  if (!residual) return -10;
  if (lwork < 2 * n) return -12;
  for (int i = 0; i < n; i++)
    if (!(a[(size_t)i * (size_t)lda + (size_t)i] > 0)) return 2;
  for (int i = 0; i < n; i++) x[i] = fmax(0, x[i]);
  double *y = work, *sizes = work + n;
  for (*iterations = 0;; ++*iterations) {
    if (nsdae_dlcpres(n, a, lda, b, x, y, residual, sizes) != 0) return 3;
    if (*residual <= tol) return 0;
    if (*iterations == max_iter) return 1;
    sweep(n, a, lda, omega, x, y);
  }
}
