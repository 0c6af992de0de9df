/* The curve of smoothed, compliant problems, followed round its folds: see the file itself. */
#ifndef NSDAE_FRICTION_CONTINUATION_H
#define NSDAE_FRICTION_CONTINUATION_H

#include "newton.h"

typedef struct nsdae_fc_curve {
  double stiffness;    /* compliance / epsilon */
  double close;        /* length of the last correction relative to the step */
  double l;            /* log(epsilon) of the point */
  double rate;         /* of l along the tangent */
  double length;       /* of the next step */
  double *tangent;     /* 3 n: of r */
  double *slope;       /* 3 n: F_l */
  double *turn;        /* 3 n: F_r^-1 F_l */
  double *start, *aim; /* 3 n: where a step begins; where its tangent leads */
  double *weight;      /* n: of lengths in r */
} nsdae_fc_curve;

void nsdae_fc_curve_layout(nsdae_fc_curve *curve, const nsdae_fc *fc, nsdae_arena *arena);

/* Follows the curve from its beginning until the residual is below tol, or for newton->most steps.
 * Returns the residual, which is that of fc->r then. */
double nsdae_fc_continue(nsdae_fc_curve *curve, nsdae_fc_newton *newton, double stiffness,
                         double close, double tol);

#endif
