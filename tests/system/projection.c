/* The option projection: what is projected stays at rounding, as long as one likes, and what that
 * does is in the energy balance. NSDAE_LONG=1 runs the million steps. */
#include "check.h"

#include <stdlib.h>
#include <string.h>

#include "rods.h"

static const int in_steps[] = {NSDAE_METHOD_IMPLICIT, NSDAE_METHOD_IMPLICIT_PRINTED,
                               NSDAE_METHOD_MOREAU};

/* What ends the projection: 16 eps (1 + |row| max |q|), with rows of up to 1.5 and angles up
 * to 1.6. */
static const double rounding = 1.2e-14;

static double steps(double few)
{
  const char *asked = getenv("NSDAE_LONG");
  return asked && *asked == '1' ? 1e6 : few;
}

static nsdae_sim *make(nsdae_system *system, int method, double dt, int projection)
{
  nsdae_sim_options options;
  nsdae_sim *sim = NULL;
  nsdae_sim_options_default(&options);
  options.method = method;
  options.dt = dt;
  options.projection = projection;
  assert_int_equal(nsdae_sim_create(system, &options, &sim, NULL), NSDAE_OK);
  return sim;
}

/* The rod swings from the horizontal with moreau at dt = 1 ms: without the projection it is 1e-2
 * long after 2 10^4 steps, with it to rounding. Its energy is the method's own matter;
 * balance = energy + dissipated - start has the projection's work on both sides, so that it is what
 * the method alone did: first order, here of a relative 1e-3 per swing at most. */
static void test_rod(void **state)
{
  (void)state;
  const double dt = 1e-3, count = steps(2e4);
  for (int i = 0; i < 3; i++) {
    rod r = {.wall = -2};
    nsdae_system *system = rod_system(&r);
    double q[3], v[3], drift[2];
    rod_start(1.5707963267948966, 0, q, v);
    for (int projection = 0; projection < 2; projection++) {
      nsdae_sim *sim = make(system, in_steps[i], dt, projection);
      nsdae_stats stats;
      nsdae_record now;
      assert_int_equal(nsdae_sim_init(sim, 0, q, v), NSDAE_OK);
      assert_true(nsdae_sim_run(sim, count * dt) >= 0);
      nsdae_sim_get_stats(sim, &stats);
      nsdae_sim_get_record(sim, &now);
      drift[projection] = stats.worst_drift;
      if (projection) {
        assert_near(hypot(now.v[0], now.v[1]), fabs(now.v[2]) / 2, 1e-13);
        assert_near(stats.energy_balance,
                    now.kinetic + now.potential + now.dissipated - stats.energy_start, 1e-12);
      }
      nsdae_sim_destroy(&sim);
    }
    assert_at_most(drift[1], rounding);
    assert_true(drift[0] > 1e-9); /* so that there was something to do */
    nsdae_system_destroy(&system);
  }
}

/* A free body that tumbles for 100 s: without the projection its quaternion's length drifts, with
 * it it keeps the length of the start, and its angular momentum in space is as good as without. */
static void test_quaternion(void **state)
{
  (void)state;
  const double dt = 0.01;
  for (int i = 0; i < 3; i++) {
    nsdae_system *system = body_system();
    double off[2], turned[2];
    for (int projection = 0; projection < 2; projection++) {
      nsdae_sim *sim = make(system, in_steps[i], dt, projection);
      const double q[7] = {0, 0, 1e5, 1}, v[6] = {0, 0, 0, 2, 0.1, 1};
      double start[3], end[3], sum = 0;
      nsdae_record now;
      assert_int_equal(nsdae_sim_init(sim, 0, q, v), NSDAE_OK);
      assert_true(nsdae_sim_run(sim, 100) >= 0);
      nsdae_sim_get_record(sim, &now);
      for (int j = 3; j < 7; j++) sum += now.q[j] * now.q[j];
      off[projection] = fabs(sqrt(sum) - 1);
      body_momentum(q, v, start);
      body_momentum(now.q, now.v, end);
      turned[projection] = 0;
      for (int j = 0; j < 3; j++) turned[projection] += fabs(end[j] - start[j]);
      nsdae_sim_destroy(&sim);
    }
    assert_at_most(off[1], 4e-16);
    assert_true(off[0] > 1e-9);
    assert_at_most(turned[1], 1.5 * turned[0] + 1e-9);
    nsdae_system_destroy(&system);
  }
}

