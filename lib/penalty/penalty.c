/* Continuous contact force (see penalty_law.h), the baseline of Zhang, Gu and Sun, integrated as a
 * stiff smooth system (equations.h) by SUNDIALS with error control; dt is only how often it
 * records.
 *
 * The integrals of the forces are integrated along, so that a step's impulses are as accurate as
 * its state. A gap that closes starts a contact (its d'_0 is the velocity there); when it opens
 * again, what happened in between is an impact. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "equations.h"
#include "errors.h"
#include "ode.h"
#include "vector.h"

typedef struct penalty {
  nsdae_penalty_equations equations;
  nsdae_ode *ode;
  nsdae_arena arena;
  int n;               /* length of y */
  double *y, *y_start; /* n: now, at the start of the step */
  double *peak;        /* k: largest force of each contact until now */
  int *found;          /* k: roots */
  double grid;         /* of the ends of steps, of the step in work */
  long stamp, stamps;  /* of the memory that the integrator stands at, 0: none; given so far */
} penalty;

static void layout(void *object, nsdae_arena *arena)
{
  penalty *p = object;
  int k = p->equations.stepper->system->dims.k;
  p->y = NSDAE_ARENA_DOUBLES(arena, p->n);
  p->y_start = NSDAE_ARENA_DOUBLES(arena, p->n);
  p->peak = NSDAE_ARENA_DOUBLES(arena, k);
  p->found = NSDAE_ARENA_INTS(arena, k);
  nsdae_penalty_equations_layout(&p->equations, arena);
}

static int check_law(const nsdae_stepper *s)
{
  if (s->options->penalty_law != NSDAE_PENALTY_FLORES) return NSDAE_OK;
  for (int i = 0; i < s->system->dims.k; i++) {
    if (s->system->contact[i].e_n > 0) continue;
    nsdae_error_set(s->error, NSDAE_E_ARGUMENT, "nsdae_sim_create", "e_n",
                    "e_n = 0 is outside its range: the law flores needs it greater than 0");
    nsdae_system_name_item(s->system, NSDAE_NAME_CONTACT, i, s->error);
    return NSDAE_E_ARGUMENT;
  }
  return NSDAE_OK;
}

static int prepare(void *own)
{
  penalty *p = own;
  const nsdae_sim_options *o = p->equations.stepper->options;
  p->equations.law =
      (nsdae_penalty_force){o->penalty_law, o->penalty_stiffness, o->penalty_exponent};
  nsdae_ode_tolerances(p->ode, o->rtol, o->atol, o->step_max);
  return check_law(p->equations.stepper);
}

static int create(nsdae_stepper *s, void **own)
{
  penalty *p = calloc(1, sizeof *p);
  *own = p;
  if (!p) return nsdae_stepper_made(s, NSDAE_E_MEMORY, "penalty");
  p->equations.stepper = s;
  p->n = nsdae_penalty_size(&s->system->dims);
  const nsdae_ode_problem problem = {.n = p->n,
                                     .controlled = nsdae_penalty_at_other_work(&s->system->dims),
                                     .roots = s->system->dims.k,
                                     .rate = nsdae_penalty_rate,
                                     .root = nsdae_penalty_gaps,
                                     .user = &p->equations};
  int status = nsdae_arena_build(&p->arena, layout, p);
  if (status == NSDAE_OK)
    status = nsdae_ode_create(&problem, s->options->rtol, s->options->atol, &p->ode);
  return status < 0 ? nsdae_stepper_made(s, status, "penalty") : prepare(p);
}

static void destroy(void *own)
{
  penalty *p = own;
  if (!p) return;
  nsdae_ode_destroy(&p->ode);
  nsdae_arena_release(&p->arena);
  free(p);
}

/* The integrator starts at y. Within rounding of zero a gap can have the wrong sign for its
 * contact, and would cross zero again at once, without an end: it is looked at from where it has
 * twice that. */
