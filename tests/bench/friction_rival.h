/* Peers for frictional contact problems, so that they can be timed on the same problems in the same
 * run. Where none was found there are none. */
#ifndef NSDAE_BENCH_FRICTION_RIVAL_H
#define NSDAE_BENCH_FRICTION_RIVAL_H

#include <nsdae/friction.h>

int friction_rivals(void);
const char *friction_rival_name(int peer);

/* The problem in its local form, three rows a contact; r [3 contacts] in: zero, out: what the peer
 * hands over. Returns its info, 0 for what it takes for solved. tol: its own tolerance. */
int friction_rival_solve(int peer, const nsdae_friction_problem *local, double tol, double *r);

#endif
