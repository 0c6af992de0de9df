/* Continuous contact force (see penalty_law.h), the baseline of Zhang, Gu and Sun, integrated as a
 * smooth system (equations.h) with error control: by an explicit pair, and for stiff equations by
 * IDA. dt is only how often it records.
 *
 * The integrals of the forces are integrated along, so that a step's impulses are as accurate as
 * its state. A gap that closes starts a contact (its d'_0 is the velocity there); when it opens
 * again, what happened in between is an impact. */
#include <float.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "errors.h"
#include "penalty.h"
#include "vector.h"

/* Steps of the integrator after which it starts anew, so that a replay is not longer. IDA takes
 * some twenty steps to come back to its order. */
enum { STEPS_MAX = 5000, STIFF_STEPS_MAX = 300 };

/* Of IDA's last step the first one after a new start. */
static const double FIRST = 0.1;

/* Of the tolerance of a position: less deep between two steps a contact is none. */
static const double DEEP = 0.1;

/* Of a time: two crossings nearer to each other are one (fall.c). */
static const double ROUNDING = 100 * DBL_EPSILON;

/* ---- creation */

static void layout(void *object, nsdae_arena *arena)
{
  nsdae_penalty *p = object;
  const nsdae_dims *d = nsdae_penalty_dims(p);
  p->qv = NSDAE_ARENA_DOUBLES(arena, d->nq + d->nv);
  for (int i = 0; i < 2; i++) p->z[i] = NSDAE_ARENA_DOUBLES(arena, nsdae_penalty_size(d));
  nsdae_arena_doubles(arena, d->k, (double **[]){&p->peak, &p->force, &p->gaps.shift, NULL});
  p->gaps.found = NSDAE_ARENA_INTS(arena, d->k);
  nsdae_penalty_slots_layout(p, arena);
  nsdae_penalty_equations_layout(&p->equations, arena);
  nsdae_smooth_layout(&p->integrator, arena);
  nsdae_fall_layout(&p->gaps.fall, arena);
  nsdae_dip_layout(&p->gaps.dip, arena);
}

/* Whether the law has a force for contact i. */
static int check_law(const nsdae_stepper *s, const char *where, int i)
{
  int flores = s->options->penalty_law == NSDAE_PENALTY_FLORES;
  if (!flores || s->system->contact[i].e_n > 0) return NSDAE_OK;
  nsdae_error_set(s->error, NSDAE_E_ARGUMENT, where, "e_n",
                  "e_n = 0 is outside its range: the law flores needs it greater than 0");
  nsdae_system_name_item(s->system, NSDAE_NAME_CONTACT, i, s->error);
  return NSDAE_E_ARGUMENT;
}

static int prepare(void *own)
{
  nsdae_penalty *p = own;
  const nsdae_sim_options *o = p->equations.stepper->options;
  p->equations.law =
      (nsdae_penalty_force){o->penalty_law, o->penalty_stiffness, o->penalty_exponent};
  p->integrator.steps.rtol = o->rtol;
  p->integrator.steps.atol = o->atol;
  p->integrator.steps.max_step = fmin(o->dt, o->step_max);
  p->integrator.steps.span = o->dt;
  int status = NSDAE_OK, k = nsdae_penalty_is_tracked(p) ? 0 : nsdae_penalty_dims(p)->k;
  for (int i = 0; i < k && status == NSDAE_OK; i++)
    status = check_law(p->equations.stepper, "nsdae_sim_create", i);
  return status;
}

/* Overlaps of closed contacts and gaps of open ones at t in the last step. */
static int values(double t, double *g, void *user)
{
  nsdae_penalty *p = user;
  nsdae_terms *T = &p->equations.stepper->middle;
  double *qv = p->equations.room;
  int status = nsdae_penalty_read(p, t, qv);
  nsdae_terms_at(T, t, qv, qv + nsdae_penalty_dims(p)->nq);
  if (status == NSDAE_OK) status = nsdae_terms_need(T, NSDAE_TERM_GAP);
  for (int i = 0; i < nsdae_penalty_dims(p)->k && status == NSDAE_OK; i++) {
    double gap = T->gap[i] - p->gaps.shift[i];
    g[i] = p->equations.base.closed[i] ? -gap : gap;
  }
  return status;
}

