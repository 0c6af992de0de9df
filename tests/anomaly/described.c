/* Descriptions, where memory is lost: each allocation in turn fails while bodies with every joint,
 * spring, load and pair of shapes are put together, made to a system, named and checked. Each call
 * that fails says NSDAE_E_MEMORY, and nothing is left. */
#include "check.h"

#include <stdlib.h>

#include <nsdae/nsdae.h>

#include "allocator.h"

static char said[256]; /* by the check */

static int load(double t, const double x[3], const double v[3], double force[3], double torque[3],
                void *user)
{
  (void)t, (void)x, (void)user;
  for (int i = 0; i < 3; i++) force[i] = -v[i];
  torque[2] = 0.1;
  return 0;
}

static int own_mass(double t, const double *q, double *M, int ldm, void *user)
{
  (void)t, (void)q, (void)ldm, (void)user;
  M[0] = 2;
  return 0;
}

static void add_bodies(nsdae_bodies *b)
{
  for (int i = 0; i < 6; i++)
    nsdae_bodies_add(
        b, &(nsdae_rigid_body){.mass = 1, .inertia = {1, 1, 1}, .position = {3.0 * i, 0.5 * i, 0}});
}

static void add_joints(nsdae_bodies *b, int dimension)
{
  const int planar[] = {NSDAE_JOINT_REVOLUTE, NSDAE_JOINT_PRISMATIC, NSDAE_JOINT_WELD,
                        NSDAE_JOINT_DISTANCE, NSDAE_JOINT_SLOT,      NSDAE_JOINT_GEAR};
  const int spatial[] = {NSDAE_JOINT_REVOLUTE,    NSDAE_JOINT_PRISMATIC, NSDAE_JOINT_WELD,
                         NSDAE_JOINT_CYLINDRICAL, NSDAE_JOINT_SPHERICAL, NSDAE_JOINT_UNIVERSAL};
  for (int i = 0; i < 6; i++)
    nsdae_bodies_add_joint(
        b,
        &(nsdae_joint){.kind = dimension == 2 ? planar[i] : spatial[i],
                       .body = {i - 1, i},
                       .point = {3.0 * i - 1, 0.5 * i, 0},
                       .end = {3.0 * i, 0.5 * i, 0},
                       .axis = {1, 0, 0},
                       .cross = {0, 1, 0},
                       .ratio = 2,
                       .mu = i == 0 || (planar[i] == NSDAE_JOINT_SLOT && dimension == 2) ? 0.2 : 0,
                       .radius = i == 0 ? 0.1 : 0});
  nsdae_bodies_add_spring(
      b, &(nsdae_spring){.body = {-1, 2}, .point = {0, 9, 0}, .end = {6, 1, 0}, .stiffness = 3});
  nsdae_bodies_add_torsion(b, &(nsdae_torsion){.body = {0, 1}, .axis = {0, 0, 1}, .damping = 1});
  nsdae_bodies_add_limit(b, &(nsdae_limit){1, 0, -1, 1, 0.5});
  nsdae_bodies_add_rope(b, &(nsdae_rope){.body = {0, 1}, .end = {3, 2, 0}, .length = 9});
  nsdae_bodies_add_coupler(b, &(nsdae_coupler){.joint = {0, 1}, .p = {0, 1}});
  nsdae_bodies_add_joint_spring(b, &(nsdae_joint_spring){1, 0, 2, 1, 0});
  for (int kind = NSDAE_MOTOR_FORCE; kind <= NSDAE_MOTOR_POSITION; kind++)
    nsdae_bodies_add_motor(b, &(nsdae_motor){.joint = 1,
                                             .kind = kind,
                                             .target = 1,
                                             .kp = kind == NSDAE_MOTOR_POSITION ? 4 : 0,
                                             .limit = 2});
  nsdae_bodies_add_load(b, 3, (const double[]){9, 1.5, 0}, load, NULL);
  nsdae_bodies_set_gravity(b, (const double[]){0, -9.81, 0});
}

/* Each with the solid before them, a plane. */
static void add_smooth(nsdae_bodies *b, int plane)
{
  const int shapes[] = {NSDAE_SHAPE_CYLINDER, NSDAE_SHAPE_CONE, NSDAE_SHAPE_ELLIPSOID,
                        NSDAE_SHAPE_DISC};
  for (int i = 0; i < 4; i++) {
    nsdae_solid s = {.shape = shapes[i], .radius = 1, .length = {1, 1, 1}};
    if (s.shape == NSDAE_SHAPE_ELLIPSOID) s.radius = 0;
    nsdae_bodies_add_contact(b, nsdae_bodies_add_solid(b, i, &s), plane, 0.3, 0, 0);
  }
}

