/* Event-driven integration: smooth phases by SUNDIALS IDA (event_phase.c) up to the instants where
 * a contact closes, opens, sticks or slips, which its root functions find (event_roots.c); there
 * the laws of impact and contact decide how it goes on (event_instant.c). dt is how often the state
 * is recorded, by the integrator's own interpolation, and its longest step. */
#include "event.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "errors.h"
#include "vector.h"

/* Instants in one step without an impact or a change of mode. */
enum { IDLE_MAX = 100 };

static int create(nsdae_stepper *s)
{
  nsdae_event_method *e = calloc(1, sizeof *e);
  s->own = e;
  int status = NSDAE_E_MEMORY;
  if (e) {
    e->stepper = s;
    status = nsdae_event_make(e);
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
  nsdae_event_release(e);
  free(e);
  s->own = NULL;
}

static int integrator_failed(nsdae_event_method *e, int status, double t, int code)
{
  nsdae_stepper *s = e->stepper;
  if (s->error->status != NSDAE_OK) return s->error->status;
  if (nsdae_event_diagnose(e, t) < 0) return NSDAE_E_PAINLEVE;
  nsdae_error_set(s->error, status, "nsdae_event", "rtol",
                  "the integrator failed at t = %.17g with IDA's code %d: try a larger rtol, or "
                  "method = implicit",
                  t, code);
  s->error->code = code;
  s->error->time = t;
  return status;
}

/* Accelerations and forces of the new phase at its start, of its own equations. Where these are
 * singular the integrator starts with those of the instant, and says so if it cannot. */
static int solve_start(nsdae_event_method *e, double t)
{
  int nq = e->stepper->system->dims.nq, nv = e->stepper->system->dims.nv;
  memcpy(e->at, e->y, (size_t)e->n * sizeof *e->y);
  int status = nsdae_event_forces(e, t, e->at);
  if (status == NSDAE_E_CONVERGENCE) return NSDAE_OK;
  if (status < 0) return status;
  memcpy(e->y, e->at, (size_t)e->n * sizeof *e->y);
  for (int i = 0; i < nv; i++) e->yp[nq + i] = -e->r[nq + i];
  return NSDAE_OK;
}

/* The instant t at the state e->y: what happens there, and the start of the next phase. */
static int restart(nsdae_event_method *e, double t)
{
  int code = 0, status = nsdae_event_instant(e, t);
  if (status < 0) return status;
  nsdae_event_set_terms(e);
  nsdae_error_clear(e->stepper->error);
  status = solve_start(e, t);
  if (status < 0) return status;
  status = nsdae_dae_start(e->dae, t, t + e->stepper->options->dt, e->y, e->yp, &code);
  if (status < 0) return integrator_failed(e, status, t, code);
  status = nsdae_event_set_roots(e, t);
  e->ahead = t;
  e->pending = 0;
  return status;
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
  memcpy(e->mode_before, e->mode, (size_t)d->k * sizeof *e->mode);
  memcpy(e->slide_mode_before, e->slide_mode, (size_t)d->f * sizeof *e->mode);
  int before = s->impacts + s->changes, status = restart(e, t);
  for (int i = 0; i < d->k && status == NSDAE_OK; i++)
    add_change(s, t, i, -1, e->mode_before[i], e->mode[i]);
  for (int j = 0; j < d->f && status == NSDAE_OK; j++)
    add_change(s, t, -1, j, e->slide_mode_before[j], e->slide_mode[j]);
  e->idle += s->impacts + s->changes == before;
  return status;
}

/* Whether the lists of impacts and changes hold what one more instant may add. */
static int room(const nsdae_stepper *s)
{
  const nsdae_dims *d = &s->system->dims;
  return s->impacts + d->k <= s->impacts_max && s->changes + d->k + d->f <= s->changes_max;
}

/* From the state of the step's start: at the beginning, and after a step that failed. */
static int begin(nsdae_event_method *e)
{
  nsdae_stepper *s = e->stepper;
  const nsdae_dims *d = &s->system->dims;
  memset(e->y, 0, (size_t)e->n * sizeof *e->y);
  memset(e->mode, 0, (size_t)d->k * sizeof *e->mode);
  memset(e->found, 0, (size_t)e->roots * sizeof *e->found);
  memset(e->slide_mode, 0, (size_t)d->f * sizeof *e->slide_mode);
  memset(e->slide_sense, 0, (size_t)d->f * sizeof *e->slide_sense);
  for (int j = 0; j < d->f; j++) e->normal_sense[j] = 1;
  for (int i = 0; i < d->k; i++) {
    e->last[i] = -INFINITY;
    e->interval[i] = INFINITY;
    e->shrunk[i] = e->settling[i] = 0;
  }
  nsdae_contacts_forget(&e->modes);
  memcpy(e->y, s->start.q, (size_t)d->nq * sizeof *e->y);
  memcpy(e->y + d->nq, s->start.v, (size_t)d->nv * sizeof *e->y);
  e->reached = s->start.t;
  e->ahead = -INFINITY;
  return restart(e, s->start.t);
}

/* One step of the integrator, to e->ahead; whether an instant waits there. */
static int integrate(nsdae_event_method *e)
{
  int code = 0, root = 0;
  double from = e->ahead;
  nsdae_error_clear(e->stepper->error);
  int status = nsdae_dae_advance(e->dae, &e->ahead, &root, e->other_found, &code);
  if (status < 0) {
    nsdae_dae_interpolate(e->dae, from, 0, e->y);
    return integrator_failed(e, status, from, code);
  }
  e->stepper->iterations++;
  int watched = nsdae_event_watch_roots(e, e->ahead);
  if (watched < 0) return watched;
  for (int i = 0; root && i < e->roots; i++) e->found[i] |= e->other_found[i] != 0;
  e->pending = root || watched > 0;
  return NSDAE_OK;
}

/* Friction that is asked again and again how it shares between contacts leads nowhere, sooner. */
static int too_many(const nsdae_event_method *e)
{
  return e->endless || e->changes > e->stepper->options->events_max || e->idle > IDLE_MAX;
}

/* To the end of the step, or until a list is nearly full: then the step ends early. */
static int run_to(nsdae_event_method *e, double t_end)
{
  int status = NSDAE_OK;
  while (status == NSDAE_OK && e->reached < t_end && room(e->stepper) && !too_many(e)) {
    if (!(e->ahead > e->reached)) status = integrate(e);
    if (status < 0) break;
    double to = fmin(e->ahead, t_end);
    status = nsdae_event_account(e, e->reached, to);
    e->reached = to;
    if (status < 0 || !e->pending || to < e->ahead) continue;
    status = nsdae_dae_interpolate(e->dae, to, 0, e->y);
    if (status == NSDAE_OK) status = go_through(e, to);
  }
  return status;
}

static void clear_step(nsdae_event_method *e)
{
  const nsdae_dims *d = &e->stepper->system->dims;
  memset(e->multiplier, 0, (size_t)d->m * sizeof *e->multiplier);
  memset(e->normal, 0, (size_t)d->k * sizeof *e->normal);
  memset(e->tangential, 0, (size_t)(d->k * d->nt) * sizeof *e->tangential);
  memset(e->friction, 0, (size_t)d->f * sizeof *e->friction);
  e->work = 0;
  e->changes = e->idle = e->endless = e->settled = 0;
  e->stepper->impacts = e->stepper->changes = 0;
  e->stepper->worst_residual = 0;
}

/* What the step did, for the record. */
static int read_results(nsdae_event_method *e, double h)
{
  nsdae_stepper *s = e->stepper;
  nsdae_contacts *c = &s->contacts;
  const nsdae_dims *d = &s->system->dims;
  int status = NSDAE_OK;
  if (e->ahead > e->reached || e->ahead > e->instant)
    status = nsdae_dae_interpolate(e->dae, e->reached, 0, e->y);
  if (status < 0) return status;
  nsdae_terms_at(&s->end, e->reached, e->y, e->y + d->nq);
  for (int i = 0; i < d->m; i++) s->multiplier[i] = e->multiplier[i] / h;
  memcpy(c->normal, e->normal, (size_t)d->k * sizeof *c->normal);
  memcpy(c->tangential, e->tangential, (size_t)(d->k * d->nt) * sizeof *c->tangential);
  memcpy(c->mode, e->mode, (size_t)d->k * sizeof *c->mode);
  memcpy(c->slide_impulse, e->friction, (size_t)d->f * sizeof *c->slide_impulse);
  memcpy(c->slide_mode, e->slide_mode, (size_t)d->f * sizeof *c->slide_mode);
  s->work = e->work;
  s->smooth = e->changes == 0;
  s->events += e->changes;
  s->accumulations += e->settled;
  s->changed = e->changes;
  s->settled = e->settled;
  return status;
}

/* So many instants in one step that it is no accumulation: the step by implicit instead. */
static int step_over(nsdae_event_method *e, double h)
{
  nsdae_stepper *s = e->stepper;
  s->fallbacks++;
  s->stepped_over = 1;
  s->impacts = s->changes = 0;
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