/* Gaps and their rates there. */
static int look(double t, double *gap, double *rate, void *user)
{
  nsdae_penalty *p = user;
  int status = nsdae_penalty_read(p, t, p->equations.room);
  if (status == NSDAE_OK) status = nsdae_penalty_evaluate(&p->equations, t, p->equations.room);
  if (status < 0) return status;
  memcpy(gap, p->equations.stepper->middle.gap, (size_t)nsdae_penalty_dims(p)->k * sizeof *gap);
  memcpy(rate, p->equations.at.v_n, (size_t)nsdae_penalty_dims(p)->k * sizeof *rate);
  return NSDAE_OK;
}

static int make(nsdae_penalty *p)
{
  const nsdae_stepper *s = p->equations.stepper;
  const nsdae_dims *d = nsdae_penalty_dims(p);
  p->integrator.steps = (nsdae_runge_kutta){.n = nsdae_penalty_size(d),
                                            .controlled = nsdae_penalty_at_lambda(d),
                                            .positions = d->nq,
                                            .forces = d->m + d->k * (1 + d->nt) + d->f,
                                            .rate = nsdae_penalty_rate,
                                            .user = &p->equations};
  p->integrator.implicit = (nsdae_ida_problem){.residual = nsdae_penalty_residual,
                                               .setup = nsdae_penalty_setup,
                                               .solve = nsdae_penalty_solve,
                                               .user = &p->equations};
  p->integrator.powers = nsdae_penalty_powers;
  p->gaps.fall = (nsdae_fall){.count = d->k, .values = values, .user = p};
  p->gaps.dip = (nsdae_dip){.count = d->k, .look = look, .user = p};
  int status = nsdae_arena_build(&p->arena, layout, p);
  if (status == NSDAE_OK) status = nsdae_newton_kkt_make(&p->equations.newton);
  return status < 0 ? status : nsdae_smooth_make(&p->integrator, s->options->integrator);
}

static int create(nsdae_stepper *s, void **own)
{
  nsdae_penalty *p = calloc(1, sizeof *p);
  *own = p;
  if (!p) return nsdae_stepper_made(s, NSDAE_E_MEMORY, "penalty");
  p->equations.stepper = s;
  int status = make(p);
  return status < 0 ? nsdae_stepper_made(s, status, "penalty") : prepare(p);
}

static void destroy(void *own)
{
  nsdae_penalty *p = own;
  if (!p) return;
  nsdae_smooth_destroy(&p->integrator);
  nsdae_newton_kkt_release(&p->equations.newton);
  nsdae_arena_release(&p->arena);
  free(p);
}

/* ---- starts */

/* The velocity of the largest change at t, in units of its tolerance; -1: the equations have no
 * solution there, as the error record says. */
static int fastest(nsdae_penalty *p, double t)
{
  const nsdae_sim_options *o = p->equations.stepper->options;
  const double *v = p->qv + nsdae_penalty_dims(p)->nq;
  double *rate = p->z[0], most = 0;
  int found = -1;
  if (nsdae_penalty_rate(t, p->qv, rate, 0, &p->equations) != 0) return -1;
  for (int i = 0; i < nsdae_penalty_dims(p)->nv; i++) {
    double change = fabs(rate[nsdae_penalty_dims(p)->nq + i]) / (o->rtol * fabs(v[i]) + o->atol);
    if (change > most) most = change, found = i;
  }
  return found;
}

static int integrator_failed(nsdae_penalty *p, int status, double t)
{
  nsdae_stepper *s = p->equations.stepper;
  const char *cause = p->integrator.cause;
  if (status == NSDAE_ARRAYS_GROW) return status;
  if (s->error->status != NSDAE_OK) return s->error->status;
  int velocity = fastest(p, t);
  if (s->error->status != NSDAE_OK) return s->error->status;          /* no solution there */
  status = status == NSDAE_E_CALLBACK ? NSDAE_E_CONVERGENCE : status; /* none failed */
  nsdae_error_set(s->error, status, "nsdae_penalty", "rtol",
                  "the integrator failed at t = %.17g: no step length satisfies rtol and atol%s%s: "
                  "try a larger rtol or a smaller penalty_stiffness%s",
                  nsdae_system_time(s->system, t), *cause ? ", reason of SUNDIALS: " : "", cause,
                  velocity < 0 ? "" : "; fastest change");
  s->error->time = nsdae_system_time(s->system, t);
  if (velocity >= 0) nsdae_system_name_item(s->system, NSDAE_NAME_VELOCITY, velocity, s->error);
  return status;
}

