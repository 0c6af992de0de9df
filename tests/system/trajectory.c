/* The trajectory file, read back with HDF5's own interface. */
#include "check.h"

#include <fcntl.h>
#include <hdf5.h>
#include <hdf5_hl.h>
#include <signal.h>
#include <stdlib.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <time.h>
#include <unistd.h>

#include "bead.h"

enum { NQ = 3, WIDEST = 3 };

static char path[] = "test_trajectory.h5";

typedef struct fixture {
  bead bead;
  nsdae_system *system;
  nsdae_sim *sim;
} fixture;

static void open_fixture(fixture *f, double dt)
{
  nsdae_sim_options options;
  double q0[3], v0[3];
  bead_default(&f->bead);
  bead_start(&f->bead, q0, v0);
  nsdae_sim_options_default(&options);
  options.dt = dt;
  f->system = bead_system(&f->bead);
  assert_int_equal(nsdae_sim_create(f->system, &options, &f->sim, NULL), NSDAE_OK);
  assert_int_equal(nsdae_sim_init(f->sim, 0, q0, v0), NSDAE_OK);
}

static void close_fixture(fixture *f)
{
  nsdae_sim_destroy(&f->sim);
  nsdae_system_destroy(&f->system);
}

/* Parameters of the bead as a table, to see them in the file. */
static const nsdae_param entries[] = {
    {"speed", "m/s", "of the parabola", NSDAE_PARAM_REAL, offsetof(bead, speed), 0, 0, 1, 0, NULL},
    {"repeated", "1", "constraint twice", NSDAE_PARAM_INT, offsetof(bead, repeated), 0, 0, 1, 0,
     NULL},
};
static const nsdae_params table = {entries, 2};

static nsdae_trajectory *create(fixture *f, const char *file, int live)
{
  const nsdae_trajectory_info info = {
      .model = "bead", .parameters = &table, .parameters_base = &f->bead, .live = live};
  nsdae_trajectory *t;
  nsdae_error error;
  int status = nsdae_trajectory_create(f->sim, file, &info, &t, &error);
  if (status < 0) print_message("%s\n", error.text);
  assert_int_equal(status, NSDAE_OK);
  return t;
}

/* Records of a run, kept beside the file. */
typedef struct memory {
  double time[4096], q[4096][NQ], residual[4096], tol[4096];
  int n, impacts;
  double impulse[4096];
  nsdae_certificate certificate[4096];
} memory;

static int remember(const nsdae_record *r, nsdae_error *error, void *user)
{
  memory *m = user;
  (void)error;
  m->time[m->n] = r->time;
  m->residual[m->n] = r->lcp_residual;
  m->tol[m->n] = r->contact_tol;
  m->certificate[m->n] = r->certificate;
  memcpy(m->q[m->n++], r->q, sizeof m->q[0]);
  for (int i = 0; i < r->impacts; i++) m->impulse[m->impacts++] = r->impact[i].normal_impulse;
  return 0;
}

static void expect_shape(hid_t file, const char *name, int rank, hsize_t rows, hsize_t width)
{
  hsize_t dims[3] = {0};
  int got;
  assert_true(H5LTget_dataset_ndims(file, name, &got) >= 0);
  assert_int_equal(got, rank);
  assert_true(H5LTget_dataset_info(file, name, dims, NULL, NULL) >= 0);
  assert_int_equal(dims[0], rows);
  if (rank > 1) assert_int_equal(dims[1], width);
}

/* To be released with H5free_memory. */
static char *read_text(hid_t file, const char *object, const char *name)
{
  char *value = NULL;
  hid_t attribute = H5Aopen_by_name(file, object, name, H5P_DEFAULT, H5P_DEFAULT);
  hid_t type = H5Aget_type(attribute);
  assert_true(attribute >= 0);
  assert_true(H5Aread(attribute, type, &value) >= 0);
  H5Tclose(type);
  H5Aclose(attribute);
  return value;
}

static void expect_text(hid_t file, const char *object, const char *name, const char *text)
{
  char *value = read_text(file, object, name);
  if (text)
    assert_string_equal(value, text);
  else
    assert_true(strlen(value) > 0);
  H5free_memory(value);
}

/* The file was made within the last minute. */
static void expect_created_now(hid_t file)
{
  char *value = read_text(file, "/", "created"), text[32];
  time_t now = time(NULL);
  int found = 0;
  for (time_t t = now - 60; t <= now; t++) {
    strftime(text, sizeof text, "%Y-%m-%dT%H:%M:%SZ", gmtime(&t));
    found |= strcmp(value, text) == 0;
  }
  assert_true(found);
  H5free_memory(value);
}

