/* Continuous contact force (see penalty_law.h), the baseline of Zhang, Gu and Sun, integrated as a
 * stiff smooth system by SUNDIALS with error control; dt is only how often it records.
 *
 *   y = [q, v, Lambda, I_N, I_T, I_S, E]
 *   q' = H v,   [M Phi_q^T; Phi_q 0] [v'; lambda] = [F + W_N F_N + W_T F_T + W_S F_S;
 *                                                    -omega - 2 alpha Phi' - beta^2 Phi]
 *   Lambda' = lambda,  I' = the contact forces,  E' = -(F_N v_N + F_T v_T + F_S v_S)
 *
 * The integrals of the forces are integrated along, so that a step's impulses are as accurate as
 * its state. A gap that closes starts a contact (its d'_0 is the velocity there); when it opens
 * again, what happened in between is an impact. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "errors.h"
#include "ode.h"
#include "penalty_law.h"
#include "stepper.h"
#include "vector.h"

enum {
  RATE_TERMS = NSDAE_TERM_MASS | NSDAE_TERM_FORCE | NSDAE_TERM_PHI | NSDAE_TERM_JACOBIAN |
               NSDAE_TERM_PHI_T | NSDAE_TERM_OMEGA | NSDAE_TERM_GAP | NSDAE_TERM_NORMAL |
               NSDAE_TERM_TANGENT | NSDAE_TERM_BIAS | NSDAE_TERM_SLIDE
};

/* Friction on the slides feeds their normal force: so many rounds of substitution at most. */
enum { SLIDE_ROUNDS = 50 };

typedef struct penalty {
  nsdae_stepper *stepper;
  nsdae_ode *ode;
  nsdae_penalty_force law;
  nsdae_arena arena;
  int n, running;                    /* length of y; the integrator is where the step starts */
  double *y, *y0;                    /* n: now, at the start of the step */
  double *force, *force_t, *force_s; /* k, k nt, f: at the last evaluation */
  double *v_n, *v_t, *v_s;           /* velocities there */
  double *lambda;                    /* m */
  double *U, *D;                     /* nv x f, m x f: a unit friction force on each slide */
  int *closed, *found;               /* k: in contact; roots */
  double *since, *start_rate, *mass; /* k: when it closed, d'_0, effective mass */
  double *impulse, *peak;            /* k: I_N at closing; largest force since */
  double *impulse_t;                 /* k nt: I_T at closing */
} penalty;

/* Offsets in y. */
static int at_lambda(const nsdae_dims *d)
{
  return d->nq + d->nv;
}

static int at_normal(const nsdae_dims *d)
{
  return at_lambda(d) + d->m;
}

static int at_tangential(const nsdae_dims *d)
{
  return at_normal(d) + d->k;
}

static int at_slide(const nsdae_dims *d)
{
  return at_tangential(d) + d->k * d->nt;
}

static int at_work(const nsdae_dims *d)
{
  return at_slide(d) + d->f;
}

static void contact_forces(penalty *p, const nsdae_terms *T)
{
  const nsdae_system *s = T->system;
  int n = s->dims.nv, nt = s->dims.nt;
  for (int i = 0; i < s->dims.k; i++) {
    const nsdae_coefficients *c = &s->contact[i];
    double speed = 0;
    p->v_n[i] = nsdae_dot(n, T->W_N + (size_t)i * (size_t)n, T->v) + T->w_N[i];
    p->force[i] =
        nsdae_penalty_normal(&p->law, -T->gap[i], -p->v_n[i], p->start_rate[i], c->e_n, p->mass[i]);
    for (int j = i * nt; j < (i + 1) * nt; j++) {
      p->v_t[j] = nsdae_dot(n, T->W_T + (size_t)j * (size_t)n, T->v) + T->w_T[j];
      speed = hypot(speed, p->v_t[j]);
    }
    double per_speed =
        nsdae_penalty_friction(c->mu, p->force[i], speed, p->stepper->options->friction_velocity);
    for (int j = i * nt; j < (i + 1) * nt; j++) p->force_t[j] = per_speed * p->v_t[j];
  }
}

