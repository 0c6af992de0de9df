/* Frictional contact problems with what is missing, outside its range, not finite, extreme, or
 * without memory: a status, nothing lost, and never a solution that is none. */
#include "check.h"

#include <limits.h>

#include <nsdae/nsdae.h>

#include "allocator.h"

enum { MOST = 16 };

/* Two unit masses in space, one on the ground z = 0 and one on the other, falling at 1 and sliding.
 */
typedef struct stack {
  double M[18], f[6], H[27], w[9], mu[2], compliance[6];
  int size[2], first[4], block[3], rows[2];
  nsdae_friction_problem p;
} stack;

static void make_stack(stack *s)
{
  static const double up[9] = {0, 0, 1, 1, 0, 0, 0, 1, 0};
  memset(s, 0, sizeof *s);
  for (int i = 0; i < 3; i++) s->M[4 * i] = s->M[9 + 4 * i] = 1;
  s->f[0] = 3, s->f[2] = s->f[5] = -1;
  for (int i = 0; i < 9; i++) s->H[i] = s->H[9 + i] = up[i], s->H[18 + i] = -up[i];
  memcpy(s->mu, (double[]){0.5, 0.5}, sizeof s->mu);
  memcpy(s->size, (int[]){3, 3}, sizeof s->size);
  memcpy(s->first, (int[]){0, 1, 3, 3}, sizeof s->first);
  memcpy(s->block, (int[]){0, 1, 0}, sizeof s->block);
  memcpy(s->rows, (int[]){3, 3}, sizeof s->rows);
  s->p = (nsdae_friction_problem){.contacts = 2,
                                  .rows = s->rows,
                                  .mu = s->mu,
                                  .w = s->w,
                                  .blocks = 2,
                                  .size = s->size,
                                  .M = s->M,
                                  .f = s->f,
                                  .first = s->first,
                                  .block = s->block,
                                  .value = s->H};
}

static int solve(const nsdae_friction_problem *p, double *r, nsdae_friction_info *info)
{
  double u[MOST];
  return nsdae_friction_solve(p, NULL, r, u, info);
}

static const char *words; /* that the text of the next refusal contains, or NULL */

/* Refused by both, with the argument named, and r as it was. */
static void check_refused(const nsdae_friction_problem *p, int status, const char *argument)
{
  double r[MOST], u[MOST];
  nsdae_error error;
  nsdae_friction_info info;
  for (int i = 0; i < MOST; i++) r[i] = u[i] = 7;
  assert_int_equal(nsdae_friction_check(p, &error), status);
  assert_int_equal(error.status, status);
  assert_string_equal(error.argument, argument);
  assert_true(strlen(error.text) > 0);
  if (words && !strstr(error.text, words)) fail_msg("%s", error.text);
  words = NULL;
  assert_int_equal(nsdae_friction_solve(p, NULL, r, u, &info), status);
  assert_int_equal(info.outcome, NSDAE_OUTCOME_UNSOLVED);
  for (int i = 0; i < MOST; i++) assert_true(r[i] == 7 && u[i] == 7);
}

#define REFUSED(change, status, argument)    \
  do {                                       \
    stack s;                                 \
    make_stack(&s);                          \
    change;                                  \
    check_refused(&s.p, (status), argument); \
  } while (0)

/* Each entry is named by its own number. */
static void test_index(void **state)
{
  const double bad[] = {-0.1, NAN};
  (void)state;
  for (int i = 0; i < 2; i++)
    for (int k = 0; k < 2; k++) {
      stack s;
      nsdae_error error;
      char called[16];
      make_stack(&s);
      s.mu[i] = bad[k];
      assert_true(nsdae_friction_check(&s.p, &error) < 0);
      snprintf(called, sizeof called, "mu[%d] = ", i);
      assert_non_null(strstr(error.text, called));
      assert_int_equal(error.index, i);
    }
}

