/* Scene files: what is written is read back to the last bit, whatever the form of its settings; a
 * mechanism of it starts there. Wrong files, and seeded mutations of a good one: an error that
 * names the file and its line, or a scene that makes a system. Each allocation lost in turn. */
#include "check.h"

#include <nsdae/nsdae.h>

#include <unistd.h>

#include "allocator.h"
#include "support/random.h"

#define HEADER   "kind,size0,size1,size2,mass,I1,I2,I3,x,y,z,qw,qx,qy,qz,vx,vy,vz,w1,w2,w3\n"
#define SETTINGS "# walls: none\n# mu: 0.5\n# e_N: 0\n# g: 9.81\n# dt: 0.002\n"
#define REST     ",0.1,0.2,0.3,1,0,0,1,0,0,0,0,0,0,0,0,0\n"

enum { BODIES = 40, ROOM = 1 << 15 };

static char path[] = "/tmp/nsdae-scene-XXXXXX";

static void write_bytes(const char *text, size_t length)
{
  FILE *file = fopen(path, "wb");
  assert_non_null(file);
  assert_int_equal(fwrite(text, 1, length, file), length);
  assert_int_equal(fclose(file), 0);
}

/* ---- a round trip */

/* Kinds with the number of their sizes; of a regular polyhedron corners and edges of a corner. */
static const struct {
  const char *name;
  int shape, sizes, corners, edges;
} kinds[] = {{"sphere", NSDAE_SHAPE_SPHERE, 1, 0, 0},
             {"capsule", NSDAE_SHAPE_CAPSULE, 2, 0, 0},
             {"box", NSDAE_SHAPE_BOX, 3, 0, 0},
             {"cylinder", NSDAE_SHAPE_CYLINDER, 2, 0, 0},
             {"cone", NSDAE_SHAPE_CONE, 2, 0, 0},
             {"ellipsoid", NSDAE_SHAPE_ELLIPSOID, 3, 0, 0},
             {"tetrahedron", NSDAE_SHAPE_POLYHEDRON, 1, 4, 3},
             {"octahedron", NSDAE_SHAPE_POLYHEDRON, 1, 6, 4},
             {"icosahedron", NSDAE_SHAPE_POLYHEDRON, 1, 12, 5},
             {"dodecahedron", NSDAE_SHAPE_POLYHEDRON, 1, 20, 3}};
enum { KINDS = sizeof kinds / sizeof *kinds };

/* value[20]: the kind */
static int add_row(char *text, uint64_t *seed, double value[21])
{
  int kind = random_below(seed, KINDS), at = sprintf(text, "%s", kinds[kind].name);
  value[20] = kind;
  for (int j = 0; j < 20; j++) {
    value[j] = j < 4   ? random_between(seed, 0.01, 2)
               : j < 7 ? random_between(seed, 1, 2) /* moments that a body has */
                       : random_between(seed, -1, 1);
    if (j < 3 && j >= kinds[kind].sizes) value[j] = 0;
    at += sprintf(text + at, j % 3 ? ",%.17g" : " ,\t%.17g", value[j]);
  }
  return at + sprintf(text + at, "%s", random_below(seed, 2) ? "\r\n" : "\n");
}

static int write_scene(char *text, uint64_t *seed, int words, double value[BODIES][21])
{
  int at = sprintf(text, "\xEF\xBB\xBF# %d bodies, mu 3: no setting\n", BODIES);
  if (words)
    at += sprintf(text + at, "#  walls: planes at x, y = -1.5 and +2.5, floor z = -0.25; mu 0.3, "
                             "e_N 0.1, g 9.5 along -z, dt 0.004\n");
  at += sprintf(text + at, HEADER);
  for (int i = 0; i < BODIES; i++) at += add_row(text + at, seed, value[i]);
  if (!words)
    at += sprintf(text + at, "\n# walls: -1.5 2.5\n#floor: -0.25\n# mu:0.3\n# e_N = : 0.1\n# dt: "
                             "0.004, g: 9.5\n#e_N: 0.1");
  write_bytes(text, (size_t)at);
  return at;
}

/* A polyhedron is regular if its corners are on a sphere, and each has as many nearest neighbours
 * as edges. */