/* Friction on the slides, with U and D of their directions; a and lambda are free of it before. */
static int slide_forces(penalty *p, const nsdae_terms *T, double *a)
{
  const nsdae_system *s = T->system;
  int n = s->dims.nv, m = s->dims.m, f = s->dims.f;
  double moved = 1;
  memcpy(p->U, T->W_S, (size_t)n * (size_t)f * sizeof *p->U);
  memset(p->D, 0, (size_t)m * (size_t)f * sizeof *p->D);
  nsdae_kkt_solve(&p->stepper->kkt, f, p->U, n, p->D, m);
  memset(p->force_s, 0, (size_t)f * sizeof *p->force_s);
  for (int round = 0; moved > 1e-14 && round < SLIDE_ROUNDS; round++) {
    moved = 0;
    for (int j = 0; j < f; j++) {
      double normal = p->lambda[s->slide[j].constraint];
      for (int l = 0; l < f; l++)
        normal += p->D[(size_t)l * (size_t)m + (size_t)s->slide[j].constraint] * p->force_s[l];
      p->v_s[j] = nsdae_dot(n, T->W_S + (size_t)j * (size_t)n, T->v) + T->w_S[j];
      double force = p->v_s[j] * nsdae_penalty_friction(s->slide[j].mu, fabs(normal), p->v_s[j],
                                                        p->stepper->options->friction_velocity);
      moved = fmax(moved, fabs(force - p->force_s[j]) / (1 + fabs(force)));
      p->force_s[j] = force;
    }
  }
  nsdae_add_product(n, f, p->U, p->force_s, a);
  nsdae_add_product(m, f, p->D, p->force_s, p->lambda);
  return moved > 1e-8 ? 1 : 0; /* no convergence: a smaller step */
}

/* a [nv] and lambda of the forces at the terms' point. */
static int accelerations(penalty *p, nsdae_terms *T, double *a)
{
  nsdae_stepper *s = p->stepper;
  const nsdae_dims *d = &s->system->dims;
  double alpha = s->options->baumgarte_alpha, beta = s->options->baumgarte_beta;
  contact_forces(p, T);
  memcpy(a, T->F, (size_t)d->nv * sizeof *a);
  nsdae_add_product(d->nv, d->k, T->W_N, p->force, a);
  nsdae_add_product(d->nv, d->k * d->nt, T->W_T, p->force_t, a);
  for (int i = 0; i < d->m; i++) {
    double rate = T->phi_t[i];
    for (int j = 0; j < d->nv; j++) rate += T->J[(size_t)j * (size_t)d->m + (size_t)i] * T->v[j];
    p->lambda[i] = -T->omega[i] - 2 * alpha * rate - beta * beta * T->phi[i];
  }
  nsdae_kkt_solve(&s->kkt, 1, a, d->nv, p->lambda, d->m);
  return d->f > 0 ? slide_forces(p, T, a) : 0;
}

/* Status of the library as a code of the integrator: what a smaller step may help is positive. */
static int as_code(const nsdae_stepper *s, int status)
{
  if (status == NSDAE_OK) return 0;
  if (status == NSDAE_E_CALLBACK) return s->error->code < 0 ? -1 : 1;
  return status == NSDAE_E_NONFINITE ? -1 : 1;
}

static int rate(double t, const double *y, double *ydot, void *user)
{
  penalty *p = user;
  nsdae_stepper *s = p->stepper;
  nsdae_terms *T = &s->middle;
  const nsdae_dims *d = &s->system->dims;
  nsdae_terms_at(T, t, y, y + d->nq);
  int status = nsdae_terms_need(T, RATE_TERMS);
  if (status == NSDAE_OK) status = nsdae_stepper_factor(s, T, T->M);
  if (status == NSDAE_OK) status = nsdae_stepper_kinematics(s, t, T->q, T->v, ydot);
  if (status < 0) return as_code(s, status);
  int code = accelerations(p, T, ydot + d->nq);
  memcpy(ydot + at_lambda(d), p->lambda, (size_t)d->m * sizeof *ydot);
  memcpy(ydot + at_normal(d), p->force, (size_t)d->k * sizeof *ydot);
  memcpy(ydot + at_tangential(d), p->force_t, (size_t)(d->k * d->nt) * sizeof *ydot);
  memcpy(ydot + at_slide(d), p->force_s, (size_t)d->f * sizeof *ydot);
  ydot[at_work(d)] = -nsdae_dot(d->k, p->force, p->v_n) -
                     nsdae_dot(d->k * d->nt, p->force_t, p->v_t) -
                     nsdae_dot(d->f, p->force_s, p->v_s);
  return code;
}