/* The largest force applied, or what would stop the bodies in a dt. */
static double force_of(const nsdae_penalty *p)
{
  nsdae_stepper *s = p->equations.stepper;
  const nsdae_terms *T = &s->middle;
  int n = nsdae_penalty_dims(p)->nv;
  memset(s->r, 0, (size_t)n * sizeof *s->r);
  nsdae_blocks_add_product(&s->system->blocks, T->M, T->v, s->r);
  return fmax(nsdae_largest(n, T->F), nsdae_largest(n, s->r) / s->options->dt);
}

/* The integrator starts at qv and the base's t. Within rounding of zero a gap can have the wrong
 * sign for its contact, and would cross zero again at once, without an end: it is looked at from
 * where it has twice that. */
static int start_integrator(nsdae_penalty *p)
{
  const nsdae_penalty_base *b = &p->equations.base;
  nsdae_stepper *s = p->equations.stepper;
  const double hair = 1e-12 * s->options->dt * s->options->friction_velocity;
  nsdae_terms *T = &s->middle;
  p->ahead = *b->t;
  p->gaps.pending = 0;
  nsdae_smooth_set(&p->integrator, *b->is_stiff ? NSDAE_INTEGRATOR_IDA : s->options->integrator);
  p->integrator.first = p->integrator.steps.h = *b->first;
  nsdae_error_clear(s->error);
  nsdae_power_start(&p->equations.power);
  nsdae_dip_start(&p->gaps.dip);
  int status = nsdae_penalty_evaluate(&p->equations, p->ahead, p->qv);
  if (status == NSDAE_OK) status = nsdae_terms_need(T, NSDAE_TERM_MASS | NSDAE_TERM_FORCE);
  if (status < 0) return status;
  p->integrator.steps.force = force_of(p);
  memcpy(p->force, p->equations.at.normal, (size_t)nsdae_penalty_dims(p)->k * sizeof *p->force);
  p->gaps.depth = 0;
  for (int i = 0; i < nsdae_penalty_dims(p)->k; i++) {
    double gap = T->gap[i];
    if (b->closed[i]) p->gaps.depth = fmax(p->gaps.depth, -gap);
    int wrong = b->closed[i] ? gap >= 0 : gap <= 0;
    p->gaps.shift[i] = wrong ? 2 * gap + (b->closed[i] ? hair : -hair) : 0;
  }
  status = nsdae_smooth_start(&p->integrator, p->ahead, p->qv);
  if (status < 0) return integrator_failed(p, status, p->ahead);
  const nsdae_counters counted = *s->counters; /* a start is no work of the step */
  status = nsdae_terms_need(T, NSDAE_TERM_MASS | NSDAE_TERM_JACOBIAN);
  if (status == NSDAE_OK) status = nsdae_stepper_factor(s, T, T->M);
  *s->counters = counted;
  if (status < 0) return status;
  p->equations.rank = s->kkt.rank; /* IDA starts at the point of the last factorisation */
  if (s->kkt.rank < s->kkt.m) nsdae_kkt_basis(&s->kkt, p->equations.basis);
  return NSDAE_OK;
}

/* The base is at t, where q and v are qv, from the last one on. */
static int move_base(nsdae_penalty *p, double t)
{
  nsdae_penalty_base *b = &p->equations.base;
  const nsdae_dims *d = nsdae_penalty_dims(p);
  double *z = p->z[0];
  if (*b->steps > 0) {
    const nsdae_smooth *g = &p->integrator;
    double within = fmax(g->from, fmin(t, g->to));
    int status = nsdae_smooth_read(&p->integrator, within, nsdae_penalty_size(d), z);
    if (status < 0) return status;
    nsdae_add(d->k, 1, z + nsdae_penalty_at_normal(d), b->impulse);
    nsdae_add(d->k * d->nt, 1, z + nsdae_penalty_at_tangential(d), b->impulse_t);
    *b->first = g->is_stiff ? FIRST * (g->to - g->from) : g->steps.h;
  }
  *b->t = t;
  *b->steps = 0;
  memcpy(b->qv, p->qv, (size_t)(d->nq + d->nv) * sizeof *b->qv);
  memcpy(b->peak, p->peak, (size_t)d->k * sizeof *b->peak);
  return NSDAE_OK;
}

