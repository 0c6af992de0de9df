/* The ball in C, for the tests of compiled callbacks. user: its mass, where it is not NULL. */
#include <stddef.h>

static double mass_of(const void *user)
{
  return user ? *(const double *)user : 0.1;
}

int mass(double t, const double *q, double *M, int ldm, void *user)
{
  (void)t, (void)q, (void)ldm;
  M[0] = mass_of(user);
  return 0;
}

int force(double t, const double *q, const double *v, double *F, void *user)
{
  (void)t, (void)q, (void)v;
  F[0] = -mass_of(user) * 9.81;
  return 0;
}

int gap(double t, const double *q, double *g, void *user)
{
  (void)t, (void)user;
  g[0] = q[0];
  return 0;
}

int drive(double t, double *f, void *user)
{
  (void)user;
  f[0] = 2 * t;
  f[1] = 2;
  f[2] = 0;
  return 0;
}
