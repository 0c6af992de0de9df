/* The explicit pairs on y_1' = y_1 cos t, y_2' = -y_2^2 with y = [exp(sin t), 1 / (1 + t)]: orders
 * of the step and of the continuous extension at fixed steps, error control, the border of
 * stability, failures of f. */
#include "check.h"

#include "runge_kutta.h"

typedef struct flow {
  nsdae_runge_kutta rk;
  nsdae_arena arena;
  double stiffness; /* y_1' += stiffness (exp(sin t) - y_1), which leaves the solution as it is */
  double until;     /* f returns `code` later than this */
  int code;
  long calls;
} flow;

static int rate(double t, const double *y, double *ydot, int whole, void *user)
{
  flow *f = user;
  (void)whole;
  f->calls++;
  if (t > f->until) return f->code;
  ydot[0] = y[0] * cos(t) + f->stiffness * (exp(sin(t)) - y[0]);
  ydot[1] = -y[1] * y[1];
  return 0;
}

static void layout(void *object, nsdae_arena *arena)
{
  nsdae_runge_kutta_layout(object, arena);
}

static double error_at(double t, const double *y)
{
  return fmax(fabs(y[0] - exp(sin(t))), fabs(y[1] - 1 / (1 + t)));
}

static void start(flow *f, const nsdae_tableau *pair, double tol, double max_step)
{
  const double y[] = {1, 1};
  f->rk = (nsdae_runge_kutta){.n = 2, .controlled = 2, .rate = rate, .user = f, .pair = pair};
  f->rk.rtol = f->rk.atol = tol;
  f->rk.max_step = f->rk.span = max_step;
  if (f->until == 0) f->until = HUGE_VAL;
  assert_int_equal(nsdae_arena_build(&f->arena, layout, &f->rk), NSDAE_OK);
  assert_int_equal(nsdae_runge_kutta_start(&f->rk, 0, y), NSDAE_OK);
}

static const struct {
  const nsdae_tableau *pair;
  const char *name;
  double step;           /* where rounding does not count yet, nor terms of higher order */
  double order, between; /* of the step, of the extension */
  int stages;
} pairs[] = {{&nsdae_dopri5, "dopri5", 0.1, 5, 4, 6}, {&nsdae_dop853, "dop853", 0.2, 8, 7, 12}};

enum { PAIRS = 2 };

/* The largest errors up to t = 4 of steps h: at their ends, and at eight places inside of each. */
static void errors(int which, double h, double *end, double *inside)
{
  flow f = {0};
  double y[2];
  start(&f, pairs[which].pair, 1e3, h);
  *end = *inside = 0;
  f.rk.h = h;
  while (f.rk.t < 4 - h / 2) {
    assert_int_equal(nsdae_runge_kutta_advance(&f.rk), NSDAE_OK);
    *end = fmax(*end, error_at(f.rk.t, f.rk.y));
    for (int i = 1; i < 9; i++) {
      double t = f.rk.t - h * i / 9;
      assert_int_equal(nsdae_runge_kutta_read(&f.rk, t, 2, y), NSDAE_OK);
      *inside = fmax(*inside, error_at(t, y));
    }
  }
  nsdae_arena_release(&f.arena);
}

/* Halved steps have an error 2^-order times as large; 0.4 of the exponent is for the next term. */
static void test_orders(void **state)
{
  (void)state;
  for (int i = 0; i < PAIRS; i++) {
    double end[2], inside[2];
    for (int j = 0; j < 2; j++) errors(i, ldexp(pairs[i].step, -j), &end[j], &inside[j]);
    print_message("%s: order %.2f, inside %.2f\n", pairs[i].name, log2(end[0] / end[1]),
                  log2(inside[0] / inside[1]));
    assert_true(log2(end[0] / end[1]) > pairs[i].order - 0.4);
    assert_true(log2(inside[0] / inside[1]) > pairs[i].between - 0.4);
  }
}

