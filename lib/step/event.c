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

static int create(nsdae_stepper *s, void **own)
{
  nsdae_event_method *e = calloc(1, sizeof *e);
  *own = e;
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

static void destroy(void *own)
{
  nsdae_event_method *e = own;
  if (!e) return;
  nsdae_event_release(e);
  free(e);
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

static void add_change(nsdae_result *r, double t, int contact, int slide, int before, int after)
{
  if (before != after) r->change[r->changes++] = (nsdae_change){t, contact, slide, before, after};
}

/* The same in the middle of a run, where a change of mode is told. */
static int go_through(nsdae_event_method *e, double t)
{
  nsdae_stepper *s = e->stepper;
  const nsdae_dims *d = &s->system->dims;
  memcpy(e->mode_before, e->mode, (size_t)d->k * sizeof *e->mode);
  memcpy(e->slide_mode_before, e->slide_mode, (size_t)d->f * sizeof *e->mode);
  nsdae_result *r = e->result;
  int before = r->impacts + r->changes, status = restart(e, t);
  for (int i = 0; i < d->k && status == NSDAE_OK; i++)
    add_change(r, t, i, -1, e->mode_before[i], e->mode[i]);
  for (int j = 0; j < d->f && status == NSDAE_OK; j++)
    add_change(r, t, -1, j, e->slide_mode_before[j], e->slide_mode[j]);
  e->idle += r->impacts + r->changes == before;
  return status;
}

/* Whether the lists of impacts and changes hold what one more instant may add. */
static int room(const nsdae_result *r)
{
  const nsdae_dims *d = &r->end.system->dims;
  return r->impacts + d->k <= r->impacts_max && r->changes + d->k + d->f <= r->changes_max;
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
  const nsdae_terms *start = e->state->terms;
  memset(e->warm, 0, nsdae_contacts_memory_size(&e->modes) * sizeof *e->warm);
  memcpy(e->y, start->q, (size_t)d->nq * sizeof *e->y);
  memcpy(e->y + d->nq, start->v, (size_t)d->nv * sizeof *e->y);
  e->reached = start->t;
  e->ahead = -INFINITY;
  return restart(e, start->t);
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
  e->result->counters.iterations++;
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
  while (status == NSDAE_OK && e->reached < t_end && room(e->result) && !too_many(e)) {
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
}

/* What the step did, for the record. */
static int read_results(nsdae_event_method *e, double h)
{
  nsdae_result *r = e->result;
  nsdae_impulses *to = &r->impulses;
  const nsdae_dims *d = &e->stepper->system->dims;
  int status = NSDAE_OK;
  if (e->ahead > e->reached || e->ahead > e->instant)
    status = nsdae_dae_interpolate(e->dae, e->reached, 0, e->y);
  if (status < 0) return status;
  nsdae_terms_at(&r->end, e->reached, e->y, e->y + d->nq);
  for (int i = 0; i < d->m; i++) r->multiplier[i] = e->multiplier[i] / h;
  nsdae_impulses_clear(to, d); /* what an impact left */
  memcpy(to->normal, e->normal, (size_t)d->k * sizeof *to->normal);
  memcpy(to->tangential, e->tangential, (size_t)d->k * (size_t)d->nt * sizeof *to->tangential);
  memcpy(to->mode, e->mode, (size_t)d->k * sizeof *to->mode);
  memcpy(to->slide_impulse, e->friction, (size_t)d->f * sizeof *to->slide_impulse);
  memcpy(to->slide_mode, e->slide_mode, (size_t)d->f * sizeof *to->slide_mode);
  r->located = 1;
  r->work = e->work;
  r->smooth = e->changes == 0;
  r->counters.events = e->changes;
  r->counters.accumulations = e->settled;
  return status;
}

static int advance(void *own, const nsdae_state *state, double t_end, nsdae_result *result)
{
  nsdae_event_method *e = own;
  int status = NSDAE_OK, stands = e->stamp > 0 && e->stamp == state->memory->stamp;
  e->state = state;
  e->result = result;
  e->stamp = 0;
  nsdae_contacts_remember(&e->stepper->contacts, result->memory.whole);
  clear_step(e);
  if (!stands) status = begin(e);
  if (status == NSDAE_OK) status = run_to(e, t_end);
  if (status < 0) return status;
  result->given_up = too_many(e);
  if (result->given_up) return NSDAE_OK;
  status = read_results(e, e->reached - state->terms->t);
  nsdae_error_clear(e->stepper->error);
  if (status == NSDAE_OK) result->memory.stamp = e->stamp = ++e->stamps;
  return status;
}

const nsdae_stepping nsdae_stepping_event = {
    .name = "event",
    .summary = "event-driven on SUNDIALS IDA: impacts, stick and slip located exactly",
    .create = create,
    .destroy = destroy,
    .sizes = nsdae_stepper_sizes,
    .advance = advance};
