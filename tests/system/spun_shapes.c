/* Bodies of revolution that spin and lose energy, by event: coins that roll against a drag and spin
 * down, and a tippe top that slides. The reference is Euler's equations of the axis a and the
 * angular velocity omega in space, without quaternions and contacts, by GSL's Runge-Kutta pair of
 * order 8. With c from the centre of mass to the ground, I = I_t + (I_a - I_t) a a^T:
 *
 *   a' = omega x a,   (I omega)' = I omega' + (I_a - I_t) (a . omega) omega x a
 *                                = c x F + T,   m v' = F - m g e_z + D                          */
#include "check.h"

#include <gsl/gsl_errno.h>
#include <gsl/gsl_odeiv2.h>

#include <nsdae/nsdae.h>

#include "run_bodies.h"

enum { AXIS = 0, OMEGA = 3, PLACE = 6, VELOCITY = 9, STATES = 12 };

typedef struct spun {
  double m, along, across, g; /* mass, I_a, I_t */
  double r, h, k;             /* coin: radius, thickness, drag of each of four points of its rim */
  double alpha, mu;           /* top of radius r: see tippe_top.c */
} spun;

static const double up[3] = {0, 0, 1};

static double dot(const double *x, const double *y)
{
  return x[0] * y[0] + x[1] * y[1] + x[2] * y[2];
}

static void cross(const double *x, const double *y, double *z)
{
  for (int i = 0; i < 3; i++)
    z[i] = x[(i + 1) % 3] * y[(i + 2) % 3] - x[(i + 2) % 3] * y[(i + 1) % 3];
}

/* z += s (x x y) */
static void add_cross(double s, const double *x, const double *y, double *z)
{
  double product[3];
  cross(x, y, product);
  for (int i = 0; i < 3; i++) z[i] += s * product[i];
}

/* A x = b, by Cramer's rule; A symmetric. */
static void solve(double A[3][3], const double *b, double *x)
{
  double minor[3][3];
  for (int i = 0; i < 3; i++) cross(A[(i + 1) % 3], A[(i + 2) % 3], minor[i]);
  for (int i = 0; i < 3; i++)
    x[i] = (minor[0][i] * b[0] + minor[1][i] * b[1] + minor[2][i] * b[2]) / dot(A[0], minor[0]);
}

/* I + m (c^2 - c c^T); c = NULL: I */
static void inertia_about(const spun *p, const double *a, const double *c, double A[3][3])
{
  double square = c ? dot(c, c) : 0;
  for (int i = 0; i < 3; i++)
    for (int j = 0; j < 3; j++) {
      A[i][j] = (p->along - p->across) * a[i] * a[j] + (i == j) * (p->across + p->m * square);
      if (c) A[i][j] -= p->m * c[i] * c[j];
    }
}

/* A coin: v = -omega x c, F = m v' + m g e_z - D. The steepest direction of its face is
 * s = (e_z - (e_z . a) a) / sin(theta), and c = -r s - h/2 a. Drag of four points of the rim:
 * D = -4 k v and T = -k (4 r^2 omega - 2 r^2 (omega - (a . omega) a)), so
 *
 *   (I + m (c^2 - c c^T)) omega' = (I_t - I_a) (a . omega) omega x a - m c x (omega x c')
 *                                  + c x (m g e_z - D) + T                                      */
static int coin_rate(double t, const double *y, double *rate, void *user)
{
  const spun *p = user;
  const double *a = y + AXIS, *w = y + OMEGA;
  double *da = rate + AXIS, c[3], dc[3], v[3], wdc[3], right[3], force[3], A[3][3];
  double cosine = a[2], sine = sqrt(1 - cosine * cosine), spin = dot(a, w);
  (void)t;
  cross(w, a, da);
  for (int i = 0; i < 3; i++) {
    double s = (up[i] - cosine * a[i]) / sine;
    double ds = -(da[2] * a[i] + cosine * da[i]) / sine + s * cosine * da[2] / (sine * sine);
    c[i] = -p->r * s - p->h / 2 * a[i];
    dc[i] = -p->r * ds - p->h / 2 * da[i];
  }
  cross(c, w, v);
  cross(w, dc, wdc);
  for (int i = 0; i < 3; i++) {
    force[i] = p->m * p->g * up[i] + 4 * p->k * v[i];
    right[i] =
        (p->across - p->along) * spin * da[i] - 2 * p->k * p->r * p->r * (w[i] + spin * a[i]);
    rate[PLACE + i] = v[i];
    rate[VELOCITY + i] = 0;
  }
  add_cross(-p->m, c, wdc, right);
  add_cross(1, c, force, right);
  inertia_about(p, a, c, A);
  solve(A, right, rate + OMEGA);
  return GSL_SUCCESS;
}

