/* The event-driven method at its limits: restitution 0, 1 and in between, impacts that accumulate,
 * events at the ends of steps and runs, states that start on or through a contact, slides whose
 * constraint force changes sign. */
#include "check.h"

#include "event_run.h"
#include "long_pendulum.h"

enum { BALLS = 3 };

static event_run r; /* large */
static const double pi = 3.14159265358979324;

/* ---- balls over one floor, q = [y_1 .. y_n, x]; x is the first one's way along it ---- */

typedef struct balls {
  int count;
  double g;
} balls;

static int balls_mass(double t, const double *q, double *M, int ldm, void *user)
{
  const balls *p = user;
  (void)t;
  (void)q;
  for (int i = 0; i <= p->count; i++) M[i * ldm + i] = 1;
  return 0;
}

static int balls_force(double t, const double *q, const double *v, double *F, void *user)
{
  const balls *p = user;
  (void)t;
  (void)q;
  (void)v;
  for (int i = 0; i < p->count; i++) F[i] = -p->g;
  return 0;
}

static int balls_gap(double t, const double *q, double *gap, void *user)
{
  const balls *p = user;
  (void)t;
  memcpy(gap, q, (size_t)p->count * sizeof *gap);
  return 0;
}

static int balls_tangent(double t, const double *q, double *W, int ldw, void *user)
{
  const balls *p = user;
  (void)t;
  (void)q;
  (void)ldw;
  W[p->count] = 1;
  return 0;
}

static int balls_potential(double t, const double *q, double *V, void *user)
{
  const balls *p = user;
  (void)t;
  for (int i = 0; i < p->count; i++) *V += p->g * q[i];
  return 0;
}

static nsdae_system *balls_system(balls *p, double mu, const double *e)
{
  nsdae_system *system;
  nsdae_dims dims = {.nq = p->count + 1, .k = p->count, .nt = 1};
  assert_int_equal(nsdae_system_create(&dims, &system, NULL), NSDAE_OK);
  nsdae_system_set_user(system, p);
  nsdae_system_set_mass(system, balls_mass);
  nsdae_system_set_force(system, balls_force);
  nsdae_system_set_potential(system, balls_potential);
  nsdae_system_set_gap(system, balls_gap);
  nsdae_system_set_gap_tangent(system, balls_tangent);
  for (int i = 0; i < p->count; i++) nsdae_system_set_contact(system, i, i == 0 ? mu : 0, e[i], 0);
  return system;
}

/* A ball dropped from h: its n-th impact (from 0), and its state at t before it rests. */
static double impact_time(double h, double g, double e, int n)
{
  double first = sqrt(2 * h / g), sum = 0;
  for (int i = 1; i <= n; i++) sum += pow(e, i);
  return first * (1 + 2 * sum);
}

static void flight(double h, double g, double e, double t, double *y, double *v)
{
  double first = sqrt(2 * h / g), from = -first, up = g * first;
  int n = 0;
  while (impact_time(h, g, e, n) <= t) {
    from = impact_time(h, g, e, n);
    n++;
    up *= e;
  }
  if (n == 0) from = -first, up = g * first; /* as if it came from the floor */
  *v = up - g * (t - from);
  *y = up * (t - from) - g * (t - from) * (t - from) / 2;
}

typedef struct expected_flight {
  double h, g, e, worst;
} expected_flight;

/* Every record between two events is on the parabola. */
static int compare_flight(const nsdae_record *record, nsdae_error *error, void *user)
{
  expected_flight *p = user;
  double y, v;
  (void)error;
  flight(p->h, p->g, p->e, record->time, &y, &v);
  p->worst = fmax(p->worst, fabs(record->q[0] - y));
  return 0;
}

/* e = 1 keeps its energy, e = 0 and 1e-9 end in the first impact (and what is left of it); in
 * between every sample is on the closed form, whatever dt: also where a step holds all impacts. */
