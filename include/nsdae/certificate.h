/* nsdae: outcome and proof of a solve. BSD-3-Clause.
 *
 * Shared by complementarity problems (lcp.h) and frictional contact problems (friction.h).
 *
 * - solved: the residual, recomputed from the data, is below the tolerance
 * - infeasible: a proof of infeasibility exists
 * - unsolved: neither */
#ifndef NSDAE_CERTIFICATE_H
#define NSDAE_CERTIFICATE_H

#include <nsdae/version.h>

#ifdef __cplusplus
extern "C" {
#endif

/* Outcome of a solve. */
enum nsdae_outcome {
  NSDAE_OUTCOME_UNSOLVED = 0,  /* no solver found a solution; nothing is proved */
  NSDAE_OUTCOME_SOLVED = 1,    /* residual below the tolerance, recomputed from the data */
  NSDAE_OUTCOME_INFEASIBLE = 2 /* proved: no solution exists */
};

/* Proofs of infeasibility. */
enum nsdae_proof {
  NSDAE_PROOF_NONE = 0,
  NSDAE_PROOF_FARKAS = 1,    /* Farkas vector: it separates the data from all data with a
                                solution; the solver returns it */
  NSDAE_PROOF_ENUMERATED = 2 /* every choice of zero entries (x_i or y_i) is excluded by its own
                                Farkas vector */
};

/* Names ("solved", "farkas"); "unknown" for any other value. */
NSDAE_API const char *nsdae_outcome_name(int outcome);
NSDAE_API const char *nsdae_proof_name(int proof);

#ifdef __cplusplus
}
#endif
#endif
