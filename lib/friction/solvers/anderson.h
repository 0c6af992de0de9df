/* Block Gauss-Seidel: one item after the other is solved, the others fixed;
 * and Anderson's extrapolation (J. ACM 12 (1965) 547; Walker and Ni, SIAM J. Numer. Anal. 49 (2011)
 * 1715) of the fixed point r = g(r) of a sweep. f = g(r) - r is taken to be affine in r over the
 * last sweeps,
 *
 *   r := g(r) - G c,   c = argmin |f - F c|,
 *
 * the columns of F and G being the differences of f and g between sweeps. While no contact changes
 * its state a sweep is affine, and this is truncated GMRES with the sweep as preconditioner. If |f|
 * grows, contacts have changed their state, and the method restarts. */
#ifndef NSDAE_FRICTION_ANDERSON_H
#define NSDAE_FRICTION_ANDERSON_H

#include "scaled_island.h"

/* fc->y := J fc->r, to plain rounding. */
void nsdae_fc_sweep_begin(nsdae_fc_scaled *fc);

/* A sweep over the island from fc->r, fc->y of which is current; slip [n] is kept between calls,
 * zero at first. Returns the largest weighted change of r. */
double nsdae_fc_sweep(nsdae_fc_scaled *fc, double *slip);

/* Columns. In 2400 steps of four seeded heaps to 1e-4, with 500 sweeps at most, 4 columns take 1.04
 * times the sweeps and leave 41 problems unsolved, 3 leave 16; 4 without the ratio step 284. */
enum { NSDAE_FC_WINDOW = 3 };

typedef struct nsdae_fc_anderson {
  double *before;    /* 3 n: r before the sweep, then its change, f */
  double *f, *g, *y; /* 3 n, 3 n, ny: of the last sweep; y of g */
  double *F, *G, *Y; /* their differences, a column each of NSDAE_FC_WINDOW */
  double gram[NSDAE_FC_WINDOW * NSDAE_FC_WINDOW]; /* F^T F */
  double share[NSDAE_FC_WINDOW];                  /* held: c of the last extrapolation */
  double square;                                  /* |f|^2 of the last sweep */
  double left;                                    /* its |f - F c|^2 / |f|^2 */
  int held, next;                                 /* columns; the one to be overwritten */
  int begun;                                      /* there was a sweep before */
} nsdae_fc_anderson;

void nsdae_fc_anderson_layout(nsdae_fc_anderson *anderson, const nsdae_fc_scaled *fc,
                              nsdae_arena *arena);

/* From fc->r on, whose fc->y is current; then sweeps, after any of them an extrapolation. */
void nsdae_fc_anderson_begin(nsdae_fc_anderson *anderson);
/* Returns the largest weighted change of r; r is inside the cones, to fc->exact. */
double nsdae_fc_anderson_sweep(nsdae_fc_anderson *anderson, nsdae_fc_scaled *fc, double *slip);
/* The same of another fixed point g: fc->r is g(r), r in before. */
void nsdae_fc_anderson_collect(nsdae_fc_anderson *anderson, nsdae_fc_scaled *fc);
/* r need not be inside. */
void nsdae_fc_anderson_extrapolate(nsdae_fc_anderson *anderson, nsdae_fc_scaled *fc);
/* f - F c of the last extrapolation, into before. At most once after each. */
void nsdae_fc_anderson_remainder(nsdae_fc_anderson *anderson, const nsdae_fc_scaled *fc);

/* After an extrapolation: if little but a ray remains, r moves along it, inside the cones, and
 * Anderson's method restarts (ratio_step.c). */
void nsdae_fc_ratio_step(nsdae_fc_anderson *anderson, nsdae_fc_scaled *fc);

#endif
