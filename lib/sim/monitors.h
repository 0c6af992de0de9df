/* Judges every point before it becomes the state: what the method does not explain is reported,
 * once for each kind. docs/methods/warnings.md has the bounds and where they come from. In its
 * letters h is the step, c the largest entry of Phi_q at the start, l = max h c max |v_j| the way
 * along such a row in one step so far, g the largest change of a gap in one; neither is below the
 * way h^2 F / M that the forces of the start lead to from rest. */
#ifndef NSDAE_MONITORS_H
#define NSDAE_MONITORS_H

#include "sim_impl.h"

/* From the start on. NSDAE_OK, or what the terms return. */
int nsdae_monitors_start(const nsdae_sim *sim, nsdae_point *point);
/* After a step: the warning of now, NSDAE_WARN_... with the error record, or NSDAE_OK. */
int nsdae_monitors_step(const nsdae_sim *sim, const nsdae_point *before, nsdae_point *point);

#endif
