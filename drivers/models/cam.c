/* A cam turns with constant speed and lifts a flat follower against a spring. The follower rises by
 * a cycloid, dwells, returns and dwells (R. L. Norton, Cam Design and Manufacturing Handbook,
 * 2009): with u the angle since the rise began, beta its length and x = u / beta
 *
 *   s(u) = L (x - sin(2 pi x) / (2 pi))   s'' = 2 pi L / beta^2 sin(2 pi x)
 *
 * A flat follower is at the support function of the cam, h(phi) = R + s(pi / 2 - phi) in the
 * direction phi of the cam's frame. So the profile is
 *
 *   h (cos phi, sin phi) + h' (-sin phi, cos phi), convex if its radius of curvature h + h'' > 0
 *
 * The cam is a polygon of points of the profile: between two of them, an angle delta apart, the
 * follower is too low by at most rho (1 - cos(delta / 2)), rho the largest radius of curvature. */
#include "cam.h"

#include <math.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>

#include "scene.h"

enum { CAM, FOLLOWER };

static const double pi = 3.14159265358979323846;

/* The part x of the rise that the angle has reached, the return backwards; *way: 1 upwards, -1
 * downwards, 0 at rest. */
static double part_of(const cam *p, double angle, double *way)
{
  double u = angle - 2 * pi * floor(angle / (2 * pi)), x = (u < pi ? u : u - pi) / p->rise;
  *way = x < 1 ? (u < pi ? 1 : -1) : 0;
  return u < pi ? fmin(x, 1) : 1 - fmin(x, 1);
}

double cam_lift(const cam *p, double angle)
{
  double way, x = part_of(p, angle, &way);
  return p->lift * (x - sin(2 * pi * x) / (2 * pi));
}

static double slope(const cam *p, double angle)
{
  double way, x = part_of(p, angle, &way);
  return way * p->lift / p->rise * (1 - cos(2 * pi * x));
}

/* The largest |s''|. */
static double bend(const cam *p)
{
  return 2 * pi * p->lift / (p->rise * p->rise);
}

double cam_bound(const cam *p)
{
  return (p->radius + p->lift + bend(p)) * (1 - cos(pi / p->corners));
}

/* With A = m omega^2 max |s''| the spring holds the follower if preload + k s(x) + A sin(2 pi x) is
 * above 0: the least is at cos(2 pi x) = -k L / (2 pi A - k L) with a negative sine. */
double cam_least_preload(const cam *p)
{
  double A = p->mass * bend(p) * p->speed * p->speed, kL = p->stiffness * p->lift;
  double cosine = -kL / (2 * pi * A - kL);
  if (!(fabs(cosine) < 1)) return 0;
  double x = 1 - acos(cosine) / (2 * pi);
  return fmax(0, -A * sin(2 * pi * x) - p->stiffness * cam_lift(p, x * p->rise));
}

/* Ten times the torque of the largest force on the cam, at its largest lever, with friction. */
static double torque(const cam *p)
{
  double force = p->mass * bend(p) * p->speed * p->speed + p->stiffness * p->lift + p->preload;
  return 10 * force * (2 * p->lift / p->rise + p->mu * (p->radius + p->lift));
}

static int check(const cam *p, nsdae_error *error)
{
  if (p->radius > bend(p)) return NSDAE_OK;
  snprintf(error->text, sizeof error->text,
           "radius = %g m must be above 2 pi lift / rise^2 = %g m, else the cam is not convex: a "
           "smaller lift, or a longer rise",
           p->radius, bend(p));
  return error->status = NSDAE_E_ARGUMENT;
}

static int add_cam(const cam *p)
{
  double *corner = calloc((size_t)p->corners, 2 * sizeof *corner);
  if (!corner) return NSDAE_E_MEMORY;
  for (int i = 0; i < p->corners; i++) {
    double phi = 2 * pi * i / p->corners, u = pi / 2 - phi, h = p->radius + cam_lift(p, u);
    corner[2 * i] = h * cos(phi) + slope(p, u) * sin(phi);
    corner[2 * i + 1] = h * sin(phi) - slope(p, u) * cos(phi);
  }
  int body = nsdae_bodies_add(
      p->world,
      &(nsdae_rigid_body){.mass = p->mass, .inertia = {0, 0, 1}, .spin = {0, 0, p->speed}});
  int joint = nsdae_bodies_add_joint(
      p->world, &(nsdae_joint){.kind = NSDAE_JOINT_REVOLUTE, .body = {NSDAE_GROUND, body}});
  nsdae_bodies_add_motor(p->world, &(nsdae_motor){.joint = joint,
                                                  .kind = NSDAE_MOTOR_SPEED,
                                                  .target = p->speed,
                                                  .limit = torque(p)});
  int status = nsdae_bodies_add_solid(
      p->world, body,
      &(nsdae_solid){
          .shape = NSDAE_SHAPE_POLYGON, .points = p->corners, .point = corner, .material = CAM});
  free(corner);
  return status;
}

/* Its face reaches as far as the contact gets from the middle, max |s'|, and a fifth of the radius
 * more; the stem is for pictures. */
