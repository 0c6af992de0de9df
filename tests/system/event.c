/* The event-driven method on the three systems of Zhang, Gu and Sun against exact solutions and an
 * independent event-driven reference, and what it does with impacts that come ever faster. */
#include "check.h"

#include <gsl/gsl_sf_ellint.h>
#include <stdlib.h>

#include "clearance_hinge.h"
#include "crank_slider.h"
#include "pendulum.h"

enum { KEPT = 512, NQ = 3 };

/* What a run leaves. */
typedef struct run {
  int status, impacts, changes;
  nsdae_impact impact[KEPT];
  nsdae_change change[KEPT];
  double q[NQ], worst_gain, energy; /* largest energy above the start's; the start's */
  nsdae_stats stats;
} run;

static run r;
static nsdae_dims dims;

static int observe(const nsdae_record *record, nsdae_error *error, void *user)
{
  double energy = record->kinetic + record->potential;
  (void)error;
  (void)user;
  if (record->step == 0) r.energy = energy;
  r.worst_gain = fmax(r.worst_gain, energy - r.energy);
  for (int i = 0; i < record->impacts && r.impacts < KEPT; i++)
    r.impact[r.impacts++] = record->impact[i];
  for (int i = 0; i < record->changes && r.changes < KEPT; i++)
    r.change[r.changes++] = record->change[i];
  memcpy(r.q, record->q, (size_t)dims.nq * sizeof *r.q);
  return 0;
}

static nsdae_sim_options options_of(double dt)
{
  nsdae_sim_options options;
  nsdae_sim_options_default(&options);
  options.method = NSDAE_METHOD_EVENT;
  options.rtol = 1e-11;
  options.atol = 1e-13;
  options.dt = dt;
  return options;
}

/* A simulation of the system at its start, observed. */
static nsdae_sim *start(nsdae_system *system, const nsdae_sim_options *options, const double *q0,
                        const double *v0)
{
  nsdae_sim *sim;
  r = (run){0};
  nsdae_system_get_dims(system, &dims);
  assert_int_equal(nsdae_sim_create(system, options, &sim, NULL), NSDAE_OK);
  nsdae_sim_observe(sim, observe, NULL);
  assert_int_equal(nsdae_sim_init(sim, 0, q0, v0), NSDAE_OK);
  return sim;
}

static void finish(nsdae_sim **sim, nsdae_system **system, double t_end)
{
  r.status = nsdae_sim_run(*sim, t_end);
  if (r.status < 0) print_message("%s\n", nsdae_sim_error(*sim)->text);
  nsdae_sim_get_stats(*sim, &r.stats);
  nsdae_sim_destroy(sim);
  nsdae_system_destroy(system);
  /* with the slip of the hinge's angle, which is no velocity of the surfaces, friction drives the
   * shaft into the wall long after the impacts that are compared: said */
  int said = r.status == NSDAE_WARN_PENETRATION && t_end > 2;
  assert_true(r.status == NSDAE_OK || said);
}

/* The model as its parameters are now; the times at which to stop, the last of them t_end. */
static void integrate(const driver_model *model, const nsdae_sim_options *options, double t_end)
{
  nsdae_system *system;
  double q0[NQ] = {0}, v0[NQ] = {0};
  assert_int_equal(model->build(model->base, &system, NULL), NSDAE_OK);
  model->start(model->base, q0, v0);
  nsdae_sim *sim = start(system, options, q0, v0);
  finish(&sim, &system, t_end);
}

static void *defaults(const driver_model *model)
{
  nsdae_params_default(model->parameters, model->base);
  return model->base;
}

/* Rows of numbers of a file in data/, behind a first column of words where there is one. */
static int read_rows(const char *name, const char *word, int columns, double row[][7], int most)
{
  char path[512], line[256];
  int rows = 0;
  snprintf(path, sizeof path, "%s/%s", NSDAE_DATA_DIR, name);
  FILE *file = fopen(path, "r");
  assert_non_null(file);
  while (rows < most && fgets(line, sizeof line, file)) {
    char *at = line, *end;
    int column = 0;
    if (word && strncmp(line, word, strlen(word)) != 0) continue;
    if (word) at += strlen(word) + 1;
    for (; column < columns; column++, at = end + 1) {
      row[rows][column] = strtod(at, &end);
      if (end == at) break;
    }
    rows += column == columns;
  }
  fclose(file);
  assert_true(rows > 0);
  return rows;
}

static double relative(double value, double exact)
{
  return fabs(value / exact - 1);
}

