/* Records, impacts, certificates and statistics of a point, from its result alone. */
#include <string.h>

#include "errors.h"
#include "listed.h"
#include "sim_impl.h"

/* Observers: each sees every record once, in the order in which they were added. A step is the
 * state when all have seen it; when one fails, it is its turn again as soon as the step is tried
 * again. */

NSDAE_SIM_CALL(NSDAE_ASK, nsdae_sim_observe,
               (nsdae_sim * sim, nsdae_observer_fn observer, void *user), sim, observer, user)
{
  nsdae_observers *o = &sim->observers;
  nsdae_error_clear(&sim->error);
  if (!observer)
    return nsdae_error_set(&sim->error, NSDAE_E_ARGUMENT, "nsdae_sim_observe", "observer",
                           "observer is NULL");
  if (o->count == NSDAE_OBSERVERS_MAX)
    return nsdae_error_set(&sim->error, NSDAE_E_ARGUMENT, "nsdae_sim_observe", "observer",
                           "there are %d observers already, the maximum", NSDAE_OBSERVERS_MAX);
  o->of[o->count++] = (nsdae_observation){observer, user};
  return NSDAE_OK;
}

NSDAE_SIM_CALL(NSDAE_ASK, nsdae_sim_unobserve,
               (nsdae_sim * sim, nsdae_observer_fn observer, void *user), sim, observer, user)
{
  nsdae_observers *o = &sim->observers;
  int i = 0;
  while (i < o->count && (o->of[i].call != observer || o->of[i].user != user)) i++;
  if (i == o->count) return NSDAE_OK;
  o->count--;
  o->turn -= i < o->turn;
  memmove(o->of + i, o->of + i + 1, (size_t)(o->count - i) * sizeof *o->of);
  return NSDAE_OK;
}

static int call(nsdae_sim *sim, nsdae_observation observer, const nsdae_record *record)
{
  nsdae_error_clear(&sim->error);
  nsdae_refusal_forget(sim); /* that of a callback */
  sim->observers.telling = sim->guard.showing = 1;
  int status = observer.call(record, &sim->error, observer.user);
  sim->observers.telling = sim->guard.showing = 0;
  if (status >= 0 || sim->error.status != NSDAE_OK) return status;
  nsdae_error_set(&sim->error, status, "nsdae_sim", "observer",
                  "an observer returned %d (%s) at t = %g", status, nsdae_status_message(status),
                  record->time);
  sim->error.code = status;
  return nsdae_error_at(&sim->error, status, -1, record->time);
}

int nsdae_observers_tell(nsdae_sim *sim, const nsdae_record *record)
{
  nsdae_observers *o = &sim->observers;
  while (o->turn < o->count) {
    nsdae_observation observer = o->of[o->turn++];
    int status = call(sim, observer, record);
    if (status > 0) o->stop = 1;
    if (status >= 0) continue;
    /* it is its turn again, unless it took itself out */
    o->turn -= o->turn > 0 && o->of[o->turn - 1].call == observer.call &&
               o->of[o->turn - 1].user == observer.user;
    return status;
  }
  int stop = o->stop;
  o->turn = o->stop = 0;
  return stop ? NSDAE_STOPPED : NSDAE_OK;
}

enum {
  RECORD_TERMS = NSDAE_TERM_MASS | NSDAE_TERM_PHI | NSDAE_TERM_GAP | NSDAE_TERM_POTENTIAL,
  ALL_TERMS = RECORD_TERMS | NSDAE_TERM_FORCE | NSDAE_TERM_JACOBIAN | NSDAE_TERM_PHI_T |
              NSDAE_TERM_OMEGA | NSDAE_TERM_NORMAL | NSDAE_TERM_TANGENT | NSDAE_TERM_BIAS |
              NSDAE_TERM_SLIDE,
  EVERY_TERM = ALL_TERMS | NSDAE_TERM_ACCELERATION
};

