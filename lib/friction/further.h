/* The last stage of the chain: what is slow, and gets to what nothing else does. */
#ifndef NSDAE_FRICTION_FURTHER_H
#define NSDAE_FRICTION_FURTHER_H

#include "chain.h"

/* Goes on from where the stages before ended; 1: solved, or rounding leaves nothing to be done. */
int nsdae_fc_further(nsdae_fc_chain *chain);

/* The last digits of what is nearly solved, by the data as given, in two parts where one does not
 * hold them: who takes one gets that, if it is the better one. */
int nsdae_fc_precisely(nsdae_fc_chain *chain);

/* Middle points (middle.h) and proximal points from chain->fc.r on, as long as they bring the
 * residual down; then the same in two parts. 1: solved. */
int nsdae_fc_creep_on(nsdae_fc_chain *chain);

/* Whether the best point is a solution, or rounding leaves nothing to be done. */
int nsdae_fc_arrived(nsdae_fc_chain *chain);

#endif
