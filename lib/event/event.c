/* Event-driven integration: smooth phases by SUNDIALS IDA up to the instants where a contact
 * closes, opens, sticks or slips, which its root functions find; there the laws of impact and
 * contact decide how it goes on. dt is how often the state is recorded, by the integrator's own
 * interpolation, and its longest step. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "errors.h"
#include "method.h"

/* Instants in one dt without an impact or a change of mode. */
enum { IDLE_MAX = 100 };

static void layout(void *object, nsdae_arena *arena)
{
  nsdae_event_method *e = object;
  const nsdae_dims *d = &e->setting.system->dims;
  nsdae_event_modes_layout(&e->phase.modes, d, arena);
  nsdae_event_phase_layout(&e->phase, arena);
  nsdae_event_roots_layout(&e->roots, arena);
  nsdae_event_integrator_layout(&e->integrator, arena);
  nsdae_event_account_layout(&e->account, arena);
  nsdae_event_acceleration_layout(&e->instant.acceleration, arena);
  nsdae_event_sharing_layout(&e->instant.sharing, arena);
  nsdae_event_impacts_layout(&e->instant.impacts, arena);
  nsdae_event_projection_layout(&e->instant.projection, arena);
  e->mode_before = NSDAE_ARENA_INTS(arena, d->k);
  e->slide_mode_before = NSDAE_ARENA_INTS(arena, d->f);
}

/* Each part to those that it stands on. */
static void connect(nsdae_event_method *e)
{
  nsdae_stepper *s = e->stepper;
  e->setting = (nsdae_event_setting){.system = s->system,
                                     .options = s->options,
                                     .error = s->error,
                                     .here = &s->middle,
                                     .kkt = &s->kkt};
  nsdae_event_set_places(&e->setting);
  e->phase.setting = &e->setting;
  e->roots.phase = &e->phase;
  e->integrator.roots = &e->roots;
  e->account.integrator = &e->integrator;
  e->instant.roots = &e->roots;
  e->instant.acceleration.phase = &e->phase;
  e->instant.sharing.acceleration = &e->instant.acceleration;
  e->instant.projection.phase = &e->phase;
  e->instant.impacts.acceleration = &e->instant.acceleration;
  e->instant.impacts.account = &e->account;
  e->instant.impacts.accumulation.acceleration = &e->instant.acceleration;
  e->instant.impacts.accumulation.projection = &e->instant.projection;
}

static int make(nsdae_event_method *e)
{
  connect(e);
  int status = nsdae_event_acceleration_make(&e->instant.acceleration);
  if (status == NSDAE_OK) status = nsdae_event_impacts_make(&e->instant.impacts);
  if (status == NSDAE_OK) status = nsdae_arena_build(&e->arena, layout, e);
  if (status < 0) return status;
  nsdae_event_roots_name(&e->roots);
  return nsdae_event_integrator_make(&e->integrator);
}

static int create(nsdae_stepper *s)
{
  nsdae_event_method *e = calloc(1, sizeof *e);
  s->own = e;
  int status = NSDAE_E_MEMORY;
  if (e) {
    e->stepper = s;
    status = make(e);
  }
  if (status == NSDAE_E_UNSUPPORTED)
    return nsdae_error_set(s->error, status, "nsdae_sim_create", "method",
                           "method event needs SUNDIALS, and this library was built without it "
                           "(NSDAE_SUNDIALS=OFF)");
  if (status < 0) nsdae_error_set(s->error, status, "nsdae_sim_create", "", "out of memory");
  return status;
}

static void destroy(nsdae_stepper *s)
{
  nsdae_event_method *e = s->own;
  if (!e) return;
  nsdae_dae_destroy(&e->integrator.dae);
  nsdae_arena_release(&e->arena);
  nsdae_event_acceleration_release(&e->instant.acceleration);
  nsdae_event_impacts_release(&e->instant.impacts);
  free(e);
  s->own = NULL;
}

/* A failure of the integrator at t, where its y is. */
static int integrator_failed(nsdae_event_method *e, int status, double t)
{
  nsdae_error *error = e->setting.error;
  if (error->status != NSDAE_OK) return error->status;
  if (nsdae_event_diagnose(&e->instant.acceleration, t, e->integrator.y) < 0)
    return NSDAE_E_PAINLEVE;
  nsdae_error_set(error, status, "nsdae_event", "rtol",
                  "the integrator failed at t = %.17g with IDA's code %d: try a larger rtol, or "
                  "method = implicit",
                  t, e->integrator.code);
  error->code = e->integrator.code;
  error->time = t;
  return status;
}

