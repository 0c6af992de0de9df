/* Block Gauss-Seidel: one item after the other solved exactly, the others held. */
#ifndef NSDAE_FRICTION_SWEEP_H
#define NSDAE_FRICTION_SWEEP_H

#include "island.h"

/* Solves one contact, u = D r + q with Coulomb's law. D [9] as in nsdae_fc and positive definite.
 * slip in: a guess at |u_T| / |r_T| of a contact that slides; out: it, zero where it sticks. */
void nsdae_fc_solve_contact(const double *D, const double *q, double mu, double *slip, double *r);

/* Sweeps over the island from fc->r, fc->y of which is current; slip [n] is kept between calls,
 * zero at first. Returns the largest weighted change of r in the last sweep. */
double nsdae_fc_sweep(nsdae_fc *fc, int sweeps, double *slip);

#endif
