/* The saddle-point equations of kkt.h if they are large and sparse: M and D by blocks, Phi_q by
 * rows, over the blocks of one part of a system.
 *
 *     [ M + D    J^T ] [ x ]   [ r ]      M + D = L L^T,  Y = L^-1 J^T,  S = Y^T Y,
 *     [ J        0   ] [ l ] = [ c ]      S l = Y^T z - c,  x = L^-T (z - Y l),  z = L^-1 r
 *
 * S has an entry for every two rows that share a block. It is ordered by AMD (symbolic.h) and
 * factored by SuiteSparse's LDL (sparse_ldl.h) or by the multifrontal method (multifrontal.h),
 * by predicted operations. All rows follow their blocks in this elimination, so that the pivots of
 * M + D are positive and no regularisation is needed. Iterative refinement against M + D and J.
 *
 * Rank: the pivot of a row, divided by S_ii, is the squared sine of the angle between the row and
 * those eliminated before it. A row with a sine of at most max(rank_tol, 1e-6) is redundant; it is
 * dropped, by the multifrontal method. l is then of least norm. */
#ifndef NSDAE_LINALG_SPARSE_KKT_H
#define NSDAE_LINALG_SPARSE_KKT_H

#include "rows.h"
#include "sparse_ldl.h"

/* Part of a system: these of its blocks and rows. The rows touch no other blocks. */
typedef struct nsdae_kkt_part {
  const nsdae_blocks *blocks;
  const nsdae_rows *J;
  int block_count, row_count;
  const int *block, *row;
} nsdae_kkt_part;

enum nsdae_kkt_backend { NSDAE_KKT_AUTO, NSDAE_KKT_LDL, NSDAE_KKT_SCHUR };

/* The pattern of the last analysis as one list: counts of blocks and rows, sizes of the blocks, of
 * each row how many blocks it touches and which. */
typedef struct nsdae_kkt_pattern {
  int *list, *next;        /* next: the one asked for */
  int used, room, numbers; /* numbers: room in number */
  int *number;             /* blocks of the system: in the part */
} nsdae_kkt_pattern;

/* Consecutive rows that touch the same blocks are one node of the graph of S. */
typedef struct nsdae_kkt_nodes {
  int count;
  int *row, *part, *size; /* count + 1: first row, first part; count: rows */
  int *block;             /* parts: the block that they touch */
  size_t *at;             /* parts: their values, row by row */
  int *first, *index;     /* the graph */
  int *by_block, *of_block, *mark;
  int neighbours, parts;
  size_t values; /* of J */
} nsdae_kkt_nodes;

/* Of the part, its blocks and rows one behind the other. */
typedef struct nsdae_kkt_values {
  nsdae_blocks blocks;
  double *M, *L, *J, *Y; /* M + D; as above */
  double *x, *r, *g;     /* by blocks: solution, right-hand side, residual */
  double *z, *size;      /* the last correction of x; sizes of the terms of g */
  double *l, *c, *d, *h; /* by rows, likewise */
  double *u, *p;         /* rows: work */
} nsdae_kkt_values;

/* Of the rows, by the last factorisation. */
typedef struct nsdae_kkt_rank {
  int count;
  int dependent;     /* the first row of the system that is dropped */
  double kept, left; /* smallest sine that counts, largest that does not; 1, 0: none */
} nsdae_kkt_rank;

typedef struct nsdae_sparse_kkt {
  double rank_tol; /* set before; likewise backend, for tests */
  int backend, ready;
  int ldl_first, by_ldl; /* choice of the analysis; of the last factorisation */
  int pivot, bad_block;  /* the pivot of this block of the system is not positive */
  nsdae_kkt_rank rank;
  nsdae_kkt_part part;
  nsdae_kkt_pattern pattern;
  nsdae_kkt_nodes nodes;
  nsdae_kkt_values at;
  nsdae_multifrontal schur;
  nsdae_sparse_ldl ldl;
  nsdae_arena of_part, of_graph;
} nsdae_sparse_kkt;

/* Analyses the part; its lists must last until the solution. Returns at once if the pattern is that
 * of the last call. Only this function allocates; a struct of zeros has no memory. NSDAE_OK or
 * NSDAE_E_MEMORY. */
int nsdae_sparse_kkt_analyse(nsdae_sparse_kkt *kkt, const nsdae_kkt_part *part);

/* Factors with M and D, both block diagonal (D NULL: none), and the present values of J. NSDAE_OK
 * for every rank; NSDAE_E_MASS (see pivot), NSDAE_E_NONFINITE. */
int nsdae_sparse_kkt_factor(nsdae_sparse_kkt *kkt, const double *M, const double *D);

/* v [nv] and lambda [m] of the blocks and rows of the part: lambda holds c on entry and l on
 * return, v holds x on return. NSDAE_OK: the residual of M x + J^T l = r and that of J x = c are
 * each at most 1e-12 of the largest sum of absolute terms; redundant rows hold up to their sine.
 * Else NSDAE_E_CONVERGENCE. */
int nsdae_sparse_kkt_solve(nsdae_sparse_kkt *kkt, const double *r, double *v, double *lambda);

void nsdae_sparse_kkt_release(nsdae_sparse_kkt *kkt);

#endif
