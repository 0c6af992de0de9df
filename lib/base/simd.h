/* Sums in lanes of their own, two or four: the order of the additions, and so every bit, is what is
 * written, however many of them a processor does at once. */
#ifndef NSDAE_SIMD_H
#define NSDAE_SIMD_H

#include "dispatch.h"

typedef double nsdae_pair __attribute__((vector_size(2 * sizeof(double)), aligned(sizeof(double))));
typedef double nsdae_four __attribute__((vector_size(4 * sizeof(double)), aligned(sizeof(double))));

NSDAE_INLINED nsdae_pair nsdae_pair_of(const double *x)
{
  return *(const nsdae_pair *)x;
}

/* y += scale x, of many */
NSDAE_INLINED void nsdae_simd_add(int n, double scale, const double *x, double *y)
{
  int i = 0;
  for (; i + 4 <= n; i += 4) *(nsdae_four *)(y + i) += scale * *(const nsdae_four *)(x + i);
  for (; i < n; i++) y[i] += scale * x[i];
}

/* to = a - b, of many */
NSDAE_INLINED void nsdae_simd_subtract(int n, const double *a, const double *b, double *to)
{
  int i = 0;
  for (; i + 4 <= n; i += 4)
    *(nsdae_four *)(to + i) = *(const nsdae_four *)(a + i) - *(const nsdae_four *)(b + i);
  for (; i < n; i++) to[i] = a[i] - b[i];
}

/* a b, of many */
NSDAE_INLINED double nsdae_simd_dot(int n, const double *a, const double *b)
{
  nsdae_four s = {0}, t = {0};
  int i = 0;
  for (; i + 8 <= n; i += 8) {
    s += *(const nsdae_four *)(a + i) * *(const nsdae_four *)(b + i);
    t += *(const nsdae_four *)(a + i + 4) * *(const nsdae_four *)(b + i + 4);
  }
  s += t;
  double sum = (s[0] + s[1]) + (s[2] + s[3]);
  for (; i < n; i++) sum += a[i] * b[i];
  return sum;
}

#endif