static void test_arguments(void **state)
{
  (void)state;
  check_refused(NULL, NSDAE_E_ARGUMENT, "problem");
  REFUSED(s.p.form = 2, NSDAE_E_ARGUMENT, "form");
  REFUSED(s.p.contacts = -1, NSDAE_E_ARGUMENT, "contacts");
  REFUSED(s.p.contacts = INT_MAX, NSDAE_E_ARGUMENT, "contacts");
  REFUSED(s.p.bilateral = -1, NSDAE_E_ARGUMENT, "bilateral");
  REFUSED(s.p.bilateral = INT_MAX, NSDAE_E_ARGUMENT, "bilateral");
  REFUSED(s.p.blocks = -1, NSDAE_E_ARGUMENT, "blocks");
  REFUSED(s.rows[1] = 5, NSDAE_E_ARGUMENT, "rows"); /* rolling friction */
  REFUSED(s.rows[1] = 0, NSDAE_E_ARGUMENT, "rows");
  REFUSED(s.mu[1] = -0.1, NSDAE_E_ARGUMENT, "mu");
  REFUSED(s.size[0] = 0, NSDAE_E_ARGUMENT, "size");
  REFUSED(s.size[0] = INT_MAX, NSDAE_E_ARGUMENT, "size");
  REFUSED(s.first[0] = 1, NSDAE_E_ARGUMENT, "first");
  REFUSED(s.first[1] = 5, NSDAE_E_ARGUMENT, "first");
  REFUSED(s.first[1] = -1, NSDAE_E_ARGUMENT, "first");
  REFUSED(s.block[0] = 2, NSDAE_E_ARGUMENT, "block");
  REFUSED(s.block[0] = -1, NSDAE_E_ARGUMENT, "block");
  REFUSED(s.block[2] = 1, NSDAE_E_ARGUMENT, "block");
  REFUSED((s.compliance[0] = -1, s.p.compliance = s.compliance), NSDAE_E_ARGUMENT, "compliance");
  REFUSED(s.p.form = NSDAE_FRICTION_LOCAL, NSDAE_E_ARGUMENT, "blocks");
  REFUSED(s.p.form = -1, NSDAE_E_ARGUMENT, "form");
  REFUSED(s.size[1] = 1000000000, NSDAE_E_ARGUMENT, "size"); /* its mass in bytes */
  REFUSED(s.p.mu = NULL, NSDAE_E_ARGUMENT, "mu");
  REFUSED(s.p.w = NULL, NSDAE_E_ARGUMENT, "w");
  REFUSED(s.p.M = NULL, NSDAE_E_ARGUMENT, "M");
  REFUSED(s.p.f = NULL, NSDAE_E_ARGUMENT, "f");
  REFUSED(s.p.size = NULL, NSDAE_E_ARGUMENT, "size");
  REFUSED(s.p.first = NULL, NSDAE_E_ARGUMENT, "first");
  REFUSED(s.p.block = NULL, NSDAE_E_ARGUMENT, "block");
  REFUSED(s.p.value = NULL, NSDAE_E_ARGUMENT, "value");
  words = "block 0 of M is not positive definite: pivot 0, of the diagonal entry 0, ";
  REFUSED(s.M[0] = 0, NSDAE_E_MASS, "M");
  words = "(0, 1) is 0, (1, 0) is 0.5";
  REFUSED(s.M[1] = 0.5, NSDAE_E_MASS, "M");
  REFUSED(s.M[4] = -1, NSDAE_E_MASS, "M");
}

static void test_not_finite(void **state)
{
  (void)state;
  const double bad[] = {NAN, INFINITY, -INFINITY};
  for (int k = 0; k < 3; k++) {
    REFUSED(s.M[4] = bad[k], NSDAE_E_NONFINITE, "M");
    REFUSED(s.f[4] = bad[k], NSDAE_E_NONFINITE, "f");
    REFUSED(s.w[4] = bad[k], NSDAE_E_NONFINITE, "w");
    REFUSED(s.H[4] = bad[k], NSDAE_E_NONFINITE, "value");
    REFUSED(s.mu[1] = bad[k], NSDAE_E_NONFINITE, "mu");
  }
  REFUSED(s.H[0] = 1e300, NSDAE_E_NONFINITE, "value"); /* its square */
}

