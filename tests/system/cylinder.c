/* Cylinders: gaps against other formulas, derivatives, and by event one that rolls
 * down an incline and coins that roll steadily, against closed forms. */
#include "check.h"

#include <stdlib.h>
#include <string.h>

#include <nsdae/nsdae.h>

#include "random.h"

static uint64_t seed = 9;

static double uniform(double low, double high)
{
  return random_between(&seed, low, high);
}

static nsdae_solid cylinder(double radius, double length)
{
  return (nsdae_solid){
      .shape = NSDAE_SHAPE_CYLINDER, .radius = radius, .length = {0, 0, length}, .material = 1};
}

/* A system of a cylinder and another solid of this shape, each of a body in a random pose. */
static nsdae_bodies *couple(int shape, const nsdae_solid *one, nsdae_solid *other, double *q,
                            double *v)
{
  nsdae_bodies *b;
  assert_int_equal(nsdae_bodies_create(3, &b, NULL), NSDAE_OK);
  *other = (nsdae_solid){.shape = shape, .radius = shape == NSDAE_SHAPE_SPHERE ? 0.2 : 0};
  for (int i = 0; i < 2; i++) {
    nsdae_bodies_add(b, &(nsdae_rigid_body){.mass = 1, .inertia = {1, 1, 1}});
    nsdae_bodies_add_solid(b, i, i ? other : one);
  }
  nsdae_bodies_add_contact(b, 0, 1, 0.3, 0, 0);
  for (int i = 0; i < 14; i++) q[i] = uniform(-1, 1);
  for (int i = 0; i < 12; i++) v[i] = uniform(-1, 1);
  return b;
}

static void column(const double *p, int axis, double *x)
{
  double e[4] = {0, 0, 0, 0}, r[4], s = 0;
  e[1 + axis] = 1;
  for (int i = 0; i < 4; i++) s += p[i] * p[i];
  r[0] = -p[1] * e[1] - p[2] * e[2] - p[3] * e[3];
  for (int i = 0; i < 3; i++) {
    int j = (i + 1) % 3, k = (i + 2) % 3;
    r[1 + i] = p[0] * e[1 + i] + p[1 + j] * e[1 + k] - p[1 + k] * e[1 + j];
  }
  for (int i = 0; i < 3; i++) {
    int j = (i + 1) % 3, k = (i + 2) % 3;
    x[i] = (-r[0] * p[1 + i] + r[1 + i] * p[0] - r[1 + j] * p[1 + k] + r[1 + k] * p[1 + j]) / s;
  }
}

/* The other solid from the cylinder: the height d . n over a plane z <= 0 and the cosine n . a; the
 * way of a point across the axis, and how far it is beside the side and beyond the cap. */
typedef struct relation {
  double height, cosine, sine, across, beside, beyond;
} relation;

static relation relate(const nsdae_solid *one, const double *q)
{
  double a[3], n[3], d[3], dn = 0, da = 0, na = 0, dd = 0;
  column(q + 3, 2, a);
  column(q + 10, 2, n);
  for (int i = 0; i < 3; i++) {
    d[i] = q[i] - q[7 + i];
    dn += d[i] * n[i];
    da += d[i] * a[i];
    na += a[i] * n[i];
    dd += d[i] * d[i];
  }
  double across = sqrt(fmax(0, dd - da * da));
  return (relation){dn,
                    fabs(na),
                    sqrt(fmax(0, 1 - na * na)),
                    across,
                    across - one->radius,
                    fabs(da) - one->length[2] / 2};
}

/* Of a plane z <= 0 the support of the cylinder, n . d - |n . a| h / 2 - r |n x a|; of a ball its
 * distance in the coordinates across and along the axis. */
static double gap_of(const nsdae_solid *one, const nsdae_solid *other, const double *q)
{
  const relation r = relate(one, q);
  if (other->shape == NSDAE_SHAPE_PLANE)
    return r.height - r.cosine * one->length[2] / 2 - one->radius * r.sine;
  double apart =
      r.beside > 0 && r.beyond > 0 ? hypot(r.beside, r.beyond) : fmax(r.beside, r.beyond);
  return apart - other->radius;
}