static int start_integrator(penalty *p, double t)
{
  const nsdae_system *s = p->equations.stepper->system;
  const nsdae_sim_options *o = p->equations.stepper->options;
  const double hair = 1e-12 * o->dt * o->friction_velocity;
  nsdae_terms *T = &p->equations.stepper->middle;
  nsdae_power_start(&p->equations.power);
  nsdae_terms_at(T, t, p->y, p->y + s->dims.nq);
  int status = nsdae_terms_need(T, NSDAE_TERM_GAP);
  for (int i = 0; i < s->dims.k && status == NSDAE_OK; i++) {
    double gap = T->gap[i];
    int wrong = p->equations.base.closed[i] ? gap >= 0 : gap <= 0;
    p->equations.shift[i] = wrong ? 2 * gap + (p->equations.base.closed[i] ? hair : -hair) : 0;
  }
  return status < 0 ? status : nsdae_ode_start(p->ode, t, p->y);
}

/* Here the integrator starts anew. */
static void move_base(penalty *p, double t)
{
  nsdae_penalty_base *b = &p->equations.base;
  *b->t = t;
  *b->since_then.count = *b->since_then.ends = 0;
  memcpy(b->y, p->y, (size_t)p->n * sizeof *b->y);
  memcpy(b->peak, p->peak, (size_t)p->equations.stepper->system->dims.k * sizeof *b->peak);
}

/* The integrator starts anew from here: that is the base from now on. */
static int start(penalty *p, double t)
{
  move_base(p, t);
  return start_integrator(p, t);
}

/* A contact closes here: its d'_0, its effective mass 1 / (W_N^T P W_N). */
static void close_contact(penalty *p, int i, double t)
{
  nsdae_stepper *s = p->equations.stepper;
  const nsdae_terms *T = &s->middle;
  const nsdae_dims *d = &s->system->dims;
  nsdae_penalty_base *b = &p->equations.base;
  size_t n = (size_t)d->nv, nt = (size_t)d->nt, first = (size_t)i * nt;
  memcpy(s->r, T->by.normal.value + (size_t)i * n, n * sizeof *s->r);
  memset(s->impulse, 0, (size_t)d->m * sizeof *s->impulse);
  nsdae_kkt_solve(&s->kkt, 1, s->r, d->nv, s->impulse, d->m);
  double inverse = nsdae_dot(d->nv, T->by.normal.value + (size_t)i * n, s->r);
  b->mass[i] = inverse > 0 ? 1 / inverse : 0;
  b->closed[i] = 1;
  b->since[i] = t;
  b->start_rate[i] = fmax(-nsdae_terms_normal_rate(T, i, T->v), s->options->friction_velocity);
  b->impulse[i] = p->y[nsdae_penalty_at_normal(d) + i];
  memcpy(b->impulse_t + first, p->y + (size_t)nsdae_penalty_at_tangential(d) + first,
         nt * sizeof *p->y);
  p->peak[i] = 0;
}

static void open_contact(penalty *p, nsdae_result *result, int i)
{
  const nsdae_dims *d = &p->equations.stepper->system->dims;
  const nsdae_penalty_base *b = &p->equations.base;
  b->closed[i] = 0;
  if (!(b->start_rate[i] > p->equations.stepper->options->impact_velocity)) return;
  nsdae_impact *impact = &result->impact[result->impacts++];
  *impact = (nsdae_impact){.time = nsdae_system_time(p->equations.stepper->system, b->since[i]),
                           .contact = i,
                           .velocity_before = -b->start_rate[i],
                           .normal_impulse = p->y[nsdae_penalty_at_normal(d) + i] - b->impulse[i],
                           .velocity_after = p->equations.at.v_n[i],
                           .peak_force = p->peak[i]};
  for (int l = 0, j = i * d->nt; l < d->nt; l++, j++)
    impact->tangential_impulse[l] = p->y[nsdae_penalty_at_tangential(d) + j] - b->impulse_t[j];
}

/* Gaps that crossed zero: contacts begin and end, and the integrator starts anew. A gap within its
 * rounding crosses zero any number of times: a contact opens while it moves apart alone, and closes
 * while it does not. CVODE refuses to continue at a root without a new start. */
static int switch_contacts(penalty *p, nsdae_result *result, double t)
{
  int status = nsdae_penalty_evaluate(&p->equations, t, p->y);
  for (int i = 0; i < p->equations.stepper->system->dims.k && status == NSDAE_OK; i++) {
    double v_n = p->equations.at.v_n[i];
    int closes = p->found[i] < 0 && !p->equations.base.closed[i] && v_n <= 0;
    int opens = p->found[i] > 0 && p->equations.base.closed[i] && v_n > 0;
    if (closes) close_contact(p, i, t);
    if (opens) open_contact(p, result, i);
  }
  return status < 0 ? status : start(p, t);
}

