/* The event-driven method where it is hard: contacts that alternate to rest, jamming, contacts
 * shorter than a step of the integrator, friction of an impact in space. */
#include "check.h"

#include "drop.h"

static const double pi = 3.14159265358979324;

typedef struct kept {
  int impacts, accumulations;
  double end, last, tangential[2]; /* of the last accumulation, the last impact */
} kept;

static int keep(const nsdae_record *record, nsdae_error *error, void *user)
{
  kept *k = user;
  (void)error;
  for (int i = 0; i < record->impacts; i++) {
    const nsdae_impact *impact = &record->impact[i];
    k->impacts++;
    k->accumulations += impact->accumulation;
    if (impact->accumulation) k->end = impact->time;
    assert_true(impact->time >= k->last); /* also the ends of accumulations come in order */
    k->last = impact->time;
    for (int l = 0; l < 2; l++) k->tangential[l] = impact->tangential_impulse[l];
  }
  return 0;
}

static int run(drop *d, double dt, double t_end, kept *k, nsdae_record *record, nsdae_sim **sim,
               nsdae_system **system)
{
  nsdae_sim_options o;
  *k = (kept){0};
  *system = drop_system(d);
  nsdae_sim_options_default(&o);
  o.method = NSDAE_METHOD_EVENT;
  o.rtol = d->rtol;
  o.atol = d->rtol * 1e-2;
  o.dt = dt;
  assert_int_equal(nsdae_sim_create(*system, &o, sim, NULL), NSDAE_OK);
  nsdae_sim_observe(*sim, keep, k);
  assert_int_equal(nsdae_sim_init(*sim, 0, d->q0, d->v0), NSDAE_OK);
  int status = nsdae_sim_run(*sim, t_end);
  nsdae_sim_get_record(*sim, record);
  return status;
}

static void end(nsdae_sim **sim, nsdae_system **system)
{
  nsdae_sim_destroy(sim);
  nsdae_system_destroy(system);
}

/* A disc without friction in a groove, beside its middle: with e = 0 it hits the walls in turn.
 * Its speed along a wall after an impact is |cos| of the angle between the walls of that before,
 * so that the impacts accumulate; it rests where both walls hold it. */
static void test_groove(void **state)
{
  (void)state;
  const double e[] = {0, 0.1, 0.4};
  for (int i = 0; i < 3; i++)
    for (double angle = 0.4; angle < 0.9; angle += 0.2) {
      drop d = {.bodies = 1, .points = 1, .walls = 2, .m = 1.7, .radius = 0.2, .g = 9.81};
      kept k;
      nsdae_record r;
      nsdae_sim *sim;
      nsdae_system *system;
      d.J[2] = 0.034;
      d.e = e[i];
      d.rtol = 1e-8;
      for (int w = 0; w < 2; w++) {
        d.normal[w][0] = w ? -sin(angle) : sin(angle);
        d.normal[w][1] = cos(angle);
      }
      d.q0[0] = 0.05;
      d.q0[1] = d.radius / cos(angle) + 0.2;
      assert_int_equal(run(&d, 5e-3, 3, &k, &r, &sim, &system), NSDAE_OK);
      assert_int_equal(k.accumulations >= 1, d.e > 0 || angle < pi / 4);
      assert_true(k.end < 3);
      assert_near(r.q[0], 0, 1e-8);
      assert_near(r.q[1], d.radius / cos(angle), 1e-8);
      for (int j = 0; j < 2; j++) assert_near(r.v[j], 0, 1e-8);
      end(&sim, &system);
    }
}

/* Housner's block (Bull. Seism. Soc. Am. 53, 1963), 0.025 by 0.1 m, e = 0, mu = 0.3, released on
 * one corner at 8 degrees: omega(+) = (1 - 3/2 sin^2 alpha) omega(-) at every impact, and between
 * two the elliptic swing. The sum of these times, of which the first six are asserted elsewhere, is
 * 1.8833874 s. */
