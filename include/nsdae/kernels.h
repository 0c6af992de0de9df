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
 *   sy_i = min(|b_i| + sum_j |a_ij x_j|, 1e6 max_k |b_k|) + 1e-3 max_k |b_k|,
 *   sx_i = min_k sy_k / |a_ki| over a_ki != 0
 *
 * sy_i is what the rounding of y_i is relative to; its last term says how exact the data are:
 * entries of b come from differences of values of their common size, so that a row in which all is
 * of rounding size has no error of its own. Terms larger than 1e6 max_k |b_k| count no further, and
 * such a row is summed in twice the precision: else b would vanish in their rounding, and a long
 * null vector of A pass for a solution. x_i is negligible when its column changes no row. Rows
 * should be scaled alike (nsdae_lcp_solve equilibrates); columns need not.
 *
 *   n         >= 0
 *   a [lda,n] A, lda >= max(1, n)
 *   b, x [n]
 *   y [n]     out: A x + b
 *   residual  out; NaN where A, b or x has a NaN or an infinity, or y overflows
 *   work [n]  out: sy
 * info 1: the residual is NaN. */
NSDAE_API int nsdae_dlcpres(int n, const double *a, int lda, const double *b, const double *x,
                            double *y, double *residual, double *work);

/* Lemke's method with lexicographic pivoting (Cottle, Pang, Stone, "The Linear Complementarity
 * Problem", 1992, sections 4.4 and 4.9) on the problem as it is given: scale it before.
 *
 *   n, a, lda, b   as above; a and b finite
 *   d [n]          covering vector, every entry > 0 and finite; NULL: ones
 *   max_pivots     >= 0
 *   x [n]          out: the solution
 *   basis [n]      out: 1 where x_i is basic, else 0
 *   pivots         out: their number
 *   work [lwork]   lwork >= n (n + 2), or -1; with what that asks for the pivots of large problems
 *                  are put off and applied as one matrix product, which is several times faster
 *   iwork [2 n + 1]
 * info 1: ended on a secondary ray; 2: max_pivots reached; 3: overflow. x is then not a solution.
 */
NSDAE_API int nsdae_dlemke(int n, const double *a, int lda, const double *b, const double *d,
                           int max_pivots, double *x, int *basis, int *pivots, double *work,
                           int lwork, int *iwork);

/* Projected Gauss-Seidel, with relaxation projected SOR (Cryer, SIAM J. Control 9 (1971) 385;
 * Cottle, Pang, Stone, chapter 5): sweeps over
 *
 *   x_i := max(0, x_i - omega (A x + b)_i / a_ii),   i = 1 .. n
 *
 * Converges where A is symmetric positive definite, for every omega between 0 and 2.
 *
 *   n, a, lda, b   as above; a and b finite
 *   omega          relaxation, > 0 and < 2; 1: Gauss-Seidel
 *   tol            >= 0: sweeps end once the residual of nsdae_dlcpres is not above it
 *   max_iter       >= 0
 *   x [n]          in: the start, finite; its negative entries count as zero. out: the last iterate
 *   iterations     out: sweeps done
 *   residual       out: that of x
 *   work [lwork]   lwork >= 2 n, or -1
 * info 1: max_iter reached; 2: a diagonal entry is not > 0 (nothing was done); 3: the iterates
 * overflowed. x is then not a solution. */
NSDAE_API int nsdae_dlcppgs(int n, const double *a, int lda, const double *b, double omega,
                            double tol, int max_iter, double *x, int *iterations, double *residual,
                            double *work, int lwork);

/* Principal pivoting for P-matrices (all principal minors > 0; positive definite, symmetric or
 * not, is one). Indices whose x_i or y_i is negative change sides, all at once as long as that
 * makes them fewer (block pivoting: Kostreva, Linear Algebra Appl. 21 (1978) 213; Judice and Pires,
 * Comput. Oper. Res. 21 (1994) 587), else the least of them alone (Murty, Linear Algebra Appl. 9
 * (1974) 65; Cottle, Pang, Stone, section 4.2), which makes the method finite. Each change is one
 * factorisation of the active block A_FF; few are needed as a rule.
 *
 *   n, a, lda, b   as above; a and b finite
 *   tol            >= 0: bound on the residual of nsdae_dlcpres, which ends the method
 *   block          >= 0: block changes in a row that may fail to leave fewer indices before single
 *                  ones begin, 10 as a rule; 0: single ones only, Murty's method
 *   max_pivots     >= 0: most changes
 *   x [n]          out: the solution
 *   basis [n]      in: where to start, 1 for x_i > 0, else 0 (all 0 where nothing is known);
 *                  out: that of x
 *   pivots         out: changes done
 *   residual       out: that of x
 *   work [lwork]   lwork >= n (n + 2), or -1
 *   iwork [2 n]
 * info 1: a block was singular, or nothing is negative but the residual is above tol: A is no
 * P-matrix, or too near to none; 2: max_pivots reached. x is then not a solution. */
NSDAE_API int nsdae_dlcpppm(int n, const double *a, int lda, const double *b, double tol, int block,
                            int max_pivots, double *x, int *basis, int *pivots, double *residual,
                            double *work, int lwork, int *iwork);

