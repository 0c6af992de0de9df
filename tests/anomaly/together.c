/* penalty: two balls that touch their floors at once, but for a gap below the rounding of a
 * coordinate, and come with 1 m/s. Each is a ball alone: the same first impact, e_N = 0.5 as far as
 * the law gives it, and no other between. */
#include "check.h"

#include <nsdae/nsdae.h>

static const double floor_at = 0.43;

static int mass(double t, const double *q, double *M, int ldm, void *user)
{
  (void)t;
  (void)q;
  (void)user;
  M[0] = M[ldm + 1] = 1;
  return 0;
}

static int force(double t, const double *q, const double *v, double *F, void *user)
{
  (void)t;
  (void)q;
  (void)v;
  (void)user;
  F[0] = F[1] = -9.81;
  return 0;
}

/* user: how far the second is away */
static int gap(double t, const double *q, double *g, void *user)
{
  (void)t;
  g[0] = q[0] - floor_at;
  g[1] = (q[1] - floor_at) + *(const double *)user;
  return 0;
}

static void fall_together(double apart)
{
  const nsdae_dims dims = {.nq = 2, .k = 2};
  const double q0[2] = {floor_at, floor_at}, v0[2] = {-1, -1};
  nsdae_sim_options options;
  nsdae_system *system;
  nsdae_sim *sim;
  nsdae_record r;
  int hits[2] = {0}, steps = 0;
  assert_int_equal(nsdae_system_create(&dims, &system, NULL), NSDAE_OK);
  nsdae_system_set_user(system, &apart);
  nsdae_system_set_mass(system, mass);
  nsdae_system_set_force(system, force);
  nsdae_system_set_gap(system, gap);
  for (int i = 0; i < 2; i++) nsdae_system_set_contact(system, i, 0, 0.5, 0);
  nsdae_sim_options_default(&options);
  options.method = NSDAE_METHOD_PENALTY;
  int status = nsdae_sim_create(system, &options, &sim, NULL);
  if (status == NSDAE_OK) status = nsdae_sim_init(sim, 0, q0, v0);
  /* the next impacts are at 2 v / g = 0.15 s */
  for (; steps < 20 && status >= 0; steps++) {
    status = nsdae_sim_step(sim);
    nsdae_sim_get_record(sim, &r);
    for (int i = 0; i < r.impacts && status >= 0; i++) {
      hits[r.impact[i].contact]++;
      assert_near(r.impact[i].velocity_before, -1, 1e-6);
      assert_true(r.impact[i].velocity_after > 0.5 && r.impact[i].normal_impulse > 1.5);
      /* the change of velocity and the weight over some 2 ms of contact: 2.94 (m^2 / (K^2 v))^(1/5)
       */
      assert_near(r.impact[i].normal_impulse, 1 + r.impact[i].velocity_after, 0.03);
    }
  }
  if (status != NSDAE_E_UNSUPPORTED) {
    assert_true(status >= 0);
    assert_int_equal(hits[0], 1);
    assert_int_equal(hits[1], 1);
    nsdae_sim_destroy(&sim);
  }
  nsdae_system_destroy(&system);
}

static void test_together(void **state)
{
  (void)state;
  const double apart[] = {0, 1e-300, 1e-18, 5e-17, 1e-16, 1e-15, 1e-13, 1e-10};
  for (size_t i = 0; i < sizeof apart / sizeof *apart; i++) fall_together(apart[i]);
}

int main(void)
{
  const struct CMUnitTest tests[] = {cmocka_unit_test(test_together)};
  return cmocka_run_group_tests(tests, NULL, NULL);
}
