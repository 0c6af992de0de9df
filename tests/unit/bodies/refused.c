/* What the kit refuses: each wrong number is named with its value and its bound, the first one
 * stays, and lost memory is said. */
#include "check.h"

#include <nsdae/nsdae.h>

static const nsdae_rigid_body good = {.mass = 1, .inertia = {1, 1, 1}};

static nsdae_bodies *world(int d)
{
  nsdae_bodies *b;
  assert_int_equal(nsdae_bodies_create(d, &b, NULL), NSDAE_OK);
  for (int i = 0; i < 2; i++) assert_int_equal(nsdae_bodies_add(b, &good), i);
  return b;
}

static const char *words; /* that the text of the next refusal contains, or NULL */

/* The call was refused for this argument; everything after it is too, with the same record. */
static void expect(nsdae_bodies *b, int returned, int status, const char *argument)
{
  nsdae_system *system;
  const nsdae_error *error = nsdae_bodies_error(b);
  assert_int_equal(returned, status);
  assert_int_equal(error->status, status);
  assert_string_equal(error->argument, argument);
  assert_true(strlen(error->text) > 10);
  if (words && !strstr(error->text, words)) fail_msg("%s", error->text);
  words = NULL;
  assert_int_equal(nsdae_bodies_add(b, &good), status);
  assert_int_equal(nsdae_bodies_system(b, &system), status);
  assert_null(system);
  assert_string_equal(error->argument, argument);
  nsdae_bodies_destroy(&b);
  assert_null(b);
}

static void test_create(void **state)
{
  nsdae_bodies *b;
  nsdae_error error;
  nsdae_system *system;
  (void)state;
  assert_int_equal(nsdae_bodies_create(4, &b, &error), NSDAE_E_ARGUMENT);
  assert_null(b);
  assert_string_equal(error.argument, "dimension");
  assert_int_equal(nsdae_bodies_create(2, NULL, &error), NSDAE_E_ARGUMENT);
  assert_int_equal(nsdae_bodies_add(NULL, &good), NSDAE_E_ARGUMENT);
  assert_int_equal(nsdae_bodies_error(NULL)->status, NSDAE_E_ARGUMENT);
  nsdae_bodies_destroy(NULL);
  assert_int_equal(nsdae_bodies_create(2, &b, NULL), NSDAE_OK);
  assert_int_equal(nsdae_bodies_system(b, &system), NSDAE_E_STATE);
  nsdae_bodies_destroy(&b);
}

static void test_bodies(void **state)
{
  (void)state;
  const double bad[] = {0, -1, NAN, INFINITY};
  for (int i = 0; i < 4; i++) {
    nsdae_rigid_body body = good;
    body.mass = bad[i];
    nsdae_bodies *b = world(2);
    expect(b, nsdae_bodies_add(b, &body), NSDAE_E_ARGUMENT, "mass");
    body = good;
    body.inertia[2] = bad[i];
    b = world(2);
    expect(b, nsdae_bodies_add(b, &body), NSDAE_E_ARGUMENT, "inertia");
  }
  nsdae_rigid_body body = good;
  body.position[2] = 1;
  nsdae_bodies *b = world(2);
  expect(b, nsdae_bodies_add(b, &body), NSDAE_E_ARGUMENT, "position");
  body = good;
  body.spin[0] = NAN;
  b = world(3);
  expect(b, nsdae_bodies_add(b, &body), NSDAE_E_NONFINITE, "spin");
  body = good;
  body.quaternion[1] = INFINITY;
  b = world(3);
  expect(b, nsdae_bodies_add(b, &body), NSDAE_E_NONFINITE, "quaternion");
  b = world(3);
  expect(b, nsdae_bodies_add(b, NULL), NSDAE_E_ARGUMENT, "body");
}

static int drive(double t, double f[3], void *user)
{
  (void)t;
  (void)f;
  (void)user;
  return 0;
}

static void refuse_joint(int d, nsdae_joint joint, const char *argument)
{
  nsdae_bodies *b = world(d);
  expect(b, nsdae_bodies_add_joint(b, &joint), NSDAE_E_ARGUMENT, argument);
}

/* Rotations of the other dimension; (w, 0, 0, 0) is none. */
static void test_rotations(void **state)
{
  (void)state;
  for (int d = 2; d <= 3; d++)
    for (int wrong = 0; wrong <= 1; wrong++) {
      const char *argument = d == 2 ? "quaternion" : "angle";
      nsdae_rigid_body body = {.mass = 1, .inertia = {1, 1, 1}, .quaternion = {0.5}};
      nsdae_solid solid = {.shape = NSDAE_SHAPE_POINT, .quaternion = {0.5}};
      body.quaternion[d == 2 && wrong] = solid.quaternion[d == 2 && wrong] = 0.5;
      body.angle = solid.angle = d == 3 && wrong;
      nsdae_bodies *b = world(d);
      if (wrong) {
        expect(b, nsdae_bodies_add(b, &body), NSDAE_E_ARGUMENT, argument);
        b = world(d);
        expect(b, nsdae_bodies_add_solid(b, 0, &solid), NSDAE_E_ARGUMENT, argument);
        continue;
      }
      assert_true(nsdae_bodies_add(b, &body) >= 0 && nsdae_bodies_add_solid(b, 0, &solid) >= 0);
      nsdae_bodies_destroy(&b);
    }
}

