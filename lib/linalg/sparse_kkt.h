/* The saddle-point equations of kkt.h if they are large and sparse: M by blocks, Phi_q by rows,
 * over the blocks of one part of a system.
 *
 *     [ M   J^T ] [ x ]   [ r ]      M = L L^T,  Y = L^-1 J^T,  S = Y^T Y,
 *     [ J   0   ] [ l ] = [ c ]      S l = Y^T z - c,  x = L^-T (z - Y l),  z = L^-1 r
 *
 * S has an entry for every two rows that share a block. It is ordered by AMD (symbolic.h) and
 * factored by the multifrontal method (multifrontal.h). All rows follow their blocks in this
 * elimination, so that the pivots of M are positive and no regularisation is needed. Iterative
 * refinement against M and J.
 *
 * Rank: the pivot of a row, divided by S_ii, is the squared sine of the angle between the row and
 * those eliminated before it. A row with a sine of at most max(rank_tol, 1e-6) is redundant; it is
 * dropped. l is then of least norm. */
#ifndef NSDAE_LINALG_SPARSE_KKT_H
#define NSDAE_LINALG_SPARSE_KKT_H

#include "sparse_schur.h"

/* Analyses the part; its lists must last until the solution. Returns at once if the pattern is that
 * of the last call. Only this function allocates; a struct of zeros has no memory. NSDAE_OK or
 * NSDAE_E_MEMORY. */
int nsdae_sparse_kkt_analyse(nsdae_sparse_kkt *kkt, const nsdae_kkt_part *part);

/* Factors with M and the present values of J. NSDAE_OK for every rank; NSDAE_E_MASS (see pivot),
 * NSDAE_E_NONFINITE. */
int nsdae_sparse_kkt_factor(nsdae_sparse_kkt *kkt, const double *M);

/* The same with the rows that have keep[row of the part] = 1, NULL: all, without a decision about
 * the rank. NSDAE_E_CONVERGENCE if they are dependent here. */
int nsdae_sparse_kkt_factor_in(nsdae_sparse_kkt *kkt, const double *M, const double *keep);

/* keep [rows] := 1 for each that counts in the last factorisation, else 0; and how many of those
 * with keep 1 count. */
void nsdae_sparse_kkt_kept(const nsdae_sparse_kkt *kkt, double *keep);
int nsdae_sparse_kkt_common(const nsdae_sparse_kkt *kkt, const double *keep);

/* v [nv] and lambda [m] of the blocks and rows of the part: lambda holds c on entry and l on
 * return, v holds x on return. NSDAE_OK: the residual of M x + J^T l = r and that of J x = c are
 * each at most 1e-12, or `enough`, of the largest sum of absolute terms (x as the terms it is a sum
 * of); redundant rows hold up to their sine, those outside of a choice need not. Else
 * NSDAE_E_CONVERGENCE. */
int nsdae_sparse_kkt_solve(const nsdae_sparse_kkt *kkt, const double *r, double *v, double *lambda);

/* v := M^-1 v, of the blocks of the part. */
void nsdae_sparse_kkt_solve_mass(const nsdae_sparse_kkt *kkt, double *v);

void nsdae_sparse_kkt_release(nsdae_sparse_kkt *kkt);

#endif