static void test_restitution(void **state)
{
  (void)state;
  const double e[] = {0, 1e-9, 0.5, 0.9, 1}, dt[] = {0.01, 0.37, 5};
  const double h = 1, g = 9.81, first = sqrt(2 * h / g);
  for (int i = 0; i < 5; i++)
    for (int j = 0; j < 3; j++) {
      balls p = {.count = 1, .g = g};
      double q0[2] = {h}, v0[2] = {0};
      nsdae_system *system = balls_system(&p, 0, &e[i]);
      expected_flight exact = {h, g, e[i], 0};
      event_run_default(&r);
      r.options.dt = dt[j];
      r.t_end = 5;
      if (e[i] > 0.5) r.look = compare_flight, r.user = &exact;
      event_run_both(&r, system, q0, v0);
      assert_int_equal(r.status, NSDAE_OK);
      assert_int_equal(r.stats.fallback_steps, 0);
      for (int n = 0; n < r.impacts && !r.impact[n].accumulation; n++) {
        assert_near(r.impact[n].time, impact_time(h, g, e[i], n), 1e-8);
        assert_near(r.impact[n].normal_impulse, (1 + e[i]) * g * first * pow(e[i], n), 1e-8);
      }
      assert_at_most(exact.worst, 1e-7); /* 10 m/s times an impact's time */
      assert_near(r.normal[0], r.v[0] + 5 * g, 1e-8);
      assert_at_most(fabs(r.stats.energy_balance), 1e-8);
      if (e[i] <= 0.5) {
        double rest = first * (1 + e[i]) / (1 - e[i]);
        assert_near(r.impact[r.impacts - 1].time, rest, 1e-8);
        assert_near(r.q[0], 0, 1e-12);
        assert_int_equal(r.mode[0], NSDAE_MODE_SLIP);
      }
      if (e[i] == 1) assert_near(r.v[0] * r.v[0] / 2 + g * r.q[0], g * h, 1e-8);
      nsdae_system_destroy(&system);
    }
}

/* Three balls come to rest at times of their own, one of them while another bounces on. */
static void test_accumulations(void **state)
{
  (void)state;
  const double e[BALLS] = {0.5, 0.8, 0.3}, h[BALLS] = {1, 0.2, 1}, g = 9.81;
  balls p = {.count = BALLS, .g = g};
  double q0[BALLS + 1] = {h[0], h[1], h[2]}, v0[BALLS + 1] = {0};
  nsdae_system *system = balls_system(&p, 0, e);
  event_run_default(&r);
  r.t_end = 3;
  event_run_both(&r, system, q0, v0);
  assert_int_equal(r.stats.accumulations, BALLS);
  for (int i = 0; i < r.impacts; i++) {
    int ball = r.impact[i].contact;
    if (!r.impact[i].accumulation) continue;
    double rest = sqrt(2 * h[ball] / g) * (1 + e[ball]) / (1 - e[ball]);
    assert_near(r.impact[i].time, rest, 1e-8);
  }
  for (int i = 0; i < BALLS; i++) assert_near(r.normal[i], 3 * g, 1e-8);
  nsdae_system_destroy(&system);
}

/* e = 0.99: hundreds of impacts, more than a step's list holds. Where a step may not hold them it
 * is stepped by implicit, which is told. */
