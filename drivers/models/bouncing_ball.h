/* A ball that bounces on the floor: see bouncing_ball.c. */
#ifndef NSDAE_MODEL_BOUNCING_BALL_H
#define NSDAE_MODEL_BOUNCING_BALL_H

#include "table_ball.h"

typedef struct bouncing_ball {
  table_ball ball;
  double h0;
} bouncing_ball;

extern const driver_model bouncing_ball_model;

/* Time from which the ball rests [s]; infinite for e_N = 1. */
double bouncing_ball_rest(const bouncing_ball *p);

/* Exact height [m] and velocity [m/s] at t >= 0, and the number of impacts up to then; once the
 * ball rests, that number is the largest int. Each may be NULL. */
void bouncing_ball_exact(const bouncing_ball *p, double t, double *y, double *v, int *impacts);

#endif
