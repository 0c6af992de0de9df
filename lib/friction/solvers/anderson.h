/* Sweeps that remember where they came from: the fixed point of a sweep, r = g(r), by the method of
 * Anderson (J. ACM 12 (1965) 547; Walker and Ni, SIAM J. Numer. Anal. 49 (2011) 1715). Of the last
 * few sweeps what they changed, f = g(r) - r, is taken to be affine in r,
 *
 *   r := g(r) - G c,   c least of |f - F c|,
 *
 * with the differences of g and of f between sweeps for columns. Where contacts stay as they are,
 * stuck or open, a sweep is affine, and this is GMRES with the sweep for preconditioner, but that
 * it forgets (Walker and Ni): what carries over through many contacts, as a weight does through a
 * heap, moves in some sweeps where it crept in hundreds. Where |f| grows much, contacts have
 * changed, and the method begins anew. */
#ifndef NSDAE_FRICTION_ANDERSON_H
#define NSDAE_FRICTION_ANDERSON_H

#include "scaled_island.h"

/* Sweeps that are remembered: more save few and cost their products. */
enum { NSDAE_FC_WINDOW = 4 };

typedef struct nsdae_fc_anderson {
  double *before;    /* 3 n: r before the sweep; after an extrapolation its change, f */
  double *f, *g, *y; /* 3 n, 3 n, ny: of the sweep before; y of g */
  double *F, *G, *Y; /* their differences, a column each of NSDAE_FC_WINDOW */
  double gram[NSDAE_FC_WINDOW * NSDAE_FC_WINDOW]; /* F^T F */
  double share[NSDAE_FC_WINDOW];                  /* held: c of the last extrapolation */
  double square;                                  /* |f|^2 of the sweep before */
  double left;                                    /* its |f - F c|^2 / |f|^2 */
  int held, next;                                 /* columns; the one to be overwritten */
  int begun;                                      /* there was a sweep before */
} nsdae_fc_anderson;

void nsdae_fc_anderson_layout(nsdae_fc_anderson *anderson, const nsdae_fc_scaled *fc,
                              nsdae_arena *arena);

/* From fc->r on, whose fc->y is current; then a sweep and an extrapolation in turn. */
void nsdae_fc_anderson_begin(nsdae_fc_anderson *anderson);
/* Returns the largest weighted change of r; r is inside the cones, to fc->exact. */
double nsdae_fc_anderson_sweep(nsdae_fc_anderson *anderson, nsdae_fc_scaled *fc, double *slip);
/* r need not be inside. */
void nsdae_fc_anderson_extrapolate(nsdae_fc_anderson *anderson, nsdae_fc_scaled *fc);
/* What the extrapolation left of the sweep, f - F c, in before. Once after each. */
void nsdae_fc_anderson_leave(nsdae_fc_anderson *anderson, const nsdae_fc_scaled *fc);

#endif