static void test_options(void **state)
{
  (void)state;
  stack s;
  double r[6] = {0}, u[6];
  make_stack(&s);
  for (int k = 0; k < 8; k++) {
    nsdae_friction_options o;
    nsdae_friction_options_default(&o);
    if (k == 0) o.tol = 0;
    if (k == 1) o.tol = NAN;
    if (k == 2) o.tol = 2;
    if (k == 3) o.stages = -1;
    if (k == 4) o.stages = NSDAE_FRICTION_ALL + 1;
    if (k == 5) o.max_sweeps = -1;
    if (k == 6) o.max_iterations = -1;
    if (k == 7) o.refine = -1;
    assert_int_equal(nsdae_friction_solve(&s.p, &o, r, u, NULL), NSDAE_E_ARGUMENT);
  }
  const nsdae_friction_options zeros = {0};
  assert_int_equal(nsdae_friction_solve(&s.p, &zeros, r, u, NULL), NSDAE_E_ARGUMENT);
  assert_int_equal(nsdae_friction_solve(&s.p, NULL, NULL, u, NULL), NSDAE_E_ARGUMENT);
  assert_int_equal(nsdae_friction_solve(&s.p, NULL, r, NULL, NULL), NSDAE_E_ARGUMENT);
}

/* What is not there, of functions that need it; and words for every stage. */
static void test_missing(void **state)
{
  (void)state;
  stack s;
  double r[6] = {0}, u[6], residual;
  nsdae_friction_solver *solver;
  make_stack(&s);
  nsdae_friction_options_default(NULL);
  nsdae_friction_destroy(NULL);
  assert_int_equal(nsdae_friction_create(NULL), NSDAE_E_ARGUMENT);
  assert_int_equal(nsdae_friction_solver_solve(NULL, &s.p, NULL, r, u, NULL), NSDAE_E_ARGUMENT);
  assert_int_equal(nsdae_friction_residual(&s.p, r, u, NULL), NSDAE_E_ARGUMENT);
  assert_int_equal(nsdae_friction_residual(&s.p, NULL, u, &residual), NSDAE_E_ARGUMENT);
  assert_int_equal(nsdae_friction_residual(NULL, r, NULL, &residual), NSDAE_E_ARGUMENT);
  assert_int_equal(nsdae_friction_create(&solver), NSDAE_OK);
  nsdae_friction_destroy(&solver);
  assert_null(solver);
  nsdae_friction_destroy(&solver);
  assert_string_equal(nsdae_friction_stage_name(NSDAE_FRICTION_NONE), "none");
  assert_string_equal(nsdae_friction_stage_name(-1), "unknown");
  assert_string_equal(nsdae_friction_stage_name(1 << 20), "unknown");
}

/* Each stage alone, with and without bounds of its work and more digits asked for: what is called
 * solved is, by the certificate, and the bounds are kept. */
static void test_bounds(void **state)
{
  (void)state;
  for (int stage = 1; stage <= NSDAE_FRICTION_ALL; stage *= 2)
    for (int k = 0; k < 4; k++)
      for (int loose = 0; loose < 2; loose++) {
        stack s;
        double r[6] = {0}, residual, tol = loose ? 1e-3 : 1e-10;
        nsdae_friction_info info;
        nsdae_friction_options o;
        double u[6];
        make_stack(&s);
        nsdae_friction_options_default(&o);
        o.tol = tol;
        o.stages = stage;
        o.max_sweeps = k == 1 ? 3 : 0;
        o.max_iterations = k == 2 ? 2 : 0;
        o.refine = k == 3 ? 5 : 0;
        int status = nsdae_friction_solve(&s.p, &o, r, u, &info);
        assert_true(status == NSDAE_OK || status == NSDAE_E_LCP);
        assert_int_equal(nsdae_friction_residual(&s.p, r, NULL, &residual), NSDAE_OK);
        assert_int_equal(status == NSDAE_OK, residual <= tol);
      }
}

static void test_nothing(void **state)
{
  (void)state;
  const nsdae_friction_problem none = {0}, local = {.form = NSDAE_FRICTION_LOCAL};
  nsdae_friction_info info;
  assert_int_equal(nsdae_friction_solve(&none, NULL, NULL, NULL, &info), NSDAE_OK);
  assert_int_equal(info.outcome, NSDAE_OUTCOME_SOLVED);
  assert_int_equal(nsdae_friction_solve(&local, NULL, NULL, NULL, &info), NSDAE_OK);
}

/* q = 0: r = 0 whatever the guess; NaN as a guess is none. */
static void test_at_rest(void **state)
{
  (void)state;
  stack s;
  double r[6] = {NAN, INFINITY, 1, 2, 3, 4};
  nsdae_friction_info info;
  make_stack(&s);
  memset(s.f, 0, sizeof s.f);
  assert_int_equal(solve(&s.p, r, &info), NSDAE_OK);
  assert_true(info.residual == 0);
  for (int i = 0; i < 6; i++) assert_true(r[i] == 0);
}

