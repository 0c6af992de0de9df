/* Friction in the pins of revolute joints, a torque of at most mu r |F|, against closed forms: by
 * event to 1e-10, by time stepping with its order. */
#include "check.h"

#include <stdlib.h>

#include <nsdae/nsdae.h>

#include "support/hung_bodies.h"
#include "support/random.h"

static const double pi = 3.14159265358979324, mass = 2, J = 0.5, mu = 0.3;

/* A body of 2 kg and 0.5 kg m^2 at the distance e along x from its pin at (0, 0, 0), with friction
 * in the pin of this radius. */
static nsdae_bodies *pinned(int d, double e, double w, double radius, double gravity)
{
  nsdae_bodies *b = create(d, 0, gravity, 0);
  nsdae_bodies_add(b, &(nsdae_rigid_body){.mass = mass,
                                          .inertia = {J, J, J},
                                          .position = {e},
                                          .velocity = {0, e * w},
                                          .spin = {0, 0, w}});
  nsdae_joint pin = {.kind = NSDAE_JOINT_REVOLUTE,
                     .body = {NSDAE_GROUND, 0},
                     .axis = {0, 0, d == 3},
                     .mu = mu,
                     .radius = radius};
  if (nsdae_bodies_add_joint(b, &pin) < 0) fail_msg("%s", nsdae_bodies_error(b)->text);
  return b;
}

static double off(int d, const ending *end, double angle, double rate)
{
  return fmax(fabs(remainder(angle_of(d, end->q) - angle, 2 * pi)),
              fabs(end->v[d == 2 ? 2 : 5] - rate));
}

/* A wheel whose pin carries its weight: omega' = -mu r m g / J until it is at rest. */
static double wheel(int d, int method, double dt)
{
  const double g = 10, r = 0.1, w = 3, brake = mu * r * mass * g / J, rest = w / brake;
  ending end = run(pinned(d, 0, w, r, -g), method, dt, 3);
  if (method == NSDAE_METHOD_EVENT) assert_near(end.changed, rest, 1e-10);
  assert_near(end.v[d == 2 ? 2 : 5], 0, 1e-12);
  return off(d, &end, w * rest / 2, 0);
}

/* A rotor with its centre at the distance e, without weight: F = m e (omega^2, alpha). With I = J +
 * m e^2 and k = mu r m e, I alpha = -k |(omega^2, alpha)| is omega' = -c omega^2,
 * c = k / sqrt(I^2 - k^2):  omega = w / (1 + c w t), angle ln(1 + c w t) / c. */
static double reach; /* mu r e m / I: by how much the substitution contracts */

static double rotor(int d, int method, double dt)
{
  const double e = 0.4, w = 4, t = 1, I = J + mass * e * e, k = reach * I;
  const double c = k / sqrt(I * I - k * k);
  ending end = run(pinned(d, e, w, k / (mu * mass * e), 0), method, dt, t);
  return off(d, &end, log(1 + c * w * t) / c, w / (1 + c * w * t));
}

static void test_slips(void **state)
{
  (void)state;
  for (int d = 2; d <= 3; d++) {
    judge(wheel, d, 20);
    for (reach = 0.01; reach < 0.6; reach *= 7) judge(rotor, d, 50);
  }
}

/* The friction circle: a body at rest stays while its weight acts within mu r of the centre of the
 * pin. */
static void test_circle(void **state)
{
  (void)state;
  const double r = 0.1, g = 10;
  for (int method = NSDAE_METHOD_IMPLICIT; method <= NSDAE_METHOD_EVENT; method++)
    for (int d = 2; d <= 3; d++)
      for (int slips = 0; slips <= 1; slips++) {
        if (method == NSDAE_METHOD_PENALTY) continue; /* it has no stick */
        double e = mu * r * (slips ? 1.001 : 0.999);
        ending end = run(pinned(d, e, 0, r, -g), method, 0.01, 1);
        if (slips)
          assert_true(angle_of(d, end.q) < -1e-4);
        else
          assert_near(angle_of(d, end.q), 0, 1e-15);
      }
}

