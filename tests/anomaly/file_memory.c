/* Allocations of lib/io fail, one in each run: NSDAE_E_MEMORY, nothing is left behind, and the file
 * has the rows that were flushed before.
 *
 * Each place that allocates fails once, told by a line and the four that led to it, in the first
 * run that comes to it. The whole form fails every third allocation of every run too, NSDAE_LONG=1
 * each. */
#include "check.h"

#include <hdf5.h>
#include <hdf5_hl.h>
#include <stdlib.h>

#include "allocator.h"
#include "bead.h"
#include "disks.h"
#include "file_image.h"

static const char path[] = "test_file_memory.h5";

enum { STEPS = 1100 };

typedef struct fixture {
  bead bead;
  nsdae_bodies *bodies; /* NULL: the bead */
  nsdae_system *system;
  nsdae_sim *sim;
} fixture;

static int sensed; /* a wheel with sensors of 1, 3 and 4 values, and a ball on a floor, in place of
                      the bead */

static void open_wheel(fixture *f)
{
  double q0[14], v0[12];
  assert_int_equal(nsdae_bodies_create(3, &f->bodies, NULL), NSDAE_OK);
  nsdae_bodies_add(f->bodies,
                   &(nsdae_rigid_body){.mass = 1, .inertia = {1, 1, 1}, .spin = {0, 0, 9}});
  nsdae_bodies_add(f->bodies,
                   &(nsdae_rigid_body){.mass = 1, .inertia = {1, 1, 1}, .position = {0, 0, 1}});
  nsdae_bodies_add_solid(f->bodies, NSDAE_GROUND, &(nsdae_solid){.shape = NSDAE_SHAPE_PLANE});
  nsdae_bodies_add_solid(f->bodies, 1, &(nsdae_solid){.shape = NSDAE_SHAPE_SPHERE, .radius = 1});
  nsdae_bodies_add_contact(f->bodies, 0, 1, 0, 0, 0);
  nsdae_bodies_add_joint(f->bodies, &(nsdae_joint){.body = {NSDAE_GROUND}, .axis = {0, 0, 1}});
  nsdae_bodies_add_sensor(f->bodies,
                          &(nsdae_sensor){.name = "turned", .kind = NSDAE_SENSOR_COORDINATE});
  nsdae_bodies_add_sensor(f->bodies, &(nsdae_sensor){.kind = NSDAE_SENSOR_RATE});
  nsdae_bodies_add_sensor(f->bodies,
                          &(nsdae_sensor){.name = "force", .kind = NSDAE_SENSOR_REACTION_FORCE});
  nsdae_bodies_add_sensor(f->bodies,
                          &(nsdae_sensor){.name = "pose", .kind = NSDAE_SENSOR_ORIENTATION});
  assert_int_equal(nsdae_bodies_system(f->bodies, &f->system), NSDAE_OK);
  nsdae_bodies_get_start(f->bodies, q0, v0);
  assert_int_equal(nsdae_sim_create(f->system, NULL, &f->sim, NULL), NSDAE_OK);
  assert_int_equal(nsdae_sim_init(f->sim, 0, q0, v0), NSDAE_OK);
}

static void open_fixture(fixture *f)
{
  f->bodies = NULL;
  if (sensed) {
    open_wheel(f);
    return;
  }
  double q0[3], v0[3];
  bead_default(&f->bead);
  bead_start(&f->bead, q0, v0);
  f->system = bead_system(&f->bead);
  assert_int_equal(nsdae_sim_create(f->system, NULL, &f->sim, NULL), NSDAE_OK);
  assert_int_equal(nsdae_sim_init(f->sim, 0, q0, v0), NSDAE_OK);
}

static void close_fixture(fixture *f)
{
  nsdae_sim_destroy(&f->sim);
  nsdae_system_destroy(&f->system);
  nsdae_bodies_destroy(&f->bodies);
}

static int write_rows(fixture *f, nsdae_trajectory *t, int steps)
{
  const double mine[] = {1, 2, 3};
  for (int i = 0; i < steps; i++) {
    int status = nsdae_sim_step(f->sim);
    if (status < 0) return status;
  }
  int status = nsdae_trajectory_flush(t, NULL);
  if (status == NSDAE_OK) status = nsdae_trajectory_put(t, "/mine", 3, mine, "1", "mine", NULL);
  return status;
}

/* The allocation of number `at` fails; below 0 none does, and the place of each is noted. */
static void count_from(long at)
{
  if (at < 0)
    allocator_list(5);
  else
    allocator_reset(at);
}

typedef int (*open_fn)(nsdae_sim *sim, const char *path, const nsdae_trajectory_info *info,
                       nsdae_trajectory **trajectory, nsdae_error *error);

/* From opening to closing. The first failure, or NSDAE_OK. */
static int run(open_fn open, long at)
{
  fixture f;
  nsdae_trajectory *t;
  nsdae_error error;
  const nsdae_trajectory_info info = {.model = "bead", .compress = 2, .contact_forces = sensed};
  open_fixture(&f);
  count_from(at);
  int status = open(f.sim, path, &info, &t, &error);
  if (status < 0) assert_non_null(error.text);
  if (status == NSDAE_OK) {
    status = write_rows(&f, t, STEPS);
    int closed = nsdae_trajectory_close(&t, status, &error);
    if (status == NSDAE_OK) status = closed;
  }
  assert_null(t);
  assert_int_equal(the_allocator.live, 0);
  allocator_reset(-1);
  close_fixture(&f);
  return status;
}

