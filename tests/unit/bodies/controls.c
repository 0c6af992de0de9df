/* Targets of motors that are set between steps: against closed forms by every method, as a part of
 * the state to the byte, and what is refused. */
#include "check.h"

#include <nsdae/nsdae.h>

#include "support/hung_bodies.h"

static const double inertia = 0.5;

typedef struct machine {
  nsdae_bodies *bodies;
  nsdae_system *system;
  nsdae_sim *sim;
  int d;
} machine;

/* A wheel of J = 0.5 with a motor. */
static machine wheel(int d, nsdae_motor motor, int method, double dt)
{
  machine m = {.d = d, .bodies = create(d, 0, 0, 0)};
  nsdae_sim_options o;
  double q[7], v[6];
  motor.joint = hang(m.bodies, d, NSDAE_JOINT_REVOLUTE, (nsdae_rigid_body){.mass = 2});
  assert_int_equal(nsdae_bodies_add_motor(m.bodies, &motor), 0);
  assert_true(nsdae_bodies_system(m.bodies, &m.system) >= 0);
  nsdae_bodies_get_start(m.bodies, q, v);
  nsdae_sim_options_default(&o);
  o.method = method;
  o.dt = dt;
  o.rtol = 1e-12;
  o.atol = 1e-13;
  assert_int_equal(nsdae_sim_create(m.system, &o, &m.sim, NULL), NSDAE_OK);
  assert_int_equal(nsdae_sim_init(m.sim, 0, q, v), NSDAE_OK);
  return m;
}

static void release(machine *m)
{
  nsdae_sim_destroy(&m->sim);
  nsdae_system_destroy(&m->system);
  nsdae_bodies_destroy(&m->bodies);
}

static void go(const machine *m, double t)
{
  if (nsdae_sim_run(m->sim, t) < 0) fail_msg("%s", nsdae_sim_error(m->sim)->text);
}

static void set(const machine *m, double value)
{
  double is = NAN;
  assert_int_equal(nsdae_sim_set_control(m->sim, 0, value), NSDAE_OK);
  assert_int_equal(nsdae_sim_get_control(m->sim, 0, &is), NSDAE_OK);
  assert_true(is == value);
}

/* Its error in angle and rate; an energy of less than lost may be unexplained. */
static double finish(machine *m, double angle, double rate, double lost)
{
  nsdae_record r;
  nsdae_sim_get_record(m->sim, &r);
  double wrong = fabs(remainder(angle_of(m->d, r.q) - angle, 8 * atan(1)));
  wrong = fmax(wrong, fabs(r.v[m->d == 2 ? 2 : 5] - rate));
  assert_true(fabs(r.certificate.unexplained) < lost);
  release(m);
  return wrong;
}

/* ---- closed forms */

static double loss(int method, double dt)
{
  return method == NSDAE_METHOD_EVENT || method == NSDAE_METHOD_PENALTY ? 1e-9 : 20 * dt;
}

static const double first = 1 + 1.0 / 3; /* between the records of event */

/* With at most 3 N m, a = 6, to the speed 4 at t = 2/3; from t = first on to -2, reached after 1.
 */
static double speed(int d, int method, double dt)
{
  machine m =
      wheel(d, (nsdae_motor){.kind = NSDAE_MOTOR_SPEED, .limit = 3, .target = 4}, method, dt);
  go(&m, first);
  set(&m, -2);
  go(&m, first + 2);
  return finish(&m, 4 * first - 4.0 / 3 + 4 - 3 - 2, -2, loss(method, dt));
}

/* A brake that lets go and stops again: 0, 1, 0 with a = 6. */
static double stopped(int d, int method, double dt)
{
  machine m = wheel(d, (nsdae_motor){.kind = NSDAE_MOTOR_SPEED, .limit = 3}, method, dt);
  go(&m, first);
  set(&m, 1);
  go(&m, 2);
  set(&m, 0);
  go(&m, 3);
  return finish(&m, 2 - first, 0, loss(method, dt));
}

/* The torque 1, -2, and then 5 of at most 3. */
static double force(int d, int method, double dt)
{
  const double a[3] = {1 / inertia, -2 / inertia, 3 / inertia}, h[3] = {first, 2 - first, 0.5};
  machine m =
      wheel(d, (nsdae_motor){.kind = NSDAE_MOTOR_FORCE, .limit = 3, .target = 1}, method, dt);
  double angle = 0, rate = 0, t = 0;
  for (int i = 0; i < 3; i++) {
    if (i > 0) set(&m, i == 1 ? -2 : 5);
    go(&m, t += h[i]);
    angle += rate * h[i] + a[i] * h[i] * h[i] / 2;
    rate += a[i] * h[i];
  }
  return finish(&m, angle, rate, 1e-9); /* exact by every method */
}

