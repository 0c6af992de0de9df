/* Spheres that collapse to a heap: see heap.c. */
#ifndef NSDAE_MODEL_HEAP_H
#define NSDAE_MODEL_HEAP_H

#include "driver.h"

typedef struct heap {
  int spheres, rough;
  double r, mu, e_N, g;
  nsdae_bodies *world;
  double weight, mass, impulse,
      momentum;          /* [N, kg]; of the floor so far, of the spheres now [N s] */
  double worst_momentum; /* balance: impulse - weight t - momentum [N s] */
  double angle;          /* slope of the heap [rad] */
  double filled;         /* part of the spheres' volume that lies in another */
} heap;

extern const driver_model heap_model;

#endif
