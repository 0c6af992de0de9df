/* The stages that look for a solution: each returns whether the chain ends with it. */
#ifndef NSDAE_LCP_METHODS_H
#define NSDAE_LCP_METHODS_H

#include "work.h"

/* b >= 0, and the caller's active set. */
int nsdae_lcp_try_trivial(nsdae_lcp_work *w);
int nsdae_lcp_try_warm(nsdae_lcp_work *w);

/* Lemke's method with the covering vector of ones, and with others. */
int nsdae_lcp_try_lemke(nsdae_lcp_work *w);
int nsdae_lcp_try_coverings(nsdae_lcp_work *w);

/* Lemke's method with the vector of ones, not judged: w->x and w->room.trial are its end, returned
 * is what nsdae_dlemke returns. */
int nsdae_lcp_lemke_once(nsdae_lcp_work *w, int *pivots);

/* Damped Newton on the semismooth equations, for a large problem from a few starts, and from all.
 */
int nsdae_lcp_try_newton(nsdae_lcp_work *w);
int nsdae_lcp_try_further(nsdae_lcp_work *w);

#endif