/* All eight impacts of the closed form to 1e-8, the first to 1e-9; with every integrator. */
static void test_pendulum(void **state)
{
  (void)state;
  double row[16][7];
  int rows = read_rows("pendulum_impacts.csv", NULL, 6, row, 16);
  for (int integrator = NSDAE_INTEGRATOR_AUTO; integrator <= NSDAE_INTEGRATOR_IDA; integrator++) {
    nsdae_sim_options options = options_of(0.005);
    options.integrator = integrator;
    defaults(&pendulum_model);
    integrate(&pendulum_model, &options, 7);
    assert_int_equal(r.impacts, rows);
    double worst = 0;
    for (int i = 0; i < rows; i++) {
      double time = relative(r.impact[i].time, row[i][1]);
      double impulse = relative(r.impact[i].normal_impulse, row[i][4]);
      assert_at_most(fmax(time, impulse), i == 0 ? 1e-9 : 1e-8);
      worst = fmax(worst, fmax(time, impulse));
      assert_near(r.impact[i].velocity_after, -0.56 * r.impact[i].velocity_before, 1e-12);
    }
    print_message("pendulum: eight impacts to %.1e\n", worst);
    assert_at_most(r.worst_gain, 1e-8 * 4.9 * 9.8); /* the integrator's error, over m g L */
  }
}

/* Evaluations of the forces over 0.2 s of the pendulum, before its first impact. */
static long evaluations(const nsdae_sim_options *options)
{
  nsdae_system *system;
  nsdae_stats stats;
  double q0[NQ] = {0}, v0[NQ] = {0};
  defaults(&pendulum_model);
  assert_int_equal(pendulum_model.build(pendulum_model.base, &system, NULL), NSDAE_OK);
  pendulum_model.start(pendulum_model.base, q0, v0);
  nsdae_sim *sim = start(system, options, q0, v0);
  assert_true(nsdae_sim_run(sim, 0.2) >= 0); /* the law of penalty has a warning */
  nsdae_sim_get_stats(sim, &stats);
  nsdae_sim_destroy(&sim);
  nsdae_system_destroy(&system);
  return stats.force_evals;
}

/* No step of the integrator is longer than step_max: a time T takes at least T / step_max of them,
 * each with an evaluation or more; without a bound, far less. */
static void test_step_max(void **state)
{
  (void)state;
  const int methods[] = {NSDAE_METHOD_EVENT, NSDAE_METHOD_PENALTY};
  for (int i = 0; i < 2; i++) {
    nsdae_sim_options options = options_of(0.005);
    options.method = methods[i];
    options.rtol = 1e-6;
    options.atol = 1e-8;
    assert_int_equal(nsdae_sim_options_set(&options, "step_max", "1e-5", NULL), NSDAE_OK);
    assert_true(evaluations(&options) >= 20000);
    assert_int_equal(nsdae_sim_options_set(&options, "step_max", "inf", NULL), NSDAE_OK);
    assert_true(evaluations(&options) < 1000);
    assert_int_equal(nsdae_sim_options_set(&options, "step_max", "0", NULL), NSDAE_E_ARGUMENT);
    assert_int_equal(nsdae_sim_options_set(&options, "step_max", "nan", NULL), NSDAE_E_ARGUMENT);
  }
}

/* The first five impacts, all radii, both definitions of the slip; the energy lost is the work of
 * impacts and friction, to 3 s. */
static void test_hinge(void **state)
{
  (void)state;
  const char *word[2] = {"surface_slip", "hinge_angle"};
  clearance_hinge *p = defaults(&clearance_hinge_model);
  double worst = 0;
  for (int slip = 0; slip < 2; slip++) {
    double row[25][7];
    int rows = read_rows("clearance_hinge_impacts.csv", word[slip], 7, row, 25);
    assert_int_equal(rows, 25);
    for (int i = 0; i < rows; i++) {
      int impact = (int)row[i][1] - 1;
      if (impact == 0) {
        nsdae_sim_options options = options_of(0.005);
        p->r = row[i][0];
        p->slip = slip == 0 ? SURFACE_SLIP : HINGE_ANGLE;
        integrate(&clearance_hinge_model, &options, 3);
        assert_at_most(r.worst_gain, 1e-8);
        assert_at_most(r.stats.worst_penetration, 1e-9); /* the shaft stays in its hole */
        /* the friction of 3 s of sliding; rtol over some 1e4 steps of up to 10 J */
        assert_at_most(fabs(r.stats.energy_balance), 1e-6);
      }
      double time = relative(r.impact[impact].time, row[i][2]);
      double normal = relative(r.impact[impact].normal_impulse, row[i][3]);
      double tangential = relative(r.impact[impact].tangential_impulse[0], row[i][4]);
      double most = fmax(time, fmax(normal, tangential));
      assert_at_most(most, 1e-8);
      worst = fmax(worst, most);
    }
  }
  print_message("hinge: fifty impacts to %.1e\n", worst);
}

