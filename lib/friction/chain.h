/* The chain on one island: one stage after the other until the residual is below the tolerance. */
#ifndef NSDAE_FRICTION_CHAIN_H
#define NSDAE_FRICTION_CHAIN_H

#include "anderson.h"
#include "continuation.h"
#include "infeasible.h"
#include "polyhedral.h"
#include "precise.h"
#include "region.h"

typedef struct nsdae_fc_chain {
  nsdae_fc fc;
  const nsdae_friction_options *options;
  nsdae_friction_info info; /* of this island */
  double tol;
  double *best; /* 3 n: the point of least residual so far */
  double *low;  /* 3 n: what that does not hold of a solution in two parts */
  double *trap; /* 3 n: where a warm start got stuck, and its residual: no other stage sees it */
  double trapped;
  double *slip; /* n: see coulomb.h */
  nsdae_fc_anderson anderson;
  nsdae_fc_newton newton;
  nsdae_fc_curve curve;
  nsdae_fc_precise precise;
  nsdae_fc_polyhedral polyhedral;
  nsdae_fc_proof *proof;   /* the solver's, kept between calls */
  double *l;               /* m of the whole: where a proof goes */
  nsdae_fc_matrix *matrix; /* the solver's, kept between calls */
  nsdae_fc_region *region; /* the same; NULL: none are taken by themselves */
  int analysed;            /* 1: matrix is ready for this island; -1: no memory for it */
  int held;                /* a solution in two parts is known, and one does not hold it */
  int lost;                /* no memory for what a stage needed */
  int spent;               /* Newton steps over the whole island */
  int patient;             /* the last resort may take its minute */
  int twice;               /* the caller takes a solution in two parts */
} nsdae_fc_chain;

/* Takes the arrays of the chain and its island. */
void nsdae_fc_chain_layout(void *chain, nsdae_arena *arena);

/* Solves the island from chain->fc.r; the answer is in chain->best and chain->info; where that is
 * infeasible, in chain->l. */
void nsdae_fc_chain_run(nsdae_fc_chain *chain);

#endif
