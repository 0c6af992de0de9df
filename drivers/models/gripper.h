/* A gripper holds a box by friction: see gripper.c. */
#ifndef NSDAE_MODEL_GRIPPER_H
#define NSDAE_MODEL_GRIPPER_H

#include "driver.h"

typedef struct gripper {
  double force, mu, mass, size, stroke, period, g;
  nsdae_bodies *world;
  double place[2][2]; /* of the box beside each finger at the start [m] */
  double slip;        /* largest so far [m] */
} gripper;

/* The least force of a finger that holds the box [N]. */
double gripper_least_force(const gripper *p);

extern const driver_model gripper_model;

#endif