/* Instants at which the slide begins and ends to stick. */
static void expect_sticks(double mu)
{
  double row[8][7];
  int rows = read_rows("crank_slider_stiction.csv", NULL, 4, row, 8), next = 0;
  for (int i = 0; i < rows; i++) {
    if (row[i][0] != mu) continue;
    double begin = 0, end = 0;
    while (next < r.changes && r.change[next].mode_after != NSDAE_MODE_STICK) next++;
    assert_true(next < r.changes);
    begin = r.change[next].time;
    while (next < r.changes && r.change[next].mode_before != NSDAE_MODE_STICK) next++;
    assert_true(next < r.changes);
    end = r.change[next].time;
    assert_int_equal(r.change[next].frictional_joint, 0);
    assert_int_equal(r.change[next].contact, -1);
    assert_near(begin, row[i][1], 1e-6);
    assert_near(end, row[i][2], 1e-6);
  }
  while (next < r.changes) assert_true(r.change[next++].mode_after != NSDAE_MODE_STICK);
}

/* States at the reference's times to 1e-7, sticks to 1e-6. */
static void test_crank_slider(void **state)
{
  (void)state;
  crank_slider *p = defaults(&crank_slider_model);
  double row[32][7], worst = 0;
  int rows = read_rows("crank_slider_states.csv", NULL, 4, row, 32);
  for (int i = 0; i < rows;) {
    nsdae_system *system;
    nsdae_sim_options options = options_of(0.005);
    nsdae_record record;
    double q0[NQ] = {0}, v0[NQ] = {0}, mu = p->mu = row[i][0];
    assert_int_equal(crank_slider_model.build(p, &system, NULL), NSDAE_OK);
    nsdae_sim *sim = start(system, &options, q0, v0);
    for (; i < rows && row[i][0] == mu; i++) {
      assert_int_equal(nsdae_sim_run(sim, row[i][1]), NSDAE_OK);
      nsdae_sim_get_record(sim, &record);
      assert_near(record.q[0], row[i][2], 1e-7);
      assert_near(record.v[0], row[i][3], 1e-7);
      worst = fmax(worst, fabs(record.q[0] - row[i][2]));
    }
    finish(&sim, &system, 12);
    if (mu > 0) expect_sticks(mu);
  }
  print_message("crank-slider: states to %.1e rad\n", worst);
}

/* A uniform rod of length 1 that gravity presses to a stop: theta'' = -(3 g / 2) sin theta. */
typedef struct rod {
  double g, stop;
} rod;

static int rod_mass(double t, const double *q, double *M, int ldm, void *user)
{
  (void)t;
  (void)q;
  (void)ldm;
  (void)user;
  M[0] = 1.0 / 3;
  return 0;
}

static int rod_force(double t, const double *q, const double *v, double *F, void *user)
{
  const rod *p = user;
  (void)t;
  (void)v;
  F[0] = -p->g / 2 * sin(q[0]);
  return 0;
}

static int rod_gap(double t, const double *q, double *gap, void *user)
{
  const rod *p = user;
  (void)t;
  gap[0] = sin(q[0] - p->stop);
  return 0;
}

static int rod_normal(double t, const double *q, double *W, int ldw, void *user)
{
  const rod *p = user;
  (void)t;
  (void)ldw;
  W[0] = cos(q[0] - p->stop);
  return 0;
}

static nsdae_system *rod_system(rod *p, double e)
{
  nsdae_system *system;
  assert_int_equal(nsdae_system_create(&(nsdae_dims){.nq = 1, .k = 1}, &system, NULL), NSDAE_OK);
  nsdae_system_set_user(system, p);
  nsdae_system_set_mass(system, rod_mass);
  nsdae_system_set_force(system, rod_force);
  nsdae_system_set_gap(system, rod_gap);
  nsdae_system_set_gap_normal(system, rod_normal);
  nsdae_system_set_contact(system, 0, 0, e, 0);
  return system;
}

/* Time from rest at the angle a to the stop, c = 3 g / 2:
 *   [K(k) - F(asin(sin(stop / 2) / k), k)] / sqrt(c),  k = sin(a / 2) */
static double fall(const rod *p, double a)
{
  double k = sin(a / 2), phi = asin(sin(p->stop / 2) / k);
  return (gsl_sf_ellint_Kcomp(k, GSL_PREC_DOUBLE) - gsl_sf_ellint_F(phi, k, GSL_PREC_DOUBLE)) /
         sqrt(1.5 * p->g);
}

