/* Dominoes in a row: see dominoes.c. */
#ifndef NSDAE_MODEL_DOMINOES_H
#define NSDAE_MODEL_DOMINOES_H

#include "driver.h"

typedef struct dominoes {
  int n;
  double h, d, s, mu, floor_mu, push, g;
  nsdae_bodies *world;
  double hit_first, hit_last; /* times at which the dominoes n/2 and n - 2 hit the next [s] */
  double speed;               /* of the wave between these [m/s]; 0: it has not come that far */
} dominoes;

extern const driver_model dominoes_model;

/* Speed of the wave by J. M. J. van Leeuwen's theory, for dominoes that do not slide on the floor
 * and are smooth to each other. */
double dominoes_theory(const dominoes *p);

#endif
