/* Solutions that one double an entry does not hold. Where bodies of a stack differ in mass by 1e6,
 * impulses x = r d / s of the residual are as large, their last digit 1e-10: of two layers that
 * hold a light one between them r_below - r_above = its weight, all of it multiples of that digit.
 */
#ifndef NSDAE_FRICTION_PRECISE_H
#define NSDAE_FRICTION_PRECISE_H

#include "interior.h"

typedef struct nsdae_fc_precise {
  double *high, *low;      /* 3 n: the point, in two parts */
  double *best, *best_low; /* 3 n: the best one */
  double *q;               /* 3 n: that of the island, while it is another */
  double *held;            /* 3 n: fc->r, which comes back */
} nsdae_fc_precise;

/* Takes the arrays. */
void nsdae_fc_precise_layout(nsdae_fc_precise *precise, const nsdae_fc *fc, nsdae_arena *arena);

/* The residual of the point high + low, of the data as given. */
double nsdae_fc_precise_residual(nsdae_fc_precise *precise, nsdae_fc *fc);

/* Corrects high + low, near a solution, until that is below tol or halves no more; returns it. The
 * point is the best one then, and fc->r what it was. Where it halves no more it goes through the
 * middle (middle.h; interior NULL: it does not), and it creeps, for so many steps, and so many
 * times where that seems to get to tol; 0: it does not. */
double nsdae_fc_precise_run(nsdae_fc_precise *precise, nsdae_fc_newton *newton,
                            nsdae_fc_interior *interior, double tol, int creep, int times);

#endif