/* J s'' = kp (u - s) - kd s', over-critical: s - u = A e^(x t) + B e^(y t). */
static double position(int d, int method, double dt)
{
  const double kp = 4, kd = 3, root = sqrt(kd * kd - 4 * inertia * kp);
  const double x = (-kd + root) / (2 * inertia), y = (-kd - root) / (2 * inertia);
  const double u[2] = {0.5, -0.25}, h[2] = {first, 1};
  machine m =
      wheel(d,
            (nsdae_motor){
                .kind = NSDAE_MOTOR_POSITION, .limit = INFINITY, .kp = kp, .kd = kd, .target = 0.5},
            method, dt);
  double s = 0, rate = 0, t = 0;
  for (int i = 0; i < 2; i++) {
    if (i > 0) set(&m, u[i]);
    go(&m, t += h[i]);
    double B = (rate - x * (s - u[i])) / (y - x), A = s - u[i] - B;
    s = u[i] + A * exp(x * h[i]) + B * exp(y * h[i]);
    rate = A * x * exp(x * h[i]) + B * y * exp(y * h[i]);
  }
  return finish(&m, s, rate, loss(method, dt));
}

static void test_closed_forms(void **state)
{
  (void)state;
  for (int d = 2; d <= 3; d++) {
    judge(speed, d, 20);
    judge(stopped, d, 20);
    judge(force, d, 20);
    judge(position, d, 20);
    assert_at_most(force(d, NSDAE_METHOD_PENALTY, 0.05), 1e-9);
    assert_at_most(position(d, NSDAE_METHOD_PENALTY, 0.05), 1e-9);
  }
}

/* ---- part of the state */

static const int methods[] = {NSDAE_METHOD_IMPLICIT, NSDAE_METHOD_IMPLICIT_PRINTED,
                              NSDAE_METHOD_MOREAU, NSDAE_METHOD_PENALTY, NSDAE_METHOD_EVENT};
enum { METHODS = sizeof methods / sizeof *methods };

static const nsdae_motor kinds[] = {
    {.kind = NSDAE_MOTOR_FORCE, .limit = 3, .target = 1},
    {.kind = NSDAE_MOTOR_SPEED, .limit = 3, .target = 1},
    {.kind = NSDAE_MOTOR_POSITION, .limit = 3, .kp = 4, .kd = 1, .target = 1}};

static char *block_of(nsdae_sim *sim, size_t *size)
{
  assert_int_equal(nsdae_sim_state_size(sim, size), NSDAE_OK);
  char *block = malloc(*size);
  assert_non_null(block);
  assert_int_equal(nsdae_sim_get_state(sim, block, *size), NSDAE_OK);
  return block;
}

static void assert_same_state(nsdae_sim *one, nsdae_sim *other)
{
  size_t size[2];
  char *block[2] = {block_of(one, &size[0]), block_of(other, &size[1])};
  assert_int_equal(size[0], size[1]);
  assert_memory_equal(block[0], block[1], size[0]);
  free(block[0]);
  free(block[1]);
}

/* After a control was set, and some steps later, another simulation goes on from the block with the
 * same bytes; it has its control from there. */
static void test_restart(void **state)
{
  (void)state;
  for (int i = 0; i < 3 * METHODS; i++)
    for (int later = 0; later <= 1; later++) {
      int method = methods[i / 3];
      if (method == NSDAE_METHOD_PENALTY && kinds[i % 3].kind == NSDAE_MOTOR_SPEED) continue;
      machine m = wheel(3, kinds[i % 3], method, 0.01), n = wheel(3, kinds[i % 3], method, 0.01);
      size_t size;
      double is = 0;
      go(&m, 0.5);
      set(&m, -0.5);
      if (later) go(&m, 0.735);
      char *block = block_of(m.sim, &size);
      assert_int_equal(nsdae_sim_set_state(n.sim, block, size), NSDAE_OK);
      nsdae_sim_get_control(n.sim, 0, &is);
      assert_true(is == -0.5);
      assert_same_state(m.sim, n.sim);
      go(&m, 1.2);
      go(&n, 1.2);
      assert_same_state(m.sim, n.sim);
      free(block);
      release(&m);
      release(&n);
    }
}