/* What each dataset of the contract is: name, rank, width. */
static const struct {
  const char *name;
  int rank;
  hsize_t width;
} contract[] = {{"/time", 1, 0},
                {"/q", 2, 3},
                {"/v", 2, 3},
                {"/multiplier", 2, 1},
                {"/contacts/gap", 2, 1},
                {"/contacts/normal_impulse", 2, 1},
                {"/contacts/tangential_impulse", 3, 1},
                {"/contacts/mode", 2, 1},
                {"/energy/kinetic", 1, 0},
                {"/energy/potential", 1, 0},
                {"/energy/dissipated", 1, 0},
                {"/energy/projection", 1, 0},
                {"/certificate/lcp_residual", 1, 0},
                {"/certificate/contact_tol", 1, 0},
                {"/certificate/constraint_drift", 1, 0},
                {"/certificate/penetration", 1, 0},
                {"/certificate/penetration_contact", 1, 0},
                {"/certificate/pull", 1, 0},
                {"/certificate/pull_contact", 1, 0},
                {"/certificate/cone_excess", 1, 0},
                {"/certificate/cone_contact", 1, 0},
                {"/certificate/complementarity", 1, 0},
                {"/certificate/complementarity_contact", 1, 0},
                {"/certificate/drift_constraint", 1, 0},
                {"/certificate/constraint_rate", 1, 0},
                {"/certificate/rate_constraint", 1, 0},
                {"/energy/work", 1, 0},
                {"/energy/unexplained", 1, 0}};
static const char *const impact_names[] = {"/impact/time",           "/impact/id",
                                           "/impact/normal_impulse", "/impact/velocity_before",
                                           "/impact/velocity_after", "/impact/tangential_impulse"};

/* Of the rows, dimension 0, or of the entries of a row. */
static void expect_scale_of(hid_t file, const char *name, const char *scale, unsigned dimension)
{
  hid_t set = H5Dopen2(file, name, H5P_DEFAULT), axis = H5Dopen2(file, scale, H5P_DEFAULT);
  if (strcmp(name, scale) == 0)
    assert_true(H5DSis_scale(set) > 0);
  else
    assert_true(H5DSis_attached(set, axis, dimension) > 0);
  H5Dclose(set);
  H5Dclose(axis);
}

static void expect_scale(hid_t file, const char *name, const char *scale)
{
  expect_scale_of(file, name, scale, 0);
}

static void expect_contract(hid_t file, hsize_t rows, hsize_t impacts)
{
  for (size_t i = 0; i < sizeof contract / sizeof *contract; i++) {
    expect_shape(file, contract[i].name, contract[i].rank, rows, contract[i].width);
    expect_text(file, contract[i].name, "units", NULL);
    expect_text(file, contract[i].name, "description", NULL);
    expect_scale(file, contract[i].name, "/time");
    if (strncmp(contract[i].name, "/contacts/", 10) == 0)
      expect_scale_of(file, contract[i].name, "/contacts/contact", 1);
  }
  expect_shape(file, "/contacts/id", 1, 1, 0);
  expect_scale(file, "/contacts/id", "/contacts/contact");
  for (size_t i = 0; i < 5; i++) {
    expect_shape(file, impact_names[i], 1, impacts, 0);
    expect_scale(file, impact_names[i], "/impact/time");
  }
  expect_shape(file, impact_names[5], 2, impacts, 1);
}

/* The column of the records' certificates at that offset, and its dataset. */
static void expect_figures(hid_t file, const memory *m, const char *name, size_t offset)
{
  static double got[4096];
  assert_true(H5LTread_dataset_double(file, name, got) >= 0);
  for (int i = 0; i < m->n; i++) {
    const char *at = (const char *)&m->certificate[i] + offset;
    int is_item = offset >= offsetof(nsdae_certificate, pull_contact);
    double had = is_item ? *(const int *)(const void *)at : *(const double *)(const void *)at;
    assert_memory_equal(&got[i], &had, sizeof had);
  }
}

