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
 * x'y = 0, scaled by the data, row by row, so that no large entry hides an error elsewhere:
 *
 *   residual = max_i |min(x_i / sx_i, y_i / sy_i)|
 *   sy_i = |b_i| + sum_j |a_ij x_j| + 1e-3 max_k |b_k|,   sx_i = min_k sy_k / |a_ki| over a_ki != 0
 *
 * sy_i is what the rounding of y_i is relative to; its last term says how exact the data are:
 * entries of b come from differences of values of their common size, so that a row in which all is
 * of rounding size has no error of its own. x_i is negligible when its column changes no row. Rows
 * should be scaled alike (nsdae_lcp_solve equilibrates); columns need not.
 *
 *   n         >= 0
 *   a [lda,n] A, lda >= max(1, n)
 *   b, x [n]
 *   y [n]     out: A x + b
 *   residual  out; NaN where A, b or x has one
 *   work [n]                                                                                */
NSDAE_API int nsdae_dlcpres(int n, const double *a, int lda, const double *b, const double *x,
                            double *y, double *residual, double *work);

/* Lemke's method with lexicographic pivoting (Cottle, Pang, Stone, "The Linear Complementarity
 * Problem", 1992, sections 4.4 and 4.9) on the problem as it is given: scale it before.
 *
 *   n, a, lda, b   as above
 *   d [n]          covering vector, every entry > 0; NULL: ones
 *   max_pivots     >= 0
 *   x [n]          out: the solution
 *   basis [n]      out: 1 where x_i is basic, else 0
 *   pivots         out: their number
 *   work [lwork]   lwork >= n (n + 2), or -1; with what that asks for the pivots of large problems
 *                  are put off and applied as one matrix product, which is several times faster
 *   iwork [2 n + 1]
 * info -2, -4, -5: also for an entry of A, b, d that is not finite; 1: ended on a secondary ray;
 * 2: max_pivots reached; 3: overflow. x is after 1, 2 and 3 not a solution. */
NSDAE_API int nsdae_dlemke(int n, const double *a, int lda, const double *b, const double *d,
                           int max_pivots, double *x, int *basis, int *pivots, double *work,
                           int lwork, int *iwork);

#ifdef __cplusplus
}
#endif
#endif