/* A top that slides, its centre of mass alpha r from that of its ball: c = r (alpha a - e_z),
 * F = N f, f = e_z - mu u / |u| with the slip u = v + omega x c, and N so that z'' = -r alpha
 * a_z''.
 */
static int top_rate(double t, const double *y, double *rate, void *user)
{
  const spun *p = user;
  const double *a = y + AXIS, *w = y + OMEGA, *v = y + VELOCITY;
  double *da = rate + AXIS, c[3], u[3], f[3], moment[3], free[3], own[3], by_force[3], A[3][3];
  double part[3] = {0}, held[3] = {0};
  (void)t;
  cross(w, a, da);
  for (int i = 0; i < 3; i++) {
    c[i] = p->r * (p->alpha * a[i] - up[i]);
    free[i] = (p->across - p->along) * dot(a, w) * da[i];
    u[i] = v[i];
  }
  add_cross(1, w, c, u);
  for (int i = 0; i < 3; i++) f[i] = i == 2 ? 1 : -p->mu * u[i] / hypot(u[0], u[1]);
  cross(c, f, moment);
  inertia_about(p, a, NULL, A);
  solve(A, free, own);
  solve(A, moment, by_force);
  add_cross(1, own, a, part);
  add_cross(1, w, da, part);
  add_cross(1, by_force, a, held);
  double lever = p->r * p->alpha;
  double N = (p->g - lever * part[2]) / (1 / p->m + lever * held[2]);
  for (int i = 0; i < 3; i++) {
    rate[OMEGA + i] = own[i] + N * by_force[i];
    rate[PLACE + i] = v[i];
    rate[VELOCITY + i] = N * f[i] / p->m - p->g * up[i];
  }
  return GSL_SUCCESS;
}

/* y at t, of error below 1e-11: with 1e-13 in place of 1e-12 it is the same to 2e-12. */
static void integrate(int (*rate)(double, const double *, double *, void *), spun *p, double t_end,
                      double *y)
{
  gsl_odeiv2_system equations = {rate, NULL, STATES, p};
  gsl_odeiv2_driver *driver =
      gsl_odeiv2_driver_alloc_y_new(&equations, gsl_odeiv2_step_rk8pd, 1e-4, 1e-13, 1e-13);
  double t = 0;
  assert_int_equal(gsl_odeiv2_driver_apply(driver, &t, t_end, y), GSL_SUCCESS);
  gsl_odeiv2_driver_free(driver);
}

/* The body 0 on a floor, its axis tilted about y by theta; its first state in space. */
static nsdae_bodies *lay(const spun *p, const nsdae_solid *solid, double theta, double spin,
                         double precession, const double *position, double *y)
{
  const double c = cos(theta), s = sin(theta);
  nsdae_bodies *b;
  nsdae_rigid_body body = {.mass = p->m,
                           .inertia = {p->across, p->across, p->along},
                           .quaternion = {cos(theta / 2), 0, sin(theta / 2)},
                           .spin = {-precession * s, 0, precession * c + spin}};
  memset(y, 0, STATES * sizeof *y);
  memcpy(body.position, position, sizeof body.position);
  memcpy(y + PLACE, position, sizeof body.position);
  y[AXIS] = y[OMEGA] = s;
  y[AXIS + 2] = y[OMEGA + 2] = c;
  for (int i = 0; i < 3; i++) y[OMEGA + i] = spin * y[AXIS + i] + precession * up[i];
  assert_int_equal(nsdae_bodies_create(3, &b, NULL), NSDAE_OK);
  nsdae_bodies_set_gravity(b, (double[]){0, 0, -p->g});
  nsdae_bodies_add(b, &body);
  nsdae_bodies_add_solid(b, 0, solid);
  nsdae_bodies_add_solid(b, NSDAE_GROUND,
                         &(nsdae_solid){.shape = NSDAE_SHAPE_PLANE, .material = 1});
  nsdae_bodies_set_pair(b, 0, 1, p->mu, 0, 0);
  return b;
}

