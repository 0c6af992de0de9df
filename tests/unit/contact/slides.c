/* Friction on bilateral constraints against closed forms. */
#include "fixture.h"

#include "support/random.h"

static const double rounding = 1e-12;

/* A slider of mass m on the line y = 0:  q = [x, y], Phi = y. */
static void slider(fixture *f, double m, double mu)
{
  fixture_begin(f, (nsdae_dims){.nq = 2, .m = 1, .f = 1});
  f->M[0] = f->M[3] = m;
  f->J[1] = 1;
  f->W_S[0] = 1;
  assert_int_equal(nsdae_system_set_frictional_joint(f->system, 0, 0, mu), NSDAE_OK);
  fixture_build(f, 8);
}

/* The normal force has either sign, the friction its size. */
static void test_slider(void **state)
{
  (void)state;
  const double m = 2, mu = 0.4;
  fixture f;
  slider(&f, m, mu);
  for (int i = -5; i <= 5; i++)
    for (int j = -7; j <= 7; j++) {
      f.lambda_free[0] = 0.5 * i;
      f.free[0] = 0.13 * j;
      double most = mu * fabs(f.lambda_free[0]);
      double friction = fmax(-most, fmin(most, -m * f.free[0]));
      assert_int_equal(fixture_solve(&f), NSDAE_OK);
      assert_near(f.impulses.frictional_joint_impulse[0], friction, rounding);
      assert_near(f.v[0], f.free[0] + friction / m, rounding);
      assert_near(f.v[1], 0, rounding);
      assert_near(f.lambda[0], f.lambda_free[0], rounding);
      if (m * fabs(f.free[0]) < most - rounding)
        assert_int_equal(f.impulses.frictional_joint_mode[0], NSDAE_MODE_STICK);
      if (m * fabs(f.free[0]) > most + rounding)
        assert_int_equal(f.impulses.frictional_joint_mode[0], NSDAE_MODE_SLIP);
      assert_at_most(nsdae_contacts_work(&f.contacts), rounding);
      fixture_expect_laws(&f, rounding);
    }
  fixture_end(&f);
}

/* A rail that moves under the slider. */
static void test_moving_rail(void **state)
{
  (void)state;
  fixture f;
  slider(&f, 2, 0.4);
  f.w_s[0] = -0.1;
  f.lambda_free[0] = 1;
  assert_int_equal(fixture_solve(&f), NSDAE_OK);
  assert_near(f.v[0], 0.1, rounding); /* taken along: 0.2 N s of at most 0.4 */
  f.w_s[0] = -1;
  assert_int_equal(fixture_solve(&f), NSDAE_OK);
  assert_near(f.v[0], 0.2, rounding); /* 0.4 N s of friction */
  assert_int_equal(f.impulses.frictional_joint_mode[0], NSDAE_MODE_SLIP);
  fixture_end(&f);
}

/* The slider is thrown against a stop that leans, (a, b) being its normal: the impulse of the stop
 * presses it against the rail, which rubs with mu |lambda|. With the slider moving to the left,
 *   m (v+ - v-) = a L + mu |lambda|,  |lambda| = b L,  v+ = -e v-. */
static void test_stop(void **state)
{
  (void)state;
  const double m = 2, mu = 0.3, a = 0.8, b = 0.6, coming = -1.5;
  for (int i = 0; i < 3; i++) {
    const double e = 0.4 * i;
    fixture f;
    fixture_begin(&f, (nsdae_dims){.nq = 2, .m = 1, .k = 1, .f = 1});
    f.M[0] = f.M[3] = m;
    f.J[1] = 1;
    f.W_S[0] = 1;
    f.W_N[0] = a;
    f.W_N[1] = b;
    nsdae_system_set_frictional_joint(f.system, 0, 0, mu);
    nsdae_system_set_contact(f.system, 0, 0, e, 0);
    fixture_build(&f, 8);
    f.before[0] = f.free[0] = coming;
    assert_int_equal(fixture_solve(&f), NSDAE_OK);
    assert_near(f.v[0], -e * coming, rounding);
    /* after the impact it moves to the right (or rests): the rail rubs against that */
    double L = i == 0 ? NAN : m * (1 + e) * -coming / (a - mu * b);
    if (i > 0) {
      assert_near(f.impulses.normal[0], L, rounding * 10);
      assert_near(f.impulses.frictional_joint_impulse[0], -mu * b * L, rounding * 10);
    }
    assert_near(fabs(f.lambda[0]), b * f.impulses.normal[0], rounding * 10);
    fixture_expect_laws(&f, rounding * 10);
    fixture_end(&f);
  }
}

