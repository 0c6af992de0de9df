/* The equations of a step of Newton's method or of an interior point, over one island:
 *
 *   E dr + A (J^T J) dr = b       (local form: E dr + A W dr = b)
 *
 * with E and A of 3 x 3 blocks by item. In velocities they are sparser than in impulses,
 *
 *   (1 + J K J^T) dy = J E^-1 b,   K = E^-1 A,   dr = E^-1 b - K J^T dy,
 *
 * with the graph of blocks of y that share an item; the local form has that of W, or where it is
 * small is dense. */
#ifndef NSDAE_FRICTION_MATRIX_H
#define NSDAE_FRICTION_MATRIX_H

#include "fronts.h"
#include "island.h"

typedef struct nsdae_fc_matrix {
  const nsdae_fc *fc;
  nsdae_fronts fronts;
  int dense_always; /* local forms of any size */
  int dense;        /* this one: lu [9 n^2], column-major, and pivot [3 n] are for it */
  double *lu;
  int *pivot;
  size_t pairs; /* of blocks that share an item, in both directions and with themselves */
  int *first;   /* blocks + 1: the graph; local form: items */
  int *index;
  int *other;        /* work of its construction: lists before they are sorted */
  int *at;           /* blocks + 1: where those lists begin */
  size_t *place;     /* pairs: of their blocks in the matrix, item by item */
  double *E, *K;     /* 9 n: E as given; K, of the local form A */
  double *E_inverse; /* 9 n */
  double *dy, *rhs;  /* ny; 3 n */
  nsdae_arena memory;
} nsdae_fc_matrix;

/* Prepares for the island; the analysis is kept while its graph is the same. NSDAE_OK or
 * NSDAE_E_MEMORY. */
int nsdae_fc_matrix_analyse(nsdae_fc_matrix *m, const nsdae_fc *fc);

/* Factors; E and A [9 n] row-major, A NULL: ones. With symmetric, E is symmetric positive definite
 * and A is NULL. Returns 0, or > 0 where it is singular. */
int nsdae_fc_matrix_factor(nsdae_fc_matrix *m, const double *E, const double *A, int symmetric);

/* dr [3 n] of b [3 n]. */
void nsdae_fc_matrix_solve(nsdae_fc_matrix *m, const double *b, double *dr);

void nsdae_fc_matrix_release(nsdae_fc_matrix *m);

#endif
