/* The event-driven method where contacts move by themselves: belts and shaken plates, against
 * closed forms and an independent solution of the equations between events. */
#include "check.h"

#include <nsdae/nsdae.h>

#include "event_run.h"

static event_run r; /* large */
static const double g = 9.81;

static int identity(double t, const double *q, double *M, int ldm, void *user)
{
  (void)t;
  (void)q;
  (void)user;
  M[0] = M[ldm + 1] = 1;
  return 0;
}

/* ---- a block on a belt, held by a spring: q = [x, y] ---- */

typedef struct belt {
  double k, speed, rate; /* of the spring; of the belt: speed + rate t */
} belt;

static int belt_force(double t, const double *q, const double *v, double *F, void *user)
{
  const belt *b = user;
  (void)t;
  (void)v;
  F[0] = -b->k * q[0];
  F[1] = -g;
  return 0;
}

static int height(double t, const double *q, double *gap, void *user)
{
  (void)t;
  (void)user;
  gap[0] = q[1];
  return 0;
}

static int upwards(double t, const double *q, double *W, int ldw, void *user)
{
  (void)t;
  (void)q;
  (void)ldw;
  (void)user;
  W[1] = 1;
  return 0;
}

static int sidewards(double t, const double *q, double *W, int ldw, void *user)
{
  (void)t;
  (void)q;
  (void)ldw;
  (void)user;
  W[0] = 1;
  return 0;
}

static int belt_bias(double t, const double *q, double *w_n, double *w_t, void *user)
{
  const belt *b = user;
  (void)q;
  w_n[0] = 0;
  if (w_t) w_t[0] = -(b->speed + b->rate * t);
  return 0;
}

static nsdae_system *belt_system(belt *b, double mu)
{
  nsdae_system *system;
  assert_int_equal(nsdae_system_create(&(nsdae_dims){.nq = 2, .k = 1, .nt = 1}, &system, NULL),
                   NSDAE_OK);
  nsdae_system_set_user(system, b);
  nsdae_system_set_mass(system, identity);
  nsdae_system_set_force(system, belt_force);
  nsdae_system_set_gap(system, height);
  nsdae_system_set_gap_normal(system, upwards);
  nsdae_system_set_gap_tangent(system, sidewards);
  nsdae_system_set_contact_bias(system, belt_bias);
  nsdae_system_set_contact(system, 0, mu, 0, 0);
  return system;
}

/* m = k = 1. It slides: x'' = -x + mu g until x' = V at t = asin(V / mu g); sticks until x = mu g;
 * then slides back through x' = V cos s and meets V again after 2 pi: from there on it only swings
 * about mu g with amplitude V, and touches the speed of the belt once in a period. Any t0. */
static void test_belt(void **state)
{
  (void)state;
  const double start[] = {0, -1e3, 12345};
  const double mu = 0.1, V = 0.5, most = mu * g;
  double stick = asin(V / most), x = most * (1 - cos(stick)), slip = stick + (most - x) / V;
  belt b = {.k = 1, .speed = V};
  nsdae_system *system = belt_system(&b, mu);
  for (int i = 0; i < 3; i++) {
    double q0[2] = {0}, v0[2] = {0}, t0 = start[i];
    event_run_default(&r);
    r.t0 = t0;
    r.t_end = t0 + 6;
    event_run_both(&r, system, q0, v0);
    assert_int_equal(r.status, NSDAE_OK);
    assert_int_equal(r.impacts, 0);
    assert_int_equal(r.changes, 2);
    assert_int_equal(r.change[0].mode_after, NSDAE_MODE_STICK);
    assert_int_equal(r.change[1].mode_after, NSDAE_MODE_SLIP);
    assert_near(r.change[0].time - t0, stick, 1e-8);
    assert_near(r.change[1].time - t0, slip, 1e-8);
    assert_near(r.q[0], most + V * sin(6 - slip),
                1e-7); /* a hundred steps of rtol, and the slip's */
    assert_near(r.normal[0], 6 * g, 1e-7);
    /* the impulse of friction: momentum, and the spring's */
    double spring = x; /* integral of x: while it first slides */
    spring = most * (stick - sin(stick)) + (x + most) / 2 * (slip - stick) + most * (6 - slip) +
             V * (1 - cos(6 - slip));
    assert_near(r.tangential[0], r.v[0] + spring, 1e-7);
  }
  nsdae_system_destroy(&system);
}