/* Without friction a slide is an ordinary constraint. */
static void test_frictionless(void **state)
{
  (void)state;
  fixture f;
  slider(&f, 2, 0);
  f.free[0] = 1;
  f.lambda_free[0] = 5;
  assert_int_equal(fixture_solve(&f), NSDAE_OK);
  assert_true(f.v[0] == 1 && f.impulses.frictional_joint_impulse[0] == 0);
  assert_int_equal(f.impulses.frictional_joint_mode[0], NSDAE_MODE_OPEN);
  fixture_end(&f);
}

/* Two slides of which one has friction: the numbers do not get mixed up. */
static void test_second_slide(void **state)
{
  (void)state;
  fixture f;
  fixture_begin(&f, (nsdae_dims){.nq = 4, .m = 2, .f = 2});
  f.J[2 * 1 + 0] = 1; /* Phi_0 = q_1 */
  f.J[2 * 3 + 1] = 1; /* Phi_1 = q_3 */
  f.W_S[0] = 1;       /* frictional joint 0 along q_0 */
  f.W_S[4 + 2] = 1;   /* slide 1 along q_2 */
  nsdae_system_set_frictional_joint(f.system, 0, 0, 0);
  nsdae_system_set_frictional_joint(f.system, 1, 1, 0.5);
  fixture_build(&f, 8);
  f.free[0] = f.free[2] = 1;
  f.lambda_free[0] = 10;
  f.lambda_free[1] = -0.6;
  assert_int_equal(fixture_solve(&f), NSDAE_OK);
  assert_near(f.v[0], 1, rounding);
  assert_near(f.v[2], 0.7, rounding);
  assert_true(f.impulses.frictional_joint_impulse[0] == 0);
  assert_near(f.impulses.frictional_joint_impulse[1], -0.3, rounding);
  assert_int_equal(f.impulses.frictional_joint_mode[1], NSDAE_MODE_SLIP);
  fixture_end(&f);
}

/* A sledge on the floor z = 0 that a rail keeps at y = 0 and presses upon: the cone's friction and
 * the rail's both act against its motion along x. */
static void test_beside_cone(void **state)
{
  (void)state;
  const double m = 2, mu = 0.4, mu_rail = 0.3, down = -0.5, press = 0.7;
  for (int i = -8; i <= 8; i++) {
    fixture f;
    fixture_begin(&f, (nsdae_dims){.nq = 3, .m = 1, .k = 1, .nt = 2, .f = 1});
    f.M[0] = f.M[4] = f.M[8] = m;
    f.J[1] = 1;
    f.W_S[0] = 1;
    f.W_N[2] = f.W_T[0] = f.W_T[3 + 1] = 1;
    nsdae_system_set_contact(f.system, 0, mu, 0, 0);
    nsdae_system_set_frictional_joint(f.system, 0, 0, mu_rail);
    fixture_build(&f, 0);
    f.free[0] = 0.13 * i;
    f.free[2] = down;
    f.lambda_free[0] = press;
    assert_int_equal(fixture_solve(&f), NSDAE_OK);
    double most = (mu * -m * down + mu_rail * press) / m, v = fmax(0, fabs(f.free[0]) - most);
    assert_near(f.v[0], copysign(v, f.free[0]), rounding);
    assert_near(f.v[1], 0, rounding);
    assert_near(f.impulses.normal[0], -m * down, rounding);
    assert_near(f.lambda[0], press, rounding);
    if (v > 0) {
      assert_int_equal(f.impulses.mode[0], NSDAE_MODE_SLIP);
      assert_int_equal(f.impulses.frictional_joint_mode[0], NSDAE_MODE_SLIP);
    }
    fixture_expect_laws(&f, 1e-10);
    fixture_end(&f);
  }
}

