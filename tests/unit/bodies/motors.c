/* Motors, dry friction, brakes and clutches of joints against closed forms: by event to 1e-10, by
 * time stepping with its order. */
#include "check.h"

#include <nsdae/nsdae.h>

#include "support/hung_bodies.h"

static const double pi = 3.14159265358979324;

static int sine(double t, double f[3], void *user)
{
  (void)user;
  f[0] = sin(3 * t);
  f[1] = 3 * cos(3 * t);
  f[2] = -9 * sin(3 * t);
  return 0;
}

/* t^2: a bound of a clutch */
static int ramp(double t, double f[3], void *user)
{
  (void)user;
  f[0] = t * t;
  f[1] = 2 * t;
  f[2] = 2;
  return 0;
}

/* A wheel of J = 0.5 about z. */
static int wheel(nsdae_bodies *b, int d, double spin)
{
  return hang(b, d, NSDAE_JOINT_REVOLUTE, (nsdae_rigid_body){.spin = {0, 0, spin}});
}

static void add_motor(nsdae_bodies *b, nsdae_motor motor)
{
  int status = nsdae_bodies_add_motor(b, &motor);
  if (status < 0) fail_msg("%s", nsdae_bodies_error(b)->text);
}

static double off(int d, const ending *end, double angle, double rate)
{
  double wrong = remainder(angle_of(d, end->q) - angle, 2 * pi);
  return fmax(fabs(wrong), fabs(end->v[d == 2 ? 2 : 5] - rate));
}

/* ---- force motors */

/* A torque sin(3 t): the rate is (1 - cos 3 t) / (3 J), the angle (t - sin(3 t) / 3) / (3 J). */
static double driven(int d, int method, double dt)
{
  const double t = 2, J = 0.5;
  nsdae_bodies *b = create(d, 0, 0, 0);
  int joint = wheel(b, d, 0);
  add_motor(b, (nsdae_motor){joint, .limit = INFINITY, .drive = sine});
  ending end = run(b, method, dt, t);
  return off(d, &end, (t - sin(3 * t) / 3) / (3 * J), (1 - cos(3 * t)) / (3 * J));
}

/* A torque of 5 from a motor of at most 3. */
static double limited(int d, int method, double dt)
{
  const double t = 2, a = 3 / 0.5;
  nsdae_bodies *b = create(d, 0, 0, 0);
  int joint = wheel(b, d, 0);
  add_motor(b, (nsdae_motor){joint, .limit = 3, .target = 5});
  ending end = run(b, method, dt, t);
  return off(d, &end, a * t * t / 2, a * t);
}

static void test_force(void **state)
{
  (void)state;
  for (int d = 2; d <= 3; d++) {
    judge(driven, d, 10);
    judge(limited, d, 10);
  }
}

/* ---- speed motors */

/* From rest to the speed 4 with at most 3 N m: t_1 = J 4 / 3, then with this speed against a load
 * of 1 N m. */
static int load(double t, const double x[3], const double v[3], double force[3], double moment[3],
                void *user)
{
  (void)t, (void)x, (void)v, (void)force, (void)user;
  moment[2] = -1;
  return 0;
}

static double speed(int d, int method, double dt)
{
  const double t = 2, J = 0.5, w = 4, t1 = J * w / 2, origin[3] = {0, 0, 0};
  nsdae_bodies *b = create(d, 0, 0, 0);
  int joint = wheel(b, d, 0);
  add_motor(b, (nsdae_motor){joint, .kind = NSDAE_MOTOR_SPEED, .limit = 3, .target = w});
  nsdae_bodies_add_load(b, 0, origin, load, NULL);
  ending end = run(b, method, dt, t);
  return off(d, &end, w * t1 / 2 + w * (t - t1), w);
}

/* The speed sin(3 t) within the limit: 0.5 * 3 N m. */
static double followed(int d, int method, double dt)
{
  const double t = 2;
  nsdae_bodies *b = create(d, 0, 0, 0);
  int joint = wheel(b, d, 0);
  add_motor(b, (nsdae_motor){joint, .kind = NSDAE_MOTOR_SPEED, .limit = 5, .drive = sine});
  ending end = run(b, method, dt, t);
  return off(d, &end, (1 - cos(3 * t)) / 3, sin(3 * t));
}