/* Enumeration of all 2^n active sets F: A_FF x_F = -b_F, all else zero (Cottle, Pang, Stone,
 * section 1.3: a complementary basic solution). Time goes like 2^n n^3.
 *
 *   n              0 .. 20
 *   a, lda, b      as above; a and b finite
 *   tol            >= 0: bound on the residual of nsdae_dlcpres
 *   set            in: the active set to begin with, bit i - 1 for x_i; 0 for all; <= 2^n.
 *                  out: the first one that gives a solution, else 2^n. A call with it + 1 looks
 *                  for the next solution.
 *   x [n]          out: the solution
 *   residual       out: that of x; without a solution the least of all sets
 *   work [lwork]   lwork >= n (n + 2), or -1
 *   iwork [3 n]
 * info 1: none, and all A_FF met are regular, so that, begun at 0, there is no solution; 2: none,
 * but some A_FF is singular to rounding: its solutions, if any, are not found. x is then none. */
NSDAE_API int nsdae_dlcpenum(int n, const double *a, int lda, const double *b, double tol, int *set,
                             double *x, double *residual, double *work, int lwork, int *iwork);

/* Kernels of frictional contact (nsdae/friction.h) in the local form, dense:
 *
 *   u = W r + q;  per contact  K* contains u + mu |u_T| e_N,  K = {|r_T| <= mu r_N} contains r,
 *   and their product is zero.
 *
 *   nc          contacts, >= 0
 *   rows [nc]   of each: 1 (frictionless), 2 (planar) or 3, normal first; NULL: all 3; their sum m
 *   a [lda,m]   W, symmetric positive semidefinite; lda >= max(1, m)
 *   q [m]
 *   mu [nc]     coefficients of friction, >= 0 and finite; not read where rows is 1
 *
 * With d_c the mean diagonal entry of W of contact c and s = max |q| (1 where that is zero), its
 * residual is that of nsdae_friction_residual: x = r d_c / s, y = (u + mu |u_T| e_N) / s, the
 * largest entry of |x - P_K(x - y)| over all contacts.
 *
 * nsdae_dfcres: the residual of a point. a and q may have entries that are not finite.
 *   r [m]       the point
 *   u [m]       out: its velocities, summed in twice the precision
 *   residual    out
 * info 1: the residual is NaN, for something is not finite or overflows. */
NSDAE_API int nsdae_dfcres(int nc, const int *rows, const double *a, int lda, const double *q,
                           const double *mu, const double *r, double *u, double *residual);

/* One contact, solved exactly: it opens (q_N >= 0: r = 0), sticks (u = 0) or slides, where
 * |u_T| / |r_T| is found by a bracketed secant (lib/friction/kernels/one_contact.c).
 *
 *   rows        1, 2 or 3
 *   a, lda, q   as above; finite, W positive definite
 *   mu          >= 0 and finite
 *   r, u [rows] out: the solution and its velocities
 *   residual    out: that of nsdae_dfcres
 * info 1: W is not positive definite (nothing was done); 2: overflow. */
NSDAE_API int nsdae_dfccon(int rows, const double *a, int lda, const double *q, double mu,
                           double *r, double *u, double *residual);

/* Block Gauss-Seidel: sweeps that solve each contact exactly, the others held (Jourdan, Alart,
 * Jean, Comput. Methods Appl. Mech. Eng. 155 (1998) 31). It need not converge, and where W is
 * singular does so slowly; few digits come soon.
 *
 *   nc .. mu    as above; finite, diagonal blocks positive definite
 *   tol         >= 0: sweeps end once the residual of nsdae_dfcres is not above it
 *   max_iter    >= 0
 *   r [m]       in: the start, finite; out: the last iterate
 *   iterations  out: sweeps done
 *   residual    out: that of r
 *   work [lwork]  lwork >= m + 12 nc, or -1
 * info 1: max_iter reached; 2: a diagonal block is not positive definite (nothing was done); 3: the
 * iterates overflowed. r is then not a solution. */
NSDAE_API int nsdae_dfcbgs(int nc, const int *rows, const double *a, int lda, const double *q,
                           const double *mu, double tol, int max_iter, double *r, int *iterations,
                           double *residual, double *work, int lwork);

/* Semismooth Newton on the natural map of all contacts, with a proximal term alpha d_c (r - z), z
 * the point before, that keeps the equations regular where W is not and vanishes at a solution
 * (Qi and Sun, Math. Program. 58 (1993) 353; Rockafellar, SIAM J. Control Optim. 14 (1976) 877).
 * Steps are whole: near a solution a few suffice; from far away it may not converge, so begin where
 * sweeps end.
 *
 *   nc .. mu    as above; finite
 *   alpha       >= 0; 0: Newton's method itself; 1e-10 does where W is singular
 *   tol         >= 0: ends once the residual of nsdae_dfcres is not above it
 *   max_iter    >= 0: most steps, each one factorisation of m rows
 *   r [m]       in: the start, finite; out: the point of least residual
 *   iterations  out: steps done
 *   residual    out: that of r
 *   work [lwork]  lwork >= m (m + 3), or -1
 *   iwork [m]
 * info 1: max_iter reached; 2: the equations were singular; 3: overflow. r is then not a solution.
 */
NSDAE_API int nsdae_dfcnwt(int nc, const int *rows, const double *a, int lda, const double *q,
                           const double *mu, double alpha, double tol, int max_iter, double *r,
                           int *iterations, double *residual, double *work, int lwork, int *iwork);

#ifdef __cplusplus
}
#endif
#endif
