/* Event-driven integration: smooth phases by SUNDIALS IDA (event_phase.c) up to the instants where
 * a contact closes, opens, sticks or slips, which its root functions find (event_roots.c); there
 * the laws of impact and contact decide how it goes on (event_instant.c). dt is how often the state
 * is recorded, by the integrator's own interpolation, and its longest step.
 *
 * Impulses of forces over a step are Gauss' integrals of the integrator's polynomials, three points
 * to a piece, which is exact for its highest order. */
#include "event.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "errors.h"
#include "vector.h"

enum { IDLE_MAX = 100 };

static void count_sizes(nsdae_event_method *e)
{
  const nsdae_dims *d = &e->stepper->system->dims;
  e->n = nsdae_at_slide(d) + d->f;
  e->roots = 2 * d->k + 2 * d->f;
}

static void layout_rows(nsdae_row_set *s, long n, long k, nsdae_arena *arena)
{
  s->taken = NSDAE_ARENA_INTS(arena, n);
  s->dependent = NSDAE_ARENA_INTS(arena, n);
  s->rank_before = NSDAE_ARENA_INTS(arena, n);
  s->seen = NSDAE_ARENA_INTS(arena, n);
  s->normal = NSDAE_ARENA_INTS(arena, n);
  s->unknown = NSDAE_ARENA_INTS(arena, n);
  s->pivot = NSDAE_ARENA_INTS(arena, n);
  s->solved_mode = NSDAE_ARENA_INTS(arena, k);
  s->factor = NSDAE_ARENA_DOUBLES(arena, n * n);
  s->combination = NSDAE_ARENA_DOUBLES(arena, n * n);
  s->relation = NSDAE_ARENA_DOUBLES(arena, n * n);
  s->system = NSDAE_ARENA_DOUBLES(arena, n * n);
  s->force = NSDAE_ARENA_DOUBLES(arena, n);
  s->weight = NSDAE_ARENA_DOUBLES(arena, n);
  s->emphasis = NSDAE_ARENA_DOUBLES(arena, k);
  s->solved = NSDAE_ARENA_DOUBLES(arena, n);
  s->shift = NSDAE_ARENA_DOUBLES(arena, n);
}

static void layout_phase(nsdae_event_method *e, nsdae_arena *arena)
{
  const nsdae_dims *d = &e->stepper->system->dims;
  long k = d->k, kt = k * d->nt, f = d->f;
  e->y = NSDAE_ARENA_DOUBLES(arena, e->n);
  e->yp = NSDAE_ARENA_DOUBLES(arena, e->n);
  e->order = NSDAE_ARENA_DOUBLES(arena, e->n);
  e->other = NSDAE_ARENA_DOUBLES(arena, e->n);
  e->r = NSDAE_ARENA_DOUBLES(arena, e->n);
  e->at = NSDAE_ARENA_DOUBLES(arena, e->n);
  e->K = NSDAE_ARENA_DOUBLES(arena, (long)e->n * e->n);
  e->zero = NSDAE_ARENA_DOUBLES(arena, e->n);
  e->pivot = NSDAE_ARENA_INTS(arena, e->n);
  e->mode = NSDAE_ARENA_INTS(arena, k);
  e->mode_before = NSDAE_ARENA_INTS(arena, k);
  e->slide_mode_before = NSDAE_ARENA_INTS(arena, f);
  e->direction = NSDAE_ARENA_DOUBLES(arena, kt);
  e->slip = NSDAE_ARENA_DOUBLES(arena, kt);
  e->slide_mode = NSDAE_ARENA_INTS(arena, f);
  e->slide_sense = NSDAE_ARENA_INTS(arena, f);
  e->normal_sense = NSDAE_ARENA_INTS(arena, f);
  e->independent = NSDAE_ARENA_INTS(arena, d->m);
  e->relation = NSDAE_ARENA_INTS(arena, k + kt);
  e->slide_row = NSDAE_ARENA_INTS(arena, f);
  e->slide_part = NSDAE_ARENA_DOUBLES(arena, f);
  layout_rows(&e->rows, k + kt + f, k, arena);
  e->root = nsdae_arena_take(arena, e->roots, sizeof *e->root);
  e->found = NSDAE_ARENA_INTS(arena, e->roots);
  e->other_found = NSDAE_ARENA_INTS(arena, e->roots);
}