/* The integrator starts anew from here: that is the base from now on. */
static int start(nsdae_penalty *p, double t, int stiff)
{
  int status = move_base(p, t);
  /* The integrator from here on: IDA as long as a contact is closed that has made the
   * equations stiff. */
  int by_option = p->equations.stepper->options->integrator, any = 0;
  for (int i = 0; i < nsdae_penalty_dims(p)->k; i++) any |= p->equations.base.closed[i];
  *p->equations.base.is_stiff = by_option == NSDAE_INTEGRATOR_IDA ||
                                (by_option == NSDAE_INTEGRATOR_AUTO && p->integrator.ida &&
                                 (stiff || (p->integrator.is_stiff && any)));
  return status < 0 ? status : start_integrator(p);
}

/* A contact closes here: its d'_0, its effective mass 1 / (W_N^T P W_N). */
static int close_contact(nsdae_penalty *p, int i, double t)
{
  nsdae_stepper *s = p->equations.stepper;
  nsdae_terms *T = &s->middle;
  const nsdae_dims *d = nsdae_penalty_dims(p);
  nsdae_penalty_base *b = &p->equations.base;
  int status = check_law(s, "nsdae_penalty", i);
  if (status == NSDAE_OK) status = nsdae_terms_need(T, NSDAE_TERM_MASS | NSDAE_TERM_JACOBIAN);
  if (status == NSDAE_OK) status = nsdae_stepper_factor(s, T, T->M);
  if (status < 0) return status;
  memset(s->r, 0, (size_t)d->nv * sizeof *s->r);
  memset(s->impulse, 0, (size_t)d->m * sizeof *s->impulse);
  nsdae_rows_add(&s->system->blocks, &T->by.normal, i, 1, s->r);
  status = nsdae_terms_solve(T, &s->kkt, 1, s->r, s->impulse);
  if (status < 0) return status;
  double inverse = nsdae_rows_dot(&s->system->blocks, &T->by.normal, i, s->r);
  b->mass[i] = inverse > 0 ? 1 / inverse : 0;
  b->closed[i] = 1;
  b->since[i] = t;
  b->start_rate[i] = fmax(-nsdae_terms_normal_rate(T, i, T->v), s->options->friction_velocity);
  b->impulse[i] = 0;
  memset(b->impulse_t + (size_t)i * (size_t)d->nt, 0, (size_t)d->nt * sizeof *b->impulse_t);
  p->peak[i] = 0;
  return NSDAE_OK;
}

static void open_contact(nsdae_penalty *p, nsdae_result *result, int i)
{
  const nsdae_dims *d = nsdae_penalty_dims(p);
  const nsdae_penalty_base *b = &p->equations.base;
  b->closed[i] = 0;
  if (!(b->start_rate[i] > p->equations.stepper->options->impact_velocity)) return;
  nsdae_impact *impact = &result->impact[result->impacts++];
  *impact = (nsdae_impact){.time = nsdae_system_time(p->equations.stepper->system, b->since[i]),
                           .contact = i,
                           .velocity_before = -b->start_rate[i],
                           .normal_impulse = b->impulse[i],
                           .velocity_after = p->equations.at.v_n[i],
                           .peak_force = p->peak[i],
                           .id = i,
                           .block = {-1, -1}};
  for (int l = 0, j = i * d->nt; l < d->nt; l++, j++)
    impact->tangential_impulse[l] = b->impulse_t[j];
}

/* Gaps that crossed zero: contacts begin and end, and the integrator starts anew. A gap within its
 * rounding crosses zero any number of times: a contact opens while it moves apart alone, and closes
 * while it does not. One that is no longer listed has opened; one that was not before closes
 * wherever it is, as another feature of two bodies. */
