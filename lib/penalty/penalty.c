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
#include "progress.h"
#include "stepper.h"
#include "vector.h"

enum {
  RATE_TERMS = NSDAE_TERM_MASS | NSDAE_TERM_FORCE | NSDAE_TERM_PHI | NSDAE_TERM_JACOBIAN |
               NSDAE_TERM_PHI_T | NSDAE_TERM_OMEGA | NSDAE_TERM_GAP | NSDAE_TERM_NORMAL |
               NSDAE_TERM_TANGENT | NSDAE_TERM_BIAS | NSDAE_TERM_SLIDE
};

enum {
  SLIDE_ROUNDS = 50, /* friction on the slides feeds their normal force: rounds of substitution */
  REPLAY_MAX = 256   /* ends of steps since the integrator started; then it starts anew */
};

/* Forces at the last evaluation. */
typedef struct penalty_forces {
  double *normal, *tangential, *slide; /* k, k nt, f */
  double *v_n, *v_t, *v_s;             /* velocities there */
  double *lambda;                      /* m */
  double *U, *D;                       /* nv x f, m x f: a unit friction force on each slide */
} penalty_forces;

/* Where the integrator started last, and the contacts of then: the method's part of the memory. The
 * same start and the same ends of steps lead to the same point, bit by bit. */
typedef struct penalty_base {
  double *t, *y;                     /* 1, n */
  double *since, *start_rate, *mass; /* k: when it closed, d'_0, effective mass */
  double *impulse, *impulse_t;       /* k, k nt: I_N, I_T at closing */
  double *peak;                      /* k: largest force since */
  double *end;                       /* REPLAY_MAX: steps since then ended there, */
  int *ends;                         /* 1: so many */
  int *closed;                       /* k: in contact */
} penalty_base;

typedef struct penalty {
  nsdae_stepper *stepper;
  nsdae_ode *ode;
  nsdae_penalty_force law;
  nsdae_arena arena;
  int n;               /* length of y */
  double *y, *y_start; /* n: now, at the start of the step */
  double *peak;        /* k: largest force of each contact until now */
  double *shift;       /* k: where a gap counts as zero */
  int *found;          /* k: roots */
  penalty_forces at;
  penalty_base base;  /* within the memory of the step in work */
  long stamp, stamps; /* of the memory that the integrator stands at, 0: none; given so far */
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
  const penalty_forces *at = &p->at;
  double regular = p->stepper->options->friction_velocity;
  int nt = s->dims.nt;
  for (int i = 0; i < s->dims.k; i++) {
    const nsdae_coefficients *c = &s->contact[i];
    double speed = 0;
    at->v_n[i] = nsdae_terms_rate(T, T->W_N, T->w_N, i, T->v);
    at->normal[i] = nsdae_penalty_normal(&p->law, -T->gap[i], -at->v_n[i], p->base.start_rate[i],
                                         c->e_n, p->base.mass[i]);
    for (int j = i * nt; j < (i + 1) * nt; j++) {
      at->v_t[j] = nsdae_terms_rate(T, T->W_T, T->w_T, j, T->v);
      speed = hypot(speed, at->v_t[j]);
    }
    double per_speed = nsdae_penalty_friction(c->mu, at->normal[i], speed, regular);
    for (int j = i * nt; j < (i + 1) * nt; j++) at->tangential[j] = per_speed * at->v_t[j];
  }
}

/* One round of substitution for the friction on the slides; how far it moved. */
static double relax_slides(penalty *p, const nsdae_terms *T)
{
  const nsdae_system *s = T->system;
  const penalty_forces *at = &p->at;
  double moved = 0, regular = p->stepper->options->friction_velocity;
  size_t m = (size_t)s->dims.m;
  for (int j = 0; j < s->dims.f; j++) {
    size_t row = (size_t)s->slide[j].constraint;
    double normal = at->lambda[row], v = nsdae_terms_rate(T, T->W_S, T->w_S, j, T->v);
    for (int l = 0; l < s->dims.f; l++) normal += at->D[(size_t)l * m + row] * at->slide[l];
    double force = v * nsdae_penalty_friction(s->slide[j].mu, fabs(normal), v, regular);
    moved = fmax(moved, fabs(force - at->slide[j]) / (1 + fabs(force)));
    at->v_s[j] = v;
    at->slide[j] = force;
  }
  return moved;
}

