/* Event-driven integration: smooth phases with error control up to the instants where a contact
 * closes, opens, sticks or slips, which its root functions find; there the laws of impact and
 * contact decide how it goes on. dt is how often the state is recorded, by the integrator's own
 * interpolation, and its longest step. */
#include <float.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "errors.h"
#include "event_method.h"

/* Instants in one dt without an impact or a change of mode; steps of the integrator after which it
 * starts anew, so that a way back is not longer. */
enum { IDLE_MAX = 500, STEPS_MAX = 5000, STIFF_STEPS = 300 };

/* In place of the steps since the base: there is none, the next step begins at the state. */
enum { ANEW = -1 };

/* Steps shorter than this part of dt lead nowhere: the most of them in one dt, and at each start.
 */
static const double TINY = 1e-6;
enum { TINY_MAX = 1000, STARTS = 50 };

/* After each KINK_STEPS of them a kink is looked for, KINK_AHEAD of them ahead: a step that fails
 * is tried again with an eighth of its length. */
enum { KINK_STEPS = 25, KINK_AHEAD = 16 };

static void layout(void *object, nsdae_arena *arena)
{
  nsdae_event *e = object;
  const nsdae_dims *d = &e->setting.system->dims;
  nsdae_event_phase_layout(&e->phase, arena);
  nsdae_event_roots_layout(&e->roots, arena);
  nsdae_event_integrator_layout(&e->integrator, arena);
  nsdae_event_account_layout(&e->account, arena);
  nsdae_event_acceleration_layout(&e->instant.acceleration, arena);
  nsdae_event_impacts_layout(&e->instant.impacts, arena);
  nsdae_event_projection_layout(&e->instant.projection, arena);
  e->mode_before = NSDAE_ARENA_INTS(arena, d->k);
  e->slide_mode_before = NSDAE_ARENA_INTS(arena, d->f);
}

/* Each part to those that it stands on. */
static void connect(nsdae_event *e, nsdae_stepper *s)
{
  e->tools = s;
  e->setting = (nsdae_event_setting){.system = s->system,
                                     .options = s->options,
                                     .error = s->error,
                                     .here = &s->middle,
                                     .kkt = &s->kkt};
  nsdae_event_set_places(&e->setting);
  e->setting.tracking = &e->integrator.tracking;
  e->phase.setting = &e->setting;
  e->roots.phase = &e->phase;
  e->integrator.roots = &e->roots;
  e->account.phase = &e->phase;
  e->integrator.account = &e->account;
  e->instant.roots = &e->roots;
  e->instant.acceleration.phase = &e->phase;
  e->instant.projection.phase = &e->phase;
  e->instant.impacts.acceleration = &e->instant.acceleration;
  e->instant.impacts.account = &e->account;
  e->instant.impacts.accumulation.acceleration = &e->instant.acceleration;
  e->instant.impacts.accumulation.projection = &e->instant.projection;
}

static void prepare_problems(nsdae_event *e)
{
  nsdae_event_acceleration_prepare(&e->instant.acceleration);
  nsdae_event_impacts_prepare(&e->instant.impacts);
}

static int make(nsdae_event *e)
{
  prepare_problems(e);
  int status = nsdae_arena_build(&e->arena, layout, e);
  if (status < 0) return status;
  prepare_problems(e);
  nsdae_event_roots_name(&e->roots);
  status = nsdae_cones_open(&e->instant.acceleration.problem.cones);
  if (status == NSDAE_OK) status = nsdae_cones_open(&e->instant.impacts.problem.cones);
  return status < 0 ? status : nsdae_event_integrator_make(&e->integrator);
}

static int create(nsdae_stepper *s, void **own)
{
  nsdae_event *e = calloc(1, sizeof *e);
  *own = e;
  int status = NSDAE_E_MEMORY;
  if (e) {
    connect(e, s);
    status = make(e);
  }
  return nsdae_stepper_made(s, status, "event");
}

