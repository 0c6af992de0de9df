/* Matrices of three rows, row-major. */
#ifndef NSDAE_FRICTION_MATRIX3_H
#define NSDAE_FRICTION_MATRIX3_H

#include <math.h>
#include <string.h>

/* y = A x */
static inline void nsdae_apply3(const double *A, const double *x, double *y)
{
  for (int i = 0; i < 3; i++) y[i] = A[3 * i] * x[0] + A[3 * i + 1] * x[1] + A[3 * i + 2] * x[2];
}

/* C = A B */
static inline void nsdae_multiply3(const double *A, const double *B, double *C)
{
  for (int i = 0; i < 3; i++)
    for (int j = 0; j < 3; j++)
      C[3 * i + j] = A[3 * i] * B[j] + A[3 * i + 1] * B[3 + j] + A[3 * i + 2] * B[6 + j];
}

/* Gauss-Jordan elimination with row pivoting. Returns 0, or 1 if A is singular or not finite. */
static inline int nsdae_invert3(const double *A, double *inverse)
{
  double a[3][6];
  for (int i = 0; i < 3; i++)
    for (int j = 0; j < 6; j++) a[i][j] = j < 3 ? A[3 * i + j] : j == i + 3;
  for (int k = 0; k < 3; k++) {
    int p = k;
    for (int i = k + 1; i < 3; i++)
      if (fabs(a[i][k]) > fabs(a[p][k])) p = i;
    double pivot = a[p][k];
    if (!(fabs(pivot) > 0 && fabs(pivot) < INFINITY)) return 1;
    for (int j = 0; j < 6; j++) {
      double held = a[p][j] / pivot;
      a[p][j] = a[k][j];
      a[k][j] = held;
    }
    for (int i = 0; i < 3; i++) {
      double factor = a[i][k];
      for (int j = 0; j < 6 && i != k; j++) a[i][j] -= factor * a[k][j];
    }
  }
  for (int i = 0; i < 9; i++) inverse[i] = a[i / 3][3 + i % 3];
  return 0;
}

#endif