static void expect_certificates(hid_t file, const memory *m)
{
  static const struct {
    const char *name;
    size_t offset;
  } all[] = {{"/certificate/pull", offsetof(nsdae_certificate, pull)},
             {"/certificate/pull_contact", offsetof(nsdae_certificate, pull_contact)},
             {"/certificate/cone_excess", offsetof(nsdae_certificate, cone_excess)},
             {"/certificate/cone_contact", offsetof(nsdae_certificate, cone_contact)},
             {"/certificate/penetration", offsetof(nsdae_certificate, penetration)},
             {"/certificate/penetration_contact", offsetof(nsdae_certificate, penetration_contact)},
             {"/certificate/complementarity", offsetof(nsdae_certificate, complementarity)},
             {"/certificate/complementarity_contact",
              offsetof(nsdae_certificate, complementarity_contact)},
             {"/certificate/constraint_drift", offsetof(nsdae_certificate, constraint_drift)},
             {"/certificate/drift_constraint", offsetof(nsdae_certificate, drift_constraint)},
             {"/certificate/constraint_rate", offsetof(nsdae_certificate, constraint_rate)},
             {"/certificate/rate_constraint", offsetof(nsdae_certificate, rate_constraint)},
             {"/energy/work", offsetof(nsdae_certificate, work)},
             {"/energy/dissipated", offsetof(nsdae_certificate, dissipated)},
             {"/energy/unexplained", offsetof(nsdae_certificate, unexplained)}};
  for (size_t i = 0; i < sizeof all / sizeof *all; i++)
    expect_figures(file, m, all[i].name, all[i].offset);
}

static void expect_values(hid_t file, const memory *m)
{
  static double got[4096 * NQ];
  assert_true(H5LTread_dataset_double(file, "/time", got) >= 0);
  assert_memory_equal(got, m->time, (size_t)m->n * sizeof *got);
  assert_true(H5LTread_dataset_double(file, "/q", got) >= 0);
  assert_memory_equal(got, m->q, (size_t)m->n * NQ * sizeof *got);
  assert_true(H5LTread_dataset_double(file, "/certificate/lcp_residual", got) >= 0);
  assert_memory_equal(got, m->residual, (size_t)m->n * sizeof *got);
  assert_true(H5LTread_dataset_double(file, "/certificate/contact_tol", got) >= 0);
  assert_memory_equal(got, m->tol, (size_t)m->n * sizeof *got);
  for (int i = 1; i < m->n; i++) got[0] = fmax(got[0], got[i]);
  assert_true(m->tol[0] == 0 && (m->impacts == 0 || got[0] > 0)); /* the start is no step */
  expect_certificates(file, m);
  if (m->impacts == 0) return;
  assert_true(H5LTread_dataset_double(file, "/impact/normal_impulse", got) >= 0);
  assert_memory_equal(got, m->impulse, (size_t)m->impacts * sizeof *got);
}

static void expect_root(hid_t file, const char *status)
{
  int version;
  double dt, speed;
  expect_text(file, "/", "format", "nsdae-trajectory");
  expect_text(file, "/", "status", status);
  expect_text(file, "/", "library_version", NSDAE_VERSION);
  expect_text(file, "/", "model", "bead");
  expect_text(file, "/", "method", "implicit");
  expect_created_now(file);
  assert_true(H5LTget_attribute_int(file, "/", "format_version", &version) >= 0);
  assert_int_equal(version, 3);
  assert_true(H5LTread_dataset_double(file, "/options/dt", &dt) >= 0);
  assert_true(dt == 0.001);
  assert_true(H5LTread_dataset_double(file, "/parameters/speed", &speed) >= 0);
  assert_true(speed == 0.3);
  expect_text(file, "/parameters/speed", "units", "m/s");
}

/* Every byte that was recorded is in the file, around the size of a chunk. */
static void test_contract(void **state)
{
  (void)state;
  const int steps[] = {0, 1, 1022, 1023, 1024, 3000};
  for (int live = 0; live < 2; live++)
    for (size_t i = 0; i < sizeof steps / sizeof *steps; i++) {
      static memory m;
      fixture f;
      m = (memory){0};
      open_fixture(&f, 0.001);
      nsdae_trajectory *t = create(&f, path, live);
      nsdae_sim_observe(f.sim, remember, &m);
      assert_int_equal(nsdae_sim_run(f.sim, steps[i] * 0.001), NSDAE_OK);
      assert_int_equal(nsdae_trajectory_close(&t, NSDAE_OK, NULL), NSDAE_OK);
      assert_null(t);
      assert_int_equal(m.n, steps[i] + 1);
      hid_t file = H5Fopen(path, H5F_ACC_RDONLY, H5P_DEFAULT);
      assert_true(file >= 0);
      expect_root(file, "complete");
      expect_contract(file, (hsize_t)m.n, (hsize_t)m.impacts);
      expect_values(file, &m);
      H5Fclose(file);
      close_fixture(&f);
    }
}