static void check_regular(const nsdae_solid *s, double radius, int edges)
{
  for (int i = 0; i < s->points; i++) {
    double least = INFINITY;
    int count = 0;
    for (int round = 0; round < 2; round++)
      for (int j = 0; j < s->points; j++) {
        double x[3];
        for (int l = 0; l < 3; l++) x[l] = s->point[3 * i + l] - s->point[3 * j + l];
        double away = sqrt(x[0] * x[0] + x[1] * x[1] + x[2] * x[2]);
        if (j != i && round == 0) least = fmin(least, away);
        count += round == 1 && fabs(away - least) < 1e-12;
      }
    assert_true(least > 0.5 * radius);
    assert_int_equal(count, edges);
    assert_near(hypot(hypot(s->point[3 * i], s->point[3 * i + 1]), s->point[3 * i + 2]), radius,
                1e-15 * 4);
  }
}

static void check_body(const nsdae_scene *s, int i, const double value[21])
{
  const nsdae_rigid_body *b = &s->body[i];
  const nsdae_solid *solid = &s->solid[i];
  const int kind = (int)value[20], three = kinds[kind].sizes == 3, two = kinds[kind].sizes == 2;
  assert_int_equal(solid->shape, kinds[kind].shape);
  assert_int_equal(solid->points, kinds[kind].corners);
  if (solid->points > 0) check_regular(solid, value[0], kinds[kind].edges);
  const double size[3] = {three               ? solid->length[0]
                          : solid->points > 0 ? value[0]
                                              : solid->radius,
                          three ? solid->length[1] : two * solid->length[2],
                          three * solid->length[2]};
  assert_memory_equal(size, value, sizeof size);
  assert_true(b->mass == value[3]);
  assert_memory_equal(b->inertia, value + 4, sizeof b->inertia);
  assert_memory_equal(b->position, value + 7, sizeof b->position);
  assert_memory_equal(b->quaternion, value + 10, sizeof b->quaternion);
  assert_memory_equal(b->velocity, value + 14, sizeof b->velocity);
  assert_memory_equal(b->spin, value + 17, sizeof b->spin);
}

/* q and v at the start: position, the quaternion's direction, velocity, spin. */
static void check_start(const nsdae_scene *s)
{
  static double q[7 * BODIES], v[6 * BODIES];
  nsdae_bodies *b;
  nsdae_system *system;
  assert_int_equal(nsdae_bodies_create(3, &b, NULL), NSDAE_OK);
  assert_int_equal(nsdae_bodies_add_scene(b, s), NSDAE_OK);
  assert_true(nsdae_bodies_system(b, &system) >= 0);
  assert_int_equal(nsdae_bodies_get_start(b, q, v), NSDAE_OK);
  for (int i = 0; i < s->bodies; i++) {
    const double *p = s->body[i].quaternion;
    double norm = sqrt(p[0] * p[0] + p[1] * p[1] + p[2] * p[2] + p[3] * p[3]);
    assert_memory_equal(q + 7 * i, s->body[i].position, 3 * sizeof *q);
    for (int j = 0; j < 4; j++) assert_near(q[7 * i + 3 + j], p[j] / norm, 1e-15);
    assert_memory_equal(v + 6 * i, s->body[i].velocity, 3 * sizeof *v);
    assert_memory_equal(v + 6 * i + 3, s->body[i].spin, 3 * sizeof *v);
  }
  nsdae_system_destroy(&system);
  nsdae_bodies_destroy(&b);
}

static void reads_what_was_written(void **state)
{
  static char text[ROOM];
  static double value[BODIES][21];
  uint64_t seed = 1;
  (void)state;
  for (int words = 0; words < 2; words++) {
    nsdae_scene s;
    nsdae_error error;
    write_scene(text, &seed, words, value);
    if (nsdae_scene_read(path, &s, &error) < 0) fail_msg("%s", error.text);
    assert_int_equal(s.bodies, BODIES);
    for (int i = 0; i < BODIES; i++) check_body(&s, i, value[i]);
    assert_true(s.wall[0] == -1.5 && s.wall[1] == 2.5 && s.floor == -0.25);
    assert_true(s.mu == 0.3 && s.e_n == 0.1 && s.g == 9.5 && s.dt == 0.004);
    check_start(&s);
    nsdae_scene_release(&s);
    assert_null(s.body);
  }
}

