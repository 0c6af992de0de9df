/* What every method keeps to, whatever it is: run on each one that is built, on each example. */
#include "check.h"

#include <stdlib.h>

#include "clearance_hinge.h"
#include "crank_slider.h"
#include "incline.h"
#include "newtons_cradle.h"
#include "pendulum.h"

enum { STEPS = 200, NQ = 8, K = 8, F = 2 };

static const driver_model *const models[] = {&pendulum_model, &clearance_hinge_model,
                                             &crank_slider_model, &newtons_cradle_model,
                                             &incline_model};
enum { MODELS = sizeof models / sizeof *models };

/* The parts of a record that are compared. */
typedef struct point {
  double time, q[NQ], v[NQ], normal[K], dissipated;
} point;

/* A run that is being watched. */
typedef struct watch {
  nsdae_dims dims;
  int stop_at, fail_at; /* steps at which the observer says so, < 0: never */
  long records, impacts;
  point at[STEPS + 1];
  double mu[K];
  double overlap; /* how far the friction of a step may leave the cone, relative */
} watch;

static void expect_finite(const double *a, int n)
{
  for (int i = 0; i < n; i++) assert_true(isfinite(a[i]));
}

/* Signorini and Coulomb of every contact: lambda >= 0 and |lambda_T| <= mu lambda_N. */
static void expect_laws(const watch *w, const nsdae_record *r)
{
  int nt = w->dims.nt;
  for (int i = 0; i < w->dims.k; i++) {
    const double *t = r->tangential_impulse + i * nt;
    double friction = nt == 0 ? 0 : nt == 1 ? fabs(t[0]) : hypot(t[0], t[1]);
    assert_true(r->normal_impulse[i] >= 0);
    assert_at_most(friction, w->mu[i] * r->normal_impulse[i] * (1 + w->overlap) + 1e-14);
    assert_in_range(r->mode[i], NSDAE_MODE_OPEN, NSDAE_MODE_STICK);
  }
  for (int j = 0; j < w->dims.f; j++)
    assert_in_range(r->frictional_joint_mode[j], NSDAE_MODE_OPEN, NSDAE_MODE_STICK);
}

/* The arrays by contact are those of the contacts, each with its number as id. */
static void expect_contacts(const watch *w, const nsdae_record *r)
{
  const nsdae_contact_set *c = &r->contacts;
  assert_int_equal(c->count, w->dims.k);
  assert_true(c->gap == r->gap && c->mode == r->mode && c->normal_impulse == r->normal_impulse &&
              c->tangential_impulse == r->tangential_impulse);
  for (int i = 0; i < c->count; i++) {
    assert_int_equal(c->id[i], i);
    assert_true(c->block[2 * i] == -1 && c->block[2 * i + 1] == -1);
  }
  for (int i = 0; i < r->changes; i++) {
    assert_int_equal(r->change[i].id, r->change[i].contact);
    assert_true(r->change[i].block[0] == -1 && r->change[i].block[1] == -1);
  }
}

static void expect_certificate(const watch *w, const nsdae_record *r)
{
  const double certificate[] = {r->kinetic,      r->potential,        r->dissipated,
                                r->lcp_residual, r->constraint_drift, r->penetration};
  expect_finite(certificate, 6);
  assert_true(r->kinetic >= 0 && r->constraint_drift >= 0 && r->penetration >= 0);
  assert_true(r->contact_tol == 0 || r->contact_tol == 1e-10);
  assert_at_most(r->lcp_residual, r->contact_tol);
  expect_finite(r->multiplier, w->dims.m);
  expect_finite(r->gap, w->dims.k);
}

/* An impact at the very start belongs to the first step; that of a continuous contact (peak_force)
 * is recorded where it ends, with the time at which it began. */
