/* A simulation: a stepper, its records and its observers. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include <nsdae/sim.h>

#include "arena.h"
#include "clock.h"
#include "errors.h"
#include "options.h"
#include "stepper.h"
#include "system_impl.h"
#include "vector.h"

typedef struct observation {
  nsdae_observer_fn call;
  void *user;
} observation;

struct nsdae_sim {
  const nsdae_system *system;
  nsdae_sim_options options;
  nsdae_error error;
  nsdae_arena arena;
  nsdae_stepper stepper;
  nsdae_law *law; /* k, in a block of its own: its rows size the arena */
  observation observer[NSDAE_OBSERVERS_MAX];
  int observers;
  nsdae_record record;
  nsdae_stats stats;
  int started, told; /* init was called; the observers have seen the last record */
  int lcp_failed;    /* the last step ended on its complementarity problem */
  double grid_start; /* steps end at grid_start + grid_count dt */
  long grid_count;
  double *multiplier, *normal, *tangential; /* of the last record: m, k, k nt */
  int *mode;                                /* k */
  double *slide_impulse;                    /* f */
  int *slide_mode;                          /* f */
};

static void layout(void *object, nsdae_arena *arena)
{
  nsdae_sim *sim = object;
  const nsdae_dims *dims = &sim->system->dims;
  nsdae_stepper_layout(&sim->stepper, arena);
  sim->multiplier = NSDAE_ARENA_DOUBLES(arena, dims->m);
  sim->normal = NSDAE_ARENA_DOUBLES(arena, dims->k);
  sim->tangential = NSDAE_ARENA_DOUBLES(arena, (long)dims->k * dims->nt);
  sim->mode = NSDAE_ARENA_INTS(arena, dims->k);
  sim->slide_impulse = NSDAE_ARENA_DOUBLES(arena, dims->f);
  sim->slide_mode = NSDAE_ARENA_INTS(arena, dims->f);
}

static int no_memory(nsdae_sim *sim, nsdae_error *error)
{
  nsdae_sim_destroy(&sim);
  return nsdae_error_set(error, NSDAE_E_MEMORY, "nsdae_sim_create", "",
                         "out of memory for a simulation of this size");
}

static int check_create(const nsdae_system *system, const nsdae_sim_options *options,
                        nsdae_sim **sim, nsdae_error *error)
{
  nsdae_error_clear(error);
  if (!system || !sim)
    return nsdae_error_set(error, NSDAE_E_ARGUMENT, "nsdae_sim_create", system ? "sim" : "system",
                           "%s is NULL", system ? "sim" : "system");
  *sim = NULL;
  int status = options ? nsdae_sim_options_check(options, error) : NSDAE_OK;
  return status < 0 ? status : nsdae_system_complete(system, error);
}

int nsdae_sim_create(const nsdae_system *system, const nsdae_sim_options *options, nsdae_sim **sim,
                     nsdae_error *error)
{
  int status = check_create(system, options, sim, error);
  if (status < 0) return status;
  nsdae_sim *made = calloc(1, sizeof *made);
  if (!made) return no_memory(NULL, error);
  nsdae_system_hold(system);
  made->system = system;
  if (options)
    made->options = *options;
  else
    nsdae_sim_options_default(&made->options);
  nsdae_error_clear(&made->error);
  made->law = calloc((size_t)system->dims.k + 1, sizeof *made->law);
  if (!made->law) return no_memory(made, error);
  nsdae_stepper *stepper = &made->stepper;
  stepper->system = system;
  stepper->options = &made->options;
  stepper->error = &made->error;
  stepper->contacts.law = made->law;
  nsdae_stepper_prepare(stepper);
  if (nsdae_arena_build(&made->arena, layout, made) < 0) return no_memory(made, error);
  if (stepper->method->create) status = stepper->method->create(stepper);
  if (status < 0) {
    if (error) *error = made->error;
    nsdae_sim_destroy(&made);
    return status;
  }
  *sim = made;
  return NSDAE_OK;
}

void nsdae_sim_destroy(nsdae_sim **sim)
{
  if (!sim || !*sim) return;
  const nsdae_stepping *method = (*sim)->stepper.method;
  if (method && method->destroy) method->destroy(&(*sim)->stepper);
  nsdae_arena_release(&(*sim)->arena);
  free((*sim)->law);
  nsdae_system_let_go((*sim)->system);
  free(*sim);
  *sim = NULL;
}

