/* Friction of the event-driven method against closed forms, on small systems. */
#include "check.h"

#include "incline.h"
#include "rolling_ball.h"

enum { KEPT = 256, NQ = 7, K = 4 };

/* What a run leaves. */
typedef struct run {
  int status, changes, impacts;
  nsdae_change change[KEPT];
  nsdae_impact impact[KEPT];
  double q[NQ], v[NQ];
  double normal[K], tangential[2 * K]; /* impulses, over the whole run */
  nsdae_stats stats;
  nsdae_dims dims;
} run;

static run r; /* of the last run */

static int observe(const nsdae_record *record, nsdae_error *error, void *user)
{
  (void)error;
  (void)user;
  for (int i = 0; i < record->changes && r.changes < KEPT; i++)
    r.change[r.changes++] = record->change[i];
  for (int i = 0; i < record->impacts && r.impacts < KEPT; i++)
    r.impact[r.impacts++] = record->impact[i];
  memcpy(r.q, record->q, (size_t)r.dims.nq * sizeof *r.q);
  memcpy(r.v, record->v, (size_t)r.dims.nv * sizeof *r.v);
  for (int i = 0; i < r.dims.k; i++) r.normal[i] += record->normal_impulse[i];
  for (int i = 0; i < r.dims.k * r.dims.nt; i++) r.tangential[i] += record->tangential_impulse[i];
  return 0;
}

static nsdae_sim_options options_of(double rtol)
{
  nsdae_sim_options options;
  nsdae_sim_options_default(&options);
  options.method = NSDAE_METHOD_EVENT;
  options.rtol = rtol;
  options.atol = rtol / 100;
  options.dt = 0.01;
  return options;
}

/* Runs to t_end and releases the system. */
static void integrate(nsdae_system *system, const nsdae_sim_options *options, const double *q0,
                      const double *v0, double t_end)
{
  nsdae_sim *sim;
  r = (run){0};
  nsdae_system_get_dims(system, &r.dims);
  assert_int_equal(nsdae_sim_create(system, options, &sim, NULL), NSDAE_OK);
  assert_int_equal(nsdae_sim_init(sim, 0, q0, v0), NSDAE_OK);
  nsdae_sim_observe(sim, observe, NULL);
  r.status = nsdae_sim_run(sim, t_end);
  if (r.status < 0) print_message("%s\n", nsdae_sim_error(sim)->text);
  nsdae_sim_get_stats(sim, &r.stats);
  nsdae_sim_destroy(&sim);
  nsdae_system_destroy(&system);
  assert_int_equal(r.status, NSDAE_OK);
  assert_int_equal(r.stats.fallback_steps, 0);
}

static void integrate_model(const driver_model *model, const nsdae_sim_options *options,
                            double t_end)
{
  nsdae_system *system;
  double q0[NQ] = {0}, v0[NQ] = {0};
  assert_int_equal(model->build(model->base, &system, NULL), NSDAE_OK);
  model->start(model->base, q0, v0);
  integrate(system, options, q0, v0, t_end);
}

static void *defaults(const driver_model *model)
{
  nsdae_params_default(model->parameters, model->base);
  return model->base;
}

/* A block that slides on an incline at the angle b from the fall line turns into it and stops
 * there. With s = g sin(slope), m = mu g cos(slope) and the angle c of its velocity
 *
 *   v' = s cos c - m,   v c' = -s sin c   =>   d/dt [v (m + s cos c)] = s^2 - m^2
 *
 * so that it stops at t = v_0 (m + s cos b) / (m^2 - s^2), where v_T / |v_T| has no limit of its
 * own. The polygon decides nothing. */
static void test_block_stops(void **state)
{
  (void)state;
  incline *p = defaults(&incline_model);
  double worst = 0;
  int number = 0;
  for (int edges = 3; edges <= 16; edges += 5)
    for (double load = 0; load < 1; load += 0.3)
      for (double turn = 0; turn < 6.3; turn += 0.9)
        for (double b = 0; b < 6.3; b += 0.61) {
          if (number++ % test_share() > 0) continue;
          nsdae_sim_options options = options_of(1e-9);
          options.polygon = edges;
          p->slope = atan(load * p->mu);
          p->turn = turn;
          p->vx = 0.5 * cos(turn + b);
          p->vy = 0.5 * sin(turn + b);
          double s = p->g * sin(p->slope), m = p->mu * p->g * cos(p->slope);
          double stop = 0.5 * (m + s * cos(b)) / (m * m - s * s);
          integrate_model(&incline_model, &options, 2);
          assert_int_equal(r.changes, 1);
          assert_int_equal(r.change[0].mode_after, NSDAE_MODE_STICK);
          assert_at_most((double)r.stats.events, 2); /* the start and the stop */
          worst = fmax(worst, fabs(r.change[0].time / stop - 1));
          for (int i = 0; i < 3; i++) assert_true(r.v[i] == 0);
          /* all it had went into friction; rtol over a hundred steps */
          assert_at_most(fabs(r.stats.energy_balance), 1e-8);
        }
  print_message("block stops to %.1e\n", worst);
  assert_at_most(worst, 1e-7); /* a hundred steps of rtol */
}

/* From rest above the angle of friction it slides down the fall line with g (sin - mu cos), from
 * the first; also where that is hardly more than nothing. */