/* Mass and moments of the bodies of data/make_scene.py are those of the density of 1000. */
static void masses_are_those_of_the_shapes(void **state)
{
  const double density = 1000;
  nsdae_scene s;
  nsdae_error error;
  (void)state;
  if (nsdae_scene_read(NSDAE_DATA_DIR "/scene_shapes.csv", &s, &error) < 0)
    fail_msg("%s", error.text);
  for (int i = 0; i < s.bodies; i++) {
    nsdae_rigid_body body = {.mass = 0};
    nsdae_solid solid = s.solid[i];
    assert_int_equal(nsdae_body_from_solids(1, &solid, &density, &body, NULL), NSDAE_OK);
    assert_near(body.mass / s.body[i].mass, 1, 1e-8);
    for (int j = 0; j < 3; j++) {
      assert_near(body.inertia[j] / s.body[i].inertia[j], 1, 1e-8);
      assert_near(body.position[j], 0, 1e-15);
    }
  }
  nsdae_scene_release(&s);
}

/* Five spheres, each 1 mm from one plane and moving towards it, stop at it: each plane is in its
 * place, with its material on the outer side. */
static void planes_are_in_place(void **state)
{
  static const double place[5][3] = {
      {-0.899, 0, 1}, {1.899, 0, 1}, {0, -0.899, 1}, {0, 1.899, 1}, {1, 1, 0.351}};
  char text[4096];
  int at = sprintf(text, "# walls: -1 2\n# floor: 0.25\n# mu: 0, e_N: 0, g: 0, dt: 0.001\n" HEADER);
  nsdae_scene s;
  nsdae_bodies *b;
  nsdae_system *system;
  nsdae_sim *sim;
  nsdae_record r;
  double q[35], v[30];
  (void)state;
  for (int i = 0; i < 5; i++) {
    double speed[3] = {0, 0, 0};
    speed[i / 2] = i == 1 || i == 3 ? 2 : -2;
    at += sprintf(text + at, "sphere,0.1,0,0,1,1,1,1,%g,%g,%g,1,0,0,0,%g,%g,%g,0,0,0\n",
                  place[i][0], place[i][1], place[i][2], speed[0], speed[1], speed[2]);
  }
  write_bytes(text, (size_t)at);
  assert_int_equal(nsdae_scene_read(path, &s, NULL), NSDAE_OK);
  assert_int_equal(nsdae_bodies_create(3, &b, NULL), NSDAE_OK);
  nsdae_bodies_add_scene(b, &s);
  nsdae_scene_release(&s); /* it is copied */
  assert_true(nsdae_bodies_system(b, &system) >= 0);
  nsdae_bodies_get_start(b, q, v);
  assert_int_equal(nsdae_sim_create(system, NULL, &sim, NULL), NSDAE_OK);
  assert_int_equal(nsdae_sim_init(sim, 0, q, v), NSDAE_OK);
  assert_true(nsdae_sim_run(sim, 0.01) >= 0);
  nsdae_sim_get_record(sim, &r);
  for (int i = 0; i < 5; i++) /* stopped at a plane: |gap| at most a step of travel */
    for (int j = 0; j < 3; j++) {
      double out = i / 2 == j ? (i == 1 || i == 3 ? 0.001 : -0.001) : 0;
      assert_near(r.q[7 * i + j], place[i][j] + out, i / 2 == j ? 0.0021 : 1e-12);
      assert_near(r.v[6 * i + j], 0, 1e-9);
    }
  nsdae_sim_destroy(&sim);
  nsdae_system_destroy(&system);
  nsdae_bodies_destroy(&b);
}

/* ---- wrong files */

