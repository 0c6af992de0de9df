/* Seeded piles, walls and towers (support/friction_families.h): what is called solved is solved by
 * an independent residual, in long double; nearly all are, to 1e-10; warm starts and local forms
 * agree. */
#include "check.h"

#include <stdlib.h>

#include <nsdae/nsdae.h>

#include "friction_families.h"

enum { SAMPLES = 48, LEAST_SOLVED = 44 };

static int solve(const nsdae_friction_problem *p, double tol, double *r, nsdae_friction_info *info)
{
  nsdae_friction_options options;
  nsdae_friction_options_default(&options);
  options.tol = tol;
  double *u = calloc(3 * (size_t)p->contacts, sizeof *u);
  int status = nsdae_friction_solve(p, &options, r, u, info);
  free(u);
  return status;
}

/* The residual of the library is that of the sample, but for the rounding of r d / s. */
static void check_residual(const friction_sample *s, const double *r, double residual)
{
  assert_near(friction_sample_residual(s, r), residual, 1e-3 * residual + 1e-11);
}

/* From the solution the warm start ends at once. */
static void check_warm(const friction_sample *s, double *r)
{
  nsdae_friction_info info;
  assert_int_equal(solve(&s->problem, 1e-9, r, &info), NSDAE_OK);
  assert_true(info.stage <= NSDAE_FRICTION_WARM);
  assert_int_equal(info.sweeps, 0);
}

static int check_sample(int family, int contacts, unsigned seed)
{
  friction_sample s;
  nsdae_friction_info info;
  memset(&s, 0, sizeof s);
  friction_sample_draw(&s, family, contacts, seed);
  double *r = calloc(3 * (size_t)s.problem.contacts, sizeof *r);
  int status = solve(&s.problem, 1e-10, r, &info);
  assert_true(status == NSDAE_OK || status == NSDAE_E_LCP);
  assert_int_equal(status == NSDAE_OK, info.residual <= 1e-10);
  check_residual(&s, r, info.residual);
  if (status == NSDAE_OK) check_warm(&s, r);
  free(r);
  friction_sample_release(&s);
  return status == NSDAE_OK;
}

static void test_families(void **state)
{
  (void)state;
  int solved = 0;
  for (int k = 0; k < SAMPLES; k++)
    solved += check_sample(k % FRICTION_FAMILIES, 20 + 2 * k, (unsigned)k);
  print_message("%d of %d solved\n", solved, SAMPLES);
  assert_true(solved >= LEAST_SOLVED);
}

/* Both forms of a problem have the solution of one as a solution. */
static void test_forms(void **state)
{
  (void)state;
  for (unsigned k = 0; k < 8; k++) {
    friction_sample s;
    friction_local local;
    nsdae_friction_info info;
    memset(&s, 0, sizeof s);
    friction_sample_draw(&s, (int)k % FRICTION_FAMILIES, 30, 100 + k);
    friction_sample_local(&s, &local);
    double *r = calloc(3 * (size_t)s.problem.contacts, sizeof *r);
    if (solve(&local.problem, 1e-9, r, &info) == NSDAE_OK)
      assert_at_most(friction_sample_residual(&s, r), 1e-8); /* W is rounded: 1e-16 of its terms */
    free(r);
    friction_local_release(&local);
    friction_sample_release(&s);
  }
}

int main(void)
{
  const struct CMUnitTest tests[] = {cmocka_unit_test(test_families), cmocka_unit_test(test_forms)};
  return cmocka_run_group_tests(tests, NULL, NULL);
}