/* How near a contact is at hand that moves with v_n: less than a billionth of dt away. */
static double reach(const penalty *p, int i)
{
  return fmax(-p->equations.at.v_n[i], 0) * 1e-9 * p->equations.stepper->options->dt;
}

static int follow_peaks(penalty *p, double t)
{
  int any = 0, k = p->equations.stepper->system->dims.k;
  for (int i = 0; i < k; i++) any |= p->equations.base.closed[i];
  if (!any) return NSDAE_OK;
  int status = nsdae_penalty_evaluate(&p->equations, t, p->y);
  for (int i = 0; i < k; i++)
    if (p->equations.base.closed[i]) p->peak[i] = fmax(p->peak[i], p->equations.at.normal[i]);
  return status;
}

/* From a state that this method did not lead to. */
static int begin(penalty *p, const nsdae_terms *from)
{
  nsdae_stepper *s = p->equations.stepper;
  const nsdae_dims *d = &s->system->dims;
  memset(p->y, 0, (size_t)p->n * sizeof *p->y);
  memcpy(p->y, from->q, (size_t)d->nq * sizeof *p->y);
  memcpy(p->y + d->nq, from->v, (size_t)d->nv * sizeof *p->y);
  for (int i = 0; i < d->k; i++) {
    p->equations.base.closed[i] = 0;
    p->equations.base.start_rate[i] = 1;
  }
  int status = nsdae_penalty_evaluate(&p->equations, from->t, p->y);
  for (int i = 0; i < d->k && status == NSDAE_OK; i++)
    if (s->middle.gap[i] <= reach(p, i)) close_contact(p, i, from->t);
  return status < 0 ? status : start(p, from->t);
}

static int integrator_failed(nsdae_stepper *s, int status, double t, int code)
{
  if (s->error->status != NSDAE_OK) return s->error->status;
  nsdae_error_set(s->error, status, "nsdae_penalty", "rtol",
                  "the integrator failed at t = %.17g with CVODE's code %d: try a larger rtol or a "
                  "smaller penalty_stiffness",
                  nsdae_system_time(s->system, t), code);
  s->error->code = code;
  s->error->time = nsdae_system_time(s->system, t);
  return status;
}

/* One step of the integrator towards t_end. */
static int one_step(penalty *p, double t_end, double *t, int *what)
{
  int code = 0;
  nsdae_error_clear(p->equations.stepper->error);
  int status = nsdae_ode_advance(p->ode, t_end, t, p->y, what, p->found, &code);
  return status < 0 ? integrator_failed(p->equations.stepper, status, *t, code) : NSDAE_OK;
}

/* The end of a step, for a replay; after too many the integrator starts anew. */
static int keep_end(penalty *p, double t_end, double t)
{
  nsdae_stretches *s = &p->equations.base.since_then;
  double dt = p->equations.stepper->options->dt;
  if (nsdae_stretches_add(s, p->grid, dt, t_end)) return NSDAE_OK;
  int status = start(p, t);
  nsdae_stretches_add(s, p->grid, dt, t_end);
  return status;
}

/* What may help where too many steps of the integrator lead to too little. */
static const char advice[] =
    "make dt or penalty_stiffness smaller, or inner_steps_max or rtol larger";

/* A step of backward differences takes some two evaluations of the forces, and n for a Jacobian now
 * and then: ten on the average. Light bodies between stiff contacts take a Jacobian or more each
 * step, of a hundred evaluations: a bound on steps alone is none on the work. */
enum { EVALUATIONS = 10 };

static int too_much_work(const penalty *p, long rates_before, double t, double t_end)
{
  nsdae_stepper *s = p->equations.stepper;
  long rates = nsdae_ode_rates(p->ode) - rates_before;
  if (rates < EVALUATIONS * (long)s->options->inner_steps_max || t >= t_end) return NSDAE_OK;
  nsdae_error_set(s->error, NSDAE_E_CONVERGENCE, "nsdae_penalty", "inner_steps_max",
                  "the integrator is at t = %.17g after %ld evaluations of the forces, %d for each "
                  "of inner_steps_max = %d, towards t = %.17g: %s",
                  nsdae_system_time(s->system, t), rates, EVALUATIONS, s->options->inner_steps_max,
                  nsdae_system_time(s->system, t_end), advice);
  s->error->time = nsdae_system_time(s->system, t);
  return NSDAE_E_CONVERGENCE;
}

