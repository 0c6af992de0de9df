/* The LCP solver with what is missing, outside its range, not finite, or without memory. */
#include "check.h"

#include <nsdae/nsdae.h>
#include <stdlib.h>

#include "allocator.h"

enum { N = 3 };

/* A problem with the solution x = (1, 0, 2), y = (0, 3, 0), and all that the solver is given. */
typedef struct call {
  double A[N * N], b[N], x[N], y[N];
  int basis[N];
  nsdae_lcp_problem problem;
  nsdae_lcp_options options;
  nsdae_lcp_info info;
  double *work;
  int lwork, *iwork, liwork;
} call;

static call *start(void)
{
  static const double A[N * N] = {4, 1, 0, 1, 5, 1, 0, 1, 3}, b[N] = {-4, 0, -6};
  call *c = test_calloc(1, sizeof *c);
  memcpy(c->A, A, sizeof A);
  memcpy(c->b, b, sizeof b);
  for (int i = 0; i < N; i++) c->x[i] = c->y[i] = -7;
  c->problem = (nsdae_lcp_problem){.n = N, .A = c->A, .lda = N, .b = c->b};
  nsdae_lcp_options_default(&c->options);
  assert_int_equal(nsdae_lcp_workspace(N, &c->lwork, &c->liwork), NSDAE_OK);
  c->work = test_calloc((size_t)c->lwork, sizeof *c->work);
  c->iwork = test_calloc((size_t)c->liwork, sizeof *c->iwork);
  return c;
}

static void end(call *c)
{
  test_free(c->work);
  test_free(c->iwork);
  test_free(c);
}

static int solve_in(call *c)
{
  return nsdae_lcp_solve_in(&c->problem, &c->options, c->basis, c->x, c->y, &c->info, c->work,
                            c->lwork, c->iwork, c->liwork);
}

static int solve(call *c)
{
  return nsdae_lcp_solve(&c->problem, &c->options, c->x, c->y, &c->info);
}

static void is_solved(const call *c, int status)
{
  const double x[N] = {1, 0, 2}, y[N] = {0, 3, 0};
  assert_int_equal(status, NSDAE_OK);
  assert_int_equal(c->info.outcome, NSDAE_OUTCOME_SOLVED);
  assert_at_most(c->info.residual, 1e-14);
  for (int i = 0; i < N; i++) {
    assert_near(c->x[i], x[i], 1e-14);
    assert_near(c->y[i], y[i], 1e-14);
  }
}

/* Refused, with x and y as they were and nothing claimed. */
static void is_refused(const call *c, int status, int expected)
{
  assert_int_equal(status, expected);
  assert_int_equal(c->info.outcome, NSDAE_OUTCOME_UNSOLVED);
  assert_true(c->info.residual == INFINITY);
  for (int i = 0; i < N; i++) assert_true(c->x[i] == -7 && c->y[i] == -7);
}

static void test_as_it_should_be(void **state)
{
  (void)state;
  call *c = start();
  is_solved(c, solve_in(c));
  assert_true(c->basis[0] == 1 && c->basis[1] == 0 && c->basis[2] == 1);
  c->problem.lda = N;
  is_solved(c, solve(c));
  assert_int_equal(nsdae_lcp_solve(&c->problem, NULL, c->x, c->y, NULL), NSDAE_OK);
  assert_int_equal(nsdae_lcp_solve_in(&c->problem, NULL, c->basis, c->x, c->y, NULL, c->work,
                                      c->lwork, c->iwork, c->liwork),
                   NSDAE_OK);
  end(c);
}

/* The guess names the active set: any positive value, NaN none. */
static void test_guess(void **state)
{
  (void)state;
  call *c = start();
  c->x[0] = 1e-300;
  c->x[1] = NAN;
  c->x[2] = INFINITY;
  c->options.stages = NSDAE_LCP_WARM;
  is_solved(c, solve(c));
  assert_int_equal(c->info.stage, NSDAE_LCP_WARM);
  c->x[0] = 0;
  assert_int_equal(solve(c), NSDAE_E_LCP);
  assert_int_equal(c->info.outcome, NSDAE_OUTCOME_UNSOLVED);
  end(c);
}

/* Breaks the argument of that number; returns 0 past the last. */
static int break_common(call *c, int number)
{
  switch (number) {
  case 0:
    c->problem.n = -1;
    return 1;
  case 1:
    c->problem.n = 20001;
    return 1;
  case 2:
    c->problem.A = NULL;
    return 1;
  case 3:
    c->problem.lda = N - 1;
    return 1;
  case 4:
    c->problem.lda = 0;
    return 1;
  case 5:
    c->problem.b = NULL;
    return 1;
  case 6:
    c->options.tol = 0;
    return 1;
  case 7:
    c->options.tol = NAN;
    return 1;
  case 8:
    c->options.tol = nextafter(1, 2);
    return 1;
  case 9:
    c->options.max_pivots = -1;
    return 1;
  case 10:
    c->options.stages = -1;
    return 1;
  case 11:
    c->options.stages = NSDAE_LCP_ALL + 1;
    return 1;
  case 12:
    c->options.enumerate_max = -1;
    return 1;
  case 13:
    c->options.enumerate_max = 25;
    return 1;
  case 14:
    memset(&c->options, 0, sizeof c->options);
    return 1;
  case 15:
    memset(&c->options, 0xff, sizeof c->options);
    return 1;
  case 16:
    memset(&c->options, 0x5a, sizeof c->options);
    return 1;
  default:
    return 0;
  }
}