static const struct {
  const char *text, *words;
} wrong[] = {
    {"", "line 0: the file ends without the setting walls: add a line '# walls: none'"},
    {SETTINGS HEADER, "line 6: the file ends without a body"},
    {SETTINGS "sphere,1\n", "line 6: 2 columns: a line has 21"},
    {SETTINGS "\n\nsphere\n", "line 8: 1 column: a line has 21"},
    {SETTINGS "sphere,1,0,0,1" REST, "line 6, column 1 (kind): 'sphere' in the header"},
    {SETTINGS HEADER "torus,1,0,0,1" REST, "line 7, column 1 (kind): kind has no choice 'torus'"},
    {SETTINGS HEADER "cone,1,0,0,1" REST, "size1 = 0 of a cone must be greater than 0"},
    {SETTINGS HEADER "octahedron,1,1,0,1" REST, "size1 = 1 of an octahedron must be 0"},
    {SETTINGS HEADER "spere,1,0,0,1" REST, "did you mean 'sphere'?"},
    {SETTINGS HEADER "sphere,1,0,0,-2" REST, "line 7, column 5 (mass): mass = -2 is outside its"},
    {SETTINGS HEADER "sphere,1,0,0,0" REST, "mass = 0 is outside its range: it must be greater"},
    {SETTINGS HEADER "sphere,1,0,0,nan" REST, "column 5 (mass): mass = nan is outside"},
    {SETTINGS HEADER "sphere,inf,0,0,1" REST, "column 2 (size0): size0 = inf is outside"},
    {SETTINGS HEADER "sphere,one,0,0,1" REST, "column 2 (size0): size0 = 'one' is not a number"},
    {SETTINGS HEADER "sphere,,0,0,1" REST, "column 2 (size0): size0 = '' is not a number"},
    {SETTINGS HEADER "sphere,1e,0,0,1" REST, "size0 = '1e' is not a number"},
    {SETTINGS HEADER "sphere,0,0,0,1" REST, "size0 = 0 of a sphere must be greater than 0"},
    {SETTINGS HEADER "sphere,1,2,0,1" REST, "size1 = 2 of a sphere must be 0"},
    {SETTINGS HEADER "capsule,1,0,0,1" REST, "size1 = 0 of a capsule must be greater than 0"},
    {SETTINGS HEADER "capsule,1,1,1,1" REST, "size2 = 1 of a capsule must be 0"},
    {SETTINGS HEADER "box,1,1,-1,1" REST, "column 4 (size2): size2 = -1 of a box"},
    {SETTINGS HEADER "box,1,1,1,1,1,1,1,0,0,0,0,0,0,0,0,0,0,0,0,0\n", "column 12 (qw)"},
    {SETTINGS HEADER "box,1,1,1,1,1,1,1,0,0,0,1,0,0,0,0,0,0,0,0\n", "20 columns"},
    {SETTINGS HEADER "box,1,1,1,1,1,1,1,0,0,0,1,0,0,0,0,0,0,0,0,0,\n", "22 columns"},
    {"# walls: none\n# mu: 0.5\n# g: 9.81\n# dt: 0.002\n" HEADER, "without the setting e_N"},
    {"# mu: 0.5 0.6\n", "line 1: the number 0.6 belongs to no setting"},
    {"# mu: high\n", "line 1: mu lacks a number: it needs one"},
    {"# mu: -0.5\n", "line 1: mu = -0.5 is outside its range: it must be at least 0"},
    {"# e_N: 2\n", "e_N = 2 is outside its range: it must be at least 0 and at most 1"},
    {"# dt: 0\n", "dt = 0 is outside its range"},
    {"# mu: e_N 0\n", "mu has no number before 'e_N'"},
    {"# mu: 1\n\n# mu: 2\n", "line 3: mu is given twice"},
    {"# walls: 3\n", "walls lacks a number: it needs two, or the word none"},
    {"# walls: 3 -3\n# mu: 0, e_N 0, g 1, dt 1\n" HEADER, "walls at 3 and -3: the first must be"},
    {"# walls: nan 1\n", "line 1: walls = nan is outside"},
};

static void wrong_files_have_errors(void **state)
{
  (void)state;
  for (size_t i = 0; i < sizeof wrong / sizeof *wrong; i++) {
    nsdae_scene s;
    nsdae_error error;
    write_bytes(wrong[i].text, strlen(wrong[i].text));
    int status = nsdae_scene_read(path, &s, &error);
    if (status != NSDAE_E_ARGUMENT || !strstr(error.text, wrong[i].words) ||
        !strstr(error.text, path))
      fail_msg("%s: %d, %s", wrong[i].text, status, error.text);
    assert_int_equal(error.status, status);
    assert_null(s.body);
    assert_null(s.solid);
    assert_int_equal(s.bodies, 0);
  }
}

static void expect(const char *name, int status, const char *words)
{
  nsdae_scene s;
  nsdae_error error;
  assert_int_equal(nsdae_scene_read(name, &s, &error), status);
  if (!strstr(error.text, words)) fail_msg("%s", error.text);
  assert_null(s.body);
}

static void strange_files_have_errors(void **state)
{
  const size_t length = 10 << 20;
  char *line = malloc(length);
  nsdae_scene s;
  nsdae_error error;
  (void)state;
  expect("/no/such/file.csv", NSDAE_E_IO, "cannot read '/no/such/file.csv'");
  expect("/tmp", NSDAE_E_IO, "cannot read '/tmp'");
  assert_non_null(line);
  memset(line, '1', length);
  write_bytes(line, length);
  expect(path, NSDAE_E_ARGUMENT, "line 1: more than 4095 characters");
  memset(line, '\n', length); /* lines without end, and nothing in them */
  write_bytes(line, length);
  expect(path, NSDAE_E_ARGUMENT, "line 10485760: the file ends without the setting walls");
  free(line);
  write_bytes(SETTINGS HEADER "box\0,1", sizeof SETTINGS HEADER "box\0,1");
  expect(path, NSDAE_E_ARGUMENT, "line 7: a NUL byte");
  assert_int_equal(nsdae_scene_read(NULL, &s, &error), NSDAE_E_ARGUMENT);
  assert_int_equal(nsdae_scene_read(path, NULL, NULL), NSDAE_E_ARGUMENT);
  nsdae_scene_release(NULL);
}

