/* M = diag(m, m),  F = [0, -m g],  Phi = (x^2 + y^2 - L^2) / (2 L): scaled as a length, so that the
 * multiplier is the force of the rod. */
#include "long_pendulum.h"

#include <stddef.h>

static int mass(double t, const double *q, double *M, int ldm, void *user)
{
  const long_pendulum *p = user;
  (void)t;
  (void)q;
  M[0] = M[ldm + 1] = p->m;
  return 0;
}

static int force(double t, const double *q, const double *v, double *F, void *user)
{
  const long_pendulum *p = user;
  (void)t;
  (void)q;
  (void)v;
  F[1] = -p->m * p->g;
  return 0;
}

static int constraint(double t, const double *q, double *phi, void *user)
{
  const long_pendulum *p = user;
  (void)t;
  phi[0] = (q[0] * q[0] + q[1] * q[1] - p->L * p->L) / (2 * p->L);
  return 0;
}

static int jacobian(double t, const double *q, double *J, int ldj, void *user)
{
  const long_pendulum *p = user;
  (void)t;
  J[0] = q[0] / p->L;
  J[ldj] = q[1] / p->L;
  return 0;
}

static int bias(double t, const double *q, const double *v, double *phi_t, double *omega,
                void *user)
{
  const long_pendulum *p = user;
  (void)t;
  (void)q;
  (void)phi_t;
  omega[0] = (v[0] * v[0] + v[1] * v[1]) / p->L;
  return 0;
}

static int potential(double t, const double *q, double *energy, void *user)
{
  const long_pendulum *p = user;
  (void)t;
  *energy = p->m * p->g * q[1];
  return 0;
}

void long_pendulum_default(long_pendulum *p)
{
  *p = (long_pendulum){.L = 1, .m = 1, .g = 9.81};
}

nsdae_system *long_pendulum_system(long_pendulum *p)
{
  const nsdae_dims dims = {.nq = 2, .m = 1};
  nsdae_system *s;
  if (nsdae_system_create(&dims, &s, NULL) < 0) return NULL;
  nsdae_system_set_user(s, p);
  nsdae_system_set_mass(s, mass);
  nsdae_system_set_force(s, force);
  nsdae_system_set_constraint(s, constraint);
  nsdae_system_set_constraint_jacobian(s, jacobian);
  nsdae_system_set_constraint_bias(s, bias);
  nsdae_system_set_potential(s, potential);
  return s;
}

void long_pendulum_start(const long_pendulum *p, double q0[2], double v0[2])
{
  q0[0] = p->L;
  q0[1] = v0[0] = v0[1] = 0;
}