/* k of fixed contacts, which have their places in every record. */
static int fixed_contacts(const nsdae_point *p)
{
  const nsdae_system *s = p->result.end.system;
  return s->tracked ? 0 : s->dims.k;
}

/* Where the arrays are: made anew when lists grew. */
void nsdae_point_show_arrays(nsdae_point *p)
{
  const nsdae_result *r = &p->result;
  const nsdae_impulses *impulses = &r->impulses;
  const nsdae_system *s = r->end.system;
  nsdae_record *to = &p->record;
  nsdae_contact_set *contacts = &to->contacts;
  to->q = r->end.q;
  to->v = r->end.v;
  to->acceleration = p->acceleration;
  to->multiplier = r->multiplier;
  to->frictional_joint_impulse = impulses->frictional_joint_impulse;
  to->frictional_joint_force = p->frictional_joint_force;
  to->frictional_joint_mode = impulses->frictional_joint_mode;
  to->impact = r->impact;
  to->change = r->change;
  contacts->id = r->closed.id;
  contacts->block = r->closed.block;
  contacts->gap = r->closed.gap;
  contacts->normal_impulse = impulses->normal;
  contacts->tangential_impulse = impulses->tangential;
  contacts->mode = impulses->mode;
  if (s->tracked || nsdae_terms_most(s) == NSDAE_ANY_NUMBER) return;
  to->gap = contacts->gap;
  to->normal_impulse = contacts->normal_impulse;
  to->tangential_impulse = contacts->tangential_impulse;
  to->mode = contacts->mode;
  to->normal_force = p->normal_force;
  to->tangential_force = p->tangential_force;
}

void nsdae_point_layout(nsdae_point *p, nsdae_arena *arena)
{
  const nsdae_dims *d = &p->result.end.system->dims;
  long k = fixed_contacts(p);
  nsdae_result_layout(&p->result, arena);
  p->acceleration = NSDAE_ARENA_DOUBLES(arena, d->nv);
  p->normal_force = NSDAE_ARENA_DOUBLES(arena, k);
  p->tangential_force = NSDAE_ARENA_DOUBLES(arena, k * d->nt);
  p->frictional_joint_force = NSDAE_ARENA_DOUBLES(arena, d->f);
  p->angle = NSDAE_ARENA_DOUBLES(arena, p->result.end.system->maker.sensors.angles);
  nsdae_point_show_arrays(p);
}

static inline void scale(double *restrict to, const double *restrict a, int n, double factor)
{
  for (int i = 0; i < n; i++) to[i] = factor * a[i];
}

/* Means over the step of length h, of all that happened in it; h = 0: there was none. */
static void fill_means(nsdae_point *p, const nsdae_terms *from, double h)
{
  const nsdae_result *r = &p->result;
  const nsdae_dims *d = &r->end.system->dims;
  int k = fixed_contacts(p);
  double rate = h > 0 ? 1 / h : 0;
  const double *before = from->v, *after = r->end.v;
  double *a = p->acceleration;
  for (int i = 0; i < d->nv; i++) a[i] = rate * (after[i] - before[i]);
  scale(p->normal_force, r->impulses.normal, k, rate);
  scale(p->tangential_force, r->impulses.tangential, k * d->nt, rate);
  scale(p->frictional_joint_force, r->impulses.frictional_joint_impulse, d->f, rate);
  p->record.duration = r->end.t - from->t;
}

/* The numbers of the record; its arrays are the point's. */
static void fill_record(nsdae_point *p)
{
  const nsdae_result *r = &p->result;
  const nsdae_terms *end = &r->end;
  nsdae_record *record = &p->record;
  record->step = p->accounts.step;
  record->time = nsdae_terms_time(end);
  record->kinetic = nsdae_terms_energy(end, end->v);
  record->potential = end->potential;
  record->dissipated = p->accounts.dissipated;
  record->projection_energy = p->accounts.raised;
  record->lcp_residual = r->worst_residual;
  record->contact_tol = r->contact_tol;
  record->contacts.count = r->closed.count + fixed_contacts(p);
  record->impacts = r->impacts;
  record->changes = r->changes;
}

