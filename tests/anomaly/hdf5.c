/* Calls of lib/io to HDF5 and its allocations fail, one in each run, in everything that reads or
 * writes a file: a status with a text comes back, nothing stays open or allocated, and where the
 * status says that all went well what was written is there.
 *
 * The quick form fails each line that calls HDF5 or allocates once, in the first task that comes to
 * it; in problems, whose files are small, once for each way there of three callers. The whole form
 * does the latter in trajectories too, NSDAE_LONG=1 fails every call of every task (minutes). */
#include "check.h"

#include <hdf5.h>
#include <stdlib.h>

#include "allocator.h"
#include "bead.h"
#include "file_image.h"
#include "friction_families.h"
#include "hdf5_calls.h"

static const char path[] = "test_hdf5.h5";

enum { STEPS = 6 };

/* One thing that is done to a file: what it needs is made before, without failures. */
typedef struct task {
  const char *name;
  int addresses; /* that tell a place in the quick form (call_places.h) */
  void (*before)(void);
  int (*act)(nsdae_error *error);
} task;

static nsdae_sim *sim;
static nsdae_system *model;
static bead body;

static void start_sim(void)
{
  double q0[3], v0[3];
  nsdae_sim_destroy(&sim);
  nsdae_system_destroy(&model);
  bead_default(&body);
  bead_start(&body, q0, v0);
  model = bead_system(&body);
  nsdae_system_set_name(model, NSDAE_NAME_COORDINATE, 0, "x", "m");
  assert_int_equal(nsdae_sim_create(model, NULL, &sim, NULL), NSDAE_OK);
  assert_int_equal(nsdae_sim_init(sim, 0, q0, v0), NSDAE_OK);
}

/* The first failure of what is written between opening and closing. */
static int write_run(nsdae_trajectory *t, nsdae_error *error)
{
  const double mine[] = {1, 2, 3};
  const char *const texts[] = {"one", "two"};
  int status = NSDAE_OK;
  for (int i = 0; i < STEPS && status >= 0; i++) {
    status = nsdae_sim_step(sim);
    if (status < 0) *error = *nsdae_sim_error(sim);
    if (status >= 0 && i == STEPS / 2) status = nsdae_trajectory_flush(t, error);
  }
  if (status >= 0) status = nsdae_trajectory_put(t, "/own/mine", 3, mine, "1", "mine", error);
  if (status >= 0) status = nsdae_trajectory_put_texts(t, "/own/texts", 2, texts, "texts", error);
  return status < 0 ? status : NSDAE_OK;
}

/* After every kind of opening: writes, closes; the first failure of all. */
static int finish(int opened, nsdae_trajectory *t, nsdae_error *error)
{
  nsdae_error of_close;
  if (opened < 0) {
    assert_null(t);
    return opened;
  }
  int status = write_run(t, error), closed = nsdae_trajectory_close(&t, status, &of_close);
  assert_null(t);
  if (status == NSDAE_OK && closed < 0) *error = of_close;
  return status == NSDAE_OK ? closed : status;
}

static const nsdae_trajectory_info plain = {.model = "bead"},
                                   packed = {.model = "bead", .compress = 3},
                                   alive = {.model = "bead", .live = 1};

static int create(const nsdae_trajectory_info *info, nsdae_error *error)
{
  static const double corners[] = {0, 0, 0, 1, 0, 0, 0, 1, 0};
  static const nsdae_body bodies[] = {
      {.name = "bead", .shape = NSDAE_SHAPE_SPHERE, .size = {0.1}, .position = {"x", "q1"}},
      {.name = "wing",
       .shape = NSDAE_SHAPE_POLYGON,
       .points = 3,
       .point = corners,
       .position = {"q0", "q1"},
       .angle = "q2"}};
  nsdae_trajectory *t = NULL;
  int status = nsdae_trajectory_create(sim, path, info, &t, error);
  if (status < 0) return finish(status, t, error);
  nsdae_error of_close;
  status = nsdae_trajectory_set_bodies(t, 2, bodies, error);
  if (status == NSDAE_OK) return finish(status, t, error);
  nsdae_trajectory_close(&t, status, &of_close);
  return status;
}

