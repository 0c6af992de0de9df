/* Options that bound a solve: each stage alone and each left out, few sweeps and steps, small
 * budgets, cold and warm, and the callback that interrupts. An unsolved problem is reported as
 * such, with the residual of the point returned, which is computed apart in quadruple precision. A
 * stage that is left out is never named. */
#include "check.h"

#include <float.h>
#include <nsdae/nsdae.h>
#include <stdlib.h>
#include <string.h>

#include "friction_families.h"

enum { STAGES = 10 }; /* 1 << STAGES is NSDAE_FRICTION_ALL + 1 */

static void try_bounded(const friction_sample *s, nsdae_friction_options o, double *r)
{
  size_t m = 3 * (size_t)s->problem.contacts;
  nsdae_friction_info info;
  int status = nsdae_friction_solve(&s->problem, &o, r, r + m, &info);
  double residual = friction_sample_residual(s, r, NULL);
  double rounding = DBL_EPSILON * friction_sample_largest(s, r);
  assert_true(status == NSDAE_OK || status == NSDAE_E_LCP);
  assert_int_equal(info.outcome == NSDAE_OUTCOME_SOLVED, status == NSDAE_OK);
  assert_true(isfinite(residual) &&
              fabs(info.residual - residual) <= 1e-3 * residual + 4 * rounding);
  if (status == NSDAE_OK) assert_true(residual <= o.tol + rounding);
  if (info.stage != NSDAE_FRICTION_NONE && info.stage != NSDAE_FRICTION_TRIVIAL)
    assert_true(info.stage & o.stages);
  if (o.max_sweeps > 0) assert_true(info.sweeps <= o.max_sweeps * info.islands);
}

static void test_bounded(void **state)
{
  static const double tols[] = {1e-3, 1e-8, 1e-12};
  (void)state;
  for (unsigned long long seed = 1; seed <= 28; seed++) {
    friction_sample s;
    friction_sample_draw(&s, (int)(seed % FRICTION_FAMILIES), 12 + (int)seed, seed);
    size_t m = 3 * (size_t)s.problem.contacts;
    double *r = calloc(2 * m + 1, sizeof *r);
    nsdae_friction_options o;
    nsdae_friction_options_default(&o);
    assert_non_null(r);
    for (int k = 0; k < 2 * STAGES; k++) {
      o.tol = tols[(seed + (unsigned long long)k) % 3];
      o.stages = k < STAGES ? 1 << k : NSDAE_FRICTION_ALL & ~(1 << (k - STAGES));
      o.budget = k % 4 == 1 ? 300 : 0;
      o.max_sweeps = (k + (int)seed) % 4;
      o.max_iterations = (int)(seed / 2) % 3;
      o.refine = k % 3;
      if (k % 2) memset(r, 0, m * sizeof *r); /* else warm from what there is */
      try_bounded(&s, o, r);
    }
    free(r);
    friction_sample_release(&s);
  }
}

/* Interrupts at the call that user counts down to, and checks what it is called with. */
typedef struct counted {
  int calls, stop_at, contacts;
  double residual;
} counted;

static int count_calls(const nsdae_friction_progress *now, void *user)
{
  counted *c = user;
  assert_true(now->island >= 0 && now->island < now->islands);
  assert_true(now->contacts > 0 && now->contacts <= c->contacts);
  assert_true(now->share >= 0 && now->share < 1.1);
  assert_true(strcmp(nsdae_friction_stage_name(now->stage), "unknown") != 0);
  c->residual = now->residual;
  return ++c->calls == c->stop_at;
}

/* Whenever a solve is interrupted it returns the best point so far, and says so. */
static void test_interrupted(void **state)
{
  (void)state;
  assert_int_equal(NSDAE_FRICTION_ALL, (1 << STAGES) - 1);
  for (unsigned long long seed = 1; seed <= 12; seed++) {
    friction_sample s;
    nsdae_friction_info info;
    nsdae_friction_options o;
    friction_sample_draw(&s, (int)(seed % FRICTION_FAMILIES), 40, seed);
    size_t m = 3 * (size_t)s.problem.contacts;
    double *r = calloc(2 * m + 1, sizeof *r);
    nsdae_friction_options_default(&o);
    o.progress = count_calls;
    for (int stop_at = 1, status = NSDAE_E_INTERRUPTED; status == NSDAE_E_INTERRUPTED; stop_at++) {
      counted c = {.stop_at = stop_at, .contacts = s.problem.contacts};
      o.user = &c;
      memset(r, 0, m * sizeof *r);
      status = nsdae_friction_solve(&s.problem, &o, r, r + m, &info);
      double residual = friction_sample_residual(&s, r, NULL);
      assert_true(status == NSDAE_OK ? c.calls < stop_at : c.calls == stop_at);
      assert_int_equal(status, status == NSDAE_OK ? NSDAE_OK : NSDAE_E_INTERRUPTED);
      assert_true(isfinite(residual) && fabs(info.residual - residual) <= 1e-3 * residual + 1e-14);
    }
    free(r);
    friction_sample_release(&s);
  }
}

int main(void)
{
  const struct CMUnitTest tests[] = {cmocka_unit_test(test_bounded),
                                     cmocka_unit_test(test_interrupted)};
  return cmocka_run_group_tests(tests, NULL, NULL);
}
