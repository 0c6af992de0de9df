/* The event-driven method on bodies with several contacts: blocks and tables on more feet than they
 * have freedoms, boxes that slide or tip, rocking, contacts that close together or beside one that
 * sticks. */
#include "check.h"

#include "event_run.h"

enum { FEET = 8 };

static event_run r; /* large */
static const double g = 9.81, pi = 3.14159265358979324;

/* ---- a block in the plane, q = [x, y, theta], with feet at (x_i, -h) ---- */

typedef struct block {
  int feet;
  double x[FEET], h, J, tilt, push;
} block;

static int block_mass(double t, const double *q, double *M, int ldm, void *user)
{
  const block *b = user;
  (void)t;
  (void)q;
  M[0] = M[ldm + 1] = 1;
  M[2 * ldm + 2] = b->J;
  return 0;
}

static int block_force(double t, const double *q, const double *v, double *F, void *user)
{
  const block *b = user;
  (void)t;
  (void)q;
  (void)v;
  F[0] = g * sin(b->tilt) + b->push;
  F[1] = -g * cos(b->tilt);
  F[2] = 0;
  return 0;
}

static int block_potential(double t, const double *q, double *V, void *user)
{
  const block *b = user;
  (void)t;
  *V = -(g * sin(b->tilt) + b->push) * q[0] + g * cos(b->tilt) * q[1];
  return 0;
}

static int block_gap(double t, const double *q, double *gap, void *user)
{
  const block *b = user;
  (void)t;
  for (int i = 0; i < b->feet; i++) gap[i] = q[1] + b->x[i] * sin(q[2]) - b->h * cos(q[2]);
  return 0;
}

static int block_normal(double t, const double *q, double *W, int ldw, void *user)
{
  const block *b = user;
  (void)t;
  for (int i = 0; i < b->feet; i++) {
    W[i * ldw + 1] = 1;
    W[i * ldw + 2] = b->x[i] * cos(q[2]) + b->h * sin(q[2]);
  }
  return 0;
}

static int block_tangent(double t, const double *q, double *W, int ldw, void *user)
{
  const block *b = user;
  (void)t;
  for (int i = 0; i < b->feet; i++) {
    W[i * ldw] = 1;
    W[i * ldw + 2] = -b->x[i] * sin(q[2]) + b->h * cos(q[2]);
  }
  return 0;
}

/* Feet evenly over the width 1. */
static nsdae_system *block_system(block *b, int feet, double mu, double e)
{
  nsdae_system *system;
  nsdae_dims dims = {.nq = 3, .k = feet, .nt = 1};
  b->feet = feet;
  for (int i = 0; i < feet; i++) b->x[i] = feet > 1 ? -0.5 + (double)i / (feet - 1) : 0;
  assert_int_equal(nsdae_system_create(&dims, &system, NULL), NSDAE_OK);
  nsdae_system_set_user(system, b);
  nsdae_system_set_mass(system, block_mass);
  nsdae_system_set_force(system, block_force);
  nsdae_system_set_potential(system, block_potential);
  nsdae_system_set_gap(system, block_gap);
  nsdae_system_set_gap_normal(system, block_normal);
  nsdae_system_set_gap_tangent(system, block_tangent);
  for (int i = 0; i < feet; i++) nsdae_system_set_contact(system, i, mu, e, 0);
  return system;
}

static const block block_default = {.h = 0.25, .J = 0.1};

/* The sums of the feet's forces over t are those of statics, and each is in its cone. */
static void expect_carried(const block *b, double mu, double t, double friction)
{
  double normal = 0, moment = 0, tangential = 0;
  for (int i = 0; i < b->feet; i++) {
    normal += r.normal[i];
    moment += b->x[i] * r.normal[i] + b->h * r.tangential[i];
    tangential += r.tangential[i];
    assert_true(r.normal[i] >= -1e-9);
    assert_at_most(fabs(r.tangential[i]), mu * r.normal[i] + 1e-9);
  }
  assert_near(normal, g * cos(b->tilt) * t, 1e-8);
  assert_near(moment, 0, 1e-8);
  assert_near(tangential, friction, 1e-8);
}

/* On an incline below the angle of friction it rests, above it slides with g (sin - mu cos); on the
 * flat it stops at v / (mu g), and then has no friction left in it. Two to six feet. */
