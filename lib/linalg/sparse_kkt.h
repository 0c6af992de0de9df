/* The saddle-point equations of kkt.h where they are large and sparse: M by blocks, Phi_q by rows,
 * over the blocks of one part. By the method of multipliers (Hestenes, J. Optim. Theory Appl. 4
 * (1969) 303), which of linear equations is refinement: with the residuals g = r - M x - J^T l and
 * d = c - J x,
 *
 *   (M + s J^T J) y = g + s J^T d,   x += y,   l += s (J y - d),   until they no longer fall.
 *
 * The matrix is positive definite whatever the rank of J, and sparse where few blocks share a row;
 * l is in the range of J, the least of those that serve. A round multiplies d by about 1 / (s |S|),
 * S = J M^-1 J^T, and leaves no more of g than rounding. */
#ifndef NSDAE_LINALG_SADDLE_H
#define NSDAE_LINALG_SADDLE_H

#include "multifrontal.h"
#include "rows.h"

typedef struct nsdae_sparse_kkt {
  nsdae_multifrontal fronts;
  int blocks, rows, parts, order; /* room */
  int *number;                    /* blocks of the system: in the part */
  int *size, *begin;              /* blocks of the part; their first entry in x */
  int *first, *index, *mark;      /* the graph of blocks that share a row */
  int index_room;
  int *by_block, *of_block; /* rows that touch a block */
  double *x, *g, *rest;     /* nv: of the part, by blocks; nv; 3 rows: c, l, d */
} nsdae_sparse_kkt;

/* v [nv] and lambda [m] of the blocks and rows listed: on entry lambda holds c and r the right-hand
 * side, on return v x and lambda l. NSDAE_OK; NSDAE_E_MEMORY, NSDAE_E_MASS, NSDAE_E_CONVERGENCE. */
int nsdae_sparse_kkt_solve(nsdae_sparse_kkt *saddle, const nsdae_blocks *blocks,
                           const nsdae_rows *J, const double *M, int block_count, const int *block,
                           int row_count, const int *row, const double *r, double *v,
                           double *lambda);
void nsdae_sparse_kkt_release(nsdae_sparse_kkt *saddle);

#endif