/* A smaller tolerance gives a smaller error, of its own size over the few units of time; a step has
 * as many evaluations as stages. */
static void test_tolerances(void **state)
{
  (void)state;
  for (int i = 0; i < PAIRS; i++)
    for (double tol = 1e-4; tol > 1e-13; tol *= 0.1) {
      flow f = {0};
      long steps = 0, begun;
      start(&f, pairs[i].pair, tol, 10);
      begun = f.calls;
      for (; f.rk.t < 10; steps++) assert_int_equal(nsdae_runge_kutta_advance(&f.rk), NSDAE_OK);
      assert_at_most(error_at(f.rk.t, f.rk.y), 100 * tol);
      assert_true(f.calls - begun >= pairs[i].stages * steps);
      assert_true(f.calls - begun <= 2 * pairs[i].stages * steps);
      nsdae_arena_release(&f.arena);
    }
}

/* The extension is y at both ends; the step to a place within is the step of that length. */
static void test_land(void **state)
{
  (void)state;
  for (int i = 0; i < PAIRS; i++) {
    flow f = {0};
    double y[2], middle;
    start(&f, pairs[i].pair, 1e-6, 10);
    for (int n = 0; n < 3; n++) assert_int_equal(nsdae_runge_kutta_advance(&f.rk), NSDAE_OK);
    double from = f.rk.from, to = f.rk.t;
    assert_int_equal(nsdae_runge_kutta_read(&f.rk, from * (1 - 1e-15) + to * 1e-15, 2, y),
                     NSDAE_OK);
    assert_at_most(error_at(from, y), 1e-4);
    middle = (from + to) / 2;
    assert_int_equal(nsdae_runge_kutta_land(&f.rk, middle), 0);
    assert_true(f.rk.t == middle && f.rk.from == from);
    assert_at_most(error_at(middle, f.rk.y), 1e-4);
    nsdae_runge_kutta_retreat(&f.rk, 0.5);
    assert_true(f.rk.t == from && f.rk.h == 0.5 * (middle - from));
    nsdae_arena_release(&f.arena);
  }
}

/* y' = -1000 (y - s) + s' bounds the steps by stability, not so s' alone. */
static void test_stiffness(void **state)
{
  (void)state;
  for (int i = 0; i < PAIRS; i++)
    for (int stiff = 0; stiff < 2; stiff++) {
      flow f = {.stiffness = stiff * 1000};
      start(&f, pairs[i].pair, stiff ? 1e-6 : 1e-12, 1);
      for (int n = 0; n < 400; n++) assert_int_equal(nsdae_runge_kutta_advance(&f.rk), NSDAE_OK);
      assert_int_equal(nsdae_runge_kutta_stiff(&f.rk), stiff);
      if (stiff) assert_true(1000 * f.rk.last < 2 * pairs[i].pair->border);
      nsdae_arena_release(&f.arena);
    }
}

/* f that gives up ends the step at once; f that refuses its points is approached from before. */
static void test_failures(void **state)
{
  (void)state;
  for (int i = 0; i < PAIRS; i++)
    for (int code = -1; code <= 1; code += 2) {
      flow f = {.until = 1, .code = code};
      int status = NSDAE_OK;
      start(&f, pairs[i].pair, 1e-8, 1);
      while (status == NSDAE_OK) status = nsdae_runge_kutta_advance(&f.rk);
      assert_true(status == NSDAE_E_CALLBACK || (code > 0 && status == NSDAE_E_CONVERGENCE));
      assert_true(f.rk.t <= 1);
      if (code > 0) assert_true(f.rk.t > 1 - 1e-9);
      assert_at_most(error_at(f.rk.t, f.rk.y), 1e-6);
      nsdae_arena_release(&f.arena);
    }
}

int main(void)
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(test_orders), cmocka_unit_test(test_tolerances), cmocka_unit_test(test_land),
      cmocka_unit_test(test_stiffness), cmocka_unit_test(test_failures)};
  return cmocka_run_group_tests(tests, NULL, NULL);
}
