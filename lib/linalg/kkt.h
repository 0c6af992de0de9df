/* The saddle-point matrix of a constrained system,
 *
 *     [ M      Phi_q^T ] [ x ]   [ r ]
 *     [ Phi_q  0       ] [ l ] = [ c ]
 *
 * with M by blocks and Phi_q = J by rows over them. Everything above this folder is written with
 * these calls; P = x(r) with c = 0 is the projector of the contact problem. Two methods: LAPACK
 * on dense arrays of one block or of few velocities and rows, else sparse factors
 * (sparse_kkt.h). Both use the Schur complement S = J M^-1 J^T, and both find the rank of J: a row
 * depends on others if the sine of its angle to them, in the metric of M^-1, is at most rank_tol.
 * l is of least norm then, and the equations must be consistent. Where the constraints do not hold,
 * a dependent row has a sine as large as they are off: spare is how many were dependent where they
 * do, and those of the smallest sines do not count. */
#ifndef NSDAE_LINALG_KKT_H
#define NSDAE_LINALG_KKT_H

#include "sparse_kkt.h"

/* The saddle-point equations of kkt.h in dense arrays:
 *
 *     M = L L^T,  Y = L^-1 J^T,  S = Y^T Y
 *     z = L^-1 r,  S l = Y^T z - c,  x = L^-T (z - Y l)
 *
 * Where S is near singular, the rank r comes from QR with column pivoting of the columns of Y at
 * unit length, Y = Q R N with N = diag(lengths). For consistent equations
 *
 *     R_11^T w = (N^-1 (Y^T z - c)) at the r pivot columns,   x = L^-T (z - Q w),   R N l = w
 *
 * with l of least norm from (R N)^T = Z T:  l = Z T^-T w. Nothing is squared, so that the units of
 * the constraints do not matter. */

/* The rank-revealing factorisation. */
typedef struct nsdae_kkt_pivoted {
  double *Q;          /* n x m: Q of the pivoted QR; R_11 is in S then */
  double *Z, *T;      /* m x rank, rank x rank (leading dimension m); T of a basis m x m */
  double *tau, *norm; /* min(n, m), m */
  int *column;        /* m: column order of the QR */
  int *held;          /* m: 1 for each constraint that it found independent; where some are spare
                         set before */
  int *order;         /* m: constraints by decreasing length, the order of the rows of Z */
} nsdae_kkt_pivoted;

typedef struct nsdae_dense_kkt {
  int diagonal;      /* M is, as often in absolute coordinates: no product is spent on it */
  int form;          /* of the last factorisation, see kkt.c */
  double *L, *Y, *S; /* n x n, n x m, m x min(m, n) */
  nsdae_kkt_pivoted pivoted;
  double *work; /* 2 m: of one right-hand side; lwork: LAPACK's */
  int lwork;
} nsdae_dense_kkt;

typedef struct nsdae_kkt {
  int n, m; /* of blocks and rows; those of the layout are the most */
  const nsdae_blocks *blocks;
  double rank_tol;
  int spare;         /* set before: the number of rows known not to count; those that are held
                        stay, if they can (dense) */
  int rank;          /* of the last factorisation */
  double kept, left; /* smallest such sine that counts in it, largest that does not; 1, 0: none */
  int dependent;     /* the first row that does not count */
  int pivot;         /* of M that failed, from 1 */
  int is_sparse;     /* by the layout */
  int typical;       /* one more than the rows that there are mostly, without a basis; 0: m */
  int *each;         /* 0, 1, ...: sparse lists of all blocks and rows */
  nsdae_dense_kkt dense;
  nsdae_sparse_kkt sparse;
} nsdae_kkt;

/* Takes the arrays; n, m, blocks and rank_tol are set before. The sparse factors have memory
 * of their own, to be released. */
void nsdae_kkt_layout(nsdae_kkt *kkt, nsdae_arena *arena);
/* The same for problems of different sizes, of a system of this number of rows, of which
 * nsdae_kkt_reserve may be asked for all; then one of them, of these blocks. */
void nsdae_kkt_layout_most(nsdae_kkt *kkt, int rows, nsdae_arena *arena);
void nsdae_kkt_turn_to(nsdae_kkt *kkt, const nsdae_blocks *blocks, int n, int m);
void nsdae_kkt_release(nsdae_kkt *kkt);

/* Sparse, memory of the analysis of these rows, which that of a part of them finds there: NSDAE_OK
 * or NSDAE_E_MEMORY. A part needs more only if its order of elimination fills more. */
int nsdae_kkt_reserve(nsdae_kkt *kkt, const nsdae_rows *J);

/* Factors M (its lower triangles) and J [m rows]. NSDAE_OK, also with rank < m: the caller decides
 * what that means; NSDAE_E_MASS: M is not positive definite, see pivot. Sparse, also
 * NSDAE_E_NONFINITE, and NSDAE_E_MEMORY if the pattern of J is new. */
int nsdae_kkt_factor(nsdae_kkt *kkt, const double *M, const nsdae_rows *J);

/* R [n x nrhs] := x, C [m x nrhs] := l. NSDAE_OK; sparse, NSDAE_E_CONVERGENCE if the equations do
 * not hold to 1e-12, or `enough` if that is larger, of their terms. */
int nsdae_kkt_solve(const nsdae_kkt *kkt, int nrhs, double *R, int ldr, double *C, int ldc);

/* r [n] := M^-1 r, as if there were no constraints. */
void nsdae_kkt_solve_mass(const nsdae_kkt *kkt, double *r);

/* l [m] := of least norm with the same J^T l; J as it was factored, r [n]: room. A status as
 * nsdae_kkt_solve. */
int nsdae_kkt_least_norm(const nsdae_kkt *kkt, const nsdae_rows *J, double *l, double *r);

/* ---- one choice of independent rows for many factorisations */

/* The independent combinations of the rows as numbers: dense, the projector Z Z^T to them [m x m];
 * sparse, 1 for each row that counts [m]. The size is known before the layout. */
long nsdae_kkt_basis_size(const nsdae_kkt *kkt);
void nsdae_kkt_basis(const nsdae_kkt *kkt, double *basis);

/* Of the last factorisation and a basis, the dimension that their combinations have in common. */
double nsdae_kkt_common(const nsdae_kkt *kkt, const double *basis);

/* Factors A + coupling (NULL: none) as M, which is positive definite, else NSDAE_E_MASS (sparse:
 * pivot 0 if no block of A alone tells), and the combinations of a basis of this rank,
 * Z^T J x = Z^T c and l = Z mu, without a decision about the rank, dense, sines below 3e-6 damped;
 * basis NULL: all rows. NSDAE_E_CONVERGENCE if they are dependent here. With a coupling, sparse, l
 * is zero in rows outside of the basis, a new pattern of pairs may be NSDAE_E_MEMORY, and
 * nsdae_kkt_solve_mass does not follow. */
int nsdae_kkt_factor_coupled(nsdae_kkt *kkt, const double *A, const nsdae_coupling *coupling,
                             const nsdae_rows *J, const double *basis, int rank);

#endif
