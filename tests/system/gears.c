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
 *                                    + d N_1 / r_b1
 *
 * with eta the largest angle by which the chords of a polygon are behind the flank, and d the depth
 * of the contacts, so that the mean ratio of the speeds is that of the teeth. */
#include "check.h"

#include <nsdae/nsdae.h>

enum { FLANK = 9 };
static const double module = 0.01, pressure = 0.3490658503988659, delta = 1e-3; /* 20 degrees */

static double involute(double x)
{
  return tan(x) - x;
}

static double half_angle(int teeth, double rho)
{
  double base = module * teeth / 2 * cos(pressure);
  return acos(-1) / (2 * teeth) + involute(pressure) - involute(acos(fmin(base / rho, 1))) - delta;
}

/* Point k of a flank, from the base circle (no tooth goes down to the root) to the tip. */
static double radius_of(int teeth, int k)
{
  double r = module * teeth / 2, root = fmax(r * cos(pressure), r - 1.1 * module);
  return root + (r + module - root) * k / (FLANK - 1);
}

/* The largest angle by which chords are behind the flank. */
static double cut_off(int teeth)
{
  double most = 0;
  for (int k = 0; k + 1 < FLANK; k++)
    for (int i = 1; i < 16; i++) {
      double x = 0, y = 0;
      for (int end = 0; end < 2; end++) {
        double part = end ? i / 16.0 : 1 - i / 16.0, rho = radius_of(teeth, k + end);
        x += part * rho * cos(half_angle(teeth, rho));
        y += part * rho * sin(half_angle(teeth, rho));
      }
      most = fmax(most, half_angle(teeth, hypot(x, y)) - atan2(y, x));
    }
  return most;
}

static void add_gear(nsdae_bodies *b, int body, int teeth, double first)
{
  const double pi = acos(-1);
  for (int i = 0; i < teeth; i++) {
    double x[4 * FLANK];
    const double middle = first + 2 * pi * i / teeth;
    for (int k = 0; k < 2 * FLANK; k++) { /* outwards on the right flank, back on the left */
      int on = k < FLANK ? k : 2 * FLANK - 1 - k;
      double rho = radius_of(teeth, on), half = half_angle(teeth, rho);
      double angle = middle + (k < FLANK ? -half : half);
      x[2 * k] = rho * cos(angle);
      x[2 * k + 1] = rho * sin(angle);
    }
    const nsdae_solid tooth = {
        .shape = NSDAE_SHAPE_POLYGON, .points = 2 * FLANK, .point = x, .material = body};
    if (nsdae_bodies_add_solid(b, body, &tooth) < 0) fail_msg("%s", nsdae_bodies_error(b)->text);
  }
}

static void mesh(int method)
{
  enum { FIRST = 18, SECOND = 27 };
  const double pi = acos(-1), speed = 2 * pi, away = module * (FIRST + SECOND) / 2, dt = 5e-4;
  nsdae_bodies *b;
  nsdae_system *system;
  nsdae_sim *sim;
  nsdae_error error;
  nsdae_record r;
  nsdae_sim_options o;
  double q[6], v[6], worst = 0, depth = 0, play = 0, least = INFINITY, most = 0;
  assert_int_equal(nsdae_bodies_create(2, &b, NULL), NSDAE_OK);
  for (int i = 0; i < 2; i++) {
    const nsdae_rigid_body gear = {.mass = 1, .inertia = {0, 0, 0.01}, .position = {i * away}};
    nsdae_joint pin = {
        .kind = NSDAE_JOINT_REVOLUTE, .body = {NSDAE_GROUND, i}, .point = {i * away}};
    nsdae_bodies_add(b, &gear);
    assert_int_equal(nsdae_bodies_add_joint(b, &pin), i);
    add_gear(b, i, i ? SECOND : FIRST, i ? pi + pi / SECOND : 0);
  }
  play = FIRST * (delta + cut_off(FIRST)) + SECOND * (delta + cut_off(SECOND));
  nsdae_bodies_add_motor(
      b, &(nsdae_motor){.joint = 0, .kind = NSDAE_MOTOR_SPEED, .target = speed, .limit = 100});
  nsdae_bodies_add_joint_spring(b, &(nsdae_joint_spring){.joint = 1, .damping = 0.1});
  nsdae_bodies_set_pair(b, 0, 1, 0, 0, 0);
  if (nsdae_bodies_system(b, &system) < 0) fail_msg("%s", nsdae_bodies_error(b)->text);
  nsdae_bodies_get_start(b, q, v);
  nsdae_sim_options_default(&o);
  o.method = method;
  o.dt = dt;
  o.projection = NSDAE_PROJECTION_SLOP;
  if (nsdae_sim_create(system, &o, &sim, &error) < 0) fail_msg("%s", error.text);
  assert_true(nsdae_sim_init(sim, 0, q, v) >= 0);
  for (int i = 0; i < 4000; i++) {
    if (nsdae_sim_step(sim) < 0) fail_msg("%s", nsdae_sim_error(sim)->text);
    nsdae_sim_get_record(sim, &r);
    if (i < 400) continue; /* the first contact is found a step of travel late */
    depth = fmax(depth, r.penetration);
    worst = fmax(worst, fabs(FIRST * r.q[2] + SECOND * r.q[5]));
    least = fmin(least, -r.v[5] / r.v[2]);
    most = fmax(most, -r.v[5] / r.v[2]);
  }
  play += depth * 2 / (module * cos(pressure));
  print_message("method %d: %.3f turns, ratio in the mean %.6f of %.6f, at a moment %.3f to %.3f; "
                "play %.4f of %.4f\n",
                method, r.q[2] / (2 * pi), -r.q[5] / r.q[2], (double)FIRST / SECOND, least, most,
                worst, play);
  assert_true(depth < 5e-5);
  assert_true(r.q[2] > 1.9 * 2 * pi);
  assert_true(worst < play);
  assert_near(-r.q[5] / r.q[2], (double)FIRST / SECOND, play / FIRST / r.q[2]);
  nsdae_sim_destroy(&sim);
  nsdae_system_destroy(&system);
  nsdae_bodies_destroy(&b);
}

static void test_gears(void **state)
{
  (void)state;
  mesh(NSDAE_METHOD_MOREAU);
  mesh(NSDAE_METHOD_IMPLICIT);
}

int main(void)
{
  const struct CMUnitTest tests[] = {cmocka_unit_test(test_gears)};
  return cmocka_run_group_tests(tests, NULL, NULL);
}
