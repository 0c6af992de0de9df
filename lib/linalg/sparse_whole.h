/* Inside of sparse_kkt.h: blocks that are coupled, so that the Schur complement of their rows is
 * dense. The whole matrix is factored,
 *
 *     [ A   J^T                       ]
 *     [ J   -eps diag(J diag(A)^-1 J^T) ]      diag(A): blocks
 *
 * which is quasi-definite for eps > 0: it has factors L S L^T, with signs S by rows, in every order
 * (Vanderbei, SIAM J. Optim. 5 (1995) 100). Rows are eliminated after one of their blocks, so that
 * their pivots are seldom as small as eps. */
#ifndef NSDAE_LINALG_SPARSE_WHOLE_H
#define NSDAE_LINALG_SPARSE_WHOLE_H

#include "sparse_schur.h"

/* nsdae_sparse_kkt_factor_in with A and couplings, of blocks in the part's numbers; A is positive
 * definite or NSDAE_E_MASS (see pivot, 0 if it is of no block alone). NSDAE_E_MEMORY, if the pairs
 * are new. */
int nsdae_sparse_kkt_factor_coupled(nsdae_sparse_kkt *kkt, const double *A,
                                    const nsdae_coupling *coupling, const double *keep);

/* g += the products of the couplings with x. */
void nsdae_sparse_whole_add_product(const nsdae_sparse_kkt *kkt, const double *x, double *g);

/* z and h of the part := the solution of its g and d. */
void nsdae_sparse_whole_solve(const nsdae_sparse_kkt *kkt);

#endif