static void wrong_structs_have_errors(void **state)
{
  nsdae_rigid_body body = {.mass = -1, .inertia = {1, 1, 1}};
  nsdae_solid solid = {.shape = NSDAE_SHAPE_SPHERE, .radius = 1, .material = 1};
  const nsdae_scene s = {.bodies = 1, .body = &body, .solid = &solid, .wall = {-1, 1}, .dt = 0.01};
  nsdae_bodies *b;
  (void)state;
  assert_int_equal(nsdae_bodies_add_scene(NULL, &s), NSDAE_E_ARGUMENT);
  for (int dimension = 2; dimension < 4; dimension++) {
    assert_int_equal(nsdae_bodies_create(dimension, &b, NULL), NSDAE_OK);
    assert_true(nsdae_bodies_add_scene(b, dimension == 2 ? &s : NULL) < 0);
    assert_true(nsdae_bodies_error(b)->text[0] != '\0');
    nsdae_bodies_destroy(&b);
  }
  assert_int_equal(nsdae_bodies_create(3, &b, NULL), NSDAE_OK);
  assert_int_equal(nsdae_bodies_add_scene(b, &s), NSDAE_E_ARGUMENT);
  assert_non_null(strstr(nsdae_bodies_error(b)->text, "body 0: mass = -1"));
  nsdae_bodies_destroy(&b);
}

static void refuse_struct(int dimension, nsdae_scene s, const char *argument, const char *words)
{
  nsdae_bodies *b;
  assert_int_equal(nsdae_bodies_create(dimension, &b, NULL), NSDAE_OK);
  assert_int_equal(nsdae_bodies_add_scene(b, &s), NSDAE_E_ARGUMENT);
  assert_string_equal(nsdae_bodies_error(b)->argument, argument);
  if (!strstr(nsdae_bodies_error(b)->text, words)) fail_msg("%s", nsdae_bodies_error(b)->text);
  nsdae_bodies_destroy(&b);
}

/* A struct has the bounds of a file. */
static void structs_are_checked(void **state)
{
  nsdae_rigid_body body = {.mass = 1, .inertia = {1, 1, 1}};
  nsdae_solid solid = {.shape = NSDAE_SHAPE_SPHERE, .radius = 1, .material = 1};
  const nsdae_scene good = {
      .bodies = 1, .body = &body, .solid = &solid, .wall = {-INFINITY, INFINITY}, .dt = 0.01};
  nsdae_scene s = good;
  nsdae_bodies *b;
  (void)state;
  assert_int_equal(nsdae_bodies_create(3, &b, NULL), NSDAE_OK);
  assert_int_equal(nsdae_bodies_add_scene(b, &s), NSDAE_OK);
  nsdae_bodies_destroy(&b);
  refuse_struct(2, s, "dimension", "dimension = 2: a scene needs");
  s.bodies = -3, refuse_struct(3, s, "bodies", "bodies = -3 must be at least 0"), s = good;
  s.body = NULL, refuse_struct(3, s, "body", "NULL"), s = good;
  s.solid = NULL, refuse_struct(3, s, "solid", "NULL"), s = good;
  s.wall[0] = 3, s.wall[1] = -3, refuse_struct(3, s, "wall", "wall[0] = 3 must be below"), s = good;
  s.wall[0] = s.wall[1] = 0, refuse_struct(3, s, "wall", "wall[0] = 0 must be below"), s = good;
  s.wall[1] = NAN, refuse_struct(3, s, "wall", "wall[1] = nan"), s = good;
  s.floor = NAN, refuse_struct(3, s, "floor", "floor = nan"), s = good;
  s.floor = -INFINITY, refuse_struct(3, s, "floor", "floor = -inf"), s = good;
  s.mu = -1, refuse_struct(3, s, "mu", "mu = -1"), s = good;
  s.e_n = 2, refuse_struct(3, s, "e_N", "at most 1"), s = good;
  s.g = -9.81, refuse_struct(3, s, "g", "at least 0"), s = good;
  s.dt = 0, refuse_struct(3, s, "dt", "greater than 0");
}

