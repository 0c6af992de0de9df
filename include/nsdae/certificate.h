/* nsdae: what a solver says of a problem. BSD-3-Clause.
 *
 * One set of words for complementarity problems (lcp.h) and for friction (friction.h). "Solved" is
 * said of a point whose residual, computed afresh from the data, is below the tolerance, and never
 * because an algorithm came to its end; "infeasible" is said with a proof; all else is "unsolved".
 */
#ifndef NSDAE_CERTIFICATE_H
#define NSDAE_CERTIFICATE_H

#include <nsdae/version.h>

#ifdef __cplusplus
extern "C" {
#endif

/* What is known of a problem after the chain. */
enum nsdae_outcome {
  NSDAE_OUTCOME_UNSOLVED = 0,  /* no stage found a solution; nothing is proved */
  NSDAE_OUTCOME_SOLVED = 1,    /* residual below tolerance, computed afresh from the data */
  NSDAE_OUTCOME_INFEASIBLE = 2 /* proved: there is no solution */
};

/* What proves that there is no solution. */
enum nsdae_proof {
  NSDAE_PROOF_NONE = 0,
  NSDAE_PROOF_FARKAS = 1,    /* a vector that separates the data from all that have a solution; it
                                is handed over, see there */
  NSDAE_PROOF_ENUMERATED = 2 /* every choice of which of x_i and y_i is zero is excluded, by a
                                vector of that kind each */
};

/* Their names ("solved", "farkas"); "unknown" for any other value. */
NSDAE_API const char *nsdae_outcome_name(int outcome);
NSDAE_API const char *nsdae_proof_name(int proof);

#ifdef __cplusplus
}
#endif
#endif