static void test_joints(void **state)
{
  (void)state;
  refuse_joint(2, (nsdae_joint){.kind = 99, .body = {0, 1}}, "kind");
  refuse_joint(2, (nsdae_joint){.kind = NSDAE_JOINT_SPHERICAL, .body = {0, 1}}, "kind");
  refuse_joint(3, (nsdae_joint){.kind = NSDAE_JOINT_GEAR, .body = {0, 1}}, "kind");
  refuse_joint(2, (nsdae_joint){.kind = NSDAE_JOINT_REVOLUTE, .body = {0, 2}}, "body");
  refuse_joint(2, (nsdae_joint){.kind = NSDAE_JOINT_REVOLUTE, .body = {-2, 1}}, "body");
  refuse_joint(2, (nsdae_joint){.kind = NSDAE_JOINT_REVOLUTE, .body = {1, 1}}, "body");
  refuse_joint(2, (nsdae_joint){.kind = NSDAE_JOINT_WELD, .body = {0, 1}, .drive = drive}, "drive");
  refuse_joint(3, (nsdae_joint){.kind = NSDAE_JOINT_SPHERICAL, .body = {0, 1}, .drive = drive},
               "drive");
  refuse_joint(
      2,
      (nsdae_joint){
          .kind = NSDAE_JOINT_SLOT, .body = {0, 1}, .axis = {1, 0}, .mu = 0.1, .drive = drive},
      "mu");
  refuse_joint(2, (nsdae_joint){.kind = NSDAE_JOINT_PRISMATIC, .body = {0, 1}}, "axis");
  refuse_joint(3, (nsdae_joint){.kind = NSDAE_JOINT_REVOLUTE, .body = {0, 1}}, "axis");
  refuse_joint(2, (nsdae_joint){.kind = NSDAE_JOINT_GEAR, .body = {0, 1}}, "ratio");
  refuse_joint(3, (nsdae_joint){.kind = NSDAE_JOINT_SCREW, .body = {0, 1}, .axis = {1}}, "ratio");
  refuse_joint(2, (nsdae_joint){.kind = NSDAE_JOINT_DISTANCE, .body = {0, 1}}, "end");
  refuse_joint(2, (nsdae_joint){.kind = NSDAE_JOINT_REVOLUTE, .body = {0, 1}, .mu = 0.1}, "radius");
  refuse_joint(2, (nsdae_joint){.kind = NSDAE_JOINT_REVOLUTE, .body = {0, 1}, .mu = -0.1}, "mu");
  refuse_joint(2, (nsdae_joint){.kind = NSDAE_JOINT_WELD, .body = {0, 1}, .mu = 0.1}, "mu");
  refuse_joint(2, (nsdae_joint){.kind = NSDAE_JOINT_WELD, .body = {0, 1}, .radius = 0.1}, "radius");
  refuse_joint(
      2, (nsdae_joint){.kind = NSDAE_JOINT_SLOT, .body = {0, 1}, .axis = {1, 0}, .mu = -0.1}, "mu");
  refuse_joint(2, (nsdae_joint){.kind = NSDAE_JOINT_WELD, .body = {0, 1}, .point = {0, 0, 1}},
               "point");
  refuse_joint(
      3,
      (nsdae_joint){
          .kind = NSDAE_JOINT_UNIVERSAL, .body = {0, 1}, .axis = {1, 0, 0}, .cross = {1, 1, 0}},
      "cross");
}

/* ---- parts of joints: a revolute joint 0, a spherical joint 1 in space, a weld in the plane */

static nsdae_bodies *jointed(int d)
{
  nsdae_bodies *b = world(d);
  nsdae_joint j = {.kind = NSDAE_JOINT_REVOLUTE, .body = {0, 1}, .axis = {0, 0, d == 3}};
  assert_int_equal(nsdae_bodies_add_joint(b, &j), 0);
  j.kind = d == 2 ? NSDAE_JOINT_WELD : NSDAE_JOINT_SPHERICAL;
  assert_int_equal(nsdae_bodies_add_joint(b, &j), 1);
  j.kind = NSDAE_JOINT_REVOLUTE;
  assert_int_equal(nsdae_bodies_add_joint(b, &j), 2);
  return b;
}

static void refuse_limit(int d, nsdae_limit l, const char *argument)
{
  nsdae_bodies *b = jointed(d);
  expect(b, nsdae_bodies_add_limit(b, &l), NSDAE_E_ARGUMENT, argument);
}

