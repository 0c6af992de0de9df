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
#ifndef NSDAE_LINALG_DENSE_KKT_H
#define NSDAE_LINALG_DENSE_KKT_H

#include "sparse_kkt.h"

/* The rank-revealing factorisation. */
typedef struct nsdae_kkt_pivoted {
  double *Q;          /* n x m: Q of the pivoted QR; R_11 is in S then */
  double *Z, *T;      /* m x rank, rank x rank (leading dimension m); T of a basis m x m */
  double *tau, *norm; /* min(n, m), m */
  int *column;        /* m: column order of the QR */
  int *held;          /* m: 1 for each constraint that it found independent */
  int *order;         /* m: constraints by decreasing length, the order of the rows of Z */
} nsdae_kkt_pivoted;

typedef struct nsdae_dense_kkt {
  int diagonal;      /* M is, as often in absolute coordinates: no product is spent on it */
  int form;          /* of the last factorisation, see dense_kkt.c */
  double *L, *Y, *S; /* n x n, n x m, m x min(m, n) */
  nsdae_kkt_pivoted pivoted;
  double *work; /* 2 m: of one right-hand side; lwork: LAPACK's */
  int lwork;
} nsdae_dense_kkt;

typedef struct nsdae_kkt {
  int n, m; /* of blocks and rows; those of the layout are the most */
  const nsdae_blocks *blocks;
  double rank_tol;
  int hold;          /* the independent rows of the factorisation before stay, if they can: dense */
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

void nsdae_dense_kkt_layout(nsdae_kkt *kkt, nsdae_arena *arena);
int nsdae_dense_kkt_factor(nsdae_kkt *kkt, const double *M, const nsdae_rows *J);
int nsdae_dense_kkt_factor_in(nsdae_kkt *kkt, const double *A, const nsdae_coupling *coupling,
                              const nsdae_rows *J, const double *basis, int rank);
void nsdae_dense_kkt_solve(const nsdae_kkt *kkt, int nrhs, double *R, int ldr, double *C, int ldc);
void nsdae_dense_kkt_solve_mass(const nsdae_kkt *kkt, double *r);
void nsdae_dense_kkt_basis(const nsdae_kkt *kkt, double *B);
double nsdae_dense_kkt_common(const nsdae_kkt *kkt, const double *B);

#endif