/* At the start, all at zero. */
static void test_restart_at_rest(void **state)
{
  (void)state;
  for (int i = 0; i < METHODS; i++) {
    nsdae_motor motor = {.kind = NSDAE_MOTOR_FORCE, .limit = 3};
    machine m = wheel(2, motor, methods[i], 0.01), n = wheel(2, motor, methods[i], 0.01);
    size_t size;
    nsdae_record r;
    go(&m, 0.1);
    set(&m, 1);
    char *block = block_of(m.sim, &size);
    assert_int_equal(nsdae_sim_set_state(n.sim, block, size), NSDAE_OK);
    go(&m, 1.1);
    go(&n, 1.1);
    assert_same_state(m.sim, n.sim);
    nsdae_sim_get_record(n.sim, &r);
    assert_near(r.v[2], 1 / inertia, 1e-9);
    free(block);
    release(&m);
    release(&n);
  }
}

/* A damaged block leaves the controls. */
static void test_refused_state(void **state)
{
  (void)state;
  machine m = wheel(2, kinds[0], NSDAE_METHOD_IMPLICIT, 0.01);
  size_t size;
  double is = 0;
  go(&m, 0.1);
  char *block = block_of(m.sim, &size);
  set(&m, 2);
  block[size - 1] ^= 1;
  assert_int_equal(nsdae_sim_set_state(m.sim, block, size), NSDAE_E_ARGUMENT);
  assert_int_equal(nsdae_sim_get_control(m.sim, 0, &is), NSDAE_OK);
  assert_true(is == 2);
  free(block);
  release(&m);
}

/* ---- repeated steps */

static int failures;

static int fails(const nsdae_record *r, nsdae_error *error, void *user)
{
  (void)error, (void)user;
  return r->time > 0.505 && failures-- > 0 ? NSDAE_E_CALLBACK : 0;
}

/* The step after a control failed in an observer: done again it is the same. Another control then
 * replaces what was computed with the old one. The same value again changes nothing. */
static void test_repeated(void **state)
{
  (void)state;
  for (int i = 0; i < 3 * METHODS; i++) {
    int method = methods[i / 3];
    if (method == NSDAE_METHOD_PENALTY && kinds[i % 3].kind == NSDAE_MOTOR_SPEED) continue;
    for (int again = 0; again <= 1; again++) {
      machine m = wheel(3, kinds[i % 3], method, 0.01), n = wheel(3, kinds[i % 3], method, 0.01);
      nsdae_sim_observe(m.sim, fails, NULL);
      failures = 0;
      go(&m, 0.5);
      go(&n, 0.5);
      failures = 2;
      set(&m, again ? 3 : 2);
      if (again) set(&n, 3);
      assert_int_equal(nsdae_sim_run(m.sim, 1), NSDAE_E_CALLBACK);
      assert_int_equal(nsdae_sim_run(m.sim, 1), NSDAE_E_CALLBACK);
      set(&m, 2);
      set(&n, 2);
      set(&n, 2);
      go(&m, 1);
      go(&n, 1);
      assert_same_state(m.sim, n.sim);
      release(&m);
      release(&n);
    }
  }
}

/* A force motor's torque on a body that rests on the floor: the contact stays closed. */
static void test_contact_stays(void **state)
{
  (void)state;
  for (int i = 0; i < METHODS; i++) {
    nsdae_bodies *b = create(2, 0, -10, 0);
    nsdae_system *system;
    nsdae_sim *sim;
    nsdae_sim_options o;
    nsdae_record r;
    double q[3], v[3];
    const double half = NSDAE_METHOD_PENALTY == methods[i] ? 0.4999 : 0.5;
    nsdae_bodies_add(b,
                     &(nsdae_rigid_body){.mass = 2, .inertia = {0, 0, 1}, .position = {0, half}});
    int joint = nsdae_bodies_add_joint(
        b,
        &(nsdae_joint){.kind = NSDAE_JOINT_PRISMATIC, .body = {NSDAE_GROUND, 0}, .axis = {0, 1}});
    int disc =
        nsdae_bodies_add_solid(b, 0, &(nsdae_solid){.shape = NSDAE_SHAPE_DISC, .radius = 0.5});
    int floor = nsdae_bodies_add_solid(b, NSDAE_GROUND, &(nsdae_solid){.shape = NSDAE_SHAPE_PLANE});
    nsdae_bodies_add_contact(b, disc, floor, 0, 0.5, 0);
    nsdae_bodies_add_motor(b, &(nsdae_motor){joint, .limit = INFINITY});
    assert_true(nsdae_bodies_system(b, &system) >= 0);
    nsdae_bodies_get_start(b, q, v);
    nsdae_sim_options_default(&o);
    o.method = methods[i];
    o.dt = 0.01;
    assert_int_equal(nsdae_sim_create(system, &o, &sim, NULL), NSDAE_OK);
    assert_int_equal(nsdae_sim_init(sim, 0, q, v), NSDAE_OK);
    for (int step = 1; step <= 100; step++) {
      assert_int_equal(nsdae_sim_set_control(sim, 0, step % 2 ? 19 : -7), NSDAE_OK);
      if (nsdae_sim_run(sim, 0.01 * step) < 0) fail_msg("%s", nsdae_sim_error(sim)->text);
      nsdae_sim_get_record(sim, &r);
      assert_int_equal(r.impacts, 0);
      if (methods[i] == NSDAE_METHOD_PENALTY) continue;
      assert_near(r.q[1], 0.5, 1e-12);
      assert_near(r.normal_force[0], 20 - (step % 2 ? 19 : -7), 1e-9);
    }
    nsdae_sim_destroy(&sim);
    nsdae_system_destroy(&system);
    nsdae_bodies_destroy(&b);
  }
}

