#include <math.h>
#include <nsdae/kernels.h>
#include <stddef.h>

/* Row of y = A x + b, and of sum_j |a_ij|. */
static double row(int n, const double *a, int lda, double b, const double *x, double *size)
{
  double sum = b;
  *size = 0;
  for (int j = 0; j < n; j++) {
    double entry = a[(size_t)j * (size_t)lda];
    sum += entry * x[j];
    *size += fabs(entry);
  }
  return sum;
}

int nsdae_dlcpres(int n, const double *a, int lda, const double *b, const double *x, double *y,
                  double *residual)
{
  if (n < 0) return -1;
  if (!a && n > 0) return -2;
  if (lda < 1 || lda < n) return -3;
  if (!b && n > 0) return -4;
  if (!x && n > 0) return -5;
  if (!y && n > 0) return -6;
  if (!residual) return -7;
  double largest = 0, worst = 0;
  for (int j = 0; j < n; j++) largest = fmax(largest, fabs(x[j]));
  for (int i = 0; i < n; i++) {
    double size, relative_x = largest > 0 ? x[i] / largest : 0;
    y[i] = row(n, a + i, lda, b[i], x, &size);
    size = fabs(b[i]) + largest * size;
    double relative_y = size > 0 ? y[i] / size : 0;
    double error = fabs(relative_x < relative_y ? relative_x : relative_y);
    if (isnan(relative_x + relative_y) || isinf(size)) error = NAN;
    if (!(error <= worst)) worst = error;
    if (isnan(worst)) break;
  }
  *residual = worst;
  return 0;
}