static void test_many_impacts(void **state)
{
  (void)state;
  const double e = 0.99, h = 0.01, g = 9.81, first = sqrt(2 * h / g), rest = first * 199;
  balls p = {.count = 1, .g = g};
  double q0[2] = {h}, v0[2] = {0};
  nsdae_system *system = balls_system(&p, 0, &e);
  event_run_default(&r);
  r.options.dt = 1;
  r.t_end = 10;
  event_run_do(&r, system, q0, v0);
  assert_int_equal(r.status, NSDAE_OK);
  assert_int_equal(r.stats.fallback_steps, 0);
  assert_int_equal(r.stats.accumulations, 1);
  assert_true(r.impacts > 500);
  assert_near(r.impact[r.impacts - 1].time, rest, 1e-6); /* of some 700 impacts */
  for (int i = 0; i < r.impacts - 1; i++)
    assert_near(r.impact[i].time, impact_time(h, g, e, i), 1e-6);
  r.options.events_max = 20;
  r.options.dt = 0.5;
  r.look = NULL;
  nsdae_sim *sim;
  nsdae_stats stats;
  assert_int_equal(nsdae_sim_create(system, &r.options, &sim, NULL), NSDAE_OK);
  assert_int_equal(nsdae_sim_init(sim, 0, q0, v0), NSDAE_OK);
  assert_int_equal(nsdae_sim_run(sim, 10),
                   NSDAE_WARN_PENETRATION); /* by implicit, with its depth */
  nsdae_sim_get_stats(sim, &stats);
  assert_true(stats.fallback_steps > 0 && stats.fallback_steps < 20);
  nsdae_sim_destroy(&sim);
  nsdae_system_destroy(&system);
}

/* A ball that bounces with friction: Lambda_T = -mu Lambda_N at every impact and in between, so
 * that from its rest on it has v_0 - mu g t, and stops at v_0 / (mu g). */
static void test_sliding_to_rest(void **state)
{
  (void)state;
  const double e = 0.6, h = 0.3, g = 9.81, mu = 0.2, v = 4;
  balls p = {.count = 1, .g = g};
  double q0[2] = {h, 0}, v0[2] = {0, v}, rest = sqrt(2 * h / g) * (1 + e) / (1 - e);
  nsdae_system *system = balls_system(&p, mu, &e);
  event_run_default(&r);
  r.t_end = 3;
  event_run_both(&r, system, q0, v0);
  assert_int_equal(r.status, NSDAE_OK);
  for (int i = 0; i < r.impacts; i++)
    assert_near(r.impact[i].tangential_impulse[0], -mu * r.impact[i].normal_impulse, 1e-12);
  assert_int_equal(r.changes, 2);
  assert_near(r.change[0].time, rest, 1e-5); /* closed where less than accumulation_time is left */
  assert_int_equal(r.change[0].mode_after, NSDAE_MODE_SLIP);
  assert_near(r.change[1].time, v / (mu * g), 1e-8);
  assert_int_equal(r.change[1].mode_after, NSDAE_MODE_STICK);
  assert_near(r.v[1], 0, 1e-15);
  nsdae_system_destroy(&system);
}

/* The least atol that is allowed, with coordinates and velocities that are and stay zero: their
 * weights are 1 / atol. */
static void test_least_atol(void **state)
{
  (void)state;
  const double e = 0.5;
  balls p = {.count = 1, .g = 2};
  double q0[2] = {1, 0}, v0[2] = {0};
  nsdae_sim_options options;
  nsdae_sim_options_default(&options);
  assert_int_equal(nsdae_sim_options_set(&options, "atol", "1e-300", NULL), NSDAE_E_ARGUMENT);
  nsdae_system *system = balls_system(&p, 0, &e);
  event_run_default(&r);
  r.options.atol = 1e-100;
  r.t_end = 1.75;
  event_run_both(&r, system, q0, v0);
  assert_int_equal(r.status, NSDAE_OK);
  assert_int_equal(r.impacts, 1);
  assert_near(r.impact[0].time, 1, 1e-9);
  assert_near(r.q[0], 0.75 * 0.25, 1e-9); /* v t - t^2, v = 1, at t = 0.75 */
  assert_true(r.q[1] == 0 && r.v[1] == 0);
  nsdae_system_destroy(&system);
}

/* With g = 2 a ball from 1 is on the floor at t = 1: a step ends there, or a run, or one starts
 * there. The impact is seen once, and what follows is the same. */
