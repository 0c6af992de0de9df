/* The chain on one island: one stage after the other until the residual is below the tolerance. */
#ifndef NSDAE_FRICTION_CHAIN_H
#define NSDAE_FRICTION_CHAIN_H

#include "anderson.h"
#include "continuation.h"
#include "infeasible.h"
#include "interior.h"
#include "polyhedral.h"
#include "precise.h"

/* A tolerance that sweeps are likely to reach: asked for as 1e-6, less what rounding may take. */
#define NSDAE_FC_ROUGH 0.99e-6

/* What is nearly solved: the last digits are looked at closely. */
#define NSDAE_FC_NEARLY 1e-6

/* What the solver keeps from one call to the next. */
typedef struct nsdae_fc_kept {
  nsdae_fc_proof *proof;
  nsdae_fc_matrix *matrix;
} nsdae_fc_kept;

/* What has been found out about the island so far. */
typedef struct nsdae_fc_seen {
  double trapped; /* residual where a warm start got stuck */
  double looked;  /* least residual that nsdae_fc_arrived has looked at closely */
  double crept;   /* and from which it has crept on in two parts */
  int analysed;   /* 1: matrix is ready for this island; -1: no memory for it */
  int lost;       /* no memory for what a stage needed */
  int slides;     /* a few sweeps left little: most of it slides */
  int held;       /* a solution in two parts is known, and one does not hold it */
  int spent;      /* Newton steps over the whole island, */
  int creeping;   /* and those of them that crept */
} nsdae_fc_seen;

/* Of a walk of such shifts (conic.c): */
typedef struct nsdae_fc_walked {
  double *point;            /* 3 n: the solution of its convex problem, */
  double *calm;             /* 3 n: and of those the one of least residual */
  double *drift;            /* n: by how much the shift of a convex problem was off */
  nsdae_fc_anderson shifts; /* extrapolates those that go through the middle */
} nsdae_fc_walked;

typedef struct nsdae_fc_chain {
  nsdae_fc fc;
  const nsdae_friction_options *options;
  nsdae_friction_info info; /* of this island */
  double tol;
  int patient;  /* the last resort may take its time */
  int twice;    /* the caller takes a solution in two parts */
  double *best; /* 3 n: the point of least residual so far */
  double *low;  /* 3 n: what that does not hold of a solution in two parts */
  double *trap; /* 3 n: where a warm start got stuck: no other stage sees it */
  double *slip; /* n: see coulomb.h */
  nsdae_fc_walked walked;
  double *l; /* m of the whole: where a proof goes */
  nsdae_fc_anderson anderson;
  nsdae_fc_newton newton;
  nsdae_fc_curve curve;
  nsdae_fc_interior interior;
  nsdae_fc_precise precise;
  nsdae_fc_polyhedral polyhedral;
  nsdae_fc_kept kept;
  nsdae_fc_seen seen;
} nsdae_fc_chain;

/* The size of r */
static inline size_t nsdae_fc_bytes(const nsdae_fc_chain *c)
{
  return 3 * (size_t)c->fc.n * sizeof(double);
}

/* Takes the arrays of the chain and its island. */
void nsdae_fc_chain_layout(void *chain, nsdae_arena *arena);

/* Of a stage, each from chain->fc.r on unless it says otherwise, and at the best point or where it
 * ended. Those that return an int: whether the island is solved. */

/* r = 0. */
void nsdae_fc_start_cold(nsdae_fc_chain *chain);

/* Keeps fc.r where it is better than all before. */
int nsdae_fc_judge(nsdae_fc_chain *chain, int stage);

/* Sweeps, looked at now and then. With patience > 0 they end where so many have not halved the
 * residual. */
int nsdae_fc_sweeps(nsdae_fc_chain *chain, int most, int patience, int stage);

/* Whether there are factorisations for this island: then chain->newton begins anew. */
int nsdae_fc_ready(nsdae_fc_chain *chain);

/* Counts the steps of chain->newton, and judges where it ended. */
int nsdae_fc_count(nsdae_fc_chain *chain, int stage);

/* Proximal points from the best point so far, at most so many steps, as long as none of its
 * problems fails; 0: as many as one attempt has. */
int nsdae_fc_try_proximal(nsdae_fc_chain *chain, double alpha, int most, int stage);

/* Along the path, cold, and proximal points from its end on. */
int nsdae_fc_try_path(nsdae_fc_chain *chain, double loose, int stage);

/* What a sweep costs, in items of two bodies. */
double nsdae_fc_work(const nsdae_fc_chain *chain);

/* Whether the residual is what rounding r to doubles leaves. */
int nsdae_fc_exhausted(const nsdae_fc_chain *chain);

/* Solves the island from chain->fc.r; the answer is in chain->best and chain->info; where that is
 * infeasible, in chain->l. */
void nsdae_fc_chain_run(nsdae_fc_chain *chain);

#endif
