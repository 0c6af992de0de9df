/* The memory of the interior point for the second-order cone problem with s fixed. */
#ifndef NSDAE_FRICTION_SOCP_INTERIOR_POINT_H
#define NSDAE_FRICTION_SOCP_INTERIOR_POINT_H

#include "newton_step.h"

typedef struct nsdae_fc_socp {
  double *s;       /* n: mu |u_T|, added to u_N */
  double *a, *b;   /* 3 n: r and u + s e_N in rows where both cones are the second-order one */
  double *da, *db; /* 3 n: a step */
  double *rhs;     /* 3 n: of db + W^2 da */
  double *root;    /* 3 n: eigenvalues of W, along (1, axis), (1, -axis) and across them */
  double *axis;    /* 2 n: in the tangential plane */
  double *gap;     /* 3 n: velocities of r less those of b */
  double *end;     /* 3 n: the last solution */
} nsdae_fc_socp;

void nsdae_fc_socp_layout(nsdae_fc_socp *socp, const nsdae_fc_scaled *fc, nsdae_arena *arena);

#endif
