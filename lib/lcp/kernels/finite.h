/* What the kernels ask of their arrays before they start. */
#ifndef NSDAE_LCP_FINITE_H
#define NSDAE_LCP_FINITE_H

#include "vector.h"

/* Whether A [rows x columns] is there and has neither NaN nor infinity. */
static inline int nsdae_lcp_finite(int rows, int columns, const double *A, int lda)
{
  if (rows <= 0 || columns <= 0) return 1;
  if (!A) return 0;
  if (lda == rows) return nsdae_all_finite((size_t)rows * (size_t)columns, A);
  for (int j = 0; j < columns; j++)
    if (!nsdae_all_finite((size_t)rows, A + (size_t)j * (size_t)lda)) return 0;
  return 1;
}

#endif
