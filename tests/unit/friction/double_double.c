/* Solutions in two parts: of a stack of masses, known exactly, that no r of doubles solves; of a
 * random one in long arithmetic; and what does not need a second part has none. */
#include "check.h"

#include <float.h>
#include <stdlib.h>
#include <string.h>

#include <nsdae/nsdae.h>

#include "cone.h"
#include "../linalg/random_matrices.h"

enum { MOST = 8, ROWS = 3 };

/* Point masses on top of each other, the first one on the ground: u_c = v_c - v_(c - 1), and f = -m
 * g h downwards, so that r_c is what lies above. */
typedef struct stack {
  nsdae_friction_problem problem;
  int count, first[MOST + 1], block[2 * MOST], size[MOST];
  double M[9 * MOST], f[3 * MOST], value[18 * MOST], mu[MOST], w[3 * MOST];
} stack;

static void add_identity(double *part, double sign)
{
  for (int i = 0; i < ROWS; i++) part[4 * i] = sign;
}

static void make_stack(stack *s, int count, const double *mass)
{
  *s = (stack){.count = count};
  int parts = 0;
  for (int c = 0; c < count; c++) {
    s->size[c] = ROWS;
    s->mu[c] = 0.5;
    add_identity(s->M + 9 * c, mass[c]);
    s->f[3 * c] = -mass[c] * 0.04905;
    add_identity(s->value + 9 * parts, 1);
    s->block[parts++] = c;
    if (c > 0) {
      add_identity(s->value + 9 * parts, -1);
      s->block[parts++] = c - 1;
    }
    s->first[c + 1] = parts;
  }
  s->problem = (nsdae_friction_problem){.form = NSDAE_FRICTION_GLOBAL,
                                        .contacts = count,
                                        .mu = s->mu,
                                        .w = s->w,
                                        .blocks = count,
                                        .size = s->size,
                                        .M = s->M,
                                        .f = s->f,
                                        .first = s->first,
                                        .block = s->block,
                                        .value = s->value};
}

/* A light mass under a heavy one: r_0 = r_1 - f_0 has digits that r_1 + its last one has not. In
 * doubles the velocity of the light mass is f_0 plus a multiple of the last digit of r, over its
 * mass; the residual, relative to its free velocity, at least what rounding leaves of f_0. */
static void test_light_below_heavy(void **state)
{
  (void)state;
  stack s;
  const double mass[] = {1, 1e6};
  double r[6] = {0}, low[6], u[6], back[6], residual;
  nsdae_friction_options options;
  nsdae_friction_info info;
  make_stack(&s, 2, mass);
  nsdae_friction_options_default(&options);
  options.tol = 1e-12;
  const double above = -s.f[3], below = above - s.f[0], rest = -s.f[0] - (below - above);
  assert_true(fabs(rest) > 1e-13 && fabs(rest) / fabs(s.f[0]) > 1e-12);
  assert_int_equal(nsdae_friction_solve(&s.problem, &options, r, u, &info), NSDAE_E_LCP);
  assert_true(info.residual >= 0.5 * fabs(rest) / fabs(s.f[0]) && info.residual < 1e-9);
  memset(r, 0, sizeof r);
  assert_int_equal(nsdae_friction_solve_twice(&s.problem, &options, r, low, u, &info), NSDAE_OK);
  assert_int_equal(info.outcome, NSDAE_OUTCOME_SOLVED);
  assert_true(info.residual <= 1e-12);
  assert_near(r[0], below, 1e-12 * below);
  assert_near((r[0] - r[3]) + (low[0] - low[3]), -s.f[0], 1e-12 * fabs(s.f[0]));
  assert_near((r[3] - above) + low[3], 0, 1e-12 * above);
  assert_int_equal(nsdae_friction_residual_twice(&s.problem, r, low, back, &residual), NSDAE_OK);
  assert_true(residual == info.residual && memcmp(u, back, sizeof u) == 0);
  assert_int_equal(nsdae_friction_residual_twice(&s.problem, r, NULL, back, &residual), NSDAE_OK);
  assert_true(residual > 1e-12);
}

/* Without a second part where the first is enough: the same bits as in one. */
static void test_not_needed(void **state)
{
  (void)state;
  stack s;
  const double mass[] = {3, 2, 1};
  double r[9] = {0}, one[9] = {0}, low[9], u[9];
  make_stack(&s, 3, mass);
  memset(low, 1, sizeof low);
  assert_int_equal(nsdae_friction_solve(&s.problem, NULL, one, u, NULL), NSDAE_OK);
  assert_int_equal(nsdae_friction_solve_twice(&s.problem, NULL, r, low, u, NULL), NSDAE_OK);
  for (int i = 0; i < 9; i++) assert_true(low[i] == 0 && r[i] == one[i]);
}

