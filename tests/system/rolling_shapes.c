/* Smooth shapes on a plane by event, against closed forms and quadratures: a cylinder that rolls
 * down an incline, coins with and without thickness that roll steadily, a frictionless disc that
 * nutates, an ellipsoid that rocks and a cone that rolls about its apex. Gaps and derivatives:
 * tests/unit/bodies/smooth.c. */
#include "check.h"

#include <nsdae/nsdae.h>

static nsdae_solid cylinder(double radius, double length)
{
  return (nsdae_solid){
      .shape = NSDAE_SHAPE_CYLINDER, .radius = radius, .length = {0, 0, length}, .material = 1};
}

/* ---- motions by event */

/* A solid on the floor, with its mass by density; the body becomes that of its centre of mass. */
static nsdae_sim *roll(const nsdae_solid *solid, nsdae_rigid_body *body, double mu,
                       const double *gravity, nsdae_bodies **b, nsdae_system **system)
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
  assert_int_equal(nsdae_body_from_solids(1, &own, &density, body, NULL), NSDAE_OK);
  assert_int_equal(nsdae_bodies_create(3, b, NULL), NSDAE_OK);
  nsdae_bodies_set_gravity(*b, gravity);
  nsdae_bodies_add_solid(*b, NSDAE_GROUND, &(nsdae_solid){.shape = NSDAE_SHAPE_PLANE});
  nsdae_bodies_add_solid(*b, nsdae_bodies_add(*b, body), &own);
  nsdae_bodies_set_pair(*b, 0, 1, mu, 0, 0);
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

/* The axis z of a body. */
static void axis_of(const double *q, double *a)
{
  const double *p = q + 3;
  double s = p[0] * p[0] + p[1] * p[1] + p[2] * p[2] + p[3] * p[3];
  a[0] = 2 * (p[1] * p[3] + p[0] * p[2]) / s;
  a[1] = 2 * (p[2] * p[3] - p[0] * p[1]) / s;
  a[2] = 1 - 2 * (p[1] * p[1] + p[2] * p[2]) / s;
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
  nsdae_sim *sim = roll(&solid, &body, 0.8, gravity, &b, &system);
  if (nsdae_sim_run(sim, 1) < 0) fail_msg("%s", nsdae_sim_error(sim)->text);
  nsdae_sim_get_record(sim, &record);
  print_message("incline: off by %.1e m\n", record.q[0] - g * sin(alpha) / 3);
  assert_near(record.q[0], g * sin(alpha) / 3, 1e-8);
  assert_near(record.v[5], 2 * g * sin(alpha) / 3 / r, 1e-7);
  assert_near(record.q[2], r, 1e-8);
  end(b, system, sim);
}

/* A cylinder that rolls with 1 m/s, x = t, by the time-stepping methods: ends of runs that are a
 * sum of steps and leave the grid of steps by rounding, and runs of any shorter length. */
