/* The event-driven method on the examples: impacts, accumulations and modes against closed forms
 * and published numbers. */
#include "check.h"

#include "bouncing_ball.h"
#include "bricard.h"
#include "falling_rod.h"
#include "long_pendulum.h"
#include "newtons_cradle.h"
#include "woodpecker.h"

enum { KEPT = 400, NQ = BRICARD_NQ };

/* What a run leaves. */
typedef struct run {
  int status, impacts;
  nsdae_impact impact[KEPT];
  double q[NQ], v[NQ], worst_energy, start_energy;
  nsdae_stats stats;
  nsdae_error error;
} run;

static run r; /* of the last run; large */

static int observe(const nsdae_record *record, nsdae_error *error, void *user)
{
  const nsdae_dims *dims = user;
  double energy = record->kinetic + record->potential;
  (void)error;
  for (int i = 0; i < record->impacts && r.impacts < KEPT; i++)
    r.impact[r.impacts++] = record->impact[i];
  memcpy(r.q, record->q, (size_t)dims->nq * sizeof *r.q);
  memcpy(r.v, record->v, (size_t)dims->nv * sizeof *r.v);
  if (record->step == 0) r.start_energy = energy;
  r.worst_energy = fmax(r.worst_energy, fabs(energy - r.start_energy));
  return 0;
}

static nsdae_sim_options options_of(double rtol, double dt)
{
  nsdae_sim_options options;
  nsdae_sim_options_default(&options);
  options.method = NSDAE_METHOD_EVENT;
  options.rtol = rtol;
  options.atol = rtol / 10;
  options.dt = dt;
  options.redundant = NSDAE_REDUNDANT_LEAST_NORM;
  return options;
}

/* Runs to t_end and releases the system; what came of it is in r. */
static void integrate(nsdae_system *system, const nsdae_sim_options *options, const double *q0,
                      const double *v0, double t_end)
{
  nsdae_sim *sim;
  nsdae_dims dims;
  r = (run){0};
  assert_int_equal(nsdae_system_get_dims(system, &dims), NSDAE_OK);
  assert_int_equal(nsdae_sim_create(system, options, &sim, NULL), NSDAE_OK);
  r.status = nsdae_sim_init(sim, 0, q0, v0);
  nsdae_sim_observe(sim, observe, &dims);
  if (r.status == NSDAE_OK) r.status = nsdae_sim_run(sim, t_end);
  r.error = *nsdae_sim_error(sim);
  nsdae_sim_get_stats(sim, &r.stats);
  nsdae_sim_destroy(&sim);
  nsdae_system_destroy(&system);
}

/* The model as its parameters are now. */
static void integrate_model(const driver_model *model, double rtol, double dt, double t_end)
{
  nsdae_system *system;
  nsdae_sim_options options = options_of(rtol, dt);
  double q0[NQ] = {0}, v0[NQ] = {0};
  assert_int_equal(model->build(model->base, &system, NULL), NSDAE_OK);
  model->start(model->base, q0, v0);
  integrate(system, &options, q0, v0, t_end);
}

static void *defaults(const driver_model *model)
{
  nsdae_params_default(model->parameters, model->base);
  return model->base;
}

static void expect_done(void)
{
  if (r.status < 0) print_message("%s\n", r.error.text);
  assert_int_equal(r.status, NSDAE_OK);
}

/* What is asked of every time and impulse at rtol 1e-11, relative. */
static const double accuracy = 1e-9;

/* 44 impacts at 8.5 s, each against the closed form. */
static void test_ball(void **state)
{
  (void)state;
  const bouncing_ball *p = defaults(&bouncing_ball_model);
  double y, v, worst_time = 0, worst_impulse = 0;
  bouncing_ball_exact(p, 8.5, &y, &v, NULL);
  integrate_model(&bouncing_ball_model, 1e-11, 0.005, 8.5);
  expect_done();
  assert_int_equal(r.impacts, 44);
  for (int i = 0; i < r.impacts; i++) {
    driver_exact exact;
    bouncing_ball_model.exact(p, i, &exact);
    worst_time = fmax(worst_time, fabs(r.impact[i].time / exact.time - 1));
    worst_impulse =
        fmax(worst_impulse, fabs(r.impact[i].normal_impulse / exact.normal_impulse - 1));
  }
  print_message(
      "times to %.1e, impulses to %.1e; at 8.5 s height to %.1e m, velocity to %.1e m/s\n",
      worst_time, worst_impulse, fabs(r.q[0] - y), fabs(r.v[0] - v));
  assert_at_most(worst_time, accuracy);
  assert_at_most(worst_impulse, accuracy);
  assert_near(v, -4.166519581e-2, 1e-11);
  /* an impact that is off by t moves the velocity by (1 + e) g t, the height by v t */
  assert_near(r.v[0], v, (1 + p->ball.e_N) * p->ball.g * accuracy);
  assert_near(r.q[0], y, 0.1 * accuracy);
}