/* ---- refused */

static int still(double t, double f[3], void *user)
{
  (void)t, (void)user;
  f[0] = f[1] = f[2] = 0;
  return 0;
}

static void assert_refused(const machine *m, int i, double value, const char *words)
{
  size_t size;
  char *before = block_of(m->sim, &size), *after;
  assert_int_equal(nsdae_sim_set_control(m->sim, i, value), NSDAE_E_ARGUMENT);
  if (!strstr(nsdae_sim_error(m->sim)->text, words)) fail_msg("%s", nsdae_sim_error(m->sim)->text);
  after = block_of(m->sim, &size);
  assert_memory_equal(before, after, size);
  free(before);
  free(after);
}

static void test_refused(void **state)
{
  (void)state;
  machine m = wheel(2, kinds[0], NSDAE_METHOD_EVENT, 0.01);
  go(&m, 0.1);
  assert_refused(&m, 1, 0, "i = 1 is outside its range: there are 1");
  assert_refused(&m, -1, 0, "i = -1 is outside its range: there are 1");
  assert_refused(&m, 0, NAN, "value = nan of control 0 is outside its range: it must be finite");
  assert_refused(&m, 0, INFINITY, "value = inf of control 0");
  assert_int_equal(nsdae_sim_get_control(m.sim, 0, NULL), NSDAE_E_ARGUMENT);
  assert_int_equal(nsdae_sim_set_control(NULL, 0, 0), NSDAE_E_ARGUMENT);
  assert_int_equal(nsdae_sim_set_user(m.sim, &m), NSDAE_E_STATE);
  release(&m);
  for (int kind = 0; kind < 3; kind++) {
    nsdae_motor motor = kinds[kind];
    motor.drive = still;
    m = wheel(2, motor, NSDAE_METHOD_EVENT, 0.01);
    assert_refused(&m, 0, 1, "control i = 0: the target of this motor is its drive");
    release(&m);
  }
}

/* Two simulations of one system have controls of their own. */
static void test_own(void **state)
{
  (void)state;
  machine m = wheel(2, kinds[0], NSDAE_METHOD_IMPLICIT, 0.01);
  nsdae_sim *other;
  nsdae_sim_options o;
  nsdae_record r;
  const double zero[3] = {0};
  nsdae_sim_get_options(m.sim, &o);
  assert_int_equal(nsdae_sim_create(m.system, &o, &other, NULL), NSDAE_OK);
  assert_int_equal(nsdae_sim_set_control(other, 0, -2), NSDAE_OK); /* before its start */
  assert_int_equal(nsdae_sim_init(other, 0, zero, zero), NSDAE_OK);
  go(&m, 1);
  assert_int_equal(nsdae_sim_run(other, 1), NSDAE_OK);
  nsdae_sim_get_record(m.sim, &r);
  assert_near(r.v[2], 1 / inertia, 1e-12);
  nsdae_sim_get_record(other, &r);
  assert_near(r.v[2], -2 / inertia, 1e-12);
  nsdae_sim_destroy(&other);
  release(&m);
}

int main(void)
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(test_closed_forms),    cmocka_unit_test(test_restart),
      cmocka_unit_test(test_restart_at_rest), cmocka_unit_test(test_refused_state),
      cmocka_unit_test(test_repeated),        cmocka_unit_test(test_contact_stays),
      cmocka_unit_test(test_refused),         cmocka_unit_test(test_own)};
  return cmocka_run_group_tests(tests, NULL, NULL);
}