static void add_counters(nsdae_stats *stats, const nsdae_counters *c)
{
  stats->lcps += c->lcps;
  stats->lcp_pivots += c->lcp_pivots;
  stats->iterations += c->iterations;
  stats->events += c->events;
  stats->accumulations += c->accumulations;
  stats->accumulations_early += c->accumulations_early;
  if (c->rank_retained < stats->rank_retained) stats->rank_retained = c->rank_retained;
  stats->rank_discarded = nsdae_larger(stats->rank_discarded, c->rank_discarded);
  stats->fallback_steps += c->fallbacks;
  stats->frozen_steps += c->frozen;
  stats->inexact_steps += c->inexact;
  stats->mass_evals += c->evals.mass;
  stats->force_evals += c->evals.force;
  stats->jacobian_evals += c->evals.jacobian;
  if (c->rank < stats->rank) stats->rank = c->rank;
  if (c->rank_most > stats->rank_most) stats->rank_most = c->rank_most;
  stats->islands = c->islands;
  stats->island_contacts = c->island_contacts;
}

static void certify(nsdae_stats *stats, const nsdae_record *r)
{
  stats->worst_residual = nsdae_larger(stats->worst_residual, r->lcp_residual);
  stats->contact_tol = nsdae_larger(stats->contact_tol, r->contact_tol);
  stats->worst_drift = nsdae_larger(stats->worst_drift, r->constraint_drift);
  stats->worst_penetration = nsdae_larger(stats->worst_penetration, r->penetration);
  stats->energy_balance = r->kinetic + r->potential + r->dissipated - stats->energy_start;
}

/* Whether the contact in slot i had an impulse in the step before, by its id. */
static int had_impulse(const nsdae_result *last, const nsdae_tracked *tracked, int i)
{
  int any = 0;
  for (int a = 0; a < last->closed.count && !any; a++)
    any = last->closed.id[a] == tracked->id[i] && last->impulses.normal[a] != 0;
  return any;
}

/* A contact hits where it had no impulse in the step before (or the method says so) and closed
 * faster than the threshold. */
static void find_impacts(const nsdae_result *last, nsdae_result *result, double slow)
{
  const nsdae_impulses *r = &result->impulses;
  const nsdae_dims *dims = &result->end.system->dims;
  const nsdae_closed *closed = &result->closed;
  const nsdae_tracked *tracked = result->end.system->tracked;
  for (int i = 0; i < dims->k + closed->count; i++) {
    int idle = tracked ? !had_impulse(last, tracked, i) : closed->fresh[i];
    int fresh = idle || r->impact[i];
    if (!(r->normal[i] > 0) || !fresh || !(r->before[i] < -slow)) continue;
    nsdae_impact *impact = &result->impact[result->impacts++];
    *impact = (nsdae_impact){.time = nsdae_terms_time(&result->end),
                             .contact = i,
                             .normal_impulse = r->normal[i],
                             .velocity_before = r->before[i],
                             .velocity_after = r->after[i],
                             .id = closed->id[i],
                             .block = {closed->block[2 * i], closed->block[2 * i + 1]}};
    for (int j = 0; j < dims->nt; j++)
      impact->tangential_impulse[j] = r->tangential[i * dims->nt + j];
  }
}

/* What touches at the start, and whether the equations can be solved there. */
static int try_equations(nsdae_sim *sim, nsdae_result *r)
{
  const nsdae_state state = {.terms = &r->end, .closed = &r->closed, .impulses = &r->impulses};
  const nsdae_step step = {
      .tools = &sim->stepper, .state = &state, .start = &r->end, .end = &r->end, .result = r};
  nsdae_stepper *s = &sim->stepper;
  nsdae_contacts_remember(&s->contacts, r->memory.whole);
  int status = nsdae_step_close(&step, &r->end);
  if (status == NSDAE_OK) status = nsdae_problem_factor(&sim->stepper.problem, &r->end, 0);
  if (status < 0) return status;
  memset(s->impulse, 0, (size_t)sim->system->dims.m * sizeof *s->impulse);
  return nsdae_step_solve(&step, &r->end, r->end.M, r->end.F, 0, s->v, s->impulse);
}