static void layout_instant(nsdae_event_method *e, nsdae_arena *arena)
{
  const nsdae_dims *d = &e->stepper->system->dims;
  long k = d->k, rows = d->m + k * (1 + d->nt) + d->f;
  nsdae_contacts_layout(&e->modes, arena);
  e->sliding_sense = NSDAE_ARENA_INTS(arena, d->f);
  e->projector.n = d->nv;
  e->projector.m = (int)rows;
  nsdae_kkt_layout(&e->projector, arena);
  e->J = NSDAE_ARENA_DOUBLES(arena, 2 * rows * d->nv);
  e->c = NSDAE_ARENA_DOUBLES(arena, rows);
  e->a = NSDAE_ARENA_DOUBLES(arena, d->nv);
  e->lambda = NSDAE_ARENA_DOUBLES(arena, d->m);
  e->touching = NSDAE_ARENA_INTS(arena, k);
  e->candidate = NSDAE_ARENA_INTS(arena, k);
  e->released = NSDAE_ARENA_INTS(arena, k);
  e->breakaway = NSDAE_ARENA_INTS(arena, k);
  e->moving = NSDAE_ARENA_INTS(arena, k);
  e->slide_breakaway = NSDAE_ARENA_INTS(arena, d->f);
  e->velocity = NSDAE_ARENA_DOUBLES(arena, k);
  e->last = NSDAE_ARENA_DOUBLES(arena, k);
  e->interval = NSDAE_ARENA_DOUBLES(arena, k);
  e->rest = NSDAE_ARENA_DOUBLES(arena, k);
  e->shrunk = NSDAE_ARENA_INTS(arena, k);
  e->settling = NSDAE_ARENA_INTS(arena, k);
}

static void layout(void *object, nsdae_arena *arena)
{
  nsdae_event_method *e = object;
  const nsdae_dims *d = &e->stepper->system->dims;
  layout_phase(e, arena);
  layout_instant(e, arena);
  e->multiplier = NSDAE_ARENA_DOUBLES(arena, d->m);
  e->normal = NSDAE_ARENA_DOUBLES(arena, d->k);
  e->tangential = NSDAE_ARENA_DOUBLES(arena, d->k * d->nt);
  e->friction = NSDAE_ARENA_DOUBLES(arena, d->f);
}

/* Laws of the problem of accelerations. A polygon is put around the friction cone, so that a
 * contact that would leave it does slide. */
static int prepare_modes(nsdae_event_method *e)
{
  const nsdae_stepper *s = e->stepper;
  const nsdae_dims *d = &s->system->dims;
  int edges = s->options->polygon;
  e->resting = calloc((size_t)d->k + 1, sizeof *e->resting);
  e->law = calloc((size_t)d->k + 1, sizeof *e->law);
  if (!e->resting || !e->law) return NSDAE_E_MEMORY;
  e->modes.system = s->system;
  e->modes.error = s->error;
  e->modes.lcp_options = s->contacts.lcp_options;
  e->modes.law = e->law;
  nsdae_contacts_laws(&e->modes, edges);
  for (int i = 0; i < d->k; i++)
    if (e->law[i].kind == NSDAE_POLYGON)
      e->law[i] = nsdae_law_make(d->nt, e->law[i].mu / cos(acos(-1) / edges), edges);
  memcpy(e->resting, e->law, (size_t)d->k * sizeof *e->law);
  e->projector.rank_tol = s->options->rank_tol;
  return NSDAE_OK;
}

