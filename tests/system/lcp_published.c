/* Published problems of tests/data/lcp: every one that has a solution is solved, the one that has
 * none is reported so. The residual is computed here, from the file's numbers. */
#include "check.h"

#include <nsdae/nsdae.h>
#include <stdlib.h>
#include <time.h>

#include "lcp_arguments.h"

typedef struct answer {
  lcp_file file;
  nsdae_lcp_info info;
  int status;
  double *x, *y;
  double residual; /* max_i |min(x_i, y_i)|, y = A x + b in long double */
  double scale;    /* max(1, |A|, |b|), largest entries */
  double seconds;
} answer;

static double seconds(void)
{
  struct timespec now;
  clock_gettime(CLOCK_MONOTONIC, &now);
  return (double)now.tv_sec + 1e-9 * (double)now.tv_nsec;
}

static void measure(answer *a)
{
  size_t n = (size_t)a->file.n;
  a->scale = 1;
  a->residual = 0;
  for (size_t i = 0; i < n; i++) {
    long double y = a->file.b[i];
    a->scale = fmax(a->scale, fabs(a->file.b[i]));
    for (size_t j = 0; j < n; j++) {
      a->scale = fmax(a->scale, fabs(a->file.A[j * n + i]));
      y += (long double)a->file.A[j * n + i] * a->x[j];
    }
    double worst = fabs(a->x[i] < (double)y ? a->x[i] : (double)y);
    if (!(worst <= a->residual)) a->residual = worst;
  }
}

static answer solve(const char *name)
{
  answer a = {0};
  nsdae_error error;
  char path[1024];
  snprintf(path, sizeof path, NSDAE_TEST_DATA "/lcp/%s.dat", name);
  if (lcp_file_read(path, &a.file, &error) != NSDAE_OK) fail_msg("%s", error.text);
  a.x = calloc((size_t)a.file.n, sizeof *a.x);
  a.y = calloc((size_t)a.file.n, sizeof *a.y);
  const nsdae_lcp_problem problem = {.n = a.file.n, .A = a.file.A, .lda = a.file.n, .b = a.file.b};
  double start = seconds();
  a.status = nsdae_lcp_solve(&problem, NULL, a.x, a.y, &a.info);
  a.seconds = seconds() - start;
  measure(&a);
  print_message(
      "%-38s n %4d  %-10s by %-9s %5d pivots  scaled %.1e  natural %.1e of %.1e  %.4f s\n", name,
      a.file.n, nsdae_outcome_name(a.info.outcome), nsdae_lcp_stage_name(a.info.stage),
      a.info.pivots, a.info.residual, a.residual, a.scale, a.seconds);
  return a;
}

static void release(answer *a)
{
  lcp_file_release(&a->file);
  free(a->x);
  free(a->y);
}

static void is_solved(const char *name, double tol)
{
  answer a = solve(name);
  assert_int_equal(a.status, NSDAE_OK);
  assert_int_equal(a.info.outcome, NSDAE_OUTCOME_SOLVED);
  assert_at_most(a.info.residual, tol);
  assert_at_most(a.residual, tol * a.scale);
  release(&a);
}

static void test_solvable(void **state)
{
  (void)state;
  static const char *const name[] = {
      "lcp_CPS_1",      "lcp_CPS_2",     "lcp_CPS_3",        "lcp_CPS_4",
      "lcp_CPS_4bis",   "lcp_CPS_5",     "lcp_deudeu",       "lcp_deudeu_block",
      "lcp_enum_fails", "lcp_exp_murty", "lcp_exp_murty2",   "lcp_inf_sol_perturbed",
      "lcp_mmc",        "lcp_ortiz",     "lcp_ortiz_block",  "lcp_Pang_isolated_sol",
      "lcp_tobenna",    "lcp_trivial",   "lcp_trivial_block"};
  for (size_t i = 0; i < sizeof name / sizeof *name; i++) is_solved(name[i], 1e-10);
}

/* y_0 = -x_1 - x_2 - 1e-4 < 0 whatever x >= 0 is. */
static void test_without_solution(void **state)
{
  (void)state;
  answer a = solve("lcp_Pang_isolated_sol_perturbed");
  assert_int_equal(a.status, NSDAE_E_INFEASIBLE);
  assert_int_equal(a.info.outcome, NSDAE_OUTCOME_INFEASIBLE);
  release(&a);
}

/* Two contacts of one slider, Delassus matrices of condition 1e17 and 1e18. */
static void test_slider_crank(void **state)
{
  (void)state;
  is_solved("FC2D_SliderCrankLagrangian00000", 1e-12);
  is_solved("FC2D_SliderCrankLagrangian00001", 1e-12);
}

static void test_granular_flow(void **state)
{
  (void)state;
  is_solved("fc2d_granularflowonwall_00667_00000", 1e-10);
}

int main(void)
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(test_solvable),
      cmocka_unit_test(test_without_solution),
      cmocka_unit_test(test_slider_crank),
      cmocka_unit_test(test_granular_flow),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
