/* What the kernels ask of their arrays before they start. */
#ifndef NSDAE_LCP_FINITE_H
#define NSDAE_LCP_FINITE_H

#include <math.h>
#include <stddef.h>

/* Whether A [rows x columns] is there and has neither NaN nor infinity. */
static inline int nsdae_lcp_finite(int rows, int columns, const double *A, int lda)
{
  if (rows > 0 && columns > 0 && !A) return 0;
  for (int j = 0; j < columns; j++)
    for (int i = 0; i < rows; i++)
      if (!isfinite(A[(size_t)j * (size_t)lda + (size_t)i])) return 0;
  return 1;
}

#endif
