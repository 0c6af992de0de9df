/* Rows by blocks: a row of Phi_q, or a direction of a contact, touches a few blocks of v and has
 * dense values there. A row of a dense matrix is one that touches the one block. */
#ifndef NSDAE_LINALG_ROWS_H
#define NSDAE_LINALG_ROWS_H

#include <stddef.h>

/* A partition of v into blocks, by default one of all nv, and block diagonal
 * matrices over it: dense blocks, column-major, one after another. */

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

typedef struct nsdae_rows {
  int count;
  int *first;    /* count + 1: parts of each row */
  int *block;    /* of a part */
  size_t *at;    /* of a part: where its values begin */
  size_t stride; /* from a value to the next */
  double *value;
} nsdae_rows;

/* sum + row_i . x, in this order */
static inline double nsdae_rows_add_dot(const nsdae_blocks *blocks, const nsdae_rows *rows, int i,
                                        const double *x, double sum)
{
  for (int p = rows->first[i]; p < rows->first[i + 1]; p++) {
    int b = rows->block[p];
    const double *value = rows->value + rows->at[p];
    for (int j = blocks->first[b]; j < blocks->first[b + 1]; j++, value += rows->stride)
      sum += *value * x[j];
  }
  return sum;
}

/* row_i . x */
static inline double nsdae_rows_dot(const nsdae_blocks *blocks, const nsdae_rows *rows, int i,
                                    const double *x)
{
  return nsdae_rows_add_dot(blocks, rows, i, x, 0);
}

/* y [nv] += scale row_i */
static inline void nsdae_rows_add(const nsdae_blocks *blocks, const nsdae_rows *rows, int i,
                                  double scale, double *y)
{
  for (int p = rows->first[i]; p < rows->first[i + 1]; p++) {
    int b = rows->block[p];
    const double *value = rows->value + rows->at[p];
    for (int j = blocks->first[b]; j < blocks->first[b + 1]; j++, value += rows->stride)
      y[j] += *value * scale;
  }
}

/* Row i over the blocks with place[b] >= 0, where their velocities begin in out; stride: from an
 * entry of out to the next. out comes zeroed. */
void nsdae_rows_gather(const nsdae_blocks *blocks, const nsdae_rows *rows, int i, const int *place,
                       double *out, size_t stride);

/* Largest entry of a row, row_i . x (x NULL: ones), and the sum of its entries, all in absolute
 * values. */
double nsdae_rows_largest(const nsdae_blocks *blocks, const nsdae_rows *rows, int i);
double nsdae_rows_dot_sizes(const nsdae_blocks *blocks, const nsdae_rows *rows, int i,
                            const double *x);
static inline double nsdae_rows_sum(const nsdae_blocks *blocks, const nsdae_rows *rows, int i)
{
  return nsdae_rows_dot_sizes(blocks, rows, i, NULL);
}

#endif