/* Held twice as far outside the cone as it may be: x = (1, -2, 0) / 2, whose nearest point of the
 * cone is (0.8, -0.4, 0), at any scale of mass and force, and whichever of its parts holds it. It
 * slides, which is solved as in one part. */
static void test_scales(void **state)
{
  (void)state;
  static const double scales[][2] = {{1, 1},      {1e-160, 1}, {1e-200, 10}, {1, 1e-170},
                                     {1e155, 10}, {1e200, 1},  {1, 1e160},   {1e120, 1e-150}};
  for (size_t k = 0; k < sizeof scales / sizeof *scales; k++) {
    stack s;
    const double m = scales[k][0], g = scales[k][1], none[3] = {0};
    double r[3], low[3], u[3], residual;
    make_stack(&s, 1, &m);
    s.f[0] = -m * g;
    s.f[1] = 2 * m * g;
    for (int i = 0; i < 3; i++) r[i] = -s.f[i];
    assert_int_equal(nsdae_friction_residual_twice(&s.problem, r, none, u, &residual), NSDAE_OK);
    assert_near(residual, 0.6, 1e-15);
    assert_int_equal(nsdae_friction_residual_twice(&s.problem, none, r, u, &residual), NSDAE_OK);
    assert_near(residual, 0.6, 1e-15);
    memset(r, 0, sizeof r);
    assert_int_equal(nsdae_friction_solve_twice(&s.problem, NULL, r, low, u, NULL), NSDAE_OK);
    assert_near(r[0] / (m * g), 1, 1e-10);
    assert_near(r[1] / (m * g), -0.5, 1e-10);
    assert_near(u[1] / g, 1.5, 1e-10);
  }
}

static void test_arguments(void **state)
{
  (void)state;
  stack s;
  const double mass[] = {1, 1e6};
  double r[6] = {0}, low[6] = {0}, u[6], residual = 7;
  make_stack(&s, 2, mass);
  nsdae_friction_options options;
  nsdae_friction_options_default(&options);
  assert_int_equal(nsdae_friction_solve_twice(&s.problem, &options, NULL, low, u, NULL),
                   NSDAE_E_ARGUMENT);
  assert_int_equal(nsdae_friction_solve_twice(&s.problem, &options, r, low, NULL, NULL),
                   NSDAE_E_ARGUMENT);
  options.tol = 0;
  assert_int_equal(nsdae_friction_solve_twice(&s.problem, &options, r, low, u, NULL),
                   NSDAE_E_ARGUMENT);
  low[4] = NAN;
  assert_int_equal(nsdae_friction_residual_twice(&s.problem, r, low, u, &residual), NSDAE_OK);
  assert_true(isnan(residual));
  assert_int_equal(nsdae_friction_residual_twice(&s.problem, r, low, u, NULL), NSDAE_E_ARGUMENT);
}

/* Where x lies as seen in long double, whose 64 bits hold a + b of these. */
static void check_map(double mu)
{
  static random_state draws = {5};
  double x[3], low[3], y[3], F[3];
  for (int k = 0; k < 3; k++) {
    x[k] = ldexp(floor(ldexp(random_number(&draws), 30)), -20);
    low[k] = ldexp(random_number(&draws), -34);
    y[k] = random_number(&draws) * 1e-9;
  }
  /* near the cone: x_N such that mu x_N is |x_T| to ten digits */
  x[0] = (float)(hypot(x[1], x[2]) / mu);
  nsdae_fc_place p = nsdae_fc_place_of(mu, x, low, y);
  nsdae_fc_map_of_place(mu, &p, x, y, F);
  long double z[3], t, over, big = mu > 1 ? mu : 1;
  for (int k = 0; k < 3; k++) z[k] = (long double)x[k] + low[k] - y[k];
  t = hypotl(z[1], z[2]);
  over = (t - mu * z[0]) / big;
  assert_near(p.over, (double)over, 8 * (double)LDBL_EPSILON * (double)t);
  assert_true(p.inside == (over <= 0) || fabsl(over) <= 8 * LDBL_EPSILON * t);
  long double l = over <= 0 ? 0 : over * big / (1 + (long double)mu * mu);
  const long double expected[3] = {y[0] - mu * l, y[1] + l * z[1] / t, y[2] + l * z[2] / t};
  for (int k = 0; k < 3; k++)
    assert_near(F[k], (double)expected[k],
                16 * (double)LDBL_EPSILON * (double)t + 4 * DBL_EPSILON * fabs(F[k]));
}

static void test_map(void **state)
{
  (void)state;
  const double mu[] = {0.05, 0.5, 1, 3, 40};
  for (int k = 0; k < 2000; k++) check_map(mu[k % 5]);
}

int main(void)
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(test_light_below_heavy), cmocka_unit_test(test_not_needed),
      cmocka_unit_test(test_scales), cmocka_unit_test(test_arguments), cmocka_unit_test(test_map)};
  return cmocka_run_group_tests(tests, NULL, NULL);
}