/* To t with v from the centre of mass at the start: the same position and axis. */
static void run(nsdae_bodies *b, const double *v, double t, const double *y)
{
  nsdae_sim_options o;
  nsdae_system *system;
  nsdae_record record;
  double start_q[7], start_v[6], off = 0;
  nsdae_sim_options_default(&o);
  o.method = NSDAE_METHOD_EVENT;
  o.dt = 0.01;
  o.rtol = 1e-11;
  o.atol = 1e-13;
  nsdae_sim *sim = start(b, &o, &system);
  nsdae_bodies_get_start(b, start_q, start_v);
  memcpy(start_v, v, 3 * sizeof *v);
  if (nsdae_sim_init(sim, 0, start_q, start_v) < 0 || nsdae_sim_run(sim, t) < 0)
    fail_msg("%s", nsdae_sim_error(sim)->text);
  nsdae_sim_get_record(sim, &record);
  const double *p = record.q + 3;
  const double axis[3] = {2 * (p[1] * p[3] + p[0] * p[2]), 2 * (p[2] * p[3] - p[0] * p[1]),
                          1 - 2 * (p[1] * p[1] + p[2] * p[2])};
  for (int i = 0; i < 3; i++) {
    assert_near(axis[i], y[AXIS + i], 1e-8);
    assert_near(record.q[i], y[PLACE + i], 1e-8);
    off = fmax(off, fmax(fabs(axis[i] - y[AXIS + i]), fabs(record.q[i] - y[PLACE + i])));
  }
  print_message(
      "t = %g s: axis (%.4f, %.4f, %.4f), place (%.4f, %.4f, %.4f), %.1f rad/s, energy "
      "%.3f of the start's; off by %.1e\n",
      record.time, axis[0], axis[1], axis[2], record.q[0], record.q[1], record.q[2],
      sqrt(dot(record.v + 3, record.v + 3)),
      record.certificate.energy /
          (record.certificate.energy + record.certificate.dissipated - record.certificate.work),
      off);
  end(b, system, sim);
}

static int drag(double t, const double *position, const double *velocity, double *force,
                double *torque, void *user)
{
  const spun *p = user;
  (void)t, (void)position, (void)torque;
  for (int i = 0; i < 3; i++) force[i] = -p->k * velocity[i];
  return 0;
}

static void test_coins(void **state)
{
  (void)state;
  for (int i = 0; i < 4; i++) {
    const double theta = i < 2 ? 1.2 : 0.5, m = 1, r = 0.1, h = i % 2 ? 0 : 0.02;
    const double spin = i < 2 ? -20 : -25, precession = i < 2 ? 5 : 28, t = i < 2 ? 2 : 1;
    const double c = cos(theta), s = sin(theta);
    spun p = {.m = m, .along = m * r * r / 2, .across = m * (r * r / 4 + h * h / 12), .g = 9.81};
    p.r = r, p.h = h, p.k = i < 2 ? 0.15 : 0.2, p.mu = 2;
    const double at[3] = {0, 0, h / 2 * c + r * s};
    const nsdae_solid solid = {
        .shape = h > 0 ? NSDAE_SHAPE_CYLINDER : NSDAE_SHAPE_DISC, .radius = r, .length = {0, 0, h}};
    double y[STATES], rate[STATES];
    nsdae_bodies *b = lay(&p, &solid, theta, spin, precession, at, y);
    for (int j = 0; j < 4; j++) {
      const double x = j == 0 ? r : j == 1 ? -r : 0, side = j == 2 ? r : j == 3 ? -r : 0;
      const double point[3] = {at[0] + x * c, side, at[2] - x * s};
      nsdae_bodies_add_load(b, 0, point, drag, &p);
    }
    coin_rate(0, y, rate, &p);
    double v[3] = {rate[PLACE], rate[PLACE + 1], rate[PLACE + 2]};
    integrate(coin_rate, &p, t, y);
    run(b, v, t, y);
  }
}

static void test_top(void **state)
{
  const double tilt = 0.5, zero[3] = {0};
  spun p = {.m = 0.02, .g = 9.81, .r = 0.02, .alpha = 0.3, .mu = 0.3};
  double y[STATES];
  (void)state;
  p.along = 2. / 5 * p.m * p.r * p.r;
  p.across = 131. / 350 * p.m * p.r * p.r;
  const double at[3] = {0, 0, p.r * (1 - p.alpha * cos(tilt))};
  const nsdae_solid ball = {
      .shape = NSDAE_SHAPE_SPHERE, .radius = p.r, .position = {0, 0, p.alpha * p.r}};
  nsdae_bodies *b = lay(&p, &ball, tilt, 150, 0, at, y);
  integrate(top_rate, &p, 0.1, y);
  run(b, zero, 0.1, y);
}

int main(void)
{
  const struct CMUnitTest tests[] = {cmocka_unit_test(test_coins), cmocka_unit_test(test_top)};
  return cmocka_run_group_tests(tests, NULL, NULL);
}