static int make(nsdae_event_method *e)
{
  const nsdae_sim_options *o = e->stepper->options;
  const nsdae_dims *d = &e->stepper->system->dims;
  count_sizes(e);
  int status = prepare_modes(e);
  if (status == NSDAE_OK) status = nsdae_arena_build(&e->arena, layout, e);
  if (status < 0) return status;
  e->modes.slide_sense = e->sliding_sense;
  for (int i = 0; i < nsdae_at_lambda(d); i++) e->order[i] = 1;
  const nsdae_dae_problem problem = {.n = e->n,
                                     .roots = e->roots,
                                     .sparse = o->linear_solver == NSDAE_LINEAR_KLU,
                                     .order = e->order,
                                     .residual = nsdae_event_residual,
                                     .jacobian = nsdae_event_jacobian,
                                     .root = nsdae_event_root,
                                     .user = e};
  return nsdae_dae_create(&problem, o->rtol, o->atol, o->dt, &e->dae);
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
  nsdae_dae_destroy(&e->dae);
  nsdae_arena_release(&e->arena);
  free(e->resting);
  free(e->law);
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

/* The instant t at the state e->y: what happens there, and the start of the next phase. */
static int restart(nsdae_event_method *e, double t)
{
  int code = 0, status = nsdae_event_instant(e, t);
  if (status < 0) return status;
  nsdae_event_set_terms(e);
  nsdae_error_clear(e->stepper->error);
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

/* Power of the friction of what slides, at the state y and the terms there. */
static double friction_power(const nsdae_event_method *e, const double *y)
{
  const nsdae_terms *T = &e->stepper->middle;
  const nsdae_dims *d = &T->system->dims;
  int n = d->nv;
  double power = 0;
  for (int j = 0; j < d->k * d->nt && (e->terms & NSDAE_TERM_TANGENT); j++)
    if (e->mode[j / d->nt] == NSDAE_SLIDE)
      power += y[nsdae_at_tangential(d) + j] *
               (nsdae_dot(n, T->W_T + (size_t)(j * n), T->v) + T->w_T[j]);
  for (int j = 0; j < d->f; j++)
    if (e->slide_mode[j] == NSDAE_SLIDE)
      power +=
          y[nsdae_at_slide(d) + j] * (nsdae_dot(n, T->W_S + (size_t)(j * n), T->v) + T->w_S[j]);
  return power;
}

/* Multipliers lambda of least norm with the same Phi_q^T lambda, where constraints are redundant.
 */
static int least_norm(nsdae_event_method *e, double t, const double *y, double *lambda)
{
  nsdae_stepper *s = e->stepper;
  nsdae_terms *T = &s->middle;
  const nsdae_dims *d = &s->system->dims;
  int redundant = 0;
  for (int i = 0; i < d->m; i++) redundant |= !e->independent[i];
  if (!redundant) return NSDAE_OK;
  nsdae_terms_at(T, t, y, y + d->nq);
  int status = nsdae_terms_need(T, NSDAE_TERM_MASS | NSDAE_TERM_JACOBIAN);
  if (status == NSDAE_OK) status = nsdae_stepper_factor(s, T, T->M);
  if (status < 0) return status;
  memset(s->r, 0, (size_t)d->nv * sizeof *s->r);
  nsdae_add_transposed(d->m, d->nv, 1, T->J, lambda, s->r);
  memset(lambda, 0, (size_t)d->m * sizeof *lambda);
  nsdae_kkt_solve(&s->kkt, 1, s->r, d->nv, lambda, d->m);
  return NSDAE_OK;
}

static void add_scaled(int n, double scale, const double *a, double *sum)
{
  for (int i = 0; i < n; i++) sum[i] += scale * a[i];
}

/* Integrals of the forces and of the friction's power over a piece of one step of the integrator.
 * Without contacts and friction the integrator's multipliers are good enough for their mean. */
static int account(nsdae_event_method *e, double from, double to)
{
  static const double at[3] = {0.1127016653792583, 0.5, 0.8872983346207417};
  static const double weight[3] = {5.0 / 18, 8.0 / 18, 5.0 / 18};
  const nsdae_dims *d = &e->stepper->system->dims;
  const double *y = e->at;
  int status = NSDAE_OK, exact = (e->terms & (NSDAE_TERM_NORMAL | NSDAE_TERM_SLIDE)) != 0;
  for (int g = 0; (exact || d->m > 0) && g < 3; g++) {
    double t = from + at[g] * (to - from), h = weight[g] * (to - from);
    status = nsdae_dae_interpolate(e->dae, t, 0, e->at);
    if (status == NSDAE_OK && exact) status = nsdae_event_forces(e, t, e->at);
    if (status == NSDAE_OK && exact) e->work += h * friction_power(e, y);
    if (status == NSDAE_OK) status = least_norm(e, t, y, e->at + nsdae_at_lambda(d));
    if (status < 0) break;
    add_scaled(d->m, h, y + nsdae_at_lambda(d), e->multiplier);
    add_scaled(d->k, h, y + nsdae_at_normal(d), e->normal);
    add_scaled(d->k * d->nt, h, y + nsdae_at_tangential(d), e->tangential);
    add_scaled(d->f, h, y + nsdae_at_slide(d), e->friction);
  }
  return status;
}

/* Friction that is asked again and again how it shares between contacts leads nowhere, sooner. */
static int too_many(const nsdae_event_method *e)
{
  return e->changes > e->stepper->options->events_max || e->idle > IDLE_MAX;
}

/* To the end of the step, or until a list is nearly full: then the step ends early. */
static int run_to(nsdae_event_method *e, double t_end)
{
  int status = NSDAE_OK;
  while (status == NSDAE_OK && e->reached < t_end && room(e->stepper) && !too_many(e)) {
    if (!(e->ahead > e->reached)) status = integrate(e);
    if (status < 0) break;
    double to = fmin(e->ahead, t_end);
    status = account(e, e->reached, to);
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
  e->changes = e->idle = e->settled = 0;
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
