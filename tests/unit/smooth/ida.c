/* The index-1 integrator on problems with closed solutions: its order, its stiffness, every
 * callback failing in turn, every allocation lost in turn, none in a run. */
#include "ida.h"
#include "check.h"
#include "process_allocator.h"

enum { MOST = 5 };

/* A problem, the dense matrix of the last setup, and the call that fails. */
typedef struct problem {
  int n;
  void (*residual)(double t, const double *y, const double *ydot, double *r);
  void (*matrix)(const double *y, const double *ydot, double cj, double (*A)[MOST]);
  double A[MOST][MOST]; /* rows */
  long calls, fail_at;  /* of any callback, from 1; 0: none */
  int code;
  int spoil; /* solve leaves NaN */
} problem;

static int fails(problem *p)
{
  return ++p->calls == p->fail_at ? p->code : 0;
}

static int residual(double t, const double *y, const double *ydot, double cj, double *r, void *user)
{
  problem *p = user;
  assert_true(cj > 0);
  p->residual(t, y, ydot, r);
  return fails(p);
}

static int setup(double t, const double *y, const double *ydot, double cj, void *user)
{
  problem *p = user;
  (void)t;
  memset(p->A, 0, sizeof p->A);
  p->matrix(y, ydot, cj, p->A);
  return fails(p);
}

/* Gauss's elimination with row pivoting. */
static int solve(double cj, double *r, double *x, void *user)
{
  problem *p = user;
  assert_true(cj > 0);
  double A[MOST][MOST];
  int n = p->n;
  memcpy(A, p->A, sizeof A);
  for (int k = 0; k < n; k++) {
    int at = k;
    for (int i = k; i < n; i++)
      if (fabs(A[i][k]) > fabs(A[at][k])) at = i;
    for (int j = 0; j < n; j++) {
      double kept = A[k][j];
      A[k][j] = A[at][j], A[at][j] = kept;
    }
    double kept = r[k];
    r[k] = r[at], r[at] = kept;
    if (A[k][k] == 0) return 1;
    for (int i = k + 1; i < n; i++) {
      double part = A[i][k] / A[k][k];
      for (int j = k; j < n; j++) A[i][j] -= part * A[k][j];
      r[i] -= part * r[k];
    }
  }
  for (int i = n - 1; i >= 0; i--) {
    for (int j = i + 1; j < n; j++) r[i] -= A[i][j] * x[j];
    x[i] = r[i] / A[i][i];
  }
  if (p->spoil) x[0] = NAN;
  return fails(p);
}

/* ---- pendulum of length L in Cartesian coordinates, y = [x, z, x', z', lambda]:
 * Phi = (x^2 + z^2 - L^2) / 2 = 0 by J v' + v^2 + 2 ALPHA Phi' + BETA^2 Phi = 0 */

static const double G = 9.81, L = 1, ALPHA = 5, BETA = 5;

static void pendulum_residual(double t, const double *y, const double *ydot, double *r)
{
  double phi = (y[0] * y[0] + y[1] * y[1] - L * L) / 2, rate = y[0] * y[2] + y[1] * y[3];
  (void)t;
  r[0] = ydot[0] - y[2];
  r[1] = ydot[1] - y[3];
  r[2] = ydot[2] + y[0] * y[4];
  r[3] = ydot[3] + y[1] * y[4] + G;
  r[4] = y[0] * ydot[2] + y[1] * ydot[3] + y[2] * y[2] + y[3] * y[3] + 2 * ALPHA * rate +
         BETA * BETA * phi;
}

static void pendulum_matrix(const double *y, const double *ydot, double cj, double (*A)[MOST])
{
  for (int i = 0; i < 2; i++) {
    A[i][i] = cj;
    A[i][2 + i] = -1;
    A[2 + i][i] = y[4];
    A[2 + i][2 + i] = cj;
    A[2 + i][4] = y[i];
    A[4][i] = ydot[2 + i] + 2 * ALPHA * y[2 + i] + BETA * BETA * y[i];
    A[4][2 + i] = cj * y[i] + 2 * y[2 + i] + 2 * ALPHA * y[i];
  }
}

/* at rest, horizontal */
static const double pendulum_y[5] = {1, 0, 0, 0, 0}, pendulum_ydot[5] = {0, 0, 0, -9.81, 0};

static const problem pendulum = {.n = 5, .residual = pendulum_residual, .matrix = pendulum_matrix};

/* From horizontal to vertical: sqrt(L / G) K(sin 45), K by the arithmetic-geometric mean. */
static double quarter_period(void)
{
  double a = 1, b = sqrt(0.5);
  for (int i = 0; i < 8; i++) {
    double mean = (a + b) / 2;
    b = sqrt(a * b), a = mean;
  }
  return sqrt(L / G) * acos(-1) / (2 * a);
}

/* ---- C. W. Gear's stiff example: y = (2 e^-t - e^-1000t, e^-1000t - e^-t), and as an algebraic
 * entry y_1 + y_2 - y_3 = 0 */