static void test_rocking_to_rest(void **state)
{
  (void)state;
  drop d = {.bodies = 1, .points = 4, .walls = 1, .m = 1, .g = 9.81, .mu = 0.3, .rtol = 1e-10};
  const double a = 0.0125, b = 0.05, tilt = 8 * pi / 180;
  kept k;
  nsdae_record r;
  nsdae_sim *sim;
  nsdae_system *system;
  d.J[2] = (a * a + b * b) / 3;
  d.normal[0][1] = 1;
  for (int p = 0; p < 4; p++) {
    d.point[p][0] = p & 1 ? a : -a;
    d.point[p][1] = p & 2 ? b : -b;
  }
  d.q0[1] = a * sin(tilt) + b * cos(tilt);
  d.q0[2] = tilt;
  assert_int_equal(run(&d, 5e-3, 2.5, &k, &r, &sim, &system), NSDAE_OK);
  assert_near(k.end, 1.8833874, 1e-6);
  assert_near(r.q[1], b, 1e-10);
  for (int j = 0; j < 3; j++) assert_near(r.v[j], 0, 1e-10);
  end(&sim, &system);
}

/* A rod that slides on its end (length 2, m = 1, g = 10, mu = 5/3): the coefficient
 * 1 + 3 cos phi (cos phi - mu sin phi) falls to zero while the force is needed. The times are those
 * of an independent integration of phi and the slip, to where the coefficient is zero. */
static void test_jamming(void **state)
{
  (void)state;
  const double angle[] = {20, 31}, spin[] = {2, 0}, time[] = {0.22200, 0.81272};
  for (int i = 0; i < 2; i++)
    for (double rtol = 1e-6; rtol > 1e-11; rtol /= 10) {
      drop d = {.bodies = 1, .points = 2, .walls = 1, .m = 1, .g = 10, .mu = 1.6667};
      double phi = angle[i] * pi / 180;
      kept k;
      nsdae_record r;
      nsdae_sim *sim;
      nsdae_system *system;
      d.rtol = rtol;
      d.J[2] = 1.0 / 3;
      d.normal[0][1] = 1;
      d.point[0][0] = -1;
      d.point[1][0] = 1;
      d.q0[1] = sin(phi);
      d.q0[2] = phi;
      d.v0[0] = -30 - sin(phi) * spin[i];
      d.v0[1] = cos(phi) * spin[i];
      d.v0[2] = spin[i];
      assert_int_equal(run(&d, 5e-3, 1.5, &k, &r, &sim, &system), NSDAE_E_PAINLEVE);
      assert_near(nsdae_sim_error(sim)->time, time[i], 1e-5 + 100 * rtol);
      assert_int_equal(nsdae_sim_error(sim)->index, 0);
      end(&sim, &system);
    }
}

/* A ladder (length 1, m = 1) that leans at tan phi = 2 on a smooth wall while its foot slides away
 * from it, mu = 2, turning with w = -1: with the forces F of foot and head the normal accelerations
 * are A F + b, and no F >= 0 makes them >= 0 and F a = 0. No force, whatever rtol is; what has no
 * friction holds nothing along. */
static void test_ladder(void **state)
{
  (void)state;
  const double phi = atan(2), s = sin(phi), c = cos(phi), mu = 2, w = -1, g = 9.81;
  const double A[2][2] = {{1 + 3 * c * (c - mu * s), -3 * c * s},
                          {-mu + 3 * s * (mu * s - c), 1 + 3 * s * s}},
               b[2] = {-g + s * w * w / 2, c * w * w / 2},
               det = A[0][0] * A[1][1] - A[0][1] * A[1][0];
  assert_true(b[0] < 0 && -b[0] / A[0][0] < 0 && -b[1] / A[1][1] < 0 &&
              (-b[0] * A[1][1] + b[1] * A[0][1]) / det < 0);
  for (double rtol = 1e-9; rtol < 2e-4; rtol *= 10) {
    drop d = {.bodies = 1, .points = 2, .walls = 2, .m = 1, .g = g, .mu = mu};
    nsdae_sim_options o;
    nsdae_sim *sim;
    d.J[2] = 1.0 / 12;
    d.normal[0][1] = 1;
    d.normal[1][0] = -1;
    d.point[0][0] = -0.5;
    d.point[1][0] = 0.5;
    double q0[3] = {-c / 2, s / 2, phi}, v0[3] = {s * w / 2, c * w / 2, w};
    nsdae_system *system = drop_system(&d);
    for (int i = 1; i < 4; i += 2) nsdae_system_set_contact(system, i, 0, 0, 0); /* of the wall */
    nsdae_sim_options_default(&o);
    o.method = NSDAE_METHOD_EVENT;
    o.rtol = rtol;
    o.atol = 1e-2 * rtol;
    assert_int_equal(nsdae_sim_create(system, &o, &sim, NULL), NSDAE_OK);
    int status = nsdae_sim_init(sim, 0, q0, v0);
    if (status >= 0) status = nsdae_sim_run(sim, 0.2);
    assert_int_equal(status, NSDAE_E_PAINLEVE);
    assert_int_equal(nsdae_sim_error(sim)->index, 0);
    end(&sim, &system);
  }
}