static void test_ends(void **state)
{
  const double gravity[3] = {0, 0, -9.81}, r = 0.2;
  const nsdae_solid solid = cylinder(r, 0.02);
  nsdae_rigid_body body = {.position = {0, 0, r},
                           .quaternion = {sqrt(0.5), -sqrt(0.5)},
                           .velocity = {1},
                           .spin = {0, 0, 1 / r}};
  const int method[] = {NSDAE_METHOD_IMPLICIT, NSDAE_METHOD_MOREAU};
  nsdae_bodies *b;
  nsdae_system *system;
  nsdae_record record;
  nsdae_sim_options o;
  double q[7], v[6], t = 0;
  (void)state;
  nsdae_sim *sim = roll(&solid, &body, 0.6, gravity, &b, &system);
  nsdae_bodies_get_start(b, q, v);
  for (int m = 0; m < 2; m++) {
    nsdae_sim_destroy(&sim);
    nsdae_sim_options_default(&o);
    o.method = method[m];
    o.dt = 7e-4;
    assert_int_equal(nsdae_sim_create(system, &o, &sim, NULL), NSDAE_OK);
    assert_int_equal(nsdae_sim_init(sim, 0, q, v), NSDAE_OK);
    t = 0;
    for (int i = 0; i < 9000; i++)
      if (nsdae_sim_run(sim, t += o.dt) != NSDAE_OK) fail_msg("%s", nsdae_sim_error(sim)->text);
    nsdae_stats stats;
    nsdae_sim_get_stats(sim, &stats);
    assert_int_equal(stats.steps, 9000);
    for (double h = 1e-3; h > 1e-14; h /= 10)
      if (nsdae_sim_run(sim, t += h) != NSDAE_OK) fail_msg("%s", nsdae_sim_error(sim)->text);
    nsdae_sim_get_record(sim, &record);
    print_message("ends, method %d: off by %.1e m\n", m, record.q[0] - t);
    assert_true(record.time == t);
    assert_near(record.q[0], t, 1e-9);
  }
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
  /* the last is Euler's disc: its centre is at rest, Omega^2 = 4 g / (r sin(theta)) */
  for (int k = 0; k < 5; k++) {
    const double h = k < 3 ? (k == 0 ? 1e-3 : 0.02) : 0, theta = k == 4 ? 0.02 : k == 2 ? 0.9 : 1.2;
    const double rho = k == 4 ? 0 : 0.3, t = k == 4 ? 0.2 : 1;
    const double c = cos(theta), s = sin(theta), cr = r * c - h / 2 * s, H = h / 2 * c + r * s;
    const double along = m * r * r / 2, across = m * (r * r / 4 + h * h / 12);
    double rate =
        sqrt(m * g * cr / (m * H * rho + s * (along * (rho + cr) / r - (along - across) * c)));
    double spin = -rate * (rho + cr) / r;
    nsdae_solid solid = cylinder(r, h);
    if (h == 0) solid.shape = NSDAE_SHAPE_DISC;
    nsdae_rigid_body body = {.position = {rho, 0, H},
                             .quaternion = {cos(theta / 2), 0, sin(theta / 2)},
                             .velocity = {0, rate * rho},
                             .spin = {-rate * s, 0, rate * c + spin}};
    nsdae_bodies *b;
    nsdae_system *system;
    nsdae_record record;
    nsdae_sim *sim = roll(&solid, &body, 0.8, gravity, &b, &system);
    if (nsdae_sim_run(sim, t) < 0) fail_msg("%s", nsdae_sim_error(sim)->text);
    nsdae_sim_get_record(sim, &record);
    double x = rho * cos(rate * t), y = rho * sin(rate * t);
    print_message("coin %d: off by %.1e, %.1e, %.1e m\n", k, record.q[0] - x, record.q[1] - y,
                  record.q[2] - H);
    assert_near(record.q[0], x, 1e-8);
    assert_near(record.q[1], y, 1e-8);
    assert_near(record.q[2], H, 1e-8);
    double a[3];
    axis_of(record.q, a);
    assert_near(a[0], s * cos(rate * t), 1e-8);
    assert_near(a[1], s * sin(rate * t), 1e-8);
    assert_near(a[2], c, 1e-8);
    end(b, system, sim);
  }
}

/* A frictionless disc whose axis is at the angle theta to the vertical keeps its momenta about the
 * vertical and the axis, p and s, and with D = I_t + m r^2 cos^2(theta) the energy
 *
 *   E = D theta'^2 / 2 + V,  V = (p - s cos(theta))^2 / (2 I_t sin^2(theta)) + m g r sin(theta)
 *
 * From one angle of rest to the other, u and w, E - V = (theta - u) (w - theta) f, and time and
 * turn about the vertical are sums over Chebyshev's points. */
static double potential(const double *par, double theta)
{
  const double p = par[0], s = par[1], It = par[2], mgr = par[3];
  return pow((p - s * cos(theta)) / sin(theta), 2) / (2 * It) + mgr * sin(theta);
}

/* The other angle where the potential is E. */
static double other_rest(const double *par, double u, double E)
{
  double low = u, high = u, step = potential(par, u + 1e-3) < E ? 1e-3 : -1e-3;
  do {
    low = high;
    high += step;
  } while (potential(par, high) < E);
  for (int i = 0; i < 60; i++) {
    double middle = (low + high) / 2;
    if (potential(par, middle) < E)
      low = middle;
    else
      high = middle;
  }
  return low;
}