static int add_follower(const cam *p)
{
  double r = p->radius, half = 2 * p->lift / p->rise + r / 5;
  const double plate[8] = {-half, 0, half, 0, half, r / 4, -half, r / 4};
  const double stem[8] = {-r / 8, r / 4, r / 8, r / 4, r / 8, 2 * r, -r / 8, 2 * r};
  int body = nsdae_bodies_add(
      p->world, &(nsdae_rigid_body){.mass = p->mass, .inertia = {0, 0, 1}, .position = {0, r}});
  int joint = nsdae_bodies_add_joint(p->world, &(nsdae_joint){.kind = NSDAE_JOINT_PRISMATIC,
                                                              .body = {NSDAE_GROUND, body},
                                                              .point = {0, r},
                                                              .axis = {0, 1}});
  nsdae_bodies_add_joint_spring(
      p->world, &(nsdae_joint_spring){
                    .joint = joint, .stiffness = p->stiffness, .rest = -p->preload / p->stiffness});
  nsdae_bodies_add_sensor(
      p->world, &(nsdae_sensor){.name = "lift", .kind = NSDAE_SENSOR_COORDINATE, .joint = joint});
  nsdae_bodies_add_solid(
      p->world, body,
      &(nsdae_solid){
          .shape = NSDAE_SHAPE_POLYGON, .points = 4, .point = plate, .material = FOLLOWER});
  return nsdae_bodies_add_solid(
      p->world, body,
      &(nsdae_solid){.shape = NSDAE_SHAPE_POLYGON, .points = 4, .point = stem, .exclude = -1});
}

static int build(void *base, nsdae_system **system, nsdae_error *error)
{
  cam *p = base;
  nsdae_bodies_destroy(&p->world);
  int status = check(p, error);
  if (status == NSDAE_OK) status = nsdae_bodies_create(2, &p->world, error);
  if (status < 0) return status;
  p->error = p->depth = 0;
  status = add_cam(p);
  if (status >= 0) status = add_follower(p);
  nsdae_bodies_set_pair(p->world, CAM, FOLLOWER, p->mu, 0, 0);
  return world_end(p->world, status, system, error);
}

static void start(const void *base, double *q0, double *v0)
{
  const cam *p = base;
  nsdae_bodies_get_start(p->world, q0, v0);
}

static void follow(void *base, const nsdae_record *r)
{
  cam *p = base;
  double exact = p->radius + cam_lift(p, r->q[3 * CAM + 2]);
  p->error = fmax(p->error, fabs(r->q[3 * FOLLOWER + 1] - exact));
  p->depth = fmax(p->depth, r->penetration);
}

static void conclude(const void *base)
{
  const cam *p = base;
  printf("the lift is within %.2e m of the closed form (chords %.1e m, penetration %.1e m)\n",
         p->error, cam_bound(p), p->depth);
  printf("the follower stays on the cam if the preload is above %.6g N\n", cam_least_preload(p));
}

#define AT(field) offsetof(cam, field)

static const nsdae_param entries[] = {
    {"radius", "m", "radius of the cam without lift", NSDAE_PARAM_REAL, AT(radius), 0.04, 0,
     INFINITY, NSDAE_OPEN_MIN, NULL},
    {"lift", "m", "lift of the follower", NSDAE_PARAM_REAL, AT(lift), 0.02, 0, INFINITY,
     NSDAE_OPEN_MIN, NULL},
    {"rise", "rad", "angle of the rise and of the return", NSDAE_PARAM_REAL, AT(rise), 2.2, 0,
     3.14159265358979312, NSDAE_OPEN_MIN, NULL},
    {"corners", "1", "corners of the polygon", NSDAE_PARAM_INT, AT(corners), 180, 8, 1000, 0, NULL},
    {"speed", "rad/s", "speed of the cam", NSDAE_PARAM_REAL, AT(speed), 20, 0, INFINITY,
     NSDAE_OPEN_MIN, NULL},
    {"mass", "kg", "mass of the follower", NSDAE_PARAM_REAL, AT(mass), 0.5, 0, INFINITY,
     NSDAE_OPEN_MIN, NULL},
    {"stiffness", "N/m", "stiffness of the spring", NSDAE_PARAM_REAL, AT(stiffness), 200, 0,
     INFINITY, NSDAE_OPEN_MIN, NULL},
    {"preload", "N", "force of the spring without lift", NSDAE_PARAM_REAL, AT(preload), 10, 0,
     INFINITY, 0, NULL},
    {"mu", "1", "friction", NSDAE_PARAM_REAL, AT(mu), 0.1, 0, INFINITY, 0, NULL},
};

static const nsdae_params table = {entries, (int)(sizeof entries / sizeof *entries)};
static cam parameters;

const driver_model cam_model = {.name = "cam",
                                .summary = "a cam of given lift and its flat follower",
                                .parameters = &table,
                                .base = &parameters,
                                .t_end = 1,
                                .dt = 1e-3,
                                .method = NSDAE_METHOD_MOREAU,
                                .projection = NSDAE_PROJECTION_AUTO,
                                .build = build,
                                .start = start,
                                .follow = follow,
                                .conclude = conclude};
