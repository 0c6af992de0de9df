/* The residual that is the certificate of every step must not pass a point that is none, whatever
 * else is in the problem. */
#include "check.h"

#include <nsdae/nsdae.h>

enum { N = 3 };

static double residual_of(int n, const double *A, const double *b, const double *x)
{
  double y[N], work[N], residual;
  assert_int_equal(nsdae_dlcpres(n, A, n, b, x, y, &residual, work), 0);
  return residual;
}

/* Row 0 has nothing to do with the others, which are nearly dependent and have the solution
 * x_1 = 2^e + 1, x_2 = 2^e; all entries of A are of order one. A wrong x_0 is wrong however large
 * the others are (a slip or an impulse of 1e13 at another contact). All numbers are exact. */
static void test_far_apart(void **state)
{
  (void)state;
  for (int e = 0; e <= 46; e++) {
    double large = ldexp(1, e);
    const double A[N * N] = {1, 0, 0, 0, 1, -1, 0, -1, 1 + 1 / large}, b[N] = {-1, -1, 0};
    const double first[] = {0, 0.5, 2}; /* y_0 = -1, -1/2, and 1 with x_0 = 2 */
    double x[N] = {1, large + 1, large};
    assert_true(residual_of(N, A, b, x) == 0);
    for (int i = 0; i < 3; i++) {
      x[0] = first[i];
      if (!(residual_of(N, A, b, x) > 1e-3))
        fail_msg("x_1 = 2^%d, x_0 = %g for 1: residual %g", e, x[0], residual_of(N, A, b, x));
    }
  }
}

/* The other way round it is the same problem. */
static void test_scaled_rows(void **state)
{
  (void)state;
  for (int e = -14; e <= 14; e += 2) {
    double scale = pow(10, e);
    const double A[4] = {2, scale, 1, 2 * scale}, b[2] = {-4, -5 * scale};
    const double right[2] = {1, 2}, wrong[2] = {1.5, 1.5};
    assert_at_most(residual_of(2, A, b, right), 1e-15);
    assert_true(residual_of(2, A, b, wrong) > 1e-3);
  }
}

/* A (1, 1) = 0 to the last bit, and y_0 + y_1 = -2 for every x: no x is a solution, and none
 * becomes one by being large, where b is less than the rounding of A x. */
static void test_null_vector(void **state)
{
  (void)state;
  const double A[4] = {3, -3, -3, 3}, b[2] = {-1, -1};
  for (int e = 0; e <= 1000; e += 10) {
    double x[2] = {ldexp(1, e), ldexp(1, e)};
    if (!(residual_of(2, A, b, x) > 1e-7))
      fail_msg("x = 2^%d (1, 1): residual %g", e, residual_of(2, A, b, x));
  }
}

int main(void)
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(test_far_apart),
      cmocka_unit_test(test_scaled_rows),
      cmocka_unit_test(test_null_vector),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