static int create_plain(nsdae_error *error)
{
  return create(&plain, error);
}

static int create_packed(nsdae_error *error)
{
  return create(&packed, error);
}

static int create_live(nsdae_error *error)
{
  nsdae_trajectory *t = NULL;
  int status = nsdae_trajectory_create(sim, path, &alive, &t, error);
  if (status < 0) return status;
  for (int i = 0; i < STEPS && status >= 0; i++) {
    status = nsdae_sim_step(sim);
    if (status < 0) *error = *nsdae_sim_error(sim);
    if (status >= 0) status = nsdae_trajectory_flush(t, error);
  }
  nsdae_error of_close;
  int closed = nsdae_trajectory_close(&t, status < 0 ? status : NSDAE_OK, &of_close);
  if (status >= 0 && closed < 0) *error = of_close;
  return status < 0 ? status : closed;
}

enum { PLAIN, PACKED, LCP, GLOBAL, LOCAL, IMAGES };

static file_image images[IMAGES]; /* of files that were written without failures, each once */

static void written(int image, int (*act)(nsdae_error *error))
{
  nsdae_error error;
  if (images[image].bytes) {
    file_image_restore(path, &images[image]);
    return;
  }
  remove(path);
  assert_int_equal(act(&error), NSDAE_OK);
  images[image] = file_image_read(path);
}

static void written_plain(void)
{
  start_sim();
  written(PLAIN, create_plain);
  start_sim();
}

static void written_packed(void)
{
  start_sim();
  written(PACKED, create_packed);
  start_sim();
}

static int resume(const nsdae_trajectory_info *info, nsdae_error *error)
{
  nsdae_trajectory *t = NULL;
  int status = nsdae_trajectory_resume(sim, path, info, &t, error);
  return finish(status, t, error);
}

static int resume_plain(nsdae_error *error)
{
  return resume(&plain, error);
}

static int resume_packed(nsdae_error *error)
{
  return resume(&packed, error);
}

static int read_params(nsdae_error *error)
{
  nsdae_sim_options options;
  nsdae_sim_options_default(&options);
  return nsdae_trajectory_read_params(path, "options", nsdae_sim_options_table(), &options, error);
}

static const double A[] = {2, 1, 1, 3}, b[] = {-1, 2};
static const nsdae_lcp_problem lcp = {.n = 2, .A = A, .lda = 2, .b = b};
static const nsdae_lcp_origin of_lcp = {.time = 0.25, .step = 50, .tol = 1e-9, .method = "moreau"};

static int write_lcp(nsdae_error *error)
{
  return nsdae_lcp_write(path, &lcp, &of_lcp, error);
}

static void written_lcp(void)
{
  written(LCP, write_lcp);
}

static int read_lcp(nsdae_error *error)
{
  nsdae_lcp_file file;
  int status = nsdae_lcp_read(path, &file, error);
  if (status == NSDAE_OK) assert_true(file.n == 2 && file.b[1] == 2);
  nsdae_lcp_file_release(&file);
  return status;
}

static friction_sample drawn;
static friction_local local;

static int write_friction_problem(const nsdae_friction_problem *p, nsdae_error *error)
{
  static double r[2000];
  const nsdae_friction_points points = {.guess = r, .r = r, .u = r, .low = r};
  const nsdae_friction_origin origin = {.time = 0.25, .step = 3, .tol = 1e-9, .method = "moreau"};
  return nsdae_friction_write(path, p, &points, &origin, error);
}

static int write_global(nsdae_error *error)
{
  return write_friction_problem(&drawn.problem, error);
}

