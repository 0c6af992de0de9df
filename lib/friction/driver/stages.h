/* The solvers of an island in the order of one table (stages.c). */
#ifndef NSDAE_FRICTION_STAGES_H
#define NSDAE_FRICTION_STAGES_H

#include "solver_contract.h"

/* An island on its way through the table. */
typedef struct nsdae_fc_run {
  nsdae_fc_island island;
  nsdae_fc_iterate iterate;
  nsdae_fc_budget budget; /* of the whole run */
  const nsdae_friction_options *options;
  nsdae_friction_info info; /* of this island */
  double *guess;            /* 3 n: the best point from the guess */
  double guessed;           /* and the residual there; INFINITY: it is not put aside */
  int has_guess;            /* the iterate is the guess, or was found from it */
  double first;             /* residual after the first sweeps; INFINITY: none were done */
  double refined;           /* least residual that iterative refinement has begun at */
  int islands;              /* of the problem */
  int stage;                /* under way */
  int lost;                 /* a solver had no memory */
} nsdae_fc_run;

/* Takes the arrays of the run and its island. */
void nsdae_fc_run_layout(void *run, nsdae_arena *arena);

/* Solves the island from island.fc.r. iterate has the best point, info its outcome; if infeasible,
 * island.proof the proof. NSDAE_OK, NSDAE_E_MEMORY or NSDAE_E_INTERRUPTED. */
int nsdae_fc_run_stages(nsdae_fc_run *run);

#endif
