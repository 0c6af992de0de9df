/* Loops over short vectors. */
#ifndef NSDAE_BASE_VECTOR_H
#define NSDAE_BASE_VECTOR_H

#include <math.h>
#include <stddef.h>

/* sum + a . b, in this order */
static inline double nsdae_dot_from(double sum, int n, const double *a, const double *b)
{
  for (int i = 0; i < n; i++) sum += a[i] * b[i];
  return sum;
}

static inline double nsdae_dot(int n, const double *a, const double *b)
{
  return nsdae_dot_from(0, n, a, b);
}

static inline int nsdae_fewer(int a, int b)
{
  return a < b ? a : b;
}

/* fmax of a number, most, and of what may be none; of two zeros the first. */
static inline double nsdae_larger(double most, double a)
{
  return a > most ? a : most;
}

/* max |a_i|, and sqrt(sum a_i^2) of a few; four at a time, for the latency of a comparison. */
static inline double nsdae_largest(int n, const double *a)
{
  double most[4] = {0};
  int i = 0;
  for (; i + 4 <= n; i += 4)
    for (int k = 0; k < 4; k++) most[k] = nsdae_larger(most[k], fabs(a[i + k]));
  for (; i < n; i++) most[0] = nsdae_larger(most[0], fabs(a[i]));
  return nsdae_larger(nsdae_larger(most[0], most[1]), nsdae_larger(most[2], most[3]));
}

/* Whether all are finite: a finite sum has finite terms; where it overflows they are looked at.
 * Sums side by side, for the latency of an addition. */
static inline int nsdae_all_finite(size_t n, const double *a)
{
  enum { SUMS = 16 };
  double sum = 0, of[SUMS] = {0};
  size_t i = 0;
  for (; i + SUMS <= n; i += SUMS)
    for (size_t k = 0; k < SUMS; k++) of[k] += a[i + k];
  for (size_t k = 0; i > 0 && k < SUMS; k++) sum += of[k];
  for (; i < n; i++) sum += a[i];
  if (isfinite(sum)) return 1;
  while (n > 0 && isfinite(a[n - 1])) n--;
  return n == 0;
}

static inline double nsdae_norm(int n, const double *a)
{
  double norm = 0;
  for (int i = 0; i < n; i++) norm = hypot(norm, a[i]);
  return norm;
}

/* y += scale x */
static inline void nsdae_add(int n, double scale, const double *x, double *y)
{
  for (int i = 0; i < n; i++) y[i] += scale * x[i];
}

/* sum += to - from */
static inline void nsdae_add_change(int n, const double *from, const double *to, double *sum)
{
  for (int i = 0; i < n; i++) sum[i] += to[i] - from[i];
}

/* to = from + scale x */
static inline void nsdae_move(int n, const double *restrict from, double scale,
                              const double *restrict x, double *restrict to)
{
  for (int i = 0; i < n; i++) to[i] = from[i] + scale * x[i];
}

/* to += share (from - to) */
static inline void nsdae_blend(int n, double share, const double *from, double *to)
{
  for (int i = 0; i < n; i++) to[i] += share * (from[i] - to[i]);
}

/* y [rows] += A [rows x columns] x */
static inline void nsdae_add_product(int rows, int columns, const double *A, const double *x,
                                     double *y)
{
  for (int j = 0; j < columns; j++, A += rows) nsdae_add(rows, x[j], A, y);
}

/* y [columns] += scale A [rows x columns]^T x */
static inline void nsdae_add_transposed(int rows, int columns, double scale, const double *A,
                                        const double *x, double *y)
{
  for (int j = 0; j < columns; j++)
    y[j] += scale * nsdae_dot(rows, A + (size_t)j * (size_t)rows, x);
}

/* Largest difference relative to 1 + max |a|; NaN where there is one. */
static inline double nsdae_relative_change(int n, const double *a, const double *b)
{
  double most = 0, size = 1;
  for (int i = 0; i < n; i++) {
    double difference = fabs(a[i] - b[i]);
    if (!(difference <= most)) most = difference;
    size = nsdae_larger(size, 1 + fabs(a[i]));
  }
  return most / size;
}

#endif
