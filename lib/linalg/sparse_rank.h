/* Inside of sparse_kkt.h: the rank of the rows, and the multipliers of redundant ones. */
#ifndef NSDAE_LINALG_SPARSE_RANK_H
#define NSDAE_LINALG_SPARSE_RANK_H

#include "sparse_schur.h"

/* Factors S and finds the rank; NSDAE_OK or NSDAE_E_NONFINITE. */
int nsdae_sparse_kkt_find_rank(nsdae_sparse_kkt *kkt);

/* Factors S of the rows that keep has, see nsdae_sparse_kkt_factor_in. */
int nsdae_sparse_kkt_keep_rank(nsdae_sparse_kkt *kkt, const double *keep);

/* Whether the row of the part was dropped. */
int nsdae_sparse_kkt_is_dropped(const nsdae_sparse_kkt *kkt, int row);

/* Whether the equations of the dropped rows agree with the others, of the residual d. */
int nsdae_sparse_kkt_consistent(const nsdae_sparse_kkt *kkt);

/* l := of least norm with the same J^T l, up to rounding. */
void nsdae_sparse_kkt_shorten(const nsdae_sparse_kkt *kkt);

#endif
