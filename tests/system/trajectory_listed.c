/* A contact list in a trajectory: the file has what observers saw, to the bit; each record has its
 * own contacts; runs are resumed. The datasets of fixed contacts have the same names. */
#include "check.h"

#include <hdf5.h>
#include <hdf5_hl.h>
#include <stdlib.h>
#include <sys/wait.h>
#include <unistd.h>

#include "bead.h"
#include "disks.h"

static const char path[] = "test_listed.h5", whole_path[] = "test_listed_whole.h5";

#define check_ok(call) assert_int_equal((call), NSDAE_OK)

enum { DISKS = 16, COLUMNS = 8, STEPS = 250 };

/* All contacts that an observer saw, in the layout of the file. */
typedef struct seen {
  long every, records, contacts, impacts, room;
  long first[STEPS + 1], *id, impact_id[100 * DISKS];
  int count[STEPS + 1], *block, *mode, impact_block[100 * DISKS][2];
  double *gap, *normal, *tangential;
} seen;

static void grow(seen *s, long contacts)
{
  if (contacts <= s->room) return;
  s->room = 2 * contacts;
  size_t n = (size_t)s->room;
  s->id = realloc(s->id, n * sizeof *s->id);
  s->block = realloc(s->block, 2 * n * sizeof *s->block);
  s->mode = realloc(s->mode, n * sizeof *s->mode);
  s->gap = realloc(s->gap, n * sizeof *s->gap);
  s->normal = realloc(s->normal, n * sizeof *s->normal);
  s->tangential = realloc(s->tangential, n * sizeof *s->tangential);
}

static void release(seen *s)
{
  free(s->id);
  free(s->block);
  free(s->mode);
  free(s->gap);
  free(s->normal);
  free(s->tangential);
}

static void see_impacts(seen *s, const nsdae_record *r)
{
  for (int i = 0; i < r->impacts; i++, s->impacts++) {
    int at = r->impact[i].contact;
    assert_in_range(at, 0, r->contacts.count - 1);
    assert_true(s->impacts < 100 * DISKS);
    assert_int_equal(r->impact[i].id, r->contacts.id[at]);
    assert_memory_equal(r->impact[i].block, r->contacts.block + 2 * at, 2 * sizeof(int));
    s->impact_id[s->impacts] = r->contacts.id[at];
    memcpy(s->impact_block[s->impacts], r->contacts.block + 2 * at, 2 * sizeof(int));
  }
}

static int observe(const nsdae_record *r, nsdae_error *error, void *user)
{
  seen *s = user;
  const nsdae_contact_set *c = &r->contacts;
  size_t n = (size_t)c->count;
  (void)error;
  see_impacts(s, r);
  if (r->step % s->every != 0 && r->step != STEPS) return 0;
  grow(s, s->contacts + c->count);
  s->first[s->records] = s->contacts;
  s->count[s->records++] = c->count;
  if (n == 0) return 0;
  memcpy(s->id + s->contacts, c->id, n * sizeof *c->id);
  memcpy(s->block + 2 * s->contacts, c->block, 2 * n * sizeof *c->block);
  memcpy(s->mode + s->contacts, c->mode, n * sizeof *c->mode);
  memcpy(s->gap + s->contacts, c->gap, n * sizeof *c->gap);
  memcpy(s->normal + s->contacts, c->normal_impulse, n * sizeof *c->normal_impulse);
  memcpy(s->tangential + s->contacts, c->tangential_impulse, n * sizeof *c->tangential_impulse);
  s->contacts += c->count;
  return 0;
}

typedef struct fixture {
  disks disks;
  nsdae_system *system;
  nsdae_sim *sim;
  nsdae_trajectory *trajectory;
  nsdae_sim_options options;
  nsdae_trajectory_info info;
  nsdae_error error;
} fixture;

