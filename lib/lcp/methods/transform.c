/* Cottle, Pang, Stone, "The Linear Complementarity Problem", 1992, section 2.3. Column by column: a
 * column (A_B, A_N) that stays becomes (-X, A_N - A_NB X) with X = A_BB^-1 A_B, one that changes
 * places (X, A_NB X) with X = A_BB^-1 e_k. */
#include "lcp_methods.h"

#include <stddef.h>

#include "active_set.h"
#include "dense.h"
#include "vector.h"

int nsdae_lcp_transform(int n, const double *A, const double *b, const int *basis, double *T,
                        double *t, double *work, int *pivot, int *index)
{
  double *lu = work, *part = work + (size_t)n * (size_t)n;
  int size = nsdae_lcp_gather(n, A, n, basis, lu, index);
  if (nsdae_la_lu(size, lu, size, pivot) != 0) return 1;
  for (int j = 0; j <= n; j++) {
    const double *from = j < n ? A + (size_t)j * (size_t)n : b;
    double *out = j < n ? T + (size_t)j * (size_t)n : t;
    int changes = j < n && basis[j];
    double sign = changes ? 1 : -1;
    for (int k = 0; k < size; k++) part[k] = changes ? index[k] == j : from[index[k]];
    nsdae_la_lu_solve(size, lu, size, pivot, part); /* X */
    for (int i = 0; i < n; i++) out[i] = changes ? 0 : from[i];
    for (int k = 0; k < size; k++)
      nsdae_add(n, sign * part[k], A + (size_t)index[k] * (size_t)n, out);
    for (int k = 0; k < size; k++) out[index[k]] = sign * part[k];
  }
  return 0;
}