/* T = v^T M v / 2 */
static double kinetic_energy(const nsdae_terms *terms)
{
  int n = terms->system->dims.nv;
  double twice = 0;
  for (int j = 0; j < n; j++)
    twice += terms->v[j] * nsdae_dot(n, terms->M + (size_t)j * (size_t)n, terms->v);
  return twice / 2;
}

/* The record of the state at the start of the next step. */
static void fill_record(nsdae_sim *sim)
{
  const nsdae_terms *now = &sim->stepper.start;
  nsdae_record *r = &sim->record;
  r->time = now->t;
  r->q = now->q;
  r->v = now->v;
  r->gap = now->gap;
  r->kinetic = kinetic_energy(now);
  r->potential = now->potential;
  r->lcp_residual = sim->stepper.worst_residual;
  r->constraint_drift = nsdae_terms_drift(now);
  r->penetration = nsdae_terms_penetration(now);
}

static void update_stats(nsdae_sim *sim)
{
  nsdae_stats *stats = &sim->stats;
  const nsdae_record *r = &sim->record;
  const nsdae_stepper *s = &sim->stepper;
  stats->lcps = s->lcps;
  stats->lcp_pivots = s->lcp_pivots;
  stats->iterations = s->iterations;
  stats->events = s->events;
  stats->accumulations = s->accumulations;
  stats->fallback_steps = s->fallbacks;
  stats->mass_evals = s->evals.mass;
  stats->force_evals = s->evals.force;
  stats->jacobian_evals = s->evals.jacobian;
  stats->rank = s->rank;
  stats->rank_most = s->rank_most;
  stats->worst_residual = fmax(stats->worst_residual, r->lcp_residual);
  stats->worst_drift = fmax(stats->worst_drift, r->constraint_drift);
  stats->worst_penetration = fmax(stats->worst_penetration, r->penetration);
  stats->energy_balance = r->kinetic + r->potential + r->dissipated - stats->energy_start;
}

enum {
  RECORD_TERMS = NSDAE_TERM_MASS | NSDAE_TERM_PHI | NSDAE_TERM_GAP | NSDAE_TERM_POTENTIAL,
  ALL_TERMS = RECORD_TERMS | NSDAE_TERM_FORCE | NSDAE_TERM_JACOBIAN | NSDAE_TERM_PHI_T |
              NSDAE_TERM_OMEGA | NSDAE_TERM_NORMAL | NSDAE_TERM_TANGENT | NSDAE_TERM_BIAS |
              NSDAE_TERM_SLIDE
};

static void clear_record(nsdae_sim *sim)
{
  const nsdae_dims *dims = &sim->system->dims;
  size_t k = (size_t)dims->k;
  memset(sim->multiplier, 0, (size_t)dims->m * sizeof *sim->multiplier);
  memset(sim->normal, 0, k * sizeof *sim->normal);
  memset(sim->tangential, 0, k * (size_t)dims->nt * sizeof *sim->tangential);
  memset(sim->mode, 0, k * sizeof *sim->mode);
  memset(sim->slide_impulse, 0, (size_t)dims->f * sizeof *sim->slide_impulse);
  memset(sim->slide_mode, 0, (size_t)dims->f * sizeof *sim->slide_mode);
  sim->record = (nsdae_record){.multiplier = sim->multiplier,
                               .normal_impulse = sim->normal,
                               .tangential_impulse = sim->tangential,
                               .mode = sim->mode,
                               .slide_impulse = sim->slide_impulse,
                               .slide_mode = sim->slide_mode,
                               .impact = sim->stepper.impact,
                               .change = sim->stepper.change};
}

static int check_state(nsdae_sim *sim, const char *name, int kind, const double *a, int n)
{
  char called[NSDAE_CALLED_SIZE];
  if (!a)
    return nsdae_error_set(&sim->error, NSDAE_E_ARGUMENT, "nsdae_sim_init", name, "%s is NULL",
                           name);
  for (int i = 0; i < n; i++) {
    if (isfinite(a[i])) continue;
    nsdae_error_set(&sim->error, NSDAE_E_NONFINITE, "nsdae_sim_init", name,
                    "%s[%d] = %g is not a finite number (%s)", name, i, a[i],
                    nsdae_system_called(sim->system, kind, i, called));
    sim->error.index = i;
    return NSDAE_E_NONFINITE;
  }
  return NSDAE_OK;
}

