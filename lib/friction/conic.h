/* The fixed point of convex problems. */
#ifndef NSDAE_FRICTION_CONIC_H
#define NSDAE_FRICTION_CONIC_H

#include "chain.h"

/* How convex problems are solved: by paths, or by interior points from chain->fc.r on; and so that
 * where the walk of their shifts is stuck it returns to the calmest of late. */
enum { NSDAE_FC_QUICKLY, NSDAE_FC_EXACTLY, NSDAE_FC_RETURNING };

/* Solves at most so many convex problems, each with the shift of the one before, from chain->slip
 * on, and tries Newton's method now and then, and where there is time for it curves; ends where the
 * steps times items are used up. 1: solved. */
int nsdae_fc_conic(nsdae_fc_chain *chain, int how, int most, double budget, int stage);

#endif
