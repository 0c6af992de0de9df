/* Sweeps that remember where they came from: nonsmooth nonlinear conjugate gradients (Silcowitz,
 * Niebe, Erleben, The Visual Computer 26 (2010) 893, after Fletcher and Reeves). What a sweep
 * changes, g, is taken for the descent direction of a smooth problem,
 *
 *   r := sweep(r) + b p,   p := b p + g,   b = |g|^2 / |g of the sweep before|^2,
 *
 * and where that is above one the method begins anew. What carries over through many contacts, as
 * a weight does through a heap, moves in some sweeps where it crept in hundreds. */
#ifndef NSDAE_FRICTION_CONJUGATE_H
#define NSDAE_FRICTION_CONJUGATE_H

#include "island.h"

typedef struct nsdae_fc_conjugate {
  double *before, *direction;     /* 3 n: r before the sweep; p */
  double *y_before, *y_direction; /* ny: of the global form, y of these */
  double square;                  /* |g|^2 of the sweep before; 0: there was none */
} nsdae_fc_conjugate;

void nsdae_fc_conjugate_layout(nsdae_fc_conjugate *conjugate, const nsdae_fc *fc,
                               nsdae_arena *arena);

/* From fc->r on, whose fc->y is current; then a sweep and an extrapolation in turn. */
void nsdae_fc_conjugate_begin(nsdae_fc_conjugate *conjugate);
/* Returns the largest weighted change of r; r is inside the cones. */
double nsdae_fc_conjugate_sweep(nsdae_fc_conjugate *conjugate, nsdae_fc *fc, double *slip);
/* r need not be inside. */
void nsdae_fc_conjugate_extrapolate(nsdae_fc_conjugate *conjugate, nsdae_fc *fc);

#endif