static void test_feet(void **state)
{
  (void)state;
  const double mu = 0.5;
  for (int feet = 2; feet <= 6; feet++) {
    block b = block_default;
    nsdae_system *system = block_system(&b, feet, mu, 0.3);
    for (int motion = 0; motion < 4; motion++) {
      const double tilt[4] = {0, 0.3, 0.6, 0}, speed[4] = {0, 0, 0, 1};
      double q0[3] = {0, b.h, 0}, v0[3] = {speed[motion], 0, 0};
      b.tilt = tilt[motion];
      double a = fmax(0, g * (sin(b.tilt) - mu * cos(b.tilt))), stop = speed[motion] / (mu * g);
      event_run_default(&r);
      event_run_both(&r, system, q0, v0);
      assert_int_equal(r.status, NSDAE_OK);
      assert_int_equal(r.impacts, 0);
      assert_int_equal(r.stats.fallback_steps, 0);
      assert_near(r.q[0], a / 2 + speed[motion] * stop / 2, 1e-8);
      assert_near(r.v[0], a, 1e-8);
      assert_near(r.q[2], 0, 1e-12);
      if (motion != 2) assert_near(r.v[0], 0, 1e-15);
      for (int i = 0; i < r.changes; i++) assert_near(r.change[i].time, stop, 1e-9);
      assert_int_equal(r.changes, motion == 3 ? feet : 0);
      for (int i = 0; i < feet; i++)
        assert_int_equal(r.mode[i], motion == 2 ? NSDAE_MODE_SLIP : NSDAE_MODE_STICK);
      expect_carried(&b, mu, 1, r.v[0] - v0[0] - g * sin(b.tilt));
      if (motion == 0)
        for (int i = 0; i < feet; i++) { /* shared evenly, and no foot pulls at another */
          assert_near(r.normal[i], g / feet, 1e-9);
          assert_near(r.tangential[i], 0, 1e-12);
        }
    }
    nsdae_system_destroy(&system);
  }
}

/* A box pushed at its centre, half width a, height h of the centre: it slides where mu < a / h and
 * the push is above mu m g, with push - mu g; it tips about its edge where mu > a / h and the push
 * is above m g a / h, as a pendulum on the edge, (J + a^2 + h^2) omega^2 / 2 = work. */
static void test_tipping(void **state)
{
  (void)state;
  const double a = 0.5;
  for (int tips = 0; tips < 2; tips++)
    for (int feet = 2; feet <= 4; feet++) {
      block b = block_default;
      b.h = tips ? 2 : 0.5;
      double mu = tips ? 0.6 : 0.4, q0[3] = {0, b.h, 0}, v0[3] = {0};
      b.push = tips ? 1.1 * g * a / b.h : 1.5 * mu * g;
      nsdae_system *system = block_system(&b, feet, mu, 0);
      event_run_default(&r);
      r.t_end = 0.5;
      event_run_both(&r, system, q0, v0);
      assert_int_equal(r.status, NSDAE_OK);
      if (tips) {
        double y = b.h * cos(r.q[2]) - a * sin(r.q[2]); /* about the edge at (a, 0) */
        double work = b.push * r.q[0] - g * (r.q[1] - b.h);
        assert_true(r.q[2] < -0.01);
        assert_near(r.q[1], y, 1e-8);
        assert_near(r.q[0], a - a * cos(r.q[2]) - b.h * sin(r.q[2]), 1e-8);
        assert_near((b.J + a * a + b.h * b.h) * r.v[2] * r.v[2] / 2, work, 1e-8);
        assert_int_equal(r.mode[feet - 1], NSDAE_MODE_STICK);
        for (int i = 0; i < feet - 1; i++) assert_int_equal(r.mode[i], NSDAE_MODE_OPEN);
      } else {
        assert_near(r.q[0], (b.push - mu * g) * 0.25 / 2, 1e-9);
        assert_near(r.q[2], 0, 1e-12);
      }
      nsdae_system_destroy(&system);
    }
}

static double worst_gain, energy;

static int watch_energy(const nsdae_record *record, nsdae_error *error, void *user)
{
  double now = record->kinetic + record->potential;
  (void)error;
  (void)user;
  if (record->step > 0) worst_gain = fmax(worst_gain, now - energy);
  energy = now;
  return 0;
}

/* A block that falls on a corner rocks until it lies: energy never grows, what is lost is what the
 * impacts and the friction took, and it ends on all its feet, which stick. */
