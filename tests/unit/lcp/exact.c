/* Signs of sums that rounding gets wrong. */
#include "check.h"

#include "proof.h"
#include "support/random.h"

static void test_cancellation(void **state)
{
  (void)state;
  const double tiny = 0x1p-60;
  const double a[4] = {1, tiny, -1, 0x1p70}, u[4] = {1, 1, 1, 0};
  assert_int_equal(nsdae_exact_sign(4, a, 1, u), 1); /* in doubles 1 + tiny - 1 = 0 */
  const double b[3] = {1 + 0x1p-30, 1, -0x1p-59}, v[3] = {1 - 0x1p-30, -1, -0.5};
  /* (1 + e)(1 - e) - 1 + e^2 / 1 with e^2 = 2^-60: exactly zero */
  assert_int_equal(nsdae_exact_sign(3, b, 1, v), 0);
  const double w[3] = {1 - 0x1p-30, -1, -0.5 + 0x1p-54};
  assert_int_equal(nsdae_exact_sign(3, b, 1, w), -1);
}

/* Integers below 2^26 with many terms: the sum is exact in 64 bits. */
static void test_against_integers(void **state)
{
  (void)state;
  enum { N = 40 };
  uint64_t seed = 1;
  for (int round = 0; round < 1000; round++) {
    double a[2 * N], u[N];
    long long sum = 0;
    for (int i = 0; i < N; i++) {
      long long one = random_below(&seed, 1 << 26) - (1 << 25);
      long long other = random_below(&seed, 1 << 26) - (1 << 25);
      if (i == N - 1 && round % 2 == 0) { /* close to zero */
        one = sum / (1 << 20);
        other = -(1 << 20);
      }
      a[2 * i] = (double)one;
      u[i] = (double)other;
      sum += one * other;
    }
    assert_int_equal(nsdae_exact_sign(N, a, 2, u), sum > 0 ? 1 : sum < 0 ? -1 : 0);
  }
}

static void test_range(void **state)
{
  (void)state;
  const double huge[2] = {1e300, 1}, small[2] = {1e-300, 1}, one[2] = {1e300, 1};
  const double odd[2] = {NAN, 1};
  const double least[2] = {0x1p-1074, -0x1p-1074}, most[2] = {0x1.fffffffffffffp1023, 0};
  assert_int_equal(nsdae_exact_sign(2, huge, 1, one), NSDAE_SIGN_UNKNOWN);
  assert_int_equal(nsdae_exact_sign(2, small, 1, small), NSDAE_SIGN_UNKNOWN);
  assert_int_equal(nsdae_exact_sign(2, least, 1, least), 1); /* 2 x 2^-2148 */
  assert_int_equal(nsdae_exact_sign(2, most, 1, most), 1);
  assert_int_equal(nsdae_exact_sign(2, least, 1, (const double[]){3, 4}), -1);
  assert_int_equal(nsdae_exact_sign(2, small, 1, one), 1);
  assert_int_equal(nsdae_exact_sign(2, odd, 1, one), NSDAE_SIGN_UNKNOWN);
  assert_int_equal(nsdae_exact_sign(0, NULL, 1, NULL), 0);
}

int main(void)
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(test_cancellation),
      cmocka_unit_test(test_against_integers),
      cmocka_unit_test(test_range),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
