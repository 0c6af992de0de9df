/* A Geneva drive of n slots: a crank turns with constant speed, its pin enters a slot of a wheel
 * and turns the wheel by 2 pi / n; then the wheel dwells. The crank's axis is at the distance C
 * from the wheel's, the pin at the radius a = C sin(pi / n), so that it enters along the slot. With
 * the crank's angle alpha from the line of the centres, |alpha| <= pi / 2 - pi / n, and mu = C / a
 * (J. J. Uicker, G. R. Pennock, J. E. Shigley, Theory of Machines and Mechanisms, 2011)
 *
 *   phi(alpha) = atan2(sin alpha, mu - cos alpha)
 *
 * The slots are wider than the pin by the play 2 c. So the wheel is within asin(c / (C - a)) of
 * phi: the pin is no closer to its axis than C - a. In the dwell a brake holds the wheel, with
 * velocity 0. */
#include "geneva.h"

#include <math.h>
#include <stddef.h>
#include <stdio.h>

#include "scene.h"

enum { WHEEL, CRANK };

static const double pi = 3.14159265358979323846;

double geneva_entry(const geneva *p)
{
  return pi / 2 - pi / p->slots;
}

double geneva_wheel(const geneva *p, double crank)
{
  double turns = floor((crank + pi) / (2 * pi)), alpha = crank - 2 * pi * turns;
  double entry = geneva_entry(p), mu = 1 / sin(pi / p->slots);
  alpha = fmax(fmin(alpha, entry), -entry);
  return 2 * pi / p->slots * turns + atan2(sin(alpha), mu - cos(alpha));
}

double geneva_bound(const geneva *p, double overlap)
{
  return asin((p->play + overlap) / (p->distance * (1 - sin(pi / p->slots))));
}

/* Triangles between two slots: with beta = pi / n, the slots at the angles -beta and beta from the
 * triangle, w the half width of a slot and R = C cos beta its end. */
static void add_teeth(geneva *p)
{
  double beta = pi / p->slots, w = p->pin + p->play, R = p->distance * cos(beta);
  double x = R * cos(beta) + w * sin(beta), y = R * sin(beta) - w * cos(beta);
  for (int i = 0; i < p->slots; i++) {
    const double corner[6] = {w / sin(beta), 0, x, -y, x, y};
    nsdae_bodies_add_solid(
        p->world, WHEEL,
        &(nsdae_solid){
            .shape = NSDAE_SHAPE_POLYGON, .points = 3, .point = corner, .angle = 2 * beta * i});
  }
}

/* The walls of a slot begin at w / tan beta from the axis, the pin comes as close as C - a. */
static int check(const geneva *p, nsdae_error *error)
{
  double beta = pi / p->slots, most = p->distance * (1 - sin(beta)) * tan(beta);
  if (p->pin + p->play < most) return NSDAE_OK;
  snprintf(error->text, sizeof error->text,
           "pin + play = %g m is not below %g m, which a wheel of %d slots has room for",
           p->pin + p->play, most, p->slots);
  return error->status = NSDAE_E_ARGUMENT;
}

/* A body that turns about the axis at x, and its joint. */
static int add_wheel(geneva *p, double x, double mass, double inertia, double spin)
{
  int body = nsdae_bodies_add(p->world, &(nsdae_rigid_body){.mass = mass,
                                                            .inertia = {0, 0, inertia},
                                                            .position = {x},
                                                            .spin = {0, 0, spin}});
  return nsdae_bodies_add_joint(
      p->world,
      &(nsdae_joint){.kind = NSDAE_JOINT_REVOLUTE, .body = {NSDAE_GROUND, body}, .point = {x}});
}

