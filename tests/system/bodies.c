/* The bodies of a trajectory file, read back with HDF5's own interface; each fault that a body can
 * have, named. */
#include "check.h"

#include <hdf5.h>
#include <hdf5_hl.h>

#include "bead.h"

static char path[] = "test_bodies.h5";

typedef struct fixture {
  bead bead;
  nsdae_system *system;
  nsdae_sim *sim;
  nsdae_trajectory *file;
} fixture;

static const nsdae_param entries[] = {
    {"speed", "m/s", "of the parabola", NSDAE_PARAM_REAL, offsetof(bead, speed), 0, 0, 1, 0, NULL},
};
static const nsdae_params table = {entries, 1};

static void begin(fixture *f, int live)
{
  double q0[3], v0[3];
  const nsdae_trajectory_info info = {
      .model = "bead", .parameters = &table, .parameters_base = &f->bead, .live = live};
  bead_default(&f->bead);
  bead_start(&f->bead, q0, v0);
  f->system = bead_system(&f->bead);
  nsdae_system_set_name(f->system, NSDAE_NAME_COORDINATE, 2, "theta", "rad");
  assert_int_equal(nsdae_sim_create(f->system, NULL, &f->sim, NULL), NSDAE_OK);
  assert_int_equal(nsdae_sim_init(f->sim, 0, q0, v0), NSDAE_OK);
  assert_int_equal(nsdae_trajectory_create(f->sim, path, &info, &f->file, NULL), NSDAE_OK);
}

static void end(fixture *f)
{
  assert_int_equal(nsdae_trajectory_close(&f->file, NSDAE_OK, NULL), NSDAE_OK);
  nsdae_sim_destroy(&f->sim);
  nsdae_system_destroy(&f->system);
}

static const double corners[] = {0, 0, 0, 1, 0, 0, 0, 2, 0};
static const double line[] = {-1, 0, 0, 3, 0, 0.5};

static const nsdae_body good[] = {
    {.name = "bead", .shape = NSDAE_SHAPE_SPHERE, .size = {0.1}, .position = {"q0", "q1"}},
    {.name = "wing",
     .shape = NSDAE_SHAPE_POLYGON,
     .points = 3,
     .point = corners,
     .position = {"q0", "q1+speed*t"},
     .angle = "theta"},
    {.name = "thread", .shape = NSDAE_SHAPE_SEGMENT, .end = {NULL, "q1"}},
    {.name = "wire", .shape = NSDAE_SHAPE_PATH, .points = 2, .point = line, .angle = ""},
    {.name = "box",
     .shape = NSDAE_SHAPE_BOX,
     .size = {1, 2, 3},
     .quaternion = {"cos(q2/2)", "0", "0", "sin(q2/2)"}},
    {.name = "floor", .shape = NSDAE_SHAPE_PLANE, .size = {0, -2, 0}},
};

enum { BODIES = sizeof good / sizeof *good };

static void expect_texts(hid_t file, const char *name, const char *const *expected)
{
  hid_t set = H5Dopen2(file, name, H5P_DEFAULT), type = H5Dget_type(set), space = H5Dget_space(set);
  char *text[BODIES];
  assert_int_equal(H5Sget_simple_extent_npoints(space), BODIES);
  assert_true(H5Dread(set, type, H5S_ALL, H5S_ALL, H5P_DEFAULT, text) >= 0);
  for (int i = 0; i < BODIES; i++) assert_string_equal(text[i], expected[i]);
  H5Dvlen_reclaim(type, space, H5P_DEFAULT, text);
  H5Sclose(space);
  H5Tclose(type);
  H5Dclose(set);
}