static hsize_t rows(void)
{
  hsize_t length = 0;
  hid_t file = H5Fopen(path, H5F_ACC_RDONLY, H5P_DEFAULT);
  assert_true(file >= 0);
  assert_true(H5LTget_dataset_info(file, "/time", &length, NULL, NULL) >= 0);
  H5Fclose(file);
  return length;
}

/* Returns the number of allocations. `before` is the file that is there, NULL: none. */
static long fail_each(int (*act)(open_fn open, long at), open_fn open, const file_image *before)
{
  static call_places tried;
  static unsigned long place[CALL_PLACES];
  long count = 0, failed = 0;
  for (long at = -1; at < count; at++) {
    int whole = getenv("NSDAE_LONG") || (test_share() == 1 && at % 3 == 0);
    if (at >= 0 && !whole && !call_places_add(&tried, place[at])) continue;
    if (before)
      file_image_restore(path, before);
    else
      remove(path);
    int status = act(open, at);
    if (at < 0) { /* without a failure */
      count = the_allocations.count;
      memcpy(place, the_allocations.at, sizeof place);
    }
    assert_int_equal(status, at < 0 ? NSDAE_OK : NSDAE_E_MEMORY);
    if (at >= 0 && before && act == run) assert_true(rows() >= STEPS + 1);
    failed += at >= 0;
  }
  print_message("%ld allocations, %ld failed\n", count, failed);
  assert_true(count > 40);
  return failed;
}

/* Of a new file, and of one that continues. */
static void fail_both(int (*act)(open_fn open, long at), hsize_t steps)
{
  fail_each(act, nsdae_trajectory_create, NULL);
  remove(path);
  assert_int_equal(act(nsdae_trajectory_create, -1), NSDAE_OK);
  file_image whole = file_image_read(path);
  if (steps) assert_int_equal(rows(), steps + 1);
  fail_each(act, nsdae_trajectory_resume, &whole);
  file_image_restore(path, &whole);
  assert_int_equal(act(nsdae_trajectory_resume, -1), NSDAE_OK);
  if (steps) assert_int_equal(rows(), 2 * steps + 1);
  file_image_release(&whole);
}

static void test_bead(void **state)
{
  (void)state;
  fail_both(run, STEPS);
}

static void test_read_params(void **state)
{
  (void)state;
  nsdae_sim_options options;
  nsdae_sim_options_default(&options);
  long at = 0;
  for (;; at++) {
    allocator_reset(at);
    int status =
        nsdae_trajectory_read_params(path, "options", nsdae_sim_options_table(), &options, NULL);
    assert_int_equal(the_allocator.live, 0);
    if (status == NSDAE_OK) break;
    assert_int_equal(status, NSDAE_E_MEMORY);
  }
  allocator_reset(-1);
  assert_true(at > 0);
}

/* Disks that fall on each other: lists, shapes, a state that grows. */
static int run_listed(open_fn open, long at)
{
  enum { DISKS = 6, FALL = 130 };
  disks d;
  double q0[3 * DISKS], v0[3 * DISKS];
  nsdae_sim_options options;
  nsdae_sim *sim;
  nsdae_trajectory *t;
  const nsdae_trajectory_info info = {.model = "disks"};
  nsdae_sim_options_default(&options);
  options.method = NSDAE_METHOD_MOREAU;
  options.dt = 1e-3;
  disks_create(&d, DISKS, 3);
  disks_start(&d, q0, v0);
  nsdae_system *system = disks_system(&d);
  assert_int_equal(nsdae_sim_create(system, &options, &sim, NULL), NSDAE_OK);
  assert_int_equal(nsdae_sim_init(sim, 0, q0, v0), NSDAE_OK);
  count_from(at);
  int status = open(sim, path, &info, &t, NULL);
  for (int i = 0; i < FALL && status == NSDAE_OK; i++) {
    status = nsdae_sim_step(sim);
    if (status == NSDAE_EVENT) status = NSDAE_OK;
    if (status == NSDAE_OK && i % 40 == 0) status = nsdae_trajectory_flush(t, NULL);
  }
  int closed = nsdae_trajectory_close(&t, status, NULL);
  if (status == NSDAE_OK) status = closed;
  assert_int_equal(the_allocator.live, 0);
  allocator_reset(-1);
  nsdae_sim_destroy(&sim);
  nsdae_system_destroy(&system);
  disks_destroy(&d);
  return status;
}

static void test_listed(void **state)
{
  (void)state;
  fail_both(run_listed, 0);
}

static void test_sensors(void **state)
{
  (void)state;
  sensed = 1;
  fail_both(run, STEPS);
  sensed = 0;
}

int main(void)
{
  const struct CMUnitTest tests[] = {cmocka_unit_test(test_bead),
                                     cmocka_unit_test(test_read_params),
                                     cmocka_unit_test(test_sensors), cmocka_unit_test(test_listed)};
  H5Eset_auto2(H5E_DEFAULT, NULL, NULL);
  int failed = cmocka_run_group_tests(tests, NULL, NULL);
  remove(path);
  return failed;
}