static void test_event_at_an_end(void **state)
{
  (void)state;
  const double e = 0.5, g = 2;
  balls p = {.count = 1, .g = g};
  nsdae_system *system = balls_system(&p, 0, &e);
  for (int i = 0; i < 4; i++) {
    const double stop[4] = {1, 2, 2.5, 1.5};
    double q0[2] = {1}, v0[2] = {0};
    nsdae_sim *sim;
    nsdae_stats stats;
    nsdae_record record;
    event_run_default(&r);
    r.options.dt = i % 2 ? 0.25 : 0.01;
    assert_int_equal(nsdae_sim_create(system, &r.options, &sim, NULL), NSDAE_OK);
    assert_int_equal(nsdae_sim_init(sim, 0, q0, v0), NSDAE_OK);
    assert_int_equal(nsdae_sim_run(sim, stop[i]), NSDAE_OK);
    assert_int_equal(nsdae_sim_run(sim, 2.7), NSDAE_OK);
    nsdae_sim_get_stats(sim, &stats);
    nsdae_sim_get_record(sim, &record);
    /* impacts at 1, 2, 2.5, with 2, 1, 0.5; after them v = 1, 0.5, 0.25 */
    assert_int_equal(stats.impacts, 3);
    assert_near(record.q[0], 0.25 * 0.2 - 0.2 * 0.2, 1e-8);
    nsdae_sim_destroy(&sim);
  }
  double q0[2] = {0}, v0[2] = {-2}; /* starts in the impact */
  event_run_default(&r);
  r.t0 = 1;
  r.t_end = 2.25;
  event_run_both(&r, system, q0, v0);
  assert_int_equal(r.impacts, 2);
  assert_near(r.impact[0].time, 1, 0);
  assert_near(r.impact[0].normal_impulse, 3, 1e-12);
  assert_near(r.impact[1].time, 2, 1e-9);
  nsdae_system_destroy(&system);
}

/* Starts that are not clean: through the floor by a little, coming and going; on it at rest.
 * Nothing falls through. A run in which nothing happens has no events but its start. */
static void test_starts(void **state)
{
  (void)state;
  const double e = 0.5, g = 9.81, speed[] = {-1, 1, 0}, deep[] = {0, -1e-7};
  balls p = {.count = 1, .g = g};
  nsdae_system *system = balls_system(&p, 0, &e);
  for (int i = 0; i < 6; i++) {
    double q0[2] = {deep[i / 3]}, v0[2] = {speed[i % 3]};
    nsdae_sim *sim;
    nsdae_record record;
    event_run_default(&r);
    assert_int_equal(nsdae_sim_create(system, &r.options, &sim, NULL), NSDAE_OK);
    assert_int_equal(nsdae_sim_init(sim, 0, q0, v0), NSDAE_OK);
    assert_int_equal(nsdae_sim_run(sim, 2), NSDAE_OK);
    nsdae_sim_get_record(sim, &record);
    assert_at_most(record.penetration, 1e-9);
    assert_near(record.q[0], 0, 1e-9);
    assert_near(record.v[0], 0, 1e-9);
    nsdae_sim_destroy(&sim);
  }
  double q0[2] = {100}, v0[2] = {0};
  event_run_default(&r);
  event_run_both(&r, system, q0, v0);
  assert_int_equal(r.stats.events, 1);
  assert_near(r.q[0], 100 - g / 2, 1e-9);
  p.g = 0;
  event_run_both(&r, system, q0, v0);
  assert_true(r.q[0] == 100 && r.v[0] == 0 && r.stats.events == 1);
  nsdae_system_destroy(&system);
}

/* The weights of Baumgarte's stabilisation change nothing, but that those of 1e4 make accelerations
 * of 1e-5 m/s^2 out of atol: beta^2 1e-13 m. */
