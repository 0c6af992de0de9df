/* Going on in a file: what is refused, by name, and what is the same as without an end between. */
#define _POSIX_C_SOURCE 200809L /* fork, kill */
#include "check.h"

#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <hdf5.h>
#include <hdf5_hl.h>
#include <stdlib.h>

#include "bead.h"

static const char path[] = "test_resume.h5", whole_path[] = "test_resume_whole.h5";

static const nsdae_param entries[] = {
    {"speed", "m/s", "of the parabola", NSDAE_PARAM_REAL, offsetof(bead, speed), 0, 0, 10, 0, NULL},
};
static const nsdae_params table = {entries, 1};

typedef struct fixture {
  bead bead;
  nsdae_system *system;
  nsdae_sim *sim;
  nsdae_trajectory *trajectory;
  nsdae_sim_options options;
  nsdae_trajectory_info info;
  nsdae_error error;
} fixture;

static void prepare(fixture *f)
{
  *f = (fixture){.sim = NULL};
  bead_default(&f->bead);
  nsdae_sim_options_default(&f->options);
  f->options.dt = 0.001;
  f->info = (nsdae_trajectory_info){.model = "bead", .parameters = &table};
}

static void open_sim(fixture *f)
{
  double q0[3], v0[3];
  bead_start(&f->bead, q0, v0);
  f->info.parameters_base = &f->bead;
  f->system = bead_system(&f->bead);
  assert_int_equal(nsdae_sim_create(f->system, &f->options, &f->sim, NULL), NSDAE_OK);
  assert_int_equal(nsdae_sim_init(f->sim, 0, q0, v0), NSDAE_OK);
}

static int resume(fixture *f)
{
  open_sim(f);
  return nsdae_trajectory_resume(f->sim, path, &f->info, &f->trajectory, &f->error);
}

static void leave(fixture *f, int status)
{
  assert_int_equal(nsdae_trajectory_close(&f->trajectory, status, NULL), NSDAE_OK);
  nsdae_sim_destroy(&f->sim);
  nsdae_system_destroy(&f->system);
}

static void write_file(const char *name, int every, int compress, double t_end)
{
  fixture f;
  prepare(&f);
  open_sim(&f);
  f.info.every = every;
  f.info.compress = compress;
  f.info.t_end = t_end;
  assert_int_equal(nsdae_trajectory_create(f.sim, name, &f.info, &f.trajectory, NULL), NSDAE_OK);
  assert_int_equal(nsdae_sim_run(f.sim, t_end), NSDAE_OK);
  leave(&f, NSDAE_OK);
}

/* The bytes of a dataset of numbers; to be freed. */
static char *bytes_of(const char *name, const char *dataset, size_t *size)
{
  hid_t file = H5Fopen(name, H5F_ACC_RDONLY, H5P_DEFAULT);
  hid_t set = H5Dopen2(file, dataset, H5P_DEFAULT), type = H5Dget_type(set);
  hid_t space = H5Dget_space(set);
  *size = (size_t)H5Sget_simple_extent_npoints(space) * H5Tget_size(type);
  char *bytes = malloc(*size + 1);
  assert_true(H5Dread(set, type, H5S_ALL, H5S_ALL, H5P_DEFAULT, bytes) >= 0);
  H5Sclose(space);
  H5Tclose(type);
  H5Dclose(set);
  H5Fclose(file);
  return bytes;
}

static const char *const datasets[] = {"/time",
                                       "/q",
                                       "/v",
                                       "/multiplier",
                                       "/contacts/gap",
                                       "/contacts/normal_impulse",
                                       "/contacts/mode",
                                       "/energy/kinetic",
                                       "/impact/time",
                                       "/impact/normal_impulse",
                                       "/impact/id",
                                       "/energy/work",
                                       "/energy/unexplained",
                                       "/certificate/lcp_residual",
                                       "/certificate/contact_tol",
                                       "/certificate/constraint_rate",
                                       "/certificate/rate_constraint",
                                       "/certificate/complementarity",
                                       "/restart/state"};

enum { DATASETS = sizeof datasets / sizeof *datasets, ROWS = DATASETS - 1 };

/* The first n of them. */
static void expect_same(int n)
{
  for (int i = 0; i < n; i++) {
    size_t one, other;
    char *a = bytes_of(whole_path, datasets[i], &one), *b = bytes_of(path, datasets[i], &other);
    if (one != other || memcmp(a, b, one) != 0) fail_msg("%s differs", datasets[i]);
    free(a);
    free(b);
  }
}

