/* What the options of the friction chain bound: every stage alone and left out, few sweeps and
 * steps, cold and warm. An effort that does not suffice is said not to, with the residual of what
 * is handed over, as computed apart in long double; what suffices solves. */
#include "check.h"

#include <float.h>
#include <nsdae/nsdae.h>
#include <stdlib.h>
#include <string.h>

#include "friction_families.h"

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
  if (status == NSDAE_OK && info.stage != NSDAE_FRICTION_NONE) assert_true(info.stage & o.stages);
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
    for (int k = 0; k < 14; k++) {
      o.tol = tols[(seed + (unsigned long long)k) % 3];
      o.stages = k < 7 ? 1 << k : NSDAE_FRICTION_ALL & ~(1 << (k - 7));
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

int main(void)
{
  const struct CMUnitTest tests[] = {cmocka_unit_test(test_bounded)};
  return cmocka_run_group_tests(tests, NULL, NULL);
}