static void test_nutation(void **state)
{
  enum { POINTS = 60 };
  const double g = 9.81, r = 0.1, gravity[3] = {0, 0, -g}, u = 1, spin = 12, precession = 4;
  const nsdae_solid solid = {.shape = NSDAE_SHAPE_DISC, .radius = r, .material = 1};
  nsdae_rigid_body body = {.position = {0, 0, r * sin(u)},
                           .quaternion = {cos(u / 2), 0, sin(u / 2)},
                           .spin = {-precession * sin(u), 0, precession * cos(u) + spin}};
  nsdae_bodies *b;
  nsdae_system *system;
  nsdae_record record;
  (void)state;
  nsdae_sim *sim = roll(&solid, &body, 0, gravity, &b, &system);
  const double m = body.mass, It = body.inertia[0], Ia = body.inertia[2];
  const double s = Ia * (precession * cos(u) + spin);
  const double p = s * cos(u) + It * precession * sin(u) * sin(u);
  const double par[4] = {p, s, It, m * g * r}, E = potential(par, u), w = other_rest(par, u, E);
  double t = 0, phi = 0, a[3];
  for (int i = 0; i < POINTS; i++) {
    double theta = (u + w) / 2 + (w - u) / 2 * cos(acos(-1) * (i + 0.5) / POINTS);
    double f = (E - potential(par, theta)) / ((theta - u) * (w - theta));
    double D = It + m * r * r * cos(theta) * cos(theta);
    double dt = acos(-1) / POINTS * sqrt(D / (2 * f));
    t += dt;
    phi += dt * (p - s * cos(theta)) / (It * sin(theta) * sin(theta));
  }
  if (nsdae_sim_run(sim, t) < 0) fail_msg("%s", nsdae_sim_error(sim)->text);
  nsdae_sim_get_record(sim, &record);
  axis_of(record.q, a);
  print_message("disc: from %.3f to %.3f in %.3f s, turned by %.3f; off by %.1e, %.1e\n", u, w, t,
                phi, a[0] - sin(w) * cos(phi), a[1] - sin(w) * sin(phi));
  assert_near(a[0], sin(w) * cos(phi), 1e-8);
  assert_near(a[1], sin(w) * sin(phi), 1e-8);
  assert_near(record.q[2], r * sin(w), 1e-8);
  for (int i = 0; i < 2; i++) assert_near(record.q[i], 0, 1e-9);
  end(b, system, sim);
}

/* An ellipsoid that rolls to and fro about its middle axis. At the tilt phi its centre is
 * h = sqrt(a^2 sin^2 + b^2 cos^2) above the floor and c from the place of contact,
 * c^2 = (a^4 sin^2 + b^4 cos^2) / h^2:
 *
 *   (I + m c^2) phi'^2 / 2 + m g h = m g h(phi_0)
 *
 * A quarter of the period, by Chebyshev's points in phi / phi_0; after it phi = 0. */
static void test_ellipsoid(void **state)
{
  enum { POINTS = 100 };
  const double g = 9.81, gravity[3] = {0, 0, -g}, a = 0.15, c = 0.1, phi0 = 0.6;
  const double most = hypot(a * sin(phi0), c * cos(phi0));
  const nsdae_solid solid = {
      .shape = NSDAE_SHAPE_ELLIPSOID, .length = {2 * a, 0.24, 2 * c}, .material = 1};
  nsdae_rigid_body body = {.position = {0, 0, most},
                           .quaternion = {cos(phi0 / 2), 0, sin(phi0 / 2)}};
  nsdae_bodies *b;
  nsdae_system *system;
  nsdae_record record;
  double t = 0, z[3];
  (void)state;
  nsdae_sim *sim = roll(&solid, &body, 0.9, gravity, &b, &system);
  const double m = body.mass, I = body.inertia[1];
  for (int i = 0; i < POINTS; i++) { /* over -phi_0 .. phi_0: half a period */
    double phi = phi0 * cos(acos(-1) * (i + 0.5) / POINTS), s = sin(phi), k = cos(phi);
    double h = hypot(a * s, c * k), square = (pow(a, 4) * s * s + pow(c, 4) * k * k) / (h * h);
    double f = m * g * (most - h) / (phi0 * phi0 - phi * phi);
    t += acos(-1) / POINTS * sqrt((I + m * square) / (2 * f)) / 2;
  }
  if (nsdae_sim_run(sim, t) < 0) fail_msg("%s", nsdae_sim_error(sim)->text);
  nsdae_sim_get_record(sim, &record);
  double rate = sqrt(2 * m * g * (most - c) / (I + m * c * c));
  axis_of(record.q, z);
  print_message("ellipsoid: a quarter of the period is %.6f s, off by %.1e rad\n", t, z[0]);
  assert_near(z[0], 0, 1e-8);
  assert_near(z[1], 0, 1e-12);
  assert_near(record.q[2], c, 1e-9);
  assert_near(record.v[4], -rate, 1e-7);
  end(b, system, sim);
}