/* A brake of 2 N m: a wheel of 5 rad/s stops after 5 J / 2 = 1.25 s at 3.125 rad, and stays. */
static double brake(int d, int method, double dt)
{
  nsdae_bodies *b = create(d, 0, 0, 0);
  int joint = wheel(b, d, 5);
  add_motor(b, (nsdae_motor){joint, .kind = NSDAE_MOTOR_SPEED, .limit = 2});
  ending end = run(b, method, dt, 3);
  assert_near(end.v[d == 2 ? 2 : 5], 0, 1e-12);
  if (method == NSDAE_METHOD_EVENT) assert_near(end.changed, 1.25, 1e-10);
  return off(d, &end, 3.125, 0);
}

static void test_speed(void **state)
{
  (void)state;
  for (int d = 2; d <= 3; d++) {
    judge(speed, d, 20);
    judge(followed, d, 10);
    judge(brake, d, 20);
  }
}

/* Dry friction of 3 N holds a slider of 2 kg under 2.9 N for ever, and not under 3.2 N: a = 0.1. */
static void test_stick(void **state)
{
  (void)state;
  for (int d = 2; d <= 3; d++)
    for (int slips = 0; slips <= 1; slips++) {
      double g = (slips ? 3.2 : 2.9) / 2;
      nsdae_bodies *b = create(d, d == 2 ? g : 0, 0, d == 3 ? g : 0);
      int joint = hang(b, d, NSDAE_JOINT_PRISMATIC, (nsdae_rigid_body){.mass = 2});
      add_motor(b, (nsdae_motor){joint, .kind = NSDAE_MOTOR_SPEED, .limit = 3});
      ending end = run(b, NSDAE_METHOD_IMPLICIT, 1e-2, 10);
      assert_near(end.q[d == 2 ? 0 : 2], slips ? 0.1 * 100 / 2 : 0, 1e-9);
    }
}

/* A clutch between two wheels, of 0.5 and 0.3, on one axis: its torque is t^2 at most. From the
 * speeds 3 and 0 it slips until t^3 / 3 (1 / J_0 + 1 / J_1) = 3, then both have 3 J_0 / (J_0 +
 * J_1). The angle of the second at t_1 is t_1^4 / (12 J_1). */
static double clutch(int d, int method, double dt)
{
  const double J0 = 0.5, J1 = 0.3, t_end = 2, t1 = cbrt(9 / (1 / J0 + 1 / J1));
  nsdae_bodies *b = create(d, 0, 0, 0);
  wheel(b, d, 3);
  int second = nsdae_bodies_add(b, &(nsdae_rigid_body){.mass = 1, .inertia = {J1, J1, J1}});
  int joint = nsdae_bodies_add_joint(
      b, &(nsdae_joint){.kind = NSDAE_JOINT_REVOLUTE, .body = {0, second}, .axis = {0, 0, 1}});
  add_motor(b, (nsdae_motor){joint, .kind = NSDAE_MOTOR_SPEED, .vary = ramp});
  ending end = run(b, method, dt, t_end);
  double w = 3 * J0 / (J0 + J1), angle = pow(t1, 4) / (12 * J1) + w * (t_end - t1);
  int nq = d == 2 ? 3 : 7, nv = d == 2 ? 3 : 6;
  assert_near(end.v[nv + (d == 2 ? 2 : 5)], end.v[d == 2 ? 2 : 5], 1e-12);
  double wrong = remainder(angle_of(d, end.q + nq) - angle, 2 * pi);
  return fmax(fabs(wrong), fabs(end.v[d == 2 ? 2 : 5] - w));
}

/* 4 t */
static int linear(double t, double f[3], void *user)
{
  (void)user;
  f[0] = 4 * t;
  f[1] = 4;
  f[2] = 0;
  return 0;
}

/* The same with the bound b = 2 and the torque 4 t on the first wheel. It slips until w_0 - w_1 = 3
 * + (2 t^2 - b t) / J_0 - b t / J_1 = 0, at t_1; it sticks while 4 t J_1 / (J_0 + J_1) <= b, until
 * t_2; then it slips. */