static void test_limits(void **state)
{
  (void)state;
  for (int d = 2; d <= 3; d++) {
    refuse_limit(d, (nsdae_limit){3, 0, -1, 1, 0}, "joint");
    refuse_limit(d, (nsdae_limit){-1, 0, -1, 1, 0}, "joint");
    refuse_limit(d, (nsdae_limit){0, 1, -1, 1, 0}, "coordinate");
    refuse_limit(d, (nsdae_limit){0, -1, -1, 1, 0}, "coordinate");
    refuse_limit(d, (nsdae_limit){1, 0, -1, 1, 0}, "coordinate");
    refuse_limit(d, (nsdae_limit){0, 0, 1, 1, 0}, "low");
    refuse_limit(d, (nsdae_limit){0, 0, NAN, 1, 0}, "low");
    refuse_limit(d, (nsdae_limit){0, 0, -INFINITY, INFINITY, 0}, "low");
    refuse_limit(d, (nsdae_limit){0, 0, -1, 1, 1.5}, "e_n");
    refuse_limit(d, (nsdae_limit){0, 0, -1, 1, NAN}, "e_n");
  }
  words = "limit 0: high = nan is not a number";
  refuse_limit(3, (nsdae_limit){0, 0, -1, NAN, 0}, "high");
  refuse_limit(3, (nsdae_limit){0, 0, -1, INFINITY, 0}, "high");
  refuse_limit(3, (nsdae_limit){0, 0, -3.2, 3.2, 0}, "high");
  nsdae_bodies *b = jointed(2);
  expect(b, nsdae_bodies_add_limit(b, NULL), NSDAE_E_ARGUMENT, "limit");
}

static void refuse_rope(nsdae_rope r, int status, const char *argument)
{
  nsdae_bodies *b = world(2);
  expect(b, nsdae_bodies_add_rope(b, &r), status, argument);
}

static void test_ropes(void **state)
{
  (void)state;
  refuse_rope((nsdae_rope){.body = {1, 1}, .length = 1}, NSDAE_E_ARGUMENT, "body");
  words = "rope 0: body = 2 is not a body: there are 2";
  refuse_rope((nsdae_rope){.body = {0, 2}, .length = 1}, NSDAE_E_ARGUMENT, "body");
  refuse_rope((nsdae_rope){.body = {0, 1}}, NSDAE_E_ARGUMENT, "length");
  words = "rope 0: length = inf is not a finite number above 0";
  refuse_rope((nsdae_rope){.body = {0, 1}, .length = INFINITY}, NSDAE_E_ARGUMENT, "length");
  refuse_rope((nsdae_rope){.body = {0, 1}, .length = 1, .e_n = -1}, NSDAE_E_ARGUMENT, "e_n");
  refuse_rope((nsdae_rope){.body = {0, 1}, .length = 1, .end = {0, 0, 1}}, NSDAE_E_ARGUMENT, "end");
  refuse_rope((nsdae_rope){.body = {0, 1}, .length = 1, .point = {NAN}}, NSDAE_E_NONFINITE,
              "point");
}

static void refuse_coupler(int d, nsdae_coupler c, int status, const char *argument)
{
  nsdae_bodies *b = jointed(d);
  expect(b, nsdae_bodies_add_coupler(b, &c), status, argument);
}

static void refuse_joint_spring(int d, nsdae_joint_spring s, int status, const char *argument)
{
  nsdae_bodies *b = jointed(d);
  expect(b, nsdae_bodies_add_joint_spring(b, &s), status, argument);
}

static void refuse_motor(nsdae_motor m, int status, const char *argument)
{
  nsdae_bodies *b = jointed(3);
  expect(b, nsdae_bodies_add_motor(b, &m), status, argument);
}

static void test_motors(void **state)
{
  (void)state;
  const int speed = NSDAE_MOTOR_SPEED, position = NSDAE_MOTOR_POSITION;
  refuse_motor((nsdae_motor){.joint = 3, .limit = 1}, NSDAE_E_ARGUMENT, "joint");
  refuse_motor((nsdae_motor){.joint = 1, .limit = 1}, NSDAE_E_ARGUMENT, "coordinate");
  refuse_motor((nsdae_motor){.kind = 3, .limit = 1}, NSDAE_E_ARGUMENT, "kind");
  refuse_motor((nsdae_motor){.kind = -1, .limit = 1}, NSDAE_E_ARGUMENT, "kind");
  refuse_motor((nsdae_motor){.target = NAN, .limit = 1}, NSDAE_E_NONFINITE, "target");
  refuse_motor((nsdae_motor){.target = 1}, NSDAE_E_ARGUMENT, "limit");
  refuse_motor((nsdae_motor){.limit = NAN}, NSDAE_E_ARGUMENT, "limit");
  refuse_motor((nsdae_motor){.kind = speed, .limit = INFINITY}, NSDAE_E_ARGUMENT, "limit");
  refuse_motor((nsdae_motor){.kind = speed, .limit = -1}, NSDAE_E_ARGUMENT, "limit");
  words = "limit = 0 of a speed motor with a target must be above 0";
  refuse_motor((nsdae_motor){.kind = speed, .target = 1}, NSDAE_E_ARGUMENT, "limit");
  refuse_motor((nsdae_motor){.kind = speed, .drive = drive}, NSDAE_E_ARGUMENT, "limit");
  words = "kp = 0, kd = 0 of a position motor";
  refuse_motor((nsdae_motor){.kind = position, .limit = 1}, NSDAE_E_ARGUMENT, "kp");
  refuse_motor((nsdae_motor){.kind = speed, .limit = 1, .kp = 1}, NSDAE_E_ARGUMENT, "kp");
  refuse_motor((nsdae_motor){.limit = 1, .kd = 1}, NSDAE_E_ARGUMENT, "kp");
  refuse_motor((nsdae_motor){.kind = position, .limit = 1, .kp = -1}, NSDAE_E_ARGUMENT, "kp");
  refuse_motor((nsdae_motor){.kind = position, .limit = 1, .kd = NAN}, NSDAE_E_ARGUMENT, "kd");
  refuse_motor((nsdae_motor){.kind = position, .limit = 1, .vary = drive}, NSDAE_E_ARGUMENT,
               "vary");
}

