/* Systems in absolute coordinates that drift: a rod on a pivot, with a stop, and a free body whose
 * attitude is a quaternion. */
#ifndef NSDAE_TESTS_RODS_H
#define NSDAE_TESTS_RODS_H

#include <nsdae/nsdae.h>

/* A uniform rod of length 1 m and 1 kg, q = [x, y, theta]: its centre and its angle from the
 * vertical. Phi = [x - sin theta / 2, y + cos theta / 2], g_N = sin theta - wall. */
typedef struct rod {
  double wall, e;
} rod;

nsdae_system *rod_system(rod *r);
void rod_start(double theta, double omega, double q0[3], double v0[3]);

/* A body of 2 kg with the moments of inertia (1, 2, 3) kg m^2 that falls: q = [x, y, z, e_0 ..
 * e_3], v = [x', y', z', omega in its own axes], and a ball of radius 0.1 m about its centre above
 * a floor. */
nsdae_system *body_system(void);

/* Angular momentum of the body in space. */
void body_momentum(const double q[7], const double v[6], double L[3]);

#endif
