/* Problems whose proof is known by hand, those that fall apart, and scaled ones. */
#include "check.h"

#include <nsdae/nsdae.h>

enum { MOST = 8 };

static nsdae_lcp_info solve(int n, const double *A, const double *b, double *x, double *y)
{
  const nsdae_lcp_problem problem = {.n = n, .A = A, .lda = n, .b = b};
  nsdae_lcp_info info;
  for (int i = 0; i < n; i++) x[i] = 0;
  int status = nsdae_lcp_solve(&problem, NULL, x, y, &info);
  assert_int_equal(status, info.outcome == NSDAE_OUTCOME_SOLVED       ? NSDAE_OK
                           : info.outcome == NSDAE_OUTCOME_INFEASIBLE ? NSDAE_E_INFEASIBLE
                                                                      : NSDAE_E_LCP);
  return info;
}

/* u = y proves: u >= 0, A^T u <= 0, b^T u < 0 (small integers: no rounding in the sums). */
static void is_farkas(int n, const double *A, const double *b)
{
  double x[MOST], u[MOST], against = 0;
  nsdae_lcp_info info = solve(n, A, b, x, u);
  assert_int_equal(info.outcome, NSDAE_OUTCOME_INFEASIBLE);
  assert_int_equal(info.proof, NSDAE_PROOF_FARKAS);
  for (int i = 0; i < n; i++) {
    double sum = 0;
    for (int k = 0; k < n; k++) sum += A[i * n + k] * u[k];
    assert_true(u[i] >= 0 && sum <= 0);
    against += b[i] * u[i];
  }
  assert_true(against < 0);
}

static void test_farkas(void **state)
{
  (void)state;
  is_farkas(1, (const double[]){-1}, (const double[]){-1});
  is_farkas(1, (const double[]){0}, (const double[]){-1e-300});
  /* y_0 + y_1 = -2: only u = (1, 1) proves it, and with A^T u = 0 to the last bit */
  is_farkas(2, (const double[]){1, -1, -1, 1}, (const double[]){-1, -1});
  /* only u = (1, 3), and u = (5, 7, 3 or more): not exact where the largest entry is one */
  is_farkas(2, (const double[]){3, -1, -3, 1}, (const double[]){-1, 0});
  is_farkas(3, (const double[]){7, -5, 0, -7, 5, 0, 0, 3, -7}, (const double[]){-1, 0, 0});
  /* y_0 = -x_1 - 1 */
  is_farkas(2, (const double[]){0, 1, -1, 0}, (const double[]){-1, 0});
}

/* y_0 = x_1 - 1, y_1 = x_0 + 1: y_1 > 0 asks for x_1 = 0, and then y_0 = -1. x_1 = 1 is feasible.
 */
static void test_enumerated(void **state)
{
  (void)state;
  const double A[4] = {0, 1, 1, 0}, b[2] = {-1, 1};
  double x[2], y[2];
  nsdae_lcp_info info = solve(2, A, b, x, y);
  assert_int_equal(info.outcome, NSDAE_OUTCOME_INFEASIBLE);
  assert_int_equal(info.proof, NSDAE_PROOF_ENUMERATED);
}

/* All square blocks of the x_i > 0 are singular in every solution. First x_0 = 1; then 2 x_0 - x_2
 * = 1 in rows 0 and 2 alike, x_0 >= 3. */
static void test_singular_blocks(void **state)
{
  (void)state;
  const double few[4] = {0, 1, 0, 0}, b[2] = {0, -1};
  const double repeated[16] = {2, -3, 2, -1, -2, -3, -2, -1, -1, 2, -1, 1, 0, 0, 0, 0};
  const double c[4] = {-1, -1, -1, 1};
  double x[4], y[4];
  assert_int_equal(solve(2, few, b, x, y).outcome, NSDAE_OUTCOME_SOLVED);
  assert_near(x[0], 1, 1e-12);
  assert_int_equal(solve(4, repeated, c, x, y).outcome, NSDAE_OUTCOME_SOLVED);
  assert_near(2 * x[0] - x[2], 1, 1e-9);
  assert_true(x[0] > 3 - 1e-9 && x[1] == 0);
}

/* A ray on a skew matrix (x^T A x = 0 for all x) and on a negative one. */
static void test_ray(void **state)
{
  (void)state;
  double x[2], y[2];
  nsdae_lcp_info info = solve(1, (const double[]){-1}, (const double[]){-1}, x, y);
  assert_int_equal(info.ray, NSDAE_LCP_RAY_NOT_COPOSITIVE);
  info = solve(2, (const double[]){0, 1, -1, 0}, (const double[]){-1, 0}, x, y);
  assert_int_equal(info.ray, NSDAE_LCP_RAY_NOT_STRICTLY_COPOSITIVE);
  info = solve(1, (const double[]){1}, (const double[]){-1}, x, y);
  assert_int_equal(info.outcome, NSDAE_OUTCOME_SOLVED);
  assert_int_equal(info.ray, NSDAE_LCP_RAY_NOTHING);
}

