/* A cam and its flat follower: see cam.c. */
#ifndef NSDAE_MODEL_CAM_H
#define NSDAE_MODEL_CAM_H

#include "driver.h"

typedef struct cam {
  double radius, lift, rise, speed, mass, stiffness, preload, mu;
  int corners;
  nsdae_bodies *world;
  double error; /* largest distance of the follower from its closed form so far [m] */
  double depth; /* largest penetration so far [m] */
} cam;

/* Lift of the follower at an angle of the cam [m]. */
double cam_lift(const cam *p, double angle);

/* Bound of the error: of the chords of the polygon. */
double cam_bound(const cam *p);

/* The least preload of the spring with which the follower stays on the cam [N]. */
double cam_least_preload(const cam *p);

extern const driver_model cam_model;

#endif