/* The accumulation is one record at the time of rest; then the ball lies still. */
static void test_ball_at_rest(void **state)
{
  (void)state;
  const bouncing_ball *p = defaults(&bouncing_ball_model);
  integrate_model(&bouncing_ball_model, 1e-11, 0.005, 10);
  expect_done();
  const nsdae_impact *last = &r.impact[r.impacts - 1];
  print_message("%d impacts, rest off by %.1e s\n", r.impacts, last->time - bouncing_ball_rest(p));
  assert_true(r.impacts < KEPT);
  assert_int_equal(r.stats.accumulations, 1);
  assert_int_equal(last->accumulation, 1);
  assert_near(last->time, 8.578949178728887, 1e-8);
  assert_near(r.q[0], 0, 1e-12); /* atol */
  assert_near(r.v[0], 0, 1e-12);
}

/* Balls that touch: one simultaneous impact at the start and, with rounding between them, one after
 * every half swing. */
static void test_cradle(void **state)
{
  (void)state;
  newtons_cradle *p = defaults(&newtons_cradle_model);
  const double e[] = {0, 0.5, 1}, half = 3.14159265358979324 * sqrt(p->L / p->g);
  double worst = 0;
  for (p->n = 2; p->n <= 5; p->n++)
    for (int j = 0; j < 3; j++)
      for (int impact = 0; impact < 4; impact++) {
        double v[NEWTONS_CRADLE_MAX];
        p->e_N = e[j];
        integrate_model(&newtons_cradle_model, 1e-11, 0.005, (impact + 1e-6) * half);
        expect_done();
        newtons_cradle_exact(p, impact, v);
        /* swinging for 1e-6 of half a swing turns the velocities by 5e-12 */
        for (int i = 0; i < p->n; i++) worst = fmax(worst, fabs(r.v[i] - v[i]));
        /* all that touch are in the record, but for an impact of balls that go on together */
        assert_int_equal(r.impacts, (p->e_N > 0 ? impact + 1 : 1) * (p->n - 1));
      }
  print_message("worst velocity error %.1e of 1 m/s\n", worst);
  /* four impacts, each of up to four balls that touch to the integrator's accuracy only */
  assert_at_most(worst, 10 * accuracy);
}

/* With a gap the same balls hand the velocity on, and the last one flies off alone. */
static void test_chain(void **state)
{
  (void)state;
  newtons_cradle *p = defaults(&newtons_cradle_model);
  p->gap = 1e-4;
  p->g = 0;
  integrate_model(&newtons_cradle_model, 1e-11, 0.005, 0.1);
  expect_done();
  assert_int_equal(r.impacts, 4);
  for (int i = 0; i < 4; i++) {
    assert_int_equal(r.impact[i].contact, i);
    assert_near(r.impact[i].time, (i + 1) * p->gap / p->v0, accuracy);
    assert_near(r.impact[i].normal_impulse, p->m * p->v0, accuracy);
  }
  for (int i = 0; i < 5; i++) assert_near(r.v[i], i == 4 ? p->v0 : 0, accuracy);
}

/* The published period and multiplier: the periods of successive pecks of the beak come to the
 * limit like (-0.84)^n. */
static void test_woodpecker(void **state)
{
  (void)state;
  double period[2];
  defaults(&woodpecker_model);
  for (int i = 0; i < 2; i++) {
    double peck[64];
    int n = 0;
    integrate_model(&woodpecker_model, i == 0 ? 1e-8 : 1e-11, 0.005, 6);
    expect_done();
    for (int j = 0; j < r.impacts; j++)
      if (r.impact[j].contact == WOODPECKER_BEAK && n < 64) peck[n++] = r.impact[j].time;
    assert_int_equal(n, 41);
    assert_int_equal(r.stats.fallback_steps, 0);
    period[i] = (peck[40] - peck[20]) / 20;
    double first = peck[9] - 2 * peck[8] + peck[7], next = peck[10] - 2 * peck[9] + peck[8];
    print_message("period %.9f s, multiplier %.4f\n", period[i], next / first);
    assert_near(period[i], 0.145976, 0.5e-6);
    assert_near(next / first, -0.84, 0.5e-2);
  }
  assert_near(period[0], period[1], 1e-8);
}

/* A rod that slides from the angle, in degrees, for a microsecond. */
static int frictional_joint(falling_rod *p, double mu, double angle)
{
  p->mu = mu;
  p->p0 = angle * 3.14159265358979324 / 180;
  integrate_model(&falling_rod_model, 1e-10, 1e-6, 1e-6);
  return r.status;
}

/* Painleve: the friction from which on there is a paradox, its angles, and what is said of no
 * solution and of two. */