/* mu from 0 to 1e300: solved is below tol by the certificate, or it is not said. */
static void test_coefficients(void **state)
{
  (void)state;
  const double mu[] = {0, 1e-300, 1e-12, 0.5, 1e3, 1e12, 1e150, 1e300};
  for (int a = 0; a < 8; a++)
    for (int b = 0; b < 8; b++) {
      stack s;
      double r[6] = {0}, residual;
      nsdae_friction_info info;
      make_stack(&s);
      s.mu[0] = mu[a], s.mu[1] = mu[b];
      int status = solve(&s.p, r, &info);
      assert_true(status == NSDAE_OK || status == NSDAE_E_LCP);
      assert_int_equal(nsdae_friction_residual(&s.p, r, NULL, &residual), NSDAE_OK);
      assert_int_equal(status == NSDAE_OK, residual <= 1e-10);
      if (mu[a] <= 1e3 && mu[b] <= 1e3) assert_int_equal(status, NSDAE_OK);
    }
}

/* A contact that nothing moves: it parts, or there is no solution, which is proved. */
static void test_fixed(void **state)
{
  (void)state;
  stack s;
  double r[6] = {0};
  nsdae_friction_info info;
  make_stack(&s);
  memset(s.H + 9, 0, 18 * sizeof *s.H);
  s.w[3] = 1;
  assert_int_equal(solve(&s.p, r, &info), NSDAE_OK);
  assert_true(r[3] == 0);
  s.w[3] = -1;
  assert_int_equal(solve(&s.p, r, &info), NSDAE_E_INFEASIBLE);
  assert_int_equal(info.outcome, NSDAE_OUTCOME_INFEASIBLE);
  assert_int_equal(info.proof, NSDAE_PROOF_FARKAS);
  for (int i = 0; i < 6; i++) assert_true(r[i] == (i == 3)); /* H l = 0, q . l = -1 */
}

/* Pressed together by two walls that close: no solution; it is not solved, at least. */
static void test_jammed(void **state)
{
  (void)state;
  const double M = 1, f = 0, H[2] = {1, -1}, w[2] = {-1, -1}, mu[2] = {0};
  const int size = 1, first[3] = {0, 1, 2}, block[2] = {0, 0}, rows[2] = {1, 1};
  const nsdae_friction_problem p = {.contacts = 2,
                                    .rows = rows,
                                    .mu = mu,
                                    .w = w,
                                    .blocks = 1,
                                    .size = &size,
                                    .M = &M,
                                    .f = &f,
                                    .first = first,
                                    .block = block,
                                    .value = H};
  double r[2] = {0};
  nsdae_friction_info info;
  int status = solve(&p, r, &info);
  assert_true(status == NSDAE_E_LCP || status == NSDAE_E_INFEASIBLE);
  assert_true(info.outcome != NSDAE_OUTCOME_SOLVED);
}

static void test_not_symmetric(void **state)
{
  (void)state;
  double W[4] = {1, 0.5, 0.5, 1}, r[2] = {0};
  const double q[2] = {-1, -1}, mu[2] = {0};
  const int first[3] = {0, 2, 4}, block[4] = {0, 1, 0, 1}, rows[2] = {1, 1};
  nsdae_friction_problem p = {.form = NSDAE_FRICTION_LOCAL,
                              .contacts = 2,
                              .rows = rows,
                              .mu = mu,
                              .w = q,
                              .first = first,
                              .block = block,
                              .value = W};
  nsdae_friction_info info;
  assert_int_equal(solve(&p, r, &info), NSDAE_OK);
  assert_near(r[0], 2.0 / 3, 1e-9);
  W[1] = 0.4;
  check_refused(&p, NSDAE_E_ARGUMENT, "value");
  W[1] = 0.5, W[0] = -1;
  check_refused(&p, NSDAE_E_ARGUMENT, "value");
}

/* Each allocation in turn is lost: NSDAE_E_MEMORY and r as it was, nothing leaks; and a solver that
 * has seen a problem allocates nothing for it again. */