static int write_local(nsdae_error *error)
{
  return write_friction_problem(&local.problem, error);
}

static void written_global(void)
{
  written(GLOBAL, write_global);
}

static void written_local(void)
{
  written(LOCAL, write_local);
}

static int read_friction(nsdae_error *error)
{
  nsdae_friction_file file;
  int status = nsdae_friction_read(path, &file, error);
  nsdae_friction_file_release(&file);
  return status;
}

static void nothing(void)
{
  remove(path);
}

static void fresh(void)
{
  remove(path);
  start_sim();
}

static const task tasks[] = {
    {"create", 1, fresh, create_plain},
    {"create packed", 1, fresh, create_packed},
    {"create live", 1, fresh, create_live},
    {"resume", 1, written_plain, resume_plain},
    {"resume packed", 1, written_packed, resume_packed},
    {"read options", 1, written_plain, read_params},
    {"write LCP", 3, nothing, write_lcp},
    {"read LCP", 3, written_lcp, read_lcp},
    {"write friction", 3, nothing, write_global},
    {"read friction", 3, written_global, read_friction},
    {"write friction, local", 3, nothing, write_local},
    {"read friction, local", 3, written_local, read_friction},
};

static void expect_told(const task *t, const char *failed, long at, int status,
                        const nsdae_error *error)
{
  if (status < 0 && (error->status != status || !error->text[0]))
    fail_msg("%s: %s, number %ld: status %d, record %d '%s'", t->name, failed, at, status,
             error->status, error->text);
  if (H5Fget_obj_count(H5F_OBJ_ALL, H5F_OBJ_ALL) > 0)
    fail_msg("%s: %s, number %ld: %d objects stay open", t->name, failed, at,
             (int)H5Fget_obj_count(H5F_OBJ_ALL, H5F_OBJ_ALL));
}

/* Once a call failed and the status is OK: it must not have mattered. Then all is there. */
static void expect_written(const task *t, const char *failed, long at)
{
  nsdae_error error;
  int status = NSDAE_OK;
  if (t->act == create_plain || t->act == create_packed || t->act == resume_plain ||
      t->act == resume_packed) /* one that is live keeps no options */
    status = read_params(&error);
  if (t->act == write_lcp) status = read_lcp(&error);
  if (t->act == write_global || t->act == write_local) status = read_friction(&error);
  if (status < 0) fail_msg("%s: %s, number %ld: OK, and then %s", t->name, failed, at, error.text);
}

static int addresses(const task *t)
{
  return test_share() > 1 ? t->addresses : 3;
}

/* The calls of the task without a failure, each with its place. */
static long list_calls(const task *t)
{
  nsdae_error error = {0};
  t->before();
  hdf5_calls_reset(-1);
  the_hdf5.places.count = 0;
  the_hdf5.listing = addresses(t);
  int status = t->act(&error);
  the_hdf5.listing = 0;
  expect_told(t, "none", -1, status, &error);
  assert_int_equal(status, NSDAE_OK);
  assert_true(the_hdf5.calls > 10 && the_hdf5.calls == the_hdf5.places.count);
  return the_hdf5.calls;
}

/* Call `at` fails. 1 where the status is OK all the same, and what was written is there. */
static int fail_call(const task *t, long at)
{
  nsdae_error error = {0};
  t->before();
  hdf5_calls_reset(at);
  int status = t->act(&error);
  const char *failed = the_hdf5.failed;
  hdf5_calls_reset(-1);
  expect_told(t, failed, at, status, &error);
  assert_non_null(failed);
  if (status < 0) return 0;
  expect_written(t, failed, at);
  if (getenv("NSDAE_VERBOSE")) print_message("%s: %s, number %ld: borne\n", t->name, failed, at);
  return 1;
}

