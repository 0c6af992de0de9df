/* nsdae: kernels on plain arrays. BSD-3-Clause.
 *
 * LAPACK's contract: column-major arrays with a leading dimension, no allocation, no state.
 * Returned is info: 0 done, -i the i-th argument is wrong (nothing was done), > 0 as documented.
 * lwork = -1 asks for the workspace: its size comes back in work[0]. */
#ifndef NSDAE_KERNELS_H
#define NSDAE_KERNELS_H

#include <nsdae/version.h>

#ifdef __cplusplus
extern "C" {
#endif

/* Natural residual of a point x of the complementarity problem y = A x + b, x >= 0, y >= 0,
 * x'y = 0, scaled by the data:
 *
 *   residual = max_i |min(x_i / sx, y_i / sy_i)|,   sx = max_j |x_j|,
 *   sy_i = |b_i| + sx sum_j |a_ij|
 *
 * sy_i is what the rounding of y_i is relative to, so that a residual of n eps is that of an exact
 * solution of data changed by rounding. It does not change when rows of (A, b) are scaled; when
 * columns are, it does, so equilibrate first (nsdae_lcp_solve does).
 *
 *   n         >= 0
 *   a [lda,n] A, lda >= max(1, n)
 *   b, x [n]
 *   y [n]     out: A x + b
 *   residual  out; NaN where A, b or x has one                                              */
NSDAE_API int nsdae_dlcpres(int n, const double *a, int lda, const double *b, const double *x,
                            double *y, double *residual);

/* Lemke's method with lexicographic pivoting (Cottle, Pang, Stone, "The Linear Complementarity
 * Problem", 1992, sections 4.4 and 4.9) on the problem as it is given: scale it before.
 *
 *   n, a, lda, b   as above
 *   d [n]          covering vector, every entry > 0; NULL: ones
 *   max_pivots     >= 0
 *   x [n]          out: the solution
 *   basis [n]      out: 1 where x_i is basic, else 0
 *   pivots         out: their number
 *   work [lwork]   lwork >= n (n + 2), or -1
 *   iwork [2 n + 1]
 * info 1: ended on a secondary ray; 2: max_pivots reached. x is then not a solution. */
NSDAE_API int nsdae_dlemke(int n, const double *a, int lda, const double *b, const double *d,
                           int max_pivots, double *x, int *basis, int *pivots, double *work,
                           int lwork, int *iwork);

#ifdef __cplusplus
}
#endif
#endif
