/* A block on an incline: see incline.c. */
#ifndef NSDAE_MODEL_INCLINE_H
#define NSDAE_MODEL_INCLINE_H

#include "driver.h"

typedef struct incline {
  double m, g, slope, turn, mu, vx, vy;
} incline;

extern const driver_model incline_model;

#endif
