/* A ragdoll falls down stairs: see ragdoll.c. */
#ifndef NSDAE_MODEL_RAGDOLL_H
#define NSDAE_MODEL_RAGDOLL_H

#include "driver.h"

typedef struct ragdoll {
  int steps;
  double rise, run, push, friction, mu, g;
  nsdae_bodies *world;
  double start;  /* energy [J], the feet of the stairs at height 0 */
  double drift;  /* largest of a joint so far [m or rad] */
  double growth; /* largest energy so far beyond the start's and the projection's [J] */
} ragdoll;

extern const driver_model ragdoll_model;

#endif