static int build(void *base, nsdae_system **system, nsdae_error *error)
{
  geneva *p = base;
  nsdae_bodies_destroy(&p->world);
  int status = check(p, error);
  if (status == NSDAE_OK) status = nsdae_bodies_create(2, &p->world, error);
  if (status < 0) return status;
  double a = p->distance * sin(pi / p->slots);
  p->error = p->moving = p->turned = 0;
  int wheel = add_wheel(p, 0, 1, p->inertia, 0);
  int crank = add_wheel(p, p->distance, 1, p->inertia, -p->speed);
  nsdae_bodies_add_motor(
      p->world, &(nsdae_motor){.joint = wheel, .kind = NSDAE_MOTOR_SPEED, .limit = p->brake});
  nsdae_bodies_add_motor(p->world, &(nsdae_motor){.joint = crank,
                                                  .kind = NSDAE_MOTOR_SPEED,
                                                  .target = -p->speed,
                                                  .limit = p->torque});
  add_teeth(p);
  nsdae_bodies_add_solid(
      p->world, CRANK,
      &(nsdae_solid){
          .shape = NSDAE_SHAPE_SEGMENT, .radius = p->pin / 2, .length = {a}, .position = {a / 2}});
  int pin = nsdae_bodies_add_solid(
      p->world, CRANK,
      &(nsdae_solid){.shape = NSDAE_SHAPE_DISC, .radius = p->pin, .position = {a}});
  for (int i = 0; i < p->slots; i++) nsdae_bodies_add_contact(p->world, i, pin, 0, 0, 0);
  nsdae_bodies_add_sensor(
      p->world, &(nsdae_sensor){.name = "wheel", .kind = NSDAE_SENSOR_COORDINATE, .joint = wheel});
  nsdae_bodies_add_sensor(
      p->world,
      &(nsdae_sensor){.name = "pin_force", .kind = NSDAE_SENSOR_CONTACT_FORCE, .body = CRANK});
  return world_end(p->world, NSDAE_OK, system, error);
}

static void start(const void *base, double *q0, double *v0)
{
  const geneva *p = base;
  nsdae_bodies_get_start(p->world, q0, v0);
}

/* The crank starts at alpha = -pi, in the middle of a dwell, and turns clockwise. A dwell without
 * 1 % of a turn at its ends: at the velocity of the wheel there is at rest, and a step passes. */
static void follow(void *base, const nsdae_record *r)
{
  geneva *p = base;
  double crank = -pi - r->q[3 * CRANK + 2], alpha = remainder(crank, 2 * pi);
  p->turned = r->q[3 * WHEEL + 2];
  p->error = fmax(p->error, fabs(p->turned - pi / p->slots - geneva_wheel(p, crank)));
  if (fabs(alpha) > geneva_entry(p) + 0.02 * pi)
    p->moving = fmax(p->moving, fabs(r->v[3 * WHEEL + 2]));
}

static void conclude(const void *base)
{
  const geneva *p = base;
  printf(
      "the wheel turned by %.6g of 1 / %d turns, within %.1e rad of the closed form (the play is "
      "%.1e rad); in dwells at most %.1e rad/s\n",
      p->turned * p->slots / (2 * pi), p->slots, p->error, geneva_bound(p, 0), p->moving);
}

#define AT(field) offsetof(geneva, field)

static const nsdae_param entries[] = {
    {"slots", "1", "number of slots", NSDAE_PARAM_INT, AT(slots), 4, 3, 24, 0, NULL},
    {"distance", "m", "distance of the axes", NSDAE_PARAM_REAL, AT(distance), 0.2, 0, INFINITY,
     NSDAE_OPEN_MIN, NULL},
    {"pin", "m", "radius of the pin", NSDAE_PARAM_REAL, AT(pin), 0.01, 0, INFINITY, NSDAE_OPEN_MIN,
     NULL},
    {"play", "m", "play of the pin on each side", NSDAE_PARAM_REAL, AT(play), 1e-4, 0, INFINITY, 0,
     NULL},
    {"speed", "rad/s", "speed of the crank", NSDAE_PARAM_REAL, AT(speed), 2, 0, INFINITY,
     NSDAE_OPEN_MIN, NULL},
    {"torque", "N m", "largest torque of the motor", NSDAE_PARAM_REAL, AT(torque), 10, 0, INFINITY,
     NSDAE_OPEN_MIN, NULL},
    {"inertia", "kg m^2", "moment of inertia of wheel and crank", NSDAE_PARAM_REAL, AT(inertia),
     0.01, 0, INFINITY, NSDAE_OPEN_MIN, NULL},
    {"brake", "N m", "torque of the brake of the wheel", NSDAE_PARAM_REAL, AT(brake), 0.25, 0,
     INFINITY, 0, NULL},
};

static const nsdae_params table = {entries, (int)(sizeof entries / sizeof *entries)};
static geneva parameters;

const driver_model geneva_model = {.name = "geneva",
                                   .summary = "a Geneva drive: a pin turns a slotted wheel",
                                   .parameters = &table,
                                   .base = &parameters,
                                   .t_end = 8,
                                   .dt = 2e-3,
                                   .method = NSDAE_METHOD_IMPLICIT,
                                   .build = build,
                                   .start = start,
                                   .follow = follow,
                                   .conclude = conclude};
