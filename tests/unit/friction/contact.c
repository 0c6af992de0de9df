/* One contact of a point mass on a plane, by hand: it opens, sticks or slides; in three rows, two
 * and one; in both forms; bilateral rows; the certificate of points that are no solutions. */
#include "check.h"

#include <nsdae/nsdae.h>

/* A point of mass m in space with velocity f / m, over the plane z = 0 with normal velocity w. */
typedef struct point {
  double M[9], H[9], f[3], w[3], mu;
  int size[1], first[2], block[1], rows[1];
} point;

/* Rows of H: the normal is z, the tangents x and y. */
static nsdae_friction_problem point_on_plane(point *s, double mass, double mu, int rows,
                                             const double *v)
{
  static const double H[9] = {0, 0, 1, 1, 0, 0, 0, 1, 0};
  *s = (point){.mu = mu, .size = {3}, .first = {0, 1}, .block = {0}, .rows = {rows}};
  memcpy(s->H, H, sizeof H);
  for (int i = 0; i < 3; i++) {
    s->M[4 * i] = mass;
    s->f[i] = mass * v[i];
  }
  return (nsdae_friction_problem){.contacts = 1,
                                  .rows = s->rows,
                                  .mu = &s->mu,
                                  .w = s->w,
                                  .blocks = 1,
                                  .size = s->size,
                                  .M = s->M,
                                  .f = s->f,
                                  .first = s->first,
                                  .block = s->block,
                                  .value = s->H};
}

static void check_solution(const nsdae_friction_problem *p, const double *r, const double *u)
{
  nsdae_friction_options options;
  nsdae_friction_info info;
  double x[3] = {0}, y[3];
  nsdae_friction_options_default(&options);
  options.tol = 1e-14;
  assert_int_equal(nsdae_friction_solve(p, &options, x, y, &info), NSDAE_OK);
  assert_int_equal(info.outcome, NSDAE_OUTCOME_SOLVED);
  assert_true(info.residual <= 1e-14);
  for (int i = 0; i < (p->rows ? p->rows[0] : 3); i++) {
    assert_near(x[i], r[i], 1e-13);
    assert_near(y[i], u[i], 1e-13);
  }
}

static void test_opens(void **state)
{
  (void)state;
  point s;
  const double v[3] = {1, -2, 0.5};
  nsdae_friction_problem p = point_on_plane(&s, 2, 0.5, 3, v);
  check_solution(&p, (double[]){0, 0, 0}, (double[]){0.5, 1, -2});
}

/* Falling at 2 with 0.3, 0.4 along the plane: the impulse that stops it is 2 (2, -0.3, -0.4),
 * inside the cone of 0.5: 1 <= 0.5 * 4. */
static void test_sticks(void **state)
{
  (void)state;
  point s;
  const double v[3] = {0.3, 0.4, -2};
  nsdae_friction_problem p = point_on_plane(&s, 2, 0.5, 3, v);
  check_solution(&p, (double[]){4, -0.6, -0.8}, (double[]){0, 0, 0});
  s.mu = 0.25; /* 1 <= 0.25 * 4: on the cone */
  check_solution(&p, (double[]){4, -0.6, -0.8}, (double[]){0, 0, 0});
}

/* With mu = 0.1 it slides on: r_T = -mu r_N (0.6, 0.8), u_T = (5 - 0.1 * 2) (0.6, 0.8). */
static void test_slides(void **state)
{
  (void)state;
  point s;
  const double v[3] = {3, 4, -2};
  nsdae_friction_problem p = point_on_plane(&s, 2, 0.1, 3, v);
  check_solution(&p, (double[]){4, -0.24, -0.32}, (double[]){0, 2.88, 3.84});
  s.mu = 0;
  check_solution(&p, (double[]){4, 0, 0}, (double[]){0, 3, 4});
}