static void destroy(void *own)
{
  nsdae_event *e = own;
  if (!e) return;
  nsdae_event_integrator_release(&e->integrator);
  nsdae_cones_close(&e->instant.acceleration.problem.cones);
  nsdae_cones_close(&e->instant.impacts.problem.cones);
  nsdae_least_release(&e->instant.projection.least);
  nsdae_arena_release(&e->arena);
  free(e);
}

static int goes_by_ida(const nsdae_event *e)
{
  return e->setting.options->integrator == NSDAE_INTEGRATOR_IDA;
}

/* From a state that this method did not lead to. */
static int begin(nsdae_event *e, const nsdae_terms *from)
{
  const nsdae_memory *memory = &e->setting.result->memory;
  const nsdae_dims *d = &e->setting.system->dims;
  double *y = e->integrator.y;
  memset(memory->real, 0, memory->reals * sizeof *memory->real);
  memset(memory->whole, 0, memory->wholes * sizeof *memory->whole);
  int status = nsdae_event_slots_begin(e, from);
  if (status < 0) return status;
  memset(y, 0, (size_t)e->setting.at.n * sizeof *y);
  e->integrator.smooth.steps.h = 0;
  for (int j = 0; j < d->f; j++) e->phase.modes.normal_sense[j] = 1;
  nsdae_event_blur(e);
  for (int i = 0; i < e->roots.count; i++) e->roots.entry[i].found = 0;
  memcpy(y, from->q, (size_t)d->nq * sizeof *y);
  memcpy(y + d->nq, from->v, (size_t)d->nv * sizeof *y);
  status = nsdae_event_tune(e, from->t);
  return status < 0 ? status : nsdae_event_restart(e, from->t);
}

static int strayed(nsdae_event *e, double t)
{
  nsdae_event_integrator *g = &e->integrator;
  int due = nsdae_event_strayed(&e->instant, t, g->y);
  if (due != 2 && due != NSDAE_E_CONVERGENCE) return due;
  int kink = nsdae_event_explain_strayed(&e->instant, e->roots.at); /* of a drift alone: no error */
  return kink < 0 ? kink : 1;
}

/* One step of the integrator. An instant is also due where the equations of the phase are no longer
 * the right ones, or their solution has strayed from what is closed. */
static int step(nsdae_event *e)
{
  nsdae_event_integrator *g = &e->integrator;
  int status = nsdae_event_integrator_advance(g);
  int due = status < 0 ? status : nsdae_event_turned(&e->instant, g->ahead, g->y);
  if (due == 0) due = strayed(e, g->ahead);
  if (due > 0) g->pending = 1;
  return due < 0 ? due : NSDAE_OK;
}

/* Why no step succeeds: at the end of the last one that did, with the forces there. */
static int explain(nsdae_event *e, int status)
{
  nsdae_error kept = *e->setting.error;
  nsdae_event_forces(&e->phase, e->integrator.ahead, e->integrator.y);
  *e->setting.error = kept;
  return nsdae_event_failed(e, status, e->integrator.ahead);
}

/* No step of the integrator is short enough at t, where its y is: the gap of a closed contact may
 * have a kink just ahead. The least step of Euler from which one is seen is taken, at the same
 * time: q + h q'. v and the forces in y stay: no time passes, so there is no impulse.
 * Returns 1 where it is, else 0. */
static int cross_kink(nsdae_event *e, double t)
{
  nsdae_event_integrator *g = &e->integrator;
  nsdae_terms *T = e->setting.here;
  const nsdae_event_places *at = &e->setting.at;
  double *from = g->z, *rate = g->later,
         longest = (double)KINK_AHEAD * TINY * e->setting.options->dt;
  int found = 0;
  if (!(e->phase.terms & NSDAE_TERM_NORMAL)) return 0;
  memcpy(from, g->y, (size_t)at->lambda * sizeof *from);
  if (nsdae_event_forces(&e->phase, t, g->y) < 0 || nsdae_kinematics_at(T, T->v, rate) < 0)
    return 0;
  if (nsdae_event_unbounded(&e->roots, NSDAE_EVENT_POLE) >= 0) return 0;
  for (double h = 64 * DBL_EPSILON * (fabs(t) + longest); !found && h < longest; h *= 8) {
    nsdae_move(at->v, from, h, rate, g->y);
    found = strayed(e, t);
  }
  if (found <= 0) memcpy(g->y, from, (size_t)at->lambda * sizeof *from);
  return found > 0;
}

