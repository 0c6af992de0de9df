/* Inside of sparse_kkt.h: the rank of the rows, and the multipliers of redundant ones. */
#ifndef NSDAE_LINALG_SPARSE_RANK_H
#define NSDAE_LINALG_SPARSE_RANK_H

#include "sparse_kkt.h"

/* Factors S and finds the rank; NSDAE_OK or NSDAE_E_NONFINITE. */
int nsdae_sparse_kkt_find_rank(nsdae_sparse_kkt *kkt);

/* Whether the row, of the part and of this node, was dropped. */
int nsdae_sparse_kkt_is_dropped(const nsdae_sparse_kkt *kkt, int node, int row);

/* Whether the equations of the dropped rows agree with the others, of the residual d. */
int nsdae_sparse_kkt_consistent(const nsdae_sparse_kkt *kkt);

/* l := of least norm with the same J^T l, up to rounding. */
void nsdae_sparse_kkt_shorten(nsdae_sparse_kkt *kkt);

/* out [rows] = J x, or Y^T x */
void nsdae_sparse_kkt_times(const nsdae_sparse_kkt *kkt, const double *J, const double *x,
                            double *out);

/* out [nv] += scale J^T l, or Y l; size, if not NULL, += |J^T| |l| */
void nsdae_sparse_kkt_add_transposed(const nsdae_sparse_kkt *kkt, const double *J, double scale,
                                     const double *l, double *out, double *size);

/* h [rows] := S^-1 h, zero in dropped rows. */
void nsdae_sparse_kkt_solve_schur(nsdae_sparse_kkt *kkt, double *h);

#endif