/* Friction on the slides, with U and D of their directions; a and lambda are free of it before. */
static int slide_forces(penalty *p, const nsdae_terms *T, double *a)
{
  const penalty_forces *at = &p->at;
  int n = T->system->dims.nv, m = T->system->dims.m, f = T->system->dims.f;
  double moved = 1;
  memcpy(at->U, T->W_S, (size_t)n * (size_t)f * sizeof *at->U);
  memset(at->D, 0, (size_t)m * (size_t)f * sizeof *at->D);
  nsdae_kkt_solve(&p->stepper->kkt, f, at->U, n, at->D, m);
  memset(at->slide, 0, (size_t)f * sizeof *at->slide);
  for (int round = 0; moved > 1e-14 && round < SLIDE_ROUNDS; round++) moved = relax_slides(p, T);
  nsdae_add_product(n, f, at->U, at->slide, a);
  nsdae_add_product(m, f, at->D, at->slide, at->lambda);
  return moved > 1e-8 ? 1 : 0; /* no convergence: a smaller step */
}

/* a [nv] and lambda of the forces at the terms' point. */
static int accelerations(penalty *p, nsdae_terms *T, double *a)
{
  nsdae_stepper *s = p->stepper;
  const nsdae_dims *d = &s->system->dims;
  const penalty_forces *at = &p->at;
  double alpha = s->options->baumgarte_alpha, beta = s->options->baumgarte_beta;
  contact_forces(p, T);
  memcpy(a, T->F, (size_t)d->nv * sizeof *a);
  nsdae_add_product(d->nv, d->k, T->W_N, at->normal, a);
  nsdae_add_product(d->nv, d->k * d->nt, T->W_T, at->tangential, a);
  for (int i = 0; i < d->m; i++) {
    double rate = nsdae_terms_constraint_rate(T, i, T->v);
    at->lambda[i] = -T->omega[i] - 2 * alpha * rate - beta * beta * T->phi[i];
  }
  nsdae_kkt_solve(&s->kkt, 1, a, d->nv, at->lambda, d->m);
  return d->f > 0 ? slide_forces(p, T, a) : 0;
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
  if (status == NSDAE_OK) status = nsdae_kinematics_at(T, T->v, ydot);
  if (status < 0) return nsdae_progress_code(status, s->error);
  int code = accelerations(p, T, ydot + d->nq), kt = d->k * d->nt;
  const penalty_forces *at = &p->at;
  memcpy(ydot + at_lambda(d), at->lambda, (size_t)d->m * sizeof *ydot);
  memcpy(ydot + at_normal(d), at->normal, (size_t)d->k * sizeof *ydot);
  memcpy(ydot + at_tangential(d), at->tangential, (size_t)kt * sizeof *ydot);
  memcpy(ydot + at_slide(d), at->slide, (size_t)d->f * sizeof *ydot);
  ydot[at_work(d)] = -nsdae_dot(d->k, at->normal, at->v_n) -
                     nsdae_dot(kt, at->tangential, at->v_t) - nsdae_dot(d->f, at->slide, at->v_s);
  return code;
}

static int gaps(double t, const double *y, double *g, void *user)
{
  penalty *p = user;
  nsdae_terms *T = &p->stepper->middle;
  nsdae_terms_at(T, t, y, y + p->stepper->system->dims.nq);
  int status = nsdae_terms_need(T, NSDAE_TERM_GAP);
  if (status < 0) return -1;
  for (int i = 0; i < p->stepper->system->dims.k; i++) g[i] = T->gap[i] - p->shift[i];
  return 0;
}