/* Contacts that were closed end on the surface: the rod falls on its stop, e = 0, and lies there.
 */
static void test_contacts(void **state)
{
  (void)state;
  for (int i = 0; i < 3; i++)
    for (int projection = 1; projection <= 2; projection++) {
      rod r = {.wall = 0.3};
      nsdae_system *system = rod_system(&r);
      nsdae_sim *sim = make(system, in_steps[i], 4e-3, projection);
      double q[3], v[3];
      nsdae_record now;
      nsdae_stats stats;
      rod_start(1, 0, q, v);
      assert_int_equal(nsdae_sim_init(sim, 0, q, v), NSDAE_OK);
      assert_true(nsdae_sim_run(sim, 2) >= 0);
      nsdae_sim_get_record(sim, &now);
      nsdae_sim_get_stats(sim, &stats);
      const int printed = in_steps[i] == NSDAE_METHOD_IMPLICIT_PRINTED;
      if (projection == NSDAE_PROJECTION_CONTACTS)
        assert_at_most(now.penetration, printed ? 0.75 * 9.81 * 16e-6 : rounding);
      else
        assert_true(now.penetration > 1e-6);
      assert_at_most(stats.worst_drift, rounding);
      /* at rest, the energy of the stop's height: what was lost is in dissipated */
      if (!printed) assert_near(now.kinetic, 0, 1e-20);
      if (projection == NSDAE_PROJECTION_CONTACTS && !printed)
        assert_near(now.potential, -9.81 * sqrt(1 - 0.09) / 2, 1e-13);
      nsdae_sim_destroy(&sim);
      nsdae_system_destroy(&system);
    }
}

/* penalty and event keep their constraints by themselves: the option is refused by its name. */
static void test_integrators(void **state)
{
  const int others[] = {NSDAE_METHOD_PENALTY, NSDAE_METHOD_EVENT};
  rod r = {.wall = 0.3, .e = 0.5};
  nsdae_system *system = rod_system(&r);
  (void)state;
  for (int i = 0; i < 2; i++)
    for (int projection = 0; projection <= NSDAE_PROJECTION_DEPTHS; projection++) {
      nsdae_sim_options options;
      nsdae_sim *sim = NULL;
      nsdae_error error;
      nsdae_sim_options_default(&options);
      options.method = others[i];
      options.projection = projection;
      int status = nsdae_sim_create(system, &options, &sim, &error);
      if (projection == NSDAE_PROJECTION_NONE) {
        assert_true(status == NSDAE_OK || status == NSDAE_E_UNSUPPORTED);
      } else {
        assert_int_equal(status, NSDAE_E_ARGUMENT);
        assert_string_equal(error.argument, "projection");
        assert_non_null(strstr(error.text, nsdae_method_name(others[i])));
      }
      nsdae_sim_destroy(&sim);
    }
  nsdae_system_destroy(&system);
}

/* The constraint forces of the rod as it swings through the vertical: the mean force of a step has
 * the impulse of the projection. Beside the accurate ones of implicit without it, first order. */
static void test_forces(void **state)
{
  (void)state;
  double accurate[2] = {0};
  for (int i = 2 * 3 - 1; i >= 0; i--) { /* implicit without projection first */
    int method = in_steps[2 - i / 2], projection = 1 - i % 2;
    rod r = {.wall = -2};
    nsdae_system *system = rod_system(&r);
    double q[3], v[3];
    rod_start(1.5707963267948966, 0, q, v);
    nsdae_sim *sim = make(system, method, 1e-3, projection);
    nsdae_record now;
    assert_int_equal(nsdae_sim_init(sim, 0, q, v), NSDAE_OK);
    assert_true(nsdae_sim_run(sim, 0.6) >= 0);
    nsdae_sim_get_record(sim, &now);
    if (i == 2 * 3 - 1) memcpy(accurate, now.multiplier, sizeof accurate);
    assert_true(hypot(accurate[0], accurate[1]) > 1);
    for (int j = 0; j < 2; j++)
      assert_near(now.multiplier[j], accurate[j], 5e-3 * hypot(accurate[0], accurate[1]));
    nsdae_sim_destroy(&sim);
    nsdae_system_destroy(&system);
  }
}

int main(void)
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(test_rod),         cmocka_unit_test(test_forces),
      cmocka_unit_test(test_quaternion),  cmocka_unit_test(test_contacts),
      cmocka_unit_test(test_integrators),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