/* A run that ended goes on to a later end; records that were kept for the end alone are gone. */
static void test_later_end(void **state)
{
  (void)state;
  for (int every = 1; every < 12; every += 5)
    for (int compress = 0; compress < 2; compress++) {
      fixture f;
      write_file(whole_path, every, compress, 3.0);
      write_file(path, every, compress, 1.1);
      prepare(&f);
      assert_int_equal(resume(&f), NSDAE_OK);
      assert_int_equal(nsdae_sim_run(f.sim, 3.0), NSDAE_OK);
      leave(&f, NSDAE_OK);
      expect_same(DATASETS);
    }
}

/* A run in many parts, each of which is flushed in its midst. */
static void test_many_parts(void **state)
{
  (void)state;
  enum { PARTS = 30 };
  write_file(whole_path, 0, 0, 3.0);
  write_file(path, 0, 0, 0.1);
  for (int i = 2; i <= PARTS; i++) {
    fixture f;
    prepare(&f);
    assert_int_equal(resume(&f), NSDAE_OK);
    for (int step = 0; step < 100; step++) {
      assert_true(nsdae_sim_step(f.sim) >= 0);
      if (step == 50) assert_int_equal(nsdae_trajectory_flush(f.trajectory, NULL), NSDAE_OK);
    }
    leave(&f, NSDAE_OK);
  }
  expect_same(DATASETS);
}

static int drop_once(const nsdae_record *record, nsdae_error *error, void *user)
{
  int *left = user;
  (void)error;
  return record->step == 700 && (*left)-- > 0 ? NSDAE_E_IO : 0;
}

/* A record that a later observer refused comes again, and is in the file once. */
static void test_dropped_step(void **state)
{
  (void)state;
  fixture f;
  int left = 1;
  write_file(whole_path, 0, 0, 2.0);
  prepare(&f);
  open_sim(&f);
  f.info.t_end = 2.0;
  assert_int_equal(nsdae_trajectory_create(f.sim, path, &f.info, &f.trajectory, NULL), NSDAE_OK);
  nsdae_sim_observe(f.sim, drop_once, &left);
  assert_int_equal(nsdae_sim_run(f.sim, 2.0), NSDAE_E_IO);
  leave(&f, NSDAE_E_IO);
  prepare(&f);
  assert_int_equal(resume(&f), NSDAE_OK);
  assert_int_equal(nsdae_sim_run(f.sim, 2.0), NSDAE_OK);
  leave(&f, NSDAE_OK);
  expect_same(ROWS); /* the state counts the calls of the step that was dropped, too */
}

/* The bytes of the file; NULL: there is none. */
static char *whole_file(size_t *size)
{
  FILE *file = fopen(path, "rb");
  char *bytes = NULL;
  *size = 0;
  if (!file) return NULL;
  assert_int_equal(fseek(file, 0, SEEK_END), 0);
  *size = (size_t)ftell(file);
  rewind(file);
  bytes = malloc(*size + 1);
  assert_non_null(bytes);
  assert_true(fread(bytes, 1, *size, file) == *size);
  fclose(file);
  return bytes;
}

/* The file is as it was before, to the byte. */
static void refuse(fixture *f, const char *argument)
{
  size_t before, after;
  char *kept = whole_file(&before);
  int status = resume(f);
  char *got = whole_file(&after);
  assert_true(status < 0);
  assert_true(before == after && (!kept) == (!got));
  if (kept) assert_memory_equal(kept, got, before);
  free(kept);
  free(got);
  assert_null(f->trajectory);
  assert_string_equal(f->error.argument, argument);
  assert_non_null(strstr(f->error.text, path));
  leave(f, NSDAE_OK);
}

static void test_refused(void **state)
{
  (void)state;
  size_t before, after;
  fixture f;
  write_file(path, 3, 0, 1.0);
  char *kept = bytes_of(path, "/time", &before);
  prepare(&f);
  f.info.model = "pearl";
  refuse(&f, "model");
  prepare(&f);
  f.options.dt = 0.002;
  refuse(&f, "dt");
  prepare(&f);
  f.options.method = NSDAE_METHOD_MOREAU;
  refuse(&f, "method");
  prepare(&f);
  f.bead.speed = 0.5;
  refuse(&f, "speed");
  prepare(&f);
  f.info.parameters = NULL;
  refuse(&f, "speed");
  prepare(&f);
  f.info.every = 2;
  refuse(&f, "every");
  prepare(&f);
  f.info.compress = 2;
  refuse(&f, "compress");
  FILE *file = fopen(path, "ab"); /* as after a kill between rows and the lengths of datasets */
  fputs("rows that nobody knows", file);
  fclose(file);
  prepare(&f);
  f.options.dt = 0.002;
  refuse(&f, "dt");
  char *got = bytes_of(path, "/time", &after);
  assert_int_equal(before, after);
  assert_memory_equal(kept, got, before);
  free(kept);
  free(got);
}