/* Whether rows of the phase are redundant at t, where no step of it succeeds. */
static int lost_rank(nsdae_event *e, double t)
{
  nsdae_event_setting *s = &e->setting;
  int rank = s->system->dims.m - *e->phase.modes.redundant, refused = s->error->status;
  double sine;
  if (rank < 1 || (refused != NSDAE_OK && refused != NSDAE_E_CONVERGENCE)) return 0;
  nsdae_event_move(s, t, e->integrator.y);
  if (nsdae_event_sine(s, rank, &sine) < 0 || s->kkt->rank == rank) return 0;
  nsdae_error_clear(s->error);
  return 1;
}

/* The integrator's y at t, which it has reached. Where it has just started that is the state. */
static int read_state(nsdae_event *e, double t)
{
  nsdae_event_integrator *g = &e->integrator;
  return *e->base.steps > 0 ? nsdae_event_integrator_read(g, t, g->y) : NSDAE_OK;
}

/* Whether a list had no room, or a contact no slot, since the step began. */
static int lacks_room(const nsdae_event *e)
{
  const nsdae_tracked *tracked = e->setting.system->tracked;
  const nsdae_room *wanted = e->tools->differences.by_id.wanted;
  return wanted[0].entries > 0 || wanted[1].entries > 0 ||
         (tracked && tracked->wanted > e->setting.system->dims.k);
}

static int integrate(nsdae_event *e)
{
  nsdae_event_integrator *g = &e->integrator;
  double from = g->ahead, tiny = TINY * e->setting.options->dt;
  if (!g->smooth.is_stiff && g->smooth.steps.last > 0 && g->smooth.steps.last < tiny &&
      *e->base.tiny % KINK_STEPS == 0 && read_state(e, from) == NSDAE_OK && cross_kink(e, from))
    return nsdae_event_change_modes(e, from);
  int status = step(e);
  nsdae_event_slots_settle(e);
  ++*e->base.steps;
  *e->base.tiny += g->ahead - from < tiny;
  if (status == NSDAE_OK || lacks_room(e)) return status;
  g->ahead = from;
  if (nsdae_event_integrator_read(g, from, g->y) < 0) return nsdae_event_failed(e, status, from);
  if (!g->smooth.is_stiff || goes_by_ida(e)) {
    g->pending = lost_rank(e, from);
    int refused = e->setting.error->status != NSDAE_OK; /* by a callback: no stop */
    if (g->pending || refused) return g->pending ? NSDAE_OK : explain(e, status);
    g->pending = nsdae_event_stop_slow(&e->roots, from, g->y) > 0;
    if (!g->pending && cross_kink(e, from)) return nsdae_event_change_modes(e, from);
    return g->pending ? NSDAE_OK : explain(e, status);
  }
  *e->phase.modes.integrator = NSDAE_INTEGRATOR_DOPRI5; /* a pair may solve what IDA does not */
  return nsdae_event_start(e, from);
}

/* From the base to the state again: 1; 0 where callbacks do not give the same numbers as then; < 0
 * where one fails, as in any step. */
static int replay(nsdae_event *e, const nsdae_terms *to)
{
  nsdae_event_integrator *g = &e->integrator;
  const nsdae_dims *d = &to->system->dims;
  int steps = *e->base.steps;
  nsdae_event_restore(&e->base, g);
  g->again = 1;
  int status = nsdae_event_integrator_start(g, *e->base.t);
  for (int i = 0; i < steps && status == NSDAE_OK && !(g->ahead > to->t); i++) status = step(e);
  g->again = 0;
  if (lacks_room(e)) return NSDAE_ARRAYS_GROW;
  if (status < 0 && e->setting.error->status == NSDAE_E_CALLBACK) return NSDAE_E_CALLBACK;
  if (status < 0 || to->t > g->ahead) return 0;
  return read_state(e, to->t) == NSDAE_OK &&
         memcmp(g->y, to->q, (size_t)d->nq * sizeof *g->y) == 0 &&
         memcmp(g->y + d->nq, to->v, (size_t)d->nv * sizeof *g->y) == 0;
}

