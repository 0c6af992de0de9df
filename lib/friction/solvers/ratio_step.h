/* A step along a ray, as of Lemke's method, for Gauss-Seidel sweeps with Anderson's extrapolation.
 * If few items are locked, each sweep changes r by the same f, along the null space of W over the
 * sticking items, until one of them opens or slides. The extrapolation cannot remove such a part:
 * f - F c, its least-squares residual, is nearly f. W does not see that direction, so that r may
 * follow it to the first change of state of an item (the ratio test). Without it nine steps of a
 * sliding pile take 10 times as long, each from the one before. */
#ifndef NSDAE_FRICTION_RATIO_STEP_H
#define NSDAE_FRICTION_RATIO_STEP_H

#include "anderson.h"

/* After an extrapolation: if little but such a ray remains, r moves along it, inside the cones, and
 * Anderson's method restarts. */
void nsdae_fc_ratio_step(nsdae_fc_anderson *anderson, nsdae_fc_scaled *fc);

#endif