static int gaps(double t, const double *y, double *g, void *user)
{
  penalty *p = user;
  nsdae_terms *T = &p->stepper->middle;
  nsdae_terms_at(T, t, y, y + p->stepper->system->dims.nq);
  int status = nsdae_terms_need(T, NSDAE_TERM_GAP);
  if (status < 0) return -1;
  memcpy(g, T->gap, (size_t)p->stepper->system->dims.k * sizeof *g);
  return 0;
}

static void layout(void *object, nsdae_arena *arena)
{
  penalty *p = object;
  const nsdae_dims *d = &p->stepper->system->dims;
  long k = d->k, kt = (long)d->k * d->nt, f = d->f;
  p->y = NSDAE_ARENA_DOUBLES(arena, p->n);
  p->y0 = NSDAE_ARENA_DOUBLES(arena, p->n);
  p->force = NSDAE_ARENA_DOUBLES(arena, k);
  p->force_t = NSDAE_ARENA_DOUBLES(arena, kt);
  p->force_s = NSDAE_ARENA_DOUBLES(arena, f);
  p->v_n = NSDAE_ARENA_DOUBLES(arena, k);
  p->v_t = NSDAE_ARENA_DOUBLES(arena, kt);
  p->v_s = NSDAE_ARENA_DOUBLES(arena, f);
  p->lambda = NSDAE_ARENA_DOUBLES(arena, d->m);
  p->U = NSDAE_ARENA_DOUBLES(arena, d->nv * f);
  p->D = NSDAE_ARENA_DOUBLES(arena, d->m * f);
  p->closed = NSDAE_ARENA_INTS(arena, k);
  p->found = NSDAE_ARENA_INTS(arena, k);
  p->since = NSDAE_ARENA_DOUBLES(arena, k);
  p->start_rate = NSDAE_ARENA_DOUBLES(arena, k);
  p->mass = NSDAE_ARENA_DOUBLES(arena, k);
  p->impulse = NSDAE_ARENA_DOUBLES(arena, k);
  p->peak = NSDAE_ARENA_DOUBLES(arena, k);
  p->impulse_t = NSDAE_ARENA_DOUBLES(arena, kt);
}

static int check_law(const nsdae_stepper *s)
{
  if (s->options->penalty_law != NSDAE_PENALTY_FLORES) return NSDAE_OK;
  for (int i = 0; i < s->system->dims.k; i++)
    if (!(s->system->contact[i].e_n > 0))
      return nsdae_error_set(s->error, NSDAE_E_ARGUMENT, "nsdae_sim_create", "e_n",
                             "e_n = 0 of contact %d is outside its range: the law flores needs it "
                             "greater than 0",
                             i);
  return NSDAE_OK;
}

static int create(nsdae_stepper *s)
{
  const nsdae_dims *d = &s->system->dims;
  const nsdae_sim_options *o = s->options;
  if (check_law(s) < 0) return NSDAE_E_ARGUMENT;
  penalty *p = calloc(1, sizeof *p);
  if (!p) return nsdae_error_set(s->error, NSDAE_E_MEMORY, "nsdae_sim_create", "", "out of memory");
  s->own = p;
  p->stepper = s;
  p->n = at_work(d) + 1;
  p->law = (nsdae_penalty_force){o->penalty_law, o->penalty_stiffness, o->penalty_exponent};
  const nsdae_ode_problem problem = {p->n, d->k, rate, gaps, p};
  int status = nsdae_arena_build(&p->arena, layout, p);
  if (status == NSDAE_OK) status = nsdae_ode_create(&problem, o->rtol, o->atol, &p->ode);
  if (status == NSDAE_E_UNSUPPORTED)
    return nsdae_error_set(s->error, status, "nsdae_sim_create", "method",
                           "method penalty needs SUNDIALS, and this library was built without it "
                           "(NSDAE_SUNDIALS=OFF)");
  if (status < 0) nsdae_error_set(s->error, status, "nsdae_sim_create", "", "out of memory");
  return status;
}

static void destroy(nsdae_stepper *s)
{
  penalty *p = s->own;
  if (!p) return;
  nsdae_ode_destroy(&p->ode);
  nsdae_arena_release(&p->arena);
  free(p);
  s->own = NULL;
}

