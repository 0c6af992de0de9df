/* The saddle-point matrix of a constrained system,
 *
 *     [ M      Phi_q^T ] [ x ]   [ r ]
 *     [ Phi_q  0       ] [ l ] = [ c ]
 *
 * M = L L^T,  Y = L^-1 Phi_q^T,  S = Y^T Y = Phi_q M^-1 Phi_q^T  (the Schur complement)
 * z = L^-1 r,  S l = Y^T z - c,  x = L^-T (z - Y l)
 *
 * Everything above this folder is written with these calls; P = x(r) with c = 0 is the projector
 * of the contact problem. Where S is near singular, the rank r comes from QR with column pivoting
 * of the columns of Y at unit length, Y = Q R N with N = diag(lengths). For consistent equations
 *
 *   R_11^T w = (N^-1 (Y^T z - c)) at the r pivot columns,   x = L^-T (z - Q w),   R N l = w
 *
 * with l of least norm from (R N)^T = Z T:  l = Z T^-T w. Nothing is squared, so that the units of
 * the constraints do not matter. */
#ifndef NSDAE_LINALG_KKT_H
#define NSDAE_LINALG_KKT_H

#include "arena.h"

/* The rank-revealing factorisation. */
typedef struct nsdae_kkt_pivoted {
  double *Q;          /* n x m: Q of the pivoted QR; R_11 is in S then */
  double *Z, *T;      /* m x rank, rank x rank (leading dimension m) */
  double *tau, *norm; /* min(n, m), m */
  int *column;        /* m: column order of the QR */
  int *held;          /* m: 1 for each constraint that it found independent */
  int *order;         /* m: constraints by decreasing length, the order of the rows of Z */
} nsdae_kkt_pivoted;

typedef struct nsdae_kkt {
  int n, m;
  double rank_tol;   /* sine of the angle below which a constraint depends on the others */
  int rank;          /* of the last factorisation */
  double kept, left; /* smallest such sine that counts in it, largest that does not; 1, 0: none */
  int pivot;         /* of M that failed, from 1 */
  int diagonal;      /* M is, as often in absolute coordinates: no product is spent on it */
  int factored_by_rank; /* the last factorisation is the rank-revealing one */
  int hold;          /* the independent constraints of the factorisation before stay, if they can */
  double *L, *Y, *S; /* n x n, n x m, m x m */
  nsdae_kkt_pivoted pivoted;
  double *work; /* m: one right-hand side; lwork: LAPACK's */
  int lwork;
} nsdae_kkt;

/* Takes the arrays; n, m and rank_tol are set before. */
void nsdae_kkt_layout(nsdae_kkt *kkt, nsdae_arena *arena);

/* Factors M [n x n] (its lower triangle) and Phi_q = J [m x n]. NSDAE_OK, also with rank < m: the
 * caller decides what that means; NSDAE_E_MASS: M is not positive definite, see pivot. */
int nsdae_kkt_factor(nsdae_kkt *kkt, const double *M, int ldm, const double *J, int ldj);

/* R [n x nrhs] := x, C [m x nrhs] := l. */
void nsdae_kkt_solve(const nsdae_kkt *kkt, int nrhs, double *R, int ldr, double *C, int ldc);

/* Of a deficient rank: B [m x m] := Z Z^T, the projector to the independent combinations of the
 * constraints, and trace(B Z Z^T), the dimension that a B has in common with the one of now. */
void nsdae_kkt_range(const nsdae_kkt *kkt, double *B);
double nsdae_kkt_common(const nsdae_kkt *kkt, const double *B);

/* l [m] := of least norm with the same J^T l; J as it was factored, r [n]: room. */
void nsdae_kkt_least_norm(const nsdae_kkt *kkt, const double *J, double *l, double *r);

/* r [n] := M^-1 r, as if there were no constraints. */
void nsdae_kkt_solve_mass(const nsdae_kkt *kkt, double *r);

#endif
