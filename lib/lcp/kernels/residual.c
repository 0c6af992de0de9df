#include <limits.h>
#include <math.h>
#include <nsdae/kernels.h>
#include <stddef.h>

#include "double_double.h"
#include "enumerate.h"
#include "finite.h"

/* y := A x + b and size_i := |b_i| + sum_j |a_ij x_j|, column by column; then sy. */
static void product_and_sizes(int n, const double *a, int lda, const double *b, const double *x,
                              double *restrict y, double *restrict size)
{
  double largest = nsdae_largest(n, b);
  for (int i = 0; i < n; i++) {
    y[i] = b[i];
    size[i] = fabs(b[i]);
  }
  for (int j = 0; j < n; j++) {
    const double *restrict column = a + (size_t)j * (size_t)lda;
    for (int i = 0; i < n; i++) { /* x_j = 0 included: a NaN of A must show */
      double term = column[i] * x[j];
      y[i] += term;
      size[i] += fabs(term);
    }
  }
  for (int i = 0; i < n; i++) {
    if (size[i] > NSDAE_LCP_FAR * largest && isfinite(size[i])) { /* in twice the precision */
      double high = b[i], low = 0;
      for (int j = 0; j < n; j++)
        nsdae_dd_add(a[(size_t)j * (size_t)lda + (size_t)i], x[j], &high, &low);
      y[i] = high + low;
      size[i] = NSDAE_LCP_FAR * largest;
    }
    size[i] += 1e-3 * largest;
  }
}

/* y_i / sy_i, or x_i / sx_i: zero where there is nothing to compare with. */
static double relative(double value, double size)
{
  return size > 0 ? value / size : value;
}

double nsdae_lcp_entry_error(int n, const double *column, int i, double x, double y,
                             const double *sizes)
{
  double of_y = relative(y, sizes[i]), least = INFINITY;
  if (isnan(x + y) || !isfinite(sizes[i])) return NAN;
  if (x >= 0 && of_y <= 0) return of_y; /* whatever sx is */
  /* sx: how large x must be to change some row. */
  for (int k = 0; k < n && x != 0; k++) {
    double size = column[k] != 0 ? sizes[k] / fabs(column[k]) : INFINITY;
    least = size < least ? size : least;
  }
  double of_x = x == 0 ? 0 : relative(x, least);
  return of_x < of_y ? of_x : of_y;
}

int nsdae_dlcpres(int n, const double *a, int lda, const double *b, const double *x, double *y,
                  double *residual, double *work)
{
  double worst = 0;
  if (n < 0) return -1;
  if (!a && n > 0) return -2;
  if (lda < 1 || lda < n) return -3;
  if (!b && n > 0) return -4;
  if (!x && n > 0) return -5;
  if (!y && n > 0) return -6;
  if (!residual) return -7;
  if (!work && n > 0) return -8;
  product_and_sizes(n, a, lda, b, x, y, work);
  for (int i = 0; i < n && !isnan(worst); i++) {
    double of_y = relative(y[i], work[i]);
    if (isfinite(work[i]) && x[i] >= 0 && isfinite(x[i]) && of_y >= -worst &&
        (x[i] == 0 || of_y <= worst))
      continue; /* |min(x / sx, y / sy)| is not above worst, whatever sx is */
    double error = fabs(nsdae_lcp_entry_error(n, a + (size_t)i * (size_t)lda, i, x[i], y[i], work));
    if (!(error <= worst)) worst = error;
  }
  *residual = worst;
  return isnan(worst) ? 1 : 0;
}

/* Projected Gauss-Seidel, with relaxation projected SOR: Cryer, SIAM J. Control 9 (1971) 385. */

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
