/* Driven joints: each kind that has one motion, between two bodies that move in space themselves,
 * follows f(t) and f'(t) to the integrator's tolerance, read off the poses by formulas of this
 * file; what the joint leaves free moves by itself. */
#include "check.h"

#include <nsdae/nsdae.h>

enum { NQ_MAX = 14, NV_MAX = 12 };

static const double amplitude = 0.2, rate = 3, ratio = -1.5;

/* 1 - cos: from rest, so that the start keeps the constraints. user: f(0). */
static int drive(double t, double f[3], void *user)
{
  f[0] = *(double *)user + amplitude * (1 - cos(rate * t));
  f[1] = amplitude * rate * sin(rate * t);
  f[2] = amplitude * rate * rate * cos(rate * t);
  return 0;
}

/* R s of a body with coordinates q, by Rodrigues' formula of its quaternion. */
static void turned(int d, const double *q, const double *s, double *x)
{
  if (d == 2) {
    x[0] = cos(q[2]) * s[0] - sin(q[2]) * s[1];
    x[1] = sin(q[2]) * s[0] + cos(q[2]) * s[1];
    x[2] = 0;
    return;
  }
  const double *p = q + 3;
  double u[3], length = p[0] * p[0] + p[1] * p[1] + p[2] * p[2] + p[3] * p[3];
  for (int i = 0; i < 3; i++) {
    int j = (i + 1) % 3, k = (i + 2) % 3;
    u[i] = p[1 + j] * s[k] - p[1 + k] * s[j];
  }
  for (int i = 0; i < 3; i++) {
    int j = (i + 1) % 3, k = (i + 2) % 3;
    x[i] = s[i] + 2 * (p[0] * u[i] + p[1 + j] * u[k] - p[1 + k] * u[j]) / length;
  }
}

/* The way between the bodies' centres along an axis of body 0; both are at the origin at first but
 * for DISTANCE. */
static double way(int d, const double *q, const double *axis)
{
  double a[3], sum = 0;
  turned(d, q, axis, a);
  const double *other = q + (d == 2 ? 3 : 7);
  for (int i = 0; i < d; i++) sum += a[i] * (other[i] - q[i]);
  return sum;
}

/* The angle of body 1's y axis against that of body 0, about z of body 0. */
static double angle_about_z(const double *q)
{
  const double x[3] = {1, 0, 0}, y[3] = {0, 1, 0};
  double x0[3], y0[3], y1[3], along = 0, across = 0;
  turned(3, q, x, x0);
  turned(3, q, y, y0);
  turned(3, q + 7, y, y1);
  for (int i = 0; i < 3; i++) {
    along += y1[i] * y0[i];
    across += y1[i] * x0[i];
  }
  return atan2(-across, along);
}

static double motion(int d, int kind, const double *q)
{
  const double x[3] = {1, 0, 0}, z[3] = {0, 0, 1};
  double square = 0;
  switch (kind) {
  case NSDAE_JOINT_REVOLUTE:
    return d == 2 ? q[5] - q[2] : angle_about_z(q);
  case NSDAE_JOINT_DISTANCE:
    for (int i = 0; i < d; i++) square += pow(q[(d == 2 ? 3 : 7) + i] - q[i], 2);
    return sqrt(square);
  case NSDAE_JOINT_GEAR:
    return q[5] - ratio * q[2];
  default:
    return way(d, q, d == 2 ? x : z);
  }
}

static void follow(int d, int kind, int method, double dt, double tol)
{
  double from = kind == NSDAE_JOINT_DISTANCE ? 0.5 : 0, q0[NQ_MAX], v0[NV_MAX];
  nsdae_bodies *b;
  nsdae_system *system;
  nsdae_sim *sim;
  nsdae_record r;
  nsdae_sim_options options;
  assert_int_equal(nsdae_bodies_create(d, &b, NULL), NSDAE_OK);
  nsdae_bodies_set_gravity(b, (const double[]){0.3, -1, 0});
  for (int i = 0; i < 2; i++)
    nsdae_bodies_add(
        b, &(nsdae_rigid_body){.mass = 1 + i,
                               .inertia = {0.4, 0.5, 0.6 + i},
                               .position = {i * from},
                               .spin = {0, 0, kind == NSDAE_JOINT_GEAR && i ? ratio * 0.4 : 0.4}});
  nsdae_bodies_add_joint(b, &(nsdae_joint){.kind = kind,
                                           .body = {0, 1},
                                           .end = {from},
                                           .axis = {d == 2, 0, d == 3},
                                           .ratio = ratio,
                                           .drive = drive,
                                           .user = &from});
  int status = nsdae_bodies_system(b, &system);
  if (status < 0) print_error("%s\n", nsdae_bodies_error(b)->text);
  assert_int_equal(status, NSDAE_OK);
  nsdae_bodies_get_start(b, q0, v0);
  nsdae_sim_options_default(&options);
  options.method = method;
  options.dt = dt;
  options.rtol = 1e-10;
  options.atol = 1e-12;
  status = nsdae_sim_create(system, &options, &sim, NULL);
  if (status != NSDAE_E_UNSUPPORTED) { /* event needs SUNDIALS */
    double f[3];
    int nq = d == 2 ? 3 : 7;
    assert_int_equal(status, NSDAE_OK);
    assert_int_equal(nsdae_sim_init(sim, 0, q0, v0), NSDAE_OK);
    status = nsdae_sim_run(sim, 1);
    if (status < 0) print_error("%s\n", nsdae_sim_error(sim)->text);
    assert_true(status >= 0);
    nsdae_sim_get_record(sim, &r);
    drive(r.time, f, &from);
    assert_near(motion(d, kind, r.q), f[0], tol);
    /* the common centre falls freely: the drive works between the bodies alone */
    assert_near((r.q[1] + 2 * r.q[nq + 1]) / 3, -0.5 * r.time * r.time, tol);
    nsdae_sim_destroy(&sim);
  }
  nsdae_system_destroy(&system);
  nsdae_bodies_destroy(&b);
}

static const struct {
  int d, kind;
} cases[] = {{2, NSDAE_JOINT_REVOLUTE},  {2, NSDAE_JOINT_PRISMATIC}, {2, NSDAE_JOINT_DISTANCE},
             {2, NSDAE_JOINT_SLOT},      {2, NSDAE_JOINT_GEAR},      {3, NSDAE_JOINT_REVOLUTE},
             {3, NSDAE_JOINT_PRISMATIC}, {3, NSDAE_JOINT_DISTANCE},  {3, NSDAE_JOINT_CYLINDRICAL}};

static void test_follow(void **state)
{
  (void)state;
  for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
    follow(cases[i].d, cases[i].kind, NSDAE_METHOD_EVENT, 0.05, 1e-8);
    follow(cases[i].d, cases[i].kind, NSDAE_METHOD_IMPLICIT, 1e-3, 1e-6); /* (rate dt)^2 / 9 */
  }
}

int main(void)
{
  const struct CMUnitTest tests[] = {cmocka_unit_test(test_follow)};
  return cmocka_run_group_tests(tests, NULL, NULL);
}
