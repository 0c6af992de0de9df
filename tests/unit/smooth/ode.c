/* The stiff integrator on a problem with a closed solution: few steps (its Jacobian is right),
 * every evaluation counted, and any of them may fail. */
#include "ode.h"
#include "check.h"

enum { N = 2 };

/* C. W. Gear's stiff example: y = (2 e^-t - e^-1000t, e^-1000t - e^-t); -1 and -1000 are the
 * eigenvalues, and the matrix is far from symmetric. */
typedef struct gear {
  long calls, fail_at; /* the call of this number, from 1, returns code */
  int code;
} gear;

static const double start[N] = {1, 0};

static int rate(double t, const double *y, double *ydot, void *user)
{
  gear *g = user;
  (void)t;
  ydot[0] = 998 * y[0] + 1998 * y[1];
  ydot[1] = -999 * y[0] - 1999 * y[1];
  return ++g->calls == g->fail_at ? g->code : 0;
}

/* NULL where the library was built without SUNDIALS */
static nsdae_ode *make(gear *g)
{
  const nsdae_ode_problem problem = {.n = N, .rate = rate, .user = g};
  nsdae_ode *ode;
  int status = nsdae_ode_create(&problem, 1e-8, 1e-12, &ode);
  if (status == NSDAE_E_UNSUPPORTED) untested("no SUNDIALS");
  assert_int_equal(status, NSDAE_OK);
  return ode;
}

static int go(nsdae_ode *ode, const double *from, double t_end, double *y, int *steps)
{
  double t = 0;
  int what = NSDAE_ODE_STEP, found, code, status = nsdae_ode_start(ode, 0, from);
  for (*steps = 0; status == NSDAE_OK && what != NSDAE_ODE_END; ++*steps)
    status = nsdae_ode_advance(ode, t_end, &t, y, &what, &found, &code);
  return status;
}

static void check(const double *y, double t)
{
  /* rtol is that of a step; the error of all of them stays within some hundred times that */
  assert_near(y[0], 2 * exp(-t) - exp(-1000 * t), 1e-6);
  assert_near(y[1], exp(-1000 * t) - exp(-t), 1e-6);
}

static void test_stiff(void **state)
{
  (void)state;
  gear g = {0};
  nsdae_ode *ode = make(&g);
  double y[N];
  int steps;
  for (double t = 0.001; t < 20; t *= 10) {
    assert_int_equal(go(ode, start, t, y, &steps), NSDAE_OK);
    check(y, t);
    assert_int_equal(nsdae_ode_rates(ode), g.calls);
  }
  /* 10 s are 10000 times the fast time constant: without the Jacobian no step is longer than a few
   * of those, with it the smooth solution decides */
  assert_true(steps < 1000);
  nsdae_ode_destroy(&ode);
}

/* Where f is zero it gives no length to the increments. */
static void test_at_rest(void **state)
{
  (void)state;
  gear g = {0};
  nsdae_ode *ode = make(&g);
  const double rest[N] = {0};
  double y[N];
  int steps;
  assert_int_equal(go(ode, rest, 1, y, &steps), NSDAE_OK);
  assert_true(y[0] == 0 && y[1] == 0);
  nsdae_ode_destroy(&ode);
}

/* Each evaluation in turn fails: for good, and the integrator starts anew afterwards; for once, and
 * a smaller step gets past it. The first has no step that could be smaller. */
static void test_any_fails(void **state)
{
  (void)state;
  gear g = {0};
  nsdae_ode *ode = make(&g);
  double y[N];
  int steps;
  for (long i = 1; i < 60; i++) {
    g = (gear){.fail_at = i, .code = -1};
    assert_int_equal(go(ode, start, 0.1, y, &steps), NSDAE_E_CALLBACK);
    g = (gear){.fail_at = i + 1, .code = 1};
    assert_int_equal(go(ode, start, 0.1, y, &steps), NSDAE_OK);
    check(y, 0.1);
  }
  nsdae_ode_destroy(&ode);
}

/* A velocity that is small beside another that it is summed with: q' = v_1, v_1' = 0,
 * v_2' = -1e8 (v_1 + v_2 - 1 - 1e-9 sin t). From q = 0, v = (1, 0) the solution is q = t, v_1 = 1,
 * v_2 = 1e-9 sin t but for 1e-17. */
static int slip_rate(double t, const double *y, double *ydot, void *user)
{
  (void)user;
  ydot[0] = y[1];
  ydot[1] = 0;
  ydot[2] = -1e8 * (y[1] + y[2] - 1 - 1e-9 * sin(t));
  return 0;
}

static int slip_near(double t, const double *y_0, const double *y, double *ydot, void *user)
{
  (void)y_0;
  return slip_rate(t, y, ydot, user);
}

/* An increment of v_2's own size is lost in the sum: the Jacobian is noise, and it takes 1139
 * steps.
 */
static void test_small_beside_another(void **state)
{
  (void)state;
  const nsdae_ode_problem problem = {.n = 3, .rate = slip_rate, .near = slip_near};
  const double from[] = {0, 1, 0};
  double y[3];
  int steps;
  nsdae_ode *ode;
  int status = nsdae_ode_create(&problem, 1e-6, 1e-10, &ode);
  if (status == NSDAE_E_UNSUPPORTED) untested("no SUNDIALS");
  assert_int_equal(status, NSDAE_OK);
  nsdae_ode_positions(ode, 1, 1);
  assert_int_equal(go(ode, from, 1, y, &steps), NSDAE_OK);
  assert_near(y[0], 1, 1e-6);
  assert_near(y[1], 1, 1e-6);
  assert_near(y[2], 1e-9 * sin(1), 1e-10);
  assert_true(steps < 100);
  nsdae_ode_destroy(&ode);
}

int main(void)
{
  const struct CMUnitTest tests[] = {cmocka_unit_test(test_stiff), cmocka_unit_test(test_at_rest),
                                     cmocka_unit_test(test_any_fails),
                                     cmocka_unit_test(test_small_beside_another)};
  return cmocka_run_group_tests(tests, NULL, NULL);
}