/* To where the step starts, if the integrator is not there already. A replay is not counted. */
static int arrive(nsdae_event *e, const nsdae_state *state)
{
  nsdae_counters *counters = &e->setting.result->counters, counted = *counters;
  for (int i = 0; i < 2; i++) {
    e->tools->differences.finer[i] = e->base.finer[i];
    e->setting.error_by_differences[i] = e->base.difference_error[i];
  }
  if (state->memory->stamp > 0 && state->memory->stamp == e->stamp) return NSDAE_OK;
  if (e->setting.options->integrator != NSDAE_INTEGRATOR_AUTO)
    nsdae_event_set_integrator(e); /* the option may be new */
  int anew = state->memory->stamp == 0 || *e->base.steps == ANEW;
  int stands = anew ? 0 : replay(e, state->terms);
  *counters = counted;
  if (stands < 0) return stands;
  nsdae_error_clear(e->setting.error);
  return stands ? NSDAE_OK : begin(e, state->terms);
}

static int has_short_steps(const nsdae_event *e)
{
  return *e->base.tiny > TINY_MAX + STARTS * *e->base.instants;
}

/* Time goes on whatever happens: a dt has a bounded number of events, and of steps that are none.
 * Friction that is asked again and again how it shares between contacts leads nowhere, sooner. */
static int too_many(const nsdae_event *e)
{
  return e->instant.impacts.sequence.endless ||
         *e->base.instants > e->setting.options->events_max || *e->base.idle > IDLE_MAX ||
         has_short_steps(e);
}

/* With auto, the integrator that does better from here on. IDA: if stability bounds the steps, or
 * if CRAWL of them were shorter than TINY in the mean, as where the direction of a slip of nearly
 * zero turns in each stage, which hides the border of stability. DOP853 takes 12 evaluations a
 * step, and three more if it is read inside, DOPRI5 takes six: it is of use if SETTLED steps, by
 * which the first ones have found their length, end with one shorter than 6 / 15 of the longest,
 * less a fifth for the restart, at a small rtol (measured: equal at 1e-6) and while nothing is
 * closed, whose forces may turn or jump within a step. */
static int better_integrator(const nsdae_event *e)
{
  const nsdae_smooth *g = &e->integrator.smooth;
  const double rtol_most = 3e-7, part = 1.0 / 3;
  enum { SETTLED = 10, CRAWL = 150 };
  int now = *e->phase.modes.integrator, steps = *e->base.steps;
  int closed = (e->phase.terms & (NSDAE_TERM_NORMAL | NSDAE_TERM_SLIDE)) != 0;
  if (e->setting.options->integrator != NSDAE_INTEGRATOR_AUTO || e->phase.crossing.count > 0)
    return now;
  if (g->is_stiff) return steps < STIFF_STEPS ? now : NSDAE_INTEGRATOR_DOPRI5;
  int crawls = steps >= CRAWL && e->integrator.ahead - *e->base.t < steps * TINY * g->steps.span;
  if (g->ida && (crawls || nsdae_smooth_stiff(g))) return NSDAE_INTEGRATOR_IDA;
  int fine = !closed && g->steps.rtol <= rtol_most && g->steps.last < part * g->steps.max_step;
  return fine && steps >= SETTLED ? NSDAE_INTEGRATOR_DOP853 : now;
}

/* Whether an integrator starts anew here. */
static int change_integrator(nsdae_event *e)
{
  int better = better_integrator(e), *now = e->phase.modes.integrator;
  int most = e->integrator.smooth.is_stiff ? STIFF_STEPS : STEPS_MAX;
  if (better == *now && *e->base.steps < most) return 0;
  *now = better;
  return 1;
}

