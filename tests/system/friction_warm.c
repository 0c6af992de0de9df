/* A guess helps: seeded problems whose forces have changed a little, from the impulses of before,
 * by a residual of the test's own; and ten consecutive steps of a pile under gravity that was
 * tilted, with far less work than from nothing (skipped where they are not there). */
#include "check.h"

#include <nsdae/nsdae.h>
#include <stdlib.h>

#include "friction_families.h"
#include "friction_sequence.h"

enum { SEEDS = 48, LEAST = 30, MOST = 90, STEPS = 10 };

static const char SEQUENCE[] = NSDAE_SHARED_DIR "/friction/seq_mixed_1000";

/* ROUNDING: what scaling changes of a residual (lib/friction/driver/solve.c). */
static const double TOL = 1e-4, ROUNDING = 1e-9;

/* In sweeps, one at least: a Newton step costs less than a hundred of them. */
static double work(const nsdae_friction_info *info)
{
  return fmax(1, (double)info->sweeps + 100.0 * info->iterations);
}

static int solve(const nsdae_friction_problem *p, double *r, nsdae_friction_info *info)
{
  double *u = calloc(3 * (size_t)p->contacts + 1, sizeof *u);
  nsdae_friction_options options;
  nsdae_friction_options_default(&options);
  options.tol = TOL;
  int status = nsdae_friction_solve(p, &options, r, u, info);
  free(u);
  return status;
}

/* Solved wherever it is from nothing, and with a tenth of the work as a rule: the geometric mean,
 * since sums are those of the hardest one. Spheres take more than from nothing now and then, which
 * is little. */
static void test_changed(void **state)
{
  (void)state;
  double sum = 0;
  int count = 0, solved = 0;
  for (int seed = 0; seed < SEEDS; seed += test_share(), count++) {
    friction_sample s = {0};
    nsdae_friction_info info, cold_info;
    friction_sample_draw(&s, seed % FRICTION_FAMILIES, LEAST + (MOST - LEAST) * seed / SEEDS,
                         (unsigned)seed);
    double *warm = calloc(3 * (size_t)s.problem.contacts + 1, sizeof *warm);
    double *cold = calloc(3 * (size_t)s.problem.contacts + 1, sizeof *cold);
    if (solve(&s.problem, warm, &info) == NSDAE_OK) {
      friction_sample_change(&s, 0.02);
      int found = solve(&s.problem, warm, &info), nothing = solve(&s.problem, cold, &cold_info);
      assert_true(found == NSDAE_OK || nothing != NSDAE_OK);
      if (found == NSDAE_OK)
        assert_at_most(friction_sample_residual(&s, warm, NULL), TOL + ROUNDING);
      solved += found == NSDAE_OK;
      sum += log(work(&info) / work(&cold_info));
    }
    free(warm);
    free(cold);
    friction_sample_release(&s);
  }
  const double mean = exp(sum / solved);
  print_message("%d of %d, work warm / cold %.3f\n", solved, count, mean);
  assert_true(solved >= 0.99 * count);
  assert_at_most(mean, 0.25);
}

static void expect_solved(const friction_instant *s, const double *r)
{
  double residual = 1;
  assert_int_equal(nsdae_friction_residual(&s->file.problem, r, NULL, &residual), NSDAE_OK);
  assert_at_most(residual, TOL);
}

static int compare(const void *a, const void *b)
{
  double x = *(const double *)a, y = *(const double *)b;
  return (x > y) - (x < y);
}

/* Work from the solution of the step before, in sweeps; it is less than that from nothing, and both
 * are solved. Then before is this step. */
static double compare_work(friction_instant *before, int number, int from_cold)
{
  friction_instant s;
  nsdae_friction_info warm, cold;
  assert_int_equal(friction_instant_read(SEQUENCE, number, &s), 1);
  double *r = calloc(3 * (size_t)s.file.problem.contacts + 1, sizeof *r);
  friction_instant_hand_on(before, &s);
  assert_int_equal(solve(&s.file.problem, r, &cold), NSDAE_OK);
  assert_int_equal(solve(&s.file.problem, s.r, &warm), NSDAE_OK);
  expect_solved(&s, r);
  expect_solved(&s, s.r);
  if (from_cold) memcpy(s.r, r, 3 * (size_t)s.file.problem.contacts * sizeof *r);
  free(r);
  friction_instant_release(before);
  *before = s;
  assert_true(work(&warm) < work(&cold));
  return work(&warm);
}

/* From a solution that was found cold, or from one that was found so itself. */
static void follow(int from_cold)
{
  friction_instant before;
  nsdae_friction_info info;
  double sweeps[STEPS - 1];
  int found = friction_instant_read(SEQUENCE, 0, &before);
  if (found == 0 || test_share() > 1) {
    friction_instant_release(&before);
    skip();
  }
  assert_int_equal(found, 1);
  assert_int_equal(solve(&before.file.problem, before.r, &info), NSDAE_OK);
  for (int k = 1; k < STEPS; k++) {
    sweeps[k - 1] = compare_work(&before, k, from_cold);
  }
  friction_instant_release(&before);
  qsort(sweeps, STEPS - 1, sizeof *sweeps, compare);
  print_message("sweeps from the step before %.0f in the median, %.0f at most\n",
                sweeps[STEPS / 2 - 1], sweeps[STEPS - 2]);
  assert_at_most(sweeps[STEPS / 2 - 1], 280);
}

static void test_sequence(void **state)
{
  (void)state;
  follow(1);
}

static void test_sequence_warm(void **state)
{
  (void)state;
  follow(0);
}

int main(void)
{
  const struct CMUnitTest tests[] = {cmocka_unit_test(test_changed),
                                     cmocka_unit_test(test_sequence),
                                     cmocka_unit_test(test_sequence_warm)};
  return cmocka_run_group_tests(tests, NULL, NULL);
}