/* The instant t at the state of the integrator's y, and the start of the next phase. */
static int restart(nsdae_event_method *e, double t)
{
  int status = nsdae_event_pass(&e->instant, t, e->integrator.y, e->integrator.yp);
  e->since = t;
  e->instants++;
  if (status < 0) return status;
  status = nsdae_event_integrator_start(&e->integrator, t);
  return status < 0 ? integrator_failed(e, status, t) : status;
}

static void add_change(nsdae_stepper *s, double t, int contact, int slide, int before, int after)
{
  if (before != after) s->change[s->changes++] = (nsdae_change){t, contact, slide, before, after};
}

/* The same in the middle of a run, where a change of mode is told. */
static int go_through(nsdae_event_method *e, double t)
{
  nsdae_stepper *s = e->stepper;
  const nsdae_dims *d = &s->system->dims;
  const nsdae_event_modes *m = &e->phase.modes;
  memcpy(e->mode_before, m->contact, (size_t)d->k * sizeof *m->contact);
  memcpy(e->slide_mode_before, m->slide, (size_t)d->f * sizeof *m->slide);
  int before = e->instant.impacts.records + s->changes, status = restart(e, t);
  for (int i = 0; i < d->k && status == NSDAE_OK; i++)
    add_change(s, t, i, -1, e->mode_before[i], m->contact[i]);
  for (int j = 0; j < d->f && status == NSDAE_OK; j++)
    add_change(s, t, -1, j, e->slide_mode_before[j], m->slide[j]);
  e->idle += e->instant.impacts.records + s->changes == before;
  return status;
}

/* Whether the lists of impacts and changes hold what one more instant may add. */
static int room(const nsdae_event_method *e)
{
  const nsdae_dims *d = &e->setting.system->dims;
  return e->instant.impacts.records + d->k <= e->instant.impacts.records_max &&
         e->stepper->changes + d->k + d->f <= e->stepper->changes_max;
}

/* From the state of the step's start: at the beginning, and after a step that failed. */
static int begin(nsdae_event_method *e)
{
  nsdae_stepper *s = e->stepper;
  nsdae_event_modes *m = &e->phase.modes;
  const nsdae_dims *d = &s->system->dims;
  double *y = e->integrator.y;
  memset(y, 0, (size_t)e->setting.at.n * sizeof *y);
  memset(m->contact, 0, (size_t)d->k * sizeof *m->contact);
  memset(m->slide, 0, (size_t)d->f * sizeof *m->slide);
  memset(m->slide_sense, 0, (size_t)d->f * sizeof *m->slide_sense);
  for (int j = 0; j < d->f; j++) m->normal_sense[j] = 1;
  for (int i = 0; i < e->roots.count; i++) e->roots.entry[i].found = 0;
  nsdae_contacts_forget(&e->instant.acceleration.problem);
  nsdae_contacts_forget(&e->instant.impacts.problem);
  memcpy(y, s->start.q, (size_t)d->nq * sizeof *y);
  memcpy(y + d->nq, s->start.v, (size_t)d->nv * sizeof *y);
  e->reached = s->start.t;
  return restart(e, s->start.t);
}

static int integrate(nsdae_event_method *e)
{
  double from = e->integrator.ahead;
  int status = nsdae_event_integrator_advance(&e->integrator);
  if (status < 0) nsdae_event_integrator_read(&e->integrator, from, e->integrator.y);
  return status < 0 ? integrator_failed(e, status, from) : status;
}

/* Friction that is asked again and again how it shares between contacts leads nowhere, sooner. */
static int too_many(const nsdae_event_method *e)
{
  return e->instant.impacts.endless || e->instants > e->setting.options->events_max ||
         e->idle > IDLE_MAX;
}

