#include "equilibrate.h"

#include <math.h>
#include <stddef.h>

/* max |a_i|; four at a time, for the latency of a comparison. */
static double largest(int n, const double *a)
{
  double most[4] = {0}, rest = 0;
  int i = 0;
  for (; i + 4 <= n; i += 4)
    for (int k = 0; k < 4; k++) most[k] = fabs(a[i + k]) > most[k] ? fabs(a[i + k]) : most[k];
  for (; i < n; i++) rest = fabs(a[i]) > rest ? fabs(a[i]) : rest;
  for (int k = 0; k < 4; k++) rest = most[k] > rest ? most[k] : rest;
  return rest;
}

/* Largest entries by magnitude of the rows and columns. */
static void measure(int n, const double *A, double *restrict of_row, double *restrict of_column)
{
  for (int i = 0; i < n; i++) of_row[i] = 0;
  for (int j = 0; j < n; j++) {
    const double *restrict column = A + (size_t)j * (size_t)n;
    for (int i = 0; i < n; i++)
      of_row[i] = fabs(column[i]) > of_row[i] ? fabs(column[i]) : of_row[i];
    of_column[j] = largest(n, column);
  }
}

static int uneven(int n, const double *sizes)
{
  for (int i = 0; i < n; i++)
    if (sizes[i] > 256 || sizes[i] < 1.0 / 256) return 1;
  return 0;
}

/* Power of two near 1 / sqrt(size). */
static double root_scale(double size)
{
  int exponent;
  if (!(size > 0)) return 1;
  frexp(size, &exponent);
  return ldexp(1, -exponent / 2);
}

static void scale(int n, double *A, double *b, const double *by_row, const double *by_column)
{
  for (int j = 0; j < n; j++) {
    double *column = A + (size_t)j * (size_t)n;
    for (int i = 0; i < n; i++) column[i] *= by_row[i] * by_column[j];
    b[j] *= by_row[j];
  }
}

/* Ruiz (RAL-TR-2001-034): rows and columns by the root of their size, again and again. */
void nsdae_equilibrate(int n, double *A, double *b, double *row, double *column, double *work)
{
  double *by_row = work, *by_column = work + n;
  for (int i = 0; i < n; i++) row[i] = column[i] = 1;
  for (int round = 0; round < 4; round++) {
    measure(n, A, by_row, by_column);
    if (round == 0 && !uneven(n, by_row) && !uneven(n, by_column)) return;
    for (int i = 0; i < n; i++) {
      row[i] *= by_row[i] = root_scale(by_row[i]);
      column[i] *= by_column[i] = root_scale(by_column[i]);
    }
    scale(n, A, b, by_row, by_column);
  }
}