static int check_time(nsdae_sim *sim, double t0)
{
  if (isfinite(t0)) return NSDAE_OK;
  return nsdae_error_set(&sim->error, NSDAE_E_NONFINITE, "nsdae_sim_init", "t0",
                         "t0 = %g is not a finite number", t0);
}

/* Every term once, so that what is wrong with a model shows here. */
static int first_terms(nsdae_sim *sim, double t0, const double *q0, const double *v0)
{
  nsdae_stepper *s = &sim->stepper;
  s->evals = (nsdae_evals){0};
  s->lcps = s->lcp_pivots = s->iterations = 0;
  s->events = s->accumulations = s->fallbacks = 0;
  s->rank = sim->system->dims.m;
  s->rank_most = 0;
  s->worst_residual = 0;
  s->newmark.have_start = 0;
  s->fresh = 1;
  nsdae_contacts_forget(&s->contacts);
  nsdae_terms_at(&s->start, t0, q0, v0);
  int status = nsdae_terms_need(&s->start, ALL_TERMS);
  if (status == NSDAE_OK) status = nsdae_terms_symmetric(&s->start);
  return status < 0 ? status : nsdae_stepper_factor(s, &s->start, s->start.M);
}

int nsdae_sim_init(nsdae_sim *sim, double t0, const double *q0, const double *v0)
{
  if (!sim) return NSDAE_E_ARGUMENT;
  nsdae_error_clear(&sim->error);
  sim->started = sim->lcp_failed = 0;
  int status = check_time(sim, t0);
  if (status == NSDAE_OK)
    status = check_state(sim, "q0", NSDAE_NAME_COORDINATE, q0, sim->system->dims.nq);
  if (status == NSDAE_OK)
    status = check_state(sim, "v0", NSDAE_NAME_VELOCITY, v0, sim->system->dims.nv);
  if (status == NSDAE_OK) status = first_terms(sim, t0, q0, v0);
  if (status < 0) return status;
  clear_record(sim);
  fill_record(sim);
  sim->stats = (nsdae_stats){.energy_start = sim->record.kinetic + sim->record.potential};
  update_stats(sim);
  sim->grid_start = t0;
  sim->grid_count = 0;
  sim->started = 1;
  sim->told = 0;
  return NSDAE_OK;
}

static int find_observer(const nsdae_sim *sim, nsdae_observer_fn observer, void *user)
{
  int i = 0;
  while (i < sim->observers && (sim->observer[i].call != observer || sim->observer[i].user != user))
    i++;
  return i;
}

int nsdae_sim_observe(nsdae_sim *sim, nsdae_observer_fn observer, void *user)
{
  if (!sim) return NSDAE_E_ARGUMENT;
  nsdae_error_clear(&sim->error);
  if (!observer)
    return nsdae_error_set(&sim->error, NSDAE_E_ARGUMENT, "nsdae_sim_observe", "observer",
                           "observer is NULL");
  if (sim->observers == NSDAE_OBSERVERS_MAX)
    return nsdae_error_set(&sim->error, NSDAE_E_ARGUMENT, "nsdae_sim_observe", "observer",
                           "there are %d observers already, the most there can be",
                           NSDAE_OBSERVERS_MAX);
  sim->observer[sim->observers++] = (observation){observer, user};
  return NSDAE_OK;
}

int nsdae_sim_unobserve(nsdae_sim *sim, nsdae_observer_fn observer, void *user)
{
  if (!sim) return NSDAE_E_ARGUMENT;
  int i = find_observer(sim, observer, user);
  if (i == sim->observers) return NSDAE_OK;
  sim->observers--;
  memmove(sim->observer + i, sim->observer + i + 1,
          (size_t)(sim->observers - i) * sizeof *sim->observer);
  return NSDAE_OK;
}

static int observer_failed(nsdae_sim *sim, int status)
{
  if (sim->error.status != NSDAE_OK) return status;
  nsdae_error_set(&sim->error, status, "nsdae_sim", "observer",
                  "an observer returned %d (%s) at t = %.17g", status, nsdae_status_message(status),
                  sim->record.time);
  sim->error.code = status;
  sim->error.time = sim->record.time;
  return status;
}

