/* Motions that decay until their velocities are below 1e-308, where doubles keep fewer and fewer
 * digits: a run goes on through them. */
#include "check.h"

#include <nsdae/nsdae.h>

static const double square = 98696.0; /* (100 pi)^2 [1/s^2] */

static int mass(double t, const double *q, double *M, int ldm, void *user)
{
  (void)t, (void)q, (void)ldm, (void)user;
  M[0] = 1.6333333;
  return 0;
}

static int force(double t, const double *q, const double *v, double *f, void *user)
{
  (void)t, (void)v, (void)user;
  f[0] = -1.6333333 * square * q[0];
  return 0;
}

static int gap(double t, const double *q, double *g, void *user)
{
  (void)t, (void)user;
  g[0] = q[0];
  return 0;
}

/* Runs to t_end; the speed there. */
static double run(nsdae_system *system, int method, double dt, double t_end, const double *q,
                  const double *v)
{
  nsdae_sim_options options;
  nsdae_sim *sim;
  nsdae_record record;
  nsdae_sim_options_default(&options);
  options.method = method;
  options.dt = dt;
  assert_int_equal(nsdae_sim_create(system, &options, &sim, NULL), NSDAE_OK);
  assert_int_equal(nsdae_sim_init(sim, 0, q, v), NSDAE_OK);
  int status = nsdae_sim_run(sim, t_end);
  if (status < 0) print_error("%s\n", nsdae_sim_error(sim)->text);
  assert_true(status >= 0);
  assert_int_equal(nsdae_sim_get_record(sim, &record), NSDAE_OK);
  double speed = fabs(record.v[0]);
  nsdae_sim_destroy(&sim);
  return speed;
}

static const int stepping[] = {NSDAE_METHOD_IMPLICIT, NSDAE_METHOD_IMPLICIT_PRINTED,
                               NSDAE_METHOD_MOREAU};

/* An oscillator of 50 Hz on a stop at its position of rest, e_N = 1/2: half the speed every 10 ms,
 * so that all is below 1e-308 after 10.5 s. */
static void test_oscillator(void **state)
{
  (void)state;
  const nsdae_dims dims = {.nq = 1, .k = 1};
  const double q = 0.01, v = 0;
  nsdae_system *system;
  assert_int_equal(nsdae_system_create(&dims, &system, NULL), NSDAE_OK);
  nsdae_system_set_mass(system, mass);
  nsdae_system_set_force(system, force);
  nsdae_system_set_gap(system, gap);
  nsdae_system_set_contact(system, 0, 0, 0.5, 0);
  for (int k = 0; k < 3; k++) assert_true(run(system, stepping[k], 1e-4, 14, &q, &v) < 1e-307);
  nsdae_system_destroy(&system);
}

int main(void)
{
  const struct CMUnitTest tests[] = {cmocka_unit_test(test_oscillator)};
  return cmocka_run_group_tests(tests, NULL, NULL);
}
