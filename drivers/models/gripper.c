/* A gripper: a speed motor moves a hand up and down, two fingers slide in it, and a motor on each
 * presses it against a box with the force F. The box is held by friction alone. The hand has the
 * height
 *
 *   y(t) = h / 2 (1 - cos w t),   w = 2 pi / T,   |y''| <= h w^2 / 2
 *
 * By Coulomb's law the box does not slip if and only if 2 mu F >= m (g + h w^2 / 2). The speed
 * motor has ten times the force at the right; all bodies together weigh 3.4 m. */
#include "gripper.h"

#include <math.h>
#include <stddef.h>
#include <stdio.h>

#include "scene.h"

enum { HAND, LEFT, RIGHT, BOX };

static double frequency(const gripper *p)
{
  return 2 * 3.14159265358979323846 / p->period;
}

double gripper_least_force(const gripper *p)
{
  double w = frequency(p);
  return p->mass * (p->g + p->stroke * w * w / 2) / (2 * p->mu);
}

/* y' and y'' */
static int lift(double t, double drive[3], void *user)
{
  const gripper *p = user;
  double w = frequency(p), half = p->stroke / 2;
  drive[0] = half * w * sin(w * t);
  drive[1] = half * w * w * cos(w * t);
  return 0;
}

/* A body with a rectangle of the half sizes a, b about (x, y); the number of the rectangle. */
static int add_rectangle(nsdae_bodies *world, double mass, double x, double y, double a, double b)
{
  const double corner[8] = {-a, -b, a, -b, a, b, -a, b};
  int body = nsdae_bodies_add(
      world, &(nsdae_rigid_body){
                 .mass = mass, .inertia = {0, 0, mass * (a * a + b * b) / 3}, .position = {x, y}});
  return nsdae_bodies_add_solid(world, body,
                                &(nsdae_solid){.shape = NSDAE_SHAPE_POLYGON,
                                               .points = 4,
                                               .point = corner,
                                               .exclude = body == HAND ? -1 : 0});
}

/* The finger on a side of the box, -1 or 1. */
static void add_finger(gripper *p, int finger, int side)
{
  int joint = nsdae_bodies_add_joint(
      p->world,
      &(nsdae_joint){.kind = NSDAE_JOINT_PRISMATIC, .body = {HAND, finger}, .axis = {-side}});
  nsdae_bodies_add_motor(p->world, &(nsdae_motor){.joint = joint,
                                                  .kind = NSDAE_MOTOR_FORCE,
                                                  .target = p->force,
                                                  .limit = INFINITY});
  nsdae_bodies_add_contact(p->world, finger, BOX, p->mu, 0, 0);
}

static int build(void *base, nsdae_system **system, nsdae_error *error)
{
  gripper *p = base;
  double s = p->size, thick = 0.1 * s;
  nsdae_bodies_destroy(&p->world);
  int status = nsdae_bodies_create(2, &p->world, error);
  if (status < 0) return status;
  p->slip = 0;
  nsdae_bodies_set_gravity(p->world, (const double[]){0, -p->g, 0});
  add_rectangle(p->world, 2 * p->mass, 0, 1.5 * s, 1.5 * s, 0.2 * s); /* body and rectangle 0 */
  for (int side = -1; side <= 1; side += 2)
    add_rectangle(p->world, 0.2 * p->mass, side * (s / 2 + thick), 0.4 * s, thick, 0.9 * s);
  add_rectangle(p->world, p->mass, 0, 0, s / 2, s / 2);
  int guide = nsdae_bodies_add_joint(
      p->world,
      &(nsdae_joint){.kind = NSDAE_JOINT_PRISMATIC, .body = {NSDAE_GROUND, HAND}, .axis = {0, 1}});
  nsdae_bodies_add_motor(p->world, &(nsdae_motor){.joint = guide,
                                                  .kind = NSDAE_MOTOR_SPEED,
                                                  .limit = 20 * p->mu * gripper_least_force(p),
                                                  .drive = lift,
                                                  .user = p});
  add_finger(p, LEFT, -1);
  add_finger(p, RIGHT, 1);
  nsdae_bodies_add_sensor(
      p->world,
      &(nsdae_sensor){.name = "grip", .kind = NSDAE_SENSOR_PAIR_FORCE, .solid = {LEFT, BOX}});
  return world_end(p->world, NSDAE_OK, system, error);
}

static void start(const void *base, double *q0, double *v0)
{
  const gripper *p = base;
  nsdae_bodies_get_start(p->world, q0, v0);
}

static void follow(void *base, const nsdae_record *r)
{
  gripper *p = base;
  for (int i = 0; i < 2; i++)
    for (int j = 0; j < 2; j++) {
      double place = r->q[3 * BOX + j] - r->q[3 * (LEFT + i) + j];
      if (r->step == 0) p->place[i][j] = place;
      p->slip = fmax(p->slip, fabs(place - p->place[i][j]));
    }
}

static void conclude(const void *base)
{
  const gripper *p = base;
  double least = gripper_least_force(p);
  printf("the box slipped by %.1e m; the force of a finger is %g N, it holds from %.6g N on\n",
         p->slip, p->force, least);
}

#define AT(field) offsetof(gripper, field)

static const nsdae_param entries[] = {
    {"force", "N", "force of a finger", NSDAE_PARAM_REAL, AT(force), 20, 0, INFINITY,
     NSDAE_OPEN_MIN, NULL},
    {"mu", "1", "friction", NSDAE_PARAM_REAL, AT(mu), 0.5, 0, INFINITY, NSDAE_OPEN_MIN, NULL},
    {"mass", "kg", "mass of the box", NSDAE_PARAM_REAL, AT(mass), 1, 0, INFINITY, NSDAE_OPEN_MIN,
     NULL},
    {"size", "m", "edge of the box", NSDAE_PARAM_REAL, AT(size), 0.1, 0, INFINITY, NSDAE_OPEN_MIN,
     NULL},
    {"stroke", "m", "way of the hand", NSDAE_PARAM_REAL, AT(stroke), 0.2, 0, INFINITY, 0, NULL},
    {"period", "s", "period of the hand", NSDAE_PARAM_REAL, AT(period), 1, 0, INFINITY,
     NSDAE_OPEN_MIN, NULL},
    {"g", "m/s^2", "gravity", NSDAE_PARAM_REAL, AT(g), 9.81, 0, INFINITY, 0, NULL},
};

static const nsdae_params table = {entries, (int)(sizeof entries / sizeof *entries)};
static gripper parameters;

const driver_model gripper_model = {.name = "gripper",
                                    .summary = "a gripper that holds a box by friction",
                                    .parameters = &table,
                                    .base = &parameters,
                                    .t_end = 2,
                                    .dt = 2e-3,
                                    .method = NSDAE_METHOD_MOREAU,
                                    .build = build,
                                    .start = start,
                                    .follow = follow,
                                    .conclude = conclude};
