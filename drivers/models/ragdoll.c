/* A ragdoll of ten capsules, 75 kg and 1.75 m tall, falls backwards down stairs, a mesh. Knees and
 * elbows are hinges, hips, shoulders and neck are universal joints. Each rotation has limits and
 * dry friction. The body does no work: its energy never grows, except by what the record has of the
 * projection.
 */
#include "ragdoll.h"

#include <math.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "scene.h"

/* x to the left, y ahead, z up; from the middle of the body, 1.2 m above its soles. */
typedef struct part {
  int parent, kind;                 /* of its joint */
  double from[2], to[2], radius;    /* x and z of the ends [m] */
  double joint[2], low[2], high[2]; /* x and z [m]; limits [rad] */
} part;

enum { TORSO, HEAD, LEFT_ARM, LEFT_HAND, RIGHT_ARM, RIGHT_HAND, LEFT_LEG, LEFT_FOOT, RIGHT_LEG };
enum { HINGE = NSDAE_JOINT_REVOLUTE, CROSS = NSDAE_JOINT_UNIVERSAL, PARTS = 10 };

/* Arms turn about z, the others about x; then a cross about y. */
static const part parts[PARTS] = {
    {NSDAE_GROUND, 0, {0, -0.3}, {0, 0.3}, 0.12, {0}, {0}, {0}},
    {TORSO, CROSS, {0, 0.32}, {0, 0.54}, 0.1, {0, 0.31}, {-0.7, -0.7}, {0.7, 0.7}},
    {TORSO, CROSS, {0.16, 0.22}, {0.46, 0.22}, 0.045, {0.15, 0.22}, {-0.5, -1.4}, {2, 1.4}},
    {LEFT_ARM, HINGE, {0.47, 0.22}, {0.77, 0.22}, 0.04, {0.465, 0.22}, {-0.05}, {2.4}},
    {TORSO, CROSS, {-0.16, 0.22}, {-0.46, 0.22}, 0.045, {-0.15, 0.22}, {-2, -1.4}, {0.5, 1.4}},
    {RIGHT_ARM, HINGE, {-0.47, 0.22}, {-0.77, 0.22}, 0.04, {-0.465, 0.22}, {-2.4}, {0.05}},
    {TORSO, CROSS, {0.09, -0.32}, {0.09, -0.76}, 0.07, {0.09, -0.31}, {-0.5, -0.3}, {2, 0.8}},
    {LEFT_LEG, HINGE, {0.09, -0.78}, {0.09, -1.2}, 0.055, {0.09, -0.77}, {-2.4}, {0.05}},
    {TORSO, CROSS, {-0.09, -0.32}, {-0.09, -0.76}, 0.07, {-0.09, -0.31}, {-0.5, -0.8}, {2, 0.3}},
    {RIGHT_LEG, HINGE, {-0.09, -0.78}, {-0.09, -1.2}, 0.055, {-0.09, -0.77}, {-2.4}, {0.05}}};

static const char *const names[PARTS] = {"torso",     "head",       "left_arm", "left_hand",
                                         "right_arm", "right_hand", "left_leg", "left_foot",
                                         "right_leg", "right_foot"};

/* A capsule of density 1000 kg/m^3, from end to end along z or x. */
static int add_part(ragdoll *p, int i, double height)
{
  const part *a = &parts[i];
  double x = a->to[0] - a->from[0], z = a->to[1] - a->from[1], half = atan2(x, z) / 2;
  nsdae_solid solid = {.shape = NSDAE_SHAPE_CAPSULE,
                       .radius = a->radius,
                       .length = {0, 0, hypot(x, z) - 2 * a->radius},
                       .material = 1};
  nsdae_rigid_body body = {
      .position = {(a->from[0] + a->to[0]) / 2, 0, height + (a->from[1] + a->to[1]) / 2},
      .quaternion = {cos(half), 0, sin(half), 0},
      .velocity = {0, -p->push, 0}};
  int status = nsdae_solid_inertia(&solid, 1000, &body.mass, body.inertia, NULL);
  if (status < 0) return status;
  nsdae_bodies_add_solid(p->world, nsdae_bodies_add(p->world, &body), &solid);
  return nsdae_bodies_set_name(p->world, NSDAE_NAMED_BODY, i, names[i]);
}

static void add_joint(ragdoll *p, int number, double height)
{
  const part *a = &parts[number];
  int arm = number >= LEFT_ARM && number < LEFT_LEG;
  int joint = nsdae_bodies_add_joint(p->world,
                                     &(nsdae_joint){.kind = a->kind,
                                                    .body = {a->parent, number},
                                                    .point = {a->joint[0], 0, height + a->joint[1]},
                                                    .axis = {!arm, 0, arm},
                                                    .cross = {0, a->kind == CROSS, 0}});
  for (int i = 0; i < 1 + (a->kind == CROSS); i++) {
    nsdae_bodies_add_limit(p->world, &(nsdae_limit){joint, i, a->low[i], a->high[i], 0});
    nsdae_bodies_add_motor(p->world, &(nsdae_motor){.joint = joint,
                                                    .coordinate = i,
                                                    .kind = NSDAE_MOTOR_SPEED,
                                                    .limit = p->friction});
  }
}

