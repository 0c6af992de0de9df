#include "rods.h"

#include <math.h>
#include <stddef.h>

static int rod_mass(double t, const double *q, double *M, int ldm, void *user)
{
  (void)t, (void)q, (void)user;
  M[0] = M[ldm + 1] = 1;
  M[2 * ldm + 2] = 1.0 / 12;
  return 0;
}

static int rod_force(double t, const double *q, const double *v, double *F, void *user)
{
  (void)t, (void)q, (void)v, (void)user;
  F[1] = -9.81;
  return 0;
}

static int rod_potential(double t, const double *q, double *energy, void *user)
{
  (void)t, (void)user;
  *energy = 9.81 * q[1];
  return 0;
}

static int rod_constraint(double t, const double *q, double *phi, void *user)
{
  (void)t, (void)user;
  phi[0] = q[0] - sin(q[2]) / 2;
  phi[1] = q[1] + cos(q[2]) / 2;
  return 0;
}

static int rod_jacobian(double t, const double *q, double *J, int ldj, void *user)
{
  (void)t, (void)user;
  J[0] = J[ldj + 1] = 1;
  J[2 * ldj] = -cos(q[2]) / 2;
  J[2 * ldj + 1] = -sin(q[2]) / 2;
  return 0;
}

static int rod_bias(double t, const double *q, const double *v, double *phi_t, double *omega,
                    void *user)
{
  (void)t, (void)phi_t, (void)user;
  omega[0] = sin(q[2]) / 2 * v[2] * v[2];
  omega[1] = -cos(q[2]) / 2 * v[2] * v[2];
  return 0;
}

static int rod_gap(double t, const double *q, double *g, void *user)
{
  const rod *r = user;
  (void)t;
  g[0] = sin(q[2]) - r->wall;
  return 0;
}

static int rod_normal(double t, const double *q, double *W, int ldw, void *user)
{
  (void)t, (void)ldw, (void)user;
  W[2] = cos(q[2]);
  return 0;
}

nsdae_system *rod_system(rod *r)
{
  const nsdae_dims dims = {.nq = 3, .m = 2, .k = 1};
  nsdae_system *s = NULL;
  if (nsdae_system_create(&dims, &s, NULL) < 0) return NULL;
  nsdae_system_set_user(s, r);
  nsdae_system_set_mass(s, rod_mass);
  nsdae_system_set_force(s, rod_force);
  nsdae_system_set_potential(s, rod_potential);
  nsdae_system_set_constraint(s, rod_constraint);
  nsdae_system_set_constraint_jacobian(s, rod_jacobian);
  nsdae_system_set_constraint_bias(s, rod_bias);
  nsdae_system_set_gap(s, rod_gap);
  nsdae_system_set_gap_normal(s, rod_normal);
  nsdae_system_set_contact(s, 0, 0, r->e, 0);
  nsdae_system_set_name(s, NSDAE_NAME_CONSTRAINT, 0, "pivot_x", "m");
  nsdae_system_set_name(s, NSDAE_NAME_CONSTRAINT, 1, "pivot_y", "m");
  nsdae_system_set_name(s, NSDAE_NAME_CONTACT, 0, "stop", "m");
  return s;
}

void rod_start(double theta, double omega, double q0[3], double v0[3])
{
  q0[0] = sin(theta) / 2;
  q0[1] = -cos(theta) / 2;
  q0[2] = theta;
  v0[0] = cos(theta) / 2 * omega;
  v0[1] = sin(theta) / 2 * omega;
  v0[2] = omega;
}

static const double inertia[3] = {1, 2, 3};

static int body_mass(double t, const double *q, double *M, int ldm, void *user)
{
  (void)t, (void)q, (void)user;
  for (int i = 0; i < 6; i++) M[i * ldm + i] = i < 3 ? 2 : inertia[i - 3];
  return 0;
}

/* Gravity, and Euler's -omega x (J omega). */
static int body_force(double t, const double *q, const double *v, double *F, void *user)
{
  const double *w = v + 3;
  (void)t, (void)q, (void)user;
  F[2] = -2 * 9.81;
  for (int i = 0; i < 3; i++) {
    int j = (i + 1) % 3, k = (i + 2) % 3;
    F[3 + i] = (inertia[j] - inertia[k]) * w[j] * w[k];
  }
  return 0;
}

static int body_potential(double t, const double *q, double *energy, void *user)
{
  (void)t, (void)user;
  *energy = 2 * 9.81 * q[2];
  return 0;
}

/* e' = e o (0, omega) / 2 */
static int body_kinematics(double t, const double *q, const double *v, double *qdot, void *user)
{
  const double *e = q + 3, *w = v + 3;
  (void)t, (void)user;
  for (int i = 0; i < 3; i++) qdot[i] = v[i];
  qdot[3] = -(e[1] * w[0] + e[2] * w[1] + e[3] * w[2]) / 2;
  qdot[4] = (e[0] * w[0] + e[2] * w[2] - e[3] * w[1]) / 2;
  qdot[5] = (e[0] * w[1] + e[3] * w[0] - e[1] * w[2]) / 2;
  qdot[6] = (e[0] * w[2] + e[1] * w[1] - e[2] * w[0]) / 2;
  return 0;
}

static int body_gap(double t, const double *q, double *g, void *user)
{
  (void)t, (void)user;
  g[0] = q[2] - 0.1;
  return 0;
}

nsdae_system *body_system(void)
{
  const nsdae_dims dims = {.nq = 7, .nv = 6, .k = 1};
  nsdae_system *s = NULL;
  if (nsdae_system_create(&dims, &s, NULL) < 0) return NULL;
  nsdae_system_set_mass(s, body_mass);
  nsdae_system_set_force(s, body_force);
  nsdae_system_set_potential(s, body_potential);
  nsdae_system_set_kinematics(s, body_kinematics);
  nsdae_system_set_gap(s, body_gap);
  nsdae_system_set_contact(s, 0, 0, 1, 0);
  return s;
}

/* e o (0, J omega) o e*, over |e|^2 */
void body_momentum(const double q[7], const double v[6], double L[3])
{
  const double *e = q + 3;
  double a[3], c[3], dot = 0, ee = 0, square = e[0] * e[0];
  for (int i = 0; i < 3; i++) {
    a[i] = inertia[i] * v[3 + i];
    dot += e[1 + i] * a[i];
    ee += e[1 + i] * e[1 + i];
  }
  square += ee;
  for (int i = 0; i < 3; i++) {
    int j = (i + 1) % 3, k = (i + 2) % 3;
    c[i] = e[1 + j] * a[k] - e[1 + k] * a[j];
  }
  for (int i = 0; i < 3; i++)
    L[i] = ((e[0] * e[0] - ee) * a[i] + 2 * dot * e[1 + i] + 2 * e[0] * c[i]) / square;
}
