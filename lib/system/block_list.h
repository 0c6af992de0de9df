/* Symmetric parts of D and K by blocks, summed with weights into one matrix,
 *
 *   A += scale (X + X^T) / 2,   X = D or K,
 *
 * its diagonal blocks in the layout of M, those below the diagonal over a fixed pattern of pairs of
 * blocks. A block outside of the pattern is left out, and its pair recorded for the next growth. */
#ifndef NSDAE_SYSTEM_BLOCK_LIST_H
#define NSDAE_SYSTEM_BLOCK_LIST_H

#include "system_impl.h"

/* Pairs of blocks, and for each block its neighbours in ascending order. */
typedef struct nsdae_block_pairs {
  int blocks, count;
  int *pair;             /* 2 count: i > j, in ascending order */
  size_t *at;            /* count: where the values of each begin */
  double *value;         /* of the matrix: n_i x n_j of each pair, column-major */
  size_t values;         /* their number */
  int *first;            /* blocks + 1 */
  int *neighbour, *slot; /* 2 count: the other block, the number of the pair */
  int *missing;          /* 2 room: pairs i > j outside of the pattern, some more than once */
  int missed, room;      /* of these met since the last growth, of these recorded at most */
} nsdae_block_pairs;

struct nsdae_block_list {
  const nsdae_system *system;
  const char *callback; /* for errors */
  nsdae_error *error;
  int status; /* the first refusal, with its record in error */
  double scale;
  double *diagonal;         /* of A, in the layout of M */
  nsdae_block_pairs *pairs; /* with the other blocks of A */
  const double *x; /* NULL, or nv: in place of the sum product [nv] += X x, over all blocks */
  double *product;
};

/* Of this number of blocks without pairs; the arrays are NULL before. NSDAE_OK or NSDAE_E_MEMORY.
 */
int nsdae_block_pairs_make(nsdae_block_pairs *pairs, int blocks);
void nsdae_block_pairs_release(nsdae_block_pairs *pairs);

/* The number of the pair (i, j), i != j; -1: recorded as missing. */
int nsdae_block_pairs_find(nsdae_block_pairs *pairs, int i, int j);

/* Takes the missing pairs into the pattern. The only function that allocates; NSDAE_OK or
 * NSDAE_E_MEMORY, and the pattern is as before. More may have been met than recorded: missed is not
 * zero then. */
int nsdae_block_pairs_grow(nsdae_block_pairs *pairs, const nsdae_blocks *blocks);

#endif
