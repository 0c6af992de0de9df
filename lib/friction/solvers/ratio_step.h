/* Where few items are locked in one another sweeps come to no end: r moves on by as much in each,
 * along what hardly moves u (the null space of W over the items that stick), until one of them
 * opens or slides. What does not change from sweep to sweep Anderson's method (anderson.h) cannot
 * take away: then f - F c is all that is left of f, and the way of the drift. As W does not see it,
 * r may go along it at once to where the first of the items that drift changes its state, as along
 * a ray of Lemke's method. What that spoils elsewhere sweeps mend, and what is solved is judged by
 * its residual. */
#ifndef NSDAE_FRICTION_RATIO_STEP_H
#define NSDAE_FRICTION_RATIO_STEP_H

#include "anderson.h"

/* After an extrapolation: where sweeps only drift, r goes on along that, inside the cones, and the
 * method begins anew. */
void nsdae_fc_ratio_step(nsdae_fc_anderson *anderson, nsdae_fc_scaled *fc);

#endif