static void test_stabilisation(void **state)
{
  (void)state;
  const double weight[] = {0, 1, 100, 1e4};
  for (int i = 0; i < 4; i++) {
    /* no contacts: in the quick form the run by list has the second */
    if (test_share() > 1 && (i == 3 || i % 2 != (getenv("EVENT_RUN_BY_LIST") != NULL))) continue;
    long_pendulum p;
    double q0[2], v0[2];
    long_pendulum_default(&p);
    long_pendulum_start(&p, q0, v0);
    nsdae_system *system = long_pendulum_system(&p);
    event_run_default(&r);
    r.options.rtol = 1e-11;
    r.options.atol = 1e-13;
    r.options.baumgarte_alpha = r.options.baumgarte_beta = weight[i];
    r.t_end = 10;
    nsdae_sim *sim;
    nsdae_record record;
    assert_int_equal(nsdae_sim_create(system, &r.options, &sim, NULL), NSDAE_OK);
    assert_int_equal(nsdae_sim_init(sim, 0, q0, v0), NSDAE_OK);
    assert_int_equal(nsdae_sim_run(sim, 10), NSDAE_OK);
    nsdae_sim_get_record(sim, &record);
    print_message("alpha = beta = %g: y(10) off by %.1e m, drift %.1e m\n", weight[i],
                  record.q[1] + 0.961419205099, record.constraint_drift);
    assert_near(record.q[1], -0.961419205099, weight[i] < 1e4 ? 1e-8 : 1e-5);
    nsdae_sim_destroy(&sim);
    nsdae_system_destroy(&system);
  }
}

/* ---- a slider in a slot along x, pressed to its sides by A cos t: q = [x, y] ---- */

typedef struct slot {
  double press, pull;
} slot;

static int slot_mass(double t, const double *q, double *M, int ldm, void *user)
{
  (void)t;
  (void)q;
  (void)user;
  M[0] = M[ldm + 1] = 1;
  return 0;
}

static int slot_force(double t, const double *q, const double *v, double *F, void *user)
{
  const slot *p = user;
  (void)q;
  (void)v;
  F[0] = p->pull;
  F[1] = p->press * cos(t);
  return 0;
}

static int slot_constraint(double t, const double *q, double *phi, void *user)
{
  (void)t;
  (void)user;
  phi[0] = q[1];
  return 0;
}

static int slot_jacobian(double t, const double *q, double *J, int ldj, void *user)
{
  (void)t;
  (void)q;
  (void)user;
  J[ldj] = 1;
  return 0;
}

static int slot_slide(double t, const double *q, double *W, int ldw, double *w, void *user)
{
  (void)t;
  (void)q;
  (void)ldw;
  (void)w;
  (void)user;
  W[0] = 1;
  return 0;
}

/* integral of |cos| from 0 */
static double absolute_cosine(double t)
{
  double half = floor(t / pi + 0.5);
  return 2 * half + sin(t - half * pi);
}

/* It slips where mu |A cos t| has fallen below the pull, slides through the sign of lambda, and
 * stops where v = P (t - t_s) - mu A (C(t) - C(t_s)) is zero, by bisection; and so every half
 * period. One that is fast slides through all of them. */
static void test_slot(void **state)
{
  (void)state;
  slot p = {.press = 10, .pull = 1};
  const double mu = 0.5, most = mu * p.press;
  nsdae_system *system;
  nsdae_dims dims = {.nq = 2, .m = 1, .f = 1};
  assert_int_equal(nsdae_system_create(&dims, &system, NULL), NSDAE_OK);
  nsdae_system_set_user(system, &p);
  nsdae_system_set_mass(system, slot_mass);
  nsdae_system_set_force(system, slot_force);
  nsdae_system_set_constraint(system, slot_constraint);
  nsdae_system_set_constraint_jacobian(system, slot_jacobian);
  nsdae_system_set_frictional_joint_tangent(system, slot_slide);
  nsdae_system_set_frictional_joint(system, 0, 0, mu);
  double q0[2] = {0}, v0[2] = {0};
  event_run_default(&r);
  r.t_end = 10;
  event_run_both(&r, system, q0, v0);
  assert_int_equal(r.status, NSDAE_OK);
  assert_int_equal(r.changes, 6);
  for (int i = 0; i < 3; i++) {
    double slip = acos(p.pull / most) + i * pi, from = slip + 1e-3, to = slip + pi;
    for (int j = 0; j < 60; j++) {
      double t = (from + to) / 2;
      double v = p.pull * (t - slip) - most * (absolute_cosine(t) - absolute_cosine(slip));
      if (v > 0)
        from = t;
      else
        to = t;
    }
    assert_near(r.change[2 * i].time, slip, 1e-8);
    assert_int_equal(r.change[2 * i].mode_after, NSDAE_MODE_SLIP);
    assert_near(r.change[2 * i + 1].time, from, 1e-8);
    assert_int_equal(r.change[2 * i + 1].mode_after, NSDAE_MODE_STICK);
  }
  v0[0] = 100;
  event_run_both(&r, system, q0, v0);
  assert_int_equal(r.changes, 0);
  assert_near(r.v[0], 100 + p.pull * 10 - most * absolute_cosine(10), 1e-7);
  nsdae_system_destroy(&system);
}