/* ---- a four-bar linkage with friction in its four pins, a motor, and a limit where it is not 0 */

static double unlike; /* cone_excess of the last run, relative to its impulses */

static double crank(int d, int method, double dt, int integrator, double limit)
{
  static const double x[4][2] = {{0, 0}, {0.3, 0.4}, {1.2, 0.9}, {1.3, 0}};
  nsdae_bodies *b = create(d, 0, -9.81, 0);
  nsdae_system *system;
  nsdae_sim *sim;
  nsdae_record r;
  nsdae_stats stats;
  nsdae_sim_options o;
  double q[NQ_MAX], v[NV_MAX];
  for (int i = 0; i < 3; i++)
    nsdae_bodies_add(b, &(nsdae_rigid_body){.mass = 1,
                                            .inertia = {0.1, 0.1, 0.1},
                                            .position = {(x[i][0] + x[i + 1][0]) / 2,
                                                         (x[i][1] + x[i + 1][1]) / 2}});
  for (int i = 0; i < 4; i++)
    nsdae_bodies_add_joint(b, &(nsdae_joint){.kind = NSDAE_JOINT_REVOLUTE,
                                             .body = {i - 1, i == 3 ? NSDAE_GROUND : i},
                                             .point = {x[i][0], x[i][1]},
                                             .axis = {0, 0, d == 3},
                                             .mu = mu,
                                             .radius = 0.05});
  nsdae_bodies_add_motor(b, &(nsdae_motor){.target = 6, .limit = INFINITY});
  if (limit > 0)
    nsdae_bodies_add_limit(b, &(nsdae_limit){.joint = 3, .low = -limit, .high = limit, .e_n = 0.5});
  assert_true(nsdae_bodies_system(b, &system) >= 0);
  nsdae_bodies_get_start(b, q, v);
  nsdae_sim_options_default(&o);
  o.method = method;
  o.dt = dt;
  o.rtol = 1e-10;
  o.atol = 1e-12;
  o.integrator = integrator;
  if (d == 3) o.redundant = NSDAE_REDUNDANT_LEAST_NORM;
  assert_int_equal(nsdae_sim_create(system, &o, &sim, NULL), NSDAE_OK);
  assert_int_equal(nsdae_sim_init(sim, 0, q, v), NSDAE_OK);
  int status = nsdae_sim_run(sim, 0.4);
  if (status != NSDAE_OK) fail_msg("%s", nsdae_sim_error(sim)->text);
  nsdae_sim_get_record(sim, &r);
  nsdae_sim_get_stats(sim, &stats);
  assert_true(r.dissipated > 0.1);
  assert_int_equal(stats.impacts > 0, limit > 0);
  unlike = stats.certificate.cone_excess;
  double angle = angle_of(d, r.q);
  nsdae_sim_destroy(&sim);
  nsdae_system_destroy(&system);
  nsdae_bodies_destroy(&b);
  return angle;
}

/* Explicit and implicit integrator of event, and time stepping with its order. In space 2 rows of
 * each pin but one are redundant, and the forces in the plane are not. */
static void test_linkage(void **state)
{
  (void)state;
  for (int d = 2; d <= 3; d++) {
    double angle = crank(d, NSDAE_METHOD_EVENT, 1e-2, NSDAE_INTEGRATOR_DOPRI5, 0), error[2];
    assert_near(crank(d, NSDAE_METHOD_EVENT, 1e-2, NSDAE_INTEGRATOR_IDA, 0), angle, 1e-7);
    for (int method = NSDAE_METHOD_IMPLICIT; method <= NSDAE_METHOD_MOREAU; method++) {
      for (int i = 0; i < 2; i++) {
        error[i] = fabs(crank(d, method, 2e-3 / (1 + i), NSDAE_INTEGRATOR_AUTO, 0) - angle);
        assert_at_most(unlike, 1e-11);
      }
      assert_at_most(error[0], method == NSDAE_METHOD_IMPLICIT ? 1e-3 : 0.1);
      assert_at_most(error[1], error[0] / (method == NSDAE_METHOD_IMPLICIT ? 2.9 : 1.6));
    }
  }
}

