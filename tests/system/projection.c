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

/* A free body that tumbles for 100 s: without the projection its quaternion has the length of the
 * start to the rounding of 1e4 steps, with it to that of one, and its angular momentum in space is
 * as good as without. */
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
    assert_at_most(off[0], 1e4 * 4e-16);
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

/* ---- a block slides out along a slot with friction in an arm that turns with constant omega
 *
 *   r'' = omega^2 r - 2 mu omega r',  r = A e^(s t) + B e^(s' t),
 *   s = omega (-mu +- sqrt(1 + mu^2)): friction needs the whole Coriolis force */

static const double turning = 2, slot_mu = 0.5;

static int turn(double t, double f[3], void *user)
{
  (void)user;
  f[0] = turning * t;
  f[1] = turning;
  f[2] = 0;
  return 0;
}

/* The error of r and r' of r(0) = r'(0) = 1 at t = 0.5. */
static double slot_error(int method, int projection, double dt)
{
  nsdae_bodies *b;
  nsdae_system *system;
  nsdae_record now;
  double q[6], v[6];
  assert_int_equal(nsdae_bodies_create(2, &b, NULL), NSDAE_OK);
  nsdae_bodies_add(b,
                   &(nsdae_rigid_body){.mass = 1, .inertia = {1, 1, 1}, .spin = {0, 0, turning}});
  nsdae_bodies_add(
      b, &(nsdae_rigid_body){
             .mass = 2, .inertia = {1, 1, 1}, .position = {1, 0}, .velocity = {1, turning}});
  nsdae_bodies_add_joint(
      b, &(nsdae_joint){.kind = NSDAE_JOINT_REVOLUTE, .body = {NSDAE_GROUND, 0}, .drive = turn});
  nsdae_bodies_add_joint(b, &(nsdae_joint){.kind = NSDAE_JOINT_SLOT,
                                           .body = {0, 1},
                                           .point = {1, 0},
                                           .axis = {1, 0},
                                           .mu = slot_mu});
  assert_true(nsdae_bodies_system(b, &system) >= 0);
  nsdae_bodies_get_start(b, q, v);
  nsdae_sim *sim = make(system, method, dt, projection);
  if (nsdae_sim_init(sim, 0, q, v) < 0) fail_msg("%s", nsdae_sim_error(sim)->text);
  assert_true(nsdae_sim_run(sim, 0.5) >= 0);
  nsdae_sim_get_record(sim, &now);
  const double root = sqrt(1 + slot_mu * slot_mu), s = turning * (root - slot_mu),
               other = -turning * (root + slot_mu), A = (1 - other) / (s - other), B = 1 - A;
  const double r = A * exp(s * 0.5) + B * exp(other * 0.5),
               rate = A * s * exp(s * 0.5) + B * other * exp(other * 0.5);
  double x = now.q[3], y = now.q[4], along = (x * now.v[3] + y * now.v[4]) / hypot(x, y);
  double error = fmax(fabs(hypot(x, y) - r), fabs(along - rate));
  nsdae_sim_destroy(&sim);
  nsdae_system_destroy(&system);
  nsdae_bodies_destroy(&b);
  return error;
}

static void test_slot(void **state)
{
  (void)state;
  for (int i = 0; i < 3; i++)
    for (int projection = 0; projection < 2; projection++) {
      double error = slot_error(in_steps[i], projection, 4e-3);
      assert_at_most(slot_error(in_steps[i], projection, 1e-3), error / 3);
      assert_at_most(error, 4e-3 * 12); /* of first order: h max |r''|, which is below 12 */
    }
}

int main(void)
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(test_rod),         cmocka_unit_test(test_forces),
      cmocka_unit_test(test_quaternion),  cmocka_unit_test(test_contacts),
      cmocka_unit_test(test_integrators), cmocka_unit_test(test_slot),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