static void add_solids(nsdae_bodies *b, int dimension)
{
  static const double corners[] = {-0.5, -0.5, 0.5, -0.5, 0.5, 0.5, -0.5, 0.5};
  const int planar[] = {NSDAE_SHAPE_POINT, NSDAE_SHAPE_DISC, NSDAE_SHAPE_SEGMENT,
                        NSDAE_SHAPE_POLYGON};
  const int spatial[] = {NSDAE_SHAPE_POINT, NSDAE_SHAPE_SPHERE, NSDAE_SHAPE_CAPSULE,
                         NSDAE_SHAPE_BOX};
  int floor_ = nsdae_bodies_add_solid(
      b, NSDAE_GROUND, &(nsdae_solid){.shape = NSDAE_SHAPE_PLANE, .position = {0, -9, 0}});
  int before = -1;
  if (dimension == 3) add_smooth(b, floor_);
  for (int i = 0; i < 4; i++) {
    int shape = dimension == 2 ? planar[i] : spatial[i], round = i == 1 || i == 2;
    int turn = dimension == 3;
    int solid =
        nsdae_bodies_add_solid(b, i,
                               &(nsdae_solid){.shape = shape,
                                              .radius = round ? 0.2 : 0,
                                              .length = {1, 1, 1},
                                              .angle = dimension == 2 ? 0.3 * i + 0.1 : 0,
                                              .quaternion = {1, turn * (0.3 * i + 0.1), turn * 0.2,
                                                             turn * (0.4 - 0.1 * i)},
                                              .points = 4,
                                              .point = corners});
    nsdae_bodies_add_contact(b, solid, floor_, 0.3, 0.5, 0);
    if (i > 1) nsdae_bodies_add_contact(b, solid, before, 0.3, 0.5, 0);
    before = solid;
  }
}

/* Of every kind, half of them with a name; a body and a solid have names and colours. */
static void add_sensors(nsdae_bodies *b)
{
  char name[] = "a";
  for (int kind = NSDAE_SENSOR_COORDINATE; kind <= NSDAE_SENSOR_POTENTIAL_ENERGY; kind++, name[0]++)
    nsdae_bodies_add_sensor(
        b, &(nsdae_sensor){.name = kind % 2 ? name : NULL, .kind = kind, .solid = {0, 1}});
  for (int kind = NSDAE_NAMED_BODY; kind <= NSDAE_NAMED_SOLID; kind++) {
    nsdae_bodies_set_name(b, kind, 1, kind ? "tip" : "crank");
    nsdae_bodies_set_colour(b, kind, 1, "#c23b22");
  }
}

static int describe(int dimension, int own)
{
  nsdae_bodies *b = NULL;
  nsdae_system *s = NULL;
  nsdae_error error;
  static double q[64], v[64];
  int status = nsdae_bodies_create(dimension, &b, &error);
  if (status < 0) {
    assert_int_equal(error.status, status);
    return status;
  }
  add_bodies(b);
  add_joints(b, dimension);
  add_solids(b, dimension);
  add_sensors(b);
  if (own) nsdae_bodies_set_user_rows(b, &(nsdae_user_rows){.dims = {.nq = 1}, .mass = own_mass});
  status = nsdae_bodies_system(b, &s);
  if (status < 0) {
    assert_int_equal(nsdae_bodies_error(b)->status, status);
    snprintf(said, sizeof said, "%s", nsdae_bodies_error(b)->text);
    assert_true(said[0] != 0);
    assert_null(s);
  } else {
    nsdae_bodies_get_start(b, q, v);
    if (status == NSDAE_OK) status = nsdae_system_check(s, 0, q, v, 1e-5, NULL);
    if (status < 0) assert_int_equal(nsdae_system_error(s)->status, status);
    snprintf(said, sizeof said, "%s", nsdae_system_error(s)->text);
  }
  nsdae_system_destroy(&s);
  nsdae_bodies_destroy(&b);
  return status;
}

static void test_every_place(void **state)
{
  (void)state;
  for (int dimension = 2; dimension <= 3; dimension++) {
    long at = 0;
    for (;; at++) {
      allocator_reset(at);
      int status = describe(dimension, dimension == 3);
      long calls = the_allocator.calls, live = the_allocator.live;
      allocator_reset(-1);
      assert_int_equal(live, 0);
      if (calls <= at) {
        if (status < 0) fail_msg("%s", said);
        break;
      }
      if (status != NSDAE_E_MEMORY)
        fail_msg("allocation %ld of %d: status %d", at, dimension, status);
    }
    print_message("%d dimensions: %ld allocations\n", dimension, at);
    assert_true(at > 20);
  }
}

int main(void)
{
  const struct CMUnitTest tests[] = {cmocka_unit_test(test_every_place)};
  return cmocka_run_group_tests(tests, NULL, NULL);
}
