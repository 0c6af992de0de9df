/* Continuous contact force, the baseline of Zhang, Gu and Sun, integrated as a
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

/* Of the tolerance of a position: less deep between two steps a contact is none. */
static const double DEEP = 0.1;

/* Of a time: two crossings nearer to each other are one (dip.c). */
static const double ROUNDING = 100 * DBL_EPSILON;

/* ---- creation */

static void layout(void *object, nsdae_arena *arena)
{
  nsdae_penalty *p = object;
  const nsdae_dims *d = nsdae_penalty_dims(p);
  p->qv = NSDAE_ARENA_DOUBLES(arena, d->nq + d->nv);
  for (int i = 0; i < 2; i++) p->z[i] = NSDAE_ARENA_DOUBLES(arena, nsdae_penalty_at(d).size);
  nsdae_arena_doubles(arena, d->k, (double **[]){&p->peak, &p->force, &p->gaps.shift, NULL});
  p->gaps.found = NSDAE_ARENA_INTS(arena, d->k);
  nsdae_penalty_slots_layout(p, arena);
  nsdae_penalty_equations_layout(&p->equations, arena);
  nsdae_smooth_layout(&p->integrator, arena);
  nsdae_fall_layout(&p->gaps.fall, arena);
  nsdae_dip_layout(&p->gaps.dip, arena);
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
    status = nsdae_penalty_check_law(p->equations.stepper, "nsdae_sim_create", i);
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
  p->integrator.steps = (nsdae_runge_kutta){.n = nsdae_penalty_at(d).size,
                                            .controlled = nsdae_penalty_at(d).lambda,
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
  nsdae_ida_destroy(&p->integrator.ida);
  nsdae_newton_kkt_release(&p->equations.newton);
  nsdae_arena_release(&p->arena);
  free(p);
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

/* The row that is nearest to the others has a name. */
static int refuse_pose(nsdae_stepper *s, nsdae_terms *T, double sine)
{
  double t = nsdae_terms_time(T);
  char called[NSDAE_CALLED_SIZE];
  s->kkt.spare = s->kkt.m - s->kkt.rank + 1;
  int status = nsdae_terms_factor(T, T->M, &s->kkt, 1), row = s->kkt.dependent;
  s->kkt.spare = 0;
  if (status < 0) return status;
  nsdae_error_set(
      s->error, NSDAE_E_CONVERGENCE, "nsdae_penalty", "method",
      "%s depends on the other constraints up to a sine of %.2g at t = %g: at this pose, a change "
      "point or one that they do not let pass, the error of penalty would turn the motion; use "
      "method = event",
      row < 0 ? "a constraint" : nsdae_system_called(s->system, NSDAE_NAME_CONSTRAINT, row, called),
      sine, t);
  int index = row < 0 ? -1 : nsdae_system_index(s->system, NSDAE_NAME_CONSTRAINT, row);
  return nsdae_error_at(s->error, NSDAE_E_CONVERGENCE, index, t);
}

/* Of the largest sine of the step: a change point is one where it falls, unlike of rows that are
 * nearly dependent in all poses. */
static const double FALLEN = 0.5;

/* Near a change point a drift of the constraints turns the motion onto another branch, in steps
 * that follow it. On a smooth branch v turns by a small part while a sine changes by its width: in
 * the step from `from`, whose velocities are still in qv, it turns by more. The new ones are in the
 * room of the equations. */
static int leaves_branch(nsdae_penalty *p, double from)
{
  nsdae_stepper *s = p->equations.stepper;
  nsdae_terms *T = &s->middle;
  const nsdae_dims *d = nsdae_penalty_dims(p);
  const double turned = 0.5;
  double width = cbrt(s->options->rtol), *v = p->equations.room + d->nq, *change = p->qv + d->nq;
  if (d->m == 0) return NSDAE_OK;
  if (!p->integrator.is_stiff) p->widest = fmax(p->widest, s->kkt.kept);
  if (!p->integrator.is_stiff && s->kkt.kept >= width) return NSDAE_OK;
  nsdae_terms_at(T, p->ahead, p->equations.room, v);
  int status = nsdae_terms_need(T, NSDAE_TERM_MASS | NSDAE_TERM_JACOBIAN);
  if (status == NSDAE_OK) status = nsdae_stepper_factor(s, T, T->M);
  double speed = nsdae_largest(d->nv, v), sine = s->kkt.kept;
  if (status < 0) return status;
  p->widest = fmax(p->widest, sine);
  if (sine > FALLEN * p->widest || sine >= width || !(speed > 0)) return NSDAE_OK;
  for (int i = 0; i < d->nv; i++) change[i] = v[i] - change[i];
  double bend = sqrt(nsdae_terms_energy(T, change)) * width / (8 * speed * (p->ahead - from));
  if (!(bend > turned * sqrt(nsdae_terms_energy(T, v)))) return NSDAE_OK;
  return refuse_pose(s, T, sine);
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
  if (status == NSDAE_OK) status = nsdae_penalty_read(p, p->ahead, p->equations.room);
  if (status == NSDAE_OK) status = leaves_branch(p, from);
  if (status == NSDAE_OK) status = follow_peaks(p, from);
  return status < 0 ? status : nsdae_penalty_read(p, p->ahead, p->qv);
}

/* What IDA does not solve the explicit pair may. */
static int step_or_start(nsdae_penalty *p)
{
  double from = p->ahead;
  int steps = *p->equations.base.steps, stiff = *p->equations.base.is_stiff;
  int automatic = p->equations.stepper->options->integrator == NSDAE_INTEGRATOR_AUTO;
  if (nsdae_smooth_stiff(&p->integrator) && automatic) return nsdae_penalty_start(p, from, 1);
  if (steps >= (stiff ? STIFF_STEPS_MAX : STEPS_MAX)) return nsdae_penalty_start(p, from, stiff);
  int status = one_step(p);
  if (status == NSDAE_OK) return NSDAE_OK;
  int grows = status == NSDAE_ARRAYS_GROW;
  if (grows || !stiff || !automatic || p->equations.stepper->error->status != NSDAE_OK)
    return nsdae_penalty_failed(p, status, from);
  p->ahead = from;
  status = nsdae_penalty_move_base(p, from); /* by what IDA has */
  p->integrator.is_stiff = 0;
  return status < 0 ? status : nsdae_penalty_start(p, from, 0);
}

/* What the forces did up to t, for the step's result. */
static int account(nsdae_penalty *p, nsdae_result *r, double t)
{
  const nsdae_dims *d = nsdae_penalty_dims(p);
  const nsdae_penalty_offsets at = nsdae_penalty_at(d);
  const double *from = p->z[0], *to = p->z[1];
  int status = nsdae_smooth_read(&p->integrator, p->reached, at.size, p->z[0]);
  if (status == NSDAE_OK) status = nsdae_smooth_read(&p->integrator, t, at.size, p->z[1]);
  if (status < 0) return status;
  nsdae_add_change(d->m, from + at.lambda, to + at.lambda, r->multiplier);
  nsdae_add_change(d->k, from + at.normal, to + at.normal, r->impulses.normal);
  nsdae_add_change(d->k * d->nt, from + at.tangential, to + at.tangential, r->impulses.tangential);
  nsdae_add_change(d->f, from + at.slide, to + at.slide, r->impulses.frictional_joint_impulse);
  nsdae_add_change(3 * d->k, from + at.linear, to + at.linear, r->impulses.linear);
  r->work -= to[at.work] - from[at.work];
  r->gain += to[at.work + 1] - from[at.work + 1] - (to[at.work] - from[at.work]);
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
      status = nsdae_penalty_switch_contacts(p, result, p->ahead);
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
  int status = nsdae_penalty_start_integrator(p);
  p->slots.replays = 1;
  *b->steps = 0;
  while (status == NSDAE_OK && *b->steps < steps && !(p->ahead > to->t)) {
    p->widest = 0; /* no pose is refused again */
    status = one_step(p);
  }
  p->slots.replays = 0;
  if (status < 0) return nsdae_penalty_failed(p, status, p->ahead);
  if (to->t <= p->ahead) status = read_state(p, to->t, p->equations.room);
  if (status < 0) return nsdae_penalty_failed(p, status, p->ahead);
  if (to->t <= p->ahead && memcmp(p->equations.room, to->q, nq) == 0 &&
      memcmp(p->equations.room + d->nq, to->v, nv) == 0)
    return NSDAE_OK;
  memcpy(q, to->q, nq);
  memcpy(v, to->v, nv);
  return nsdae_penalty_start(p, to->t, *b->is_stiff);
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
  if (stamp == 0) return nsdae_penalty_begin(p, state->terms);
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
  return status < 0 ? status : nsdae_penalty_move_base(p, state->terms->t);
}

static int advance(void *own, const nsdae_state *state, double t_end, nsdae_result *result)
{
  nsdae_penalty *p = own;
  int status = arrive(p, state, result);
  p->reached = state->terms->t;
  p->widest = 0;
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