/* To the end of the step, or until a list is nearly full: then the step ends early. */
static int run_to(nsdae_event_method *e, double t_end)
{
  nsdae_event_integrator *g = &e->integrator;
  int status = NSDAE_OK;
  while (status == NSDAE_OK && e->reached < t_end && room(e) && !too_many(e)) {
    if (!(g->ahead > e->reached)) status = integrate(e);
    if (status < 0) break;
    double to = fmin(g->ahead, t_end);
    status = nsdae_event_account_phase(&e->account, e->reached, to);
    e->reached = to;
    if (status < 0 || !g->pending || to < g->ahead) continue;
    status = nsdae_event_integrator_read(g, to, g->y);
    if (status == NSDAE_OK) status = go_through(e, to);
  }
  return status;
}

static void clear_step(nsdae_event_method *e)
{
  nsdae_event_account_clear(&e->account);
  e->setting.counts =
      (nsdae_event_counts){.rank = e->stepper->rank, .rank_most = e->stepper->rank_most};
  e->instants = e->idle = e->instant.impacts.endless = e->instant.impacts.accumulations = 0;
  e->instant.impacts.records = 0;
  e->stepper->impacts = e->stepper->changes = 0;
}

/* What the step did, for the record. */
static int read_results(nsdae_event_method *e, double h)
{
  nsdae_stepper *s = e->stepper;
  nsdae_contacts *c = &s->contacts;
  const nsdae_event_modes *m = &e->phase.modes;
  const nsdae_event_account *a = &e->account;
  const nsdae_dims *d = &s->system->dims;
  double *y = e->integrator.y;
  int status = NSDAE_OK;
  if (e->integrator.ahead > e->reached || e->integrator.ahead > e->since)
    status = nsdae_event_integrator_read(&e->integrator, e->reached, y);
  if (status < 0) return status;
  nsdae_terms_at(&s->end, e->reached, y, y + d->nq);
  for (int i = 0; i < d->m; i++) s->multiplier[i] = a->multiplier[i] / h;
  memcpy(c->normal, a->normal, (size_t)d->k * sizeof *c->normal);
  memcpy(c->tangential, a->tangential, (size_t)(d->k * d->nt) * sizeof *c->tangential);
  memcpy(c->mode, m->contact, (size_t)d->k * sizeof *c->mode);
  memcpy(c->slide_impulse, a->slide, (size_t)d->f * sizeof *c->slide_impulse);
  memcpy(c->slide_mode, m->slide, (size_t)d->f * sizeof *c->slide_mode);
  s->impacts = e->instant.impacts.records;
  memcpy(s->impact, e->instant.impacts.record, (size_t)s->impacts * sizeof *s->impact);
  s->work = a->work;
  s->smooth = e->instants == 0;
  s->events += e->instants;
  s->accumulations += e->instant.impacts.accumulations;
  s->changed = e->instants;
  s->settled = e->instant.impacts.accumulations;
  return status;
}

static void read_counts(nsdae_event_method *e)
{
  nsdae_stepper *s = e->stepper;
  const nsdae_event_counts *n = &e->setting.counts;
  s->lcps += n->lcps;
  s->lcp_pivots += n->pivots;
  s->iterations += n->iterations;
  s->rank = n->rank;
  s->rank_most = n->rank_most;
  s->worst_residual = n->residual;
  s->problem = e->setting.problem;
}

/* So many instants in one step that it is no accumulation: the step by implicit instead. */
static int step_over(nsdae_event_method *e, double h)
{
  nsdae_stepper *s = e->stepper;
  s->fallbacks++;
  s->stepped_over = 1;
  s->impacts = s->changes = s->changed = s->settled = 0;
  nsdae_contacts_forget(&s->contacts);
  return nsdae_stepping_implicit.advance(s, h);
}

static int advance(nsdae_stepper *s, double h)
{
  nsdae_event_method *e = s->own;
  int status = NSDAE_OK, running = e->running && !s->fresh;
  e->running = 0;
  s->stepped_over = 0;
  clear_step(e);
  if (!running) status = begin(e);
  if (status == NSDAE_OK) status = run_to(e, s->t_end);
  read_counts(e);
  if (status < 0) return status;
  if (too_many(e)) return step_over(e, h);
  status = read_results(e, e->reached - s->start.t);
  nsdae_error_clear(s->error);
  e->running = status == NSDAE_OK;
  return status;
}

const nsdae_stepping nsdae_stepping_event = {
    .name = "event",
    .summary = "event-driven on SUNDIALS IDA: impacts, stick and slip located exactly",
    .advance = advance,
    .create = create,
    .destroy = destroy,
    .finds_impacts = 1};