/* Friction of frictional joint j: |Lambda_T| <= b + mu |lambda|, and against the slip as far as it
 * can.
 */
static void expect_slide_law(const fixture *f, int j, double tol)
{
  const nsdae_frictional_joint *joint = &f->system->frictional_joint[j];
  double most = joint->mu > 0 ? joint->mu * fabs(f->lambda[joint->constraint]) : 0,
         friction = f->impulses.frictional_joint_impulse[j];
  double slip = fixture_dot(f->dims.nv, f->W_S + j * f->dims.nv, f->v) + f->w_s[j];
  if (f->contacts.slides.bound) most += f->contacts.slides.bound[j];
  assert_at_most(fabs(friction), most + tol);
  assert_near(friction, fmax(-most, fmin(most, friction - slip)), tol);
}

/* Slides and cones coupled at random, with friction small enough for solutions. */
static void test_with_cones(void **state)
{
  (void)state;
  random_state r = {.seed = 41};
  for (int i = 0; i < 300; i++) {
    fixture f;
    fixture_begin(&f, (nsdae_dims){.nq = 6, .m = 2, .k = 2, .nt = 2, .f = 2});
    random_matrix(&r, 2, 6, f.J, 2);
    random_matrix(&r, 6, 2, f.W_N, 6);
    random_matrix(&r, 6, 4, f.W_T, 6);
    random_matrix(&r, 6, 2, f.W_S, 6);
    for (int j = 0; j < 2; j++) {
      nsdae_system_set_frictional_joint(f.system, j, j, 0.05);
      nsdae_system_set_contact(f.system, j, 0.3, 0, 0);
    }
    fixture_build(&f, 0);
    for (int repeat = 0; repeat < 2; repeat++) {
      random_matrix(&r, 6, 1, f.free, MOST_V);
      random_matrix(&r, 2, 1, f.lambda_free, MOST_M);
      memcpy(f.v, f.free, sizeof f.v);
      double rhs[MOST_V], lambda[MOST_M] = {0}; /* J free = 0 */
      memcpy(rhs, f.free, sizeof rhs);
      fixture_factor(&f);
      assert_int_equal(nsdae_kkt_solve(&f.kkt, 1, rhs, 6, lambda, 2), NSDAE_OK);
      memcpy(f.free, rhs, sizeof rhs);
      assert_int_equal(fixture_solve(&f), NSDAE_OK);
      fixture_expect_laws(&f, 1e-9);
      double largest = fmax(1, fmax(fabs(f.lambda[0]), fabs(f.lambda[1])));
      for (int j = 0; j < 2; j++) expect_slide_law(&f, j, 1e-9 * largest);
    }
    fixture_end(&f);
  }
}

/* ---- bounds of their own */

/* A random problem of a seed: constraints, contacts, joints with a bound, in the plane some with
 * a load too; rows that are twice there, and bounds of 0 and far above what acts. In the plane, or
 * the same in space with a second direction in which nothing moves: then the contacts have cones.
 */