/* ---- a bead without any force over the valley y = -cos x, with friction ---- */

static int bead_mass(double t, const double *q, double *M, int ldm, void *user)
{
  (void)t, (void)q, (void)user;
  M[0] = M[ldm + 1] = 1;
  return 0;
}

static int bead_force(double t, const double *q, const double *v, double *F, void *user)
{
  (void)t, (void)q, (void)v, (void)user;
  F[0] = F[1] = 0;
  return 0;
}

static int bead_gap(double t, const double *q, double *gap, void *user)
{
  (void)t, (void)user;
  gap[0] = q[1] + cos(q[0]);
  return 0;
}

static int bead_tangent(double t, const double *q, double *W, int ldw, void *user)
{
  double length = hypot(1, sin(q[0]));
  (void)t, (void)ldw, (void)user;
  W[0] = 1 / length;
  W[1] = sin(q[0]) / length;
  return 0;
}

/* Only its own motion presses it: v' = -mu F_N with F_N |W_N| = v^2 kappa, |W_N| = 1 / cos theta at
 * the slope theta, so that v = v_0 exp(-mu sin theta). It leaves at x = pi / 2, where theta = pi /
 * 4 and the valley bends the other way: the force is zero there, and no jam, though nothing else
 * acts that it could be held against. */
static void test_bead(void **state)
{
  (void)state;
  const double mu[] = {0, 0.1, 0.5};
  for (int i = 0; i < 3; i++) {
    const nsdae_dims dims = {.nq = 2, .k = 1, .nt = 1};
    double q0[2] = {0, -1}, v0[2] = {1, 0}, v = exp(-mu[i] * sqrt(0.5)) * sqrt(0.5);
    nsdae_sim_options o;
    nsdae_record r;
    nsdae_system *system;
    nsdae_sim *sim;
    nsdae_sim_options_default(&o);
    o.method = NSDAE_METHOD_EVENT;
    assert_int_equal(nsdae_system_create(&dims, &system, NULL), NSDAE_OK);
    nsdae_system_set_mass(system, bead_mass);
    nsdae_system_set_force(system, bead_force);
    nsdae_system_set_gap(system, bead_gap);
    nsdae_system_set_gap_tangent(system, bead_tangent);
    nsdae_system_set_contact(system, 0, mu[i], 0, 0);
    assert_int_equal(nsdae_sim_create(system, &o, &sim, NULL), NSDAE_OK);
    assert_int_equal(nsdae_sim_init(sim, 0, q0, v0), NSDAE_OK);
    assert_int_equal(nsdae_sim_run(sim, 4), NSDAE_OK);
    nsdae_sim_get_record(sim, &r);
    for (int j = 0; j < 2; j++) assert_near(r.v[j], v, 100 * o.rtol);
    end(&sim, &system);
  }
}

/* ---- an oscillator against a stop just within its reach: q'' = -q, q <= 1 - deep ---- */

static int oscillator_mass(double t, const double *q, double *M, int ldm, void *user)
{
  (void)t;
  (void)q;
  (void)ldm;
  (void)user;
  M[0] = 1;
  return 0;
}

static int oscillator_force(double t, const double *q, const double *v, double *F, void *user)
{
  (void)t;
  (void)v;
  (void)user;
  F[0] = -q[0];
  return 0;
}