static void gear_residual(double t, const double *y, const double *ydot, double *r)
{
  (void)t;
  r[0] = ydot[0] - 998 * y[0] - 1998 * y[1];
  r[1] = ydot[1] + 999 * y[0] + 1999 * y[1];
  r[2] = y[0] + y[1] - y[2];
}

static void gear_matrix(const double *y, const double *ydot, double cj, double (*A)[MOST])
{
  const double at[3][3] = {{cj - 998, -1998, 0}, {999, cj + 1999, 0}, {1, 1, -1}};
  (void)y, (void)ydot;
  for (int i = 0; i < 3; i++) memcpy(A[i], at[i], sizeof at[i]);
}

static const double gear_y[3] = {1, 0, 1}, gear_ydot[3] = {998, -999, 0};

static const problem gear = {.n = 3, .residual = gear_residual, .matrix = gear_matrix};

/* ---- */

/* NULL where the library was built without SUNDIALS */
static nsdae_ida *make(problem *p, int differential, int positions)
{
  const nsdae_ida_problem from = {.n = p->n,
                                  .differential = differential,
                                  .positions = positions,
                                  .residual = residual,
                                  .setup = setup,
                                  .solve = solve,
                                  .user = p};
  nsdae_ida *ida;
  int status = nsdae_ida_create(&from, &ida);
  if (status == NSDAE_E_UNSUPPORTED) untested("no SUNDIALS");
  assert_int_equal(status, NSDAE_OK);
  return ida;
}

/* From 0 to t; y there. */
static int go(nsdae_ida *ida, double rtol, double step_max, const double *y_0, const double *ydot_0,
              double t_end, double *y, int *steps)
{
  const nsdae_ida_tolerances tolerances = {rtol, rtol * 1e-3, 1, 1, step_max};
  double t = 0;
  int status = nsdae_ida_start(ida, &tolerances, 0, y_0, ydot_0, 0);
  for (*steps = 0; status == NSDAE_OK && t < t_end; ++*steps) {
    double from = t;
    status = nsdae_ida_advance(ida, &t);
    assert_true(t - from <= step_max * (1 + 1e-12));
  }
  return status < 0 ? status : nsdae_ida_read(ida, t_end, 0, y);
}

/* Below, x = 0, z = -L, x' = -sqrt(2 G L), and lambda L^2 = 3 G L. The error of a step is rtol, and
 * that of all steps a few hundred times it. It falls with rtol: from 1e-5 to 1e-9 by 1000 at least
 * (a method of order k has the error rtol^(k / (k + 1)), k = 3 to 5). */
static void test_pendulum(void **state)
{
  (void)state;
  problem p = pendulum;
  nsdae_ida *ida = make(&p, 4, 2);
  double y[5], ydot[5], error[5], t = quarter_period(), v = sqrt(2 * G * L);
  int steps;
  for (int i = 0; i < 5; i++) {
    double rtol = pow(10, -5 - i);
    assert_int_equal(go(ida, rtol, INFINITY, pendulum_y, pendulum_ydot, t, y, &steps), NSDAE_OK);
    error[i] = fmax(fabs(y[0]), fmax(fabs(y[1] + L), fabs(y[2] + v)));
    assert_at_most(error[i], 500 * rtol);
    assert_near(y[4], 3 * G / L, 1e5 * rtol);
    assert_int_equal(nsdae_ida_read(ida, t, 1, ydot), NSDAE_OK);
    assert_near(ydot[0], y[2], 1e4 * rtol);
    assert_near(ydot[3], 2 * G, 1e5 * rtol);
    print_message("rtol %.0e: %d steps, error %.1e\n", rtol, steps, error[i]);
  }
  assert_at_most(error[4], error[0] / 1000);
  nsdae_ida_destroy(&ida);
}

/* No step is longer than step_max; the solution is the same. */
static void test_step_max(void **state)
{
  (void)state;
  problem p = pendulum;
  nsdae_ida *ida = make(&p, 4, 2);
  double y[5];
  int steps;
  assert_int_equal(go(ida, 1e-6, 1e-3, pendulum_y, pendulum_ydot, quarter_period(), y, &steps),
                   NSDAE_OK);
  assert_true(steps >= quarter_period() / 1e-3);
  assert_near(y[0], 0, 500e-6);
  nsdae_ida_destroy(&ida);
}

static void check_gear(const double *y, double t)
{
  assert_near(y[0], 2 * exp(-t) - exp(-1000 * t), 1e-6);
  assert_near(y[1], exp(-1000 * t) - exp(-t), 1e-6);
  assert_near(y[2], y[0] + y[1], 1e-6);
}

