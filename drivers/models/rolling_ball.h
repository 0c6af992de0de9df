/* A ball that slides and spins: see rolling_ball.c. */
#ifndef NSDAE_MODEL_ROLLING_BALL_H
#define NSDAE_MODEL_ROLLING_BALL_H

#include "driver.h"

typedef struct rolling_ball {
  double m, r, g, mu, vx, vy, wx, wy;
} rolling_ball;

extern const driver_model rolling_ball_model;

#endif