static int advance_from(nsdae_event *e)
{
  nsdae_event_integrator *g = &e->integrator;
  if (g->ahead > e->reached) return NSDAE_OK;
  if (!change_integrator(e)) return integrate(e);
  int status = nsdae_event_integrator_read(g, g->ahead, g->y);
  return status < 0 ? status : nsdae_event_start(e, g->ahead);
}

/* To the end of the step, or until a list is nearly full: then the step ends early. */
static int run_to(nsdae_event *e, double t_end)
{
  nsdae_event_integrator *g = &e->integrator;
  int status = NSDAE_OK;
  while (status == NSDAE_OK && e->reached < t_end && nsdae_result_room(e->setting.result) &&
         !too_many(e)) {
    status = advance_from(e);
    if (status == NSDAE_OK)
      status = nsdae_stepper_goes_on(
          e->tools, "nsdae_event",
          "make dt smaller, inner_steps_max or rtol larger, or use method = implicit", g->ahead,
          t_end);
    if (status < 0) break;
    double to = fmin(g->ahead, t_end);
    if (to > e->reached) status = nsdae_event_integrator_account(g, e->reached, to);
    e->reached = to;
    if (status < 0 || !g->pending || to < g->ahead) continue;
    status = nsdae_event_integrator_read(g, to, g->y);
    if (status == NSDAE_OK) status = nsdae_event_go_through(e, to);
  }
  return status;
}

/* What the step did beside its impulses. */
static int read_results(nsdae_event *e, nsdae_terms *from)
{
  nsdae_result *r = e->setting.result;
  const nsdae_event_modes *m = &e->phase.modes;
  const nsdae_dims *d = &e->setting.system->dims;
  int status = read_state(e, e->reached);
  if (status < 0) return status;
  nsdae_terms_at(&r->end, e->reached, e->integrator.y, e->integrator.y + d->nq);
  for (int i = 0; i < d->m; i++) r->multiplier[i] /= e->reached - from->t;
  for (int i = 0; i < d->k; i++) r->impulses.mode[i] = m->contact[i];
  for (int j = 0; j < d->f; j++) r->impulses.frictional_joint_mode[j] = m->frictional_joint[j];
  r->located = 1;
  r->smooth = r->counters.events == 0;
  nsdae_event_move(&e->setting, e->reached, e->integrator.y);
  /* Newton's matrix of IDA may be regular if M or Phi_q is not. */
  if (e->integrator.smooth.is_stiff)
    status = nsdae_terms_need(e->setting.here, NSDAE_TERM_MASS | NSDAE_TERM_JACOBIAN);
  if (e->integrator.smooth.is_stiff && status == NSDAE_OK) status = nsdae_event_factor(&e->setting);
  if (status == NSDAE_OK) status = nsdae_event_slots_show(e, from);
  return status < 0 ? status : nsdae_event_certify(&e->phase, from);
}

static int prepare(void *own)
{
  nsdae_event *e = own;
  prepare_problems(e);
  nsdae_event_integrator_prepare(&e->integrator);
  return NSDAE_OK;
}

static int start_run(void *own, const nsdae_terms *at)
{
  nsdae_event *e = own;
  int status = nsdae_least_reserve(&e->instant.projection.least, at, NSDAE_LEAST_ALL);
  if (status < 0 || !e->integrator.smooth.ida) return status;
  return nsdae_stepper_start(e->tools, &e->phase.newton, at);
}

/* The memory of the result is that of the method, from here on. */
static void open_memory(nsdae_event *e, nsdae_result *result)
{
  e->setting.result = result;
  nsdae_event_lay(&e->base, &e->instant, &e->integrator.tracking, e->tools, &result->memory);
  e->integrator.late = e->base.late;
  if (!e->setting.system->tracked) return;
  nsdae_tracking_load(&e->integrator.tracking);
  e->setting.system->tracked->wanted = 0;
}

