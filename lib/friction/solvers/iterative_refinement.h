/* The memory of iterative refinement: a point in double-double arithmetic. */
#ifndef NSDAE_FRICTION_ITERATIVE_REFINEMENT_H
#define NSDAE_FRICTION_ITERATIVE_REFINEMENT_H

#include "scaled_island.h"

typedef struct nsdae_fc_refinement {
  double *high, *low;      /* 3 n: the point, its leading and its trailing parts */
  double *best, *best_low; /* 3 n: the best one */
  double *q;          /* 3 n: that of the island, replaced while it is solved for a correction */
  double *correction; /* 3 n: the iterate of a correction */
} nsdae_fc_refinement;

/* Takes the arrays. */
void nsdae_fc_refinement_layout(nsdae_fc_refinement *refinement, const nsdae_fc_scaled *fc,
                                nsdae_arena *arena);

#endif