static void test_block_slides(void **state)
{
  (void)state;
  incline *p = defaults(&incline_model);
  p->vx = 0;
  for (int i = 0; i < 2; i++)
    for (int edges = 3; edges <= 16; edges += 5)
      for (double turn = 0; turn < 6.3; turn += 0.37) {
        nsdae_sim_options options = options_of(1e-9);
        options.polygon = edges;
        p->slope = i == 0 ? 0.6 : atan(1.000001 * p->mu);
        p->turn = turn;
        double a = p->g * (sin(p->slope) - p->mu * cos(p->slope));
        integrate_model(&incline_model, &options, 2);
        assert_near(r.v[0], 2 * a * cos(turn), 1e-8);
        assert_near(r.v[1], 2 * a * sin(turn), 1e-8);
        assert_at_most((double)r.stats.events, 2);
      }
}

/* At rest, then mu becomes mu_1: from there it slides with g (sin - mu_1 cos), or stays. */
static void test_less_friction(void **state)
{
  (void)state;
  const double mu[] = {0.7, 0.5, 0.1, 0.01, 0}, q0[3] = {0}, v0[3] = {0};
  incline *p = defaults(&incline_model);
  p->slope = 0.5;
  p->mu = 0.8;
  for (int i = 0; i < 5; i++) {
    nsdae_sim_options options = options_of(1e-9);
    nsdae_system *system;
    nsdae_sim *sim;
    nsdae_record record;
    assert_int_equal(incline_model.build(p, &system, NULL), NSDAE_OK);
    assert_int_equal(nsdae_sim_create(system, &options, &sim, NULL), NSDAE_OK);
    assert_int_equal(nsdae_sim_init(sim, 0, q0, v0), NSDAE_OK);
    assert_int_equal(nsdae_sim_run(sim, 0.5), NSDAE_OK);
    assert_int_equal(nsdae_sim_set_contact(sim, 0, mu[i], 0, 0), NSDAE_OK);
    if (nsdae_sim_run(sim, 1) < 0) fail_msg("%s", nsdae_sim_error(sim)->text);
    nsdae_sim_get_record(sim, &record);
    double a = p->g * fmax(0, sin(p->slope) - mu[i] * cos(p->slope));
    assert_near(hypot(record.v[0], record.v[1]), 0.5 * a, 1e-12);
    nsdae_sim_destroy(&sim);
    nsdae_system_destroy(&system);
  }
}

/* The ball rolls from t = 2 |v_T| / (7 mu g) on, with the velocity (5 v + 2 r (w_y, -w_x)) / 7. */
static void test_ball_rolls(void **state)
{
  (void)state;
  rolling_ball *p = defaults(&rolling_ball_model);
  for (int spin = 0; spin < 12; spin++) {
    nsdae_sim_options options = options_of(1e-9);
    p->vx = 2 * cos(1.1 * spin);
    p->vy = 2 * sin(1.1 * spin);
    p->wx = 70 * cos(0.7 * spin + 0.2);
    p->wy = 70 * sin(0.7 * spin + 0.2);
    double slip = hypot(p->vx - p->r * p->wy, p->vy + p->r * p->wx);
    integrate_model(&rolling_ball_model, &options, 1);
    assert_int_equal(r.changes, 1);
    assert_int_equal(r.change[0].mode_after, NSDAE_MODE_STICK);
    assert_near(r.change[0].time, 2 * slip / (7 * p->mu * p->g), 1e-9);
    assert_near(r.v[0], (5 * p->vx + 2 * p->r * p->wy) / 7, 1e-8);
    assert_near(r.v[1], (5 * p->vy - 2 * p->r * p->wx) / 7, 1e-8);
    assert_at_most((double)r.stats.events, 2);
  }
}

/* The same at any tolerance, and from any state of the way: what slides slowly and is braked stops,
 * however large the errors of the integration are beside its speed. */
static void test_ball_rolls_whatever_rtol(void **state)
{
  (void)state;
  rolling_ball *p = defaults(&rolling_ball_model);
  const double frictional_joint = hypot(p->vx - p->r * p->wy, p->vy + p->r * p->wx);
  const double rtols[] = {1e-3, 1e-4, 1e-5, 1e-6};
  for (int i = 0; i < 4; i++)
    for (int part = 0; part < 25; part++) {
      nsdae_sim_options options = options_of(rtols[i]);
      double left = pow(0.75, part); /* of the slip, less that of the rolling it ends in */
      rolling_ball from = *p;
      from.vx = (5 * p->vx + 2 * p->r * p->wy) / 7 + 2 * left * (p->vx - p->r * p->wy) / 7;
      from.vy = (5 * p->vy - 2 * p->r * p->wx) / 7 + 2 * left * (p->vy + p->r * p->wx) / 7;
      from.wy = ((5 * p->vx + 2 * p->r * p->wy) / 7 - 5 * left * (p->vx - p->r * p->wy) / 7) / p->r;
      from.wx =
          -((5 * p->vy - 2 * p->r * p->wx) / 7 - 5 * left * (p->vy + p->r * p->wx) / 7) / p->r;
      const rolling_ball kept = *p;
      *p = from;
      integrate_model(&rolling_ball_model, &options, 0.8);
      *p = kept;
      double slip = hypot(r.v[0] - p->r * r.v[4], r.v[1] + p->r * r.v[3]);
      assert_at_most(slip, 1e-3 * frictional_joint);
      assert_near(r.v[0], (5 * p->vx + 2 * p->r * p->wy) / 7, 100 * rtols[i] * frictional_joint);
    }
}

int main(void)
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(test_block_stops),
      cmocka_unit_test(test_block_slides),
      cmocka_unit_test(test_less_friction),
      cmocka_unit_test(test_ball_rolls),
      cmocka_unit_test(test_ball_rolls_whatever_rtol),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
