/* The equations of a step of Newton's method or of an interior point, over one island:
 *
 *   E dr + A (J^T J) dr = b       (local form: E dr + A W dr = b)
 *
 * with E and A of 3 x 3 blocks by item. In velocities they are sparser than in impulses,
 *
 *   (1 + J K J^T) dy = J E^-1 b,   K = E^-1 A,   dr = E^-1 b - K J^T dy,
 *
 * with the graph of blocks of y that share an item; the local form has that of W, or is dense if it
 * is small or lists every pair of its items. */
#ifndef NSDAE_FRICTION_NEWTON_SYSTEM_H
#define NSDAE_FRICTION_NEWTON_SYSTEM_H

#include "symbolic.h"
#include "multifrontal.h"
#include "scaled_island.h"

typedef struct nsdae_fc_system {
  const nsdae_fc_scaled *fc;
  nsdae_multifrontal fronts;
  int dense; /* a local form with every pair listed, or small: lu [9 n^2], column-major, and
                pivot [3 n] are for it */
  double *lu;
  int *pivot;
  nsdae_adjacency graph; /* of the blocks (local form: of the items) */
  int *couple, *begin;   /* of the local form: 2 for each part, itself and its block; from where */
  size_t pairs;          /* of blocks that share an item, in both directions and with themselves */
  size_t *place;         /* pairs: of their blocks in the matrix, item by item */
  double *E, *K;         /* 9 n: E as given; K, of the local form A */
  double *E_inverse;     /* 9 n */
  double *dy;            /* ny */
  double cost;           /* of a factorisation, in multiplications by J */
  nsdae_arena memory;
} nsdae_fc_system;

/* Prepares for the island; the analysis is kept while its graph is the same. NSDAE_OK or
 * NSDAE_E_MEMORY. */
int nsdae_fc_system_analyse(nsdae_fc_system *m, const nsdae_fc_scaled *fc);

/* Factors; E and A [9 n] row-major. Returns 0, or > 0 if it is singular. */
int nsdae_fc_system_factor(nsdae_fc_system *m, const double *E, const double *A);

/* dr [3 n] of b [3 n]. */
void nsdae_fc_system_solve(nsdae_fc_system *m, const double *b, double *dr);

void nsdae_fc_system_release(nsdae_fc_system *m);

#endif