/* To the end of the step, or until the list of impacts is full: then the step ends early. */
static int integrate(penalty *p, nsdae_result *result, double t_end, double *t)
{
  int what = NSDAE_ODE_STEP, room = result->impacts_max - p->equations.stepper->system->dims.k;
  long rates = nsdae_ode_rates(p->ode);
  while (what != NSDAE_ODE_END && *t < t_end && result->impacts < room) {
    int status = keep_end(p, t_end, *t);
    if (status == NSDAE_OK) status = one_step(p, t_end, t, &what);
    if (status < 0) return status;
    result->counters.iterations++;
    status = what == NSDAE_ODE_ROOT ? switch_contacts(p, result, *t) : follow_peaks(p, *t);
    if (status == NSDAE_OK)
      status = nsdae_stepper_goes_on(p->equations.stepper, "nsdae_penalty", advice, *t, t_end);
    if (status == NSDAE_OK) status = too_much_work(p, rates, *t, t_end);
    if (status < 0) return status;
  }
  return NSDAE_OK;
}

/* The integrator's point is the state's, to the last bit. */
static int stands_at(const penalty *p, const nsdae_terms *to, double t)
{
  const nsdae_dims *d = &p->equations.stepper->system->dims;
  return t == to->t && memcmp(p->y, to->q, (size_t)d->nq * sizeof *p->y) == 0 &&
         memcmp(p->y + d->nq, to->v, (size_t)d->nv * sizeof *p->y) == 0;
}

/* All steps of a stretch again, from t on. */
static int replay_stretch(penalty *p, int stretch, double *t)
{
  const nsdae_stretches *s = &p->equations.base.since_then;
  int status = NSDAE_OK;
  for (int i = 0; i < s->steps[stretch] && status == NSDAE_OK; i++) {
    double end = nsdae_stretches_end(s, stretch, i, p->equations.stepper->options->dt);
    int what = NSDAE_ODE_STEP;
    while (status == NSDAE_OK && what != NSDAE_ODE_END && *t < end) {
      status = one_step(p, end, t, &what);
      if (status == NSDAE_OK) status = follow_peaks(p, *t);
    }
  }
  return status;
}

/* From the base to the state again. Where callbacks do not give the same numbers as then, it is
 * the state that holds, and the integrator starts anew there. */
static int replay(penalty *p, const nsdae_terms *to)
{
  const nsdae_dims *d = &p->equations.stepper->system->dims;
  const nsdae_penalty_base *b = &p->equations.base;
  double t = *b->t;
  memcpy(p->y, b->y, (size_t)p->n * sizeof *p->y);
  memcpy(p->peak, b->peak, (size_t)d->k * sizeof *p->peak);
  int status = start_integrator(p, t);
  for (int i = 0; i < *b->since_then.count && status == NSDAE_OK; i++)
    status = replay_stretch(p, i, &t);
  if (status < 0 || stands_at(p, to, t)) return status;
  memcpy(p->y, to->q, (size_t)d->nq * sizeof *p->y);
  memcpy(p->y + d->nq, to->v, (size_t)d->nv * sizeof *p->y);
  return start(p, to->t);
}

/* A gap that closes or opens just where the step ends, to rounding of its time, is no root that the
 * integrator reports. */
static int switch_at_end(penalty *p, nsdae_result *result, double t)
{
  const nsdae_terms *T = &p->equations.stepper->middle;
  int any = 0, status = nsdae_penalty_evaluate(&p->equations, t, p->y);
  for (int i = 0; i < p->equations.stepper->system->dims.k && status == NSDAE_OK; i++) {
    double v_n = p->equations.at.v_n[i];
    int closes = !p->equations.base.closed[i] && v_n < 0 && T->gap[i] <= reach(p, i);
    int opens = p->equations.base.closed[i] && T->gap[i] > 0 && v_n > 0;
    p->found[i] = opens - closes;
    any |= closes || opens;
  }
  return any && status == NSDAE_OK ? switch_contacts(p, result, t) : status;
}