/* Shows the record to every observer. */
static int tell(nsdae_sim *sim)
{
  int result = NSDAE_OK;
  sim->told = 1;
  for (int i = 0; i < sim->observers; i++) {
    nsdae_error_clear(&sim->error);
    int status = sim->observer[i].call(&sim->record, &sim->error, sim->observer[i].user);
    if (status < 0) return observer_failed(sim, status);
    if (status > 0) result = NSDAE_STOPPED;
  }
  return result;
}

/* A contact hits where it had no impulse in the step before (or the method says so) and closed
 * faster than the threshold. */
static void collect_impacts(nsdae_sim *sim)
{
  const nsdae_contacts *c = &sim->stepper.contacts;
  int nt = sim->system->dims.nt;
  nsdae_stepper *s = &sim->stepper;
  s->impacts = 0;
  for (int i = 0; i < sim->system->dims.k; i++) {
    int fresh = sim->normal[i] == 0 || c->impact[i];
    if (!(c->normal[i] > 0) || !fresh || !(c->before[i] < -sim->options.impact_velocity)) continue;
    nsdae_impact *impact = &s->impact[s->impacts++];
    *impact = (nsdae_impact){.time = sim->stepper.end.t,
                             .contact = i,
                             .normal_impulse = c->normal[i],
                             .velocity_before = c->before[i],
                             .velocity_after = c->after[i]};
    for (int j = 0; j < nt; j++) impact->tangential_impulse[j] = c->tangential[i * nt + j];
  }
}

static void keep_results(nsdae_sim *sim)
{
  const nsdae_stepper *s = &sim->stepper;
  const nsdae_dims *dims = &sim->system->dims;
  size_t k = (size_t)dims->k;
  if (!s->method->finds_impacts || s->stepped_over) collect_impacts(sim);
  sim->record.impacts = s->impacts;
  sim->record.changes = s->changes;
  memcpy(sim->multiplier, s->multiplier, (size_t)dims->m * sizeof *sim->multiplier);
  memcpy(sim->normal, s->contacts.normal, k * sizeof *sim->normal);
  memcpy(sim->tangential, s->contacts.tangential, k * (size_t)dims->nt * sizeof *sim->tangential);
  memcpy(sim->mode, s->contacts.mode, k * sizeof *sim->mode);
  memcpy(sim->slide_impulse, s->contacts.slide_impulse,
         (size_t)dims->f * sizeof *sim->slide_impulse);
  memcpy(sim->slide_mode, s->contacts.slide_mode, (size_t)dims->f * sizeof *sim->slide_mode);
  sim->record.dissipated -= s->work;
  sim->stats.steps++;
  sim->stats.smooth_steps += s->smooth;
  sim->stats.contact_steps += !s->smooth;
  sim->stats.impacts += sim->record.impacts;
}

/* One step to t1: the method, then the terms of the certificate, then the state changes. */
static int step_to(nsdae_sim *sim, double t1)
{
  nsdae_stepper *s = &sim->stepper;
  double h = t1 - s->start.t;
  if (!(h > 0))
    return nsdae_error_set(&sim->error, NSDAE_E_ARGUMENT, "nsdae_sim", "dt",
                           "dt = %g is lost in rounding at t = %.17g: make it larger",
                           sim->options.dt, s->start.t);
  s->t_end = t1;
  int status = s->method->advance(s, h);
  sim->lcp_failed = s->problem && (status == NSDAE_E_LCP || status == NSDAE_E_INFEASIBLE ||
                                   status == NSDAE_E_PAINLEVE);
  if (status == NSDAE_OK) status = nsdae_terms_need(&s->end, RECORD_TERMS);
  if (status < 0) {
    s->newmark.have_start = 0;
    return status;
  }
  keep_results(sim);
  nsdae_terms swapped = s->start;
  s->start = s->end;
  s->end = swapped;
  sim->record.step++;
  sim->grid_count += s->start.t >= t1;
  s->fresh = 0;
  fill_record(sim);
  update_stats(sim);
  return tell(sim);
}

static int begin(nsdae_sim *sim)
{
  nsdae_error_clear(&sim->error);
  if (!sim->started)
    return nsdae_error_set(&sim->error, NSDAE_E_STATE, "nsdae_sim", "",
                           "the simulation has no state: call nsdae_sim_init first");
  return sim->told ? NSDAE_OK : tell(sim);
}

/* Times come from the grid, not from adding dt up. */
static double next_time(const nsdae_sim *sim)
{
  return sim->grid_start + (double)(sim->grid_count + 1) * sim->options.dt;
}