static int switch_contacts(nsdae_penalty *p, nsdae_result *result, double t)
{
  int status = move_base(p, t);
  if (status == NSDAE_OK) status = nsdae_penalty_evaluate(&p->equations, t, p->qv);
  for (int i = 0; i < nsdae_penalty_dims(p)->k && status == NSDAE_OK; i++) {
    double v_n = p->equations.at.v_n[i];
    int closed = p->equations.base.closed[i];
    int near = p->equations.stepper->middle.gap[i] < NSDAE_FAR;
    int appears = nsdae_penalty_is_tracked(p) && p->gaps.fall.low[i] >= NSDAE_FAR;
    if (!p->gaps.found[i]) continue;
    if (closed && (v_n > 0 || !near))
      open_contact(p, result, i);
    else if (!closed && (v_n <= 0 || appears) && near)
      status = close_contact(p, i, t);
  }
  return status < 0 ? status : start(p, t, 0);
}

/* How near a contact is at hand that moves with v_n: less than a billionth of dt away. */
static double reach(const nsdae_penalty *p, int i)
{
  return fmax(-p->equations.at.v_n[i], 0) * 1e-9 * p->equations.stepper->options->dt;
}

/* From a state that this method did not lead to. */
static int begin(nsdae_penalty *p, const nsdae_terms *from)
{
  const nsdae_dims *d = nsdae_penalty_dims(p);
  nsdae_penalty_base *b = &p->equations.base;
  memcpy(p->qv, from->q, (size_t)d->nq * sizeof *p->qv);
  memcpy(p->qv + d->nq, from->v, (size_t)d->nv * sizeof *p->qv);
  *b->steps = *b->is_stiff = p->integrator.is_stiff = 0;
  *b->first = 0;
  for (int i = 0; i < d->k; i++) b->closed[i] = 0, b->start_rate[i] = 1;
  for (int i = 0; i < d->k; i++) p->gaps.shift[i] = 0; /* nothing of a run before */
  p->gaps.pending = 0;
  p->gaps.depth = 0;
  int status = nsdae_penalty_slots_begin(p, from);
  if (status == NSDAE_OK) status = nsdae_penalty_evaluate(&p->equations, from->t, p->qv);
  for (int i = 0; i < d->k && status == NSDAE_OK; i++)
    if (p->equations.stepper->middle.gap[i] <= reach(p, i)) status = close_contact(p, i, from->t);
  return status < 0 ? status : start(p, from->t, 0);
}

/* ---- steps */

/* The contact forces at a part x of the step from `from` to `ahead`. */
static int forces_at(nsdae_penalty *p, double from, double x)
{
  double t = x < 1 ? from + x * (p->ahead - from) : p->ahead, *qv = p->equations.room;
  int status = nsdae_penalty_read(p, t, qv);
  return status < 0 ? status : nsdae_penalty_evaluate(&p->equations, t, qv);
}

/* The largest force of each closed contact in the step up to `ahead`: at its end, and where the
 * parabola through the forces at its start, middle and end has a maximum. */
static int follow_peaks(nsdae_penalty *p, double from)
{
  const nsdae_dims *d = nsdae_penalty_dims(p);
  double *middle = p->z[0], *end = p->z[1];
  int any = 0, status;
  for (int i = 0; i < d->k; i++) any |= p->equations.base.closed[i];
  if (!any) return NSDAE_OK;
  status = forces_at(p, from, 0.5);
  memcpy(middle, p->equations.at.normal, (size_t)d->k * sizeof *middle);
  if (status == NSDAE_OK) status = forces_at(p, from, 1);
  memcpy(end, p->equations.at.normal, (size_t)d->k * sizeof *end);
  for (int i = 0; i < d->k && status == NSDAE_OK; i++) {
    double f = p->force[i], bend = 2 * (f - 2 * middle[i] + end[i]);
    double slope = 4 * middle[i] - 3 * f - end[i], x = -slope / (2 * bend);
    double peak = fmax(p->peak[i], end[i]);
    p->force[i] = end[i];
    if (!p->equations.base.closed[i]) continue;
    if (bend < 0 && x > 0 && x < 1) {
      status = forces_at(p, from, x);
      peak = fmax(peak, p->equations.at.normal[i]);
    }
    p->peak[i] = peak;
  }
  return status;
}

/* Of the step from `from` to `ahead` the first time at which a gap crosses zero is `ahead`, where
 * `found` says which. */
