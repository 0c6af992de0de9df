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

#include "kkt.h"

void nsdae_dense_kkt_layout(nsdae_kkt *kkt, nsdae_arena *arena);
int nsdae_dense_kkt_factor(nsdae_kkt *kkt, const double *M, const nsdae_rows *J);
int nsdae_dense_kkt_factor_in(nsdae_kkt *kkt, const double *M, const nsdae_rows *J,
                              const double *basis, int rank);
void nsdae_dense_kkt_solve(const nsdae_kkt *kkt, int nrhs, double *R, int ldr, double *C, int ldc);
void nsdae_dense_kkt_solve_mass(const nsdae_kkt *kkt, double *r);
void nsdae_dense_kkt_basis(const nsdae_kkt *kkt, double *B);
double nsdae_dense_kkt_common(const nsdae_kkt *kkt, const double *B);

#endif
