/* A disc of zero thickness falls on its rim: gap = z - r |sin theta|, which has a kink at theta =
 * 0. The run ends there with an error that names the contact. Rounded by b the gap z - sqrt((r sin
 * theta)^2 + b^2) has none, and no run is told of one. */
#include "check.h"

#include <nsdae/nsdae.h>

#include "support/random.h"

static uint64_t seed;

static double uniform(double from, double to)
{
  return random_between(&seed, from, to);
}

typedef struct rim {
  double r, rounding;
} rim;

static int mass(double t, const double *q, double *M, int ldm, void *user)
{
  const rim *d = user;
  (void)t, (void)q;
  M[0] = 1;
  M[ldm + 1] = d->r * d->r / 4;
  return 0;
}

static int force(double t, const double *q, const double *v, double *F, void *user)
{
  (void)t, (void)q, (void)v, (void)user;
  F[0] = -9.81;
  return 0;
}

static int gap(double t, const double *q, double *g, void *user)
{
  const rim *d = user;
  (void)t;
  g[0] = q[0] - hypot(d->r * sin(q[1]), d->rounding);
  return 0;
}

static int fall(const rim *d, double theta, double dt, nsdae_error *error)
{
  const nsdae_dims dims = {.nq = 2, .k = 1};
  nsdae_system *system;
  nsdae_sim *sim;
  nsdae_sim_options o;
  rim copy = *d;
  const double q[2] = {hypot(d->r * sin(theta), d->rounding), theta}, v[2] = {0};
  assert_int_equal(nsdae_system_create(&dims, &system, NULL), NSDAE_OK);
  nsdae_system_set_user(system, &copy);
  nsdae_system_set_mass(system, mass);
  nsdae_system_set_force(system, force);
  nsdae_system_set_gap(system, gap);
  nsdae_system_set_contact(system, 0, 0, 0, 0);
  nsdae_sim_options_default(&o);
  o.method = NSDAE_METHOD_EVENT;
  o.dt = dt;
  assert_int_equal(nsdae_sim_create(system, &o, &sim, NULL), NSDAE_OK);
  int status = nsdae_sim_init(sim, 0, q, v);
  if (status == NSDAE_OK) status = nsdae_sim_run(sim, 0.6);
  *error = *nsdae_sim_error(sim);
  nsdae_sim_destroy(&sim);
  nsdae_system_destroy(&system);
  return status;
}

static void test_kink(void **state)
{
  (void)state;
  for (int i = 0; i < 40; i++) {
    nsdae_error error;
    seed = (unsigned)i + 1;
    const rim sharp = {uniform(0.05, 0.5), 0};
    double theta = uniform(0.3, 1.2);
    int status = fall(&sharp, theta, 1e-3, &error);
    if (!strstr(error.text, "contact 0: the gradient of its gap rotates"))
      print_error("%d: %d %s\n", i, status, error.text);
    assert_int_equal(status, NSDAE_E_CONVERGENCE);
    assert_non_null(strstr(error.text, "contact 0: the gradient of its gap rotates"));
    assert_int_equal(error.index, 0);
    const rim rounded = {sharp.r, sharp.r / 10};
    fall(&rounded, theta, 1e-3, &error);
    assert_null(strstr(error.text, "gradient"));
  }
}

int main(void)
{
  const struct CMUnitTest tests[] = {cmocka_unit_test(test_kink)};
  return cmocka_run_group_tests(tests, NULL, NULL);
}
