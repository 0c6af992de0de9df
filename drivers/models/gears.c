/* Two gears of involute teeth, each tooth a polygon, that touch and drive: a motor turns the first,
 * the second has a damper. With radii r_b = r cos(phi) of the base circles a tooth of N has at the
 * radius rho the half angle
 *
 *   psi(rho) = pi / (2 N) + inv(phi) - inv(acos(r_b / rho)) - delta,   inv(x) = tan(x) - x
 *
 * (e.g. E. Buckingham, Analytical Mechanics of Gears, 1949), delta for backlash. Teeth on opposite
 * sides of a gap cannot pass: for ever
 *
 *   |N_1 theta_1 + N_2 theta_2| <= N_1 (delta + eta_1) + N_2 (delta + eta_2)
 *                                    + d (N_1 / r_b1 + N_2 / r_b2) / 2
 *
 * with eta the largest angle by which the chords of a polygon are behind the flank, and d the depth
 * of the contacts: r_b is N module cos(phi) / 2. */
#include "gears.h"

#include <math.h>
#include <stddef.h>
#include <stdio.h>

#include "scene.h"

enum { FLANK = 9, PARTS = 16 }; /* points of a flank; of a chord, where its distance is taken */

static const double pi = 3.14159265358979323846;

static double involute(double x)
{
  return tan(x) - x;
}

static double half_angle(const gears *p, int gear, double rho)
{
  int teeth = p->teeth[gear];
  double base = p->module * teeth / 2 * cos(p->pressure);
  return pi / (2 * teeth) + involute(p->pressure) - involute(acos(fmin(base / rho, 1))) -
         p->thinner;
}

/* Point k of a flank, from the base circle (no tooth goes down to the root) to the tip. */
static double radius_of(const gears *p, int gear, int k)
{
  double r = p->module * p->teeth[gear] / 2;
  double root = fmax(r * cos(p->pressure), r - 1.1 * p->module);
  return root + (r + p->module - root) * k / (FLANK - 1);
}

/* The largest angle by which chords are behind the flank. */
static double cut_off(const gears *p, int gear)
{
  double most = 0;
  for (int k = 0; k + 1 < FLANK; k++)
    for (int i = 1; i < PARTS; i++) {
      double x = 0, y = 0;
      for (int end = 0; end < 2; end++) {
        double part = end ? (double)i / PARTS : 1 - (double)i / PARTS;
        double rho = radius_of(p, gear, k + end), half = half_angle(p, gear, rho);
        x += part * rho * cos(half);
        y += part * rho * sin(half);
      }
      most = fmax(most, half_angle(p, gear, hypot(x, y)) - atan2(y, x));
    }
  return most;
}

double gears_bound(const gears *p, double depth)
{
  double play = 2 * depth / (p->module * cos(p->pressure));
  for (int i = 0; i < 2; i++) play += p->teeth[i] * (p->thinner + cut_off(p, i));
  return play;
}

/* Teeth around a body at x, the first at an angle, and a disc that does not touch: the rim. It
 * turns with the speed of the motor. */
static void add_gear(const gears *p, int gear, double x, double first)
{
  const int teeth = p->teeth[gear];
  const double spin = gear ? -p->speed * p->teeth[0] / teeth : p->speed;
  nsdae_joint pin = {.kind = NSDAE_JOINT_REVOLUTE, .point = {x}};
  pin.body[0] = NSDAE_GROUND;
  pin.body[1] = nsdae_bodies_add(
      p->world, &(nsdae_rigid_body){
                    .mass = 1, .inertia = {0, 0, 0.01}, .position = {x}, .spin = {0, 0, spin}});
  nsdae_bodies_add_joint(p->world, &pin);
  for (int i = 0; i < teeth; i++) {
    double corner[4 * FLANK];
    const double middle = first + 2 * pi * i / teeth;
    for (int k = 0; k < 2 * FLANK; k++) { /* outwards on the right flank, back on the left */
      double rho = radius_of(p, gear, k < FLANK ? k : 2 * FLANK - 1 - k);
      double half = half_angle(p, gear, rho), angle = middle + (k < FLANK ? -half : half);
      corner[2 * k] = rho * cos(angle);
      corner[2 * k + 1] = rho * sin(angle);
    }
    nsdae_bodies_add_solid(
        p->world, pin.body[1],
        &(nsdae_solid){
            .shape = NSDAE_SHAPE_POLYGON, .points = 2 * FLANK, .point = corner, .material = gear});
  }
  nsdae_bodies_add_solid(p->world, pin.body[1],
                         &(nsdae_solid){.shape = NSDAE_SHAPE_DISC,
                                        .radius = 1.001 * radius_of(p, gear, 0),
                                        .exclude = -1});
}