static void expect_file(void)
{
  hid_t file = H5Fopen(path, H5F_ACC_RDONLY, H5P_DEFAULT);
  double size[3 * BODIES], point[15];
  int points[BODIES];
  hsize_t extent[2];
  assert_true(file >= 0);
  expect_texts(file, "/bodies/name",
               (const char *[]){"bead", "wing", "thread", "wire", "box", "floor"});
  expect_texts(file, "/bodies/shape",
               (const char *[]){"sphere", "polygon", "segment", "path", "box", "plane"});
  expect_texts(file, "/bodies/x", (const char *[]){"q0", "q0", "0", "0", "0", "0"});
  expect_texts(file, "/bodies/y", (const char *[]){"q1", "q1+speed*t", "0", "0", "0", "0"});
  expect_texts(file, "/bodies/z", (const char *[]){"0", "0", "0", "0", "0", "0"});
  expect_texts(file, "/bodies/angle", (const char *[]){"", "theta", "", "", "", ""});
  expect_texts(file, "/bodies/quaternion_w", (const char *[]){"", "", "", "", "cos(q2/2)", ""});
  expect_texts(file, "/bodies/quaternion_z", (const char *[]){"", "", "", "", "sin(q2/2)", ""});
  expect_texts(file, "/bodies/end_x", (const char *[]){"", "", "0", "", "", ""});
  expect_texts(file, "/bodies/end_y", (const char *[]){"", "", "q1", "", "", ""});
  assert_true(H5LTread_dataset_double(file, "/bodies/size", size) >= 0);
  assert_true(H5LTread_dataset_int(file, "/bodies/points", points) >= 0);
  assert_true(H5LTget_dataset_info(file, "/bodies/point", extent, NULL, NULL) >= 0);
  assert_true(extent[0] == 5 && extent[1] == 3);
  assert_true(H5LTread_dataset_double(file, "/bodies/point", point) >= 0);
  for (int i = 0; i < BODIES; i++) {
    assert_memory_equal(size + 3 * i, good[i].size, sizeof good[i].size);
    assert_int_equal(points[i], good[i].points);
  }
  assert_memory_equal(point, corners, sizeof corners);
  assert_memory_equal(point + 9, line, sizeof line);
  H5Fclose(file);
}

static void are_in_the_file(void **state)
{
  (void)state;
  for (int live = 0; live < 2; live++) {
    fixture f;
    nsdae_error error;
    begin(&f, live);
    int status = nsdae_trajectory_set_bodies(f.file, BODIES, good, &error);
    if (status < 0) print_error("%s\n", error.text);
    assert_int_equal(status, NSDAE_OK);
    assert_int_equal(nsdae_sim_run(f.sim, 0.1), NSDAE_OK);
    end(&f);
    expect_file();
  }
}

static void are_named_once_and_first(void **state)
{
  (void)state;
  fixture f;
  nsdae_error error;
  begin(&f, 0);
  assert_int_equal(nsdae_trajectory_set_bodies(f.file, BODIES, good, NULL), NSDAE_OK);
  assert_int_equal(nsdae_trajectory_set_bodies(f.file, BODIES, good, &error), NSDAE_E_STATE);
  assert_non_null(strstr(error.text, "once"));
  end(&f);
  begin(&f, 1);
  assert_int_equal(nsdae_sim_step(f.sim), NSDAE_OK);
  assert_int_equal(nsdae_trajectory_set_bodies(f.file, BODIES, good, &error), NSDAE_E_STATE);
  assert_non_null(strstr(error.text, "before the first step"));
  assert_int_equal(nsdae_trajectory_set_bodies(NULL, 0, NULL, &error), NSDAE_E_ARGUMENT);
  assert_string_equal(error.argument, "trajectory");
  end(&f);
  begin(&f, 0); /* none at all is none; n and body are looked at */
  assert_int_equal(nsdae_trajectory_set_bodies(f.file, -1, good, &error), NSDAE_E_ARGUMENT);
  assert_string_equal(error.argument, "n");
  assert_int_equal(nsdae_trajectory_set_bodies(f.file, 1, NULL, &error), NSDAE_E_ARGUMENT);
  assert_string_equal(error.argument, "body");
  assert_int_equal(nsdae_trajectory_set_bodies(f.file, 0, NULL, &error), NSDAE_OK);
  end(&f);
}

/* The bodies of a file with one of them changed are refused with these words, and then it takes
 * the good ones: nothing was written. */
