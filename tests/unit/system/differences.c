/* Differences against derivatives by hand. */
#include "differences.h"
#include "check.h"

#include "planar.h"

enum { POINTS = 60 };

typedef struct fixture {
  nsdae_system *system;
  nsdae_differences differences;
  nsdae_arena arena;
} fixture;

static void layout(void *object, nsdae_arena *arena)
{
  nsdae_differences_layout(object, arena);
}

static void begin(fixture *f)
{
  f->system = planar_system(NULL);
  f->differences = (nsdae_differences){.system = f->system};
  assert_int_equal(nsdae_arena_build(&f->arena, layout, &f->differences), NSDAE_OK);
}

static void end(fixture *f)
{
  nsdae_arena_release(&f->arena);
  nsdae_system_destroy(&f->system);
}

/* s^2/6 f''' with s = eps^(1/3) (1 + t), here with third derivatives of up to 10. */
static const double once = 2e-9;
/* s^4/90 of the sixth derivative, which the turning makes 4^2 of f'''', and 5 eps f / s^2 with
 * s = 4e-3. */
static const double twice = 1e-9;

static void test_velocity(void **state)
{
  (void)state;
  fixture f;
  begin(&f);
  for (int i = 0; i < POINTS; i++) {
    enum { LD = 5 };
    double t, q[PLANAR_NQ], v[PLANAR_NV], J[LD * PLANAR_NV], D[LD * PLANAR_NV];
    planar_point(i, &t, q, v);
    planar_jacobian(t, q, J, LD, NULL);
    assert_int_equal(
        nsdae_differences_velocity(&f.differences, planar_constraint, PLANAR_M, t, q, D, LD, 0), 0);
    for (int k = 0; k < PLANAR_M * PLANAR_NV; k++) {
      int at = k / PLANAR_M * LD + k % PLANAR_M;
      assert_near(D[at], J[at], once * (1 + fabs(J[at])));
    }
    planar_normal(t, q, J, LD, NULL);
    assert_int_equal(
        nsdae_differences_velocity(&f.differences, planar_gap, PLANAR_K, t, q, D, LD, 1), 0);
    for (int k = 0; k < PLANAR_NV * PLANAR_K; k++) {
      int at = k / PLANAR_NV * LD + k % PLANAR_NV;
      assert_near(D[at], J[at], once * (1 + fabs(J[at])));
    }
  }
  end(&f);
}

static void test_time_and_second(void **state)
{
  (void)state;
  fixture f;
  begin(&f);
  for (int i = 0; i < POINTS; i++) {
    double t, q[PLANAR_NQ], v[PLANAR_NV], d[2], phi_t[2], omega[2], w_n[2], w_t[2];
    planar_point(i, &t, q, v);
    planar_bias(t, q, v, phi_t, omega, NULL);
    planar_contact_bias(t, q, w_n, w_t, NULL);
    nsdae_differences_time(&f.differences, planar_constraint, 2, t, q, d);
    for (int j = 0; j < 2; j++) assert_near(d[j], phi_t[j], once * (1 + fabs(phi_t[j])));
    nsdae_differences_time(&f.differences, planar_gap, 2, t, q, d);
    for (int j = 0; j < 2; j++) assert_near(d[j], w_n[j], once * (1 + fabs(w_n[j])));
    nsdae_differences_second(&f.differences, planar_constraint, 2, t, q, v, d);
    for (int j = 0; j < 2; j++) assert_near(d[j], omega[j], twice * (1 + fabs(omega[j])));
  }
  end(&f);
}

/* A body at rest and one that is fast: the step follows the motion. */
static void test_slow_and_fast(void **state)
{
  (void)state;
  fixture f;
  begin(&f);
  const double speeds[] = {0, 1e-9, 1e-3, 1e3, 1e6};
  for (int k = 0; k < 5; k++)
    for (int i = 0; i < POINTS; i++) {
      double t, q[PLANAR_NQ], v[PLANAR_NV], d[2], phi_t[2], omega[2];
      planar_point(i, &t, q, v);
      for (int j = 0; j < PLANAR_NV; j++) v[j] *= speeds[k];
      planar_bias(t, q, v, phi_t, omega, NULL);
      nsdae_differences_second(&f.differences, planar_constraint, 2, t, q, v, d);
      double size = 1 + speeds[k] * speeds[k] * 50; /* of the terms of omega */
      for (int j = 0; j < 2; j++) assert_near(d[j], omega[j], twice * size);
    }
  end(&f);
}

/* Time has no origin: after a quarter of an hour the differences are as good, but for the rounding
 * of t + s, which is eps t over s = 6e-6 (or over s^2, with s = 4e-3, for the second). */