static void test_failed_run(void **state)
{
  (void)state;
  fixture f;
  open_fixture(&f, 0.001);
  nsdae_trajectory *t = create(&f, path, 0);
  f.bead.term = BEAD_FORCE;
  f.bead.at = 400;
  f.bead.code = -1;
  int status = nsdae_sim_run(f.sim, 3);
  assert_int_equal(status, NSDAE_E_CALLBACK);
  assert_int_equal(nsdae_trajectory_close(&t, status, NULL), NSDAE_OK);
  hid_t file = H5Fopen(path, H5F_ACC_RDONLY, H5P_DEFAULT);
  expect_text(file, "/", "status", "failed");
  H5Fclose(file);
  close_fixture(&f);
}

static void expect_refused(fixture *f, const char *name, const char *words)
{
  const nsdae_trajectory_info info = {.model = "bead"};
  nsdae_trajectory *t;
  nsdae_error error;
  assert_int_equal(nsdae_trajectory_create(f->sim, name, &info, &t, &error), NSDAE_E_IO);
  assert_null(t);
  assert_non_null(strstr(error.text, name));
  assert_non_null(strstr(error.text, words));
}

/* Locking is left to whoever says so, as HDF5's own drivers do. */
static void test_unlocked(void **state)
{
  static const char *const words[] = {"FALSE", "0", "TRUE", "BEST_EFFORT"};
  (void)state;
  for (int i = 0; i < 4; i++) {
    fixture f, other;
    nsdae_error error;
    nsdae_trajectory_info info = {.model = "other"};
    nsdae_trajectory *second = NULL;
    assert_int_equal(setenv("HDF5_USE_FILE_LOCKING", words[i], 1), 0);
    open_fixture(&f, 0.01);
    open_fixture(&other, 0.01);
    nsdae_trajectory *first = create(&f, path, 0);
    int status = nsdae_trajectory_create(other.sim, path, &info, &second, &error);
    assert_int_equal(status == NSDAE_OK, i < 2);
    if (status == NSDAE_OK)
      assert_int_equal(nsdae_trajectory_close(&second, NSDAE_OK, NULL), NSDAE_OK);
    nsdae_trajectory_close(&first, NSDAE_OK, &error);
    close_fixture(&other);
    close_fixture(&f);
  }
  unsetenv("HDF5_USE_FILE_LOCKING");
}

static void test_unwritable(void **state)
{
  (void)state;
  fixture f;
  open_fixture(&f, 0.001);
  expect_refused(&f, "no/such/folder/x.h5", "No such file or directory");
  expect_refused(&f, "/", "Is a directory");
  /* and nothing is left behind in the simulation */
  assert_int_equal(nsdae_sim_run(f.sim, 0.1), NSDAE_OK);
  close_fixture(&f);
}

/* A disk that is full: a file may not grow past some size. In a child, for the limit stays. */
static void test_full_disk(void **state)
{
  (void)state;
  pid_t child = fork();
  if (child == 0) {
    fixture f;
    nsdae_error error;
    const struct rlimit limit = {2000000, 2000000};
    open_fixture(&f, 0.001);
    nsdae_trajectory *t = create(&f, path, 0);
    signal(SIGXFSZ, SIG_IGN);
    setrlimit(RLIMIT_FSIZE, &limit);
    int run = nsdae_sim_run(f.sim, 100);
    const char *text = nsdae_sim_error(f.sim)->text;
    int said = strstr(text, path) && strstr(text, "File too large");
    int closed = nsdae_trajectory_close(&t, run, &error);
    int honest = strstr(error.text, "holds") != NULL;
    close_fixture(&f);
    exit(run != NSDAE_E_IO ? 1 : !said ? 2 : closed != NSDAE_E_IO ? 3 : !honest ? 4 : 0);
  }
  int status;
  assert_int_equal(waitpid(child, &status, 0), child);
  assert_true(WIFEXITED(status));
  assert_int_equal(WEXITSTATUS(status), 0);
  /* what was written before is there, and says how it ended */
  hsize_t rows = 0;
  hid_t file = H5Fopen(path, H5F_ACC_RDONLY, H5P_DEFAULT);
  assert_true(file >= 0);
  assert_true(H5LTget_dataset_info(file, "/time", &rows, NULL, NULL) >= 0);
  assert_true(rows >= 1024);
  expect_text(file, "/", "status", "failed");
  H5Fclose(file);
}

