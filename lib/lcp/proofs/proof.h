/* Proofs that a problem has no solution, and what a ray of Lemke's method proves. */
#ifndef NSDAE_PROOF_H
#define NSDAE_PROOF_H

#include "work.h"

/* Largest problem for which a separating vector is looked for. */
enum { NSDAE_PROOF_MAX = 400 };

/* Stage NSDAE_LCP_PROVE. Returns whether the chain has ended: proved, or a solution found by the
 * way. */
int nsdae_lcp_prove(nsdae_lcp_work *w);

/* Every choice of active sets, cut short where a partial one is proved empty. Returns as above. */
int nsdae_lcp_prove_all(nsdae_lcp_work *w);

/* Largest problem whose ray is looked at. */
enum { NSDAE_RAY_MAX = 60 };

/* Sets info->ray from the basis in w->trial, on which Lemke's method with the covering vector of
 * ones ended without a blocking row. */
void nsdae_lcp_read_ray(nsdae_lcp_work *w);

#endif