/* 10 s are 10000 times the fast time constant, which no longer decides about the step. */
static void test_stiff(void **state)
{
  (void)state;
  problem p = gear;
  nsdae_ida *ida = make(&p, 2, 0);
  double y[3];
  int steps;
  for (double t = 0.001; t < 20; t *= 10) {
    assert_int_equal(go(ida, 1e-8, INFINITY, gear_y, gear_ydot, t, y, &steps), NSDAE_OK);
    check_gear(y, t);
  }
  assert_true(steps < 1000);
  nsdae_ida_destroy(&ida);
}

/* Each call in turn fails: for good, and the integrator starts anew afterwards; for once, and a
 * smaller step gets past it. The first has no step that could be smaller. */
static void test_any_fails(void **state)
{
  (void)state;
  problem p = gear;
  nsdae_ida *ida = make(&p, 2, 0);
  double y[3];
  int steps;
  for (long i = 1; i < 150; i++) {
    p.calls = 0, p.fail_at = i, p.code = -1;
    assert_int_equal(go(ida, 1e-8, INFINITY, gear_y, gear_ydot, 0.1, y, &steps), NSDAE_E_CALLBACK);
    assert_true(strncmp(nsdae_ida_failure(ida), "IDA_", 4) == 0);
    p.calls = 0, p.fail_at = i + 1, p.code = 1;
    assert_int_equal(go(ida, 1e-8, INFINITY, gear_y, gear_ydot, 0.1, y, &steps), NSDAE_OK);
    check_gear(y, 0.1);
  }
  nsdae_ida_destroy(&ida);
}

static void singular_matrix(const double *y, const double *ydot, double cj, double (*A)[MOST])
{
  gear_matrix(y, ydot, cj, A);
  memcpy(A[2], A[1], sizeof A[2]);
}

/* A matrix that is singular at every step: it is the callback that refuses it. One whose solutions
 * are not numbers: no convergence. */
static void test_matrix(void **state)
{
  (void)state;
  problem p = gear;
  nsdae_ida *ida = make(&p, 2, 0);
  double y[3];
  int steps;
  p.matrix = singular_matrix;
  assert_int_equal(go(ida, 1e-8, INFINITY, gear_y, gear_ydot, 0.1, y, &steps), NSDAE_E_CALLBACK);
  assert_string_equal(nsdae_ida_failure(ida), "IDA_CONV_FAIL");
  p.matrix = gear_matrix;
  p.spoil = 1;
  assert_int_equal(go(ida, 1e-8, INFINITY, gear_y, gear_ydot, 0.1, y, &steps), NSDAE_E_CONVERGENCE);
  assert_string_equal(nsdae_ida_failure(ida), "IDA_CONV_FAIL");
  p.spoil = 0;
  assert_int_equal(go(ida, 1e-8, INFINITY, gear_y, gear_ydot, 0.1, y, &steps), NSDAE_OK);
  check_gear(y, 0.1);
  assert_int_equal(nsdae_ida_read(ida, -1, 0, y), NSDAE_E_CONVERGENCE);
  nsdae_ida_destroy(&ida);
}

#if NSDAE_PROCESS_ALLOCATOR
/* Each allocation of the creation lost in turn: NSDAE_E_MEMORY, and nothing is left behind. A run,
 * with starts in it, allocates nothing. */
static void test_memory(void **state)
{
  (void)state;
  problem p = pendulum;
  const nsdae_ida_problem from = {.n = 5,
                                  .differential = 4,
                                  .positions = 2,
                                  .residual = residual,
                                  .setup = setup,
                                  .solve = solve,
                                  .user = &p};
  nsdae_ida *ida = make(&p, 4, 2);
  double y[5];
  int steps, status = NSDAE_E_MEMORY;
  long places = 0;
  process_allocator_reset(-1);
  for (int i = 0; i < 2; i++)
    status = go(ida, 1e-8, INFINITY, pendulum_y, pendulum_ydot, 3, y, &steps);
  long calls = the_process.calls;
  assert_int_equal(status, NSDAE_OK);
  assert_int_equal(calls, 0);
  nsdae_ida_destroy(&ida);
  for (int failed = 1; failed; places++) {
    process_allocator_reset(places);
    status = nsdae_ida_create(&from, &ida);
    failed = the_process.failed != 0;
    if (!failed) nsdae_ida_destroy(&ida);
    long live = the_process.live;
    process_allocator_reset(-1);
    assert_int_equal(status, failed ? NSDAE_E_MEMORY : NSDAE_OK);
    assert_null(ida);
    assert_int_equal(live, 0);
  }
  print_message("%ld places\n", places - 1);
  assert_true(places - 1 >= 5); /* record, vectors, reserve, IDACreate, IDASetLinearSolver */
}
#endif

int main(void)
{
  const struct CMUnitTest tests[] = {
    cmocka_unit_test(test_pendulum),
    cmocka_unit_test(test_step_max),
    cmocka_unit_test(test_stiff),
    cmocka_unit_test(test_any_fails),
    cmocka_unit_test(test_matrix),
#if NSDAE_PROCESS_ALLOCATOR
    cmocka_unit_test(test_memory)
#endif
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