static void test_couplers(void **state)
{
  (void)state;
  for (int d = 2; d <= 3; d++) {
    refuse_coupler(d, (nsdae_coupler){.joint = {0, 3}, .p = {0, 1}}, NSDAE_E_ARGUMENT, "joint");
    refuse_coupler(d, (nsdae_coupler){.joint = {0, 0}, .p = {0, 1}}, NSDAE_E_ARGUMENT, "joint");
    refuse_coupler(d, (nsdae_coupler){.joint = {0, 1}, .p = {0, 1}}, NSDAE_E_ARGUMENT,
                   "coordinate");
    refuse_coupler(d, (nsdae_coupler){.joint = {0, 2}, .p = {1}}, NSDAE_E_ARGUMENT, "p");
    refuse_coupler(d, (nsdae_coupler){.joint = {0, 2}, .p = {NAN, 1}}, NSDAE_E_NONFINITE, "p");
    refuse_joint_spring(d, (nsdae_joint_spring){.joint = 4}, NSDAE_E_ARGUMENT, "joint");
    refuse_joint_spring(d, (nsdae_joint_spring){1, 0, 1, 1, 0}, NSDAE_E_ARGUMENT, "coordinate");
    refuse_joint_spring(d, (nsdae_joint_spring){0, 0, -1, 1, 0}, NSDAE_E_ARGUMENT, "stiffness");
    refuse_joint_spring(d, (nsdae_joint_spring){0, 0, 1, -1, 0}, NSDAE_E_ARGUMENT, "damping");
    refuse_joint_spring(d, (nsdae_joint_spring){0, 0, 1, 1, NAN}, NSDAE_E_NONFINITE, "rest");
  }
  /* gears in space have numbers of teeth */
  refuse_coupler(3, (nsdae_coupler){.joint = {0, 2}, .p = {0, 1.41421356}}, NSDAE_E_ARGUMENT, "p");
  nsdae_bodies *b = jointed(3);
  nsdae_coupler c = {.joint = {0, 2}, .p = {0, -17. / 256}};
  assert_int_equal(nsdae_bodies_add_coupler(b, &c), 0);
  nsdae_bodies_destroy(&b);
}

static void refuse_solid(int d, int body, nsdae_solid solid, const char *argument)
{
  nsdae_bodies *b = world(d);
  expect(b, nsdae_bodies_add_solid(b, body, &solid), NSDAE_E_ARGUMENT, argument);
}

static void test_solids(void **state)
{
  const double clockwise[6] = {0, 0, 0, 1, 1, 0};
  (void)state;
  refuse_solid(2, 0, (nsdae_solid){.shape = NSDAE_SHAPE_BOX}, "shape");
  refuse_solid(3, 0, (nsdae_solid){.shape = NSDAE_SHAPE_PATH}, "shape");
  refuse_solid(3, 0, (nsdae_solid){.shape = -1}, "shape");
  refuse_solid(2, 2, (nsdae_solid){.shape = NSDAE_SHAPE_POINT}, "body");
  refuse_solid(2, 0, (nsdae_solid){.shape = NSDAE_SHAPE_DISC}, "radius");
  refuse_solid(2, 0, (nsdae_solid){.shape = NSDAE_SHAPE_DISC, .radius = NAN}, "radius");
  refuse_solid(2, 0, (nsdae_solid){.shape = NSDAE_SHAPE_SEGMENT}, "length");
  refuse_solid(3, 0, (nsdae_solid){.shape = NSDAE_SHAPE_BOX, .length = {1, 1, -1}}, "length");
  refuse_solid(2, 0, (nsdae_solid){.shape = NSDAE_SHAPE_POLYGON, .points = 2}, "points");
  refuse_solid(2, 0, (nsdae_solid){.shape = NSDAE_SHAPE_POLYGON, .points = 3, .point = clockwise},
               "point");
  refuse_solid(2, 0, (nsdae_solid){.shape = NSDAE_SHAPE_POINT, .position = {0, 0, 1}}, "position");
}

static void refuse_contact(int first, int second, double mu, double e_n, const char *argument)
{
  nsdae_bodies *b = world(2);
  const nsdae_solid plane = {.shape = NSDAE_SHAPE_PLANE}, point = {.shape = NSDAE_SHAPE_POINT};
  assert_int_equal(nsdae_bodies_add_solid(b, NSDAE_GROUND, &plane), 0);
  assert_int_equal(nsdae_bodies_add_solid(b, 0, &point), 1);
  assert_int_equal(nsdae_bodies_add_solid(b, 0, &point), 2);
  assert_int_equal(nsdae_bodies_add_solid(b, 1, &plane), 3);
  expect(b, nsdae_bodies_add_contact(b, first, second, mu, e_n, 0), NSDAE_E_ARGUMENT, argument);
}

