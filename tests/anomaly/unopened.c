/* Where files are read: what is no regular file is refused at once, and nothing else needs a file.
 */
#include "check.h"

#include <nsdae/nsdae.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <unistd.h>

/* A pipe without a writer is refused at once: opening it waits for one. So are folders and devices.
 */
static void test_not_regular(void **state)
{
  (void)state;
  const char *const path[] = {"unopened.obj", "unopened.stl", "unopened.csv", "unopened.h5"};
  enum { PATHS = sizeof path / sizeof *path };
  alarm(60); /* ends the test that waits */
  for (int i = 0; i < PATHS; i++)
    for (int folder = 0; folder < 2; folder++) {
      nsdae_error error;
      nsdae_solid solid;
      nsdae_scene scene;
      nsdae_lcp_file lcp;
      nsdae_friction_file friction;
      remove(path[i]);
      assert_int_equal(folder ? mkdir(path[i], 0700) : mkfifo(path[i], 0600), 0);
      int status = i < 2    ? nsdae_solid_read(path[i], 1, &solid, &error)
                   : i == 2 ? nsdae_scene_read(path[i], &scene, &error)
                            : nsdae_lcp_read(path[i], &lcp, &error);
      if (status != NSDAE_E_UNSUPPORTED) { /* built without HDF5 */
        assert_int_equal(status, NSDAE_E_IO);
        if (i < 3 || !folder) assert_non_null(strstr(error.text, "regular file"));
        if (i == 3) assert_int_equal(nsdae_friction_read(path[i], &friction, &error), NSDAE_E_IO);
      }
      assert_int_equal(remove(path[i]), 0);
    }
  alarm(0);
}

/* The hull of points needs no file, so that it is made without a writable folder, too. */
static void test_no_file(void **state)
{
  (void)state;
  const double point[12] = {0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1};
  const nsdae_solid solid = {.shape = NSDAE_SHAPE_POLYHEDRON, .points = 4, .point = point};
  double triangle[4 * 9];
  nsdae_error error;
  struct rlimit files, none;
  assert_int_equal(getrlimit(RLIMIT_NOFILE, &files), 0);
  none = files;
  none.rlim_cur = 0;
  assert_int_equal(setrlimit(RLIMIT_NOFILE, &none), 0);
  FILE *file = tmpfile();
  int status = nsdae_solid_triangles(&solid, triangle, &error);
  setrlimit(RLIMIT_NOFILE, &files);
  assert_null(file);
  if (status == NSDAE_E_UNSUPPORTED) untested("Qhull");
  if (status < 0) print_error("%s\n", error.text);
  assert_int_equal(status, 4);
}

int main(void)
{
  const struct CMUnitTest tests[] = {cmocka_unit_test(test_not_regular),
                                     cmocka_unit_test(test_no_file)};
  return cmocka_run_group_tests(tests, NULL, NULL);
}
