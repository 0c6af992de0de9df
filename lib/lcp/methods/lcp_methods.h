/* The stages that look for a solution: each returns whether the chain ends with it. */
#ifndef NSDAE_LCP_METHODS_H
#define NSDAE_LCP_METHODS_H

#include "work.h"

/* Lemke's method with the covering vector of ones, and with others. */
int nsdae_lcp_try_lemke(nsdae_lcp_work *w);
int nsdae_lcp_try_coverings(nsdae_lcp_work *w);

/* Lemke's method with this covering vector (NULL: ones), not judged: w->x and w->room.trial are its
 * end, returned is what nsdae_dlemke returns. */
int nsdae_lcp_lemke_once(nsdae_lcp_work *w, const double *cover, int *pivots);

/* Damped Newton on the semismooth equations, for a large problem from a few starts, and from all.
 */
int nsdae_lcp_try_newton(nsdae_lcp_work *w);
int nsdae_lcp_try_further(nsdae_lcp_work *w);

/* x [n]: entries in (0, 1] from a linear congruential generator (Knuth's MMIX), always the same
 * ones for the same seed, which goes on. */
static inline void nsdae_lcp_scatter(int n, double *x, unsigned long long *seed)
{
  for (int i = 0; i < n; i++) {
    *seed = *seed * 6364136223846793005ull + 1442695040888963407ull;
    x[i] = ((double)(*seed >> 40) + 1) / 16777216.0;
  }
}

/* ---- damped Newton on the semismooth equations of Fischer and Burmeister */

enum { NSDAE_FISCHER_MEMORY = 10 };

/* ---- the principal pivot transform of a problem */

#endif
