/* The Schur complement of sparse_kkt.h and the products with its factors:
 *
 *     M = L L^T,   Y = L^-1 J^T,   S = Y^T Y. */
#ifndef NSDAE_LINALG_SPARSE_SCHUR_H
#define NSDAE_LINALG_SPARSE_SCHUR_H

#include "symbolic.h"
#include "rows.h"
#include "multifrontal.h"

/* Part of a system: these of its blocks and rows. The rows touch no other blocks. */
typedef struct nsdae_kkt_part {
  const nsdae_blocks *blocks;
  const nsdae_rows *J;
  int block_count, row_count;
  const int *block, *row;
} nsdae_kkt_part;

/* The pattern of the last analysis as one list: counts of blocks and rows, sizes of the blocks, of
 * each row how many blocks it touches and which. */
typedef struct nsdae_kkt_pattern {
  int *list;
  int used, room;
  int *number;        /* blocks of the system: in the part */
  nsdae_arena memory; /* of all that the part alone decides */
} nsdae_kkt_pattern;

/* Consecutive rows that touch the same blocks are one node of the graph of S. */
typedef struct nsdae_kkt_nodes {
  int count;
  int *row, *part, *size; /* count + 1: first row, first part; count: rows */
  int *block;             /* parts: the block that they touch */
  size_t *at;             /* parts: their values, row by row */
  int *of_row;            /* rows: the node */
  int parts;
  size_t values; /* of J */
} nsdae_kkt_nodes;

/* Of the part, its blocks and rows one behind the other. */
typedef struct nsdae_kkt_values {
  nsdae_blocks blocks;
  double *M, *L, *J, *Y; /* as above */
  double *x, *r, *g;     /* by blocks: solution, right-hand side, residual */
  double *z, *size;      /* the last correction of x; sizes of the terms of g */
  double *l, *c, *d, *h; /* by rows, likewise */
  double *u, *p;         /* rows: work */
} nsdae_kkt_values;

/* Of the rows, by the last factorisation. */
typedef struct nsdae_kkt_rank {
  int count;
  int chosen;        /* by the caller */
  int dependent;     /* the first row of the system that is dropped */
  double kept, left; /* smallest sine that counts, largest that does not; 1, 0: none */
} nsdae_kkt_rank;

/* The whole matrix with its couplings, see sparse_rank.c. Nodes are the blocks, then the nodes of
 * rows. */
typedef struct nsdae_kkt_whole {
  nsdae_multifrontal fronts;
  int ready, count;  /* pairs */
  int *pair;         /* 2 count */
  double *value;     /* of the pairs */
  int *size;         /* nodes */
  int *edge, *begin; /* pairs of neighbours; where each begins */
  nsdae_adjacency graph;
  int *left_out; /* rows: not of the basis */
  double *x;     /* order */
  nsdae_arena arena;
} nsdae_kkt_whole;

typedef struct nsdae_sparse_kkt {
  double rank_tol; /* set before; likewise */
  int spare;       /* likewise, see kkt.h */
  double enough;   /* the relative error at which refinement may end; 0: as far as it falls */
  int ready, coupled;
  int pivot, bad_block; /* the pivot of this block of the system is not positive */
  nsdae_kkt_rank rank;
  nsdae_kkt_part part;
  nsdae_kkt_pattern pattern;
  nsdae_kkt_nodes nodes;
  nsdae_kkt_values at;
  nsdae_adjacency graph; /* of the nodes */
  nsdae_multifrontal schur;
  nsdae_kkt_whole whole;
} nsdae_sparse_kkt;

/* Forms L and Y. NSDAE_OK or NSDAE_E_MASS, see pivot. */
int nsdae_sparse_kkt_transform_rows(nsdae_sparse_kkt *kkt, const double *M);

/* Forms L, Y and S, which is not factored. NSDAE_OK or NSDAE_E_MASS, see pivot. */
int nsdae_sparse_kkt_form_schur(nsdae_sparse_kkt *kkt, const double *M);

/* out [rows] = J x, or Y^T x */
void nsdae_sparse_kkt_times(const nsdae_sparse_kkt *kkt, const double *J, const double *x,
                            double *out);

/* out [nv] += scale J^T l, or Y l; size, if not NULL, += |J^T| |l| */
void nsdae_sparse_kkt_add_transposed(const nsdae_sparse_kkt *kkt, const double *J, double scale,
                                     const double *l, double *out, double *size);

/* ---- the rank of the rows, and the multipliers of redundant ones (sparse_rank.c) */

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

/* ---- the whole matrix (sparse_rank.c) */

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
