/* Which records a trajectory keeps, and how: every so-manieth, compressed; how its run ended. */
#include "check.h"

#include <hdf5.h>
#include <hdf5_hl.h>
#include <stdlib.h>
#include <sys/stat.h>

#include "bead.h"

static const char path[] = "test_kept.h5";

/* Of a run of the bead that bounces: times, q of its first coordinate, impulses of impacts. */
typedef struct content {
  hsize_t records, impacts;
  double time[8192], q[8192 * 3], impulse[256], impact[256];
  char status[16];
} content;

static hsize_t rows_of(hid_t file, const char *name)
{
  hsize_t size[3] = {0};
  assert_true(H5LTget_dataset_info(file, name, size, NULL, NULL) >= 0);
  return size[0];
}

static void read_file(content *c)
{
  char *text = NULL;
  hid_t file = H5Fopen(path, H5F_ACC_RDONLY, H5P_DEFAULT);
  assert_true(file >= 0);
  c->records = rows_of(file, "/time");
  c->impacts = rows_of(file, "/impact/time");
  assert_int_equal(rows_of(file, "/q"), c->records);
  assert_true(c->records <= 8192 && c->impacts <= 256);
  assert_true(H5LTread_dataset_double(file, "/time", c->time) >= 0);
  assert_true(H5LTread_dataset_double(file, "/q", c->q) >= 0);
  assert_true(H5LTread_dataset_double(file, "/impact/time", c->impact) >= 0);
  assert_true(H5LTread_dataset_double(file, "/impact/normal_impulse", c->impulse) >= 0);
  hid_t attribute = H5Aopen(file, "status", H5P_DEFAULT), type = H5Aget_type(attribute);
  assert_true(H5Aread(attribute, type, &text) >= 0);
  snprintf(c->status, sizeof c->status, "%s", text);
  H5free_memory(text);
  H5Tclose(type);
  H5Aclose(attribute);
  H5Fclose(file);
}

static int stop_at(const nsdae_record *record, nsdae_error *error, void *user)
{
  (void)error;
  return record->step == *(const long *)user;
}

/* A run of that many steps; stopped: after so many by an observer. */
static void run(const nsdae_trajectory_info *info, int steps, long stopped)
{
  bead b;
  double q0[3], v0[3];
  nsdae_sim *sim;
  nsdae_trajectory *t;
  nsdae_sim_options options;
  bead_default(&b);
  bead_start(&b, q0, v0);
  nsdae_sim_options_default(&options);
  options.dt = 0.001;
  nsdae_system *system = bead_system(&b);
  assert_int_equal(nsdae_sim_create(system, &options, &sim, NULL), NSDAE_OK);
  assert_int_equal(nsdae_sim_init(sim, 0, q0, v0), NSDAE_OK);
  assert_int_equal(nsdae_trajectory_create(sim, path, info, &t, NULL), NSDAE_OK);
  nsdae_sim_observe(sim, stop_at, &stopped);
  int status = nsdae_sim_run(sim, steps * options.dt);
  assert_true(status >= 0);
  assert_int_equal(nsdae_trajectory_close(&t, status, NULL), NSDAE_OK);
  nsdae_sim_destroy(&sim);
  nsdae_system_destroy(&system);
}

static void expect_impacts(const content *got, const content *all)
{
  assert_int_equal(got->impacts, all->impacts);
  assert_true(all->impacts > 0);
  assert_memory_equal(got->impact, all->impact, all->impacts * sizeof(double));
  assert_memory_equal(got->impulse, all->impulse, all->impacts * sizeof(double));
}

/* The start, every N-th, the last state; all impacts. */
static void test_every(void **state)
{
  (void)state;
  enum { STEPS = 4000 };
  static content all, got;
  const nsdae_trajectory_info whole = {.model = "bead"};
  run(&whole, STEPS, -1);
  read_file(&all);
  assert_int_equal(all.records, STEPS + 1);
  const int every[] = {1, 2, 7, 1000, STEPS, STEPS + 5};
  for (size_t i = 0; i < sizeof every / sizeof *every; i++)
    for (int compress = 0; compress < 2; compress++) {
      hsize_t kept = 0;
      const nsdae_trajectory_info info = {
          .model = "bead", .every = every[i], .compress = compress ? 5 : 0};
      run(&info, STEPS, -1);
      read_file(&got);
      for (int step = 0; step <= STEPS; step++) {
        if (step % every[i] != 0 && step != STEPS) continue;
        assert_true(got.time[kept] == all.time[step]);
        assert_memory_equal(&got.q[3 * kept], &all.q[3 * (size_t)step], 3 * sizeof(double));
        kept++;
      }
      assert_int_equal(got.records, kept);
      expect_impacts(&got, &all);
    }
}