static double clutch_again(int d, int method, double dt)
{
  const double J0 = 0.5, J1 = 0.3, b = 2, J = J0 + J1, t_end = 2, t2 = b * J / (4 * J1);
  const double half = b * (1 / J0 + 1 / J1) / 2, t1 = (half - sqrt(half * half - 6 / J0)) * J0 / 2;
  nsdae_bodies *bodies = create(d, 0, 0, 0);
  int first = wheel(bodies, d, 3);
  int second = nsdae_bodies_add(bodies, &(nsdae_rigid_body){.mass = 1, .inertia = {J1, J1, J1}});
  int joint = nsdae_bodies_add_joint(
      bodies, &(nsdae_joint){.kind = NSDAE_JOINT_REVOLUTE, .body = {0, second}, .axis = {0, 0, 1}});
  add_motor(bodies, (nsdae_motor){joint, .kind = NSDAE_MOTOR_SPEED, .limit = b});
  add_motor(bodies, (nsdae_motor){first, .limit = INFINITY, .drive = linear});
  ending end = run(bodies, method, dt, t_end);
  if (method == NSDAE_METHOD_EVENT) assert_near(end.changed, t2, 1e-10);
  double w1 = b * t1 / J1, w2 = w1 + 2 * (t2 * t2 - t1 * t1) / J, left = t_end - t2;
  double angle = w1 * t1 / 2 + (w1 - 2 * t1 * t1 / J) * (t2 - t1) +
                 2 * (t2 * t2 * t2 - t1 * t1 * t1) / (3 * J) + w2 * left + b * left * left / 2 / J1;
  double fast = w2 + (2 * (t_end * t_end - t2 * t2) - b * left) / J0;
  int nq = d == 2 ? 3 : 7, nv = d == 2 ? 3 : 6, w = d == 2 ? 2 : 5;
  double wrong = fabs(remainder(angle_of(d, end.q + nq) - angle, 2 * pi));
  return fmax(wrong, fmax(fabs(end.v[w] - fast), fabs(end.v[nv + w] - w2 - b * left / J1)));
}

static void test_clutch(void **state)
{
  (void)state;
  for (int d = 2; d <= 3; d++) {
    judge(clutch, d, 20);
    judge(clutch_again, d, 20);
  }
}

/* A constant bound is added to vary: a wheel of 3 rad/s under the bound t^2 until t = 1, then t^2 +
 * 0.25, has at t = 1.2 the rate 3 - (1.2^3 / 3 + 0.05) / J. */
static void test_added_bound(void **state)
{
  (void)state;
  for (int method = NSDAE_METHOD_IMPLICIT; method <= NSDAE_METHOD_EVENT; method++) {
    nsdae_system *system;
    nsdae_sim *sim;
    nsdae_record r;
    nsdae_sim_options o;
    double q[3], v[3];
    nsdae_bodies *b = create(2, 0, 0, 0);
    add_motor(b, (nsdae_motor){wheel(b, 2, 3), .kind = NSDAE_MOTOR_SPEED, .vary = ramp});
    assert_true(nsdae_bodies_system(b, &system) >= 0);
    nsdae_bodies_get_start(b, q, v);
    nsdae_sim_options_default(&o);
    o.method = method;
    o.dt = 1e-3;
    assert_int_equal(nsdae_sim_create(system, &o, &sim, NULL), NSDAE_OK);
    assert_int_equal(nsdae_sim_init(sim, 0, q, v), NSDAE_OK);
    assert_int_equal(nsdae_sim_run(sim, 1), NSDAE_OK);
    assert_int_equal(nsdae_sim_set_friction_bound(sim, 0, 0.25), NSDAE_OK);
    assert_int_equal(nsdae_sim_run(sim, 1.2), NSDAE_OK);
    nsdae_sim_get_record(sim, &r);
    assert_near(r.v[2], 3 - (pow(1.2, 3) / 3 + 0.05) / 0.5,
                method == NSDAE_METHOD_EVENT ? 1e-6 : 3e-3); /* dt (t^2 + 0.25) / J */
    nsdae_sim_destroy(&sim);
    nsdae_system_destroy(&system);
    nsdae_bodies_destroy(&b);
  }
}

/* A vary that is negative or not finite from t = 0.5 on is named, with the motor and the value. */
static double late_value;

static int late(double t, double f[3], void *user)
{
  (void)user;
  f[0] = late_value < 0 ? 0.5 - t : t > 0.5 ? late_value : 1;
  return 0;
}