static int mode_of(const penalty *p, int i, int nt)
{
  double speed = nsdae_norm(nt, p->equations.at.v_t + i * nt);
  if (!p->equations.base.closed[i]) return NSDAE_MODE_OPEN;
  return nt > 0 && speed <= p->equations.stepper->options->friction_velocity ? NSDAE_MODE_STICK
                                                                             : NSDAE_MODE_SLIP;
}

/* to [n] := what the step added to the integrals from entry first on. */
static void integrals(const penalty *p, int first, int n, double *to)
{
  for (int i = 0; i < n; i++) to[i] = p->y[first + i] - p->y_start[first + i];
}

/* What the step did, from the integrals. */
static void read_results(const penalty *p, nsdae_result *result, double t, double h)
{
  const nsdae_terms *T = &p->equations.stepper->middle;
  const nsdae_dims *d = &T->system->dims;
  nsdae_impulses *to = &result->impulses;
  integrals(p, nsdae_penalty_at_lambda(d), d->m, result->multiplier);
  for (int i = 0; i < d->m; i++) result->multiplier[i] /= h;
  integrals(p, nsdae_penalty_at_normal(d), d->k, to->normal);
  integrals(p, nsdae_penalty_at_tangential(d), d->k * d->nt, to->tangential);
  integrals(p, nsdae_penalty_at_slide(d), d->f, to->frictional_joint_impulse);
  for (int i = 0; i < d->k; i++) to->mode[i] = mode_of(p, i, d->nt);
  for (int j = 0; j < d->f; j++) {
    double slip = fabs(nsdae_terms_slide_rate(T, j, T->v));
    int sticks = slip <= p->equations.stepper->options->friction_velocity;
    to->frictional_joint_mode[j] = sticks ? NSDAE_MODE_STICK : NSDAE_MODE_SLIP;
  }
  result->work = p->y_start[nsdae_penalty_at_work(d)] - p->y[nsdae_penalty_at_work(d)];
  integrals(p, nsdae_penalty_at_other_work(d), 1, &result->gain);
  result->gain += result->work;
  nsdae_result_rate(result, T, T->v);
  result->located = 1;
  nsdae_terms_at(&result->end, t, p->y, p->y + d->nq);
}

/* To where the step starts, if the integrator is not there already. A replay is not counted. */
static int arrive(penalty *p, const nsdae_state *state, nsdae_counters *counters)
{
  long stamp = state->memory->stamp;
  if (stamp == 0) return begin(p, state->terms);
  if (stamp == p->stamp) return NSDAE_OK;
  nsdae_counters counted = *counters;
  int status = replay(p, state->terms);
  *counters = counted;
  return status;
}

static int settle(void *own, const nsdae_state *state, nsdae_result *result)
{
  penalty *p = own;
  nsdae_penalty_base_find(&p->equations.base, p->equations.stepper, &result->memory);
  int status = arrive(p, state, &result->counters);
  p->stamp = 0;
  if (status == NSDAE_OK) move_base(p, state->terms->t);
  return status;
}

static int advance(void *own, const nsdae_state *state, double t_end, nsdae_result *result)
{
  penalty *p = own;
  double t = state->terms->t;
  p->grid = state->grid;
  nsdae_penalty_base_find(&p->equations.base, p->equations.stepper, &result->memory);
  int status = arrive(p, state, &result->counters);
  p->stamp = 0;
  if (status < 0) return status;
  memcpy(p->y_start, p->y, (size_t)p->n * sizeof *p->y);
  status = integrate(p, result, t_end, &t);
  if (status == NSDAE_OK) status = switch_at_end(p, result, t);
  if (status < 0) return status;
  nsdae_error_clear(p->equations.stepper->error); /* of callbacks that a smaller step helped */
  read_results(p, result, t, t - state->terms->t);
  result->memory.stamp = p->stamp = ++p->stamps;
  return NSDAE_OK;
}

const nsdae_stepping nsdae_stepping_penalty = {
    .name = "penalty",
    .summary = "continuous contact force, integrated by SUNDIALS with error control",
    .create = create,
    .destroy = destroy,
    .sizes = nsdae_penalty_base_sizes,
    .prepare = prepare,
    .settle = settle,
    .advance = advance};
