/* A wall of blocks: see wall.c. */
#ifndef NSDAE_MODEL_WALL_H
#define NSDAE_MODEL_WALL_H

#include "driver.h"

typedef struct wall {
  int courses, length; /* blocks of an even course */
  double width, height, gap, mu, e_N, g;
  nsdae_bodies *world;
  int blocks;
  double weight, carried; /* [N]; what the floor carried in the last step */
  double fastest;         /* |v| of any block so far */
} wall;

extern const driver_model wall_model;

#endif
