/* A kinematics callback that fails or gives NaN in the middle of a run: named, and the state is the
 * one before. The model has nothing else that a NaN in q could show in. */
#include "check.h"

#include <nsdae/nsdae.h>

/* A wheel that turns: its orientation is the unit vector (c, s), so nq = 3, nv = 2. */
typedef struct wheel {
  long calls, at;
  int code;
  double value;
} wheel;

static int mass(double t, const double *q, double *M, int ldm, void *user)
{
  (void)t;
  (void)q;
  (void)user;
  M[0] = 2;
  M[ldm + 1] = 0.1;
  return 0;
}

static int force(double t, const double *q, const double *v, double *F, void *user)
{
  (void)t;
  (void)q;
  (void)user;
  F[0] = -0.1 * v[0];
  F[1] = -0.01 * v[1];
  return 0;
}

static int kinematics(double t, const double *q, const double *v, double *qdot, void *user)
{
  wheel *w = user;
  (void)t;
  qdot[0] = v[0];
  qdot[1] = -q[2] * v[1];
  qdot[2] = q[1] * v[1];
  if (w->calls++ != w->at) return 0;
  if (w->code == 0) qdot[1] = w->value;
  return w->code;
}

static const double start_q[3] = {0, 1, 0}, start_v[2] = {1, 3};

static void fails(int method, long at, int code, double value)
{
  const nsdae_dims dims = {.nq = 3, .nv = 2};
  wheel w = {.at = at, .code = code, .value = value};
  nsdae_system *system;
  nsdae_sim *sim;
  nsdae_sim_options options;
  nsdae_record record;
  double q[3], v[2];
  int status = NSDAE_OK;
  nsdae_system_create(&dims, &system, NULL);
  nsdae_system_set_user(system, &w);
  nsdae_system_set_mass(system, mass);
  nsdae_system_set_force(system, force);
  nsdae_system_set_kinematics(system, kinematics);
  nsdae_sim_options_default(&options);
  options.method = method;
  options.dt = 0.01;
  status = nsdae_sim_create(system, &options, &sim, NULL);
  if (status == NSDAE_E_UNSUPPORTED) {
    nsdae_system_destroy(&system);
    return;
  }
  assert_int_equal(status, NSDAE_OK);
  assert_int_equal(nsdae_sim_init(sim, 0, start_q, start_v), NSDAE_OK);
  for (int step = 0; step < 300 && status >= 0; step++) {
    nsdae_sim_get_record(sim, &record);
    memcpy(q, record.q, sizeof q);
    memcpy(v, record.v, sizeof v);
    status = nsdae_sim_step(sim);
  }
  if (method >= NSDAE_METHOD_PENALTY && code >= 0 &&
      status >= 0) { /* smaller steps got around it */
    assert_near(hypot(record.q[1], record.q[2]), 1, 1e-2);
    nsdae_sim_destroy(&sim);
    nsdae_system_destroy(&system);
    return;
  }
  if (status != (code ? NSDAE_E_CALLBACK : NSDAE_E_NONFINITE))
    fail_msg("method %s, call %ld, code %d: status %d", nsdae_method_name(method), at, code,
             status);
  assert_string_equal(nsdae_sim_error(sim)->argument, "kinematics");
  assert_int_equal(nsdae_sim_error(sim)->code, code);
  assert_true(isfinite(nsdae_sim_error(sim)->time));
  nsdae_record after;
  nsdae_sim_get_record(sim, &after);
  assert_true(after.step == record.step && after.time == record.time);
  assert_memory_equal(after.q, q, sizeof q);
  assert_memory_equal(after.v, v, sizeof v);
  assert_int_equal(nsdae_sim_init(sim, 0, start_q, start_v), NSDAE_OK);
  assert_int_equal(nsdae_sim_run(sim, 1), NSDAE_OK);
  nsdae_sim_destroy(&sim);
  nsdae_system_destroy(&system);
}

/* Three calls in a row, for a method may call it at more than one point of a step. */
static void test_code(void **state)
{
  (void)state;
  for (int method = 0; nsdae_method_name(method); method++)
    for (long at = 50; at < 53; at++)
      for (int code = -2; code <= 2; code += 4) fails(method, at, code, 0);
}

static void test_nan(void **state)
{
  (void)state;
  for (int method = 0; nsdae_method_name(method); method++)
    for (long at = 50; at < 53; at++) fails(method, at, 0, at == 51 ? INFINITY : NAN);
}

/* Only quaternions must have length one: a unit vector of two entries may as well be a point on a
 * circle of any radius, which each start keeps. */
static void test_radius(void **state)
{
  const nsdae_dims dims = {.nq = 3, .nv = 2};
  const double radius[] = {0.2, 0.5, 3};
  wheel w = {.at = -1};
  nsdae_system *system;
  nsdae_sim *sim;
  (void)state;
  nsdae_system_create(&dims, &system, NULL);
  nsdae_system_set_user(system, &w);
  nsdae_system_set_mass(system, mass);
  nsdae_system_set_force(system, force);
  nsdae_system_set_kinematics(system, kinematics);
  assert_int_equal(nsdae_sim_create(system, NULL, &sim, NULL), NSDAE_OK);
  for (int i = 0; i < 3; i++) {
    double q[3] = {0, 0.6 * radius[i], -0.8 * radius[i]}, v[2] = {1, 3};
    assert_int_equal(nsdae_sim_init(sim, 0, q, v), NSDAE_OK);
    assert_int_equal(nsdae_sim_project(sim, 0, q, v), NSDAE_OK);
    assert_near(hypot(q[1], q[2]), radius[i], 1e-15);
    assert_int_equal(nsdae_sim_run(sim, 0.1), NSDAE_OK);
  }
  nsdae_sim_destroy(&sim);
  nsdae_system_destroy(&system);
}

int main(void)
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(test_code),
      cmocka_unit_test(test_nan),
      cmocka_unit_test(test_radius),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