static void test_rocking(void **state)
{
  (void)state;
  const double e[] = {0, 0.3, 0.6};
  for (int i = 0; i < 3; i++)
    for (int feet = 2; feet <= 3; feet++) {
      block b = block_default;
      double q0[3] = {0, 0.6, 0.3}, v0[3] = {0};
      nsdae_system *system = block_system(&b, feet, 0.5, e[i]);
      event_run_default(&r);
      r.look = watch_energy;
      r.t_end = 4;
      worst_gain = 0;
      event_run_do(&r, system, q0, v0);
      assert_int_equal(r.status, NSDAE_OK);
      assert_at_most(worst_gain, 1e-8);
      assert_at_most(fabs(r.stats.energy_balance), 1e-8);
      assert_near(r.q[1], b.h, 1e-10);
      assert_near(r.q[2], 0, 1e-10);
      for (int j = 0; j < 3; j++) assert_near(r.v[j], 0, 1e-12);
      for (int j = 0; j < feet; j++) assert_int_equal(r.mode[j], NSDAE_MODE_STICK);
      nsdae_system_destroy(&system);
    }
}

/* ---- a table in space, small angles: q = [x, y, z, a, b, c], legs at (x_i, y_i, -h) ---- */

typedef struct table {
  int legs;
  double x[FEET], y[FEET], h, fx, fy, spin; /* forces and moment grow with t */
  double stretch;                           /* legs are farther out, one after the other */
  double phase;                             /* of the first leg, in parts of the circle's */
} table;

enum { TURN = 10 }; /* 1 / J */

static int table_mass(double t, const double *q, double *M, int ldm, void *user)
{
  (void)t;
  (void)q;
  (void)user;
  for (int i = 0; i < 6; i++) M[i * ldm + i] = i < 3 ? 1 : 1.0 / TURN;
  return 0;
}

static int table_force(double t, const double *q, const double *v, double *F, void *user)
{
  const table *p = user;
  (void)q;
  (void)v;
  const double force[6] = {p->fx * t, p->fy * t, -g, 0, 0, p->spin * t};
  memcpy(F, force, sizeof force);
  return 0;
}

static int table_gap(double t, const double *q, double *gap, void *user)
{
  const table *p = user;
  (void)t;
  for (int i = 0; i < p->legs; i++) gap[i] = q[2] + p->y[i] * q[3] - p->x[i] * q[4];
  return 0;
}

static int table_normal(double t, const double *q, double *W, int ldw, void *user)
{
  const table *p = user;
  (void)t;
  (void)q;
  for (int i = 0; i < p->legs; i++) {
    W[i * ldw + 2] = 1;
    W[i * ldw + 3] = p->y[i];
    W[i * ldw + 4] = -p->x[i];
  }
  return 0;
}

static int table_tangent(double t, const double *q, double *W, int ldw, void *user)
{
  const table *p = user;
  (void)t;
  (void)q;
  for (int i = 0; i < p->legs; i++) {
    double *along_x = W + 2 * i * ldw, *along_y = along_x + ldw;
    along_x[0] = along_y[1] = 1;
    along_x[4] = -p->h;
    along_y[3] = p->h;
    along_x[5] = -p->y[i];
    along_y[5] = p->x[i];
  }
  return 0;
}

static nsdae_system *table_system(table *p, int legs, double mu, double e)
{
  nsdae_system *system;
  nsdae_dims dims = {.nq = 6, .k = legs, .nt = 2};
  p->legs = legs;
  for (int i = 0; i < legs; i++) {
    p->x[i] = cos(2 * pi * (i + p->phase) / legs) * (1 + p->stretch * i);
    p->y[i] = sin(2 * pi * (i + p->phase) / legs);
  }
  assert_int_equal(nsdae_system_create(&dims, &system, NULL), NSDAE_OK);
  nsdae_system_set_user(system, p);
  nsdae_system_set_mass(system, table_mass);
  nsdae_system_set_force(system, table_force);
  nsdae_system_set_gap(system, table_gap);
  nsdae_system_set_gap_normal(system, table_normal);
  nsdae_system_set_gap_tangent(system, table_tangent);
  for (int i = 0; i < legs; i++) nsdae_system_set_contact(system, i, mu, e, 0);
  return system;
}