static void refuse_endless(int d, nsdae_solid solid, const char *argument)
{
  nsdae_bodies *b = world(d);
  expect(b, nsdae_bodies_add_solid(b, 0, &solid), NSDAE_E_NONFINITE, argument);
}

/* Corner i of a star of points corners that goes around turns times, each corner turning left. */
static void star_corner(int i, int points, int turns, double phase, double *x)
{
  double angle = phase + 2 * acos(-1) * turns * i / points;
  x[0] = cos(angle);
  x[1] = sin(angle);
}

/* A polygon goes around once, wherever its first corner is; stars that go around more often turn
 * left at each corner as well. */
static void test_polygons(void **state)
{
  double corner[2 * 13];
  (void)state;
  for (int points = 3; points <= 13; points++)
    for (int turns = 1; 2 * turns < points; turns++)
      for (int phase = 0; phase < 24; phase++) {
        nsdae_solid solid = {.shape = NSDAE_SHAPE_POLYGON, .points = points, .point = corner};
        for (int i = 0; i < points; i++)
          star_corner(i, points, turns, phase * acos(-1) / 12, corner + 2 * i);
        if (turns > 1) {
          refuse_solid(2, 0, solid, "point");
          continue;
        }
        nsdae_bodies *b = world(2);
        assert_int_equal(nsdae_bodies_add_solid(b, 0, &solid), 0);
        nsdae_bodies_destroy(&b);
      }
}

static void test_endless(void **state)
{
  const double corner[6] = {0, 0, 1, 0, 0, INFINITY};
  (void)state;
  refuse_endless(2, (nsdae_solid){.shape = NSDAE_SHAPE_PLANE, .angle = NAN}, "angle");
  refuse_endless(3, (nsdae_solid){.shape = NSDAE_SHAPE_PLANE, .quaternion = {1, 0, NAN}},
                 "quaternion");
  refuse_endless(3, (nsdae_solid){.shape = NSDAE_SHAPE_POINT, .quaternion = {INFINITY}},
                 "quaternion");
  refuse_endless(2, (nsdae_solid){.shape = NSDAE_SHAPE_POLYGON, .points = 3, .point = corner},
                 "point");
  /* no length is too small or too large for a quaternion */
  for (int i = 0; i < 2; i++) {
    double size = i ? 1e300 : 1e-300, least = 0.5;
    nsdae_bodies *b = world(3);
    const nsdae_rigid_body body = {
        .mass = 1, .inertia = {1, 1, 1}, .quaternion = {size, size, size, size}};
    double q[3 * 7], v[3 * 6];
    int index = nsdae_bodies_add(b, &body);
    assert_true(index >= 0);
    nsdae_bodies_get_start(b, q, v);
    for (int j = 3; j < 7; j++) assert_near(q[7 * index + j], least, 1e-15);
    nsdae_bodies_destroy(&b);
  }
}

static void test_contacts(void **state)
{
  (void)state;
  refuse_contact(0, 4, 0, 0, "solid");
  refuse_contact(-1, 1, 0, 0, "solid");
  refuse_contact(1, 2, 0, 0, "solid"); /* of one body */
  refuse_contact(0, 3, 0, 0, "solid"); /* two planes */
  refuse_contact(0, 1, -1, 0, "mu");
  refuse_contact(0, 1, 0, 1.5, "e_n");
}

static void test_forces(void **state)
{
  (void)state;
  nsdae_bodies *b = world(2);
  const nsdae_spring spring = {.body = {0, 1}, .stiffness = -1};
  expect(b, nsdae_bodies_add_spring(b, &spring), NSDAE_E_ARGUMENT, "stiffness");
  b = world(3);
  const nsdae_torsion torsion = {.body = {0, 1}, .stiffness = 1};
  expect(b, nsdae_bodies_add_torsion(b, &torsion), NSDAE_E_ARGUMENT, "axis");
  b = world(2);
  const double point[3] = {0}, gravity[3] = {0, NAN, 0};
  expect(b, nsdae_bodies_add_load(b, 0, point, NULL, NULL), NSDAE_E_ARGUMENT, "load");
  b = world(2);
  words = "bodies: gravity[1] = nan is not a finite number";
  expect(b, nsdae_bodies_set_gravity(b, gravity), NSDAE_E_NONFINITE, "gravity");
}

/* Numbers and bodies of springs and torsions, one by one. */
static void refuse_spring(nsdae_spring s, int status, const char *argument)
{
  nsdae_bodies *b = world(3);
  expect(b, nsdae_bodies_add_spring(b, &s), status, argument);
}

static void refuse_torsion(nsdae_torsion s, int status, const char *argument)
{
  nsdae_bodies *b = world(3);
  expect(b, nsdae_bodies_add_torsion(b, &s), status, argument);
}