static int break_workspace(call *c, int number)
{
  switch (number) {
  case 0:
    c->lwork--;
    return 1;
  case 1:
    c->liwork--;
    return 1;
  case 2:
    c->lwork = -1;
    return 1;
  case 3:
    c->liwork = 0;
    return 1;
  default:
    return 0;
  }
}

static void test_arguments(void **state)
{
  (void)state;
  for (int number = 0, more = 1; more; number++) {
    call *c = start();
    more = break_common(c, number);
    if (more) {
      is_refused(c, solve_in(c), NSDAE_E_ARGUMENT);
      is_refused(c, solve(c), NSDAE_E_ARGUMENT);
    }
    end(c);
  }
  for (int number = 0, more = 1; more; number++) {
    call *c = start();
    more = break_workspace(c, number);
    if (more) is_refused(c, solve_in(c), NSDAE_E_ARGUMENT);
    end(c);
  }
}

static void test_null(void **state)
{
  (void)state;
  call *c = start();
  const nsdae_lcp_problem *p = &c->problem;
  const nsdae_lcp_options *o = &c->options;
  nsdae_lcp_info *info = &c->info;
  double *w = c->work, *x = c->x, *y = c->y;
  int *iw = c->iwork, *basis = c->basis, n = c->lwork, k = c->liwork, size;
  const int refused = NSDAE_E_ARGUMENT;
  is_refused(c, nsdae_lcp_solve(NULL, o, x, y, info), refused);
  is_refused(c, nsdae_lcp_solve(p, o, NULL, y, info), refused);
  is_refused(c, nsdae_lcp_solve(p, o, x, NULL, info), refused);
  is_refused(c, nsdae_lcp_solve_in(NULL, o, basis, x, y, info, w, n, iw, k), refused);
  is_refused(c, nsdae_lcp_solve_in(p, o, NULL, x, y, info, w, n, iw, k), refused);
  is_refused(c, nsdae_lcp_solve_in(p, o, basis, NULL, y, info, w, n, iw, k), refused);
  is_refused(c, nsdae_lcp_solve_in(p, o, basis, x, NULL, info, w, n, iw, k), refused);
  is_refused(c, nsdae_lcp_solve_in(p, o, basis, x, y, info, NULL, n, iw, k), refused);
  is_refused(c, nsdae_lcp_solve_in(p, o, basis, x, y, info, w, n, NULL, k), refused);
  assert_int_equal(nsdae_lcp_solve(NULL, NULL, NULL, NULL, NULL), refused);
  assert_int_equal(nsdae_lcp_solve_in(NULL, NULL, NULL, NULL, NULL, NULL, NULL, 0, NULL, 0),
                   refused);
  assert_int_equal(nsdae_lcp_workspace(-1, &size, &size), refused);
  assert_int_equal(nsdae_lcp_workspace(20001, &size, &size), refused);
  assert_int_equal(nsdae_lcp_workspace(1, NULL, &size), refused);
  assert_int_equal(nsdae_lcp_workspace(1, &size, NULL), refused);
  assert_int_equal(nsdae_lcp_workspace(20000, &n, &k), NSDAE_OK);
  assert_true(n > 0 && k > 0);
  nsdae_lcp_options_default(NULL);
  end(c);
}

static void test_not_finite(void **state)
{
  (void)state;
  const double bad[] = {NAN, INFINITY, -INFINITY};
  for (int k = 0; k < 3; k++)
    for (int i = 0; i < N * N + N; i++) {
      call *c = start();
      *(i < N * N ? c->A + i : c->b + (i - N * N)) = bad[k];
      is_refused(c, solve_in(c), NSDAE_E_NONFINITE);
      is_refused(c, solve(c), NSDAE_E_NONFINITE);
      end(c);
    }
}

/* What lies between the columns is nobody's. */
static void test_leading_dimension(void **state)
{
  (void)state;
  enum { LDA = N + 2 };
  call *c = start();
  double A[LDA * N];
  for (int i = 0; i < LDA * N; i++) A[i] = NAN;
  for (int j = 0; j < N; j++) memcpy(A + LDA * j, c->A + N * j, N * sizeof *A);
  c->problem.A = A;
  c->problem.lda = LDA;
  is_solved(c, solve(c));
  is_solved(c, solve_in(c));
  end(c);
}