/* ---- mutations */

/* Some edits of a text: bytes changed, inserted, removed, lines cut or doubled. */
static int mutate(char *text, int length, uint64_t *seed)
{
  static const char letters[] = ",,,;:#\n\n\r\t -+.0123456789eEinfa\"\xEF\xFF\1";
  for (int edits = 1 + random_below(seed, 4); edits > 0 && length > 1; edits--) {
    int at = random_below(seed, length), kind = random_below(seed, 4);
    int some = 1 + random_below(seed, 20);
    if (some > length - at) some = length - at;
    char c = letters[random_below(seed, (int)sizeof letters)]; /* and NUL */
    if (kind == 0) text[at] = c;
    if (kind == 1) { /* removed */
      memmove(text + at, text + at + some, (size_t)(length - at - some));
      length -= some;
    }
    if (kind == 2) { /* doubled */
      memmove(text + at + some, text + at, (size_t)(length - at));
      length += some;
    }
    if (kind == 3 && random_below(seed, 4) == 0) length = at;
  }
  return length;
}

static void make_system(const nsdae_scene *s)
{
  nsdae_bodies *b;
  nsdae_system *system = NULL;
  assert_int_equal(nsdae_bodies_create(3, &b, NULL), NSDAE_OK);
  if (nsdae_bodies_add_scene(b, s) < 0 || nsdae_bodies_system(b, &system) < 0)
    fail_msg("%s", nsdae_bodies_error(b)->text);
  nsdae_system_destroy(&system);
  nsdae_bodies_destroy(&b);
}

static void mutations_are_errors_or_scenes(void **state)
{
  static char good[ROOM], text[2 * ROOM];
  static double value[BODIES][21];
  uint64_t seed = 7;
  int scenes = 0, errors = 0;
  (void)state;
  for (int i = 0; i < 3000; i++) {
    if (i % 100 == 0) write_scene(good, &seed, i / 100 % 2, value);
    int length = (int)strlen(good);
    if (i % 2)
      length = (int)(strchr(strstr(good, HEADER) + sizeof HEADER, '\n') - good); /* short */
    memcpy(text, good, (size_t)length);
    write_bytes(text, (size_t)mutate(text, length, &seed));
    nsdae_scene s;
    nsdae_error error;
    allocator_reset(-1);
    if (nsdae_scene_read(path, &s, &error) == NSDAE_OK) {
      make_system(&s);
      scenes++;
    } else {
      assert_true(error.status == NSDAE_E_ARGUMENT && strstr(error.text, " line "));
      assert_int_equal(s.bodies, 0);
      errors++;
    }
    nsdae_scene_release(&s);
    assert_int_equal(the_allocator.live, 0);
  }
  print_message("%d scenes, %d errors\n", scenes, errors);
  assert_true(scenes > 100 && errors > 1000);
}

static void lost_allocations(void **state)
{
  static char text[ROOM];
  static double value[BODIES][21];
  uint64_t seed = 3;
  int status = NSDAE_E_MEMORY, lost = -1;
  (void)state;
  write_scene(text, &seed, 1, value);
  for (long i = 0; status < 0; i++, lost++) {
    nsdae_scene s;
    nsdae_error error;
    allocator_reset(i);
    status = nsdae_scene_read(path, &s, &error);
    if (status < 0) {
      assert_true(status == NSDAE_E_MEMORY || status == NSDAE_E_IO); /* IO: the stream of fopen */
      assert_null(s.body);
    }
    nsdae_scene_release(&s);
    assert_int_equal(the_allocator.live, 0);
  }
  assert_true(lost >= 2);
  allocator_reset(-1);
}

int main(void)
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(reads_what_was_written),
      cmocka_unit_test(planes_are_in_place),
      cmocka_unit_test(masses_are_those_of_the_shapes),
      cmocka_unit_test(wrong_files_have_errors),
      cmocka_unit_test(strange_files_have_errors),
      cmocka_unit_test(wrong_structs_have_errors),
      cmocka_unit_test(structs_are_checked),
      cmocka_unit_test(mutations_are_errors_or_scenes),
      cmocka_unit_test(lost_allocations),
  };
  int file = mkstemp(path);
  if (file < 0) return 77;
  close(file);
  int failed = cmocka_run_group_tests(tests, NULL, NULL);
  remove(path);
  return failed;
}