static void prepare(fixture *f, int method)
{
  double q0[3 * DISKS], v0[3 * DISKS];
  *f = (fixture){.info = {.model = "disks"}};
  disks_create(&f->disks, DISKS, COLUMNS);
  f->system = disks_system(&f->disks);
  nsdae_sim_options_default(&f->options);
  f->options.method = method;
  f->options.dt = 1e-3;
  f->options.contact_tol = 1e-8;
  disks_start(&f->disks, q0, v0);
  check_ok(nsdae_sim_create(f->system, &f->options, &f->sim, &f->error));
  check_ok(nsdae_sim_init(f->sim, 0, q0, v0));
}

static void create(fixture *f, const char *name, int method, int every, int compress)
{
  prepare(f, method);
  f->info.every = every;
  f->info.compress = compress;
  check_ok(nsdae_trajectory_create(f->sim, name, &f->info, &f->trajectory, &f->error));
}

static void leave(fixture *f, int status)
{
  check_ok(nsdae_trajectory_close(&f->trajectory, status, &f->error));
  nsdae_sim_destroy(&f->sim);
  nsdae_system_destroy(&f->system);
  disks_destroy(&f->disks);
}

/* The values of a dataset as a type of memory; to be freed. */
static void *values_of(const char *name, const char *dataset, hid_t type, size_t size, size_t *n)
{
  hid_t file = H5Fopen(name, H5F_ACC_RDONLY, H5P_DEFAULT);
  hid_t set = H5Dopen2(file, dataset, H5P_DEFAULT), space = H5Dget_space(set);
  assert_true(set >= 0);
  *n = (size_t)H5Sget_simple_extent_npoints(space);
  void *values = malloc(*n * size + 1);
  assert_true(H5Dread(set, type, H5S_ALL, H5S_ALL, H5P_DEFAULT, values) >= 0);
  H5Sclose(space);
  H5Dclose(set);
  H5Fclose(file);
  return values;
}

static void expect_values(const char *dataset, hid_t type, size_t size, const void *values, long n)
{
  size_t got;
  void *read = values_of(path, dataset, type, size, &got);
  assert_int_equal(got, n);
  if (memcmp(read, values, got * size) != 0) fail_msg("%s differs", dataset);
  free(read);
}

static void expect_seen(const seen *s)
{
  const hid_t real = H5T_NATIVE_DOUBLE, whole = H5T_NATIVE_INT, wide = H5T_NATIVE_LONG;
  expect_values("/contacts/first", wide, sizeof(long), s->first, s->records);
  expect_values("/contacts/count", whole, sizeof(int), s->count, s->records);
  expect_values("/contacts/id", wide, sizeof(long), s->id, s->contacts);
  expect_values("/contacts/block", whole, sizeof(int), s->block, 2 * s->contacts);
  expect_values("/contacts/mode", whole, sizeof(int), s->mode, s->contacts);
  expect_values("/contacts/gap", real, sizeof(double), s->gap, s->contacts);
  expect_values("/contacts/normal_impulse", real, sizeof(double), s->normal, s->contacts);
  expect_values("/contacts/tangential_impulse", real, sizeof(double), s->tangential, s->contacts);
  expect_values("/impact/id", wide, sizeof(long), s->impact_id, s->impacts);
  expect_values("/impact/block", whole, sizeof(int), s->impact_block, 2 * s->impacts);
}

static int attribute(const char *name, const char *object, const char *attribute)
{
  int value = -1;
  hid_t file = H5Fopen(name, H5F_ACC_RDONLY, H5P_DEFAULT);
  assert_true(H5LTget_attribute_int(file, object, attribute, &value) >= 0);
  H5Fclose(file);
  return value;
}

static int has(const char *name, const char *object)
{
  hid_t file = H5Fopen(name, H5F_ACC_RDONLY, H5P_DEFAULT);
  int there = H5Lexists(file, object, H5P_DEFAULT) > 0;
  H5Fclose(file);
  return there;
}