/* Time of the impact of that number, from 0. */
static double exact_impact(const rod *p, double e, double a, int number)
{
  double c = 1.5 * p->g, t = fall(p, a), w = sqrt(2 * c * (cos(p->stop) - cos(a)));
  for (int i = 0; i < number; i++) {
    w *= e;
    t += 2 * fall(p, acos(cos(p->stop) - w * w / (2 * c)));
  }
  return t;
}

/* Where they all end: from the 16th on, 1e-5 s apart, the intervals fall by e but for a part of
 * 1e-5 of it. */
static double exact_rest(const rod *p, double e, double a)
{
  double before = exact_impact(p, e, a, 15), t = exact_impact(p, e, a, 16);
  return t + (t - before) * e / (1 - e);
}

/* From 90 to 30 degrees with e 0.5: impacts as the closed form has them, then rest at the end of
 * their accumulation; the step that holds it says so. */
static void test_accumulation(void **state)
{
  (void)state;
  const double pi = acos(-1), q0 = pi / 2, v0 = 0;
  rod p = {.g = 9.81, .stop = pi / 6};
  nsdae_system *system = rod_system(&p, 0.5);
  nsdae_sim_options options = options_of(0.01);
  nsdae_sim *sim = start(system, &options, &q0, &v0);
  int status = NSDAE_OK, ended = 0;
  for (int step = 0; step < 160 && status >= 0; step++) {
    status = nsdae_sim_step(sim);
    ended += status == NSDAE_ZENO;
  }
  assert_int_equal(ended, 1);
  finish(&sim, &system, 3);
  for (int i = 0; i < 10; i++)
    assert_near(r.impact[i].time, exact_impact(&p, 0.5, pi / 2, i), 1e-8);
  const nsdae_impact *last = &r.impact[r.impacts - 1];
  assert_int_equal(last->accumulation, 1);
  assert_near(last->time, exact_rest(&p, 0.5, pi / 2), 1e-8);
  assert_int_equal(r.stats.accumulations, 1);
  assert_near(r.q[0], pi / 6, 1e-12); /* rests on the stop */
  print_message("rod on its stop: %d impacts, the last at %.10f s\n", r.impacts, last->time);
}

static int ball_mass(double t, const double *q, double *M, int ldm, void *user)
{
  (void)t;
  (void)q;
  (void)ldm;
  (void)user;
  M[0] = 1;
  return 0;
}

static int no_force(double t, const double *q, const double *v, double *F, void *user)
{
  (void)t;
  (void)q;
  (void)v;
  (void)F;
  (void)user;
  return 0;
}

static int walls(double t, const double *q, double *gap, void *user)
{
  const double *width = user;
  (void)t;
  gap[0] = q[0];
  gap[1] = *width - q[0];
  return 0;
}

/* A ball between two walls that gives no energy away: a hundred impacts in every dt, and no end of
 * them. It keeps its speed, and the steps that were stepped over are told. */
static void test_chattering(void **state)
{
  (void)state;
  double width = 1e-3, q0 = 3e-4, v0 = 10;
  for (int most = 20; most <= 2000; most *= 100) {
    nsdae_system *system;
    nsdae_sim_options options = options_of(0.01);
    options.rtol = 1e-8;
    options.atol = 1e-10;
    options.events_max = most;
    assert_int_equal(nsdae_system_create(&(nsdae_dims){.nq = 1, .k = 2}, &system, NULL), NSDAE_OK);
    nsdae_system_set_user(system, &width);
    nsdae_system_set_mass(system, ball_mass);
    nsdae_system_set_force(system, no_force);
    nsdae_system_set_gap(system, walls);
    nsdae_system_set_contact(system, 0, 0, 1, 0);
    nsdae_system_set_contact(system, 1, 0, 1, 0);
    nsdae_sim *sim = start(system, &options, &q0, &v0);
    nsdae_record record;
    /* a step by implicit is reported with its depth */
    assert_int_equal(nsdae_sim_run(sim, 0.1), most == 20 ? NSDAE_WARN_PENETRATION : NSDAE_OK);
    nsdae_sim_get_record(sim, &record);
    assert_near(fabs(record.v[0]), 10, 1e-10);
    finish(&sim, &system, 0.2);
    assert_int_equal(r.stats.accumulations, 0);
    if (most == 20) {
      assert_true(r.stats.fallback_steps > 0);
      assert_at_most(r.worst_gain, 1e-10);
    } else {
      assert_int_equal(r.stats.fallback_steps, 0);
      /* distance 10 * 0.2 from 3e-4, a wall every 1e-3 */
      assert_int_equal(r.stats.impacts, 2000);
    }
  }
}

int main(void)
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(test_pendulum),     cmocka_unit_test(test_step_max),
      cmocka_unit_test(test_hinge),        cmocka_unit_test(test_crank_slider),
      cmocka_unit_test(test_accumulation), cmocka_unit_test(test_chattering),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