static int build(void *base, nsdae_system **system, nsdae_error *error)
{
  gears *p = base;
  const double apart = p->module * (p->teeth[0] + p->teeth[1]) / 2;
  nsdae_bodies_destroy(&p->world);
  int status = nsdae_bodies_create(2, &p->world, error);
  if (status < 0) return status;
  p->error = p->depth = 0;
  add_gear(p, 0, 0, 0);
  add_gear(p, 1, apart, pi + pi / p->teeth[1]); /* a gap towards the first */
  nsdae_bodies_add_motor(
      p->world, &(nsdae_motor){
                    .joint = 0, .kind = NSDAE_MOTOR_SPEED, .target = p->speed, .limit = p->torque});
  nsdae_bodies_add_joint_spring(p->world, &(nsdae_joint_spring){.joint = 1, .damping = p->damping});
  nsdae_bodies_set_pair(p->world, 0, 1, 0, 0, 0);
  return world_end(p->world, NSDAE_OK, system, error);
}

static void start(const void *base, double *q0, double *v0)
{
  const gears *p = base;
  nsdae_bodies_get_start(p->world, q0, v0);
}

static void follow(void *base, const nsdae_record *r)
{
  gears *p = base;
  for (int i = 0; i < 2; i++) p->turned[i] = r->q[3 * i + 2];
  p->error = fmax(p->error, fabs(p->teeth[0] * p->turned[0] + p->teeth[1] * p->turned[1]));
  p->depth = fmax(p->depth, r->penetration);
}

static void conclude(const void *base)
{
  const gears *p = base;
  printf("the gears turned by %.6g and %.6g rad: ratio %.6f, of the teeth %.6f; backlash at most "
         "%.2e of %.2e rad\n",
         p->turned[0], p->turned[1], -p->turned[1] / p->turned[0],
         (double)p->teeth[0] / p->teeth[1], p->error, gears_bound(p, p->depth));
}

static int figure(const void *base, driver_figure *f)
{
  const gears *p = base;
  *f = (driver_figure){"ratio of the gears", "", -p->turned[1] / p->turned[0],
                       (double)p->teeth[0] / p->teeth[1]};
  return 1;
}

#define AT(field) offsetof(gears, field)

static const nsdae_param entries[] = {
    {"driver", "1", "teeth of the driving gear", NSDAE_PARAM_INT, AT(teeth[0]), 18, 18, 200, 0,
     NULL},
    {"driven", "1", "teeth of the driven gear", NSDAE_PARAM_INT, AT(teeth[1]), 27, 18, 200, 0,
     NULL},
    {"module", "m", "module", NSDAE_PARAM_REAL, AT(module), 0.01, 0, INFINITY, NSDAE_OPEN_MIN,
     NULL},
    {"pressure", "rad", "pressure angle", NSDAE_PARAM_REAL, AT(pressure), 0.3490658503988659, 0.25,
     0.45, 0, NULL},
    {"thinner", "rad", "half angle by which teeth are thinner", NSDAE_PARAM_REAL, AT(thinner), 1e-3,
     0, 0.02, 0, NULL},
    {"speed", "rad/s", "speed of the motor", NSDAE_PARAM_REAL, AT(speed), 6, -INFINITY, INFINITY, 0,
     NULL},
    {"damping", "N m s", "damper of the driven gear", NSDAE_PARAM_REAL, AT(damping), 0.1, 0,
     INFINITY, 0, NULL},
    {"torque", "N m", "largest torque of the motor", NSDAE_PARAM_REAL, AT(torque), 100, 0, INFINITY,
     NSDAE_OPEN_MIN, NULL},
};

static const nsdae_params table = {entries, (int)(sizeof entries / sizeof *entries)};
static gears parameters;

const driver_model gears_model = {.name = "gears",
                                  .summary = "two gears of involute teeth",
                                  .parameters = &table,
                                  .base = &parameters,
                                  .t_end = 2,
                                  .dt = 5e-4,
                                  .method = NSDAE_METHOD_MOREAU,
                                  .projection = NSDAE_PROJECTION_SLOP,
                                  .build = build,
                                  .start = start,
                                  .follow = follow,
                                  .figure = figure,
                                  .conclude = conclude};