static void test_memory(void **state)
{
  (void)state;
  stack s;
  double r[6] = {0}, u[6];
  nsdae_friction_options o;
  make_stack(&s);
  nsdae_friction_options_default(&o);
  o.stages = NSDAE_FRICTION_SMOOTHING_HOMOTOPY;
  for (long lost = 0;; lost++) {
    r[0] = 7;
    allocator_reset(lost);
    int status = nsdae_friction_solve(&s.p, &o, r, u, NULL);
    assert_int_equal(the_allocator.live, 0);
    long calls = the_allocator.calls;
    allocator_reset(-1);
    if (status == NSDAE_OK && lost >= calls) break;
    if (status == NSDAE_OK) continue; /* what AMD lost it did without */
    assert_int_equal(status, NSDAE_E_MEMORY);
    assert_true(r[0] == 7);
  }
  nsdae_friction_solver *solver;
  assert_int_equal(nsdae_friction_create(&solver), NSDAE_OK);
  assert_int_equal(nsdae_friction_solver_solve(solver, &s.p, &o, r, u, NULL), NSDAE_OK);
  allocator_reset(-1);
  assert_int_equal(nsdae_friction_solver_solve(solver, &s.p, &o, r, u, NULL), NSDAE_OK);
  assert_int_equal(the_allocator.calls, 0);
  nsdae_friction_destroy(&solver);
  assert_null(solver);
  nsdae_friction_destroy(&solver);
}

/* The same of a proof: two rows that close in on each other. */
static void test_memory_of_proofs(void **state)
{
  (void)state;
  const int rows[] = {1, 1}, first[] = {0, 2, 4}, block[] = {0, 1, 0, 1};
  const double W[] = {1, -1, -1, 1}, mu[2] = {0}, q[] = {-1, -1};
  const nsdae_friction_problem p = {.form = NSDAE_FRICTION_LOCAL,
                                    .contacts = 2,
                                    .rows = rows,
                                    .mu = mu,
                                    .w = q,
                                    .first = first,
                                    .block = block,
                                    .value = W};
  double r[2] = {0}, u[2];
  for (long lost = 0;; lost++) {
    r[0] = 7;
    allocator_reset(lost);
    int status = nsdae_friction_solve(&p, NULL, r, u, NULL);
    assert_int_equal(the_allocator.live, 0);
    long calls = the_allocator.calls;
    allocator_reset(-1);
    if (status == NSDAE_E_INFEASIBLE && lost >= calls) break;
    if (status == NSDAE_E_INFEASIBLE) continue; /* what another stage had wanted */
    assert_int_equal(status, NSDAE_E_MEMORY);
    assert_true(r[0] == 7);
  }
  assert_true(r[0] > 0 && r[0] == r[1]);
}

enum { ROW = 120 };

/* A row of masses that are pressed together and on the ground, and one more on the ground alone,
 * with or without the parts of zeros, which lead to the other island. */
static int press(int zeros, double *r, nsdae_friction_info *info)
{
  enum { N = ROW };
  double M[N], f[N], mu[N] = {0}, w[N] = {0}, value[N * N], u[N];
  int size[N], rows[N], first[N + 1] = {0}, block[N * N], at = 0;
  for (int i = 0; i < N; i++) {
    M[i] = i + 1;
    f[i] = -(i + 1) * (i + 2);
    size[i] = rows[i] = 1;
    for (int j = 0; j < N; j++) { /* v_i - v_(i-1), of the first and the last v_i */
      double part = j == i ? 1 : j == i - 1 && i < N - 1 ? -1 : 0;
      if (part == 0 && !zeros) continue;
      block[at] = j;
      value[at++] = part;
    }
    first[i + 1] = at;
  }
  nsdae_friction_problem p = {.contacts = N,
                              .rows = rows,
                              .mu = mu,
                              .w = w,
                              .blocks = N,
                              .size = size,
                              .M = M,
                              .f = f,
                              .first = first,
                              .block = block,
                              .value = value};
  nsdae_friction_options options;
  nsdae_friction_options_default(&options);
  options.tol = 1e-12;
  return nsdae_friction_solve(&p, &options, r, u, info);
}

