/* Problems of the Siconos and FCLIB projects, files of tests/data/friction in the layout of FCLIB:
 * each is solved to 1e-12 from nothing. The residual is that of the library, of the file's numbers.
 */
#include "check.h"

#include <nsdae/nsdae.h>
#include <stdio.h>
#include <stdlib.h>

static const char *const names[] = {
    "LMGC_GFC3D-i00001-1-00000", /* 1 contact, global form */
    "Rover1041",                 /* 5 contacts, W of rank 14 */
    "Rover3865",                 /* 5 contacts, W of rank 13 */
    "OneObject-i100000-316",     /* 25 contacts, W of rank 49 */
};

static int rows_of(const nsdae_friction_problem *p)
{
  int m = p->bilateral;
  for (int c = 0; c < p->contacts; c++) m += p->rows ? p->rows[c] : 3;
  return m;
}

static void expect_solved(const char *name, const nsdae_friction_problem *p)
{
  size_t m = (size_t)rows_of(p);
  double *r = calloc(2 * m + 1, sizeof *r), residual = 1;
  nsdae_friction_options options;
  nsdae_friction_info info;
  nsdae_friction_options_default(&options);
  options.tol = 1e-12;
  int status = nsdae_friction_solve(p, &options, r, r + m, &info);
  if (status != NSDAE_OK) print_message("%s: residual %.2e\n", name, info.residual);
  assert_int_equal(status, NSDAE_OK);
  assert_int_equal(nsdae_friction_residual(p, r, NULL, &residual), NSDAE_OK);
  assert_at_most(residual, 1e-12);
  free(r);
}

static void test_published(void **state)
{
  (void)state;
  for (size_t i = 0; i < sizeof names / sizeof *names; i++) {
    char path[512];
    nsdae_friction_file file;
    nsdae_error error;
    snprintf(path, sizeof path, NSDAE_TEST_DATA "/friction/%s.hdf5", names[i]);
    if (nsdae_friction_read(path, &file, &error) != NSDAE_OK) fail_msg("%s", error.text);
    expect_solved(names[i], &file.problem);
    nsdae_friction_file_release(&file);
  }
}

int main(void)
{
  const struct CMUnitTest tests[] = {cmocka_unit_test(test_published)};
  return cmocka_run_group_tests(tests, NULL, NULL);
}