static void expect_impacts(const watch *w, const nsdae_record *r)
{
  double before = w->records > 0 ? w->at[w->records - 1].time : r->time;
  for (int i = 0; i < r->impacts; i++) {
    assert_in_range(r->impact[i].contact, 0, w->dims.k - 1);
    assert_int_equal(r->impact[i].id, r->impact[i].contact);
    assert_true(r->impact[i].block[0] == -1 && r->impact[i].block[1] == -1);
    assert_true(r->impact[i].normal_impulse >= 0);
    assert_at_most(r->impact[i].velocity_before, 1e-9); /* zero: pushed by another impact */
    assert_true(r->impact[i].time >= before || r->impact[i].peak_force > 0);
    assert_true(r->impact[i].time <= r->time);
  }
}

static int observe(const nsdae_record *r, nsdae_error *error, void *user)
{
  watch *w = user;
  (void)error;
  assert_in_range(w->records, 0, STEPS);
  assert_int_equal(r->step, w->records);
  expect_finite(r->q, w->dims.nq);
  expect_finite(r->v, w->dims.nv);
  expect_laws(w, r);
  expect_contacts(w, r);
  expect_certificate(w, r);
  expect_impacts(w, r);
  if (r->step == w->fail_at) { /* once: it is shown this step again */
    w->fail_at = -1;
    return NSDAE_E_IO;
  }
  point *p = &w->at[w->records++];
  *p = (point){.time = r->time, .dissipated = r->dissipated};
  memcpy(p->q, r->q, (size_t)w->dims.nq * sizeof *p->q);
  memcpy(p->v, r->v, (size_t)w->dims.nv * sizeof *p->v);
  for (int i = 0; i < w->dims.k; i++) p->normal[i] = r->normal_impulse[i];
  w->impacts += r->impacts;
  return r->step == w->stop_at;
}

/* One method on one model. */
typedef struct bench {
  nsdae_system *system;
  nsdae_sim *sim;
  int method;
  double q0[NQ], v0[NQ], dt;
  watch watch;
} bench;

static const double *mu_of(const driver_model *model)
{
  static const double none = 0;
  if (model == &clearance_hinge_model) return &((clearance_hinge *)model->base)->mu;
  return model == &incline_model ? &((incline *)model->base)->mu : &none;
}

/* Returns 0 where the method is not built. */
static int make(bench *b, int method, const driver_model *model)
{
  nsdae_sim_options options;
  *b = (bench){.method = method};
  nsdae_params_default(model->parameters, model->base);
  assert_int_equal(model->build(model->base, &b->system, NULL), NSDAE_OK);
  nsdae_system_get_dims(b->system, &b->watch.dims);
  model->start(model->base, b->q0, b->v0);
  nsdae_sim_options_default(&options);
  options.method = method;
  options.penalty_law = NSDAE_PENALTY_KELVIN_VOIGT; /* gives the restitution asked, up to 0.14 */
  b->dt = options.dt = model->dt > 0 ? model->dt : options.dt;
  for (int i = 0; i < K; i++) b->watch.mu[i] = *mu_of(model);
  int status = nsdae_sim_create(b->system, &options, &b->sim, NULL);
  if (status == NSDAE_E_UNSUPPORTED) nsdae_system_destroy(&b->system);
  if (status == NSDAE_E_UNSUPPORTED) return 0;
  assert_int_equal(status, NSDAE_OK);
  assert_int_equal(nsdae_sim_observe(b->sim, observe, &b->watch), NSDAE_OK);
  return 1;
}

static void drop(bench *b)
{
  nsdae_sim_destroy(&b->sim);
  nsdae_system_destroy(&b->system);
}

static void start(bench *b)
{
  b->watch.records = b->watch.impacts = 0;
  b->watch.stop_at = b->watch.fail_at = -1;
  assert_int_equal(nsdae_sim_init(b->sim, 0, b->q0, b->v0), NSDAE_OK);
}