/* ---- a ball that just fits between two walls ---- */

static int fitted_mass(double t, const double *q, double *M, int ldm, void *user)
{
  (void)t;
  (void)q;
  (void)ldm;
  (void)user;
  M[0] = 1;
  return 0;
}

static int fitted_force(double t, const double *q, const double *v, double *F, void *user)
{
  (void)t;
  (void)q;
  (void)v;
  (void)user;
  F[0] = 0;
  return 0;
}

static int fitted_gap(double t, const double *q, double *gap, void *user)
{
  (void)t;
  (void)user;
  gap[0] = q[0];
  gap[1] = -q[0];
  return 0;
}

/* It bounces to and fro in no time. With e < 1 it ends at rest, and all it had is dissipated; with
 * e = 1 it never does: no such step is done by the method itself, and no energy is lost unsaid. */
static void test_no_room(void **state)
{
  (void)state;
  const double e[] = {0, 0.5, 0.9, 0.99, 1}, q0 = 0, v0 = 1;
  const nsdae_dims dims = {.nq = 1, .k = 2};
  for (int i = 0; i < 5; i++) {
    nsdae_system *system;
    assert_int_equal(nsdae_system_create(&dims, &system, NULL), NSDAE_OK);
    nsdae_system_set_mass(system, fitted_mass);
    nsdae_system_set_force(system, fitted_force);
    nsdae_system_set_gap(system, fitted_gap);
    for (int j = 0; j < 2; j++) nsdae_system_set_contact(system, j, 0, e[i], 0);
    event_run_default(&r);
    r.t_end = 0.1;
    event_run_do(&r, system, &q0, &v0);
    nsdae_system_destroy(&system);
    assert_int_equal(r.status, NSDAE_OK);
    assert_near(r.stats.energy_balance, 0, 1e-12);
    assert_true((e[i] < 1) == (r.stats.fallback_steps == 0));
    if (e[i] < 1) assert_near(r.v[0], 0, 1e-9); /* what counts as no velocity */
  }
}

/* ---- a light ball between a wall and a heavy one ---- */

typedef struct squeezed {
  double light, heavy, g;
} squeezed;

static int squeezed_mass(double t, const double *q, double *M, int ldm, void *user)
{
  const squeezed *p = user;
  (void)t;
  (void)q;
  M[0] = p->light;
  M[ldm + 1] = p->heavy;
  return 0;
}

static int squeezed_force(double t, const double *q, const double *v, double *F, void *user)
{
  const squeezed *p = user;
  (void)t;
  (void)q;
  (void)v;
  F[0] = -p->light * p->g;
  F[1] = -p->heavy * p->g;
  return 0;
}

static int squeezed_potential(double t, const double *q, double *V, void *user)
{
  const squeezed *p = user;
  (void)t;
  *V = p->g * (p->light * q[0] + p->heavy * q[1]);
  return 0;
}

static int squeezed_gap(double t, const double *q, double *gap, void *user)
{
  (void)t;
  (void)user;
  gap[0] = q[0];
  gap[1] = q[1] - q[0];
  return 0;
}

static long squeezed_impacts;

static int count_impacts(const nsdae_record *record, nsdae_error *error, void *user)
{
  (void)error;
  (void)user;
  squeezed_impacts += record->impacts;
  return 0;
}