/* The turns of sensors after a step; before NULL: at the start. */
static void follow_turns(const nsdae_point *before, nsdae_point *point, double length)
{
  const nsdae_terms *to = &point->result.end, *from = before ? &before->result.end : to;
  const nsdae_maker *maker = &to->system->maker;
  const nsdae_moved was = {from->q, from->v}, is = {to->q, to->v};
  if (maker->sensors.angles > 0)
    maker->sensors.follow(maker->of, &was, &is, length, before ? before->angle : NULL,
                          point->angle);
}

int nsdae_point_start(nsdae_sim *sim, nsdae_point *point)
{
  nsdae_terms *start = &point->result.end;
  nsdae_stats *stats = &point->accounts.stats;
  int status = nsdae_terms_need(start, ALL_TERMS);
  if (status == NSDAE_OK) status = nsdae_terms_symmetric(start);
  if (status == NSDAE_OK) status = try_equations(sim, &point->result);
  if (status < 0) return status;
  point->accounts = (nsdae_accounts){.grid_start = start->t};
  fill_record(point);
  point->accounts.watch.kinetic = point->record.kinetic;
  status = nsdae_certificate_start(sim, point);
  if (status < 0) return status;
  point->result.closed.count = 0; /* none did anything yet */
  point->record.contacts.count = fixed_contacts(point);
  fill_means(point, start, 0);
  follow_turns(NULL, point, 0);
  stats->energy_start = point->record.kinetic + point->record.potential;
  stats->rank = sim->system->dims.m;
  stats->rank_retained = 1;
  status = nsdae_point_finite(point);
  if (status < 0) return status;
  status = nsdae_monitors_start(sim, point);
  if (status < 0) return status;
  add_counters(stats, &point->result.counters);
  certify(stats, &point->record);
  return NSDAE_OK;
}

int nsdae_point_show(nsdae_point *point, unsigned have)
{
  nsdae_terms *end = &point->result.end;
  int status = nsdae_terms_need(end, (have & EVERY_TERM) | RECORD_TERMS);
  if (status == NSDAE_OK && (have & NSDAE_TERM_CONTACTS))
    status = nsdae_terms_contacts(end, end->by.reach);
  if (status < 0) return status;
  end->have &= have | RECORD_TERMS | end->absent; /* some callbacks give two */
  fill_record(point);
  point->record.constraint_drift = point->record.certificate.constraint_drift;
  point->record.penetration = point->record.certificate.penetration;
  fill_means(point, end, 0);
  return NSDAE_OK;
}

int nsdae_point_follow(const nsdae_sim *sim, nsdae_point *before, nsdae_point *point, double length)
{
  nsdae_result *r = &point->result;
  nsdae_accounts *a = &point->accounts;
  int status = nsdae_terms_need(&r->end, RECORD_TERMS);
  if (status < 0) return status;
  if (!r->located) find_impacts(&before->result, r, sim->options.impact_velocity);
  *a = before->accounts;
  a->step++;
  a->dissipated -= r->work;
  a->raised += r->raised;
  a->stats.steps++;
  a->stats.smooth_steps += r->smooth;
  a->stats.contact_steps += !r->smooth;
  a->stats.impacts += r->impacts;
  fill_record(point);
  status = nsdae_certificate_follow(sim, before, point);
  if (status < 0) return status;
  fill_means(point, &before->result.end, length);
  follow_turns(before, point, length);
  status = nsdae_point_finite(point);
  if (status < 0) return status;
  add_counters(&a->stats, &r->counters);
  certify(&a->stats, &point->record);
  return NSDAE_OK;
}
