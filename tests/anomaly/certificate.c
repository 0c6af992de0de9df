/* The residual that is the certificate of every step must not pass a point that is none, whatever
 * else is in the problem. */
#include "check.h"

#include <nsdae/nsdae.h>

static double residual_of(const double A[4], const double b[2], const double x[2])
{
  double y[2], residual;
  assert_int_equal(nsdae_dlcpres(2, A, 2, b, x, y, &residual), 0);
  return residual;
}

/* Two problems that have nothing to do with each other, x_0 = 1 and x_1 = size: a wrong x_0 is
 * wrong however large x_1 is. (Contacts: a slip of 1e13 m/s or an impulse of 1e13 N s elsewhere.) */
static void test_far_apart(void **state)
{
  (void)state;
  for (int e = -14; e <= 14; e += 2) {
    double size = pow(10, e);
    const double A[4] = {1, 0, 0, 1 / size}, b[2] = {-1, -1};
    const double right[2] = {1, size}, low[2] = {0.5, size}, high[2] = {2, size}, none[2] = {0, size};
    const double other[2] = {1, size / 2};
    assert_at_most(residual_of(A, b, right), 1e-15); /* a rounding or two */
    assert_true(residual_of(A, b, low) > 1e-3);      /* y_0 = -1/2 of 1 */
    assert_true(residual_of(A, b, high) > 1e-3);     /* y_0 = 1 with x_0 = 2 */
    assert_true(residual_of(A, b, none) > 1e-3);     /* y_0 = -1 */
    assert_true(residual_of(A, b, other) > 1e-3);    /* y_1 = -1/2 */
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
    assert_at_most(residual_of(A, b, right), 1e-15);
    assert_true(residual_of(A, b, wrong) > 1e-3);
  }
}

int main(void)
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(test_far_apart),
      cmocka_unit_test(test_scaled_rows),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