static void squeeze(squeezed *p, double e, const double *q0, const double *v0, double t_end)
{
  const nsdae_dims dims = {.nq = 2, .k = 2};
  nsdae_system *system;
  assert_int_equal(nsdae_system_create(&dims, &system, NULL), NSDAE_OK);
  nsdae_system_set_user(system, p);
  nsdae_system_set_mass(system, squeezed_mass);
  nsdae_system_set_force(system, squeezed_force);
  nsdae_system_set_potential(system, squeezed_potential);
  nsdae_system_set_gap(system, squeezed_gap);
  for (int i = 0; i < 2; i++) nsdae_system_set_contact(system, i, 0, e, 0);
  event_run_default(&r);
  r.t_end = t_end;
  r.look = count_impacts;
  squeezed_impacts = 0;
  event_run_do(&r, system, q0, v0);
  nsdae_system_destroy(&system);
  assert_int_equal(r.status, NSDAE_OK);
  assert_int_equal(r.stats.fallback_steps, 0);
}

/* A heavy ball that meets a light one at rest before a wall, without loss and gravity: with a ratio
 * of masses of 100^n there are as many impacts as the first n + 1 digits of pi say (Galperin,
 * "Playing pool with pi", 2003). */
static void test_pool_with_pi(void **state)
{
  (void)state;
  const long impacts[] = {3, 31, 314, 3141};
  for (int n = 0; n < 4; n++) {
    squeezed p = {1, pow(100, n), 0};
    double q0[2] = {1, 2}, v0[2] = {0, -1};
    squeeze(&p, 1, q0, v0, 50);
    assert_int_equal(squeezed_impacts, impacts[n]);
    assert_near(r.stats.energy_balance / p.heavy, 0, 1e-9);
    assert_true(r.q[0] > 0 && r.v[1] > r.v[0] && r.v[0] > -1e-9);
  }
}

/* Dropped together, the heavy one 1e6 times as heavy: thousands of impacts at a time. None
 * overlaps, none gains, and what is lost is said. */
static void test_mass_ratio(void **state)
{
  (void)state;
  const double e[] = {0, 0.3, 0.5, 0.8, 0.95, 1};
  for (int i = 0; i < 6; i++)
    for (int turned = 0; turned < 2; turned++) {
      if (test_share() > 1 && (i + turned) % 2) continue; /* each e_N one way round */
      squeezed p = {turned ? 1e6 : 1, turned ? 1 : 1e6, 9.81};
      double q0[2] = {0.1, 0.2}, v0[2] = {0};
      squeeze(&p, e[i], q0, v0, 1.5);
      double start = p.g * (p.light * q0[0] + p.heavy * q0[1]);
      assert_at_most(fabs(r.stats.energy_balance), 1e-8 * start);
      if (e[i] <= 0.5) assert_near(fmax(fabs(r.v[0]), fabs(r.v[1])), 0, 1e-8);
    }
}

/* v+ of the heavy ball after all impacts, one by one: a limit of zero (inelastic collapse) within
 * 1e-12 counts as reached. */
static double after_impacts(const squeezed *p, double e)
{
  double u = 0, w = -1;
  while (fabs(u) + fabs(w) > 1e-12 && (u < 0 || w < u)) {
    if (u < 0) u = -e * u;
    double P = (1 + e) * fmax(0, u - w) / (1 / p->light + 1 / p->heavy);
    u -= P / p->light;
    w += P / p->heavy;
  }
  return w;
}

/* The heavy ball comes with 1 m/s to the light one at rest. With (1 - e)^2 < 4 e m / M the impacts
 * end and it rebounds; else they have no end, and both balls come to rest, whatever e_N is. The
 * impacts of a collapse are too many to be made one by one. */
