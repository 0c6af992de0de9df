/* What a drop's contact forces are, worked out by itself: whether there are any at all. */
#ifndef JAM_H
#define JAM_H

#include "drop.h"

enum { JAM_BY_FORCES = 1, JAM_BY_PROBLEM };

/* Whether at a state no contact forces solve the equations but such as are a hundred times what it
 * takes to stop every contact alone (Painleve's paradox, where forces have no solution, or are
 * about to be without bound), or two do: JAM_BY_FORCES. What touches within rtol of the state and
 * does not part is asked, after the impact of what approaches, if any does. Where an impact has
 * several solutions another one may have come of it: then whether the complementarity problem that
 * failed, which may be NULL, has no solution, or two, by a complete search: JAM_BY_PROBLEM. 0 else.
 */
int jam_is_true(const drop *d, const double *q, const double *v, const nsdae_lcp_problem *failed);

#endif