/* In impacts the impulse of the pins is at most mu r |Lambda|. */
static void test_impacts(void **state)
{
  (void)state;
  double angle = crank(2, NSDAE_METHOD_EVENT, 1e-2, NSDAE_INTEGRATOR_DOPRI5, 0.2);
  for (int method = NSDAE_METHOD_IMPLICIT; method <= NSDAE_METHOD_MOREAU; method++) {
    assert_near(crank(2, method, 5e-4, NSDAE_INTEGRATOR_AUTO, 0.2), angle, 2e-2);
    assert_at_most(unlike, 1e-11);
  }
}

/* ---- a rotor on a sled that slides on a floor with friction: in space, with constraints that
 * drift and are projected */

static double sled(int method, double dt)
{
  nsdae_bodies *b = create(3, 0, 0, -9.81);
  nsdae_bodies_add(b, &(nsdae_rigid_body){.mass = 5,
                                          .inertia = {0.2, 0.3, 0.4},
                                          .position = {0, 0, 0.1},
                                          .velocity = {2, 0.3, 0}});
  nsdae_bodies_add(b, &(nsdae_rigid_body){.mass = 1,
                                          .inertia = {0.02, 0.02, 0.02},
                                          .position = {0.2, 0, 0.4},
                                          .velocity = {2, 0.3, -2},
                                          .spin = {0, 10, 0}});
  nsdae_bodies_add_joint(
      b, &(nsdae_joint){
             .body = {0, 1}, .point = {0, 0, 0.4}, .axis = {0, 1, 0}, .mu = mu, .radius = 0.05});
  nsdae_bodies_add_solid(b, 0, &(nsdae_solid){.shape = NSDAE_SHAPE_BOX, .length = {0.6, 0.4, 0.2}});
  nsdae_bodies_add_solid(b, NSDAE_GROUND, &(nsdae_solid){.shape = NSDAE_SHAPE_PLANE});
  nsdae_bodies_add_contact(b, 1, 0, 0.2, 0, 0);
  return run(b, method, dt, 0.25).v[10];
}

static void test_sled(void **state)
{
  (void)state;
  double rate = sled(NSDAE_METHOD_EVENT, 1e-2), error[2];
  for (int method = NSDAE_METHOD_IMPLICIT; method <= NSDAE_METHOD_MOREAU; method++) {
    for (int i = 0; i < 2; i++) error[i] = fabs(sled(method, 2e-3 / (1 + i)) - rate);
    assert_at_most(error[1], error[0] / 1.6);
    assert_at_most(error[1], method == NSDAE_METHOD_IMPLICIT ? 1e-3 : 0.3);
  }
}

/* ---- a pendulum that comes to rest on a stop: stop and friction share the load in any parts,
 * and the last rebounds are below the tolerance; each step is solved */

static void test_stop(void **state)
{
  (void)state;
  for (int brake = 0; brake <= 1; brake++)
    for (int method = NSDAE_METHOD_IMPLICIT; method <= NSDAE_METHOD_MOREAU; method++)
      for (int i = 0; i < 9; i += test_share()) {
        nsdae_bodies *b = pinned(2, 0.15, 0, brake ? 1e-9 : 0.01, -9.81);
        nsdae_system *system;
        nsdae_sim *sim;
        nsdae_sim_options o;
        nsdae_record r;
        nsdae_stats stats;
        double q[3], v[3];
        if (brake)
          nsdae_bodies_add_motor(b, &(nsdae_motor){.kind = NSDAE_MOTOR_SPEED, .limit = 0.06});
        nsdae_bodies_add_limit(
            b, &(nsdae_limit){.low = -0.2, .high = 0.2, .e_n = 0.1 + 0.05 * i}); /* of joint 0 */
        assert_true(nsdae_bodies_system(b, &system) >= 0);
        nsdae_bodies_get_start(b, q, v);
        nsdae_sim_options_default(&o);
        o.method = method;
        o.dt = 1e-3;
        assert_int_equal(nsdae_sim_create(system, &o, &sim, NULL), NSDAE_OK);
        assert_int_equal(nsdae_sim_init(sim, 0, q, v), NSDAE_OK);
        if (nsdae_sim_run(sim, 2) != NSDAE_OK) fail_msg("%s", nsdae_sim_error(sim)->text);
        nsdae_sim_get_record(sim, &r);
        nsdae_sim_get_stats(sim, &stats);
        assert_int_equal(stats.inexact_steps, 0);
        assert_near(r.v[2], 0, 0);
        assert_near(r.q[2], -0.2, 1e-2);
        nsdae_sim_destroy(&sim);
        nsdae_system_destroy(&system);
        nsdae_bodies_destroy(&b);
      }
}

