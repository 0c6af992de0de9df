/* The way to a solution nearby through the middle of those of convex problems. */
#ifndef NSDAE_FRICTION_MIDDLE_H
#define NSDAE_FRICTION_MIDDLE_H

#include "chain.h"

/* From chain->fc.r on, where that is near a solution and the chain may take its time; where it
 * leads nowhere fc.r is the best point then, if that is a better one, or as it was. 1: solved. */
int nsdae_fc_middle_on(nsdae_fc_chain *chain);

#endif