/* Calls the function on every method that is built with every model. */
static void each(void (*f)(bench *b))
{
  for (int method = 0; nsdae_method_name(method); method++)
    for (int i = 0; i < MODELS; i++) {
      bench *b = malloc(sizeof *b);
      assert_non_null(b);
      if (make(b, method, models[i])) {
        f(b);
        drop(b);
      }
      free(b);
    }
}

static void expect_same(const bench *b, const point *before)
{
  assert_int_equal(b->watch.records, STEPS + 1);
  assert_memory_equal(before, b->watch.at, sizeof b->watch.at);
}

/* The grid is t0 + i dt, not a sum; the last step ends at t_end; every record keeps to the laws. */
static void grid(bench *b)
{
  nsdae_stats stats;
  double t_end = (double)STEPS * b->dt;
  start(b);
  assert_int_equal(nsdae_sim_run(b->sim, t_end), NSDAE_OK);
  assert_int_equal(b->watch.records, STEPS + 1);
  for (int i = 0; i <= STEPS; i++) assert_near(b->watch.at[i].time, i * b->dt, 2 * t_end * 1.2e-16);
  assert_true(b->watch.at[STEPS].time == t_end);
  nsdae_sim_get_stats(b->sim, &stats);
  assert_int_equal(stats.steps, STEPS);
  assert_int_equal(stats.smooth_steps + stats.contact_steps, STEPS);
  assert_int_equal(stats.impacts, b->watch.impacts);
  assert_int_equal(nsdae_sim_run(b->sim, t_end), NSDAE_OK); /* nothing to do */
  assert_int_equal(b->watch.records, STEPS + 1);
}

static void test_grid(void **state)
{
  (void)state;
  each(grid);
}

/* The same bytes again: from the same simulation, step by step, and in two runs. */
static void again(bench *b)
{
  static point first[STEPS + 1];
  double t_end = (double)STEPS * b->dt;
  start(b);
  assert_int_equal(nsdae_sim_run(b->sim, t_end), NSDAE_OK);
  memcpy(first, b->watch.at, sizeof first);
  start(b);
  assert_int_equal(nsdae_sim_run(b->sim, t_end), NSDAE_OK);
  expect_same(b, first);
  start(b);
  for (int i = 0; i < STEPS - 1; i++) assert_true(nsdae_sim_step(b->sim) >= 0);
  assert_int_equal(nsdae_sim_run(b->sim, t_end), NSDAE_OK);
  expect_same(b, first);
  start(b);
  assert_int_equal(nsdae_sim_run(b->sim, first[STEPS / 3].time), NSDAE_OK);
  assert_int_equal(nsdae_sim_run(b->sim, t_end), NSDAE_OK);
  expect_same(b, first);
}

static void test_again(void **state)
{
  (void)state;
  each(again);
}

/* An observer that stops or fails a run does not disturb it: it goes on from there. */
static void observer(bench *b)
{
  static point first[STEPS + 1];
  double t_end = (double)STEPS * b->dt;
  start(b);
  assert_int_equal(nsdae_sim_run(b->sim, t_end), NSDAE_OK);
  memcpy(first, b->watch.at, sizeof first);
  start(b);
  b->watch.stop_at = 57;
  b->watch.fail_at = 91;
  assert_int_equal(nsdae_sim_run(b->sim, t_end), NSDAE_STOPPED);
  assert_int_equal(b->watch.records, 58);
  assert_int_equal(nsdae_sim_run(b->sim, t_end), NSDAE_E_IO);
  assert_int_equal(b->watch.records, 91);
  nsdae_record record;
  assert_int_equal(nsdae_sim_get_record(b->sim, &record), NSDAE_OK);
  assert_int_equal(record.step, 90); /* the state is the one before */
  assert_int_equal(nsdae_sim_run(b->sim, t_end), NSDAE_OK);
  expect_same(b, first);
}

static void test_observer(void **state)
{
  (void)state;
  each(observer);
}

int main(void)
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(test_grid),
      cmocka_unit_test(test_again),
      cmocka_unit_test(test_observer),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