/* The columns of W do not change: momentum over the whole run, M v - M v_0 = int F + W Lambda. */
static void expect_momentum(const table *p, const double *v0, double t)
{
  double sum[6] = {p->fx * t * t / 2, p->fy * t * t / 2, -g * t, 0, 0, p->spin * t * t / 2};
  for (int i = 0; i < p->legs; i++) {
    double n = r.normal[i], x = r.tangential[2 * i], y = r.tangential[2 * i + 1];
    sum[0] += x;
    sum[1] += y;
    sum[2] += n;
    sum[3] += p->y[i] * n + p->h * y;
    sum[4] += -p->x[i] * n - p->h * x;
    sum[5] += p->x[i] * y - p->y[i] * x;
  }
  for (int i = 0; i < 6; i++) { /* hundreds of steps of rtol, of what legs share in momentum */
    double inverse = i < 3 ? 1 : TURN, share = p->legs > 3 ? inverse : 1;
    assert_near(r.v[i] - v0[i], inverse * sum[i], share * 1e3 * r.options.rtol);
  }
}

/* Every leg slides from then on. Of more than three which ones carry is not determined: one may
 * leave its load to others, and stands by on the floor, where the errors of the integration touch
 * it, slower than anything is counted. */
static void expect_slip(double slip, int legs)
{
  int slid[FEET] = {0}, open[FEET] = {0};
  for (int i = 0; i < r.changes; i++) {
    int leg = r.change[i].contact, mode = r.change[i].mode_after;
    if (slid[leg] == 0) {
      assert_int_equal(mode, NSDAE_MODE_SLIP);
      /* a leg is known to be at its limit to ten times rtol, of all forces: g / rate of that in
       * time; and there are some dozen times at which it is asked anew how they share */
      assert_near(r.change[i].time, slip, 1e-7);
      slid[leg] = 1;
    }
    assert_int_not_equal(mode, NSDAE_MODE_STICK);
    open[leg] = mode == NSDAE_MODE_OPEN;
  }
  int carry = legs;
  for (int i = 0; i < legs; i++) {
    assert_int_equal(slid[i], 1);
    carry -= open[i];
  }
  assert_true(carry >= 3);
  if (legs == 3) assert_int_equal(r.changes, legs); /* nothing is left to rounding */
  if (legs == 3) assert_int_equal(r.impacts, 0);
  for (int i = 0; i < r.impacts; i++) assert_at_most(-r.impact[i].velocity_before, 1e-8);
}

/* Pushed harder and harder, by 5 t at the height of its centre, it slides as one at mu g / 5, all
 * legs at once, though they carry more and more unlike; turned by 4 t at the floor at mu g / 4. */
static void push_table(int legs, int spin, double phase)
{
  const double mu = 0.5, T = 1.5;
  table p = {.h = spin ? 0 : 0.3, .phase = phase};
  double q0[6] = {0}, v0[6] = {0}, rate = spin ? 4 : 5;
  nsdae_system *system = table_system(&p, legs, mu, 0.3);
  double slip = mu * g / rate, speed = rate * (T * T - slip * slip) / 2 - mu * g * (T - slip);
  if (spin)
    p.spin = rate;
  else
    p.fx = 4, p.fy = 3;
  for (int pair = NSDAE_INTEGRATOR_DOPRI5; pair <= NSDAE_INTEGRATOR_DOP853; pair++) {
    event_run_default(&r);
    r.options.integrator = pair;
    r.t_end = T;
    event_run_do(&r, system, q0, v0);
    assert_int_equal(r.status, NSDAE_OK);
    assert_int_equal(r.stats.fallback_steps, 0);
    expect_slip(slip, legs);
    /* what slips 1e-7 s too soon or too late gets mu g of that too much, and more than three legs,
     * which share no better than that, turn and push aside as much; of angles by 1 / J */
    double tol = legs > 3 ? 2e-7 * mu * g : 1e-7, turns = legs > 3 ? TURN * tol : 1e-9;
    double along = spin ? 2e-7 * mu * g : tol; /* legs that slip so far apart push aside */
    assert_near(r.v[0], spin ? 0 : 0.8 * speed, along);
    assert_near(r.v[1], spin ? 0 : 0.6 * speed, along);
    assert_near(r.v[2], 0, tol);
    for (int i = 3; i < 5; i++) assert_near(r.v[i], 0, turns);
    assert_near(r.v[5], spin ? TURN * speed : 0, spin ? TURN * tol : turns);
    expect_momentum(&p, v0, T);
  }
  nsdae_system_destroy(&system);
}

