/* An arch of blocks: see arch.c. */
#ifndef NSDAE_MODEL_ARCH_H
#define NSDAE_MODEL_ARCH_H

#include "driver.h"

typedef struct arch {
  int blocks;
  double R, t, mu, g; /* t: thickness over the radius R of its middle line */
  nsdae_bodies *world;
  double moved;   /* how far the highest block is from where it was [m] */
  double crown;   /* its height at the start */
  double fastest; /* |v| of the last record */
} arch;

extern const driver_model arch_model;

/* Least t at which a semicircular arch of that many blocks stands whatever the friction: Heyman's
 * safe theorem, for hinges at its joints alone; of infinitely many it is 0.1075. */
double arch_least_thickness(int blocks);

#endif