static void test_calls(void **state)
{
  static call_places met; /* in this task or those before it */
  long all = 0;
  (void)state;
  for (size_t i = 0; i < sizeof tasks / sizeof *tasks; i++) {
    const task *t = &tasks[i];
    long calls = list_calls(t), tried = 0, borne = 0;
    for (long at = 0; at < calls; at++)
      if (getenv("NSDAE_LONG") || call_places_add(&met, the_hdf5.places.at[at])) {
        tried++;
        borne += fail_call(t, at);
      }
    print_message("%s: %ld calls, %ld failed, %ld of them borne\n", t->name, calls, tried, borne);
    all += tried;
  }
  assert_true(all > (test_share() > 1 ? 200 : 500)); /* of 1135 places by three addresses */
}

static void test_allocations(void **state)
{
  static call_places tried;
  nsdae_error error = {0};
  (void)state;
  for (size_t i = 0; i < sizeof tasks / sizeof *tasks; i++) {
    const task *t = &tasks[i];
    long failed = 0;
    t->before();
    allocator_list(addresses(t) + 1); /* one is of what grows an array */
    assert_int_equal(t->act(&error), NSDAE_OK);
    allocator_reset(-1);
    for (long at = 0; at < the_allocations.count; at++) {
      if (!getenv("NSDAE_LONG") && !call_places_add(&tried, the_allocations.at[at])) continue;
      failed++;
      t->before();
      allocator_reset(at);
      int status = t->act(&error);
      long live = the_allocator.live;
      allocator_reset(-1);
      expect_told(t, "an allocation", at, status, &error);
      if (status != NSDAE_E_MEMORY || live != 0)
        fail_msg("%s, allocation %ld: status %d, %ld left", t->name, at, status, live);
    }
    print_message("%s: %ld allocations, %ld failed\n", t->name, the_allocations.count, failed);
  }
  assert_true(tried.count > 30);
}

/* Each argument that is none, and calls at the wrong time, by name. */
static void test_arguments(void **state)
{
  const double values[] = {1, 2};
  const char *const texts[] = {"a", "b"};
  const nsdae_body dot = {.name = "dot"};
  nsdae_trajectory *t = NULL;
  nsdae_error error;
  (void)state;
  fresh();
  assert_int_equal(nsdae_trajectory_put(NULL, "/x", 1, values, "", "", &error), NSDAE_E_ARGUMENT);
  assert_string_equal(error.argument, "trajectory");
  assert_int_equal(nsdae_trajectory_flush(NULL, &error), NSDAE_E_ARGUMENT);
  assert_string_equal(error.argument, "trajectory");
  assert_int_equal(nsdae_trajectory_flush(NULL, NULL), NSDAE_E_ARGUMENT);
  assert_int_equal(nsdae_trajectory_create(sim, path, &plain, &t, &error), NSDAE_OK);
  assert_int_equal(nsdae_trajectory_put(t, NULL, 1, values, "", "", &error), NSDAE_E_ARGUMENT);
  assert_string_equal(error.argument, "path");
  assert_int_equal(nsdae_trajectory_put(t, "/x", -1, values, "", "", NULL), NSDAE_E_ARGUMENT);
  assert_int_equal(nsdae_trajectory_put(t, "/x", 1, NULL, "", "", &error), NSDAE_E_ARGUMENT);
  assert_string_equal(error.argument, "values");
  assert_int_equal(nsdae_trajectory_put_texts(t, "/t", 2, NULL, "", &error), NSDAE_E_ARGUMENT);
  assert_int_equal(nsdae_trajectory_put(t, "/x", 2, values, NULL, NULL, NULL), NSDAE_OK);
  assert_int_equal(nsdae_trajectory_put_texts(t, "/t", 2, texts, NULL, NULL), NSDAE_OK);
  assert_true(nsdae_sim_step(sim) >= 0);
  assert_int_equal(nsdae_trajectory_set_bodies(t, 1, &dot, &error), NSDAE_E_STATE);
  assert_int_equal(nsdae_trajectory_set_bodies(t, 1, &dot, NULL), NSDAE_E_STATE);
  assert_int_equal(nsdae_trajectory_flush(t, NULL), NSDAE_OK);
  assert_int_equal(nsdae_trajectory_close(&t, NSDAE_STOPPED, NULL), NSDAE_OK);
  assert_int_equal(nsdae_trajectory_resume(sim, path, &alive, &t, &error), NSDAE_E_ARGUMENT);
  assert_string_equal(error.argument, "live");
  assert_null(t);
}

