/* Block Gauss-Seidel: one item after the other is solved, the others fixed. */
#ifndef NSDAE_FRICTION_BLOCK_SWEEP_H
#define NSDAE_FRICTION_BLOCK_SWEEP_H

#include "scaled_island.h"

/* fc->y := J fc->r, to plain rounding. */
void nsdae_fc_sweep_begin(nsdae_fc_scaled *fc);

/* Sweeps over the island from fc->r, fc->y of which is current; slip [n] is kept between calls,
 * zero at first. Returns the largest weighted change of r in the last sweep. */
double nsdae_fc_sweep(nsdae_fc_scaled *fc, int sweeps, double *slip);

/* Whether the residual of each item is at most tol, to plain rounding; fc->y is current. Checks
 * item *first first, and stores the one that failed: most checks end with it. */
int nsdae_fc_sweep_converged(const nsdae_fc_scaled *fc, double tol, int *first);

#endif
