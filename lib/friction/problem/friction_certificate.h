/* What a point is worth: its velocities and its residual, from the data as given. Impulses may be
 * double-double, r + low, low being the trailing part (NULL: zero). */
#ifndef NSDAE_FRICTION_FRICTION_CERTIFICATE_H
#define NSDAE_FRICTION_FRICTION_CERTIFICATE_H

#include "global_problem.h"

/* u [m] of r and low [m], and the residual of the public header; NaN if an entry is not finite.
 */
double nsdae_fc_global_residual(const nsdae_fc_global *whole, const double *r, const double *low,
                                double *u);

/* u in the rows of one island; those of others stay. */
void nsdae_fc_island_velocities(const nsdae_fc_global *whole, int island, const double *r,
                                const double *low, double *u);

#endif
