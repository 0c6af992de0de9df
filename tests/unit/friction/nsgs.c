/* Sweeps where a contact by itself is not like most: without friction, its block of any scale,
 * nearly isotropic, of rank one; opening and sticking both solutions; nothing left to change; a
 * local form without a diagonal. */
#include "check.h"

#include <nsdae/kernels.h>
#include <nsdae/nsdae.h>

#include "../linalg/random_matrices.h"

static random_state draws = {31};

static double draw(void)
{
  return random_number(&draws);
}

/* r k is the same for every k in k W r + q, and so is u. */
static void test_scales(void **state)
{
  (void)state;
  const double q[3] = {-1, 2, 0.5}, W[9] = {1, 0, 0, 0, 1, 0.5, 0, 0.5, 1.2};
  double r[3], u[3], residual, at_one[3], u_at_one[3];
  assert_int_equal(nsdae_dfccon(3, W, 3, q, 0.3, at_one, u_at_one, &residual), 0);
  assert_true(residual < 1e-15);
  assert_near(hypot(at_one[1], at_one[2]), 0.3 * at_one[0], 1e-15); /* it slides */
  for (int e = -1000; e <= 1000; e += 125) {
    double scaled[9], k = ldexp(1, e);
    for (int j = 0; j < 9; j++) scaled[j] = k * W[j];
    assert_int_equal(nsdae_dfccon(3, scaled, 3, q, 0.3, r, u, &residual), 0);
    assert_true(residual < 1e-14);
    for (int j = 0; j < 3; j++) {
      assert_near(r[j] * k, at_one[j], 1e-15);
      assert_near(u[j], u_at_one[j], 1e-15);
    }
  }
}

/* Of W = 1 and a coupling of the tangents that is nearly none: r is what it is without. */
static void test_nearly_isotropic(void **state)
{
  (void)state;
  const double q[3] = {-1, 2, 0.5};
  for (int e = -1070; e <= -50; e += 20) {
    double c = ldexp(1, e), W[9] = {1, 0, 0, 0, 1, c, 0, c, 1}, r[3], u[3], residual;
    assert_int_equal(nsdae_dfccon(3, W, 3, q, 0.3, r, u, &residual), 0);
    assert_near(r[1], -0.3 * 2 / hypot(2, 0.5), 1e-14);
    assert_near(r[2], -0.3 * 0.5 / hypot(2, 0.5), 1e-14);
  }
}

static void solve_by_sweeps(const nsdae_friction_problem *p, double *r, double *u,
                            nsdae_friction_info *info)
{
  nsdae_friction_options options;
  nsdae_friction_options_default(&options);
  options.stages = NSDAE_FRICTION_NSGS;
  assert_int_equal(nsdae_friction_solve(p, &options, r, u, info), NSDAE_OK);
}

/* One coordinate that a contact presses and drags: W = H^T H is of rank one, and what a sweep takes
 * for its inverse must not be rounding. Impulses that stop it: H r = 1. */
static void test_rank_one(void **state)
{
  (void)state;
  const int first[] = {0, 1}, block[] = {0}, size[] = {1};
  const double M[] = {1}, f[] = {-1}, w[3] = {0}, mu[] = {3};
  for (int k = 0; k < 500; k++) {
    double H[3] = {1, draw(), draw()}, r[3] = {0}, u[3];
    nsdae_friction_info info;
    const nsdae_friction_problem p = {.form = NSDAE_FRICTION_GLOBAL,
                                      .contacts = 1,
                                      .mu = mu,
                                      .blocks = 1,
                                      .size = size,
                                      .M = M,
                                      .f = f,
                                      .w = w,
                                      .first = first,
                                      .block = block,
                                      .value = H};
    solve_by_sweeps(&p, r, u, &info);
    assert_true(info.sweeps <= 20);
    assert_near(H[0] * r[0] + H[1] * r[1] + H[2] * r[2], 1, 1e-9);
  }
}

/* Two contacts, hardly coupled; the first parts by itself, and would jam if it were pressed. */
static void test_opens_before_it_sticks(void **state)
{
  (void)state;
  const int first[] = {0, 2, 4}, block[] = {0, 1, 0, 1};
  const double mu[] = {2, 0.5}, w[6] = {0.1, -1, 0, -1, 0, 0}, c = 1e-3;
  const double value[36] = {1, -0.9, 0, -0.9, 1, 0, 0, 0, 1, c, 0, 0, 0, c, 0, 0, 0, c,
                            c, 0,    0, 0,    c, 0, 0, 0, c, 1, 0, 0, 0, 1, 0, 0, 0, 1};
  const nsdae_friction_problem p = {.form = NSDAE_FRICTION_LOCAL,
                                    .contacts = 2,
                                    .mu = mu,
                                    .w = w,
                                    .first = first,
                                    .block = block,
                                    .value = value};
  double r[6] = {0}, u[6];
  nsdae_friction_info info;
  solve_by_sweeps(&p, r, u, &info);
  assert_true(r[0] == 0 && r[1] == 0 && r[2] == 0);
  assert_near(u[0], 0.101, 1e-6);
}