static int oscillator_gap(double t, const double *q, double *gap, void *user)
{
  (void)t;
  gap[0] = 1 - *(const double *)user - q[0];
  return 0;
}

/* With e = 1 it hits every 2 asin(1 - deep) + pi; without the stop it would be behind it for
 * 2 acos(1 - deep), which is 0.03 of the longest step. What is found does not depend on dt. */
static void test_short_contacts(void **state)
{
  (void)state;
  const double all_deep[] = {1e-2, 1e-4, 1e-6}, dt[] = {0.01, 0.05, 0.3, 1, 5};
  for (int i = 0; i < 3; i++)
    for (int j = 0; j < 5; j++) {
      double deep = all_deep[i], q0 = 0, v0 = 1, first = asin(1 - deep), period = 2 * first + pi;
      const nsdae_dims dims = {.nq = 1, .k = 1};
      nsdae_sim_options o;
      nsdae_system *system;
      nsdae_sim *sim;
      kept k = {0};
      nsdae_sim_options_default(&o);
      o.method = NSDAE_METHOD_EVENT;
      o.dt = dt[j];
      assert_int_equal(nsdae_system_create(&dims, &system, NULL), NSDAE_OK);
      nsdae_system_set_user(system, &deep);
      nsdae_system_set_mass(system, oscillator_mass);
      nsdae_system_set_force(system, oscillator_force);
      nsdae_system_set_gap(system, oscillator_gap);
      nsdae_system_set_contact(system, 0, 0, 1, 0);
      assert_int_equal(nsdae_sim_create(system, &o, &sim, NULL), NSDAE_OK);
      nsdae_sim_observe(sim, keep, &k);
      assert_int_equal(nsdae_sim_init(sim, 0, &q0, &v0), NSDAE_OK);
      assert_int_equal(nsdae_sim_run(sim, first + 19 * period + 1), NSDAE_OK);
      assert_int_equal(k.impacts, 20);
      /* a time along a graze is as good as the root of the accuracy of the position */
      assert_near(k.last, first + 19 * period, 20 * sqrt(1e-6 / deep) * 1e-2);
      end(&sim, &system);
    }
}

/* A ball that slips through its impact: the friction is mu P against the slip, in any direction;
 * P = (1 + e) m v. The error is that of the cone, no polygon's. */
static void test_oblique_impact(void **state)
{
  (void)state;
  for (int i = 0; i < 24; i++) {
    drop d = {.space = 1,
              .bodies = 1,
              .points = 1,
              .walls = 1,
              .m = 0.7,
              .radius = 0.11,
              .g = 9.81,
              .mu = 0.25,
              .e = 0.5,
              .rtol = 1e-9};
    double turn = 0.27 * i, speed = 3, height = 0.1;
    kept k;
    nsdae_record r;
    nsdae_sim *sim;
    nsdae_system *system;
    for (int j = 0; j < 3; j++) d.J[j] = 0.4 * d.m * d.radius * d.radius;
    d.normal[0][2] = 1;
    d.q0[2] = d.radius + height;
    d.q0[3] = 1;
    d.v0[0] = speed * cos(turn);
    d.v0[1] = speed * sin(turn);
    assert_int_equal(run(&d, 5e-3, 0.2, &k, &r, &sim, &system), NSDAE_OK);
    double P = (1 + d.e) * d.m * sqrt(2 * d.g * height);
    /* tangents of the floor: t_0 = (0, 1, 0), t_1 = n x t_0 = (-1, 0, 0) */
    assert_near(k.tangential[0], -d.mu * P * sin(turn), 1e-8);
    assert_near(k.tangential[1], d.mu * P * cos(turn), 1e-8);
    end(&sim, &system);
  }
}

int main(void)
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(test_groove),        cmocka_unit_test(test_rocking_to_rest),
      cmocka_unit_test(test_jamming),       cmocka_unit_test(test_ladder),
      cmocka_unit_test(test_bead),          cmocka_unit_test(test_short_contacts),
      cmocka_unit_test(test_oblique_impact)};
  return cmocka_run_group_tests(tests, NULL, NULL);
}
