/* Starts: which are taken, and putting one right. */
#ifndef NSDAE_SIM_START_H
#define NSDAE_SIM_START_H

#include "state_projection.h"

/* Whether the terms' point may be a start: NSDAE_OK, or NSDAE_E_ARGUMENT naming the row, its value
 * and its bound, NSDAE_E_DERIVATIVE where derivatives are grossly wrong. NSDAE_WARN_PENETRATION:
 * time stepping starts from an overlap beyond start_tol. The terms and the groups of unit length
 * are those of the start; work has nsdae_initial_size numbers. */
int nsdae_initial_check(nsdae_projector *projection, const nsdae_terms *start, double *work);

/* Moves the start of event to gaps >= 0 and to the constraints if a contact overlaps: the least
 * change in the metric of M. 1: moved; NSDAE_OK: nothing to do; NSDAE_E_CONVERGENCE naming the
 * worst row, and what the terms return. */
int nsdae_initial_touch(nsdae_projector *projection, nsdae_terms *start);

/* NSDAE_OK, or with method penalty NSDAE_WARN_RESTITUTION naming the contact whose law is furthest
 * from e_N. */
int nsdae_initial_law(const nsdae_system *system, const nsdae_sim_options *options,
                      nsdae_error *error);

/* Numbers that the check works on: accelerations of contacts and frictional joints, given and
 * differenced. */
size_t nsdae_initial_size(const nsdae_dims *dims);

#endif
