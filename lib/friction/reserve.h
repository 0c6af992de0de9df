/* Memory of a solver ahead of its problems. */
#ifndef NSDAE_FRICTION_RESERVE_H
#define NSDAE_FRICTION_RESERVE_H

#include <nsdae/friction.h>

/* From here on the solver allocates nothing for a problem in the local form that is no larger than
 * this one, which must pass nsdae_friction_check: its equations are solved by dense factorisations,
 * since the analysis of sparse ones takes memory. NSDAE_OK, or status as of nsdae_friction_check.
 */
int nsdae_fc_reserve(nsdae_friction_solver *solver, const nsdae_friction_problem *largest);

#endif