/* A contact closes here: its d'_0, its effective mass 1 / (W_N^T P W_N). */
static int close_contact(penalty *p, int i, double t)
{
  nsdae_stepper *s = p->stepper;
  nsdae_terms *T = &s->middle;
  const nsdae_dims *d = &s->system->dims;
  int n = d->nv, nt = d->nt;
  const double *W = T->W_N + (size_t)i * (size_t)n;
  memcpy(s->r, W, (size_t)n * sizeof *s->r);
  memset(s->impulse, 0, (size_t)d->m * sizeof *s->impulse);
  nsdae_kkt_solve(&s->kkt, 1, s->r, n, s->impulse, d->m);
  double inverse = nsdae_dot(n, W, s->r);
  p->mass[i] = inverse > 0 ? 1 / inverse : 0;
  double velocity = nsdae_dot(n, W, T->v) + T->w_N[i];
  p->closed[i] = 1;
  p->since[i] = t;
  p->start_rate[i] = fmax(-velocity, s->options->friction_velocity);
  p->impulse[i] = p->y[at_normal(d) + i];
  memcpy(p->impulse_t + i * nt, p->y + at_tangential(d) + i * nt, (size_t)nt * sizeof *p->y);
  p->peak[i] = 0;
  return NSDAE_OK;
}

static void open_contact(penalty *p, int i)
{
  nsdae_stepper *s = p->stepper;
  const nsdae_dims *d = &s->system->dims;
  p->closed[i] = 0;
  if (!(p->start_rate[i] > s->options->impact_velocity)) return;
  nsdae_impact *impact = &s->impact[s->impacts++];
  *impact = (nsdae_impact){.time = p->since[i],
                           .contact = i,
                           .velocity_before = -p->start_rate[i],
                           .normal_impulse = p->y[at_normal(d) + i] - p->impulse[i],
                           .velocity_after = p->v_n[i],
                           .peak_force = p->peak[i]};
  for (int j = 0; j < d->nt; j++)
    impact->tangential_impulse[j] =
        p->y[at_tangential(d) + i * d->nt + j] - p->impulse_t[i * d->nt + j];
}

/* Terms, matrices and forces at the point that the integrator is at. */
static int evaluate(penalty *p, double t)
{
  nsdae_stepper *s = p->stepper;
  nsdae_terms *T = &s->middle;
  nsdae_terms_at(T, t, p->y, p->y + s->system->dims.nq);
  int status = nsdae_terms_need(T, RATE_TERMS);
  if (status == NSDAE_OK) status = nsdae_stepper_factor(s, T, T->M);
  if (status == NSDAE_OK) contact_forces(p, T);
  return status;
}

/* Gaps that crossed zero: contacts begin and end, and the integrator starts anew. */
static int switch_contacts(penalty *p, double t)
{
  int status = evaluate(p, t);
  for (int i = 0; i < p->stepper->system->dims.k && status == NSDAE_OK; i++) {
    if (p->found[i] < 0 && !p->closed[i]) status = close_contact(p, i, t);
    if (p->found[i] > 0 && p->closed[i]) open_contact(p, i);
  }
  return status < 0 ? status : nsdae_ode_start(p->ode, t, p->y);
}

static int follow_peaks(penalty *p, double t)
{
  int any = 0, k = p->stepper->system->dims.k;
  for (int i = 0; i < k; i++) any |= p->closed[i];
  if (!any) return NSDAE_OK;
  int status = evaluate(p, t);
  for (int i = 0; i < k; i++)
    if (p->closed[i]) p->peak[i] = fmax(p->peak[i], p->force[i]);
  return status;
}

/* From the state of the step's start: at the beginning, and after a step that failed. */
static int begin(penalty *p)
{
  nsdae_stepper *s = p->stepper;
  const nsdae_dims *d = &s->system->dims;
  memset(p->y, 0, (size_t)p->n * sizeof *p->y);
  memcpy(p->y, s->start.q, (size_t)d->nq * sizeof *p->y);
  memcpy(p->y + d->nq, s->start.v, (size_t)d->nv * sizeof *p->y);
  int status = evaluate(p, s->start.t);
  for (int i = 0; i < d->k && status == NSDAE_OK; i++) {
    p->closed[i] = 0;
    p->start_rate[i] = 1;
    if (!(s->middle.gap[i] > 0)) status = close_contact(p, i, s->start.t);
  }
  return status < 0 ? status : nsdae_ode_start(p->ode, s->start.t, p->y);
}

static int integrator_failed(nsdae_stepper *s, int status, double t, int code)
{
  if (s->error->status != NSDAE_OK) return s->error->status;
  nsdae_error_set(s->error, status, "nsdae_penalty", "rtol",
                  "the integrator failed at t = %.17g with CVODE's code %d: try a larger rtol or a "
                  "smaller penalty_stiffness",
                  t, code);
  s->error->code = code;
  s->error->time = t;
  return status;
}