static void test_table(void **state)
{
  (void)state;
  /* 6 of each number of legs, pushed or turned; the quick form has one that is pushed, one turned
   */
  for (int n = 0; n<(test_share() > 1 ? 14 : 36); n += test_share()> 1 ? 7 : 1)
    push_table(3 + n / 6, n % 2, 0.25 + 0.0187 * (n / 2 % 3));
}

/* Pushed and turned at once, on three legs that are not alike: friction shares anew between them
 * until all must slide. The polygon, which is only a start, decides nothing, nor does rtol, and it
 * is done in few instants. */
static void test_pushed_and_turned(void **state)
{
  (void)state;
  const int polygon[] = {5, 8, 24, 8};
  table p = {.h = 0.3, .fx = 3, .spin = 3, .stretch = 0.3, .phase = 0.25};
  double q0[6] = {0}, v0[6] = {0}, first[6], slip = 0;
  nsdae_system *system = table_system(&p, 3, 0.5, 0);
  for (int i = 0; i < 4; i++) {
    event_run_default(&r);
    r.options.polygon = polygon[i];
    if (i == 3) r.options.rtol = 1e-8, r.options.atol = 1e-10;
    r.t_end = 1.5;
    event_run_do(&r, system, q0, v0);
    assert_int_equal(r.status, NSDAE_OK);
    assert_int_equal(r.stats.fallback_steps, 0);
    assert_at_most((double)r.stats.events, 60);
    assert_int_equal(r.changes, 3);
    expect_momentum(&p, v0, 1.5);
    if (i == 0) memcpy(first, r.q, sizeof first);
    if (i == 0) slip = r.change[0].time;
    assert_near(r.change[0].time, slip, i == 3 ? 1e-5 : 1e-7);
    for (int j = 0; j < 6; j++) assert_near(r.q[j], first[j], i == 3 ? 1e-7 : 1e-9);
  }
  nsdae_system_destroy(&system);
}

/* Dropped, tilted and spinning: momentum over everything, energy, and rest on all legs. */
static void test_dropped(void **state)
{
  (void)state;
  const double e[] = {0, 0.3};
  for (int legs = 3; legs <= 4; legs++)
    for (int i = 0; i < 2; i++) {
      table p = {.h = 0.3, .phase = 0.25};
      double q0[6] = {0, 0, 0.3, 0.1, 0.05, 0}, v0[6] = {0.5, 0, 0, 0, 0, 3};
      nsdae_system *system = table_system(&p, legs, 0.5, e[i]);
      event_run_default(&r);
      r.t_end = 2;
      event_run_do(&r, system, q0, v0);
      assert_int_equal(r.status, NSDAE_OK);
      assert_int_equal(r.stats.fallback_steps, 0);
      expect_momentum(&p, v0, 2);
      for (int j = 0; j < 6; j++) assert_near(r.v[j], 0, 1e-10);
      for (int j = 2; j < 5; j++) assert_near(r.q[j], 0, 1e-10);
      for (int j = 0; j < legs; j++) assert_int_equal(r.mode[j], NSDAE_MODE_STICK);
      nsdae_system_destroy(&system);
    }
}

/* ---- a block on the floor and what hits it: q = [x, y] of the block, [u, w] of a ball ---- */

typedef struct hit {
  double m, pull; /* of the ball; on the block */
  int from_above;
} hit;

static int hit_mass(double t, const double *q, double *M, int ldm, void *user)
{
  const hit *p = user;
  (void)t;
  (void)q;
  M[0] = M[ldm + 1] = 1;
  M[2 * ldm + 2] = M[3 * ldm + 3] = p->m;
  return 0;
}

static int hit_force(double t, const double *q, const double *v, double *F, void *user)
{
  const hit *p = user;
  (void)t;
  (void)q;
  (void)v;
  F[0] = p->pull;
  F[1] = -g;
  F[2] = 0;
  F[3] = p->from_above ? -p->m * g : 0;
  return 0;
}

static int hit_gap(double t, const double *q, double *gap, void *user)
{
  const hit *p = user;
  (void)t;
  gap[0] = q[1];
  gap[1] = p->from_above ? q[3] - q[1] : q[0] - q[2];
  return 0;
}

static int hit_tangent(double t, const double *q, double *W, int ldw, void *user)
{
  (void)t;
  (void)q;
  (void)ldw;
  (void)user;
  W[0] = 1;
  return 0;
}