static void test_springs(void **state)
{
  (void)state;
  refuse_spring((nsdae_spring){.body = {0, 5}}, NSDAE_E_ARGUMENT, "body");
  refuse_spring((nsdae_spring){.body = {0, 1}, .damping = NAN}, NSDAE_E_ARGUMENT, "damping");
  refuse_spring((nsdae_spring){.body = {0, 1}, .rest = -1}, NSDAE_E_ARGUMENT, "rest");
  refuse_spring((nsdae_spring){.body = {0, 1}, .point = {NAN}}, NSDAE_E_NONFINITE, "point");
  refuse_torsion((nsdae_torsion){.body = {1, 1}, .axis = {1}}, NSDAE_E_ARGUMENT, "body");
  refuse_torsion((nsdae_torsion){.body = {0, 1}, .axis = {1}, .rest = INFINITY}, NSDAE_E_NONFINITE,
                 "rest");
  words = "rest = -3.2 of a rotation in space must be -pi .. pi";
  refuse_torsion((nsdae_torsion){.body = {0, 1}, .axis = {1}, .rest = -3.2}, NSDAE_E_ARGUMENT,
                 "rest");
  refuse_joint_spring(3, (nsdae_joint_spring){.stiffness = 1, .rest = 3.2}, NSDAE_E_ARGUMENT,
                      "rest");
  refuse_torsion((nsdae_torsion){.body = {0, 1}, .axis = {INFINITY}}, NSDAE_E_NONFINITE, "axis");
}

/* In the plane it is the normal, or left out. */
static void test_axis_of_planar_torsion(void **state)
{
  (void)state;
  const double axes[][3] = {{NAN, 1, 0}, {0, 0, INFINITY}, {1, 0, 0}, {0, -1, 1}};
  for (int i = 0; i < 4; i++) {
    nsdae_torsion torsion = {.body = {0, 1}, .stiffness = 1};
    memcpy(torsion.axis, axes[i], sizeof torsion.axis);
    int status = i < 2 ? NSDAE_E_NONFINITE : NSDAE_E_ARGUMENT;
    nsdae_bodies *b = world(2);
    words = i == 3 ? "torsion 0: axis (0, -1, 1) has no effect in the plane" : NULL;
    expect(b, nsdae_bodies_add_torsion(b, &torsion), status, "axis");
  }
  nsdae_bodies *b = world(2);
  const nsdae_torsion normal = {.body = {0, 1}, .axis = {0, 0, -2}, .stiffness = 1};
  assert_int_equal(nsdae_bodies_add_torsion(b, &normal), 0);
  nsdae_bodies_destroy(&b);
}

static void test_more_solids(void **state)
{
  (void)state;
  refuse_solid(2, -2, (nsdae_solid){.shape = NSDAE_SHAPE_POINT}, "body");
  refuse_solid(2, 0, (nsdae_solid){.shape = NSDAE_SHAPE_POINT, .material = -1}, "material");
  refuse_solid(2, 0, (nsdae_solid){.shape = NSDAE_SHAPE_POINT, .material = NSDAE_MATERIALS},
               "material");
  words = "group = -1 is outside its range: it must be 0 ..";
  refuse_solid(2, 0, (nsdae_solid){.shape = NSDAE_SHAPE_POINT, .group = -1}, "group");
  words = "exclude = -2 is outside its range: it must be -1 ..";
  refuse_solid(2, 0, (nsdae_solid){.shape = NSDAE_SHAPE_POINT, .exclude = -2}, "exclude");
  refuse_solid(2, 0, (nsdae_solid){.shape = NSDAE_SHAPE_POINT, .radius = -1}, "radius");
  refuse_solid(2, 0, (nsdae_solid){.shape = NSDAE_SHAPE_SEGMENT, .length = {INFINITY}}, "length");
  refuse_solid(2, 0, (nsdae_solid){.shape = NSDAE_SHAPE_POLYGON, .points = 3}, "points");
  refuse_solid(2, 0, (nsdae_solid){.shape = NSDAE_SHAPE_CONE, .radius = 1, .length = {0, 0, 1}},
               "shape");
  refuse_solid(3, 0, (nsdae_solid){.shape = NSDAE_SHAPE_CONE, .length = {0, 0, 1}}, "radius");
  refuse_solid(3, 0, (nsdae_solid){.shape = NSDAE_SHAPE_CONE, .radius = 1}, "length");
  refuse_solid(3, 0, (nsdae_solid){.shape = NSDAE_SHAPE_DISC, .radius = NAN}, "radius");
  refuse_solid(3, 0, (nsdae_solid){.shape = NSDAE_SHAPE_DISC, .radius = 1, .hollow = 1}, "hollow");
  for (int i = 0; i < 4; i++) {
    nsdae_solid s = {.shape = NSDAE_SHAPE_ELLIPSOID, .radius = i == 3, .length = {1, 1, 1}};
    if (i < 3) s.length[i] = -1;
    refuse_solid(3, 0, s, i < 3 ? "length" : "radius");
  }
  refuse_contact(0, -1, 0, 0, "solid");
  refuse_contact(4, 1, 0, 0, "solid");
}

