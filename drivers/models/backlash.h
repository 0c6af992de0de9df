/* Gears with backlash: see backlash.c. */
#ifndef NSDAE_MODEL_BACKLASH_H
#define NSDAE_MODEL_BACKLASH_H

#include "driver.h"

typedef struct backlash {
  double amplitude, frequency, play, inertia, brake;
  int teeth[2]; /* of the pinion and the gear */
  nsdae_bodies *world;
  double error; /* largest distance of the load from its closed form so far [rad] */
} backlash;

/* Angles of the gear and of the load at a time: the closed form. */
double backlash_gear(const backlash *p, double t);
double backlash_load(const backlash *p, double t);

/* The least torque of the brake for the closed form. */
double backlash_least_brake(const backlash *p);

extern const driver_model backlash_model;

#endif
