/* The saddle-point equations of kkt.h if they are large and sparse: M and D by blocks, Phi_q by
 * rows, over the blocks of one part of a system.
 *
 *     [ M + D    J^T ] [ x ]   [ r ]      M + D = L L^T,  Y = L^-1 J^T,  S = Y^T Y,
 *     [ J        0   ] [ l ] = [ c ]      S l = Y^T z - c,  x = L^-T (z - Y l),  z = L^-1 r
 *
 * S has an entry for every two rows that share a block. It is ordered by AMD (symbolic.h) and
 * factored by SuiteSparse's LDL (sparse_ldl.h) or by the multifrontal method (multifrontal.h),
 * by predicted operations. All rows follow their blocks in this elimination, so that the pivots of
 * M + D are positive and no regularisation is needed. Iterative refinement against M + D and J.
 *
 * Rank: the pivot of a row, divided by S_ii, is the squared sine of the angle between the row and
 * those eliminated before it. A row with a sine of at most max(rank_tol, 1e-6) is redundant; it is
 * dropped, by the multifrontal method. l is then of least norm. */
#ifndef NSDAE_LINALG_SPARSE_KKT_H
#define NSDAE_LINALG_SPARSE_KKT_H

#include "sparse_schur.h"

/* Analyses the part; its lists must last until the solution. Returns at once if the pattern is that
 * of the last call. Only this function allocates; a struct of zeros has no memory. NSDAE_OK or
 * NSDAE_E_MEMORY. */
int nsdae_sparse_kkt_analyse(nsdae_sparse_kkt *kkt, const nsdae_kkt_part *part);

/* Factors with M and D, both block diagonal (D NULL: none), and the present values of J. NSDAE_OK
 * for every rank; NSDAE_E_MASS (see pivot), NSDAE_E_NONFINITE. */
int nsdae_sparse_kkt_factor(nsdae_sparse_kkt *kkt, const double *M, const double *D);

/* v [nv] and lambda [m] of the blocks and rows of the part: lambda holds c on entry and l on
 * return, v holds x on return. NSDAE_OK: the residual of M x + J^T l = r and that of J x = c are
 * each at most 1e-12 of the largest sum of absolute terms; redundant rows hold up to their sine.
 * Else NSDAE_E_CONVERGENCE. */
int nsdae_sparse_kkt_solve(nsdae_sparse_kkt *kkt, const double *r, double *v, double *lambda);

void nsdae_sparse_kkt_release(nsdae_sparse_kkt *kkt);

#endif