static void refuse_pair(int first, int second, double e_n, double e_t, const char *argument)
{
  nsdae_bodies *b = world(3);
  expect(b, nsdae_bodies_set_pair(b, first, second, 0.1, e_n, e_t), NSDAE_E_ARGUMENT, argument);
}

static void test_pairs(void **state)
{
  (void)state;
  nsdae_bodies *b = world(3);
  refuse_pair(-1, 0, 0, 0, "material");
  refuse_pair(0, NSDAE_MATERIALS, 0, 0, "material");
  refuse_pair(0, 0, 1.5, 0, "e_n");
  refuse_pair(0, 0, 0, 1.5, "e_t");
  expect(b, nsdae_bodies_set_pair(b, 0, 0, -1, 0, 0), NSDAE_E_ARGUMENT, "mu");
  assert_int_equal(nsdae_bodies_set_pair(NULL, 0, 0, 0, 0, 0), NSDAE_E_ARGUMENT);
}

/* What is asked of no bodies, or without room for the answer. */
static void test_asked(void **state)
{
  (void)state;
  nsdae_bodies *b = world(2);
  nsdae_dims dims;
  double q[6], v[6], point[3];
  const double local[3] = {0};
  assert_int_equal(nsdae_bodies_get_dims(NULL, &dims), NSDAE_E_ARGUMENT);
  assert_int_equal(nsdae_bodies_get_dims(b, NULL), NSDAE_E_ARGUMENT);
  assert_int_equal(nsdae_bodies_get_start(NULL, q, v), NSDAE_E_ARGUMENT);
  assert_int_equal(nsdae_bodies_get_start(b, NULL, v), NSDAE_E_ARGUMENT);
  assert_int_equal(nsdae_bodies_get_start(b, q, NULL), NSDAE_E_ARGUMENT);
  assert_int_equal(nsdae_bodies_get_start(b, q, v), NSDAE_OK);
  assert_int_equal(nsdae_bodies_locate(NULL, q, 0, local, point), NSDAE_E_ARGUMENT);
  assert_int_equal(nsdae_bodies_locate(b, NULL, 0, local, point), NSDAE_E_ARGUMENT);
  assert_int_equal(nsdae_bodies_locate(b, q, 0, NULL, point), NSDAE_E_ARGUMENT);
  assert_int_equal(nsdae_bodies_locate(b, q, 0, local, NULL), NSDAE_E_ARGUMENT);
  assert_int_equal(nsdae_bodies_locate(b, q, -2, local, point), NSDAE_E_ARGUMENT);
  assert_int_equal(nsdae_bodies_locate(b, q, 2, local, point), NSDAE_E_ARGUMENT);
  assert_int_equal(nsdae_bodies_locate(b, q, NSDAE_GROUND, local, point), NSDAE_OK);
  assert_int_equal(nsdae_bodies_system(b, NULL), NSDAE_E_ARGUMENT);
  nsdae_bodies_destroy(&b);
}

/* Nothing can be added to what has become a system. */
static void test_made(void **state)
{
  nsdae_system *system, *again;
  nsdae_bodies *b = world(2);
  (void)state;
  assert_true(nsdae_bodies_system(b, &system) >= 0);
  assert_int_equal(nsdae_bodies_add(b, &good), NSDAE_E_STATE);
  assert_int_equal(nsdae_bodies_system(b, &again), NSDAE_E_STATE);
  nsdae_system_destroy(&system);
  nsdae_bodies_destroy(&b);
}

/* Mass and inertia by formula against sums over a fine grid. */
static void grid_inertia(const nsdae_solid *s, int d,
                         int (*inside)(const double *, const nsdae_solid *))
{
  enum { N = 120 };
  const double half = 1.2, h = 2 * half / N;
  double mass = 0, sum[3] = {0}, given_mass, given[3];
  for (int i = 0; i < N; i++)
    for (int j = 0; j < N; j++)
      for (int k = 0; k < (d == 2 ? 1 : N); k++) {
        double x[3] = {(i + 0.5) * h - half, (j + 0.5) * h - half,
                       d == 2 ? 0 : (k + 0.5) * h - half};
        if (!inside(x, s)) continue;
        double cell = d == 2 ? h * h : h * h * h;
        mass += cell;
        for (int l = 0; l < 3; l++)
          sum[l] += cell * (x[(l + 1) % 3] * x[(l + 1) % 3] + x[(l + 2) % 3] * x[(l + 2) % 3]);
      }
  assert_int_equal(nsdae_solid_inertia(s, 2, &given_mass, given, NULL), NSDAE_OK);
  assert_near(given_mass, 2 * mass, 0.02 * 2 * mass); /* the surface's cells are in or out */
  for (int l = d == 2 ? 2 : 0; l < 3; l++) assert_near(given[l], 2 * sum[l], 0.03 * 2 * sum[l]);
}

static int in_ball(const double *x, const nsdae_solid *s)
{
  return x[0] * x[0] + x[1] * x[1] + x[2] * x[2] < s->radius * s->radius;
}

static int in_capsule(const double *x, const nsdae_solid *s)
{
  double z = fmax(fabs(x[2]) - s->length[2] / 2, 0);
  return x[0] * x[0] + x[1] * x[1] + z * z < s->radius * s->radius;
}