static int search(nsdae_penalty *p, double from)
{
  const nsdae_smooth *g = &p->integrator;
  const double deep = DEEP * (g->steps.rtol * g->steps.way + g->steps.atol);
  const double h = p->ahead - from;
  double hidden;
  int contact = -1, k = nsdae_penalty_dims(p)->k;
  p->gaps.pending = 0;
  if (k == 0) return NSDAE_OK;
  int status = nsdae_penalty_slots_cover(p, from);
  if (status == NSDAE_OK) status = values(from, p->gaps.fall.low, p);
  if (status < 0) return status;
  int found = nsdae_fall_find(&p->gaps.fall, from, &p->ahead, p->gaps.found);
  if (found < 0) return found;
  p->gaps.depth = 0;
  for (int i = 0; i < k; i++)
    if (p->equations.base.closed[i])
      p->gaps.depth = fmax(p->gaps.depth, p->gaps.fall.high[i] - p->gaps.shift[i]);
  status = nsdae_dip_find(&p->gaps.dip, from, p->ahead, nsdae_smooth_pieces(g),
                          p->equations.base.closed, deep, &hidden, &contact);
  if (contact >= 0 && (found == 0 || p->ahead - hidden > ROUNDING * (fabs(p->ahead) + h))) {
    p->ahead = hidden;
    found = 1;
    memset(p->gaps.found, 0, (size_t)k * sizeof *p->gaps.found);
    p->gaps.found[contact] = 1;
  }
  p->gaps.pending = found > 0;
  return status < 0 || !found ? status : nsdae_penalty_slots_close(p, from);
}

/* One step of the integrator, up to the first gap that crosses zero. */
static int one_step(nsdae_penalty *p)
{
  nsdae_smooth *g = &p->integrator;
  double from = p->ahead;
  nsdae_error_clear(p->equations.stepper->error);
  int status = nsdae_smooth_advance(g);
  if (status < 0) return status;
  p->ahead = g->to;
  ++*p->equations.base.steps;
  status = search(p, from);
  if (status == NSDAE_OK) status = follow_peaks(p, from);
  return status < 0 ? status : nsdae_penalty_read(p, p->ahead, p->qv);
}

/* What IDA does not solve the explicit pair may. */
static int step_or_start(nsdae_penalty *p)
{
  double from = p->ahead;
  int steps = *p->equations.base.steps, stiff = *p->equations.base.is_stiff;
  int automatic = p->equations.stepper->options->integrator == NSDAE_INTEGRATOR_AUTO;
  if (nsdae_smooth_stiff(&p->integrator) && automatic) return start(p, from, 1);
  if (steps >= (stiff ? STIFF_STEPS_MAX : STEPS_MAX)) return start(p, from, stiff);
  int status = one_step(p);
  if (status == NSDAE_OK) return NSDAE_OK;
  int grows = status == NSDAE_ARRAYS_GROW;
  if (grows || !stiff || !automatic || p->equations.stepper->error->status != NSDAE_OK)
    return integrator_failed(p, status, from);
  p->ahead = from;
  status = move_base(p, from); /* by what IDA has */
  p->integrator.is_stiff = 0;
  return status < 0 ? status : start(p, from, 0);
}

/* What the forces did up to t, for the step's result. */
static int account(nsdae_penalty *p, nsdae_result *r, double t)
{
  const nsdae_dims *d = nsdae_penalty_dims(p);
  int n = nsdae_penalty_size(d), work = nsdae_penalty_at_work(d);
  const double *from = p->z[0], *to = p->z[1];
  int status = nsdae_smooth_read(&p->integrator, p->reached, n, p->z[0]);
  if (status == NSDAE_OK) status = nsdae_smooth_read(&p->integrator, t, n, p->z[1]);
  if (status < 0) return status;
  int lambda = nsdae_penalty_at_lambda(d), normal = nsdae_penalty_at_normal(d);
  int tangential = nsdae_penalty_at_tangential(d), slide = nsdae_penalty_at_slide(d);
  nsdae_add_change(d->m, from + lambda, to + lambda, r->multiplier);
  nsdae_add_change(d->k, from + normal, to + normal, r->impulses.normal);
  nsdae_add_change(d->k * d->nt, from + tangential, to + tangential, r->impulses.tangential);
  nsdae_add_change(d->f, from + slide, to + slide, r->impulses.frictional_joint_impulse);
  r->work -= to[work] - from[work];
  r->gain += to[work + 1] - from[work + 1] - (to[work] - from[work]);
  p->reached = t;
  return NSDAE_OK;
}