/* ---- damaged states */

enum { STATE_MOST = 1 << 16 };

/* The bytes of /restart/state with `flip` added to that one, in the places from `from` to `to`; 0
 * where a place has fewer. */
static int damage_state(size_t at, unsigned char flip, size_t from, size_t to)
{
  static unsigned char bytes[STATE_MOST];
  hsize_t size[2];
  hid_t file = H5Fopen(path, H5F_ACC_RDWR, H5P_DEFAULT),
        set = H5Dopen2(file, "/restart/state", H5P_DEFAULT), space = H5Dget_space(set);
  assert_int_equal(H5Sget_simple_extent_dims(space, size, NULL), 2);
  assert_true(size[0] == 2 && size[1] < STATE_MOST / 2);
  assert_true(H5Dread(set, H5T_NATIVE_UCHAR, H5S_ALL, H5S_ALL, H5P_DEFAULT, bytes) >= 0);
  for (size_t place = from; place < to && at < size[1]; place++)
    bytes[place * size[1] + at] = (unsigned char)(bytes[place * size[1] + at] ^ flip);
  assert_true(H5Dwrite(set, H5T_NATIVE_UCHAR, H5S_ALL, H5S_ALL, H5P_DEFAULT, bytes) >= 0);
  H5Sclose(space);
  H5Dclose(set);
  H5Fclose(file);
  return at < size[1];
}

/* Any byte of one state: the run goes on from the other. Of both: it cannot, and says so. */
static void test_damaged_states(void **state)
{
  const unsigned char flips[] = {0x01, 0x40, 0x80};
  nsdae_error error;
  (void)state;
  for (size_t at = 7; at < 400; at += at < 160 ? 8 : 89) { /* a byte of each number of the head */
    unsigned char flip = flips[at / 8 % 3];
    for (size_t place = 0; place < 3; place++) { /* the first, the second, both */
      if (test_share() > 1 && (at / 8 + at / 24) % 3 != place) continue; /* in rotation */
      size_t from = place == 1, to = place == 0 ? 1 : 2;
      written_plain();
      if (!damage_state(at, flip, from, to)) return;
      int status = resume_plain(&error);
      assert_int_equal(status, place < 2 ? NSDAE_OK : NSDAE_E_IO);
      if (place == 2) assert_non_null(strstr(error.text, "it has no complete state"));
    }
  }
}

/* Fewer rows than the states are of. */
static void test_lost_rows(void **state)
{
  const hsize_t one[1] = {1};
  nsdae_error error;
  (void)state;
  written_plain();
  hid_t file = H5Fopen(path, H5F_ACC_RDWR, H5P_DEFAULT), set = H5Dopen2(file, "/time", H5P_DEFAULT);
  assert_true(H5Dset_extent(set, one) >= 0);
  H5Dclose(set);
  H5Fclose(file);
  assert_int_equal(resume_plain(&error), NSDAE_E_IO);
}

/* Something else in the place of a dataset. */
static void replace(const char *name, int rank, const hsize_t *size, const void *bytes)
{
  hid_t file = H5Fopen(path, H5F_ACC_RDWR, H5P_DEFAULT);
  assert_true(H5Ldelete(file, name, H5P_DEFAULT) >= 0);
  hid_t space = H5Screate_simple(rank, size, NULL),
        set =
            H5Dcreate2(file, name, H5T_NATIVE_UCHAR, space, H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT);
  if (bytes)
    assert_true(H5Dwrite(set, H5T_NATIVE_UCHAR, H5S_ALL, H5S_ALL, H5P_DEFAULT, bytes) >= 0);
  H5Dclose(set);
  H5Sclose(space);
  H5Fclose(file);
}

