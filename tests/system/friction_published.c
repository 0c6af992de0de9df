/* Problems of the Siconos and FCLIB projects and generated ones, read where they lie: each is
 * solved to 1e-12 from nothing, where double precision can say so. Those that take long are left to
 * the bench. A problem of rolling friction is refused. Skipped where the folder is not there. */
#include "check.h"

#include <nsdae/nsdae.h>
#include <stdio.h>
#include <stdlib.h>

static const char *const names[] = {
    "BoxesStack1-i100000-32",
    "Box_Stacks-i0122-82-5",
    "Capsules-i100-1090",
    "Capsules-i101-404",
    "Capsules-i103-990",
    "Capsules-i125-1213",
    "Confeti-ex13-4contact-Fc3D-SBM",
    "Confeti-ex13-Fc3D-SBM",
    "CubeH8",
    "Example1_Fc3D_SBM",
    "FrictionContact3D_1c",
    "FrictionContact3D_RR_1c",
    "KaplasTower-i1061-4",
    "LMGC_100_PR_PerioBox-i00361-60-03000",
    "LMGC_GFC3D-i00001-1-00000",
    "NESpheres_10_1",
    "OneObject-i100000-316",
    "OneObject-i1028-138",
    "RockPile_tob1",
    "Rover1039",
    "Rover1041",
    "Rover11035",
    "Rover3865",
    "Rover4396",
    "Rover4493",
    "Rover4609",
    "Rover4613",
    "Rover4622",
    "Spheres-i099-356-679",
    "arch_100",
    "pile_capsules_300",
    "pile_spheres_100",
    "spheres-in-a-box-98-i10000-256-10",
    "tower_1000",
    "wall_3000",
};

static int read_problem(const char *name, nsdae_friction_file *file)
{
  char path[512];
  FILE *stream;
  snprintf(path, sizeof path, "%s/friction/%s.hdf5", NSDAE_SHARED_DIR, name);
  stream = fopen(path, "rb");
  if (!stream) return 1;
  fclose(stream);
  return nsdae_friction_read(path, file, NULL);
}

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
  int found = 0;
  for (size_t i = 0; i < sizeof names / sizeof *names; i++) {
    nsdae_friction_file file;
    int status = read_problem(names[i], &file);
    if (status > 0 || status == NSDAE_E_UNSUPPORTED) continue;
    assert_int_equal(status, NSDAE_OK);
    expect_solved(names[i], &file.problem);
    nsdae_friction_file_release(&file);
    found++;
  }
  print_message("%d problems\n", found);
  if (found == 0) skip();
}

static void test_rolling(void **state)
{
  (void)state;
  nsdae_friction_file file;
  int status = read_problem("rolling-Chute-ndof-768-nc-4-3", &file);
  if (status > 0 || status == NSDAE_E_UNSUPPORTED) skip();
  assert_int_equal(status, NSDAE_E_IO);
}

int main(void)
{
  const struct CMUnitTest tests[] = {cmocka_unit_test(test_published),
                                     cmocka_unit_test(test_rolling)};
  return cmocka_run_group_tests(tests, NULL, NULL);
}