static void test_wrong_vary(void **state)
{
  (void)state;
  const double values[] = {NAN, INFINITY, -1};
  const char *words[] = {"the vary of motor 0 of body 0 and the ground gave f = nan",
                         "the vary of motor 0 of body 0 and the ground gave f = inf",
                         "the vary of motor 0 of body 0 and the ground gave f = -"};
  for (int i = 0; i < 3; i++)
    for (int method = NSDAE_METHOD_IMPLICIT; method <= NSDAE_METHOD_EVENT; method += 2) {
      nsdae_system *system;
      nsdae_sim *sim;
      nsdae_sim_options o;
      double q[3], v[3];
      nsdae_bodies *b = create(2, 0, 0, 0);
      add_motor(b, (nsdae_motor){wheel(b, 2, 3), .kind = NSDAE_MOTOR_SPEED, .vary = late});
      assert_true(nsdae_bodies_system(b, &system) >= 0);
      nsdae_bodies_get_start(b, q, v);
      nsdae_sim_options_default(&o);
      o.method = method;
      late_value = values[i];
      assert_int_equal(nsdae_sim_create(system, &o, &sim, NULL), NSDAE_OK);
      assert_int_equal(nsdae_sim_init(sim, 0, q, v), NSDAE_OK);
      assert_int_equal(nsdae_sim_run(sim, 1), i < 2 ? NSDAE_E_NONFINITE : NSDAE_E_CALLBACK);
      const nsdae_error *error = nsdae_sim_error(sim);
      if (!strstr(error->text, words[i])) fail_msg("%s", error->text);
      assert_string_equal(error->argument, "motor");
      assert_int_equal(error->index, 0);
      nsdae_sim_destroy(&sim);
      nsdae_system_destroy(&system);
      nsdae_bodies_destroy(&b);
    }
}

/* A body of 2 kg that a motor of 20 N and -3 m/s presses against a wall: it rests, and the motor
 * slips at 3 m/s, which takes 60 W. Its rows have nothing but rounding, which is no drift. */
static void test_pressed(void **state)
{
  (void)state;
  for (int method = NSDAE_METHOD_IMPLICIT; method <= NSDAE_METHOD_EVENT; method++) {
    if (method == NSDAE_METHOD_PENALTY) continue; /* warns of e_N = 0 by its springs */
    nsdae_system *system;
    nsdae_sim *sim;
    nsdae_sim_options o;
    nsdae_record r;
    nsdae_stats stats;
    double q[3], v[3];
    nsdae_bodies *b = create(2, 0, 0, 0);
    int body = nsdae_bodies_add(b, &(nsdae_rigid_body){.mass = 2, .inertia = {0, 0, 1}});
    nsdae_joint slider = {.kind = NSDAE_JOINT_PRISMATIC, .body = {NSDAE_GROUND, body}, .axis = {1}};
    nsdae_solid plane = {.shape = NSDAE_SHAPE_PLANE, .angle = -pi / 2},
                point = {.shape = NSDAE_SHAPE_POINT};
    add_motor(b, (nsdae_motor){nsdae_bodies_add_joint(b, &slider), .kind = NSDAE_MOTOR_SPEED,
                               .target = -3, .limit = 20});
    int wall = nsdae_bodies_add_solid(b, NSDAE_GROUND, &plane);
    nsdae_bodies_add_contact(b, wall, nsdae_bodies_add_solid(b, body, &point), 0.3, 0, 0);
    assert_true(nsdae_bodies_system(b, &system) >= 0);
    nsdae_bodies_get_start(b, q, v);
    nsdae_sim_options_default(&o);
    o.method = method;
    o.dt = 0.01;
    if (nsdae_sim_create(system, &o, &sim, NULL) == NSDAE_OK) {
      assert_int_equal(nsdae_sim_init(sim, 0, q, v), NSDAE_OK);
      assert_int_equal(nsdae_sim_run(sim, 1), NSDAE_OK);
      nsdae_sim_get_record(sim, &r);
      nsdae_sim_get_stats(sim, &stats);
      assert_near(r.v[0], 0, 1e-15);
      assert_near(r.normal_force[0], 20, 1e-9); /* impulses of 0.2 N s to 1e-11 */
      assert_near(r.dissipated, 60, 1e-9);
      assert_near(stats.certificate.work, 60, 1e-9);
      assert_int_equal(stats.warnings, 0);
      nsdae_sim_destroy(&sim);
    }
    nsdae_system_destroy(&system);
    nsdae_bodies_destroy(&b);
  }
}

int main(void)
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(test_force),       cmocka_unit_test(test_speed),
      cmocka_unit_test(test_stick),       cmocka_unit_test(test_clutch),
      cmocka_unit_test(test_added_bound), cmocka_unit_test(test_wrong_vary),
      cmocka_unit_test(test_pressed)};
  return cmocka_run_group_tests(tests, NULL, NULL);
}