/* Parts of zeros change nothing: at rest each contact carries what lies behind it. */
static void test_parts_of_zeros(void **state)
{
  (void)state;
  for (int zeros = 0; zeros < 2; zeros++) {
    double r[ROW] = {0}, carried = 0;
    nsdae_friction_info info;
    assert_int_equal(press(zeros, r, &info), NSDAE_OK);
    assert_int_equal(info.islands, 2);
    for (int i = ROW - 2; i >= 0; i--) {
      carried += (i + 1) * (i + 2);
      assert_near(r[i], carried, 1e-9 * carried);
    }
    assert_near(r[ROW - 1], ROW * (ROW + 1), 1e-9 * ROW * ROW);
  }
}

enum { SHORT = 7, ALL = 160 };

/* A short and a long row of unit masses, ALL in all, each pressed together and on its ground by f =
 * -1, with every pair of contact and block listed: H [j][i] is 1 for v_i and -1 for v_(i-1) of the
 * same row. Contact i carries what lies behind it. */
typedef struct two_rows {
  double M[ALL], f[ALL], mu[ALL], w[ALL], carried[ALL];
  double H[ALL * ALL], W[ALL * ALL];
  int ones[ALL], first[ALL + 1], block[ALL * ALL];
} two_rows;

static void make_two_rows(two_rows *s)
{
  *s = (two_rows){.w = {0}};
  for (int i = 0; i < ALL; i++) {
    s->M[i] = 1;
    s->f[i] = -1;
    s->ones[i] = 1;
    s->carried[i] = i < SHORT ? SHORT - i : ALL - i;
    s->first[i + 1] = (i + 1) * ALL;
    for (int j = 0; j < ALL; j++) s->block[i * ALL + j] = j;
    s->H[i * ALL + i] = 1;
    if (i != 0 && i != SHORT) s->H[i * ALL + i - 1] = -1;
  }
  for (int i = 0; i < ALL; i++)
    for (int j = 0; j < ALL; j++)
      for (int k = 0; k < ALL; k++)
        s->W[i * ALL + j] += s->H[i * ALL + k] * s->H[j * ALL + k] / s->M[k];
}

/* From a guess that is not zero: the numbers of the other island's blocks, taken for this one's,
 * would have impulses read for offsets. */
static void expect_two_rows(const two_rows *s, const nsdae_friction_problem *p)
{
  double r[ALL], u[ALL];
  nsdae_friction_info info;
  for (int i = 0; i < ALL; i++) r[i] = 1 + i;
  assert_int_equal(nsdae_friction_solve(p, NULL, r, u, &info), NSDAE_OK);
  assert_int_equal(info.islands, 2);
  /* what the residual lets differ, times the condition of a row */
  for (int i = 0; i < ALL; i++) assert_near(r[i], s->carried[i], 1e-10 * ALL * ALL);
}

static void test_every_pair_listed(void **state)
{
  static two_rows s;
  double q[ALL] = {0};
  (void)state;
  make_two_rows(&s);
  nsdae_friction_problem p = {.contacts = ALL,
                              .rows = s.ones,
                              .mu = s.mu,
                              .w = s.w,
                              .blocks = ALL,
                              .size = s.ones,
                              .M = s.M,
                              .f = s.f,
                              .first = s.first,
                              .block = s.block,
                              .value = s.H};
  expect_two_rows(&s, &p);
  for (int i = 0; i < ALL; i++)
    for (int k = 0; k < ALL; k++) q[i] += s.H[i * ALL + k] * s.f[k] / s.M[k];
  p = (nsdae_friction_problem){.form = NSDAE_FRICTION_LOCAL,
                               .contacts = ALL,
                               .rows = s.ones,
                               .mu = s.mu,
                               .w = q,
                               .first = s.first,
                               .block = s.block,
                               .value = s.W};
  expect_two_rows(&s, &p);
}

int main(void)
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(test_index),          cmocka_unit_test(test_arguments),
      cmocka_unit_test(test_not_finite),     cmocka_unit_test(test_options),
      cmocka_unit_test(test_nothing),        cmocka_unit_test(test_missing),
      cmocka_unit_test(test_bounds),         cmocka_unit_test(test_at_rest),
      cmocka_unit_test(test_coefficients),   cmocka_unit_test(test_fixed),
      cmocka_unit_test(test_jammed),         cmocka_unit_test(test_not_symmetric),
      cmocka_unit_test(test_parts_of_zeros), cmocka_unit_test(test_every_pair_listed),
      cmocka_unit_test(test_memory),         cmocka_unit_test(test_memory_of_proofs),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