/* The stairs as a closed mesh 2 m wide. Its profile is from the floor behind the highest step,
 * which is around y = 0, to the floor before the lowest; points 2 i and 2 i + 1 are those of its
 * corner i on both sides, which are fans about the first. */
static int add_stairs(const ragdoll *p)
{
  const int edges = 2 * p->steps + 1, triangles = 4 * edges;
  double *point = calloc((size_t)edges + 1, 6 * sizeof *point);
  int *triangle = calloc((size_t)triangles, 3 * sizeof *triangle), status = NSDAE_E_MEMORY;
  for (int i = 0; point && triangle && i <= edges; i++) {
    double y = -(i / 2 - 0.5) * p->run, z = i == 0 ? 0 : (p->steps - (i - 1) / 2) * p->rise;
    const double corner[6] = {1, y, z, -1, y, z};
    const int a = 2 * i, b = i < edges ? a + 2 : 0, side = i > 0 && i < edges;
    const int four[12] = {a, a + 1, b + 1, a, b + 1, b, 0, a, b, 1, b + 1, a + 1};
    memcpy(point + 6 * (ptrdiff_t)i, corner, sizeof corner);
    memcpy(triangle + 12 * (ptrdiff_t)i - (i > 0 ? 6 : 0), four,
           (side ? 12 : 6) * sizeof *triangle);
  }
  if (point && triangle)
    status = nsdae_bodies_add_solid(p->world, NSDAE_GROUND,
                                    &(nsdae_solid){.shape = NSDAE_SHAPE_MESH,
                                                   .points = 2 * (edges + 1),
                                                   .point = point,
                                                   .triangles = triangles,
                                                   .triangle = triangle,
                                                   .length = {0, 0, p->run / 2}});
  free(point);
  free(triangle);
  return status;
}

static int build(void *base, nsdae_system **system, nsdae_error *error)
{
  ragdoll *p = base;
  double height = p->steps * p->rise + 1.2;
  int status = world_begin(&p->world, 3, p->g, p->mu, 0, error);
  if (status < 0) return status;
  p->drift = p->growth = p->start = 0;
  if (p->steps > 0) status = add_stairs(p);
  for (int i = 0; i < PARTS && status >= 0; i++) status = add_part(p, i, height);
  for (int i = HEAD; i < PARTS && status >= 0; i++) add_joint(p, i, height);
  return world_end(p->world, status, system, error);
}

static void start(const void *base, double *q0, double *v0)
{
  const ragdoll *p = base;
  nsdae_bodies_get_start(p->world, q0, v0);
}

static void follow(void *base, const nsdae_record *r)
{
  ragdoll *p = base;
  double energy = r->kinetic + r->potential;
  if (r->step == 0) p->start = energy;
  p->drift = fmax(p->drift, r->constraint_drift);
  p->growth = fmax(p->growth, energy - r->projection_energy - p->start);
}

static void conclude(const void *base)
{
  const ragdoll *p = base;
  printf("drift of joints at most %.1e; energy at most %.1e of the start's above it\n", p->drift,
         p->growth / p->start);
}

#define AT(field) offsetof(ragdoll, field)

static const nsdae_param entries[] = {
    {"steps", "1", "number of steps; 0: a floor", NSDAE_PARAM_INT, AT(steps), 6, 0, 1000, 0, NULL},
    {"rise", "m", "height of a step", NSDAE_PARAM_REAL, AT(rise), 0.2, 0, INFINITY, NSDAE_OPEN_MIN,
     NULL},
    {"run", "m", "depth of a step", NSDAE_PARAM_REAL, AT(run), 0.3, 0, INFINITY, NSDAE_OPEN_MIN,
     NULL},
    {"push", "m/s", "velocity down the stairs at the start", NSDAE_PARAM_REAL, AT(push), 1,
     -INFINITY, INFINITY, 0, NULL},
    {"friction", "N m", "dry friction of a joint", NSDAE_PARAM_REAL, AT(friction), 2, 0, INFINITY,
     0, NULL},
    {"mu", "1", "friction of contacts", NSDAE_PARAM_REAL, AT(mu), 0.5, 0, INFINITY, 0, NULL},
    {"g", "m/s^2", "gravity", NSDAE_PARAM_REAL, AT(g), 9.81, 0, INFINITY, NSDAE_OPEN_MIN, NULL},
};

static const nsdae_params table = {entries, (int)(sizeof entries / sizeof *entries)};
static ragdoll parameters;

const driver_model ragdoll_model = {.name = "ragdoll",
                                    .summary = "a ragdoll that falls down stairs",
                                    .parameters = &table,
                                    .base = &parameters,
                                    .t_end = 3,
                                    .dt = 2e-3,
                                    .method = NSDAE_METHOD_IMPLICIT,
                                    .projection = NSDAE_PROJECTION_AUTO,
                                    .build = build,
                                    .start = start,
                                    .follow = follow,
                                    .conclude = conclude};
