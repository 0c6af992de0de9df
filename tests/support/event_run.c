#include "event_run.h"

#include "check.h"

#include <stdlib.h>

#include "as_list.h"

void event_run_default(event_run *run)
{
  *run = (event_run){.t_end = 1};
  nsdae_sim_options_default(&run->options);
  run->options.method = NSDAE_METHOD_EVENT;
  run->options.dt = 0.01;
  run->options.rtol = 1e-10;
  run->options.atol = 1e-12;
}

static void check_record(const event_run *run, const nsdae_record *record)
{
  const nsdae_sim_options *o = &run->options;
  double size = 1;
  for (int i = 0; i < run->dims.nq; i++) size = fmax(size, fabs(record->q[i]));
  assert_at_most(record->lcp_residual, o->contact_tol > 0 ? o->contact_tol : 1e-10);
  /* the integrator's error of one phase: a few hundred steps, each with a weight of rtol */
  assert_at_most(record->penetration, 1e3 * (o->rtol * size + o->atol));
  assert_at_most(record->constraint_drift, 1e3 * (o->rtol * size + o->atol));
  for (int i = 0; i < run->dims.nq; i++) assert_true(isfinite(record->q[i]));
  for (int i = 0; i < run->dims.nv; i++) assert_true(isfinite(record->v[i]));
  assert_true(isfinite(record->dissipated));
  if (record->step > 0) assert_true(record->time > run->t);
}

static void keep_events(event_run *run, const nsdae_record *record)
{
  double least = run->t - 1e-12, most = record->time + run->options.accumulation_time;
  for (int i = 0; i < record->impacts; i++) {
    const nsdae_impact *impact = &record->impact[i];
    assert_true(impact->time >= least && impact->time <= most);
    assert_true(impact->normal_impulse > 0);
    if (run->impacts >= EVENT_RUN_KEPT) continue;
    run->impact[run->impacts] = *impact;
    run->impact[run->impacts++].contact = (int)impact->id;
  }
  for (int i = 0; i < record->changes; i++) {
    const nsdae_change *change = &record->change[i];
    assert_true(change->time >= least && change->time <= most);
    assert_true(change->mode_before != change->mode_after);
    if (run->changes >= EVENT_RUN_KEPT) continue;
    run->change[run->changes] = *change;
    run->change[run->changes++].contact = (int)change->id;
  }
}

/* What contacts did, by their ids, which are their numbers. */
static void keep_contacts(event_run *run, const nsdae_record *record)
{
  const nsdae_contact_set *c = &record->contacts;
  int nt = run->dims.nt;
  memset(run->mode, 0, sizeof run->mode);
  for (int a = 0; a < c->count; a++) {
    int i = (int)c->id[a];
    run->normal[i] += c->normal_impulse[a];
    for (int l = 0; l < nt; l++) run->tangential[i * nt + l] += c->tangential_impulse[a * nt + l];
    run->mode[i] = c->mode[a];
  }
}

static int keep(const nsdae_record *record, nsdae_error *error, void *user)
{
  event_run *run = user;
  const nsdae_dims *d = &run->dims;
  double h = record->time - run->t;
  check_record(run, record);
  if (record->step > 0) keep_events(run, record);
  keep_contacts(run, record);
  for (int i = 0; i < d->m; i++) run->multiplier[i] += h * record->multiplier[i];
  memcpy(run->q, record->q, (size_t)d->nq * sizeof *run->q);
  memcpy(run->v, record->v, (size_t)d->nv * sizeof *run->v);
  run->t = record->time;
  run->records++;
  return run->look ? run->look(record, error, run->user) : 0;
}

static void clear(event_run *run)
{
  event_run fresh = {.options = run->options,
                     .t0 = run->t0,
                     .t_end = run->t_end,
                     .look = run->look,
                     .user = run->user};
  *run = fresh;
}

int event_run_by_list(void)
{
  return getenv("EVENT_RUN_BY_LIST") != NULL;
}