/* A belt that starts from rest takes a free block along while rate < mu g, and else slides under it
 * from the first: x = mu g t^2 / 2. */
static void test_belt_starts(void **state)
{
  (void)state;
  const double mu = 0.3;
  for (int i = 0; i < 2; i++) {
    belt b = {.rate = (i == 0 ? 0.9 : -1.2) * mu * g};
    nsdae_system *system = belt_system(&b, mu);
    double q0[2] = {0}, v0[2] = {0}, a = i == 0 ? b.rate : -mu * g;
    event_run_default(&r);
    r.t_end = 2;
    event_run_both(&r, system, q0, v0);
    assert_int_equal(r.status, NSDAE_OK);
    assert_int_equal(r.changes, 0);
    assert_int_equal(r.mode[0], i == 0 ? NSDAE_MODE_STICK : NSDAE_MODE_SLIP);
    assert_near(r.q[0], 2 * a, 1e-8);
    assert_near(r.tangential[0], 2 * a, 1e-8);
    nsdae_system_destroy(&system);
  }
}

/* ---- a ball on a plate that shakes: gap q - A sin w t ---- */

typedef struct plate {
  double A, w;
  double start, height, speed; /* of a flight */
} plate;

static int one(double t, const double *q, double *W, int ldw, void *user)
{
  (void)t;
  (void)q;
  (void)ldw;
  (void)user;
  W[0] = 1;
  return 0;
}

static int plate_force(double t, const double *q, const double *v, double *F, void *user)
{
  (void)t;
  (void)q;
  (void)v;
  (void)user;
  F[0] = -g;
  return 0;
}

static int plate_gap(double t, const double *q, double *gap, void *user)
{
  const plate *p = user;
  gap[0] = q[0] - p->A * sin(p->w * t);
  return 0;
}

static int plate_bias(double t, const double *q, double *w_n, double *w_t, void *user)
{
  const plate *p = user;
  (void)q;
  (void)w_t;
  w_n[0] = -p->A * p->w * cos(p->w * t);
  return 0;
}

static nsdae_system *plate_system(plate *p, double e, int bias, int normal)
{
  nsdae_system *system;
  assert_int_equal(nsdae_system_create(&(nsdae_dims){.nq = 1, .k = 1}, &system, NULL), NSDAE_OK);
  nsdae_system_set_user(system, p);
  nsdae_system_set_mass(system, one);
  nsdae_system_set_force(system, plate_force);
  nsdae_system_set_gap(system, plate_gap);
  if (normal) nsdae_system_set_gap_normal(system, one);
  if (bias) nsdae_system_set_contact_bias(system, plate_bias);
  nsdae_system_set_contact(system, 0, 0, e, 0);
  return system;
}

static double flight(const plate *p, double t)
{
  double s = t - p->start;
  return p->height + p->speed * s - g * s * s / 2;
}

static double gap_at(double t, void *user)
{
  const plate *p = user;
  return flight(p, t) - p->A * sin(p->w * t);
}

/* The first time after p->start at which the flight ends, to rounding: stepped, then bisected. */
static double lands(plate *p)
{
  double from = p->start + 1e-4 / p->w, to = from;
  while (gap_at(to, p) > 0) from = to, to += 1e-3 / p->w;
  for (int i = 0; i < 60; i++) {
    double middle = (from + to) / 2;
    if (gap_at(middle, p) > 0)
      from = middle;
    else
      to = middle;
  }
  return to;
}

/* It lifts off where the plate falls as fast as it would, A w^2 sin w t = g, lands by the closed
 * form of its flight, and so on through every bounce that is not within an accumulation. */