/* How near the pose is to one where the gap has no derivatives: the axis along or across the normal
 * of a plane, or tilted by the sine 0.1 at which points of the rim come and go; a point on the axis
 * or between two parts of the surface. */
static double sharpness(const nsdae_solid *one, const nsdae_solid *other, const double *q)
{
  const relation r = relate(one, q);
  if (other->shape == NSDAE_SHAPE_PLANE) return fmin(fmin(r.cosine, r.sine), fabs(r.sine - 0.1));
  double part = r.beside > 0 || r.beyond > 0 ? INFINITY : fabs(r.beside - r.beyond);
  if (r.beyond > 0) part = fmin(part, fabs(r.beside));
  if (r.beside > 0) part = fmin(part, fabs(r.beyond));
  return fmin(part, r.across);
}

static void test_gaps(void **state)
{
  const int shapes[] = {NSDAE_SHAPE_PLANE, NSDAE_SHAPE_SPHERE, NSDAE_SHAPE_POINT};
  (void)state;
  for (int k = 0; k < 3000; k++) {
    const nsdae_solid one = cylinder(uniform(0.1, 1), uniform(0.1, 1));
    nsdae_solid other;
    double q[14], v[12], g[8], least = INFINITY;
    nsdae_bodies *b = couple(shapes[k % 3], &one, &other, q, v);
    nsdae_system *system;
    nsdae_dims dims;
    nsdae_check worst;
    if (k % 7 == 0) /* the axis along the normal, or across it */
      for (int i = 0; i < 8; i++) q[i < 4 ? 3 + i : 6 + i] = i % 4 == 0 || (i == 5 && k % 2);
    assert_true(nsdae_bodies_system(b, &system) >= 0);
    nsdae_bodies_get_dims(b, &dims);
    assert_int_equal(dims.k, k % 3 ? 1 : 8);
    nsdae_sim *sim;
    nsdae_record r;
    nsdae_sim_options o;
    nsdae_sim_options_default(&o);
    o.start_tol = 10;
    o.method = NSDAE_METHOD_MOREAU;
    assert_int_equal(nsdae_sim_create(system, &o, &sim, NULL), NSDAE_OK);
    assert_true(nsdae_sim_init(sim, 0, q, v) >= 0);
    nsdae_sim_get_record(sim, &r);
    memcpy(g, r.gap, (size_t)dims.k * sizeof *g);
    for (int i = 0; i < dims.k; i++) least = fmin(least, g[i]);
    /* a fixed contact that is not there has the size of both for its gap */
    double size = hypot(one.radius, one.length[2] / 2), exact = gap_of(&one, &other, q);
    if (k % 3 || exact < size) assert_near(least, exact, 1e-12);
    nsdae_sim_destroy(&sim);
    /* within 0.02 of a sharp place its curvature is too large for differences, or they reach it */
    if (sharpness(&one, &other, q) > 0.02 && nsdae_system_check(system, 0, q, v, 1e-7, &worst) < 0)
      fail_msg("pose %d: %s", k, nsdae_system_error(system)->text);
    nsdae_system_destroy(&system);
    nsdae_bodies_destroy(&b);
  }
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

static void test_inertia(void **state)
{
  const double r = 0.3, h = 0.7, density = 5, exact = density * acos(-1) * r * r * h;
  const nsdae_solid solid = cylinder(r, h);
  double mass, inertia[3];
  (void)state;
  assert_int_equal(nsdae_solid_inertia(&solid, density, &mass, inertia, NULL), NSDAE_OK);
  assert_near(mass, exact, 1e-14);
  for (int i = 0; i < 2; i++) assert_near(inertia[i], exact * (3 * r * r + h * h) / 12, 1e-14);
  assert_near(inertia[2], exact * r * r / 2, 1e-14);
}

int main(void)
{
  const struct CMUnitTest tests[] = {cmocka_unit_test(test_gaps), cmocka_unit_test(test_incline),
                                     cmocka_unit_test(test_coin), cmocka_unit_test(test_stands),
                                     cmocka_unit_test(test_inertia)};
  return cmocka_run_group_tests(tests, NULL, NULL);
}
