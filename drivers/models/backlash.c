/* Two gears with backlash. The pinion is driven back and forth, the gear turns a load on its axis
 * with the play b between their stops. A brake with the torque M holds the load. With the angle of
 * the gear x = a sin w t and J of the load, the brake keeps the load at the stop until the gear
 * returns if M >= J a w^2. Then the load y is the play operator of x (M. A. Krasnosel'skii, A. V.
 * Pokrovskii, Systems with Hysteresis, 1989): between two reversals of x, from y_k on,
 *
 *   y = min(max(y_k, x - b / 2), x + b / 2)
 *
 * After the first reversal y_k = +-(a - b / 2). The gear meets the load without rebound, and on
 * each reversal it crosses the play before it moves the load: b of its motion is lost. */
#include "backlash.h"

#include <math.h>
#include <stddef.h>
#include <stdio.h>

#include "scene.h"

enum { PINION, GEAR, LOAD };

static const double pi = 3.14159265358979323846, size = 0.005; /* radius by tooth: m / 2 [m] */

static double amplitude(const backlash *p)
{
  return -p->amplitude * p->teeth[0] / p->teeth[1];
}

double backlash_gear(const backlash *p, double t)
{
  return amplitude(p) * sin(p->frequency * t);
}

double backlash_load(const backlash *p, double t)
{
  double x = backlash_gear(p, t), half = p->play / 2, a = amplitude(p);
  double reversals = floor(p->frequency * t / pi + 0.5), before = 0;
  if (reversals > 0) before = copysign(fmax(fabs(a) - half, 0), fmod(reversals, 2) > 0 ? a : -a);
  return fmin(fmax(before, x - half), x + half);
}

double backlash_least_brake(const backlash *p)
{
  return p->inertia * fabs(amplitude(p)) * p->frequency * p->frequency;
}

static int swing(double t, double drive[3], void *user)
{
  const backlash *p = user;
  double w = p->frequency;
  drive[0] = p->amplitude * sin(w * t);
  drive[1] = p->amplitude * w * cos(w * t);
  drive[2] = -w * w * drive[0];
  return 0;
}

static int add_joint(backlash *p, int body0, int body1, double x, nsdae_drive_fn drive)
{
  return nsdae_bodies_add_joint(p->world, &(nsdae_joint){.kind = NSDAE_JOINT_REVOLUTE,
                                                         .body = {body0, body1},
                                                         .point = {x},
                                                         .drive = drive,
                                                         .user = p});
}

/* Discs, the load as an arm along y, and two stops of the gear beside it, as the limits have them.
 */
static void add_shapes(backlash *p)
{
  double r[2] = {size * p->teeth[0], size * p->teeth[1]}, w = r[1] / 12, R = 0.8 * r[1];
  double stop = p->play / 2 + asin(2 * w / R);
  for (int i = 0; i < 2; i++)
    nsdae_bodies_add_solid(
        p->world, i, &(nsdae_solid){.shape = NSDAE_SHAPE_DISC, .radius = r[i], .exclude = -1});
  for (int side = -1; side <= 1; side += 2)
    nsdae_bodies_add_solid(p->world, GEAR,
                           &(nsdae_solid){.shape = NSDAE_SHAPE_DISC,
                                          .radius = w,
                                          .exclude = -1,
                                          .position = {R * sin(stop) * side, R * cos(stop)}});
  nsdae_bodies_add_solid(p->world, LOAD,
                         &(nsdae_solid){.shape = NSDAE_SHAPE_SEGMENT,
                                        .radius = w,
                                        .exclude = -1,
                                        .length = {r[1]},
                                        .position = {0, r[1] / 2},
                                        .angle = pi / 2});
}