/* ---- an arch of links on two feet each, at rest by large pins: they share the load in any parts,
 * and each step finds one of them */

static nsdae_bodies *arch(int links, double radius, uint64_t seed)
{
  nsdae_bodies *b = create(3, 0, 0, -9.81);
  int floor = nsdae_bodies_add_solid(b, NSDAE_GROUND, &(nsdae_solid){.shape = NSDAE_SHAPE_PLANE});
  double end[2][2] = {{-0.8, 0.05}};
  for (int i = 0; i < links; i++) {
    double m = random_between(&seed, 0.5, 2), I = 0.05 * m, turn = pi * (1 - (i + 1.0) / links);
    end[1][0] = 0.8 * cos(turn);
    end[1][1] = 0.5 * sin(turn) + 0.05;
    const double at[2] = {(end[0][0] + end[1][0]) / 2, (end[0][1] + end[1][1]) / 2};
    nsdae_bodies_add(
        b, &(nsdae_rigid_body){.mass = m, .inertia = {I, I, I}, .position = {at[0], 0, at[1]}});
    if (i > 0)
      nsdae_bodies_add_joint(b, &(nsdae_joint){.body = {i - 1, i},
                                               .point = {end[0][0], 0, end[0][1]},
                                               .axis = {0, 1, 0},
                                               .mu = 0.5,
                                               .radius = radius});
    for (int foot = 0; foot < 2 && (i == 0 || i == links - 1); foot++) {
      const double *of = end[i > 0];
      nsdae_solid ball = {.shape = NSDAE_SHAPE_SPHERE,
                          .radius = 0.05,
                          .position = {of[0] - at[0], foot ? 0.2 : -0.2, of[1] - at[1]}};
      nsdae_bodies_add_contact(b, floor, nsdae_bodies_add_solid(b, i, &ball), 0.8, 0, 0);
    }
    memcpy(end[0], end[1], sizeof end[0]);
  }
  return b;
}

static void test_arch(void **state)
{
  (void)state;
  for (int links = 3; links <= 4; links++)
    for (int method = NSDAE_METHOD_IMPLICIT; method <= NSDAE_METHOD_MOREAU; method++)
      for (int i = 0; i < 8; i += test_share()) {
        ending end = run(arch(links, 0.15 + 0.1 * i, (uint64_t)i), method, 2e-3, 0.06);
        for (int j = 0; j < 6 * links; j++) assert_at_most(fabs(end.v[j]), 1e-9);
      }
}

/* ---- of a simulation that continues from a state, a control is set before the first step: its
 * lists of rows, six of a joint, are as short as at first */

