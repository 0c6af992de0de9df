/* The rate of the kinetic energy T = v^T M v / 2 by the equations of motion: with v' = a
 *
 *   T' = v^T M a + v^T M' v / 2,   M' = (M(t + s, q + s q') - M(t, q)) / s,  s ~ eps^(1/2)
 *
 * by one evaluation of M more, the second term to some 1e-8 of itself. While M is to the last bit
 * what it was at the first point M' is zero, and nothing is evaluated: as of most bodies, whose
 * coordinates are those of their centre of mass. */
#ifndef NSDAE_TERMS_POWER_H
#define NSDAE_TERMS_POWER_H

#include "terms.h"

typedef struct nsdae_power {
  double *q, *M;  /* nq; by blocks: ahead */
  double *first;  /* M at the first point */
  int any, moves; /* there is one; M was another since then */
} nsdae_power;

void nsdae_power_layout(nsdae_power *power, const nsdae_system *system, nsdae_arena *arena);

/* The next point is the first. */
void nsdae_power_start(nsdae_power *power);

/* *rate = v^T M' v / 2 alone, of the same. */
int nsdae_power_inertia(nsdae_power *power, const nsdae_terms *terms, const double *qdot,
                        double *rate);

/* *rate = T' at the terms' point, whose M is there, with accelerations a [nv] and q' [nq].
 * NSDAE_OK, NSDAE_E_CALLBACK, NSDAE_E_NONFINITE. */
int nsdae_power_rate(nsdae_power *power, const nsdae_terms *terms, const double *a,
                     const double *qdot, double *rate);

#endif
