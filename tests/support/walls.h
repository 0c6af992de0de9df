/* A mechanism in space with a floor z = 0 and up to four walls x, y = -half, half; gravity -g.
 * Bodies have the material 1. */
#ifndef WALLS_H
#define WALLS_H

#include "check.h"

#include <nsdae/nsdae.h>

static inline nsdae_bodies *floor_and_walls(double mu, int walls, double half, double g)
{
  const double turn = sqrt(0.5);
  nsdae_bodies *b;
  assert_int_equal(nsdae_bodies_create(3, &b, NULL), NSDAE_OK);
  nsdae_bodies_set_gravity(b, (double[3]){0, 0, -g});
  nsdae_bodies_set_pair(b, 0, 1, mu, 0, 0);
  nsdae_bodies_set_pair(b, 1, 1, mu, 0, 0);
  nsdae_bodies_add_solid(b, NSDAE_GROUND, &(nsdae_solid){.shape = NSDAE_SHAPE_PLANE});
  for (int i = 0; i < walls; i++) {
    const double sign = i % 2 ? 1 : -1;
    nsdae_solid wall = {.shape = NSDAE_SHAPE_PLANE};
    wall.position[i / 2] = sign * half;
    wall.quaternion[0] = turn;
    wall.quaternion[i / 2 == 0 ? 2 : 1] = (i / 2 == 0 ? -sign : sign) * turn;
    nsdae_bodies_add_solid(b, NSDAE_GROUND, &wall);
  }
  return b;
}

#endif
