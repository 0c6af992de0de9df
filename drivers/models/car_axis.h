/* The car axis on a bumpy road: see car_axis.c. */
#ifndef NSDAE_MODEL_CAR_AXIS_H
#define NSDAE_MODEL_CAR_AXIS_H

#include "published.h"

typedef struct car_axis {
  double M, k, L, L0, r, omega, g;
  last_record last;
} car_axis;

extern const driver_model car_axis_model;
extern const published car_axis_published;

#endif
