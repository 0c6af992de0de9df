/* A point mass on a massless rod, released from the horizontal: problem A01 of the IFToMM library
 * of computational benchmark problems. q = [x, y], one constraint. */
#ifndef NSDAE_TESTS_LONG_PENDULUM_H
#define NSDAE_TESTS_LONG_PENDULUM_H

#include <nsdae/nsdae.h>

typedef struct long_pendulum {
  double L, m, g;
} long_pendulum;

void long_pendulum_default(long_pendulum *p);
nsdae_system *long_pendulum_system(long_pendulum *p);
void long_pendulum_start(const long_pendulum *p, double q0[2], double v0[2]);

#endif
