/* Projected Gauss-Seidel: its iterates by hand, its rates, what it converges on and what not. */
#include "problems.h"

static int pgs(const problem *p, double omega, double tol, int max_iter, double *x, int *iterations,
               double *residual)
{
  double work[2 * MOST];
  return nsdae_dlcppgs(p->n, p->A, p->n, p->b, omega, tol, max_iter, x, iterations, residual, work,
                       2 * MOST);
}

static const problem two = {
    .n = 2, .A = {2, 1, 1, 2}, .b = {-5, -6}, .x = {4.0 / 3, 7.0 / 3}}; /* both active */

/* Sweeps by hand from zero: (5/2, 7/4), (13/8, 35/16); then each error is a quarter of the last,
 * the spectral radius a_12^2 / (a_11 a_22) of Gauss-Seidel. */
static void test_sweeps(void **state)
{
  (void)state;
  const double first[] = {2.5, 1.75}, second[] = {1.625, 2.1875};
  double x[2] = {0}, residual, before;
  int iterations;
  assert_int_equal(pgs(&two, 1, 0, 1, x, &iterations, &residual), 1);
  assert_int_equal(iterations, 1);
  for (int i = 0; i < 2; i++) assert_true(x[i] == first[i]);
  assert_int_equal(pgs(&two, 1, 0, 1, x, &iterations, &residual), 1);
  for (int i = 0; i < 2; i++) assert_true(x[i] == second[i]);
  for (int k = 0; k < 10; k++) {
    before = x[0] - two.x[0];
    assert_int_equal(pgs(&two, 1, 0, 1, x, &iterations, &residual), 1);
    assert_near(x[0] - two.x[0], before / 4, 1e-15);
  }
}

/* Young's optimal omega, 2 / (1 + sqrt(1 - rho^2)) with rho = 1/2 of Jacobi, converges like
 * (omega - 1)^k = 0.072^k against 0.25^k. */
static void test_relaxation(void **state)
{
  (void)state;
  double x[2] = {0}, residual, omega = 2 / (1 + sqrt(0.75));
  int plain, relaxed;
  assert_int_equal(pgs(&two, 1, tight, 100, x, &plain, &residual), 0);
  expect_solution(&two, x, residual);
  x[0] = x[1] = 0;
  assert_int_equal(pgs(&two, omega, tight, 100, x, &relaxed, &residual), 0);
  expect_solution(&two, x, residual);
  assert_true(relaxed < plain * 3 / 4);
}

static void test_by_hand(void **state)
{
  (void)state;
  problem p = two;
  const double bs[3][2] = {{1, 0}, {-5, 1}, {3, -4}}, xs[3][2] = {{0, 0}, {2.5, 0}, {0, 2}};
  for (int k = 0; k < 3; k++) {
    double x[2] = {k - 1.0, 1.0 - k}, residual; /* negative entries of the start count as zero */
    int iterations;
    memcpy(p.b, bs[k], sizeof bs[k]);
    memcpy(p.x, xs[k], sizeof xs[k]);
    assert_int_equal(pgs(&p, 1, tight, 100, x, &iterations, &residual), 0);
    expect_solution(&p, x, residual);
    assert_int_equal(pgs(&p, 1, tight, 0, x, &iterations, &residual), 0);
    assert_int_equal(iterations, 0); /* a solution is one at the start */
  }
}

/* x^T A x / 2 + b^T x, which every sweep lowers where A is symmetric positive definite. */
static double objective(const problem *p, const double *x)
{
  double sum = 0;
  for (int j = 0; j < p->n; j++) {
    sum += p->b[j] * x[j];
    for (int i = 0; i < p->n; i++) sum += x[i] * p->A[j * p->n + i] * x[j] / 2;
  }
  return sum;
}

static void test_definite(void **state)
{
  (void)state;
  random_state r = {1};
  for (int k = 0; k < 200; k++) {
    problem p;
    double x[MOST] = {0}, residual, omega = 1 + 0.8 * random_number(&r), before = 0;
    int iterations, info = 1;
    make_definite(&r, random_int(&r, 1, MOST), 0, &p);
    choose_solution(&r, &p);
    for (int i = 0; i < 1000 && info == 1; i++) {
      info = pgs(&p, omega, tight, 1, x, &iterations, &residual);
      assert_true(objective(&p, x) <= before + 1e-12 * p.n);
      before = objective(&p, x);
    }
    assert_int_equal(info, 0);
    expect_solution(&p, x, residual);
    expect_lemke(&p, x);
  }
}

static void test_diagonal(void **state)
{
  (void)state;
  problem p = two;
  const double wrong[] = {0, -1};
  for (int k = 0; k < 4; k++) {
    double x[2] = {-1, 1}, residual;
    int iterations;
    p = two;
    p.A[k / 2 * 3] = wrong[k % 2];
    assert_int_equal(pgs(&p, 1, tight, 100, x, &iterations, &residual), 2);
    assert_true(x[0] == -1 && x[1] == 1);
  }
}

/* x = (1, 1) grows ninefold a sweep: to the end of the numbers, then a status. */
static void test_diverging(void **state)
{
  (void)state;
  const problem p = {.n = 2, .A = {1, -3, -3, 1}, .b = {-1, -1}};
  double x[2] = {0}, residual;
  int iterations;
  assert_int_equal(pgs(&p, 1, tight, 100, x, &iterations, &residual), 1);
  assert_int_equal(iterations, 100);
  assert_true(residual > 0.1);
  assert_int_equal(pgs(&p, 1, tight, 100000, x, &iterations, &residual), 3);
  assert_true(iterations < 400 && isnan(residual)); /* 9^323 is past 1e308 */
}

int main(void)
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(test_sweeps),   cmocka_unit_test(test_relaxation),
      cmocka_unit_test(test_by_hand),  cmocka_unit_test(test_definite),
      cmocka_unit_test(test_diagonal), cmocka_unit_test(test_diverging),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