static int solve_bounded(uint64_t seed, int nt, fixture *f, double bound[MOST_M])
{
  random_state r = {.seed = seed};
  const int n = 6, m = (int)(seed % 3), k = (int)(seed / 3 % 3), joints = 1 + (int)(seed / 9 % 3);
  static const double size[] = {0, 0.1, 1, 1e3, 1e12};
  double rhs[MOST_V], lambda[MOST_M] = {0}, W_T[MOST_V * 2];
  fixture_begin(f, (nsdae_dims){.nq = n, .m = m, .k = k, .nt = nt, .f = joints});
  random_matrix(&r, m, n, f->J, m);
  random_matrix(&r, n, k, f->W_N, n);
  random_matrix(&r, n, k, W_T, n);
  for (int i = 0; i < k; i++) memcpy(f->W_T + i * nt * n, W_T + i * n, (size_t)n * sizeof *W_T);
  random_matrix(&r, n, joints, f->W_S, n);
  random_matrix(&r, joints, 1, f->w_s, joints);
  for (int j = 0; j < joints; j++) {
    int twice = j > 0 && seed % 5 == 0;
    bound[j] = size[(seed / 27 + (uint64_t)j) % 5];
    if (seed % 4 > 0 || bound[j] > 1) f->w_s[j] = 0; /* else a motor that nothing stops may jam */
    if (twice) memcpy(f->W_S + j * n, f->W_S, (size_t)n * sizeof *f->W_S);
    if (twice && bound[j] <= 1) f->w_s[j] = f->w_s[0];
    if (m > 0 && nt == 1 && seed % 7 == 0) nsdae_system_set_frictional_joint(f->system, j, 0, 0.05);
    nsdae_system_set_friction_bound(f->system, j, 1);
  }
  for (int i = 0; i < k; i++) nsdae_system_set_contact(f->system, i, 0.2, 0, 0);
  fixture_build(f, 0);
  f->contacts.slides.bound = bound;
  f->contacts.lcp.options.tol = 1e-12; /* of the laws: as dense_island.c asks for it */
  random_matrix(&r, n, 1, f->free, MOST_V);
  random_matrix(&r, m, 1, f->lambda_free, MOST_M);
  memcpy(rhs, f->free, sizeof rhs);
  fixture_factor(f);
  assert_int_equal(nsdae_kkt_solve(&f->kkt, 1, rhs, n, lambda, m), NSDAE_OK);
  memcpy(f->free, rhs, sizeof rhs); /* J free = 0 */
  return fixture_solve(f);
}

static void test_bounded(void **state)
{
  (void)state;
  int sticks = 0, slips = 0;
  for (uint64_t seed = 1; seed <= 2000; seed++) {
    fixture f[2];
    double bound[2][MOST_M];
    for (int space = 0; space < 2; space++) {
      int status = solve_bounded(seed, 1 + space, &f[space], bound[space]);
      if (status < 0) print_error("seed %d, %d: %s\n", (int)seed, space, f[space].error.text);
      assert_int_equal(status, NSDAE_OK);
      fixture_expect_laws(&f[space], 1e-9);
      double largest =
          fmax(1, nsdae_largest(f[space].dims.f, f[space].impulses.frictional_joint_impulse));
      for (int j = 0; j < f[space].dims.f; j++) {
        expect_slide_law(&f[space], j, 1e-10 * largest);
        int mode = f[space].impulses.frictional_joint_mode[j];
        double slip = f[space].impulses.slide_after[j];
        /* rows that are twice there press against each other */
        if (mode == NSDAE_MODE_STICK) assert_near(slip, 0, 1e-12 * largest);
        sticks += mode == NSDAE_MODE_STICK;
        slips += fabs(slip) > 1e-12;
      }
    }
    for (int i = 0; i < 6 && seed % 7 > 0; i++) assert_near(f[0].v[i], f[1].v[i], 1e-7);
    for (int space = 0; space < 2; space++) fixture_end(&f[space]);
  }
  assert_true(sticks > 1000 && slips > 1000);
}

int main(void)
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(test_slider),       cmocka_unit_test(test_moving_rail),
      cmocka_unit_test(test_stop),         cmocka_unit_test(test_frictionless),
      cmocka_unit_test(test_second_slide), cmocka_unit_test(test_beside_cone),
      cmocka_unit_test(test_with_cones),   cmocka_unit_test(test_bounded),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
