/* Block Gauss-Seidel: one item after the other is solved, the others fixed. */
#ifndef NSDAE_FRICTION_BLOCK_SWEEP_H
#define NSDAE_FRICTION_BLOCK_SWEEP_H

#include "scaled_island.h"

/* fc->y := J fc->r, to plain rounding. */
void nsdae_fc_sweep_begin(nsdae_fc_scaled *fc);

/* Sweeps over the island from fc->r, fc->y of which is current; slip [n] is kept between calls,
 * zero at first. Returns the largest weighted change of r in the last sweep. */
double nsdae_fc_sweep(nsdae_fc_scaled *fc, int sweeps, double *slip);

/* Whether no item's residual is above tol, fc->y being current, to plain rounding. Looks at item
 * *seen first, and leaves there the one that was above: most looks end with it. */
int nsdae_fc_sweep_arrived(const nsdae_fc_scaled *fc, double tol, int *seen);

#endif