static void close_memory(const nsdae_event *e)
{
  nsdae_result *r = e->setting.result;
  const nsdae_tracked *tracked = e->setting.system->tracked;
  if (!tracked) return;
  nsdae_tracking_store(&e->integrator.tracking);
  r->memory.slots = nsdae_tracked_count(tracked, e->setting.system->dims.k);
}

static int check(void *own, nsdae_memory *memory)
{
  nsdae_event *e = own;
  nsdae_event_lay(&e->base, &e->instant, &e->integrator.tracking, e->tools, memory);
  int steps = *e->base.steps >= ANEW && *e->base.steps <= STEPS_MAX;
  return steps && nsdae_tracking_is_valid(&e->integrator.tracking) ? NSDAE_OK : NSDAE_E_ARGUMENT;
}

static int settle(void *own, const nsdae_state *state, nsdae_result *result)
{
  nsdae_event *e = own;
  nsdae_event_integrator *g = &e->integrator;
  double t = state->terms->t;
  open_memory(e, result);
  int status = arrive(e, state);
  e->stamp = 0;
  if (lacks_room(e)) return NSDAE_ARRAYS_GROW;
  if (status == NSDAE_OK && *e->base.steps > 0) {
    status = read_state(e, t);
    if (status == NSDAE_OK) nsdae_event_save(&e->base, g, t);
  }
  close_memory(e);
  return status;
}

/* Modes of motors are found anew. */
static void jump(void *own, nsdae_memory *memory)
{
  nsdae_event *e = own;
  nsdae_event_lay(&e->base, &e->instant, &e->integrator.tracking, e->tools, memory);
  *e->base.steps = ANEW;
}

/* No failure without a text. */
static int tell(const nsdae_event *e, int status)
{
  nsdae_error *error = e->setting.error;
  if (error->status != NSDAE_OK) return status;
  nsdae_error_set(
      error, status, "nsdae_event", "",
      "at t = %g: %s; the equations of closed contacts and constraints have no solution",
      nsdae_terms_time(e->setting.here), nsdae_status_message(status));
  return nsdae_error_at(error, status, -1, nsdae_terms_time(e->setting.here));
}

static int advance(void *own, const nsdae_state *state, double t_end, nsdae_result *result)
{
  nsdae_event *e = own;
  e->reached = state->terms->t;
  e->instant.impacts.sequence.endless = 0;
  open_memory(e, result);
  int status = arrive(e, state);
  e->stamp = 0;
  if (status == NSDAE_OK) status = nsdae_event_slots_trim(e, state->terms);
  if (*e->base.goal != t_end) *e->base.instants = *e->base.idle = *e->base.tiny = 0;
  *e->base.goal = t_end;
  if (status == NSDAE_OK) status = run_to(e, t_end);
  if (status == NSDAE_OK && has_short_steps(e)) /* as in front of a pole of several contacts */
    status = nsdae_event_diagnose(&e->instant.acceleration, e->integrator.ahead, e->integrator.y);
  if (lacks_room(e)) return NSDAE_ARRAYS_GROW;
  if (status < 0) return tell(e, status);
  close_memory(e);
  /* a list that one instant fills leaves no way on either */
  result->given_up = too_many(e) || !(e->reached > state->terms->t);
  if (result->given_up) return NSDAE_OK;
  status = read_results(e, state->terms);
  if (lacks_room(e)) return NSDAE_ARRAYS_GROW;
  if (status < 0) return tell(e, status);
  nsdae_error_clear(e->setting.error); /* of a step that was tried again, smaller */
  result->memory.stamp = e->stamp = ++e->stamps;
  return NSDAE_OK;
}

const nsdae_stepping nsdae_stepping_event = {
    .name = "event",
    .summary =
        "event-driven, smooth phases with error control: impacts, stick and slip located exactly",
    .create = create,
    .destroy = destroy,
    .lay = nsdae_event_memory_lay,
    .prepare = prepare,
    .start = start_run,
    .settle = settle,
    .jump = jump,
    .check = check,
    .advance = advance,
    .track = nsdae_event_slots_anew,
    .tracks = 1};
