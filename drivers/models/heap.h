/* Spheres that collapse to a heap: see heap.c. */
#ifndef NSDAE_MODEL_HEAP_H
#define NSDAE_MODEL_HEAP_H

#include "driver.h"

/* A cylinder that holds the spheres, and is gone from a moment on. */
typedef struct heap_cylinder {
  double aspect;  /* height of the spheres in it over its radius, about; 0: none */
  double release; /* [s] */
  int seed;       /* of places and velocities at the start */
  double radius;  /* [m] */
  double filled;  /* height of the spheres in it, over its radius, when it went; 0: not seen */
} heap_cylinder;

typedef struct heap {
  int spheres, rough;
  double r, mu, e_N, g;
  heap_cylinder cylinder;
  nsdae_bodies *world;
  double *place;            /* of the spheres now [spheres x 3, m] */
  double weight, mass;      /* of all [N], of one [kg] */
  double impulse, momentum; /* of the floor so far, of the spheres now [N s] */
  double worst_momentum;    /* balance: impulse - weight t - change of momentum [N s] */
  double since, from;       /* time and momentum where the run began, or was taken up [s, N s] */
  int begun;
  double angle;  /* slope of the heap [rad] */
  double filled; /* part of the spheres' volume that lies in another */
} heap;

extern const driver_model heap_model;

#endif