static void test_other_datasets(void **state)
{
  static char endless[4000];
  const char *const texts[] = {
      "", "\n", "no such line\n", "run/every=1", "model/name=other\n", "model/name\n=\n", endless};
  const hsize_t sizes[][2] = {{1, 100}, {2, 100}, {2, 0}, {3, 1000}};
  nsdae_error error;
  (void)state;
  memset(endless, 'x', sizeof endless - 1);
  for (size_t i = 0; i < sizeof texts / sizeof *texts; i++) {
    hsize_t length[1] = {strlen(texts[i])};
    written_plain();
    replace("/restart/setting", 1, length, length[0] > 0 ? texts[i] : NULL);
    int status = resume_plain(&error);
    assert_true(status == NSDAE_E_ARGUMENT || status == NSDAE_E_IO);
    assert_true(error.text[0] && !strchr(error.text, '\n'));
    assert_int_equal(read_params(&error), NSDAE_OK); /* nothing in it is of the options */
  }
  for (size_t i = 0; i < sizeof sizes / sizeof *sizes; i++) {
    written_plain();
    replace("/restart/state", 2, sizes[i], NULL);
    assert_int_equal(resume_plain(&error), NSDAE_E_IO);
    assert_true(error.text[0]);
  }
}

/* ---- a step that comes again */

static int refuse_once(const nsdae_record *record, nsdae_error *error, void *user)
{
  long *at = user;
  (void)error;
  if (record->step != *at) return 0;
  *at = -1;
  return NSDAE_E_IO;
}

/* An observer behind the trajectory's refuses a step, which then is another one: it stands in the
 * file once, as the other; whatever of it was flushed before. */
static void test_step_again(void **state)
{
  nsdae_error error;
  (void)state;
  for (int flushed = 0; flushed < 2; flushed++) {
    nsdae_trajectory *t = NULL;
    nsdae_record r;
    long at = 4;
    double times[16];
    hsize_t rows;
    fresh();
    assert_int_equal(nsdae_trajectory_create(sim, path, &plain, &t, &error), NSDAE_OK);
    assert_int_equal(nsdae_sim_observe(sim, refuse_once, &at), NSDAE_OK);
    for (int i = 0; i < 3; i++) assert_true(nsdae_sim_step(sim) >= 0);
    assert_int_equal(nsdae_sim_step(sim), NSDAE_E_IO);
    if (flushed) assert_int_equal(nsdae_trajectory_flush(t, &error), NSDAE_OK);
    assert_int_equal(nsdae_sim_get_record(sim, &r), NSDAE_OK);
    assert_int_equal(r.step, 3);
    double shorter = r.time + 1e-3;
    assert_true(nsdae_sim_run(sim, shorter) >= 0);
    assert_int_equal(nsdae_trajectory_close(&t, NSDAE_OK, &error), NSDAE_OK);
    hid_t file = H5Fopen(path, H5F_ACC_RDONLY, H5P_DEFAULT),
          set = H5Dopen2(file, "/time", H5P_DEFAULT), space = H5Dget_space(set);
    H5Sget_simple_extent_dims(space, &rows, NULL);
    assert_int_equal(rows, 5);
    assert_true(H5Dread(set, H5T_NATIVE_DOUBLE, H5S_ALL, H5S_ALL, H5P_DEFAULT, times) >= 0);
    assert_true(times[4] == shorter && times[3] < shorter);
    H5Sclose(space);
    H5Dclose(set);
    H5Fclose(file);
  }
}

/* ---- what a program has HDF5 print */

static int printed;

