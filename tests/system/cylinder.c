/* Cylinders by event: one that rolls down an incline and coins that roll steadily, against closed
 * forms. Gaps and derivatives: tests/unit/bodies/smooth.c. */
#include "check.h"

#include <nsdae/nsdae.h>

static nsdae_solid cylinder(double radius, double length)
{
  return (nsdae_solid){
      .shape = NSDAE_SHAPE_CYLINDER, .radius = radius, .length = {0, 0, length}, .material = 1};
}

/* ---- motions by event */

/* A cylinder on the floor, with its mass by density. */
static nsdae_sim *roll(const nsdae_solid *solid, nsdae_rigid_body *body, const double *gravity,
                       nsdae_bodies **b, nsdae_system **system)
{
  const double density = 1000;
  nsdae_sim *sim;
  nsdae_error error;
  nsdae_sim_options o;
  double q[7], v[6];
  nsdae_solid own = *solid;
  nsdae_sim_options_default(&o);
  o.method = NSDAE_METHOD_EVENT;
  o.dt = 0.01;
  o.rtol = 1e-11;
  o.atol = 1e-13;
  nsdae_rigid_body made = *body;
  assert_int_equal(nsdae_body_from_solids(1, &own, &density, &made, NULL), NSDAE_OK);
  assert_int_equal(nsdae_bodies_create(3, b, NULL), NSDAE_OK);
  nsdae_bodies_set_gravity(*b, gravity);
  nsdae_bodies_add_solid(*b, NSDAE_GROUND, &(nsdae_solid){.shape = NSDAE_SHAPE_PLANE});
  nsdae_bodies_add_solid(*b, nsdae_bodies_add(*b, &made), &own);
  nsdae_bodies_set_pair(*b, 0, 1, 0.8, 0, 0);
  if (nsdae_bodies_system(*b, system) < 0) fail_msg("%s", nsdae_bodies_error(*b)->text);
  nsdae_bodies_get_start(*b, q, v);
  if (nsdae_sim_create(*system, &o, &sim, &error) < 0) fail_msg("%s", error.text);
  if (nsdae_sim_init(sim, 0, q, v) < 0) fail_msg("%s", nsdae_sim_error(sim)->text);
  return sim;
}

static void end(nsdae_bodies *b, nsdae_system *system, nsdae_sim *sim)
{
  nsdae_sim_destroy(&sim);
  nsdae_system_destroy(&system);
  nsdae_bodies_destroy(&b);
}

/* s = g sin(alpha) t^2 / 3, for J = m r^2 / 2 */
static void test_incline(void **state)
{
  const double g = 9.81, alpha = 0.3, r = 0.1, gravity[3] = {g * sin(alpha), 0, -g * cos(alpha)};
  const nsdae_solid solid = cylinder(r, 0.3);
  nsdae_rigid_body body = {.position = {0, 0, r}, .quaternion = {sqrt(0.5), -sqrt(0.5)}};
  nsdae_bodies *b;
  nsdae_system *system;
  nsdae_record record;
  (void)state;
  nsdae_sim *sim = roll(&solid, &body, gravity, &b, &system);
  if (nsdae_sim_run(sim, 1) < 0) fail_msg("%s", nsdae_sim_error(sim)->text);
  nsdae_sim_get_record(sim, &record);
  print_message("incline: off by %.1e m\n", record.q[0] - g * sin(alpha) / 3);
  assert_near(record.q[0], g * sin(alpha) / 3, 1e-8);
  assert_near(record.v[5], 2 * g * sin(alpha) / 3 / r, 1e-7);
  assert_near(record.q[2], r, 1e-8);
  end(b, system, sim);
}

/* A coin of thickness h whose axis a is at the angle theta to the vertical e_z, its centre on a
 * circle of radius rho with the rate Omega: with e_r from the middle of the circle,
 *
 *   c = c_r e_r - H e_z  from the centre to the ground,  c_r = r cos(theta) - h/2 sin(theta)
 *   omega = Omega e_z + sigma a,  no slip:  sigma = -Omega (rho + c_r) / r
 *   force  F = -m Omega^2 rho e_r + m g e_z,  moment of momentum  L' = Omega e_z x L = c x F:
 *   Omega^2 (m H rho + sin(theta) (I_a (rho + c_r) / r - (I_a - I_t) cos(theta))) = m g c_r */
