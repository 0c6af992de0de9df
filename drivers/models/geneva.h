/* A Geneva drive: see geneva.c. */
#ifndef NSDAE_MODEL_GENEVA_H
#define NSDAE_MODEL_GENEVA_H

#include "driver.h"

typedef struct geneva {
  int slots;
  double distance, pin, play, speed, torque, inertia, brake;
  nsdae_bodies *world;
  double error;  /* largest distance of the wheel from its closed form so far [rad] */
  double moving; /* largest speed of the wheel in a dwell so far [rad/s] */
  double turned; /* angle of the wheel since the start [rad] */
} geneva;

/* The crank's angle from the line of the centres at which the pin enters: pi / 2 - pi / n. */
double geneva_entry(const geneva *p);

/* Angle of the wheel, after any turns, at the angle of the crank from the line of the centres. */
double geneva_wheel(const geneva *p, double crank);

/* Bound of the error: the way of the pin from one side of its slot to the other, seen from the
 * axis of the wheel at the shortest distance. overlap: of the pin and a side. */
double geneva_bound(const geneva *p, double overlap);

extern const driver_model geneva_model;

#endif