int nsdae_sim_step(nsdae_sim *sim)
{
  if (!sim) return NSDAE_E_ARGUMENT;
  double began = nsdae_wall_clock();
  int status = begin(sim);
  if (status != NSDAE_OK) return status;
  status = step_to(sim, next_time(sim));
  sim->stats.wall_time += nsdae_wall_clock() - began;
  if (status != NSDAE_OK) return status;
  if (sim->stepper.settled) return NSDAE_ZENO;
  return sim->record.impacts > 0 || sim->stepper.changed ? NSDAE_EVENT : NSDAE_OK;
}

static int run(nsdae_sim *sim, double t_end)
{
  /* a step that would end within rounding of t_end ends at t_end */
  const double hair = 1e-9 * sim->options.dt;
  int status = begin(sim);
  while (status == NSDAE_OK && sim->stepper.start.t < t_end) {
    double t1 = next_time(sim);
    int last = t1 >= t_end - hair;
    status = step_to(sim, last ? t_end : t1);
    if (status < 0 || !last || fabs(t1 - t_end) <= hair) continue;
    sim->grid_start = t_end; /* a shortened step: a new grid from here */
    sim->grid_count = 0;
  }
  return status;
}

int nsdae_sim_run(nsdae_sim *sim, double t_end)
{
  if (!sim) return NSDAE_E_ARGUMENT;
  nsdae_error_clear(&sim->error);
  if (!isfinite(t_end) || (sim->started && t_end < sim->stepper.start.t))
    return nsdae_error_set(&sim->error, NSDAE_E_ARGUMENT, "nsdae_sim_run", "t_end",
                           "t_end = %g is outside its range: it must be finite and at least the "
                           "time reached, %g",
                           t_end, sim->started ? sim->stepper.start.t : 0);
  double began = nsdae_wall_clock();
  int status = run(sim, t_end);
  sim->stats.wall_time += nsdae_wall_clock() - began;
  return status;
}

int nsdae_sim_get_record(const nsdae_sim *sim, nsdae_record *record)
{
  if (!sim || !record) return NSDAE_E_ARGUMENT;
  if (!sim->started) return NSDAE_E_STATE;
  *record = sim->record;
  return NSDAE_OK;
}

int nsdae_sim_get_failed_lcp(const nsdae_sim *sim, nsdae_lcp_problem *problem)
{
  if (!sim || !problem) return NSDAE_E_ARGUMENT;
  if (!sim->lcp_failed) return NSDAE_E_STATE;
  const nsdae_contacts *c = sim->stepper.problem;
  *problem = (nsdae_lcp_problem){.n = c->rows, .A = c->A, .lda = c->rows, .b = c->b};
  return NSDAE_OK;
}

int nsdae_sim_get_stats(const nsdae_sim *sim, nsdae_stats *stats)
{
  if (!sim || !stats) return NSDAE_E_ARGUMENT;
  *stats = sim->stats;
  return NSDAE_OK;
}

int nsdae_sim_get_dims(const nsdae_sim *sim, nsdae_dims *dims)
{
  if (!sim || !dims) return NSDAE_E_ARGUMENT;
  *dims = sim->system->dims;
  return NSDAE_OK;
}

int nsdae_sim_has_potential(const nsdae_sim *sim)
{
  return sim && sim->system->potential;
}

int nsdae_sim_get_options(const nsdae_sim *sim, nsdae_sim_options *options)
{
  if (!sim || !options) return NSDAE_E_ARGUMENT;
  *options = sim->options;
  return NSDAE_OK;
}

const nsdae_error *nsdae_sim_error(const nsdae_sim *sim)
{
  static const nsdae_error none = {
      .status = NSDAE_E_ARGUMENT,
      .index = -1,
      .time = NAN,
      .argument = "sim",
      .where = "nsdae_sim_error",
      .text = "there is no simulation: it was not made (the last argument of nsdae_sim_create says "
              "why), or it was destroyed"};
  return sim ? &sim->error : &none;
}

const nsdae_system *nsdae_sim_get_system(const nsdae_sim *sim)
{
  return sim ? sim->system : NULL;
}

const char *nsdae_method_name(int method)
{
  const nsdae_stepping *stepping = nsdae_stepping_of(method);
  return stepping ? stepping->name : NULL;
}

const char *nsdae_method_summary(int method)
{
  const nsdae_stepping *stepping = nsdae_stepping_of(method);
  return stepping ? stepping->summary : NULL;
}