/* To the end of the step, or until the list of impacts is full: then the step ends early. */
static int integrate(penalty *p, double *t)
{
  nsdae_stepper *s = p->stepper;
  int what = NSDAE_ODE_STEP, code = 0, room = s->impacts_max - s->system->dims.k;
  while (what != NSDAE_ODE_END && *t < s->t_end && s->impacts < room) {
    nsdae_error_clear(s->error);
    int status = nsdae_ode_advance(p->ode, s->t_end, t, p->y, &what, p->found, &code);
    if (status < 0) return integrator_failed(s, status, *t, code);
    s->iterations++;
    status = what == NSDAE_ODE_ROOT ? switch_contacts(p, *t) : follow_peaks(p, *t);
    if (status < 0) return status;
  }
  nsdae_error_clear(s->error);
  return NSDAE_OK;
}

/* A gap that closes or opens just where the step ends, to rounding of its time, is no root that the
 * integrator reports. */
static int switch_at_end(penalty *p, double t)
{
  const nsdae_terms *T = &p->stepper->middle;
  int any = 0, status = evaluate(p, t);
  for (int i = 0; i < p->stepper->system->dims.k && status == NSDAE_OK; i++) {
    double reach = -p->v_n[i] * 1e-9 * p->stepper->options->dt;
    int closes = !p->closed[i] && p->v_n[i] < 0 && T->gap[i] <= reach;
    int opens = p->closed[i] && T->gap[i] > 0 && p->v_n[i] > 0;
    p->found[i] = opens - closes;
    any |= closes || opens;
  }
  return any && status == NSDAE_OK ? switch_contacts(p, t) : status;
}

static int mode_of(const penalty *p, int i, int nt)
{
  double speed = 0;
  if (!p->closed[i]) return NSDAE_MODE_OPEN;
  for (int j = i * nt; j < (i + 1) * nt; j++) speed = hypot(speed, p->v_t[j]);
  return nt > 0 && speed <= p->stepper->options->friction_velocity ? NSDAE_MODE_STICK
                                                                   : NSDAE_MODE_SLIDE;
}

/* What the step did, from the integrals. */
static int read_results(penalty *p, double t)
{
  nsdae_stepper *s = p->stepper;
  nsdae_contacts *c = &s->contacts;
  const nsdae_dims *d = &s->system->dims;
  double h = t - s->start.t;
  int status = switch_at_end(p, t);
  for (int i = 0; i < d->m; i++)
    s->multiplier[i] = (p->y[at_lambda(d) + i] - p->y0[at_lambda(d) + i]) / h;
  for (int i = 0; i < d->k; i++) {
    c->normal[i] = p->y[at_normal(d) + i] - p->y0[at_normal(d) + i];
    c->mode[i] = mode_of(p, i, d->nt);
  }
  for (int i = 0; i < d->k * d->nt; i++)
    c->tangential[i] = p->y[at_tangential(d) + i] - p->y0[at_tangential(d) + i];
  for (int i = 0; i < d->f; i++) {
    double slip = fabs(nsdae_dot(d->nv, s->middle.W_S + i * d->nv, s->middle.v) + s->middle.w_S[i]);
    c->slide_impulse[i] = p->y[at_slide(d) + i] - p->y0[at_slide(d) + i];
    c->slide_mode[i] = slip <= s->options->friction_velocity ? NSDAE_MODE_STICK : NSDAE_MODE_SLIDE;
  }
  s->work = p->y0[at_work(d)] - p->y[at_work(d)];
  return status;
}

static int advance(nsdae_stepper *s, double h)
{
  penalty *p = s->own;
  double t = s->start.t;
  int status = NSDAE_OK;
  (void)h;
  if (!p->running || s->fresh) status = begin(p);
  p->running = 0;
  s->impacts = 0;
  if (status < 0) return status;
  memcpy(p->y0, p->y, (size_t)p->n * sizeof *p->y0);
  status = integrate(p, &t);
  if (status == NSDAE_OK) status = read_results(p, t);
  if (status < 0) return status;
  nsdae_terms_at(&s->end, t, p->y, p->y + s->system->dims.nq);
  s->smooth = 0;
  s->worst_residual = 0;
  p->running = 1;
  return NSDAE_OK;
}

const nsdae_stepping nsdae_stepping_penalty = {
    .name = "penalty",
    .summary = "continuous contact force, integrated by SUNDIALS with error control",
    .advance = advance,
    .create = create,
    .destroy = destroy,
    .finds_impacts = 1};