static void layout(void *object, nsdae_arena *arena)
{
  penalty *p = object;
  const nsdae_dims *d = &p->stepper->system->dims;
  penalty_forces *at = &p->at;
  long k = d->k, kt = k * d->nt, f = d->f;
  p->y = NSDAE_ARENA_DOUBLES(arena, p->n);
  p->y_start = NSDAE_ARENA_DOUBLES(arena, p->n);
  p->peak = NSDAE_ARENA_DOUBLES(arena, k);
  p->shift = NSDAE_ARENA_DOUBLES(arena, k);
  p->found = NSDAE_ARENA_INTS(arena, k);
  at->normal = NSDAE_ARENA_DOUBLES(arena, k);
  at->tangential = NSDAE_ARENA_DOUBLES(arena, kt);
  at->slide = NSDAE_ARENA_DOUBLES(arena, f);
  at->v_n = NSDAE_ARENA_DOUBLES(arena, k);
  at->v_t = NSDAE_ARENA_DOUBLES(arena, kt);
  at->v_s = NSDAE_ARENA_DOUBLES(arena, f);
  at->lambda = NSDAE_ARENA_DOUBLES(arena, d->m);
  at->U = NSDAE_ARENA_DOUBLES(arena, d->nv * f);
  at->D = NSDAE_ARENA_DOUBLES(arena, d->m * f);
}

/* The base behind the warm start of the contacts. */
static void lay(penalty_base *b, const nsdae_stepper *s, nsdae_memory_part *part)
{
  const nsdae_dims *d = &s->system->dims;
  size_t k = (size_t)d->k;
  double **of_contact[] = {&b->since, &b->start_rate, &b->mass, &b->impulse, &b->peak};
  b->t = nsdae_memory_reals(part, 1);
  b->y = nsdae_memory_reals(part, (size_t)at_work(d) + 1);
  for (int i = 0; i < 5; i++) *of_contact[i] = nsdae_memory_reals(part, k);
  b->impulse_t = nsdae_memory_reals(part, k * (size_t)d->nt);
  b->end = nsdae_memory_reals(part, REPLAY_MAX);
  nsdae_memory_wholes(part, nsdae_contacts_memory_size(&s->contacts));
  b->ends = nsdae_memory_wholes(part, 1);
  b->closed = nsdae_memory_wholes(part, k);
}

static void sizes(const nsdae_stepper *s, size_t *reals, size_t *wholes)
{
  penalty_base base;
  nsdae_memory_part part = {0};
  lay(&base, s, &part);
  *reals = part.reals;
  *wholes = part.wholes;
}

