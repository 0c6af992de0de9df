/* A ball above a platform that a constraint drives, p = a t + b t^2 / 2: impacts and lift-off
 * against their closed forms. */
#include "check.h"

#include <nsdae/nsdae.h>

typedef struct platform {
  double a, b, g; /* of p(t); gravity on the ball */
} platform;

/* q = [p, y] */
static int mass(double t, const double *q, double *M, int ldm, void *user)
{
  (void)t, (void)q, (void)user;
  M[0] = M[ldm + 1] = 1;
  return 0;
}

static int force(double t, const double *q, const double *v, double *F, void *user)
{
  const platform *p = user;
  (void)t, (void)q, (void)v;
  F[1] = -p->g;
  return 0;
}

static int constraint(double t, const double *q, double *phi, void *user)
{
  const platform *p = user;
  phi[0] = q[0] - p->a * t - p->b * t * t / 2;
  return 0;
}

static int jacobian(double t, const double *q, double *J, int ldj, void *user)
{
  (void)t, (void)q, (void)ldj, (void)user;
  J[0] = 1;
  return 0;
}

static int bias(double t, const double *q, const double *v, double *phi_t, double *omega,
                void *user)
{
  const platform *p = user;
  (void)q, (void)v;
  phi_t[0] = -p->a - p->b * t;
  omega[0] = -p->b;
  return 0;
}

static int gap(double t, const double *q, double *g, void *user)
{
  (void)t, (void)user;
  g[0] = q[1] - q[0];
  return 0;
}

static int gap_normal(double t, const double *q, double *W, int ldw, void *user)
{
  (void)t, (void)q, (void)ldw, (void)user;
  W[0] = -1, W[1] = 1;
  return 0;
}

typedef struct ending {
  double p, y, v;
  long impacts;
} ending;

/* From p = 0 and the ball at y with v, until t_end. */
static ending run(platform p, int method, double e_n, double y, double v, double t_end)
{
  const nsdae_dims dims = {.nq = 2, .m = 1, .k = 1};
  const double q0[2] = {0, y}, v0[2] = {p.a, v};
  nsdae_system *s;
  nsdae_sim *sim;
  nsdae_sim_options o;
  nsdae_record r;
  nsdae_stats stats;
  assert_int_equal(nsdae_system_create(&dims, &s, NULL), NSDAE_OK);
  nsdae_system_set_user(s, &p);
  nsdae_system_set_mass(s, mass);
  nsdae_system_set_force(s, force);
  nsdae_system_set_constraint(s, constraint);
  nsdae_system_set_constraint_jacobian(s, jacobian);
  nsdae_system_set_constraint_bias(s, bias);
  nsdae_system_set_gap(s, gap);
  nsdae_system_set_gap_normal(s, gap_normal);
  nsdae_system_set_contact(s, 0, 0, e_n, 0);
  nsdae_sim_options_default(&o);
  o.method = method;
  o.dt = 1e-3;
  assert_int_equal(nsdae_sim_create(s, &o, &sim, NULL), NSDAE_OK);
  assert_int_equal(nsdae_sim_init(sim, 0, q0, v0), NSDAE_OK);
  int status = nsdae_sim_run(sim, t_end);
  if (status != NSDAE_OK) fail_msg("%s", nsdae_sim_error(sim)->text);
  nsdae_sim_get_record(sim, &r);
  nsdae_sim_get_stats(sim, &stats);
  ending end = {r.q[0], r.q[1], r.v[1], stats.impacts};
  nsdae_sim_destroy(&sim);
  nsdae_system_destroy(&s);
  return end;
}

static const int methods[] = {NSDAE_METHOD_EVENT, NSDAE_METHOD_IMPLICIT, NSDAE_METHOD_MOREAU};

/* Without gravity, towards the platform that comes with a = 0.3: from v = -1 to a + e (a - v). Time
 * stepping finds the impact within a step. */
static void test_impact(void **state)
{
  (void)state;
  const double a = 0.3, e = 0.5, y = 0.13, t_end = 0.25, hit = y / (1 + a);
  for (int i = 0; i < 3; i++) {
    ending end = run((platform){.a = a}, methods[i], e, y, -1, t_end);
    double after = a + e * (1 + a), late = methods[i] == NSDAE_METHOD_EVENT ? 1e-9 : 1e-3;
    assert_int_equal(end.impacts, 1);
    assert_near(end.p, a * t_end, 1e-12);
    assert_near(end.v, after, 1e-12);
    assert_near(end.y, a * hit + after * (t_end - hit), (after + 1) * late);
  }
}

/* The ball rests on the platform, which accelerates from rest: it is left behind by b < -g, and
 * carried along by any other. */
static void test_lift_off(void **state)
{
  (void)state;
  const double g = 9.81, t = 0.2;
  static const double b[] = {-12, -9.9, -9.7, 0, 12};
  for (int i = 0; i < 3; i++)
    for (int j = 0; j < 5; j++) {
      ending end = run((platform){.b = b[j], .g = g}, methods[i], 0, 0, 0, t);
      double of = fmax(b[j], -g);
      /* steps of 1e-3 have impulses at their ends or in their middles */
      double tol = methods[i] == NSDAE_METHOD_EVENT ? 1e-8 : 12 * 1e-3;
      assert_int_equal(end.impacts, 0);
      assert_near(end.p, b[j] * t * t / 2, tol * t);
      assert_near(end.v, of * t, tol);
      assert_near(end.y, of * t * t / 2, tol * t);
    }
}

int main(void)
{
  const struct CMUnitTest tests[] = {cmocka_unit_test(test_impact),
                                     cmocka_unit_test(test_lift_off)};
  return cmocka_run_group_tests(tests, NULL, NULL);
}