static void test_collapse(void **state)
{
  (void)state;
  const double e[] = {0, 0.3, 0.5, 0.9, 0.95, 0.99};
  for (int i = 0; i < 6; i++)
    for (double ratio = 10; ratio<2e5; ratio *= test_share()> 1 ? 100 : 10) {
      squeezed p = {1, ratio, 0};
      double q0[2] = {1e-3, 2e-3}, v0[2] = {0, -1};
      squeeze(&p, e[i], q0, v0, 0.1);
      /* what counts as no velocity: 10 rtol of the light ball's 2 m/s */
      assert_near(r.v[1], after_impacts(&p, e[i]), 2e-7);
      assert_true(r.q[0] > -1e-9 && r.q[1] - r.q[0] > -1e-9);
    }
}

/* ---- two beads on wires of their own, each between two walls ---- */

enum { BEAD_GAPS = 4 };

static int beads_mass(double t, const double *q, double *M, int ldm, void *user)
{
  (void)t;
  (void)q;
  (void)user;
  M[0] = M[ldm + 1] = 1;
  return 0;
}

static int beads_force(double t, const double *q, const double *v, double *F, void *user)
{
  (void)t;
  (void)q;
  (void)v;
  (void)user;
  F[0] = F[1] = 0;
  return 0;
}

static int beads_gap(double t, const double *q, double *gap, void *user)
{
  const double *play = user;
  (void)t;
  for (int i = 0; i < 2; i++) {
    gap[2 * i] = q[i];
    gap[2 * i + 1] = play[i] - q[i];
  }
  return 0;
}

/* One bounces thousands of times in a small play, the other a few times in a wide one: without loss
 * both keep their speed, whatever dt is. */
static void test_beads(void **state)
{
  (void)state;
  const double dt[] = {0.01, 0.1, 1};
  double play[2] = {5e-3, 0.5};
  for (int i = 0; i<3; i += test_share()> 1 ? 2 : 1) {
    const nsdae_dims dims = {.nq = 2, .k = BEAD_GAPS};
    double q0[2] = {2.5e-3, 0.25}, v0[2] = {1, 0.05};
    nsdae_system *system;
    nsdae_sim_options o;
    nsdae_record record;
    nsdae_stats stats;
    nsdae_sim *sim;
    assert_int_equal(nsdae_system_create(&dims, &system, NULL), NSDAE_OK);
    nsdae_system_set_user(system, play);
    nsdae_system_set_mass(system, beads_mass);
    nsdae_system_set_force(system, beads_force);
    nsdae_system_set_gap(system, beads_gap);
    for (int j = 0; j < BEAD_GAPS; j++) nsdae_system_set_contact(system, j, 0, 1, 0);
    nsdae_sim_options_default(&o);
    o.method = NSDAE_METHOD_EVENT;
    o.dt = dt[i];
    assert_int_equal(nsdae_sim_create(system, &o, &sim, NULL), NSDAE_OK);
    assert_int_equal(nsdae_sim_init(sim, 0, q0, v0), NSDAE_OK);
    assert_int_equal(nsdae_sim_run(sim, 30), NSDAE_OK);
    nsdae_sim_get_record(sim, &record);
    nsdae_sim_get_stats(sim, &stats);
    assert_near(fabs(record.v[0]), 1, 1e-6);
    assert_near(fabs(record.v[1]), 0.05, 1e-6);
    assert_int_equal(stats.accumulations_early, 0);
    assert_int_equal(stats.fallback_steps, 0);
    nsdae_sim_destroy(&sim);
    nsdae_system_destroy(&system);
  }
}

int main(void)
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(test_restitution),  cmocka_unit_test(test_accumulations),
      cmocka_unit_test(test_many_impacts), cmocka_unit_test(test_sliding_to_rest),
      cmocka_unit_test(test_least_atol),   cmocka_unit_test(test_event_at_an_end),
      cmocka_unit_test(test_starts),       cmocka_unit_test(test_stabilisation),
      cmocka_unit_test(test_slot),         cmocka_unit_test(test_no_room),
      cmocka_unit_test(test_pool_with_pi), cmocka_unit_test(test_mass_ratio),
      cmocka_unit_test(test_collapse),     cmocka_unit_test(test_beads),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
