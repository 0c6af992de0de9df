/* Block Gauss-Seidel: one item after the other solved exactly, the others held. */
#ifndef NSDAE_FRICTION_SWEEP_H
#define NSDAE_FRICTION_SWEEP_H

#include "island.h"

/* Sweeps over the island from fc->r, fc->y of which is current; slip [n] is kept between calls,
 * zero at first. Returns the largest weighted change of r in the last sweep. */
double nsdae_fc_sweep(nsdae_fc *fc, int sweeps, double *slip);

#endif