/* A version of the library that did not know a dataset. */
static void test_missing_dataset(void **state)
{
  (void)state;
  fixture f;
  write_file(path, 0, 0, 0.1);
  hid_t file = H5Fopen(path, H5F_ACC_RDWR, H5P_DEFAULT);
  assert_true(H5Ldelete(file, "/certificate/contact_tol", H5P_DEFAULT) >= 0);
  assert_true(H5Fclose(file) >= 0);
  prepare(&f);
  refuse(&f, "path");
  assert_non_null(strstr(f.error.text, "no /certificate/contact_tol"));
  assert_non_null(strstr(f.error.text, "another version"));
}

static void test_no_state(void **state)
{
  (void)state;
  fixture f;
  remove(path);
  prepare(&f);
  refuse(&f, "path");
  FILE *file = fopen(path, "w");
  fputs("not an HDF5 file", file);
  fclose(file);
  prepare(&f);
  refuse(&f, "path");
  prepare(&f);
  open_sim(&f);
  f.info.live = 1;
  assert_int_equal(nsdae_trajectory_create(f.sim, path, &f.info, &f.trajectory, NULL), NSDAE_OK);
  assert_int_equal(nsdae_sim_run(f.sim, 0.1), NSDAE_OK);
  leave(&f, NSDAE_OK);
  prepare(&f);
  refuse(&f, "path");
  assert_non_null(strstr(f.error.text, "live"));
}

/* Written live and killed: it says so, and what makes it readable; then that it keeps no state. */
static void test_killed_live(void **state)
{
  (void)state;
  fixture f;
  nsdae_param none = {"none", "", "", NSDAE_PARAM_REAL, 0, 0, 0, 1, 0, NULL};
  const nsdae_params table_of_none = {&none, 1};
  double value = 0;
  remove(path);
  pid_t child = fork();
  assert_true(child >= 0);
  if (child == 0) {
    prepare(&f);
    open_sim(&f);
    f.info.live = 1;
    int status = nsdae_trajectory_create(f.sim, path, &f.info, &f.trajectory, NULL);
    if (status == NSDAE_OK) status = nsdae_sim_run(f.sim, 0.1);
    if (status == NSDAE_OK) status = nsdae_trajectory_flush(f.trajectory, NULL);
    if (status == NSDAE_OK) raise(SIGKILL);
    _exit(1);
  }
  int ended = 0;
  assert_int_equal(waitpid(child, &ended, 0), child);
  assert_true(WIFSIGNALED(ended) && WTERMSIG(ended) == SIGKILL);
  prepare(&f);
  refuse(&f, "path");
  assert_non_null(strstr(f.error.text, "live"));
  assert_non_null(strstr(f.error.text, "h5clear"));
  assert_int_equal(nsdae_trajectory_read_params(path, "options", &table_of_none, &value, &f.error),
                   NSDAE_E_IO);
  assert_non_null(strstr(f.error.text, "live"));
}

/* What the run was told, for a program that goes on with it. */
static void test_read_params(void **state)
{
  (void)state;
  fixture f;
  bead told = {.speed = 5};
  nsdae_sim_options options;
  write_file(path, 0, 0, 1.25);
  prepare(&f);
  nsdae_sim_options_default(&options);
  assert_int_equal(
      nsdae_trajectory_read_params(path, "options", nsdae_sim_options_table(), &options, &f.error),
      NSDAE_OK);
  assert_true(options.dt == f.options.dt);
  assert_int_equal(nsdae_trajectory_read_params(path, "parameters", &table, &told, NULL), NSDAE_OK);
  assert_true(told.speed == f.bead.speed);
  double t_end = 0;
  const nsdae_param entry = {"t_end", "s", "", NSDAE_PARAM_REAL, 0, 0, 0, 10, 0, NULL};
  const nsdae_params run = {&entry, 1};
  assert_int_equal(nsdae_trajectory_read_params(path, "run", &run, &t_end, NULL), NSDAE_OK);
  assert_true(t_end == 1.25);
  assert_int_equal(nsdae_trajectory_read_params("none.h5", "run", &run, &t_end, &f.error),
                   NSDAE_E_IO);
  assert_non_null(strstr(f.error.text, "none.h5"));
  assert_int_equal(nsdae_trajectory_read_params(NULL, "run", &run, &t_end, &f.error),
                   NSDAE_E_ARGUMENT);
}

int main(void)
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(test_later_end),       cmocka_unit_test(test_many_parts),
      cmocka_unit_test(test_dropped_step),    cmocka_unit_test(test_refused),
      cmocka_unit_test(test_missing_dataset), cmocka_unit_test(test_no_state),
      cmocka_unit_test(test_killed_live),     cmocka_unit_test(test_read_params),
  };
  H5Eset_auto2(H5E_DEFAULT, NULL, NULL);
  int failed = cmocka_run_group_tests(tests, NULL, NULL);
  remove(path);
  remove(whole_path);
  return failed;
}
