/* The pendulum with a stop: see pendulum.c. */
#ifndef NSDAE_MODEL_PENDULUM_H
#define NSDAE_MODEL_PENDULUM_H

#include "driver.h"

typedef struct pendulum {
  double L, m, g, e_N, theta_0;
} pendulum;

extern const driver_model pendulum_model;

#endif