static void test_coin(void **state)
{
  const double g = 9.81, gravity[3] = {0, 0, -g}, r = 0.1, m = 1;
  (void)state;
  for (int k = 0; k < 3; k++) {
    const double h = k == 0 ? 1e-3 : 0.02, theta = k == 2 ? 0.9 : 1.2, rho = 0.3;
    const double c = cos(theta), s = sin(theta), cr = r * c - h / 2 * s, H = h / 2 * c + r * s;
    const double along = m * r * r / 2, across = m * (r * r / 4 + h * h / 12);
    double rate =
        sqrt(m * g * cr / (m * H * rho + s * (along * (rho + cr) / r - (along - across) * c)));
    double spin = -rate * (rho + cr) / r;
    const nsdae_solid solid = cylinder(r, h);
    nsdae_rigid_body body = {.position = {rho, 0, H},
                             .quaternion = {cos(theta / 2), 0, sin(theta / 2)},
                             .velocity = {0, rate * rho},
                             .spin = {-rate * s, 0, rate * c + spin}};
    nsdae_bodies *b;
    nsdae_system *system;
    nsdae_record record;
    nsdae_sim *sim = roll(&solid, &body, gravity, &b, &system);
    const double t = 1;
    if (nsdae_sim_run(sim, t) < 0) fail_msg("%s", nsdae_sim_error(sim)->text);
    nsdae_sim_get_record(sim, &record);
    double x = rho * cos(rate * t), y = rho * sin(rate * t);
    print_message("coin %d: off by %.1e, %.1e, %.1e m\n", k, record.q[0] - x, record.q[1] - y,
                  record.q[2] - H);
    assert_near(record.q[0], x, 1e-8);
    assert_near(record.q[1], y, 1e-8);
    assert_near(record.q[2], H, 1e-8);
    end(b, system, sim);
  }
}

/* Released on its rim with a small tilt it comes to stand on its cap; by event one that stands
 * stays. */
static void test_stands(void **state)
{
  const nsdae_solid solid = cylinder(0.1, 0.15);
  (void)state;
  for (int k = 0; k < 3; k++) {
    const double gravity[3] = {0, 0, -9.81}, tilt = k < 2 ? 0.2 : 0;
    const int method[] = {NSDAE_METHOD_IMPLICIT, NSDAE_METHOD_MOREAU, NSDAE_METHOD_EVENT};
    nsdae_rigid_body body = {.position = {0, 0, 0.075 * cos(tilt) + 0.1 * sin(tilt)},
                             .quaternion = {cos(tilt / 2), 0, sin(tilt / 2)}};
    nsdae_bodies *b;
    nsdae_system *system;
    nsdae_record r;
    nsdae_sim_options o;
    nsdae_sim *sim = roll(&solid, &body, gravity, &b, &system);
    double q[7], v[6];
    nsdae_bodies_get_start(b, q, v);
    nsdae_sim_destroy(&sim);
    nsdae_sim_options_default(&o);
    o.method = method[k];
    o.dt = k < 2 ? 1e-3 : 0.01;
    assert_int_equal(nsdae_sim_create(system, &o, &sim, NULL), NSDAE_OK);
    assert_true(nsdae_sim_init(sim, 0, q, v) >= 0);
    if (nsdae_sim_run(sim, 2) < 0) fail_msg("%s", nsdae_sim_error(sim)->text);
    nsdae_sim_get_record(sim, &r);
    print_message("stands at %.9f m, kinetic energy %.1e J\n", r.q[2], r.kinetic);
    assert_near(r.q[2], 0.075, k < 2 ? 1e-4 : 1e-9);
    assert_true(r.kinetic < 1e-9);
    end(b, system, sim);
  }
}

int main(void)
{
  const struct CMUnitTest tests[] = {cmocka_unit_test(test_incline), cmocka_unit_test(test_coin),
                                     cmocka_unit_test(test_stands)};
  return cmocka_run_group_tests(tests, NULL, NULL);
}