static void test_late(void **state)
{
  (void)state;
  fixture f;
  begin(&f);
  for (int i = 0; i < POINTS; i++) {
    double t, q[PLANAR_NQ], v[PLANAR_NV], d[2], phi_t[2], omega[2];
    planar_point(i, &t, q, v);
    t += 1000;
    for (int j = 0; j < PLANAR_NV; j++) v[j] *= 0.01; /* time rules the step */
    planar_bias(t, q, v, phi_t, omega, NULL);
    nsdae_differences_time(&f.differences, planar_constraint, 2, t, q, d);
    for (int j = 0; j < 2; j++) assert_near(d[j], phi_t[j], 1e-6 * (1 + fabs(phi_t[j])));
    nsdae_differences_second(&f.differences, planar_constraint, 2, t, q, v, d);
    for (int j = 0; j < 2; j++) assert_near(d[j], omega[j], 1e-7 * (1 + fabs(omega[j])));
  }
  end(&f);
}

static void test_kinematics(void **state)
{
  (void)state;
  const nsdae_dims dims = {.nq = 3};
  const double q[PLANAR_NQ] = {1, 2, 0.6, 0.8}, v[PLANAR_NV] = {3, 4, 5};
  double qdot[PLANAR_NQ];
  fixture f;
  begin(&f);
  assert_int_equal(nsdae_kinematics(f.system, 0, q, v, qdot), 0);
  assert_true(qdot[0] == 3 && qdot[1] == 4);
  assert_near(qdot[2], -4, 1e-15 * 8); /* a rounding of 4 */
  assert_near(qdot[3], 3, 1e-15 * 8);
  end(&f);
  nsdae_system *plain;
  nsdae_system_create(&dims, &plain, NULL);
  assert_int_equal(nsdae_kinematics(plain, 0, q, v, qdot), 0);
  assert_memory_equal(qdot, v, sizeof v);
  nsdae_system_destroy(&plain);
}

static int calls_until_failure;

static int failing(double t, const double *q, double *phi, void *user)
{
  if (calls_until_failure-- == 0) return -9;
  return planar_constraint(t, q, phi, user);
}

/* Whichever call fails, its code comes back. */
static void test_codes(void **state)
{
  (void)state;
  fixture f;
  double t, q[PLANAR_NQ], v[PLANAR_NV], D[PLANAR_M * PLANAR_NV];
  begin(&f);
  planar_point(1, &t, q, v);
  for (int i = 0; i < 6; i++) { /* two calls each of three columns */
    calls_until_failure = i;
    assert_int_equal(
        nsdae_differences_velocity(&f.differences, failing, PLANAR_M, t, q, D, PLANAR_M, 0), -9);
  }
  for (int i = 0; i < 2; i++) {
    calls_until_failure = i;
    assert_int_equal(nsdae_differences_time(&f.differences, failing, PLANAR_M, t, q, D), -9);
  }
  for (int i = 0; i < 5; i++) {
    calls_until_failure = i;
    assert_int_equal(nsdae_differences_second(&f.differences, failing, PLANAR_M, t, q, v, D), -9);
  }
  end(&f);
}

/* Without any derivative that is missing there is nothing to tune; with any that is, there is. */
static void test_used(void **state)
{
  (void)state;
  enum { JACOBIAN, BIAS, NORMAL, CONTACT_BIAS, ACCELERATION, NONE };
  for (int contacts = 0; contacts < 2; contacts++)
    for (int missing = 0; missing <= NONE; missing++) {
      const nsdae_dims dims = {.nq = PLANAR_NQ,
                               .nv = PLANAR_NV,
                               .m = PLANAR_M,
                               .k = contacts ? PLANAR_K : 0,
                               .nt = contacts};
      nsdae_system *s;
      assert_int_equal(nsdae_system_create(&dims, &s, NULL), NSDAE_OK);
      nsdae_system_set_kinematics(s, planar_kinematics);
      nsdae_system_set_mass(s, planar_mass);
      nsdae_system_set_force(s, planar_force);
      nsdae_system_set_constraint(s, planar_constraint);
      if (missing != JACOBIAN) nsdae_system_set_constraint_jacobian(s, planar_jacobian);
      if (missing != BIAS) nsdae_system_set_constraint_bias(s, planar_bias);
      if (contacts) {
        nsdae_system_set_gap(s, planar_gap);
        nsdae_system_set_gap_tangent(s, planar_tangent);
        if (missing != NORMAL) nsdae_system_set_gap_normal(s, planar_normal);
        if (missing != CONTACT_BIAS) nsdae_system_set_contact_bias(s, planar_contact_bias);
        if (missing != ACCELERATION) nsdae_system_set_contact_acceleration(s, planar_acceleration);
      }
      assert_int_equal(nsdae_system_complete(s, NULL), NSDAE_OK);
      int used = missing < (contacts ? NONE : NORMAL);
      assert_int_equal(nsdae_differences_used(s), used);
      nsdae_system_destroy(&s);
    }
}

int main(void)
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(test_velocity),      cmocka_unit_test(test_time_and_second),
      cmocka_unit_test(test_slow_and_fast), cmocka_unit_test(test_kinematics),
      cmocka_unit_test(test_late),          cmocka_unit_test(test_codes),
      cmocka_unit_test(test_used),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
