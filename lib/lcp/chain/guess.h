/* The problem as it is given, before the chain: b >= 0, or the active set that the caller gives. */
#ifndef NSDAE_LCP_GUESS_H
#define NSDAE_LCP_GUESS_H

#include "work.h"

/* b >= 0: x = 0, as far as the options name that stage. Returns whether that solved it. */
int nsdae_lcp_guess_nothing(nsdae_lcp_work *w);

/* The solution with the active set w->basis, as far as the options name that stage. Returns whether
 * it solves the problem, whatever it is scaled by and whatever islands it has; if so the residual
 * that it leaves in w->info is a bound to that of any of these. */
int nsdae_lcp_guess_basis(nsdae_lcp_work *w);

#endif