static int in_box(const double *x, const nsdae_solid *s)
{
  for (int i = 0; i < 3; i++)
    if (fabs(x[i]) > s->length[i] / 2) return 0;
  return 1;
}

static const double triangle[6] = {-1, -1. / 3, 1, -1. / 3, 0, 2. / 3};

static void test_inertia(void **state)
{
  double mass, inertia[3];
  (void)state;
  nsdae_solid s = {.shape = NSDAE_SHAPE_SPHERE, .radius = 0.9, .length = {1.6, 1, 0.8}};
  grid_inertia(&s, 3, in_ball);
  s.shape = NSDAE_SHAPE_DISC;
  grid_inertia(&s, 2, in_ball);
  s.shape = NSDAE_SHAPE_BOX;
  grid_inertia(&s, 3, in_box);
  s.shape = NSDAE_SHAPE_CAPSULE;
  s.radius = 0.6;
  grid_inertia(&s, 3, in_capsule);
  s = (nsdae_solid){.shape = NSDAE_SHAPE_POLYGON, .points = 3, .point = triangle};
  assert_int_equal(nsdae_solid_inertia(&s, 3, &mass, inertia, NULL), NSDAE_OK);
  assert_near(mass, 3, 1e-15); /* base 2, height 1 */
  assert_near(inertia[2], 3 * (4. / 24 + 1. / 18), 1e-15);
  assert_int_equal(nsdae_solid_inertia(&s, 0, &mass, inertia, NULL), NSDAE_E_ARGUMENT);
  s.shape = NSDAE_SHAPE_PLANE;
  assert_int_equal(nsdae_solid_inertia(&s, 1, &mass, inertia, NULL), NSDAE_E_ARGUMENT);
}

/* nsdae_solid_inertia has no handle: its record is the last argument, which may be NULL. */
static void test_inertia_refused(void **state)
{
  const double off[] = {1, 0, 2, 0, 1, 1};
  const nsdae_solid ball = {.shape = NSDAE_SHAPE_SPHERE, .radius = 0.2};
  nsdae_solid hollow = {.shape = NSDAE_SHAPE_DISC, .radius = 0.2, .hollow = 1};
  const nsdae_solid away = {.shape = NSDAE_SHAPE_POLYGON, .points = 3, .point = off};
  const double densities[] = {0, -1, NAN, INFINITY};
  double mass, inertia[3];
  nsdae_error error;
  (void)state;
  assert_int_equal(nsdae_solid_inertia(NULL, 1, &mass, inertia, &error), NSDAE_E_ARGUMENT);
  assert_int_equal(nsdae_solid_inertia(&ball, 1, NULL, inertia, &error), NSDAE_E_ARGUMENT);
  assert_int_equal(nsdae_solid_inertia(&ball, 1, &mass, NULL, NULL), NSDAE_E_ARGUMENT);
  for (int i = 0; i < 4; i++) {
    assert_int_equal(nsdae_solid_inertia(&ball, densities[i], &mass, inertia, &error),
                     NSDAE_E_ARGUMENT);
    assert_string_equal(error.argument, "density");
  }
  assert_int_equal(nsdae_solid_inertia(&away, 1, &mass, inertia, &error), NSDAE_E_ARGUMENT);
  assert_string_equal(error.argument, "point");
  assert_int_equal(nsdae_solid_inertia(&hollow, 1, &mass, inertia, &error), NSDAE_E_ARGUMENT);
  hollow.shape = -1;
  assert_int_equal(nsdae_solid_inertia(&hollow, 1, &mass, inertia, &error), NSDAE_E_ARGUMENT);
  hollow.shape = NSDAE_SHAPE_PLANE + 1;
  assert_int_equal(nsdae_solid_inertia(&hollow, 1, &mass, inertia, &error), NSDAE_E_ARGUMENT);
  assert_int_equal(nsdae_solid_inertia(&ball, 1000, &mass, inertia, &error), NSDAE_OK);
}

int main(void)
{
  const struct CMUnitTest tests[] = {cmocka_unit_test(test_inertia_refused),
                                     cmocka_unit_test(test_create),
                                     cmocka_unit_test(test_bodies),
                                     cmocka_unit_test(test_rotations),
                                     cmocka_unit_test(test_joints),
                                     cmocka_unit_test(test_limits),
                                     cmocka_unit_test(test_ropes),
                                     cmocka_unit_test(test_couplers),
                                     cmocka_unit_test(test_motors),
                                     cmocka_unit_test(test_solids),
                                     cmocka_unit_test(test_polygons),
                                     cmocka_unit_test(test_endless),
                                     cmocka_unit_test(test_contacts),
                                     cmocka_unit_test(test_forces),
                                     cmocka_unit_test(test_made),
                                     cmocka_unit_test(test_springs),
                                     cmocka_unit_test(test_axis_of_planar_torsion),
                                     cmocka_unit_test(test_more_solids),
                                     cmocka_unit_test(test_pairs),
                                     cmocka_unit_test(test_asked),
                                     cmocka_unit_test(test_inertia)};
  return cmocka_run_group_tests(tests, NULL, NULL);
}
