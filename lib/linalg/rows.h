/* Rows by blocks: a row of Phi_q, or a direction of a contact, touches a few blocks of v and has
 * dense values there. A row of a dense matrix is one that touches the one block. */
#ifndef NSDAE_LINALG_ROWS_H
#define NSDAE_LINALG_ROWS_H

#include "blocks.h"

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