static void test_painleve(void **state)
{
  (void)state;
  falling_rod *p = defaults(&falling_rod_model);
  const double critical = 63.4349488;
  assert_int_equal(frictional_joint(p, 1.333, critical), NSDAE_OK);
  assert_int_equal(frictional_joint(p, 1.334, critical), NSDAE_E_PAINLEVE);
  assert_int_equal(frictional_joint(p, 5.0 / 3, 44.999), NSDAE_OK);
  assert_int_equal(frictional_joint(p, 5.0 / 3, 45.001), NSDAE_E_PAINLEVE);
  assert_int_equal(frictional_joint(p, 5.0 / 3, 75.963), NSDAE_E_PAINLEVE);
  assert_int_equal(frictional_joint(p, 5.0 / 3, 75.965), NSDAE_OK);
  assert_int_equal(frictional_joint(p, 5.0 / 3, 60), NSDAE_E_PAINLEVE);
  assert_int_equal(r.error.index, 0);
  assert_true(r.error.time == 0);
  assert_non_null(strstr(r.error.text, "contact 0 \"first_end\" has no "));
  p->omega = 5;
  assert_true(falling_rod_free(p, p->p0, p->omega) > 0);
  assert_int_equal(frictional_joint(p, 5.0 / 3, 60), NSDAE_E_PAINLEVE);
  assert_non_null(strstr(r.error.text, "contact 0 \"first_end\" has two "));
  p->omega = 0;
  p->v_T = 1; /* the other way friction takes from the normal force */
  assert_int_equal(frictional_joint(p, 5.0 / 3, 60), NSDAE_OK);
}

/* Without friction from rest it arrives flat with omega^2 = 2 m g l sin p0 / (J + m l^2); both ends
 * take part, Lambda = (m l -+ J / l) |omega| / 2. */
static void test_rod(void **state)
{
  (void)state;
  falling_rod *p = defaults(&falling_rod_model);
  p->mu = 0;
  double omega = sqrt(2 * p->m * p->g * p->l * sin(p->p0) / (p->J + p->m * p->l * p->l));
  integrate_model(&falling_rod_model, 1e-11, 0.005, 1);
  expect_done();
  assert_int_equal(r.impacts, 2);
  for (int i = 0; i < 2; i++) {
    double side = i == 0 ? -1 : 1, exact = (p->m * p->l + side * p->J / p->l) * omega / 2;
    assert_int_equal(r.impact[i].contact, i);
    assert_near(r.impact[i].normal_impulse, exact, 10 * accuracy);
  }
  for (int i = 1; i < 3; i++) {
    assert_near(r.q[i], 0, accuracy);
    assert_near(r.v[i], 0, accuracy);
  }
  p->h = 0.5;
  p->e_N = 0.5;
  integrate_model(&falling_rod_model, 1e-11, 0.005, 0.4);
  expect_done();
  double a = falling_rod_coefficient(p, p->p0, 1), fall = sqrt(2 * p->h / p->g);
  assert_near(r.impact[0].time, fall, accuracy);
  assert_near(r.impact[0].normal_impulse, (1 + p->e_N) * p->g * fall / a, 10 * accuracy);
}

static void test_pendulum(void **state)
{
  (void)state;
  long_pendulum p;
  double q0[2], v0[2];
  nsdae_sim_options options = options_of(1e-11, 0.01);
  long_pendulum_default(&p);
  long_pendulum_start(&p, q0, v0);
  integrate(long_pendulum_system(&p), &options, q0, v0, 10);
  expect_done();
  print_message("y(10) off by %.1e m, drift %.1e m\n", r.q[1] + 0.961419205099,
                r.stats.worst_drift);
  assert_near(r.q[1], -0.961419205099, 1e-8);
  assert_at_most(r.stats.worst_drift, accuracy);
}

/* Ten seconds: energy, rank, and the geometry of the linkage (see iftomm.c). */
static void test_bricard(void **state)
{
  (void)state;
  bricard p;
  double q0[NQ], v0[NQ], c[6];
  nsdae_sim_options options = options_of(1e-11, 0.01);
  bricard_default(&p);
  bricard_start(&p, q0, v0);
  integrate(bricard_system(&p), &options, q0, v0, 10);
  expect_done();
  for (int i = 0; i < 6; i++) c[i] = bricard_cosine(&p, r.q, i);
  print_message("rank %d, energy to %.1e J, drift %.1e, closure %.1e\n", r.stats.rank,
                r.worst_energy, r.stats.worst_drift, c[0] + c[1] + c[0] * c[1]);
  assert_int_equal(r.stats.rank, BRICARD_RANK);
  assert_at_most(r.worst_energy, 1e-8 * p.m * p.g * p.L);
  assert_at_most(r.stats.worst_drift, accuracy);
  for (int i = 0; i < 4; i++) assert_near(c[i], c[i + 2], accuracy);
  assert_near(c[0] + c[1] + c[0] * c[1], 0, accuracy);
}

int main(void)
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(test_ball),       cmocka_unit_test(test_ball_at_rest),
      cmocka_unit_test(test_cradle),     cmocka_unit_test(test_chain),
      cmocka_unit_test(test_woodpecker), cmocka_unit_test(test_painleve),
      cmocka_unit_test(test_rod),        cmocka_unit_test(test_pendulum),
      cmocka_unit_test(test_bricard),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