static nsdae_system *hit_system(hit *p, double mu, double e)
{
  nsdae_system *system;
  nsdae_dims dims = {.nq = 4, .k = 2, .nt = 1};
  assert_int_equal(nsdae_system_create(&dims, &system, NULL), NSDAE_OK);
  nsdae_system_set_user(system, p);
  nsdae_system_set_mass(system, hit_mass);
  nsdae_system_set_force(system, hit_force);
  nsdae_system_set_gap(system, hit_gap);
  nsdae_system_set_gap_tangent(system, hit_tangent);
  nsdae_system_set_contact(system, 0, mu, 0, 0);
  nsdae_system_set_contact(system, 1, 0, e, 0);
  return system;
}

/* From the side: the block, which sticks, gets m (1 + e) v / (1 + m) and slides until u / (mu g).
 */
static void test_hit_from_the_side(void **state)
{
  (void)state;
  hit p = {.m = 0.5};
  const double mu = 0.4, e = 0.7, v = 3;
  double q0[4] = {0, 0, -0.3, 0}, v0[4] = {0, 0, v, 0};
  nsdae_system *system = hit_system(&p, mu, e);
  event_run_default(&r);
  event_run_both(&r, system, q0, v0);
  assert_int_equal(r.status, NSDAE_OK);
  double u = p.m * (1 + e) * v / (1 + p.m), slides = u / (mu * g);
  assert_int_equal(r.impacts, 1);
  assert_int_equal(r.impact[0].contact, 1);
  assert_near(r.impact[0].time, 0.1, 1e-9);
  assert_near(r.impact[0].normal_impulse, u, 1e-9);
  assert_int_equal(r.changes, 2);
  assert_near(r.change[0].time, 0.1, 1e-9);
  assert_int_equal(r.change[0].mode_after, NSDAE_MODE_SLIP);
  assert_near(r.change[1].time, 0.1 + slides, 1e-9);
  assert_int_equal(r.change[1].mode_after, NSDAE_MODE_STICK);
  assert_near(r.q[0], u * slides / 2, 1e-9);
  assert_near(r.q[2], 0.9 * (v - u / p.m), 1e-8);
  nsdae_system_destroy(&system);
}

/* From above, on a block that is pulled and sticks: it bounces as on the floor itself, its impulse
 * goes through the block, and the block does not move. */
static void test_hit_from_above(void **state)
{
  (void)state;
  hit p = {.m = 0.5, .pull = 0.3 * g, .from_above = 1};
  const double mu = 0.4, e = 0.5, h = 0.4;
  double q0[4] = {0, 0, 0, h}, v0[4] = {0}, first = sqrt(2 * h / g), v = g * first;
  nsdae_system *system = hit_system(&p, mu, e);
  event_run_default(&r);
  r.t_end = 2;
  event_run_both(&r, system, q0, v0);
  assert_int_equal(r.status, NSDAE_OK);
  for (int i = 0; i < 6; i += 2) {
    assert_int_equal(r.impact[i].contact, 0);
    assert_int_equal(r.impact[i + 1].contact, 1);
    assert_near(r.impact[i + 1].time, first * (1 + 2 * (e - pow(e, i / 2 + 1)) / (1 - e)), 1e-9);
    assert_near(r.impact[i + 1].normal_impulse, p.m * (1 + e) * v * pow(e, i / 2), 1e-9);
    assert_near(r.impact[i].normal_impulse, r.impact[i + 1].normal_impulse, 1e-12);
    assert_true(r.impact[i].velocity_before == 0);
  }
  assert_int_equal(r.stats.accumulations, 1);
  assert_near(r.impact[r.impacts - 1].time, first * (1 + e) / (1 - e), 1e-8);
  for (int i = 0; i < 4; i++) {
    assert_near(r.q[i], 0, 1e-10);
    assert_near(r.v[i], 0, 1e-12);
  }
  assert_int_equal(r.mode[0], NSDAE_MODE_STICK);
  assert_near(r.normal[0], 2 * g * (1 + p.m), 1e-8);
  nsdae_system_destroy(&system);
}

int main(void)
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(test_feet),
      cmocka_unit_test(test_tipping),
      cmocka_unit_test(test_rocking),
      cmocka_unit_test(test_table),
      cmocka_unit_test(test_pushed_and_turned),
      cmocka_unit_test(test_dropped),
      cmocka_unit_test(test_hit_from_the_side),
      cmocka_unit_test(test_hit_from_above),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
