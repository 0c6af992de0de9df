/* Sums of products in twice the precision (Dekker, Numer. Math. 18 (1971) 224; Ogita, Rump, Oishi,
 * SIAM J. Sci. Comput. 26 (2005) 1955). Where bodies are stacked, impulses are larger by far than
 * the momentum that their sum leaves, and their rounding would be the velocity's error. */
#ifndef NSDAE_FRICTION_TWICE_H
#define NSDAE_FRICTION_TWICE_H

#include <math.h>

/* high + low += a b */
static inline void nsdae_twice_add(double a, double b, double *high, double *low)
{
  double p = a * b, sum = *high + p, part = sum - *high;
  *low += fma(a, b, -p) + ((*high - (sum - part)) + (p - part));
  *high = sum;
}

/* y [rows] += A [rows x columns] x, with low [rows] what high does not hold */
static inline void nsdae_twice_add_product(int rows, int columns, const double *A, const double *x,
                                           double *high, double *low)
{
  for (int j = 0; j < columns; j++)
    for (int i = 0; i < rows && x[j] != 0; i++)
      nsdae_twice_add(A[j * rows + i], x[j], high + i, low + i);
}

#endif