static void test_as_seen(void **state)
{
  (void)state;
  const int method[] = {NSDAE_METHOD_MOREAU, NSDAE_METHOD_IMPLICIT};
  for (int i = 0; i < 8; i++) {
    fixture f;
    static seen s;
    s = (seen){.every = i & 2 ? 7 : 1};
    create(&f, path, method[i & 1], (int)s.every, i & 4 ? 5 : 0);
    nsdae_sim_observe(f.sim, observe, &s);
    check_ok(nsdae_sim_run(f.sim, STEPS * f.options.dt));
    leave(&f, NSDAE_OK);
    assert_true(s.contacts > s.records * DISKS / 4 && s.impacts > DISKS);
    expect_seen(&s);
    assert_int_equal(attribute(path, "/", "format_version"), 3);
    assert_int_equal(attribute(path, "/contacts", "fixed"), 0);
    assert_false(has(path, "/contacts/contact"));
    release(&s);
  }
}

static const struct {
  const char *name;
  size_t size;
} datasets[] = {{"/time", 8},
                {"/q", 8},
                {"/v", 8},
                {"/energy/dissipated", 8},
                {"/energy/unexplained", 8},
                {"/certificate/cone_excess", 8},
                {"/certificate/cone_contact", 4},
                {"/certificate/penetration_contact", 4},
                {"/contacts/first", 8},
                {"/contacts/count", 4},
                {"/contacts/id", 8},
                {"/contacts/block", 4},
                {"/contacts/gap", 8},
                {"/contacts/normal_impulse", 8},
                {"/contacts/tangential_impulse", 8},
                {"/contacts/mode", 4},
                {"/impact/time", 8},
                {"/impact/id", 8},
                {"/impact/normal_impulse", 8},
                {"/restart/state", 1}};

enum { DATASETS = sizeof datasets / sizeof *datasets };

static hid_t type_of(size_t size)
{
  return size == 8 ? H5T_NATIVE_INT64 : size == 4 ? H5T_NATIVE_INT : H5T_NATIVE_UCHAR;
}

/* The file at path is that of a run without an end between; real numbers as they would be rounded
 * are compared as whole ones where they are the same, so the types of the file are read. */
static void expect_same(int n)
{
  for (int i = 0; i < n; i++) {
    size_t one, other, size = datasets[i].size;
    const char *name = datasets[i].name;
    hid_t file = H5Fopen(path, H5F_ACC_RDONLY, H5P_DEFAULT),
          set = H5Dopen2(file, name, H5P_DEFAULT);
    hid_t own = H5Dget_type(set),
          type = H5Tget_class(own) == H5T_FLOAT ? H5T_NATIVE_DOUBLE : type_of(size);
    H5Tclose(own);
    H5Dclose(set);
    H5Fclose(file);
    void *a = values_of(whole_path, name, type, size, &one);
    void *b = values_of(path, name, type, size, &other);
    if (one != other || memcmp(a, b, one * size) != 0)
      fail_msg("%s differs: %zu and %zu values", name, one, other);
    free(a);
    free(b);
  }
}

enum { METHODS = NSDAE_METHOD_EVENT + 1 };

/* The law of penalty has another restitution than e_N, which is a warning. */
static void run(fixture *f, int steps)
{
  int status = nsdae_sim_run(f->sim, steps * f->options.dt);
  assert_true(status == NSDAE_OK || status == NSDAE_WARN_RESTITUTION);
}

static void write_whole(int method, int every, int compress, int steps)
{
  fixture f;
  create(&f, whole_path, method, every, compress);
  run(&f, steps);
  leave(&f, NSDAE_OK);
}

static void go_on(int method, int steps)
{
  fixture f;
  prepare(&f, method);
  check_ok(nsdae_trajectory_resume(f.sim, path, &f.info, &f.trajectory, &f.error));
  run(&f, steps);
  leave(&f, NSDAE_OK);
}