static void test_plate(void **state)
{
  (void)state;
  for (int bias = 0; bias < 2; bias++) {
    plate p = {.A = 0.1, .w = 15};
    const double e = 0.8;
    double q0 = 0, v0 = p.A * p.w, tol = bias ? 1e-8 : 1e-7; /* without, differences in t */
    nsdae_system *system = plate_system(&p, e, bias, 1);
    event_run_default(&r);
    r.t_end = 2;
    event_run_both(&r, system, &q0, &v0);
    assert_int_equal(r.status, NSDAE_OK);
    assert_true(r.changes == 1 && r.change[0].mode_after == NSDAE_MODE_OPEN);
    p.start = asin(g / (p.A * p.w * p.w)) / p.w;
    assert_near(r.change[0].time, p.start, tol);
    p.height = p.A * sin(p.w * p.start);
    p.speed = p.A * p.w * cos(p.w * p.start);
    assert_true(r.impacts > 3);
    for (int i = 0; i < r.impacts; i++) {
      double t = lands(&p), v = p.speed - g * (t - p.start), floor = p.A * p.w * cos(p.w * t);
      assert_near(r.impact[i].time, t, tol);
      assert_near(r.impact[i].velocity_before, v - floor, 100 * tol);
      assert_near(r.impact[i].normal_impulse, -(1 + e) * (v - floor), 100 * tol);
      p.start = t;
      p.height = p.A * sin(p.w * t);
      p.speed = floor - e * (v - floor);
      tol *= 3; /* an error of a landing grows to the next */
    }
    nsdae_system_destroy(&system);
  }
}

/* On a plate that rises evenly a ball accumulates as on one at rest, t_rest = t_1 (1 + e) / (1 -
 * e); on one that shakes gently it comes to rest too, and stays on it. */
static void test_accumulation(void **state)
{
  (void)state;
  const double e = 0.6, h = 0.2;
  plate p = {.A = 1e6, .w = 1e-6}; /* rises at 1 m/s; its curvature is 1e-6 m/s^2 */
  double q0 = h, v0 = 1, first = sqrt(2 * h / g);
  nsdae_system *system = plate_system(&p, e, 1, 1);
  event_run_default(&r);
  r.t_end = 2;
  event_run_both(&r, system, &q0, &v0);
  assert_int_equal(r.stats.accumulations, 1);
  assert_near(r.impact[0].time, first, 1e-8);
  assert_near(r.impact[r.impacts - 1].time, first * (1 + e) / (1 - e), 1e-6);
  assert_near(r.q[0], 2, 1e-6);
  assert_near(r.v[0], 1, 1e-6);
  p = (plate){.A = 0.01, .w = 10};
  v0 = 0;
  r.t_end = 5;
  event_run_both(&r, system, &q0, &v0);
  assert_int_equal(r.stats.fallback_steps, 0);
  assert_true(r.stats.accumulations >= 1);
  assert_int_equal(r.mode[0], NSDAE_MODE_SLIP);
  assert_near(r.q[0], p.A * sin(p.w * 5), 1e-8);
  assert_near(r.v[0], p.A * p.w * cos(p.w * 5), 1e-7);
  nsdae_system_destroy(&system);
}

/* Where A w^2 < g a ball that starts on the plate stays on it: there is no
 * impact and no change of mode. Neither the error of differences, of the gap alone or with its
 * normal, nor a tolerance below it makes one. Seeded: w from 1 to 300 per s. */
