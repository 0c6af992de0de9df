/* The fixed point of convex problems. */
#ifndef NSDAE_FRICTION_CONIC_H
#define NSDAE_FRICTION_CONIC_H

#include "chain.h"

/* Solves at most so many convex problems, each with the shift of the one before, from chain->slip
 * on, and tries Newton's method now and then, and where there is time for it curves; ends where the
 * steps times items are used up. exactly: each by an interior point, from chain->fc.r on. Returns
 * 1: solved. */
int nsdae_fc_conic(nsdae_fc_chain *chain, int exactly, int most, double budget, int stage);

#endif