static void test_continues(void **state)
{
  (void)state;
  for (int method = NSDAE_METHOD_IMPLICIT; method <= NSDAE_METHOD_EVENT; method++) {
    nsdae_system *system;
    nsdae_sim *sim[2];
    nsdae_sim_options o;
    nsdae_record r[2];
    double q[6], v[6];
    nsdae_bodies *b = pinned(2, 0.1, 4, 0.1, -9.81);
    nsdae_bodies_add(b, &(nsdae_rigid_body){.mass = 1,
                                            .inertia = {0, 0, 0.1},
                                            .position = {0.3},
                                            .velocity = {0, 1.2},
                                            .spin = {0, 0, 4}});
    nsdae_bodies_add_joint(b,
                           &(nsdae_joint){.body = {0, 1}, .point = {0.2}, .mu = mu, .radius = 0.1});
    nsdae_bodies_add_motor(
        b, &(nsdae_motor){.joint = 1, .kind = NSDAE_MOTOR_POSITION, .limit = 3, .kp = 20, .kd = 1});
    for (int i = 0; i < 4; i++)
      nsdae_bodies_add_motor(b,
                             &(nsdae_motor){.joint = 1, .kind = NSDAE_MOTOR_SPEED, .limit = 0.02});
    assert_true(nsdae_bodies_system(b, &system) >= 0);
    nsdae_bodies_get_start(b, q, v);
    nsdae_sim_options_default(&o);
    o.method = method;
    o.dt = 1e-2;
    for (int i = 0; i < 2; i++)
      assert_int_equal(nsdae_sim_create(system, &o, &sim[i], NULL), NSDAE_OK);
    assert_int_equal(nsdae_sim_init(sim[0], 0, q, v), NSDAE_OK);
    assert_true(nsdae_sim_run(sim[0], 0.1) >= 0);
    size_t size;
    assert_int_equal(nsdae_sim_state_size(sim[0], &size), NSDAE_OK);
    void *block = malloc(size);
    assert_int_equal(nsdae_sim_get_state(sim[0], block, size), NSDAE_OK);
    assert_int_equal(nsdae_sim_set_state(sim[1], block, size), NSDAE_OK);
    free(block);
    for (int i = 0; i < 2; i++) {
      assert_int_equal(nsdae_sim_set_control(sim[i], 0, 0.7), NSDAE_OK);
      assert_true(nsdae_sim_run(sim[i], 0.3) >= 0);
      nsdae_sim_get_record(sim[i], &r[i]);
    }
    assert_memory_equal(r[0].q, r[1].q, sizeof q);
    assert_memory_equal(r[0].v, r[1].v, sizeof v);
    for (int i = 0; i < 2; i++) nsdae_sim_destroy(&sim[i]);
    nsdae_system_destroy(&system);
    nsdae_bodies_destroy(&b);
  }
}

/* ---- a rotor whose pin has so large a friction circle that no torque solves the equations: with
 * time stepping an impulse stops it, the other methods return an error */

static void test_no_answer(void **state)
{
  (void)state;
  const double e = 0.4, I = J + mass * e * e;
  for (int method = NSDAE_METHOD_IMPLICIT; method <= NSDAE_METHOD_EVENT; method++) {
    nsdae_system *system;
    nsdae_sim *sim;
    nsdae_sim_options o;
    nsdae_record r;
    double q[3], v[3];
    nsdae_bodies *b = pinned(2, e, 4, 1.2 * I / (mu * mass * e), 0);
    assert_true(nsdae_bodies_system(b, &system) >= 0);
    nsdae_bodies_get_start(b, q, v);
    nsdae_sim_options_default(&o);
    o.method = method;
    o.dt = 1e-4;
    assert_int_equal(nsdae_sim_create(system, &o, &sim, NULL), NSDAE_OK);
    int status = nsdae_sim_init(sim, 0, q, v);
    if (status >= 0) status = nsdae_sim_run(sim, 0.1);
    nsdae_sim_get_record(sim, &r);
    int stops = method == NSDAE_METHOD_IMPLICIT || method == NSDAE_METHOD_MOREAU;
    assert_int_equal(status, stops ? NSDAE_OK : NSDAE_E_CONVERGENCE);
    if (stops) assert_near(r.v[2], 0, 0);
    if (method == NSDAE_METHOD_EVENT)
      assert_non_null(strstr(nsdae_sim_error(sim)->text, "friction circle of radius"));
    nsdae_sim_destroy(&sim);
    nsdae_system_destroy(&system);
    nsdae_bodies_destroy(&b);
  }
}

int main(void)
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(test_slips),    cmocka_unit_test(test_circle),
      cmocka_unit_test(test_linkage),  cmocka_unit_test(test_impacts),
      cmocka_unit_test(test_sled),     cmocka_unit_test(test_stop),
      cmocka_unit_test(test_arch),     cmocka_unit_test(test_continues),
      cmocka_unit_test(test_no_answer)};
  return cmocka_run_group_tests(tests, NULL, NULL);
}
