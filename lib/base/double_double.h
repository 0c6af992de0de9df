/* Sums of products in twice the precision (Dekker, Numer. Math. 18 (1971) 224; Ogita, Rump, Oishi,
 * SIAM J. Sci. Comput. 26 (2005) 1955). Where bodies are stacked, impulses are larger by far than
 * the momentum that their sum leaves, and their rounding would be the velocity's error. */
#ifndef NSDAE_BASE_DOUBLE_DOUBLE_H
#define NSDAE_BASE_DOUBLE_DOUBLE_H

#include <math.h>

#include "dispatch.h"

/* fma() is a call where the processor that is compiled for need not have it, and one instruction
 * where the one that runs does; either rounds alike. */
#define NSDAE_DD_DISPATCH(f, body, parameters, arguments) \
  NSDAE_DISPATCH("fma", f, body, parameters, arguments)

/* high + low += a b */
NSDAE_INLINED void nsdae_dd_add(double a, double b, double *high, double *low)
{
  double p = a * b, sum = *high + p, part = sum - *high;
  *low += fma(a, b, -p) + ((*high - (sum - part)) + (p - part));
  *high = sum;
}

/* y [rows] += A [rows x columns] x, low [rows]: the trailing part */
NSDAE_INLINED void nsdae_dd_add_product(int rows, int columns, const double *restrict A,
                                        const double *restrict x, double *restrict high,
                                        double *restrict low)
{
  for (int j = 0; j < columns; j++, A += rows) {
    if (x[j] == 0) continue;
    if (rows == 6) /* a body: laid out flat */
      for (int i = 0; i < 6; i++) nsdae_dd_add(A[i], x[j], high + i, low + i);
    else
      for (int i = 0; i < rows; i++) nsdae_dd_add(A[i], x[j], high + i, low + i);
  }
}

#endif
