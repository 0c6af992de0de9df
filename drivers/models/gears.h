/* Two gears of involute teeth: see gears.c. */
#ifndef NSDAE_MODEL_GEARS_H
#define NSDAE_MODEL_GEARS_H

#include "driver.h"

typedef struct gears {
  int teeth[2];
  double module, pressure, thinner, speed, damping, torque;
  nsdae_bodies *world;
  double turned[2]; /* angle of each gear since the start [rad] */
  double error;     /* largest |N_1 theta_1 + N_2 theta_2| so far [rad] */
  double depth;     /* largest penetration so far [m] */
} gears;

/* Bound of the error, for teeth that overlap by no more than depth. */
double gears_bound(const gears *p, double depth);

extern const driver_model gears_model;

#endif