static int build(void *base, nsdae_system **system, nsdae_error *error)
{
  backlash *p = base;
  nsdae_bodies_destroy(&p->world);
  int status = nsdae_bodies_create(2, &p->world, error);
  if (status < 0) return status;
  double apart = size * (p->teeth[0] + p->teeth[1]), speed = p->amplitude * p->frequency;
  p->error = 0;
  for (int i = PINION; i <= LOAD; i++)
    nsdae_bodies_add(p->world,
                     &(nsdae_rigid_body){.mass = 1,
                                         .inertia = {0, 0, p->inertia},
                                         .position = {i == PINION ? -apart : 0},
                                         .spin = {0, 0,
                                                  i == PINION ? speed
                                                  : i == GEAR ? amplitude(p) * p->frequency
                                                              : 0}});
  add_joint(p, NSDAE_GROUND, PINION, -apart, swing);
  int axis = add_joint(p, NSDAE_GROUND, LOAD, 0, NULL);
  int stops = add_joint(p, LOAD, GEAR, 0, NULL);
  nsdae_bodies_add_joint(p->world, &(nsdae_joint){.kind = NSDAE_JOINT_GEAR,
                                                  .body = {PINION, GEAR},
                                                  .ratio = -(double)p->teeth[0] / p->teeth[1]});
  nsdae_bodies_add_limit(p->world,
                         &(nsdae_limit){.joint = stops, .low = -p->play / 2, .high = p->play / 2});
  nsdae_bodies_add_motor(
      p->world, &(nsdae_motor){.joint = axis, .kind = NSDAE_MOTOR_SPEED, .limit = p->brake});
  add_shapes(p);
  return world_end(p->world, NSDAE_OK, system, error);
}

static void start(const void *base, double *q0, double *v0)
{
  const backlash *p = base;
  nsdae_bodies_get_start(p->world, q0, v0);
}

/* The gear meets the load where |x| = b / 2, and b after each reversal; if the brake is enough. */
static int exact(const void *base, int number, driver_exact *impact)
{
  const backlash *p = base;
  double a = fabs(amplitude(p)), angle = asin(p->play / 2 / a);
  if (!(p->play / 2 < a) || p->brake < backlash_least_brake(p)) return 0;
  if (number > 0) angle = (number - 0.5) * pi + acos(1 - p->play / a);
  impact->time = angle / p->frequency;
  impact->normal_impulse = p->inertia * a * p->frequency * fabs(cos(angle));
  return 1;
}

static void follow(void *base, const nsdae_record *r)
{
  backlash *p = base;
  p->error = fmax(p->error, fabs(r->q[3 * LOAD + 2] - backlash_load(p, r->time)));
}

static void conclude(const void *base)
{
  const backlash *p = base;
  printf("the load is within %.1e rad of the play operator, which needs a brake of %.4g N m\n",
         p->error, backlash_least_brake(p));
}

#define AT(field) offsetof(backlash, field)

static const nsdae_param entries[] = {
    {"amplitude", "rad", "amplitude of the pinion", NSDAE_PARAM_REAL, AT(amplitude), 1, -INFINITY,
     INFINITY, 0, NULL},
    {"frequency", "rad/s", "its angular frequency", NSDAE_PARAM_REAL, AT(frequency), 2, 0, INFINITY,
     NSDAE_OPEN_MIN, NULL},
    {"play", "rad", "play of the gear", NSDAE_PARAM_REAL, AT(play), 0.2, 0, 3, NSDAE_OPEN_MIN,
     NULL},
    {"inertia", "kg m^2", "moment of inertia of each wheel", NSDAE_PARAM_REAL, AT(inertia), 0.01, 0,
     INFINITY, NSDAE_OPEN_MIN, NULL},
    {"brake", "N m", "torque of the brake", NSDAE_PARAM_REAL, AT(brake), 0.05, 0, INFINITY, 0,
     NULL},
    {"pinion", "1", "teeth of the pinion", NSDAE_PARAM_INT, AT(teeth[0]), 12, 1, 1000, 0, NULL},
    {"gear", "1", "teeth of the gear", NSDAE_PARAM_INT, AT(teeth[1]), 24, 1, 1000, 0, NULL},
};

static const nsdae_params table = {entries, (int)(sizeof entries / sizeof *entries)};
static backlash parameters;

const driver_model backlash_model = {.name = "backlash",
                                     .summary = "two gears with backlash, back and forth",
                                     .parameters = &table,
                                     .base = &parameters,
                                     .t_end = 8,
                                     .dt = 2e-3,
                                     .method = NSDAE_METHOD_EVENT,
                                     .build = build,
                                     .start = start,
                                     .exact = exact,
                                     .follow = follow,
                                     .conclude = conclude};
