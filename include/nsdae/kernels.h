/* nsdae: kernels on plain arrays. BSD-3-Clause.
 *
 * The conventions are LAPACK's: column-major arrays with a leading dimension, no allocation, no
 * state. The return value is info:
 *
 * - 0: success
 * - -i: argument i is invalid; nothing was done
 * - > 0: see the function
 *
 * lwork = -1 is a workspace query: work[0] returns the size. */
#ifndef NSDAE_KERNELS_H
#define NSDAE_KERNELS_H

#include <nsdae/version.h>

#ifdef __cplusplus
extern "C" {
#endif

/* Natural residual of a point x of the complementarity problem y = A x + b, x >= 0, y >= 0, with
 * x'y = 0. It is scaled row by row, so that a large entry cannot hide an error in another row:
 *
 *   residual = max_i |min(x_i / sx_i, y_i / sy_i)|
 *   sy_i = min(|b_i| + sum_j |a_ij x_j|, 1e6 max_k |b_k|) + 1e-3 max_k |b_k|,
 *   sx_i = min_k sy_k / |a_ki| over a_ki != 0
 *
 * - sy_i is the magnitude that the rounding error of y_i is relative to.
 * - Its last term is the accuracy of the data. Entries of b are differences of values of similar
 *  size. A row whose terms are all of rounding size therefore has no error.
 * - Terms above 1e6 max_k |b_k| do not increase sy_i, and such a row is summed in double-double
 *  arithmetic. Otherwise rounding would hide b, and a long null vector of A would be accepted as a
 *  solution.
 * - x_i is negligible if its column changes no row.
 *
 * Rows should have similar scales (nsdae_lcp_solve equilibrates); columns need not.
 *
 *   n         >= 0
 *   a [lda,n] A, lda >= max(1, n)
 *   b, x [n]
 *   y [n]     out: A x + b
 *   residual  out; NaN if A, b or x has a NaN or an infinity, or y overflows
 *   work [n]  out: sy
 *
 * info 1: the residual is NaN. */
NSDAE_API int nsdae_dlcpres(int n, const double *a, int lda, const double *b, const double *x,
                            double *y, double *residual, double *work);

/* Lemke's method with lexicographic pivoting (Cottle, Pang, Stone, "The Linear Complementarity
 * Problem", 1992, sections 4.4 and 4.9). The problem is not scaled; scale it before the call.
 *
 *   n, a, lda, b   as above; a and b finite
 *   d [n]          covering vector, every entry > 0 and finite; NULL: ones
 *   max_pivots     >= 0
 *   x [n]          out: the solution
 *   basis [n]      out: 1 if x_i is basic, else 0
 *   pivots         out: number of pivots
 *   work [lwork]   lwork >= n (n + 2), or -1. With the size that -1 returns, pivots of large
 *                  problems are delayed and applied as one matrix product (several times faster)
 *   iwork [2 n + 1]
 *
 * If info > 0, x is not a solution. info 1: secondary ray; 2: max_pivots reached; 3: overflow. */
NSDAE_API int nsdae_dlemke(int n, const double *a, int lda, const double *b, const double *d,
                           int max_pivots, double *x, int *basis, int *pivots, double *work,
                           int lwork, int *iwork);

/* Projected Gauss-Seidel, with relaxation projected SOR (Cryer, SIAM J. Control 9 (1971) 385;
 * Cottle, Pang, Stone, chapter 5). A sweep is
 *
 *   x_i := max(0, x_i - omega (A x + b)_i / a_ii),   i = 1 .. n
 *
 * It converges for every omega in (0, 2) if A is symmetric positive definite.
 *
 *   n, a, lda, b   as above; a and b finite
 *   omega          relaxation, > 0 and < 2; 1: Gauss-Seidel
 *   tol            >= 0: sweeps end if the residual of nsdae_dlcpres is <= tol
 *   max_iter       >= 0
 *   x [n]          in: start, finite; negative entries are used as zero. out: last iterate
 *   iterations     out: number of sweeps
 *   residual       out: residual of x
 *   work [lwork]   lwork >= 2 n, or -1
 *
 * If info > 0, x is not a solution. info 1: max_iter reached; 2: a diagonal entry is not > 0
 * (nothing was done); 3: overflow of the iterates. */
NSDAE_API int nsdae_dlcppgs(int n, const double *a, int lda, const double *b, double omega,
                            double tol, int max_iter, double *x, int *iterations, double *residual,
                            double *work, int lwork);

/* Principal pivoting for P-matrices (all principal minors > 0), which include all positive definite
 * matrices, symmetric or not. Indices whose x_i or y_i is negative change sides:
 *
 * - Block pivoting changes all of them while their number decreases (Kostreva, Linear Algebra Appl.
 *  21 (1978) 213; Judice and Pires, Comput. Oper. Res. 21 (1994) 587).
 * - Otherwise only the least index changes, which makes the method finite (Murty, Linear Algebra
 *  Appl. 9 (1974) 65; Cottle, Pang, Stone, section 4.2).
 *
 * Each change is one factorisation of the active block A_FF; usually few are needed.
 *
 *   n, a, lda, b   as above; a and b finite
 *   tol            >= 0: the method ends if the residual of nsdae_dlcpres is <= tol
 *   block          >= 0: block changes in a row that may fail to reduce the number of indices;
 *                  then single changes begin. Usually 10; 0: single changes only (Murty's method)
 *   max_pivots     >= 0: maximum number of changes
 *   x [n]          out: the solution
 *   basis [n]      in: start, 1 for x_i > 0, else 0 (all 0 if nothing is known); out: basis of x
 *   pivots         out: number of changes
 *   residual       out: residual of x
 *   work [lwork]   lwork >= n (n + 2), or -1
 *   iwork [2 n]
 *
 * If info > 0, x is not a solution. info 1: a block is singular, or no entry is negative but the
 * residual is above tol (A is no P-matrix, or nearly none); 2: max_pivots reached. */
NSDAE_API int nsdae_dlcpppm(int n, const double *a, int lda, const double *b, double tol, int block,
                            int max_pivots, double *x, int *basis, int *pivots, double *residual,
                            double *work, int lwork, int *iwork);

/* Enumeration of all 2^n active sets F: A_FF x_F = -b_F, all other entries zero (Cottle, Pang,
 * Stone, section 1.3: a complementary basic solution). The time is O(2^n n^3).
 *
 *   n              0 .. 20
 *   a, lda, b      as above; a and b finite
 *   tol            >= 0: bound on the residual of nsdae_dlcpres
 *   set            in: first active set, bit i - 1 for x_i; 0 for all; <= 2^n. out: the first set
 *                  with a solution, else 2^n. A call with set + 1 continues with the next one
 *   x [n]          out: the solution
 *   residual       out: residual of x; without a solution the least of all sets
 *   work [lwork]   lwork >= n (n + 2), or -1
 *   iwork [3 n]
 *
 * If info > 0, x is not a solution:
 *
 * - 1: no solution, and all A_FF are regular. If set was 0, the problem has no solution.
 * - 2: no solution found, but some A_FF is singular to rounding; its solutions, if any, are not
 *  found. */
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
 *   mu [nc]     coefficients of friction, >= 0 and finite; ignored if rows is 1
 *
 * The residual is that of nsdae_friction_residual, with d_c the mean diagonal entry of W of contact
 * c and s = max |q| (1 if that is zero):
 *
 *   x = r d_c / s,  y = (u + mu |u_T| e_N) / s,  residual = max |x - P_K(x - y)|
 *
 * nsdae_dfcres computes the residual of a point. a and q may have entries that are not finite.
 *
 *   r [m]       the point
 *   u [m]       out: its velocities, summed in double-double arithmetic
 *   residual    out
 *
 * info 1: the residual is NaN (a value is not finite, or overflow). */
NSDAE_API int nsdae_dfcres(int nc, const int *rows, const double *a, int lda, const double *q,
                           const double *mu, const double *r, double *u, double *residual);

/* One contact, solved exactly: open (r = 0, if q_N >= 0), stick (u = 0) or slip. For slip a
 * bracketed secant method finds |u_T| / |r_T| (lib/friction/kernels/one_contact.c).
 *
 *   rows        1, 2 or 3
 *   a, lda, q   as above; finite, W positive definite
 *   mu          >= 0 and finite
 *   r, u [rows] out: the solution and its velocities
 *   residual    out: residual of nsdae_dfcres
 *
 * info 1: W is not positive definite (nothing was done); 2: overflow. */
NSDAE_API int nsdae_dfccon(int rows, const double *a, int lda, const double *q, double mu,
                           double *r, double *u, double *residual);

/* Block Gauss-Seidel: each sweep solves every contact exactly, the others fixed (Jourdan, Alart,
 * Jean, Comput. Methods Appl. Mech. Eng. 155 (1998) 31). Convergence is not guaranteed, and slow if
 * W is singular; low accuracy takes few sweeps.
 *
 *   nc .. mu    as above; finite, diagonal blocks positive definite
 *   tol         >= 0: sweeps end if the residual of nsdae_dfcres is <= tol
 *   max_iter    >= 0
 *   r [m]       in: start, finite; out: last iterate
 *   iterations  out: number of sweeps
 *   residual    out: residual of r
 *   work [lwork]  lwork >= m + 12 nc, or -1
 *
 * If info > 0, r is not a solution. info 1: max_iter reached; 2: a diagonal block is not positive
 * definite (nothing was done); 3: overflow of the iterates. */
NSDAE_API int nsdae_dfcbgs(int nc, const int *rows, const double *a, int lda, const double *q,
                           const double *mu, double tol, int max_iter, double *r, int *iterations,
                           double *residual, double *work, int lwork);

/* Semismooth Newton method on the natural map of all contacts (Qi and Sun, Math. Program. 58 (1993)
 * 353). A proximal term alpha d_c (r - z), z the previous iterate, keeps the equations regular if W
 * is singular and vanishes at a solution (Rockafellar, SIAM J. Control Optim. 14 (1976) 877). There
 * is no line search: near a solution a few steps suffice, far from it the method may diverge. Start
 * it from the result of sweeps.
 *
 *   nc .. mu    as above; finite
 *   alpha       >= 0; 0: Newton's method; 1e-10 suffices if W is singular
 *   tol         >= 0: the method ends if the residual of nsdae_dfcres is <= tol
 *   max_iter    >= 0: maximum number of steps, each one factorisation of m rows
 *   r [m]       in: start, finite; out: the iterate of least residual
 *   iterations  out: number of steps
 *   residual    out: residual of r
 *   work [lwork]  lwork >= m (m + 3), or -1
 *   iwork [m]
 *
 * If info > 0, r is not a solution. info 1: max_iter reached; 2: singular equations; 3: overflow.
 */
NSDAE_API int nsdae_dfcnwt(int nc, const int *rows, const double *a, int lda, const double *q,
                           const double *mu, double alpha, double tol, int max_iter, double *r,
                           int *iterations, double *residual, double *work, int lwork, int *iwork);

#ifdef __cplusplus
}
#endif
#endif
