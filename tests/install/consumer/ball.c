/* A ball that falls on a floor: time, height and velocity after every step, to the last bit. */
#include <inttypes.h>
#include <nsdae/nsdae.h>
#include <stdio.h>
#include <string.h>

static int mass(double t, const double *q, double *M, int ldm, void *user)
{
  (void)t, (void)q, (void)ldm, (void)user;
  M[0] = 0.1;
  return 0;
}

static int force(double t, const double *q, const double *v, double *F, void *user)
{
  (void)t, (void)q, (void)v, (void)user;
  F[0] = -0.1 * 9.81;
  return 0;
}

static int gap(double t, const double *q, double *g, void *user)
{
  (void)t, (void)user;
  g[0] = q[0];
  return 0;
}

static int print(const nsdae_record *now, nsdae_error *error, void *user)
{
  const double value[] = {now->time, now->q[0], now->v[0]};
  uint64_t bits[3];
  (void)error, (void)user;
  memcpy(bits, value, sizeof bits);
  printf("%016" PRIX64 " %016" PRIX64 " %016" PRIX64 "\n", bits[0], bits[1], bits[2]);
  return 0;
}

int main(void)
{
  const nsdae_dims dims = {.nq = 1, .k = 1};
  const double height = 1, rest = 0;
  nsdae_system *system;
  nsdae_sim *sim;
  nsdae_system_create(&dims, &system, NULL);
  nsdae_system_set_mass(system, mass);
  nsdae_system_set_force(system, force);
  nsdae_system_set_gap(system, gap);
  nsdae_system_set_contact(system, 0, 0, 0.5, 0);
  nsdae_sim_create(system, NULL, &sim, NULL);
  nsdae_sim_observe(sim, print, NULL);
  nsdae_sim_init(sim, 0, &height, &rest);
  int status = nsdae_sim_run(sim, 2);
  nsdae_sim_destroy(&sim);
  nsdae_system_destroy(&system);
  return status != NSDAE_OK;
}