/* In parts; the lists grow and shrink between them, and so does the state. */
static void test_parts(void **state)
{
  (void)state;
  for (int i = 0; i < 4 * METHODS; i++) {
    if (test_share() > 1 && i % 4 != i / 4 % 4) continue; /* one of a method's four */
    fixture f;
    int every = i & 1 ? 9 : 1, compress = i & 2 ? 4 : 0, method = i / 4;
    write_whole(method, every, compress, STEPS);
    create(&f, path, method, every, compress);
    run(&f, 50);
    leave(&f, NSDAE_OK);
    for (int steps = 100; steps <= STEPS; steps += test_share() > 1 ? 150 : 50)
      go_on(method, steps);
    go_on(method, STEPS); /* nothing left to do */
    expect_same(DATASETS);
  }
}

/* A program that dies between flushes leaves a file that is gone on with. */
static void test_killed(void **state)
{
  (void)state;
  for (int i = 0; i < 4 * METHODS; i++) {
    if (test_share() > 1 && i % 4 != (i / 4 + 1) % 4) continue; /* one of a method's four */
    int every = i & 1 ? 5 : 1, method = i / 4, left;
    write_whole(method, every, 0, STEPS / 2);
    pid_t child = fork();
    if (child == 0) {
      fixture f;
      create(&f, path, method, every, 0);
      for (int step = 0; step < 20 + 21 * (i % 4); step++) nsdae_sim_step(f.sim);
      nsdae_trajectory_flush(f.trajectory, NULL);
      for (int step = 0; step < 13; step++) nsdae_sim_step(f.sim);
      _exit(0);
    }
    assert_int_equal(waitpid(child, &left, 0), child);
    go_on(method, STEPS / 2);
    expect_same(DATASETS);
  }
}

static int drop_once(const nsdae_record *record, nsdae_error *error, void *user)
{
  int *left = user;
  (void)error;
  return record->step == 120 && (*left)-- > 0 ? NSDAE_E_IO : 0;
}

/* A record that a later observer refused comes again, and its contacts are there once. */
static void test_dropped(void **state)
{
  (void)state;
  fixture f;
  int left = 1;
  write_whole(NSDAE_METHOD_MOREAU, 1, 0, 200);
  create(&f, path, NSDAE_METHOD_MOREAU, 1, 0);
  nsdae_sim_observe(f.sim, drop_once, &left);
  assert_int_equal(nsdae_sim_run(f.sim, 200 * f.options.dt), NSDAE_E_IO);
  check_ok(nsdae_sim_run(f.sim, 200 * f.options.dt));
  leave(&f, NSDAE_OK);
  expect_same(DATASETS - 1); /* the state counts the calls of the step that was dropped, too */
}

/* A system with fixed contacts has the same datasets by contact, without a list. */
static void test_fixed(void **state)
{
  (void)state;
  bead b;
  double q0[3], v0[3];
  nsdae_sim *sim;
  nsdae_trajectory *t;
  const nsdae_trajectory_info info = {.model = "bead"};
  bead_default(&b);
  bead_start(&b, q0, v0);
  nsdae_system *system = bead_system(&b);
  check_ok(nsdae_sim_create(system, NULL, &sim, NULL));
  check_ok(nsdae_sim_init(sim, 0, q0, v0));
  check_ok(nsdae_trajectory_create(sim, path, &info, &t, NULL));
  check_ok(nsdae_sim_run(sim, 0.5));
  check_ok(nsdae_trajectory_close(&t, NSDAE_OK, NULL));
  nsdae_sim_destroy(&sim);
  nsdae_system_destroy(&system);
  assert_int_equal(attribute(path, "/", "format_version"), 3);
  assert_int_equal(attribute(path, "/contacts", "fixed"), 1);
  assert_true(has(path, "/contacts/contact") && has(path, "/impact/id") && has(path, "/change/id"));
  assert_false(has(path, "/contacts/first") || has(path, "/contacts/block") ||
               has(path, "/impact/block") || has(path, "/shapes"));
  size_t n;
  long *id = values_of(path, "/contacts/id", H5T_NATIVE_LONG, sizeof(long), &n);
  assert_true(n == 1 && id[0] == 0);
  free(id);
}

