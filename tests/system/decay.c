/* Motions that decay until their velocities are below 1e-308, where doubles keep fewer and fewer
 * digits: a run goes on through them. Damping in one step of the midpoint rule. */
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

static int damping(double t, const double *q, const double *v, double *f, void *user)
{
  const double *c = user;
  (void)t, (void)q;
  f[0] = -*c * v[0];
  return 0;
}

/* v' = -c v in one step of moreau in p parts, x = c h / 2: v_1 / v_0 = ((1 - x/p) / (1 + x/p))^p.
 * The midpoint is found by substitution u := 1 - x/p u from 1, as long as its relative changes
 * decrease: p = 1 for x = 1/4; for x = 1 the changes 1/0 do not, those of p = 2 do; of x = 3 those
 * of p = 4, 3, 0.69, 1.08, do not. */
static void test_midpoint(void **state)
{
  static const struct {
    double x;
    int parts;
  } of[] = {{0.25, 1}, {1, 2}, {3, 8}};
  static const double tols[] = {1e-6, 1e-12};
  const nsdae_dims dims = {.nq = 1};
  (void)state;
  for (int i = 0; i < 6; i++) {
    const double h = 0.1, q = 0, v = 1, tol = tols[i % 2], part = of[i / 2].x / of[i / 2].parts;
    double c = 1.6333333 * 2 * of[i / 2].x / h;
    nsdae_system *system;
    nsdae_sim *sim;
    nsdae_sim_options options;
    nsdae_record record;
    assert_int_equal(nsdae_system_create(&dims, &system, NULL), NSDAE_OK);
    nsdae_system_set_user(system, &c);
    nsdae_system_set_mass(system, mass);
    nsdae_system_set_force(system, damping);
    nsdae_sim_options_default(&options);
    options.method = NSDAE_METHOD_MOREAU;
    options.dt = h;
    options.iteration_tol = tol;
    assert_int_equal(nsdae_sim_create(system, &options, &sim, NULL), NSDAE_OK);
    assert_int_equal(nsdae_sim_init(sim, 0, &q, &v), NSDAE_OK);
    assert_true(nsdae_sim_step(sim) >= 0);
    nsdae_sim_get_record(sim, &record);
    /* a change of tol in u leaves the error x/p / (1 + x/p) of it: 2/3 tol in v at most, each part
     */
    assert_near(record.v[0], pow((1 - part) / (1 + part), of[i / 2].parts), 1e-14 + 6 * tol);
    nsdae_sim_destroy(&sim);
    nsdae_system_destroy(&system);
  }
}

int main(void)
{
  const struct CMUnitTest tests[] = {cmocka_unit_test(test_oscillator),
                                     cmocka_unit_test(test_midpoint)};
  return cmocka_run_group_tests(tests, NULL, NULL);
}
