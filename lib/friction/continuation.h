/* The curve of smoothed, compliant problems, followed round its folds: see the file itself. */
#ifndef NSDAE_FRICTION_CONTINUATION_H
#define NSDAE_FRICTION_CONTINUATION_H

#include "newton.h"

typedef struct nsdae_fc_curve {
  double stiffness; /* compliance / epsilon^power */
  double power;
  double l, top;       /* log(epsilon) of the point, and of one that has gone back */
  double rate;         /* of l along the tangent */
  double bend_rate;    /* of rate along it */
  double length;       /* of the next step */
  double *tangent;     /* 3 n: of r */
  double *next;        /* 3 n: at the end of a step */
  double *bend;        /* 3 n: of the tangent, along it */
  double *slope;       /* 3 n: F_l */
  double *turn;        /* 3 n: F_r^-1 F_l */
  double *start, *aim; /* 3 n: where a step begins; where its tangent leads */
  double *origin;      /* 3 n: z, where the compliance is at rest */
  double *weight;      /* n: of lengths in r */
} nsdae_fc_curve;

void nsdae_fc_curve_layout(nsdae_fc_curve *curve, const nsdae_fc *fc, nsdae_arena *arena);

/* To the beginning of a curve, epsilon = 1 or, where impulses are large, more. Number 0 has z = 0,
 * each other one z of its own. 0: it was not found. */
int nsdae_fc_curve_begin(nsdae_fc_curve *curve, nsdae_fc_newton *newton, double stiffness,
                         int number);

/* The same of a curve that begins near fc->r, its z, with this epsilon and this compliance, which
 * goes with the root of epsilon. */
int nsdae_fc_curve_anchor(nsdae_fc_curve *curve, nsdae_fc_newton *newton, double epsilon,
                          double compliance);

/* Steps along it, from fc->r, down to this l; 0: it was lost, or newton->most steps are done. */
int nsdae_fc_curve_follow(nsdae_fc_curve *curve, nsdae_fc_newton *newton, double lower);

/* What is left of it once it is straight: epsilon down to rounding. Returns the residual. */
double nsdae_fc_curve_descend(nsdae_fc_curve *curve, nsdae_fc_newton *newton, double tol);

#endif