static void test_fewer_rows(void **state)
{
  (void)state;
  point s;
  const double v[3] = {3, 4, -2};
  nsdae_friction_problem p = point_on_plane(&s, 2, 0.1, 2, v);
  check_solution(&p, (double[]){4, -0.4}, (double[]){0, 2.8});
  p = point_on_plane(&s, 2, 0.1, 1, v);
  check_solution(&p, (double[]){4}, (double[]){0});
}

/* u = W r + q with the sliding point's own W, and compliance that takes half of the impulse. */
static void test_local(void **state)
{
  (void)state;
  const double W[9] = {0.5, 0, 0, 0, 0.5, 0, 0, 0, 0.5}, q[3] = {-2, 3, 4}, C[3] = {0.5, 0, 0};
  const double mu = 0.1;
  const int first[2] = {0, 1}, block[1] = {0};
  nsdae_friction_problem p = {.form = NSDAE_FRICTION_LOCAL,
                              .contacts = 1,
                              .mu = &mu,
                              .w = q,
                              .first = first,
                              .block = block,
                              .value = W};
  check_solution(&p, (double[]){4, -0.24, -0.32}, (double[]){0, 2.88, 3.84});
  p.compliance = C;
  check_solution(&p, (double[]){2, -0.12, -0.16}, (double[]){0, 2.94, 3.92});
}

/* A bilateral row that moves at 1 along x beside the contact that sticks. */
static void test_bilateral(void **state)
{
  (void)state;
  point s;
  const double v[3] = {3, 0.1, -2};
  nsdae_friction_problem p = point_on_plane(&s, 2, 0.5, 3, v);
  const double H[12] = {0, 0, 1, 1, 0, 0, 0, 1, 0, 1, 0, 0}, w[4] = {0, -1, 0, -1};
  const int first[3] = {0, 1, 2}, block[2] = {0, 0};
  double r[4] = {0}, u[4], residual;
  p.bilateral = 1;
  p.first = first;
  p.block = block;
  p.value = H;
  p.w = w;
  nsdae_friction_info info;
  assert_int_equal(nsdae_friction_solve(&p, NULL, r, u, &info), NSDAE_OK);
  assert_near(r[0], 4, 1e-9);
  assert_near(r[1] + r[3], -4, 1e-9); /* any part of it may be friction */
  assert_near(r[2], -0.2, 1e-9);
  for (int i = 0; i < 4; i++) assert_near(u[i], 0, 1e-9);
  assert_int_equal(nsdae_friction_residual(&p, r, u, &residual), NSDAE_OK);
  assert_true(residual == info.residual);
}

/* By hand, with d = 0.5 and s = 4 for the sliding point of test_slides. */
static void test_residual(void **state)
{
  (void)state;
  point s;
  const double v[3] = {3, 4, -2}, zero[3] = {0}, normal[3] = {4, 0, 0};
  double u[3], residual;
  nsdae_friction_problem p = point_on_plane(&s, 2, 0, 3, v);
  assert_int_equal(nsdae_friction_residual(&p, zero, u, &residual), NSDAE_OK);
  assert_near(residual, 0.5, 1e-15); /* y_N = -2 / 4 */
  assert_int_equal(nsdae_friction_residual(&p, normal, u, &residual), NSDAE_OK);
  assert_near(residual, 0, 1e-15);
  s.mu = 0.1; /* x - y = (0.375, -0.75, -1): P has n = 0.5 / 1.01, t = -0.1 n (0.6, 0.8) */
  assert_int_equal(nsdae_friction_residual(&p, normal, NULL, &residual), NSDAE_OK);
  assert_near(residual, 0.08 * 0.5 / 1.01, 1e-15);
}

int main(void)
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(test_opens),    cmocka_unit_test(test_sticks),
      cmocka_unit_test(test_slides),   cmocka_unit_test(test_fewer_rows),
      cmocka_unit_test(test_local),    cmocka_unit_test(test_bilateral),
      cmocka_unit_test(test_residual),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