/* Around the length of a chunk; compressed, there is the same in it, in less space. */
static void test_compressed(void **state)
{
  (void)state;
  static content all, got;
  const int steps[] = {0, 1022, 1023, 1024, 3071, 5000};
  for (size_t i = 0; i < sizeof steps / sizeof *steps; i++) {
    struct stat plain, packed;
    const nsdae_trajectory_info whole = {.model = "bead"}, small = {.model = "bead", .compress = 9};
    run(&whole, steps[i], -1);
    read_file(&all);
    assert_int_equal(stat(path, &plain), 0);
    run(&small, steps[i], -1);
    read_file(&got);
    assert_int_equal(stat(path, &packed), 0);
    assert_int_equal(got.records, all.records);
    assert_memory_equal(got.q, all.q, all.records * 3 * sizeof(double));
    assert_memory_equal(got.time, all.time, all.records * sizeof(double));
    if (steps[i] > 1023) assert_true(packed.st_size < plain.st_size);
    print_message("%d steps: %ld bytes, compressed %ld\n", steps[i], (long)plain.st_size,
                  (long)packed.st_size);
  }
}

static void test_how_it_ended(void **state)
{
  (void)state;
  static content got;
  const nsdae_trajectory_info info = {.model = "bead"};
  run(&info, 100, -1);
  read_file(&got);
  assert_string_equal(got.status, "complete");
  run(&info, 100, 50);
  read_file(&got);
  assert_string_equal(got.status, "stopped");
  assert_int_equal(got.records, 51);
}

static void test_refused(void **state)
{
  (void)state;
  const nsdae_trajectory_info bad[] = {
      {.every = -1}, {.compress = -1}, {.compress = 10}, {.compress = 1, .live = 1}};
  bead b;
  nsdae_sim *sim;
  nsdae_trajectory *t;
  nsdae_error error;
  bead_default(&b);
  nsdae_system *system = bead_system(&b);
  assert_int_equal(nsdae_sim_create(system, NULL, &sim, NULL), NSDAE_OK);
  for (size_t i = 0; i < sizeof bad / sizeof *bad; i++) {
    assert_int_equal(nsdae_trajectory_create(sim, path, &bad[i], &t, &error), NSDAE_E_ARGUMENT);
    assert_true(strlen(error.argument) > 0);
  }
  nsdae_sim_destroy(&sim);
  nsdae_system_destroy(&system);
}

/* A trajectory and its simulation, while that steps. */
typedef struct meddler {
  nsdae_sim *sim;
  nsdae_trajectory *trajectory;
  int asked, refused;
} meddler;

static int meddle(void *user)
{
  meddler *m = user;
  nsdae_trajectory *other = NULL;
  const nsdae_trajectory_info info = {.model = "another"};
  nsdae_error error;
  m->asked++;
  m->refused += nsdae_trajectory_flush(m->trajectory, &error) == NSDAE_E_STATE;
  m->refused += nsdae_trajectory_close(&m->trajectory, 0, &error) == NSDAE_E_STATE;
  m->refused += error.status == NSDAE_E_STATE && m->trajectory != NULL;
  m->refused += nsdae_trajectory_create(m->sim, path, &info, &other, NULL) == NSDAE_E_STATE;
  return 0;
}

/* Refused from a callback: the file is that of the run without. */
static void test_from_a_callback(void **state)
{
  (void)state;
  static content all, got;
  const nsdae_trajectory_info info = {.model = "bead"};
  bead b;
  double q0[3], v0[3];
  nsdae_sim_options options;
  meddler m = {0};
  run(&info, 100, -1);
  read_file(&all);
  bead_default(&b);
  bead_start(&b, q0, v0);
  nsdae_sim_options_default(&options);
  options.dt = 0.001;
  nsdae_system *system = bead_system(&b);
  assert_int_equal(nsdae_sim_create(system, &options, &m.sim, NULL), NSDAE_OK);
  assert_int_equal(nsdae_sim_init(m.sim, 0, q0, v0), NSDAE_OK);
  assert_int_equal(nsdae_trajectory_create(m.sim, path, &info, &m.trajectory, NULL), NSDAE_OK);
  assert_int_equal(nsdae_sim_set_interrupt(m.sim, meddle, &m), NSDAE_OK);
  assert_true(nsdae_sim_run(m.sim, 0.1) >= 0);
  assert_int_equal(m.asked, 100);
  assert_int_equal(m.refused, 400);
  assert_int_equal(nsdae_trajectory_close(&m.trajectory, 0, NULL), NSDAE_OK);
  nsdae_sim_destroy(&m.sim);
  nsdae_system_destroy(&system);
  read_file(&got);
  assert_memory_equal(&got, &all, sizeof got);
}

int main(void)
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(test_every),           cmocka_unit_test(test_compressed),
      cmocka_unit_test(test_how_it_ended),    cmocka_unit_test(test_refused),
      cmocka_unit_test(test_from_a_callback),
  };
  H5Eset_auto2(H5E_DEFAULT, NULL, NULL);
  int failed = cmocka_run_group_tests(tests, NULL, NULL);
  remove(path);
  return failed;
}