/* A cone of the half angle beta that rolls on its side about its apex at the rate Omega: its axis
 * from the apex is d = cos(beta) e_r + sin(beta) e_z, and omega = -Omega cot(beta) e_r is along the
 * line of contact. */
static void test_cone(void **state)
{
  const double gravity[3] = {0, 0, -9.81}, beta = 0.4, h = 0.2, rate = 2, t = 1;
  const double c = cos(beta), s = sin(beta), turn = -(acos(0) + beta) / 2;
  const nsdae_solid solid = {
      .shape = NSDAE_SHAPE_CONE, .radius = h * tan(beta), .length = {0, 0, h}, .material = 1};
  nsdae_rigid_body body = {.position = {h / 2 * c, 0, h / 2 * s},
                           .quaternion = {cos(turn), 0, sin(turn)},
                           .velocity = {0, rate * 0.75 * h * c},
                           .spin = {rate * c, 0, rate * c * c / s}};
  nsdae_bodies *b;
  nsdae_system *system;
  nsdae_record record;
  (void)state;
  nsdae_sim *sim = roll(&solid, &body, 0.8, gravity, &b, &system);
  if (nsdae_sim_run(sim, t) < 0) fail_msg("%s", nsdae_sim_error(sim)->text);
  nsdae_sim_get_record(sim, &record);
  const double exact[3] = {c * cos(rate * t), c * sin(rate * t), s};
  double a[3];
  axis_of(record.q, a);
  print_message("cone: off by %.1e, %.1e, %.1e m\n", record.q[0] - 0.75 * h * exact[0],
                record.q[1] - 0.75 * h * exact[1], record.q[2] - 0.75 * h * exact[2]);
  for (int i = 0; i < 3; i++) {
    assert_near(record.q[i], 0.75 * h * exact[i], 1e-8);
    assert_near(a[i], -exact[i], 1e-7);
  }
  end(b, system, sim);
}

/* The published period of small oscillations about the middle axis, with k the radius of gyration
 * and rho = a^2 / c the radius of curvature at the lowest point (E. J. Routh, Dynamics of a system
 * of rigid bodies, elementary part, 1905, on rocking stones):
 *
 *   T = 2 pi sqrt((k^2 + c^2) / (g (rho - c))),   in error by O(phi_0^2) of it */
static void test_small_oscillation(void **state)
{
  const double g = 9.81, gravity[3] = {0, 0, -g}, a = 0.15, c = 0.1, phi0 = 1e-5;
  const nsdae_solid solid = {
      .shape = NSDAE_SHAPE_ELLIPSOID, .length = {2 * a, 0.24, 2 * c}, .material = 1};
  nsdae_rigid_body body = {.position = {0, 0, hypot(a * sin(phi0), c * cos(phi0))},
                           .quaternion = {cos(phi0 / 2), 0, sin(phi0 / 2)}};
  nsdae_bodies *b;
  nsdae_system *system;
  nsdae_record record;
  double z[3];
  (void)state;
  nsdae_sim *sim = roll(&solid, &body, 0.9, gravity, &b, &system);
  const double square = body.inertia[1] / body.mass + c * c;
  const double omega = sqrt(g * (a * a / c - c) / square), t = acos(-1) / 3 / omega;
  if (nsdae_sim_run(sim, t) < 0) fail_msg("%s", nsdae_sim_error(sim)->text);
  nsdae_sim_get_record(sim, &record);
  axis_of(record.q, z);
  print_message("ellipsoid: period %.6f s, phase off by %.1e\n", 2 * acos(-1) / omega,
                (z[0] / phi0 - 0.5) / sqrt(0.75));
  assert_near(z[0] / phi0, 0.5, 1e-8);
  end(b, system, sim);
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
    nsdae_sim *sim = roll(&solid, &body, 0.8, gravity, &b, &system);
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
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(test_incline),   cmocka_unit_test(test_ends),
      cmocka_unit_test(test_coin),      cmocka_unit_test(test_nutation),
      cmocka_unit_test(test_ellipsoid), cmocka_unit_test(test_small_oscillation),
      cmocka_unit_test(test_cone),      cmocka_unit_test(test_stands)};
  return cmocka_run_group_tests(tests, NULL, NULL);
}