static void test_stays(void **state)
{
  (void)state;
  if (event_run_by_list()) return;
  for (int seed = 0; seed < 40; seed++) {
    double w = pow(300, seed / 39.0), part = 0.1 + 0.8 * fmod(0.618 * seed, 1);
    plate p = {.A = part * g / (w * w), .w = w};
    double q0 = 0, v0 = p.A * p.w;
    nsdae_system *system = plate_system(&p, 0.5, 0, seed % 2);
    event_run_default(&r);
    r.options.rtol = pow(10, -6.0 - seed % 7);
    r.options.atol = 1e-2 * r.options.rtol;
    r.options.dt = 0.05 / w;
    r.t_end = 20 / w;
    event_run_do(&r, system, &q0, &v0);
    assert_int_equal(r.status, NSDAE_OK);
    assert_int_equal(r.impacts + r.changes, 0);
    assert_true(r.stats.events < 10); /* each that only brings back a drift allows more of it */
    assert_near(r.q[0], p.A * sin(w * r.t), 1e-5 * p.A);
    nsdae_system_destroy(&system);
  }
}

/* A ball falls into a drum of radius 1 that a motor turns with 3 rad/s, and comes to rolling by an
 * accumulation of impacts. The motor balances the moment of the tangential impulses T: its work is
 * -3 sum T, also where errors of the velocity are projected, to the square of their size. */
static void test_motor(void **state)
{
  const double gravity[3] = {0, -9.81};
  const nsdae_solid hole = {.shape = NSDAE_SHAPE_DISC, .radius = 1, .hollow = 1},
                    disc = {.shape = NSDAE_SHAPE_DISC, .radius = 0.1};
  const nsdae_joint hinge = {.kind = NSDAE_JOINT_REVOLUTE, .body = {NSDAE_GROUND, 0}};
  nsdae_bodies *b;
  nsdae_system *system;
  nsdae_sim *sim;
  nsdae_sim_options o;
  nsdae_record record;
  double q[6], v[6], sum = 0;
  (void)state;
  assert_int_equal(nsdae_bodies_create(2, &b, NULL), NSDAE_OK);
  nsdae_bodies_set_gravity(b, gravity);
  nsdae_bodies_add(b, &(nsdae_rigid_body){.mass = 10, .inertia = {0, 0, 10}, .spin = {0, 0, 3}});
  nsdae_bodies_add(
      b, &(nsdae_rigid_body){.mass = 0.5, .inertia = {0, 0, 0.0025}, .position = {0.3, -0.5}});
  nsdae_bodies_add_joint(b, &hinge);
  nsdae_bodies_add_motor(b, &(nsdae_motor){.kind = NSDAE_MOTOR_SPEED, .target = 3, .limit = 1e3});
  int first = nsdae_bodies_add_solid(b, 0, &hole), second = nsdae_bodies_add_solid(b, 1, &disc);
  nsdae_bodies_add_contact(b, first, second, 0.3, 0.3, 0);
  if (nsdae_bodies_system(b, &system) < 0) fail_msg("%s", nsdae_bodies_error(b)->text);
  nsdae_sim_options_default(&o);
  o.method = NSDAE_METHOD_EVENT;
  o.dt = 1e-3;
  o.rtol = 1e-6;
  o.atol = 1e-8;
  nsdae_bodies_get_start(b, q, v);
  assert_int_equal(nsdae_sim_create(system, &o, &sim, NULL), NSDAE_OK);
  assert_int_equal(nsdae_sim_init(sim, 0, q, v), NSDAE_OK);
  for (int i = 0; i < 600; i++) {
    assert_true(nsdae_sim_step(sim) >= 0);
    nsdae_sim_get_record(sim, &record);
    sum += record.tangential_impulse[0];
  }
  const nsdae_certificate *c = &record.certificate;
  print_message("motor: work %.6f J, off by %.1e, unexplained %.1e\n", c->work, c->work + 3 * sum,
                c->unexplained);
  assert_true(c->work > 2);
  assert_near(c->work, -3 * sum, 1e-5);
  assert_near(c->unexplained, 0, 1e-6);
  nsdae_sim_destroy(&sim);
  nsdae_system_destroy(&system);
  nsdae_bodies_destroy(&b);
}

int main(void)
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(test_belt),         cmocka_unit_test(test_belt_starts),
      cmocka_unit_test(test_plate),        cmocka_unit_test(test_stays),
      cmocka_unit_test(test_accumulation), cmocka_unit_test(test_motor),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
