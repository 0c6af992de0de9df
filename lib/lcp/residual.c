#include "residual.h"

#include <math.h>
#include <nsdae/kernels.h>
#include <stddef.h>

/* Row of y = A x + b, and of |b| + sum_j |a_ij x_j|. */
static double row(int n, const double *a, int lda, double b, const double *x, double *size)
{
  double sum = b;
  *size = fabs(b);
  for (int j = 0; j < n; j++) {
    double term = a[(size_t)j * (size_t)lda] * x[j];
    sum += term;
    *size += fabs(term);
  }
  return sum;
}

/* y_i / sy_i, or x_i / sx_i: zero where there is nothing to compare with. */
static double relative(double value, double size)
{
  return size > 0 ? value / size : value;
}

/* sx_j: how large x_j must be to change some row. */
static double column_size(int n, const double *column, const double *sy)
{
  double least = INFINITY;
  for (int k = 0; k < n; k++)
    if (column[k] != 0) least = fmin(least, sy[k] / fabs(column[k]));
  return least;
}

double nsdae_lcp_entry_error(int n, const double *column, int i, double x, double y,
                             const double *sizes)
{
  double of_x = relative(x, column_size(n, column, sizes)), of_y = relative(y, sizes[i]);
  if (isnan(x + y) || !isfinite(sizes[i])) return NAN;
  return of_x < of_y ? of_x : of_y;
}

static int check(int n, const double *a, int lda, const double *b, const double *x, const double *y,
                 const double *residual, const double *work)
{
  if (n < 0) return -1;
  if (!a && n > 0) return -2;
  if (lda < 1 || lda < n) return -3;
  if (!b && n > 0) return -4;
  if (!x && n > 0) return -5;
  if (!y && n > 0) return -6;
  if (!residual) return -7;
  return work || n == 0 ? 0 : -8;
}

int nsdae_dlcpres(int n, const double *a, int lda, const double *b, const double *x, double *y,
                  double *residual, double *work)
{
  int info = check(n, a, lda, b, x, y, residual, work);
  if (info != 0) return info;
  double largest = 0, worst = 0;
  for (int i = 0; i < n; i++) largest = fmax(largest, fabs(b[i]));
  for (int i = 0; i < n; i++) {
    y[i] = row(n, a + i, lda, b[i], x, &work[i]);
    work[i] += 1e-3 * largest;
  }
  for (int i = 0; i < n && !isnan(worst); i++) {
    double error = fabs(nsdae_lcp_entry_error(n, a + (size_t)i * (size_t)lda, i, x[i], y[i], work));
    if (!(error <= worst)) worst = error;
  }
  *residual = worst;
  return isnan(worst) ? 1 : 0;
}