/* Where bodies of every form of place stand in /shapes: dimension, position, turn; 0: in /bodies.
 */
static const struct {
  nsdae_body body;
  int place[3];
} forms[] = {
    {{.position = {"q3", "q4"}, .angle = "q5"}, {2, 3, 5}},
    {{.position = {"q3", "q4"}, .angle = "q8"}, {2, 3, 8}},
    {{.position = {"q3", "q4"}}, {2, 3, -1}},
    {{.position = {"q0", "q1", "q2"}}, {3, 0, -1}},
    {{.position = {"q0", "q1", "q2"}, .quaternion = {"q3", "q4", "q5", "q6"}}, {3, 0, 3}},
    {{.position = {"q0", "q2"}}, {0}},
    {{.position = {"q0", "q1", "q3"}}, {0}},
    {{.position = {NULL, "q1"}}, {0}},
    {{.position = {"q0"}}, {0}},
    {{.position = {"q0", "q1"}, .angle = "q2/2"}, {0}},
    {{.position = {"q0", "q1", "q2"}, .angle = "q3"}, {0}},
    {{.position = {"q0", "q1"}, .quaternion = {"q3", "q4", "q5", "q6"}}, {0}},
    {{.position = {"q0", "q1", "q2"}, .quaternion = {"q3", "q4", "q5", "q5"}}, {0}},
    {{.shape = NSDAE_SHAPE_SEGMENT, .position = {"q0", "q1"}, .end = {"q3", "q4"}}, {0}},
};
enum { FORMS = sizeof forms / sizeof *forms };

static void test_places(void **state)
{
  static const char *const set[3] = {"/shapes/dimension", "/shapes/position", "/shapes/turn"};
  double q0[3 * DISKS], v0[3 * DISKS];
  disks d;
  nsdae_sim *sim;
  nsdae_trajectory *t;
  const nsdae_trajectory_info info = {.model = "disks"};
  char name[FORMS][16];
  size_t own = 0, n;
  (void)state;
  disks_create(&d, DISKS, COLUMNS);
  nsdae_system *system = disks_system(&d);
  for (int i = 0; i < FORMS; i++) {
    nsdae_body b = forms[i].body;
    snprintf(name[i], sizeof name[i], "more %d", i);
    b.name = name[i];
    check_ok(nsdae_system_add_body(system, &b));
    own += forms[i].place[0] == 0;
  }
  disks_start(&d, q0, v0);
  check_ok(nsdae_sim_create(system, NULL, &sim, NULL));
  check_ok(nsdae_sim_init(sim, 0, q0, v0));
  check_ok(nsdae_trajectory_create(sim, path, &info, &t, NULL));
  check_ok(nsdae_trajectory_close(&t, NSDAE_OK, NULL));
  for (int c = 0; c < 3; c++) {
    int *value = values_of(path, set[c], H5T_NATIVE_INT, sizeof *value, &n);
    assert_true(n >= FORMS - own);
    for (size_t i = 0, at = n - (FORMS - own); i < FORMS; i++)
      if (forms[i].place[0] != 0) assert_int_equal(value[at++], forms[i].place[c]);
    free(value);
  }
  assert_true(has(path, "/bodies/name"));
  nsdae_sim_destroy(&sim);
  nsdae_system_destroy(&system);
  disks_destroy(&d);
}

int main(void)
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(test_as_seen), cmocka_unit_test(test_parts), cmocka_unit_test(test_killed),
      cmocka_unit_test(test_dropped), cmocka_unit_test(test_fixed), cmocka_unit_test(test_places),
  };
  H5Eset_auto2(H5E_DEFAULT, NULL, NULL);
  int failed = cmocka_run_group_tests(tests, NULL, NULL);
  remove(path);
  remove(whole_path);
  return failed;
}