/* Two islands, rows interleaved: one solved, one without solution; u is zero outside it. */
static void test_islands(void **state)
{
  (void)state;
  const double A[16] = {2, 0, 1, 0, 0, -1, 0, 1, 1, 0, 2, 0, 0, 1, 0, -1};
  double b[4] = {-3, -1, -3, -1}, x[4], y[4];
  is_farkas(4, A, b);
  nsdae_lcp_info info = solve(4, A, b, x, y);
  assert_true(y[0] == 0 && y[2] == 0 && y[1] > 0 && y[3] > 0);
  assert_near(x[0], 1, 1e-15);
  assert_near(x[2], 1, 1e-15);
  b[1] = b[3] = 1;
  info = solve(4, A, b, x, y);
  assert_int_equal(info.outcome, NSDAE_OUTCOME_SOLVED);
  assert_near(x[0], 1, 1e-15);
  assert_true(x[1] == 0 && y[1] == 1);
  /* what is rounding beside the other island is none of its own: zero is a solution of both */
  b[1] = b[3] = -1e-18;
  info = solve(4, A, b, x, y);
  assert_int_equal(info.outcome, NSDAE_OUTCOME_SOLVED);
}

/* -x - 1 is never >= 0, however large the b of another island is that hides it. */
static void test_proof_of_a_small_island(void **state)
{
  (void)state;
  const double A[4] = {-1, 0, 0, 1}, joined[9] = {1, -1, 0, -1, 1, 0, 0, 0, 2};
  for (double large = 1; large < 4e15; large *= 10) {
    is_farkas(2, A, (const double[]){-1, large});
    is_farkas(2, A, (const double[]){-1, -large});
    is_farkas(3, joined, (const double[]){-1, -1, large});
  }
}

/* Twenty rows of which sixteen are one island, b = 0 elsewhere: x = 0 there, whatever the scale. */
static void test_large_island(void **state)
{
  (void)state;
  enum { N = 20, LINKED = 16 };
  double A[N * N] = {0}, b[N] = {0}, x[N], y[N];
  for (int i = 0; i < N; i++) A[i * N + i] = 2;
  for (int i = 1; i < LINKED; i++) A[i * N + i - 1] = A[(i - 1) * N + i] = -1;
  for (int i = 0; i < LINKED; i++) b[i] = -1e-312;
  const nsdae_lcp_problem problem = {.n = N, .A = A, .lda = N, .b = b};
  for (int i = 0; i < N; i++) x[i] = 1e-79;
  assert_int_equal(nsdae_lcp_solve(&problem, NULL, x, y, NULL), NSDAE_OK);
  for (int i = 0; i < N; i++) assert_true(i < LINKED ? x[i] > 0 : x[i] == 0);
}

/* x = (1, 2) in rows and columns from 2^-60 to 2^60. */
static void test_scaled(void **state)
{
  (void)state;
  for (int r = -60; r <= 60; r += 10)
    for (int s = -60; s <= 60; s += 10) {
      const double A[4] = {2, ldexp(1, r), ldexp(1, s), ldexp(3, r + s)};
      const double b[2] = {-4, ldexp(-7, r)};
      double x[2], y[2];
      nsdae_lcp_info info = solve(2, A, b, x, y);
      assert_int_equal(info.outcome, NSDAE_OUTCOME_SOLVED);
      assert_near(x[0], 1, 1e-14);
      assert_near(ldexp(x[1], s), 2, 1e-14);
    }
}

/* Without solution at both ends of the range of numbers, where b must not vanish in the scales. */
static void test_ends_of_the_range(void **state)
{
  (void)state;
  const double sizes[] = {0x1p-1074, 1e-300, 1e-150, 1, 1e150, 1e300, 1.7e308};
  for (int i = 0; i < 7; i++)
    for (int j = 0; j < 7; j++) {
      double x[2], y[2];
      is_farkas(1, (const double[]){-sizes[i]}, (const double[]){-sizes[j]});
      nsdae_lcp_info info = solve(2, (const double[]){sizes[i], -sizes[i], -sizes[i], sizes[i]},
                                  (const double[]){-sizes[j], -sizes[j]}, x, y);
      assert_int_not_equal(info.outcome, NSDAE_OUTCOME_SOLVED);
      /* x = size_j / size_i, solved wherever that can be written */
      info = solve(1, (const double[]){sizes[i]}, (const double[]){-sizes[j]}, x, y);
      assert_int_not_equal(info.outcome, NSDAE_OUTCOME_INFEASIBLE);
      double ratio = sizes[j] / sizes[i];
      if (isnormal(ratio) && ratio < 1e307) {
        assert_int_equal(info.outcome, NSDAE_OUTCOME_SOLVED);
        assert_near(x[0] / ratio, 1, 1e-10);
      }
    }
}

int main(void)
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(test_farkas),
      cmocka_unit_test(test_enumerated),
      cmocka_unit_test(test_ray),
      cmocka_unit_test(test_islands),
      cmocka_unit_test(test_proof_of_a_small_island),
      cmocka_unit_test(test_large_island),
      cmocka_unit_test(test_scaled),
      cmocka_unit_test(test_singular_blocks),
      cmocka_unit_test(test_ends_of_the_range),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