/* The same system with a list, of one block. */
static as_list *list_of(const nsdae_system *system, const nsdae_dims *d)
{
  if (!event_run_by_list() || d->k == 0 || d->f > 0) return NULL;
  as_list *list = as_list_create(system, 1, &d->nq, &d->nv);
  assert_non_null(list);
  return list;
}

void event_run_do(event_run *run, nsdae_system *system, const double *q0, const double *v0)
{
  nsdae_sim *sim;
  clear(run);
  run->t = run->t0;
  nsdae_system_get_dims(system, &run->dims);
  assert_true(run->dims.nq <= EVENT_RUN_NQ && run->dims.k <= EVENT_RUN_K);
  as_list *list = list_of(system, &run->dims);
  assert_int_equal(
      nsdae_sim_create(list ? as_list_system(list) : system, &run->options, &sim, NULL), NSDAE_OK);
  nsdae_sim_observe(sim, keep, run);
  run->status = nsdae_sim_init(sim, run->t0, q0, v0);
  if (run->status == NSDAE_OK) run->status = nsdae_sim_run(sim, run->t_end);
  run->error = *nsdae_sim_error(sim);
  nsdae_sim_get_stats(sim, &run->stats);
  nsdae_sim_destroy(&sim);
  as_list_destroy(list);
  if (run->status != NSDAE_OK) print_message("%s\n", run->error.text);
}

static void expect_same(const event_run *a, const event_run *b)
{
  /* two integrators at the same tolerances: their errors, over the run */
  double tol = 1e3 * (a->options.rtol + a->options.atol);
  assert_int_equal(a->status, b->status);
  assert_int_equal(a->impacts, b->impacts);
  assert_int_equal(a->changes, b->changes);
  for (int i = 0; i < a->impacts; i++) {
    assert_near(a->impact[i].time, b->impact[i].time, tol * fmax(1, fabs(a->t)));
    assert_int_equal(a->impact[i].contact, b->impact[i].contact);
  }
  for (int i = 0; i < a->changes; i++) {
    assert_near(a->change[i].time, b->change[i].time, tol * fmax(1, fabs(a->t)));
    assert_int_equal(a->change[i].mode_after, b->change[i].mode_after);
  }
  for (int i = 0; i < a->dims.nq; i++) assert_near(a->q[i], b->q[i], tol * fmax(1, fabs(a->q[i])));
}

void event_run_both(event_run *run, nsdae_system *system, const double *q0, const double *v0)
{
  static event_run first; /* large */
  run->options.integrator = NSDAE_INTEGRATOR_DOPRI5;
  event_run_do(run, system, q0, v0);
  first = *run;
  run->options.integrator = NSDAE_INTEGRATOR_DOP853;
  event_run_do(run, system, q0, v0);
  run->options.integrator = NSDAE_INTEGRATOR_AUTO;
  expect_same(&first, run);
}

void event_run_print(const event_run *run)
{
  for (int i = 0; i < run->impacts; i++)
    print_message("impact %.12g contact %d: %.12g, %.6g -> %.6g%s\n", run->impact[i].time,
                  run->impact[i].contact, run->impact[i].normal_impulse,
                  run->impact[i].velocity_before, run->impact[i].velocity_after,
                  run->impact[i].accumulation ? ", the last" : "");
  for (int i = 0; i < run->changes; i++)
    print_message("change %.12g contact %d slide %d: %d -> %d\n", run->change[i].time,
                  run->change[i].contact, run->change[i].frictional_joint,
                  run->change[i].mode_before, run->change[i].mode_after);
  print_message("t %.12g, %ld instants, %ld accumulations, %ld fallbacks\n", run->t,
                run->stats.events, run->stats.accumulations, run->stats.fallback_steps);
  for (int i = 0; i < run->dims.nq; i++) print_message("%.12g  %.12g\n", run->q[i], run->v[i]);
}
