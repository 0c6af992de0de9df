/* A partition of v into blocks, by default one of all nv, and block diagonal
 * matrices over it: dense blocks, column-major, one after another. */
#ifndef NSDAE_LINALG_BLOCKS_H
#define NSDAE_LINALG_BLOCKS_H

#include <stddef.h>

typedef struct nsdae_blocks {
  int count;
  int *first;     /* count + 1: where the velocities of each begin */
  size_t *square; /* count + 1: where its entries of a matrix begin */
} nsdae_blocks;

/* Blocks below the diagonal of a symmetric matrix over the partition. */
typedef struct nsdae_coupling {
  int count;
  const int *pair;     /* 2 count: blocks i > j */
  const double *value; /* each n_i x n_j, column-major, one behind another */
} nsdae_coupling;

static inline int nsdae_blocks_size(const nsdae_blocks *blocks, int b)
{
  return blocks->first[b + 1] - blocks->first[b];
}

/* Entries of the largest square block. */
size_t nsdae_blocks_largest(const nsdae_blocks *blocks);

/* y [nv] += M x */
void nsdae_blocks_add_product(const nsdae_blocks *blocks, const double *M, const double *x,
                              double *y);

/* x^T M x */
double nsdae_blocks_square(const nsdae_blocks *blocks, const double *M, const double *x);

/* (v + u)^T (M - from) (v + u) */
double nsdae_blocks_change(const nsdae_blocks *blocks, const double *M, const double *from,
                           const double *v, const double *u);

/* A block of M factored, in an array [size x size] of its own: L L^T, or where it is diagonal, as
 * often in absolute coordinates, its diagonal. */
typedef struct nsdae_block_factor {
  int size, diagonal;
  double *L;
} nsdae_block_factor;

/* L is set before. Returns 0, or the pivot from 1 that is not positive. */
int nsdae_blocks_factor(const nsdae_blocks *blocks, int b, const double *M,
                        nsdae_block_factor *factor);
/* x [size of the block] := M_b^-1 x. */
void nsdae_blocks_solve(const nsdae_block_factor *factor, double *x);

#endif