/* Pipe to the parent, and what was recorded by when. */
typedef struct report {
  int pipe;
  double began;
} report;

static double now(void)
{
  struct timespec t;
  clock_gettime(CLOCK_MONOTONIC, &t);
  return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

/* Slows the run down to steps of a millisecond and tells the parent the clock of each. */
static int tell(const nsdae_record *r, nsdae_error *error, void *user)
{
  report *out = user;
  double clock = now();
  (void)r;
  (void)error;
  if (write(out->pipe, &clock, sizeof clock) != sizeof clock) return NSDAE_E_IO;
  nanosleep(&(struct timespec){0, 1000000}, NULL);
  return 0;
}

static void run_for_ever(int pipe)
{
  fixture f;
  report out = {.pipe = pipe};
  open_fixture(&f, 0.001);
  create(&f, path, 0);
  nsdae_sim_observe(f.sim, tell, &out);
  nsdae_sim_run(f.sim, 1e6);
  exit(1);
}

static hsize_t rows_in_file(void)
{
  hsize_t rows = 0;
  hid_t file = H5Fopen(path, H5F_ACC_RDONLY, H5P_DEFAULT);
  assert_true(file >= 0);
  assert_true(H5LTget_dataset_info(file, "/certificate/penetration", &rows, NULL, NULL) >= 0);
  expect_text(file, "/", "status", "running");
  H5Fclose(file);
  return rows;
}

static void kill_after(long milliseconds)
{
  static double clock[100000];
  int pipes[2];
  assert_int_equal(pipe(pipes), 0);
  pid_t child = fork();
  if (child == 0) run_for_ever(pipes[1]);
  close(pipes[1]);
  size_t told = 0; /* first so many, however slow the machine */
  while (told < 60 && read(pipes[0], &clock[told], sizeof *clock) == sizeof *clock) told++;
  nanosleep(&(struct timespec){milliseconds / 1000, milliseconds % 1000 * 1000000}, NULL);
  kill(child, SIGKILL);
  double killed = now();
  waitpid(child, NULL, 0);
  while (told < 100000 && read(pipes[0], &clock[told], sizeof *clock) == sizeof *clock) told++;
  close(pipes[0]);
  hsize_t rows = rows_in_file(), older = 0;
  while (older < told && clock[older] < killed - 1) older++;
  print_message("killed after %ld ms: %zu records, %zu in the file, %zu older than a second\n",
                milliseconds, told, (size_t)rows, (size_t)older);
  assert_true(rows >= older);
  assert_true(told > 60 && older >= 60);
}

static void test_killed(void **state)
{
  (void)state;
  const long after[] = {1300, 1510, 1740};
  for (int i = 0; i < 3; i++) kill_after(after[i]);
  /* plain h5dump opens it too */
  assert_int_equal(system("h5dump -H test_trajectory.h5 > test_trajectory.txt"), 0);
}

/* SWMR: a reader in another process sees records before the file is closed. */
static void test_live(void **state)
{
  (void)state;
  fixture f;
  open_fixture(&f, 0.001);
  nsdae_trajectory *t = create(&f, path, 1);
  assert_int_equal(nsdae_sim_run(f.sim, 2), NSDAE_OK);
  nanosleep(&(struct timespec){0, 300000000}, NULL); /* the next record is flushed at once */
  assert_true(nsdae_sim_step(f.sim) >= 0);
  pid_t child = fork();
  if (child == 0) {
    /* a new program: HDF5's state does not survive a fork */
    execl(NSDAE_LIVE_READER, "live_reader", path, (char *)NULL);
    _exit(9);
  }
  int status;
  waitpid(child, &status, 0);
  assert_int_equal(nsdae_trajectory_close(&t, NSDAE_OK, NULL), NSDAE_OK);
  close_fixture(&f);
  assert_true(WIFEXITED(status));
  assert_int_equal(WEXITSTATUS(status), 0);
}

int main(void)
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(test_contract),  cmocka_unit_test(test_failed_run),
      cmocka_unit_test(test_unlocked),  cmocka_unit_test(test_unwritable),
      cmocka_unit_test(test_full_disk), cmocka_unit_test(test_killed),
      cmocka_unit_test(test_live),
  };
  H5Eset_auto2(H5E_DEFAULT, NULL, NULL);
  int failed = cmocka_run_group_tests(tests, NULL, NULL);
  remove(path);
  return failed;
}
