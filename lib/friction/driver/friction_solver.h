/* What contacts ask of a solver besides the public calls. */
#ifndef NSDAE_FRICTION_FRICTION_SOLVER_H
#define NSDAE_FRICTION_FRICTION_SOLVER_H

#include <nsdae/friction.h>

#include "thread_pool.h"

/* Threads for the solutions that follow, which have the same bits; NULL: the caller's alone. */
void nsdae_fc_set_pool(nsdae_friction_solver *solver, nsdae_thread_pool *pool);

/* From here on the solver allocates nothing for a problem in the local form that lists every pair
 * of its items, as this one does, and is no larger; this one must pass nsdae_friction_check.
 * Equations of such problems are solved by dense factorisations: the analysis of sparse ones takes
 * memory. NSDAE_OK, or status as of nsdae_friction_check. */
int nsdae_fc_reserve(nsdae_friction_solver *solver, const nsdae_friction_problem *largest);

/* Multiplications by J that an island of this number of items may take if options.budget is 0. */
double nsdae_fc_own_budget(int items);

/* max |q|, q = H^T M^-1 f + w, of the problem solved last: the largest velocity without impulses.
 */
double nsdae_fc_speed(const nsdae_friction_solver *solver);

#endif