static herr_t print_new(hid_t stack, void *user)
{
  (void)stack;
  assert_ptr_equal(user, &printed);
  return printed++ < 0;
}

static herr_t print_old(void *user)
{
  assert_ptr_equal(user, &printed);
  return printed++ < 0;
}

static void fail_to_read(void)
{
  nsdae_lcp_file file;
  nsdae_error error;
  printed = 0;
  assert_int_equal(nsdae_lcp_read("none_of_this_name.h5", &file, &error), NSDAE_E_IO);
  assert_int_equal(printed, 0);
  assert_true(H5Dopen2(-1, "x", H5P_DEFAULT) < 0);
  assert_int_equal(printed, 1);
}

/* Set in the old way or the new one: it is silent in the library's calls and the same after. */
static void test_printing(void **state)
{
  (void)state;
  assert_true(H5Eset_auto2(H5E_DEFAULT, print_new, &printed) >= 0);
  fail_to_read();
  assert_true(H5Eset_auto1(print_old, &printed) >= 0);
  fail_to_read();
  assert_true(H5Eset_auto2(H5E_DEFAULT, NULL, NULL) >= 0);
}

/* Trajectories, their parameters and problems of others with what is not there. */
static void test_missing(void **state)
{
  const nsdae_params *table = nsdae_sim_options_table();
  nsdae_sim_options options;
  nsdae_trajectory *t = NULL;
  nsdae_error error;
  (void)state;
  fresh();
  assert_int_equal(nsdae_trajectory_read_params(NULL, "options", table, &options, &error),
                   NSDAE_E_ARGUMENT);
  assert_string_equal(error.argument, "path");
  assert_int_equal(nsdae_trajectory_read_params(path, NULL, table, &options, &error),
                   NSDAE_E_ARGUMENT);
  assert_string_equal(error.argument, "group");
  assert_int_equal(nsdae_trajectory_read_params(path, "options", NULL, &options, &error),
                   NSDAE_E_ARGUMENT);
  assert_string_equal(error.argument, "table");
  assert_int_equal(nsdae_trajectory_read_params(path, "options", table, NULL, NULL),
                   NSDAE_E_ARGUMENT);
  assert_int_equal(nsdae_trajectory_read_params(path, "options", table, &options, NULL),
                   NSDAE_E_IO);
  assert_int_equal(nsdae_trajectory_create(sim, path, &plain, &t, NULL), NSDAE_OK);
  assert_int_equal(nsdae_trajectory_put_texts(NULL, "/t", 0, NULL, "", &error), NSDAE_E_ARGUMENT);
  assert_int_equal(nsdae_trajectory_set_bodies(NULL, 0, NULL, &error), NSDAE_E_ARGUMENT);
  assert_int_equal(nsdae_trajectory_set_bodies(t, -1, NULL, &error), NSDAE_E_ARGUMENT);
  assert_int_equal(nsdae_trajectory_close(&t, NSDAE_OK, NULL), NSDAE_OK);
}

int main(void)
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(test_arguments),      cmocka_unit_test(test_printing),
      cmocka_unit_test(test_damaged_states), cmocka_unit_test(test_lost_rows),
      cmocka_unit_test(test_other_datasets), cmocka_unit_test(test_step_again),
      cmocka_unit_test(test_missing),        cmocka_unit_test(test_calls),
      cmocka_unit_test(test_allocations)};
  H5Eset_auto2(H5E_DEFAULT, NULL, NULL);
  friction_sample_draw(&drawn, 0, 10, 11);
  friction_sample_local(&drawn, &local);
  int failed = cmocka_run_group_tests(tests, NULL, NULL);
  friction_local_release(&local);
  friction_sample_release(&drawn);
  for (int i = 0; i < IMAGES; i++) file_image_release(&images[i]);
  nsdae_sim_destroy(&sim);
  nsdae_system_destroy(&model);
  remove(path);
  return failed;
}
