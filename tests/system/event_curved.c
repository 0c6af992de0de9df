/* Contacts on curved surfaces under the event-driven method: their normal turns with the motion. A
 * disk in a bowl, with the closed form of the pendulum, and on a sphere, which it leaves. With and
 * without the derivatives of the gap. */
#include "check.h"
#include "event_run.h"

#include <gsl/gsl_sf_elljac.h>
#include <gsl/gsl_sf_ellint.h>

static const double g = 9.81;

static event_run r; /* large */

/* q = (x, y, turn): mass 1; s (|q| - R) is its gap, in a bowl with s = -1, R the way of its centre.
 */
typedef struct disk {
  double R, radius, s, inertia;
} disk;

static int mass(double t, const double *q, double *M, int ldm, void *user)
{
  const disk *p = user;
  (void)t;
  (void)q;
  M[0] = M[ldm + 1] = 1;
  M[2 * ldm + 2] = p->inertia;
  return 0;
}

static int force(double t, const double *q, const double *v, double *F, void *user)
{
  (void)t;
  (void)q;
  (void)v;
  (void)user;
  F[1] = -g;
  return 0;
}

static int gap(double t, const double *q, double *g_N, void *user)
{
  const disk *p = user;
  (void)t;
  g_N[0] = p->s * (hypot(q[0], q[1]) - p->R);
  return 0;
}

static int gap_normal(double t, const double *q, double *W, int ldw, void *user)
{
  const disk *p = user;
  (void)t;
  (void)ldw;
  for (int i = 0; i < 2; i++) W[i] = p->s * q[i] / hypot(q[0], q[1]);
  return 0;
}

static int gap_tangent(double t, const double *q, double *W, int ldw, void *user)
{
  const disk *p = user;
  gap_normal(t, q, W, ldw, user);
  double n_x = W[0], n_y = W[1];
  W[0] = n_y;
  W[1] = -n_x;
  W[2] = p->radius;
  return 0;
}

static nsdae_system *disk_system(disk *p, double mu, int given)
{
  nsdae_system *system;
  nsdae_dims dims = {.nq = 3, .k = 1, .nt = 1};
  assert_int_equal(nsdae_system_create(&dims, &system, NULL), NSDAE_OK);
  nsdae_system_set_user(system, p);
  nsdae_system_set_mass(system, mass);
  nsdae_system_set_force(system, force);
  nsdae_system_set_gap(system, gap);
  nsdae_system_set_gap_tangent(system, gap_tangent);
  if (given) nsdae_system_set_gap_normal(system, gap_normal);
  nsdae_system_set_contact(system, 0, mu, 0, 0);
  return system;
}

/* theta'' = -c sin theta from rest at theta_0, at time t: sin(theta / 2) = k sn(K - sqrt(c) t). */
static double swing(double c, double theta_0, double t)
{
  double k = sin(theta_0 / 2), K = gsl_sf_ellint_Kcomp(k, GSL_PREC_DOUBLE), sn, cn, dn;
  gsl_sf_elljac_e(K - sqrt(c) * t, k * k, &sn, &cn, &dn);
  return 2 * asin(k * sn);
}

/* Without friction c = g / R; rolling, g / (R (1 + J / (m r^2))), and it turns by -R theta / r. */
static void test_bowl(void **state)
{
  (void)state;
  const double theta_0 = 1.2;
  for (int rolls = 0; rolls < 2; rolls++)
    for (int given = event_run_by_list(); given < 2; given++) {
      disk p = {.R = 1.7, .radius = 0.3, .s = -1, .inertia = 0.045};
      double q0[3] = {p.R * sin(theta_0), -p.R * cos(theta_0)}, v0[3] = {0};
      double c = g / p.R / (rolls ? 1 + p.inertia / (p.radius * p.radius) : 1);
      nsdae_system *system = disk_system(&p, rolls ? 2 : 0, given);
      event_run_default(&r);
      r.t_end = 5;
      event_run_both(&r, system, q0, v0);
      double theta = swing(c, theta_0, r.t_end);
      assert_int_equal(r.status, NSDAE_OK);
      assert_int_equal(r.stats.events, 1);
      assert_near(r.q[0], p.R * sin(theta), 2e-8);
      assert_near(r.q[1], -p.R * cos(theta), 2e-8);
      assert_near(r.q[2], rolls ? p.R * (theta_0 - theta) / p.radius : 0, 2e-7);
      nsdae_system_destroy(&system);
    }
}

/* It leaves a sphere where cos theta = 2/3 cos theta_0: theta'' = c sin theta, by energy
 * theta'^2 = 2 c (cos theta_0 - cos theta). With phi = pi - theta this is the pendulum of before.
 * Down to accuracies at which the force that vanishes is all rounding. */
static void test_sphere(void **state)
{
  (void)state;
  const double theta_0 = 0.05, c = g, leaves = acos(2.0 / 3 * cos(theta_0));
  double k = cos(theta_0 / 2), sine = cos(leaves / 2) / k;
  double left =
      (gsl_sf_ellint_Kcomp(k, GSL_PREC_DOUBLE) - gsl_sf_ellint_F(asin(sine), k, GSL_PREC_DOUBLE)) /
      sqrt(c);
  disk p = {.R = 1, .s = 1, .inertia = 1};
  double q0[3] = {sin(theta_0), cos(theta_0)}, v0[3] = {0};
  double speed = sqrt(2 * c * (cos(theta_0) - cos(leaves)));
  for (double rtol = 1e-9; rtol > 1e-14; rtol *= 0.8) {
    nsdae_system *system = disk_system(&p, 0, 1);
    event_run_default(&r);
    r.t_end = 1.5;
    r.options.rtol = rtol;
    r.options.atol = rtol / 100;
    event_run_do(&r, system, q0, v0);
    double t = r.t_end - left, tol = fmax(100 * rtol, 1e-10);
    assert_int_equal(r.status, NSDAE_OK);
    assert_int_equal(r.changes, 1);
    assert_int_equal(r.change[0].mode_after, NSDAE_MODE_OPEN);
    assert_near(r.change[0].time, left, tol);
    assert_near(r.q[0], sin(leaves) + speed * cos(leaves) * t, 10 * tol);
    assert_near(r.q[1], cos(leaves) - speed * sin(leaves) * t - g * t * t / 2, 10 * tol);
    nsdae_system_destroy(&system);
  }
}

int main(void)
{
  const struct CMUnitTest tests[] = {cmocka_unit_test(test_bowl), cmocka_unit_test(test_sphere)};
  return cmocka_run_group_tests(tests, NULL, NULL);
}