/* A row of three masses on the ground, without friction; a rod holds the last, which is pulled up
 * by 2, to the one below: r = (4, 3, -2) by equilibrium. */
static void test_without_friction(void **state)
{
  (void)state;
  const int first[] = {0, 1, 3, 5}, block[] = {0, 0, 1, 1, 2}, size[] = {1, 1, 1}, rows[] = {1, 1};
  const double M[] = {1, 1, 1}, f[] = {-1, -5, 2}, w[3] = {0}, mu[] = {0, 0};
  const double H[] = {1, -1, 1, -1, 1}, wanted[] = {4, 3, -2};
  const nsdae_friction_problem p = {.form = NSDAE_FRICTION_GLOBAL,
                                    .contacts = 2,
                                    .bilateral = 1,
                                    .rows = rows,
                                    .mu = mu,
                                    .blocks = 3,
                                    .size = size,
                                    .M = M,
                                    .f = f,
                                    .w = w,
                                    .first = first,
                                    .block = block,
                                    .value = H};
  double r[3] = {0}, u[3];
  nsdae_friction_info info;
  solve_by_sweeps(&p, r, u, &info);
  assert_true(info.sweeps > 0);
  /* W^-1 of three masses in a row is 6 at most, velocities are right to the tolerance 1e-8 */
  for (int i = 0; i < 3; i++) assert_near(r[i], wanted[i], 1e-6);
}

/* A ball between two plates that squeeze it by 1e7: the guess is a fixed point of the sweep, whose
 * residual is the rounding of so large an impulse. Sweeps see it at once. */
static void test_nothing_changes(void **state)
{
  (void)state;
  const int first[] = {0, 1, 2}, block[] = {0, 0}, size[] = {3};
  const double M[9] = {1, 0, 0, 0, 1, 0, 0, 0, 1}, w[6] = {0}, mu[] = {0.5, 0.5};
  const double f[3] = {0.1, -0.3, 0.2};
  const double H[18] = {1, 0, 0, 0, 1, 0, 0, 0, 1, -1, 0, 0, 0, 1, 0, 0, 0, 1};
  double r[6] = {1e7, 0, 0, 1e7, 0, 0}, u[6];
  const nsdae_friction_problem p = {.form = NSDAE_FRICTION_GLOBAL,
                                    .contacts = 2,
                                    .mu = mu,
                                    .blocks = 1,
                                    .size = size,
                                    .M = M,
                                    .f = f,
                                    .w = w,
                                    .first = first,
                                    .block = block,
                                    .value = H};
  nsdae_friction_options options;
  nsdae_friction_info info;
  nsdae_friction_options_default(&options);
  options.stages = NSDAE_FRICTION_WARM;
  nsdae_friction_solve(&p, &options, r, u, &info);
  assert_true(info.sweeps <= 100);
}

/* W_00 = 0 and W_01 not: no W that is positive semidefinite. */
static void test_no_diagonal(void **state)
{
  (void)state;
  const int first[] = {0, 2, 4}, block[] = {0, 1, 0, 1};
  const double mu[] = {0.5, 0.5}, w[6] = {1, 0, 0, -1, 0.2, 0}, c = 0.5;
  double value[36] = {0, 0, 0, 0, 0, 0, 0, 0, 0, c, 0, 0, 0, c, 0, 0, 0, c,
                      c, 0, 0, 0, c, 0, 0, 0, c, 1, 0, 0, 0, 1, 0, 0, 0, 1};
  nsdae_friction_problem p = {.form = NSDAE_FRICTION_LOCAL,
                              .contacts = 2,
                              .mu = mu,
                              .w = w,
                              .first = first,
                              .block = block,
                              .value = value};
  double r[6] = {0}, u[6];
  nsdae_error error;
  assert_int_equal(nsdae_friction_check(&p, &error), NSDAE_E_ARGUMENT);
  assert_string_equal(error.text, "W of items 0 and 1: off zero, as the diagonal is zero, by 0.5, "
                                  "bound 0");
  assert_int_equal(nsdae_friction_solve(&p, NULL, r, u, NULL), NSDAE_E_ARGUMENT);
  value[4] = -1;
  assert_int_equal(nsdae_friction_check(&p, &error), NSDAE_E_ARGUMENT);
  assert_string_equal(error.text, "W(1, 1) = -1: must be >= 0");
  value[4] = 0;
  for (int k = 9; k < 27; k++) value[k] = 0; /* nothing moves it, and it does not approach */
  assert_int_equal(nsdae_friction_solve(&p, NULL, r, u, NULL), NSDAE_OK);
  assert_near(r[3], 1, 1e-9);
}

int main(void)
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(test_scales),           cmocka_unit_test(test_nearly_isotropic),
      cmocka_unit_test(test_rank_one),         cmocka_unit_test(test_opens_before_it_sticks),
      cmocka_unit_test(test_without_friction), cmocka_unit_test(test_nothing_changes),
      cmocka_unit_test(test_no_diagonal),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