static void refused(int number, nsdae_body bad, const char *field, const char *words)
{
  fixture f;
  nsdae_error error;
  nsdae_body body[BODIES];
  char which[32];
  memcpy(body, good, sizeof good);
  body[number] = bad;
  snprintf(which, sizeof which, "body %d '", number);
  begin(&f, 0);
  assert_int_equal(nsdae_trajectory_set_bodies(f.file, BODIES, body, &error), NSDAE_E_ARGUMENT);
  if (!strstr(error.text, words) || !strstr(error.text, which)) fail_msg("%s", error.text);
  assert_string_equal(error.argument, field);
  assert_int_equal(error.index, number);
  assert_int_equal(nsdae_trajectory_set_bodies(f.file, BODIES, good, NULL), NSDAE_OK);
  end(&f);
}

#define WITH(number, field, value, words)        \
  do {                                           \
    nsdae_body b = good[number];                 \
    b.field = value;                             \
    refused(number, b, field_of(#field), words); \
  } while (0)

/* "position[0]" is told as "position". */
static const char *field_of(const char *expression)
{
  static char field[32];
  snprintf(field, sizeof field, "%.*s", (int)strcspn(expression, "["), expression);
  return strcmp(field, "point") == 0 ? "points" : field;
}

static void faults_are_named(void **state)
{
  static const double endless[] = {0, 0, 0, 1, 0, INFINITY, 0, 2, 0};
  (void)state;
  WITH(0, name, NULL, "it has none");
  WITH(1, name, "bead", "another body has it already");
  WITH(0, shape, -1, "no such shape");
  WITH(0, shape, 99, "no such shape");
  WITH(0, size[0], 0, "its radius must be greater than 0");
  WITH(0, size[0], -1, "a length is negative");
  WITH(0, size[2], NAN, "a value is not finite");
  WITH(4, size[1], 0, "its edges must be greater than 0");
  WITH(5, size[1], 0, "its normal is zero");
  WITH(1, points, 2, "a polygon needs three");
  WITH(1, point, NULL, "point is NULL");
  WITH(1, point, endless, "a value is not finite");
  WITH(3, points, 1, "a path needs two");
  WITH(0, points, 1, "only a polygon, a path and a polyhedron have any");
  WITH(0, position[0], "q3", "there is no q3: the coordinates are q0 to q2, at character 1");
  WITH(0, position[2], "sped", "did you mean 'speed'?");
  WITH(1, angle, "thet", "did you mean 'theta'?");
  WITH(1, angle, "atan2(q9, q1)", "there is no q9");
  WITH(1, angle, "atan2(q0 q1)", "atan2 takes 2 values");
  WITH(1, angle, "q2+\x01", "'?' in place of a value");
  WITH(1, angle, "{q2}", "'{' in place of a value");
  WITH(1, angle, "q2+", "ends in place of a value, at character 4");
  WITH(4, quaternion[3], "sin(q2", "sin without )");
  WITH(4, quaternion[1], NULL, "it has four parts");
  WITH(4, angle, "q2", "it has a quaternion too");
  WITH(2, end[1], NULL, "a segment needs its other end");
  WITH(2, end[0], "q", "unknown name 'q'");
  WITH(2, angle, "0", "lies between its ends");
  WITH(0, end[1], "1", "only a segment has one");
  WITH(4, size[0], 0, "its edges must be greater than 0");
  WITH(4, size[2], 0, "its edges must be greater than 0");
  const nsdae_body thin = {.name = "thin", .shape = NSDAE_SHAPE_CAPSULE, .size = {0, 1}};
  refused(0, thin, "size", "its radius must be greater than 0");
  WITH(0, name, "", "it has none");
  const nsdae_body turned = {.name = "turned",
                             .shape = NSDAE_SHAPE_SEGMENT,
                             .end = {"1"},
                             .quaternion = {"1", "0", "0", "0"}};
  refused(0, turned, "angle", "lies between its ends");
  nsdae_body ring = {.name = "ring", .shape = NSDAE_SHAPE_DISC, .size = {1, 1}};
  refused(0, ring, "size", "the radius of its hole must be less than its own");
}

/* Those of the system are there by themselves, as copies, in files that are live or not; others can
 * be named in their place; what is wrong with one is said when the file is made. */
static void system_has_them(void **state)
{
  (void)state;
  for (int named = 0; named < 3; named++) {
    fixture f;
    nsdae_body body[BODIES];
    char name[16];
    begin(&f, 0);
    nsdae_trajectory_close(&f.file, NSDAE_OK, NULL);
    nsdae_sim_destroy(&f.sim);
    memcpy(body, good, sizeof body);
    for (int i = 0; i < BODIES; i++) {
      snprintf(name, sizeof name, "%s", good[i].name);
      body[i].name = name;
      assert_int_equal(nsdae_system_add_body(f.system, &body[i]), NSDAE_OK);
    }
    if (named == 1) /* in their place; theirs have another size */
      assert_int_equal(nsdae_system_add_body(f.system, &(nsdae_body){.name = "more"}), NSDAE_OK);
    double q0[3], v0[3];
    const nsdae_trajectory_info info = {
        .model = "bead", .parameters = &table, .parameters_base = &f.bead, .live = named == 2};
    bead_start(&f.bead, q0, v0);
    assert_int_equal(nsdae_sim_create(f.system, NULL, &f.sim, NULL), NSDAE_OK);
    assert_int_equal(nsdae_system_add_body(f.system, good), NSDAE_E_STATE);
    assert_string_equal(nsdae_system_error(f.system)->where, "nsdae_system_add_body");
    assert_int_equal(nsdae_sim_init(f.sim, 0, q0, v0), NSDAE_OK);
    assert_int_equal(nsdae_trajectory_create(f.sim, path, &info, &f.file, NULL), NSDAE_OK);
    if (named == 1)
      assert_int_equal(nsdae_trajectory_set_bodies(f.file, BODIES, good, NULL), NSDAE_OK);
    assert_int_equal(nsdae_sim_run(f.sim, 0.1), NSDAE_OK);
    end(&f);
    expect_file();
  }
}

static void faults_of_the_system(void **state)
{
  fixture f;
  nsdae_error error;
  nsdae_trajectory *file;
  const nsdae_trajectory_info info = {.model = "bead"};
  const nsdae_body faulty = {.name = "faulty", .position = {"q7"}};
  int n = -1;
  (void)state;
  begin(&f, 0);
  assert_null(nsdae_system_get_bodies(f.system, &n));
  assert_int_equal(n, 0);
  assert_null(nsdae_system_get_bodies(f.system, NULL));
  n = -1;
  assert_null(nsdae_system_get_bodies(NULL, &n));
  assert_int_equal(n, 0);
  assert_int_equal(nsdae_trajectory_close(&f.file, NSDAE_OK, NULL), NSDAE_OK);
  nsdae_sim_destroy(&f.sim);
  assert_int_equal(nsdae_system_add_body(NULL, &faulty), NSDAE_E_ARGUMENT);
  assert_int_equal(nsdae_system_add_body(f.system, NULL), NSDAE_E_ARGUMENT);
  assert_int_equal(nsdae_system_add_body(f.system, &(nsdae_body){.points = 2}), NSDAE_E_ARGUMENT);
  assert_int_equal(nsdae_system_add_body(f.system, &(nsdae_body){.points = -1}), NSDAE_E_ARGUMENT);
  nsdae_system_clear_error(f.system);
  assert_int_equal(nsdae_system_add_body(f.system, &faulty), NSDAE_OK);
  assert_string_equal(nsdae_system_get_bodies(f.system, &n)->position[0], "q7");
  assert_int_equal(n, 1);
  assert_int_equal(nsdae_sim_create(f.system, NULL, &f.sim, NULL), NSDAE_OK);
  assert_int_equal(nsdae_trajectory_create(f.sim, path, &info, &file, &error), NSDAE_E_ARGUMENT);
  assert_string_equal(error.where, "nsdae_trajectory_create");
  assert_string_equal(error.argument, "position");
  assert_non_null(strstr(error.text, "body 0 'faulty'"));
  assert_null(file);
  nsdae_sim_destroy(&f.sim);
  nsdae_system_destroy(&f.system);
}

int main(void)
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(are_in_the_file), cmocka_unit_test(are_named_once_and_first),
      cmocka_unit_test(faults_are_named), cmocka_unit_test(system_has_them),
      cmocka_unit_test(faults_of_the_system)};
  int failed = cmocka_run_group_tests(tests, NULL, NULL);
  remove(path);
  return failed;
}
