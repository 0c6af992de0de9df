/* A start from an active set: it is of use again where it comes from, and whatever it is, it
 * decides neither whether a problem is solved nor whether it has a solution. */
#include "check.h"

#include <nsdae/nsdae.h>

enum { MOST = 4, LWORK = 512, LIWORK = 64 };

static nsdae_lcp_info solve(int n, const double *A, const double *b, int stages, int *basis,
                            double *x)
{
  const nsdae_lcp_problem problem = {.n = n, .A = A, .lda = n, .b = b};
  nsdae_lcp_options options;
  nsdae_lcp_info info;
  double y[MOST], work[LWORK];
  int iwork[LIWORK];
  nsdae_lcp_options_default(&options);
  options.stages = stages;
  nsdae_lcp_solve_in(&problem, &options, basis, x, y, &info, work, LWORK, iwork, LIWORK);
  return info;
}

/* A planar contact of mass 1 that opens while it slips to the left: x = (0, 0, 0.3), of which
 * Lambda_R is basic at zero; A_BB of xi_L alone is zero. */
static void test_zero_in_the_basis(void **state)
{
  (void)state;
  const double A[9] = {1, -0.5, 1, 0, 1, -1, 0, 1, 0};
  double b[3] = {0.5, -0.3, 0}, x[3];
  int basis[3] = {0};
  nsdae_lcp_info info = solve(3, A, b, NSDAE_LCP_ALL, basis, x);
  assert_int_equal(info.outcome, NSDAE_OUTCOME_SOLVED);
  for (int k = 1; k <= 3; k++) {
    b[1] = -0.3 - 0.01 * k;
    info = solve(3, A, b, NSDAE_LCP_WARM, basis, x);
    assert_int_equal(info.outcome, NSDAE_OUTCOME_SOLVED);
    assert_true(x[0] == 0 && x[1] == 0);
    assert_near(x[2], -b[1], 1e-15);
  }
}

/* Every active set as a start, of a problem with one solution, one with three and one with none. */
static void test_every_start(void **state)
{
  (void)state;
  const struct {
    double A[4], b[2];
    int outcome;
  } problems[] = {{{2, 1, 1, 2}, {-5, -6}, NSDAE_OUTCOME_SOLVED},
                  {{1, 2, 2, 1}, {-1, -1}, NSDAE_OUTCOME_SOLVED},
                  {{1, -1, -1, 1}, {-1, -1}, NSDAE_OUTCOME_INFEASIBLE},
                  {{0, 1, 1, 0}, {-1, 1}, NSDAE_OUTCOME_INFEASIBLE}};
  for (int k = 0; k < 16; k++) {
    double x[2];
    int basis[2] = {k & 1, k >> 1 & 1};
    nsdae_lcp_info info = solve(2, problems[k / 4].A, problems[k / 4].b, NSDAE_LCP_ALL, basis, x);
    assert_int_equal(info.outcome, problems[k / 4].outcome);
  }
}

/* Without solution, and of rank less than full: the factors of a singular block, rounded, give
 * x = 1e15 and more with a residual of rounding size relative to A x. */
static void test_singular_blocks(void **state)
{
  (void)state;
  const struct {
    double A[16], b[4];
  } problems[] = {{{-4, 6, 0, -2, 3, -5, 0, 0, -2, 2, 1, 6, 0, 2, 0, 6}, {-1, -1, 0, -3}},
                  {{-2, 5, -2, 0, 2, -7, 0, 3, 2, 1, 5, -5, 0, 2, 2, -3}, {1, 2, -2, -1}},
                  {{-1, -4, 0, -2, 3, 6, -2, -4, 0, 4, 2, 4, -1, -3, 0, 1}, {-1, 2, 1, 0}},
                  {{-3, 2, -7, 2, 2, -1, 5, -3, 4, -3, 3, -5, -2, 1, -5, 3}, {1, -2, -1, 2}}};
  for (int k = 0; k < 64; k++) {
    double x[4];
    int basis[4] = {k & 1, k >> 1 & 1, k >> 2 & 1, k >> 3 & 1};
    nsdae_lcp_info info = solve(4, problems[k / 16].A, problems[k / 16].b, NSDAE_LCP_ALL, basis, x);
    if (info.outcome != NSDAE_OUTCOME_INFEASIBLE)
      fail_msg("problem %d, start %d: %s by %s", k / 16, k % 16, nsdae_outcome_name(info.outcome),
               nsdae_lcp_stage_name(info.stage));
  }
}

int main(void)
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(test_zero_in_the_basis),
      cmocka_unit_test(test_every_start),
      cmocka_unit_test(test_singular_blocks),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