/* To the end of the step, or until the list of impacts is full: then the step ends early. */
static int integrate(nsdae_penalty *p, nsdae_result *result, double t_end)
{
  int status = NSDAE_OK;
  while (status == NSDAE_OK && p->reached < t_end && nsdae_result_room(result)) {
    if (!(p->ahead > p->reached)) {
      status = step_or_start(p);
      result->counters.iterations++;
      if (status == NSDAE_OK)
        status = nsdae_stepper_goes_on(
            p->equations.stepper, "nsdae_penalty",
            "make dt or penalty_stiffness smaller, or inner_steps_max or rtol larger", p->ahead,
            t_end);
    }
    double to = fmin(p->ahead, t_end);
    if (status == NSDAE_OK && to > p->reached) status = account(p, result, to);
    if (status == NSDAE_OK && p->gaps.pending && p->reached == p->ahead)
      status = switch_contacts(p, result, p->ahead);
  }
  return status;
}

/* ---- the interface of a method */

/* q and v at t, which the integrator has reached. */
static int read_state(nsdae_penalty *p, double t, double *qv)
{
  const nsdae_dims *d = nsdae_penalty_dims(p);
  if (*p->equations.base.steps > 0) return nsdae_penalty_read(p, t, qv);
  memcpy(qv, p->equations.base.qv, (size_t)(d->nq + d->nv) * sizeof *qv);
  return NSDAE_OK;
}

/* From the base to the state again. Where callbacks do not give the same numbers as then, it is the
 * state that holds, with the contacts of the base, and the integrator starts anew there. */
static int replay(nsdae_penalty *p, const nsdae_terms *to)
{
  const nsdae_dims *d = nsdae_penalty_dims(p);
  const nsdae_penalty_base *b = &p->equations.base;
  double *q = p->qv, *v = q + d->nq;
  size_t nq = (size_t)d->nq * sizeof *q, nv = (size_t)d->nv * sizeof *v;
  int steps = *b->steps;
  memcpy(q, b->qv, nq + nv);
  memcpy(p->peak, b->peak, (size_t)d->k * sizeof *p->peak);
  int status = start_integrator(p);
  p->slots.replays = 1;
  *b->steps = 0;
  while (status == NSDAE_OK && *b->steps < steps && !(p->ahead > to->t)) status = one_step(p);
  p->slots.replays = 0;
  if (status < 0) return integrator_failed(p, status, p->ahead);
  if (to->t <= p->ahead) status = read_state(p, to->t, p->equations.room);
  if (status < 0) return integrator_failed(p, status, p->ahead);
  if (to->t <= p->ahead && memcmp(p->equations.room, to->q, nq) == 0 &&
      memcmp(p->equations.room + d->nq, to->v, nv) == 0)
    return NSDAE_OK;
  memcpy(q, to->q, nq);
  memcpy(v, to->v, nv);
  return start(p, to->t, *b->is_stiff);
}

static int mode_of(const nsdae_penalty *p, int i, int nt)
{
  double speed = nsdae_norm(nt, p->equations.at.v_t + i * nt);
  if (!p->equations.base.closed[i]) return NSDAE_MODE_OPEN;
  return nt > 0 && speed <= p->equations.stepper->options->friction_velocity ? NSDAE_MODE_STICK
                                                                             : NSDAE_MODE_SLIP;
}