static void test_empty(void **state)
{
  (void)state;
  nsdae_lcp_info info;
  const nsdae_lcp_problem none = {.n = 0, .lda = 1};
  double work[8];
  int iwork[8], lwork, liwork;
  assert_int_equal(nsdae_lcp_solve(&none, NULL, NULL, NULL, &info), NSDAE_OK);
  assert_int_equal(info.outcome, NSDAE_OUTCOME_SOLVED);
  assert_true(info.residual == 0);
  assert_int_equal(nsdae_lcp_workspace(0, &lwork, &liwork), NSDAE_OK);
  assert_true(lwork >= 1 && lwork <= 8 && liwork >= 1 && liwork <= 8);
  assert_int_equal(
      nsdae_lcp_solve_in(&none, NULL, NULL, NULL, NULL, &info, work, lwork, iwork, liwork),
      NSDAE_OK);
  assert_int_equal(info.outcome, NSDAE_OUTCOME_SOLVED);
}

/* One allocation; lost, it is reported; nothing stays behind. None in the caller's workspace. */
static void test_memory(void **state)
{
  (void)state;
  call *c = start();
  allocator_reset(0);
  is_refused(c, solve(c), NSDAE_E_MEMORY);
  assert_int_equal(the_allocator.live, 0);
  allocator_reset(-1);
  is_solved(c, solve(c));
  assert_int_equal(the_allocator.calls, 1);
  assert_int_equal(the_allocator.live, 0);
  allocator_reset(-1);
  is_solved(c, solve_in(c));
  assert_int_equal(the_allocator.calls, 0);
  end(c);
}

/* Numbers at the ends of the range: solved, or said not to be, and never a NaN for a solution. */
static void test_extreme(void **state)
{
  (void)state;
  for (int e = -1070; e <= 1020; e += 10)
    for (int of_b = 0; of_b < 2; of_b++) {
      call *c = start();
      for (int i = 0; i < (of_b ? N : N * N); i++) {
        double *entry = of_b ? c->b + i : c->A + i;
        *entry = ldexp(*entry, e);
      }
      int status = solve(c);
      assert_true(status == NSDAE_OK || status == NSDAE_E_LCP);
      for (int i = 0; i < N && status == NSDAE_OK; i++)
        assert_true(c->x[i] >= 0 && isfinite(c->x[i]) && isfinite(c->y[i]));
      if (e > -900 && e < 900) assert_int_equal(status, NSDAE_OK);
      end(c);
    }
}

static void test_names(void **state)
{
  (void)state;
  const struct {
    int stage;
    const char *name;
  } stages[] = {{NSDAE_LCP_NONE, "none"},
                {NSDAE_LCP_TRIVIAL, "trivial"},
                {NSDAE_LCP_WARM, "warm"},
                {NSDAE_LCP_LEMKE, "lemke"},
                {NSDAE_LCP_NEWTON, "newton"},
                {NSDAE_LCP_COVERING, "covering"},
                {NSDAE_LCP_FURTHER, "further"},
                {NSDAE_LCP_PROVE, "prove"},
                {NSDAE_LCP_ENUMERATE, "enumerate"},
                {NSDAE_LCP_ALL, "unknown"},
                {-1, "unknown"},
                {3, "unknown"}};
  for (size_t i = 0; i < sizeof stages / sizeof *stages; i++)
    assert_string_equal(nsdae_lcp_stage_name(stages[i].stage), stages[i].name);
  assert_string_equal(nsdae_outcome_name(NSDAE_OUTCOME_UNSOLVED), "unsolved");
  assert_string_equal(nsdae_outcome_name(NSDAE_OUTCOME_SOLVED), "solved");
  assert_string_equal(nsdae_outcome_name(NSDAE_OUTCOME_INFEASIBLE), "infeasible");
  assert_string_equal(nsdae_outcome_name(3), "unknown");
  assert_string_equal(nsdae_outcome_name(-1), "unknown");
  assert_string_equal(nsdae_proof_name(NSDAE_PROOF_NONE), "none");
  assert_string_equal(nsdae_proof_name(NSDAE_PROOF_FARKAS), "farkas");
  assert_string_equal(nsdae_proof_name(NSDAE_PROOF_ENUMERATED), "enumerated");
  assert_string_equal(nsdae_proof_name(3), "unknown");
  assert_string_equal(nsdae_lcp_ray_name(NSDAE_LCP_RAY_NOTHING), "nothing");
  assert_string_equal(nsdae_lcp_ray_name(NSDAE_LCP_RAY_NOT_COPOSITIVE), "not copositive");
  assert_string_equal(nsdae_lcp_ray_name(NSDAE_LCP_RAY_NOT_STRICTLY_COPOSITIVE),
                      "not strictly copositive");
  assert_string_equal(nsdae_lcp_ray_name(-1), "unknown");
}

int main(void)
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(test_as_it_should_be), cmocka_unit_test(test_guess),
      cmocka_unit_test(test_arguments),       cmocka_unit_test(test_null),
      cmocka_unit_test(test_not_finite),      cmocka_unit_test(test_leading_dimension),
      cmocka_unit_test(test_empty),           cmocka_unit_test(test_memory),
      cmocka_unit_test(test_extreme),         cmocka_unit_test(test_names),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