/* Lays the base over the memory of a step. */
static void find_base(penalty *p, nsdae_memory *memory)
{
  nsdae_memory_part part = {.real = memory->real, .whole = memory->whole};
  lay(&p->base, p->stepper, &part);
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

static int prepare(void *own)
{
  penalty *p = own;
  const nsdae_sim_options *o = p->stepper->options;
  p->law = (nsdae_penalty_force){o->penalty_law, o->penalty_stiffness, o->penalty_exponent};
  nsdae_ode_tolerances(p->ode, o->rtol, o->atol);
  return check_law(p->stepper);
}

static int create(nsdae_stepper *s, void **own)
{
  penalty *p = calloc(1, sizeof *p);
  *own = p;
  if (!p) return nsdae_error_set(s->error, NSDAE_E_MEMORY, "nsdae_sim_create", "", "out of memory");
  p->stepper = s;
  p->n = at_work(&s->system->dims) + 1;
  const nsdae_ode_problem problem = {
      .n = p->n, .roots = s->system->dims.k, .rate = rate, .root = gaps, .user = p};
  int status = nsdae_arena_build(&p->arena, layout, p);
  if (status == NSDAE_OK)
    status = nsdae_ode_create(&problem, s->options->rtol, s->options->atol, &p->ode);
  if (status == NSDAE_E_UNSUPPORTED)
    return nsdae_error_set(s->error, status, "nsdae_sim_create", "method",
                           "method penalty needs SUNDIALS, and this library was built without it "
                           "(NSDAE_SUNDIALS=OFF)");
  if (status < 0) return nsdae_error_set(s->error, status, "nsdae_sim_create", "", "out of memory");
  return prepare(p);
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
  const nsdae_system *s = p->stepper->system;
  const nsdae_sim_options *o = p->stepper->options;
  const double hair = 1e-12 * o->dt * o->friction_velocity;
  nsdae_terms *T = &p->stepper->middle;
  nsdae_terms_at(T, t, p->y, p->y + s->dims.nq);
  int status = nsdae_terms_need(T, NSDAE_TERM_GAP);
  for (int i = 0; i < s->dims.k && status == NSDAE_OK; i++) {
    double gap = T->gap[i];
    int wrong = p->base.closed[i] ? gap >= 0 : gap <= 0;
    p->shift[i] = wrong ? 2 * gap + (p->base.closed[i] ? hair : -hair) : 0;
  }
  return status < 0 ? status : nsdae_ode_start(p->ode, t, p->y);
}

/* Here the integrator starts anew. */
static void move_base(penalty *p, double t)
{
  penalty_base *b = &p->base;
  *b->t = t;
  *b->ends = 0;
  memcpy(b->y, p->y, (size_t)p->n * sizeof *b->y);
  memcpy(b->peak, p->peak, (size_t)p->stepper->system->dims.k * sizeof *b->peak);
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
  nsdae_stepper *s = p->stepper;
  const nsdae_terms *T = &s->middle;
  const nsdae_dims *d = &s->system->dims;
  penalty_base *b = &p->base;
  size_t n = (size_t)d->nv, nt = (size_t)d->nt, first = (size_t)i * nt;
  memcpy(s->r, T->W_N + (size_t)i * n, n * sizeof *s->r);
  memset(s->impulse, 0, (size_t)d->m * sizeof *s->impulse);
  nsdae_kkt_solve(&s->kkt, 1, s->r, d->nv, s->impulse, d->m);
  double inverse = nsdae_dot(d->nv, T->W_N + (size_t)i * n, s->r);
  b->mass[i] = inverse > 0 ? 1 / inverse : 0;
  b->closed[i] = 1;
  b->since[i] = t;
  b->start_rate[i] =
      fmax(-nsdae_terms_rate(T, T->W_N, T->w_N, i, T->v), s->options->friction_velocity);
  b->impulse[i] = p->y[at_normal(d) + i];
  memcpy(b->impulse_t + first, p->y + (size_t)at_tangential(d) + first, nt * sizeof *p->y);
  p->peak[i] = 0;
}

static void open_contact(penalty *p, nsdae_result *result, int i)
{
  const nsdae_dims *d = &p->stepper->system->dims;
  const penalty_base *b = &p->base;
  b->closed[i] = 0;
  if (!(b->start_rate[i] > p->stepper->options->impact_velocity)) return;
  nsdae_impact *impact = &result->impact[result->impacts++];
  *impact = (nsdae_impact){.time = b->since[i],
                           .contact = i,
                           .velocity_before = -b->start_rate[i],
                           .normal_impulse = p->y[at_normal(d) + i] - b->impulse[i],
                           .velocity_after = p->at.v_n[i],
                           .peak_force = p->peak[i]};
  for (int l = 0, j = i * d->nt; l < d->nt; l++, j++)
    impact->tangential_impulse[l] = p->y[at_tangential(d) + j] - b->impulse_t[j];
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

/* Gaps that crossed zero: contacts begin and end, and the integrator starts anew. A gap within its
 * rounding crosses zero any number of times: a contact opens while it moves apart alone, and closes
 * while it does not. CVODE refuses to go on from a root without a new start. */
static int switch_contacts(penalty *p, nsdae_result *result, double t)
{
  int status = evaluate(p, t);
  for (int i = 0; i < p->stepper->system->dims.k && status == NSDAE_OK; i++) {
    double v_n = p->at.v_n[i];
    int closes = p->found[i] < 0 && !p->base.closed[i] && v_n <= 0;
    int opens = p->found[i] > 0 && p->base.closed[i] && v_n > 0;
    if (closes) close_contact(p, i, t);
    if (opens) open_contact(p, result, i);
  }
  return status < 0 ? status : start(p, t);
}

/* How near a contact is at hand that moves with v_n: less than a billionth of dt away. */
static double reach(const penalty *p, int i)
{
  return fmax(-p->at.v_n[i], 0) * 1e-9 * p->stepper->options->dt;
}

static int follow_peaks(penalty *p, double t)
{
  int any = 0, k = p->stepper->system->dims.k;
  for (int i = 0; i < k; i++) any |= p->base.closed[i];
  if (!any) return NSDAE_OK;
  int status = evaluate(p, t);
  for (int i = 0; i < k; i++)
    if (p->base.closed[i]) p->peak[i] = fmax(p->peak[i], p->at.normal[i]);
  return status;
}

/* From a state that this method did not lead to. */
static int begin(penalty *p, const nsdae_terms *from)
{
  nsdae_stepper *s = p->stepper;
  const nsdae_dims *d = &s->system->dims;
  memset(p->y, 0, (size_t)p->n * sizeof *p->y);
  memcpy(p->y, from->q, (size_t)d->nq * sizeof *p->y);
  memcpy(p->y + d->nq, from->v, (size_t)d->nv * sizeof *p->y);
  for (int i = 0; i < d->k; i++) {
    p->base.closed[i] = 0;
    p->base.start_rate[i] = 1;
  }
  int status = evaluate(p, from->t);
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
                  t, code);
  s->error->code = code;
  s->error->time = t;
  return status;
}

/* One step of the integrator towards t_end. */
static int one_step(penalty *p, double t_end, double *t, int *what)
{
  int code = 0;
  nsdae_error_clear(p->stepper->error);
  int status = nsdae_ode_advance(p->ode, t_end, t, p->y, what, p->found, &code);
  return status < 0 ? integrator_failed(p->stepper, status, *t, code) : NSDAE_OK;
}

/* The end of a step, for a replay; after too many the integrator starts anew. */
static int keep_end(penalty *p, double t_end, double t)
{
  const penalty_base *b = &p->base;
  if (*b->ends > 0 && b->end[*b->ends - 1] == t_end) return NSDAE_OK;
  int status = *b->ends == REPLAY_MAX ? start(p, t) : NSDAE_OK;
  b->end[(*b->ends)++] = t_end;
  return status;
}

/* What may help where too many steps of the integrator lead to too little. */
static const char advice[] =
    "make dt or penalty_stiffness smaller, or inner_steps_max or rtol larger";

/* To the end of the step, or until the list of impacts is full: then the step ends early. */
static int integrate(penalty *p, nsdae_result *result, double t_end, double *t)
{
  int what = NSDAE_ODE_STEP, room = result->impacts_max - p->stepper->system->dims.k;
  while (what != NSDAE_ODE_END && *t < t_end && result->impacts < room) {
    int status = keep_end(p, t_end, *t);
    if (status == NSDAE_OK) status = one_step(p, t_end, t, &what);
    if (status < 0) return status;
    result->counters.iterations++;
    status = what == NSDAE_ODE_ROOT ? switch_contacts(p, result, *t) : follow_peaks(p, *t);
    if (status == NSDAE_OK)
      status = nsdae_stepper_goes_on(p->stepper, "nsdae_penalty", advice, *t, t_end);
    if (status < 0) return status;
  }
  return NSDAE_OK;
}

/* The integrator's point is the state's, to the last bit. */
static int stands_at(const penalty *p, const nsdae_terms *to, double t)
{
  const nsdae_dims *d = &p->stepper->system->dims;
  return t == to->t && memcmp(p->y, to->q, (size_t)d->nq * sizeof *p->y) == 0 &&
         memcmp(p->y + d->nq, to->v, (size_t)d->nv * sizeof *p->y) == 0;
}

/* From the base to the state again. Where callbacks do not give the same numbers as then, it is
 * the state that holds, and the integrator starts anew there. */
static int replay(penalty *p, const nsdae_terms *to)
{
  const nsdae_dims *d = &p->stepper->system->dims;
  const penalty_base *b = &p->base;
  double t = *b->t;
  memcpy(p->y, b->y, (size_t)p->n * sizeof *p->y);
  memcpy(p->peak, b->peak, (size_t)d->k * sizeof *p->peak);
  int status = start_integrator(p, t);
  for (int i = 0; i < *b->ends && status == NSDAE_OK; i++) {
    int what = NSDAE_ODE_STEP;
    while (status == NSDAE_OK && what != NSDAE_ODE_END && t < b->end[i]) {
      status = one_step(p, b->end[i], &t, &what);
      if (status == NSDAE_OK) status = follow_peaks(p, t);
    }
  }
  if (status < 0 || stands_at(p, to, t)) return status;
  memcpy(p->y, to->q, (size_t)d->nq * sizeof *p->y);
  memcpy(p->y + d->nq, to->v, (size_t)d->nv * sizeof *p->y);
  return start(p, to->t);
}

/* A gap that closes or opens just where the step ends, to rounding of its time, is no root that the
 * integrator reports. */
static int switch_at_end(penalty *p, nsdae_result *result, double t)
{
  const nsdae_terms *T = &p->stepper->middle;
  int any = 0, status = evaluate(p, t);
  for (int i = 0; i < p->stepper->system->dims.k && status == NSDAE_OK; i++) {
    double v_n = p->at.v_n[i];
    int closes = !p->base.closed[i] && v_n < 0 && T->gap[i] <= reach(p, i);
    int opens = p->base.closed[i] && T->gap[i] > 0 && v_n > 0;
    p->found[i] = opens - closes;
    any |= closes || opens;
  }
  return any && status == NSDAE_OK ? switch_contacts(p, result, t) : status;
}

static int mode_of(const penalty *p, int i, int nt)
{
  double speed = nsdae_norm(nt, p->at.v_t + i * nt);
  if (!p->base.closed[i]) return NSDAE_MODE_OPEN;
  return nt > 0 && speed <= p->stepper->options->friction_velocity ? NSDAE_MODE_STICK
                                                                   : NSDAE_MODE_SLIDE;
}

/* to [n] := what the step added to the integrals from entry first on. */
static void integrals(const penalty *p, int first, int n, double *to)
{
  for (int i = 0; i < n; i++) to[i] = p->y[first + i] - p->y_start[first + i];
}

/* What the step did, from the integrals. */
static void read_results(const penalty *p, nsdae_result *result, double t, double h)
{
  const nsdae_terms *T = &p->stepper->middle;
  const nsdae_dims *d = &T->system->dims;
  nsdae_impulses *to = &result->impulses;
  integrals(p, at_lambda(d), d->m, result->multiplier);
  for (int i = 0; i < d->m; i++) result->multiplier[i] /= h;
  integrals(p, at_normal(d), d->k, to->normal);
  integrals(p, at_tangential(d), d->k * d->nt, to->tangential);
  integrals(p, at_slide(d), d->f, to->slide_impulse);
  for (int i = 0; i < d->k; i++) to->mode[i] = mode_of(p, i, d->nt);
  for (int j = 0; j < d->f; j++) {
    double slip = fabs(nsdae_terms_rate(T, T->W_S, T->w_S, j, T->v));
    int sticks = slip <= p->stepper->options->friction_velocity;
    to->slide_mode[j] = sticks ? NSDAE_MODE_STICK : NSDAE_MODE_SLIDE;
  }
  result->work = p->y_start[at_work(d)] - p->y[at_work(d)];
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
  find_base(p, &result->memory);
  int status = arrive(p, state, &result->counters);
  p->stamp = 0;
  if (status == NSDAE_OK) move_base(p, state->terms->t);
  return status;
}

static int advance(void *own, const nsdae_state *state, double t_end, nsdae_result *result)
{
  penalty *p = own;
  double t = state->terms->t;
  find_base(p, &result->memory);
  int status = arrive(p, state, &result->counters);
  p->stamp = 0;
  if (status < 0) return status;
  memcpy(p->y_start, p->y, (size_t)p->n * sizeof *p->y);
  status = integrate(p, result, t_end, &t);
  if (status == NSDAE_OK) status = switch_at_end(p, result, t);
  if (status < 0) return status;
  nsdae_error_clear(p->stepper->error); /* of callbacks that a smaller step helped */
  read_results(p, result, t, t - state->terms->t);
  result->memory.stamp = p->stamp = ++p->stamps;
  return NSDAE_OK;
}

const nsdae_stepping nsdae_stepping_penalty = {
    .name = "penalty",
    .summary = "continuous contact force, integrated by SUNDIALS with error control",
    .create = create,
    .destroy = destroy,
    .sizes = sizes,
    .prepare = prepare,
    .settle = settle,
    .advance = advance};
