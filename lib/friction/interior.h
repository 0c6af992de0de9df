/* The convex problem with a fixed shift of u_N, by an interior point: its solution is the middle
 * one where there are many. */
#ifndef NSDAE_FRICTION_INTERIOR_H
#define NSDAE_FRICTION_INTERIOR_H

#include "newton.h"

typedef struct nsdae_fc_interior {
  double *shift;   /* n: of u_N */
  double *a, *b;   /* 3 n: r and u + shift e_N in rows where both cones are the second-order one */
  double *da, *db; /* 3 n: a step */
  double *aim;     /* 3 n: what db + W^2 da is to be */
  double *root;    /* 3 n: eigenvalues of W, along (1, axis), (1, -axis) and across them */
  double *axis;    /* 2 n: in the tangential plane */
  double *gap;     /* 3 n: velocities of r, less those that b is */
  double *middle;  /* 3 n: where a run ended */
  double *held;    /* 3 n: a point of whoever asks */
} nsdae_fc_interior;

void nsdae_fc_interior_layout(nsdae_fc_interior *interior, const nsdae_fc *fc, nsdae_arena *arena);

/* From fc->r, and where that leads nowhere from r = 0, to fc->r; 0: not found. */
int nsdae_fc_interior_run(nsdae_fc_interior *interior, nsdae_fc_newton *newton);

#endif