/* What the step did beside its impulses. */
static int read_results(nsdae_penalty *p, nsdae_terms *from, nsdae_result *result)
{
  nsdae_terms *T = &p->equations.stepper->middle;
  const nsdae_dims *d = nsdae_penalty_dims(p);
  nsdae_impulses *to = &result->impulses;
  double t = p->reached;
  int status = read_state(p, t, p->equations.room);
  if (status == NSDAE_OK) status = nsdae_penalty_evaluate(&p->equations, t, p->equations.room);
  if (status == NSDAE_OK)
    status = nsdae_terms_need(T, NSDAE_TERM_PHI | NSDAE_TERM_SLIDE | NSDAE_TERM_JACOBIAN |
                                     NSDAE_TERM_PHI_T | NSDAE_TERM_MASS);
  /* Newton's matrix of IDA may be regular if M or Phi_q is not. */
  if (status == NSDAE_OK && p->integrator.is_stiff)
    status = nsdae_stepper_factor(p->equations.stepper, T, T->M);
  if (status < 0) return status;
  for (int i = 0; i < d->m; i++) result->multiplier[i] /= t - from->t;
  for (int i = 0; i < d->k; i++) to->mode[i] = mode_of(p, i, d->nt);
  for (int j = 0; j < d->f; j++) {
    double slip = fabs(nsdae_terms_slide_rate(T, j, T->v));
    int sticks = slip <= p->equations.stepper->options->friction_velocity;
    to->frictional_joint_mode[j] = sticks ? NSDAE_MODE_STICK : NSDAE_MODE_SLIP;
  }
  nsdae_result_rate(result, T, T->v);
  result->located = 1;
  nsdae_terms_at(&result->end, t, T->q, T->v);
  return nsdae_penalty_slots_show(p, from, result);
}

/* To where the step starts, if the integrator is not there already. A replay is not counted. */
static int arrive(nsdae_penalty *p, const nsdae_state *state, nsdae_result *result)
{
  long stamp = state->memory->stamp, stood = p->stamp;
  nsdae_counters *counters = &result->counters;
  nsdae_penalty_base_find(&p->equations.base, &p->slots.tracking, p->equations.stepper,
                          &result->memory);
  p->stamp = 0; /* until the step has succeeded */
  if (nsdae_penalty_is_tracked(p)) nsdae_tracking_load(&p->slots.tracking);
  if (stamp > 0 && stamp == stood) return NSDAE_OK;
  if (stamp == 0) return begin(p, state->terms);
  nsdae_counters counted = *counters;
  int status = replay(p, state->terms);
  *counters = counted;
  return status;
}

static int start_run(void *own, const nsdae_terms *at)
{
  nsdae_penalty *p = own;
  return p->integrator.ida ? nsdae_stepper_start(p->equations.stepper, &p->equations.newton, at)
                           : NSDAE_OK;
}

static int check(void *own, nsdae_memory *memory)
{
  nsdae_penalty *p = own;
  nsdae_penalty_base_find(&p->equations.base, &p->slots.tracking, p->equations.stepper, memory);
  int steps = *p->equations.base.steps >= 0 && *p->equations.base.steps <= STEPS_MAX;
  return steps && nsdae_tracking_is_valid(&p->slots.tracking) ? NSDAE_OK : NSDAE_E_ARGUMENT;
}

static int settle(void *own, const nsdae_state *state, nsdae_result *result)
{
  nsdae_penalty *p = own;
  int status = arrive(p, state, result);
  if (status == NSDAE_OK) status = read_state(p, state->terms->t, p->qv);
  if (status == NSDAE_OK) nsdae_penalty_slots_keep(p, &result->memory);
  return status < 0 ? status : move_base(p, state->terms->t);
}

static int advance(void *own, const nsdae_state *state, double t_end, nsdae_result *result)
{
  nsdae_penalty *p = own;
  int status = arrive(p, state, result);
  p->reached = state->terms->t;
  if (status == NSDAE_OK) status = nsdae_penalty_slots_trim(p, state->terms);
  if (status == NSDAE_OK) status = integrate(p, result, t_end);
  if (status == NSDAE_OK) status = read_results(p, state->terms, result);
  nsdae_error *error = p->equations.stepper->error;
  /* a callback that failed in an integral has its own status, as of a value that is not finite */
  if (status == NSDAE_E_CALLBACK && error->status < 0) return error->status;
  if (status < 0) return status;
  nsdae_error_clear(error); /* of callbacks that a smaller step helped */
  nsdae_penalty_slots_keep(p, &result->memory);
  result->memory.stamp = p->stamp = ++p->stamps;
  return NSDAE_OK;
}

const nsdae_stepping nsdae_stepping_penalty = {
    .name = "penalty",
    .summary = "continuous contact force, integrated with error control",
    .create = create,
    .destroy = destroy,
    .lay = nsdae_penalty_base_lay,
    .prepare = prepare,
    .start = start_run,
    .settle = settle,
    .check = check,
    .advance = advance,
    .track = nsdae_penalty_slots_anew,
    .tracks = 1};
