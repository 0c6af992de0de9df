#include "cpp_pendulum.h"

#include <math.h>
#include <string.h>

#include <nsdae/nsdae.h>

/* A uniform rod, L = 1 m, m = 4.9 kg, released at 1.57 rad: see drivers/models/pendulum.c. */

static int mass(double t, const double *q, double *M, int ldm, void *user)
{
  (void)t, (void)q, (void)user;
  M[0] = M[ldm + 1] = 4.9;
  M[2 * ldm + 2] = 4.9 / 12;
  return 0;
}

static int force(double t, const double *q, const double *v, double *F, void *user)
{
  (void)t, (void)q, (void)v, (void)user;
  F[1] = -4.9 * 9.8;
  return 0;
}

static int constraint(double t, const double *q, double *phi, void *user)
{
  (void)t, (void)user;
  phi[0] = q[0] - 0.5 * sin(q[2]);
  phi[1] = q[1] + 0.5 * cos(q[2]);
  return 0;
}

static int jacobian(double t, const double *q, double *J, int ldj, void *user)
{
  (void)t, (void)user;
  J[0] = J[ldj + 1] = 1;
  J[2 * ldj] = -0.5 * cos(q[2]);
  J[2 * ldj + 1] = -0.5 * sin(q[2]);
  return 0;
}

static int bias(double t, const double *q, const double *v, double *phi_t, double *omega,
                void *user)
{
  (void)t, (void)phi_t, (void)user;
  omega[0] = 0.5 * sin(q[2]) * v[2] * v[2];
  omega[1] = -0.5 * cos(q[2]) * v[2] * v[2];
  return 0;
}

static int gap(double t, const double *q, double *g, void *user)
{
  (void)t, (void)user;
  g[0] = sin(q[2]);
  return 0;
}

static int observe(const nsdae_record *now, nsdae_error *error, void *user)
{
  double **row = user;
  const double head[] = {now->time};
  (void)error;
  memcpy(*row, head, sizeof head);
  memcpy(*row + 1, now->q, 3 * sizeof *now->q);
  memcpy(*row + 4, now->v, 3 * sizeof *now->v);
  memcpy(*row + 7, now->multiplier, 2 * sizeof *now->multiplier);
  memcpy(*row + 9, now->normal_impulse, sizeof *now->normal_impulse);
  *row += PENDULUM_ROW;
  return 0;
}

int pendulum_in_c(double row[][PENDULUM_ROW])
{
  const nsdae_dims dims = {.nq = 3, .m = 2, .k = 1};
  const double q0[] = {0.5 * sin(1.57), -0.5 * cos(1.57), 1.57}, v0[3] = {0};
  nsdae_system *system;
  nsdae_sim *sim;
  double *next = row[0];
  if (nsdae_system_create(&dims, &system, NULL) < 0) return 0;
  nsdae_system_set_mass(system, mass);
  nsdae_system_set_force(system, force);
  nsdae_system_set_constraint(system, constraint);
  nsdae_system_set_constraint_jacobian(system, jacobian);
  nsdae_system_set_constraint_bias(system, bias);
  nsdae_system_set_gap(system, gap);
  nsdae_system_set_contact(system, 0, 0, 0.56, 0);
  if (nsdae_sim_create(system, NULL, &sim, NULL) == NSDAE_OK) {
    nsdae_sim_init(sim, 0, q0, v0);
    nsdae_sim_observe(sim, observe, &next);
    nsdae_sim_run(sim, 0.005 * (PENDULUM_STEPS - 1));
  }
  nsdae_sim_destroy(&sim);
  nsdae_system_destroy(&system);
  return (int)(next - row[0]) / PENDULUM_ROW;
}
