/* A start is taken as far as it was meant: with the relative error tol = start_tol of its numbers a
 * row has the error tol |row|_1 max |x|, of its coordinates for a position and of its velocities
 * for a velocity. The 1 stands for constants of order one that are not seen in the row. So
 *
 *   |Phi_i|, -g_N,i        <= tol (1 + |Phi_q,i|_1 max |q|),   tol (1 + |W_N,i|_1 max |q|)
 *   |Phi_q v + Phi_t|_i    <= tol (1 + |Phi_q,i|_1 max |v| + |Phi_t,i|)
 *   | |q_unit| - 1 |       <= tol
 *
 * tol = 1e-6 takes numbers of six digits. Overlap beyond its bound is an error of event, a warning
 * of time stepping, and the contact force of penalty (start_overlap.c). */

#include <float.h>
#include <limits.h>
#include <math.h>
#include <string.h>

#include "listed.h"
#include "equations.h"
#include "sim_impl.h"
#include "system_impl.h"
#include "tangent_check.h"

static int refuse_start(const nsdae_terms *T, const char *argument, int kind, int i,
                        const char *what, double value, double bound)
{
  char called[NSDAE_CALLED_SIZE];
  nsdae_error_set(T->error, NSDAE_E_ARGUMENT, "nsdae_sim_init", argument,
                  "%s %s %.6g at the start: it must be at most %.3g (see start_tol); "
                  "nsdae_sim_project corrects it",
                  nsdae_system_called(T->system, kind, i, called), what, value, bound);
  return nsdae_error_at(T->error, NSDAE_E_ARGUMENT, i, nsdae_terms_time(T));
}

static int check_constraints(const nsdae_terms *T, double tol)
{
  const nsdae_dims *d = &T->system->dims;
  const nsdae_blocks *blocks = &T->system->blocks;
  const nsdae_rows *J = &T->by.jacobian;
  double q = nsdae_largest(d->nq, T->q), v = nsdae_largest(d->nv, T->v);
  for (int i = 0; i < d->m; i++) {
    double sum = nsdae_rows_sum(blocks, J, i), bound = tol * (1 + sum * q);
    if (fabs(T->constraint.phi[i]) > bound)
      return refuse_start(T, "q0", NSDAE_NAME_CONSTRAINT, i, "is violated by",
                          fabs(T->constraint.phi[i]), bound);
    double rate = nsdae_rows_add_dot(blocks, J, i, T->v, T->constraint.phi_t[i]);
    bound = tol * (1 + sum * v + fabs(T->constraint.phi_t[i]));
    if (fabs(rate) > bound)
      return refuse_start(T, "v0", NSDAE_NAME_CONSTRAINT, i, "is violated at the rate", fabs(rate),
                          bound);
  }
  return NSDAE_OK;
}

/* A quaternion has length one; two coordinates may as well be a point on a circle. The group
 * is the one that coordinate `first` begins. */
static int is_rotation(const nsdae_units *u, int nq, int first)
{
  int size = 0, group = u->of[first];
  if (fabs(u->length[group] - 1) < 0.1) return 1;
  for (int i = first; i < nq && size < 4; i++) size += u->of[i] == group;
  return size == 4;
}

/* The coordinate, from `after` on, that begins the group; they are numbered in this order. */
static int next_group(const nsdae_units *u, int group, int after)
{
  int first = after;
  while (u->of[first] != group) first++;
  return first;
}

/* ---- derivatives with v = 0 and along two trial velocities: a few calls, whatever the size */

/* One of the two relations that derivatives are given of: constraints and gaps. */
typedef struct relation {
  const char *derivative; /* the callback that is judged, */
  const char *moving;     /* and that of its motion with v = 0; NULL: there is none */
  int kind, rows;
  nsdae_position_fn position;
  const double *value; /* rows: at the start */
  const nsdae_rows *rate;
  const double *bias; /* rows: the rate with v = 0 */
} relation;

enum { STILL = -1, TRIALS = 2 };

static void trial_velocity(int n, int number, double *v)
{
  for (int j = 0; j < n; j++)
    v[j] = number == STILL ? 0 : cos(1 + number + 2.399963 * (j + 1)); /* no two alike */
}

static int wrong_rate(const nsdae_terms *T, const char *callback, int kind, int i, int number,
                      double given, double difference)
{
  char called[NSDAE_CALLED_SIZE];
  nsdae_error_set(T->error, NSDAE_E_DERIVATIVE, "nsdae_sim_init", callback,
                  "%s: %s has the rate %.6g %s, differences give %.6g; nsdae_system_check names "
                  "the entry (start_check = no accepts it)",
                  callback, nsdae_system_called(T->system, kind, i, called), given,
                  number == STILL ? "with v = 0" : "along a trial velocity", difference);
  return nsdae_error_at(T->error, NSDAE_E_DERIVATIVE, i, nsdae_terms_time(T));
}

/* Formulas of the kit are not differenced: they are tested once for all, and have kinks where
 * edges are equally near. Where a relation has a kink at the start its derivative is that of one
 * side; of what jumps, as the gap of two edges where they are parallel, differences say nothing.
 * Gross errors are what is looked for, signs and places: 1e-3 of the terms, above the rounding of
 * the differences. */
static int judge_rates(const nsdae_terms *T, const relation *r, int number, const double *v,
                       double s)
{
  const nsdae_differences *d = T->differences;
  const nsdae_blocks *blocks = &T->system->blocks;
  for (int i = 0; i < r->rows; i++) {
    if (nsdae_system_exact(T->system, r->kind, i)) continue;
    /* W v + w of a row, and the sum of its terms */
    double given = nsdae_rows_add_dot(blocks, r->rate, i, v, r->bias[i]), size = fabs(r->bias[i]);
    for (int p = r->rate->first[i]; p < r->rate->first[i + 1]; p++) {
      const double *value = r->rate->value + r->rate->at[p],
                   *u = v + blocks->first[r->rate->block[p]];
      for (int j = 0; j < nsdae_blocks_size(blocks, r->rate->block[p]); j++)
        size += fabs(value[(size_t)j * r->rate->stride] * u[j]);
    }
    double ahead = (d->plus[i] - r->value[i]) / s, back = (r->value[i] - d->minus[i]) / s;
    double middle = (ahead + back) / 2;
    if (!isfinite(middle)) continue;                     /* the end of where it is defined */
    if (fabs(ahead - back) > 1e3 * (size + 1)) continue; /* a jump, over the step */
    double tol = 1e-3 * (size + fabs(middle)) + 1e-9 * (1 + fabs(r->value[i]));
    if (fabs(given - middle) <= tol || fabs(given - ahead) <= tol || fabs(given - back) <= tol)
      continue;
    return wrong_rate(T, number == STILL ? r->moving : r->derivative, r->kind, i, number, given,
                      middle);
  }
  return NSDAE_OK;
}

static int displaced(const nsdae_terms *T, const relation *r, double s, double *value)
{
  nsdae_differences *d = T->differences;
  const nsdae_system *system = T->system;
  for (int i = 0; i < system->dims.nq; i++) d->q[i] = T->q[i] + s * d->qdot[i];
  memset(value, 0, (size_t)r->rows * sizeof *value);
  int code = r->position(nsdae_terms_time(T) + s, d->q, value, system->user);
  return nsdae_system_callback_status(code, r->kind == NSDAE_NAME_CONTACT ? "gap" : "constraint",
                                      nsdae_terms_time(T), T->error);
}

/* What is wrong in the usual step is looked at in a far shorter one: a pin that is off the middle
 * of its hole by less than the step, as by microns of clearance, turns its normal within it. */
static int check_rates(nsdae_projector *p, const nsdae_terms *T, const relation *r)
{
  const double shorter = 1e-3;
  nsdae_differences *d = T->differences;
  const nsdae_dims *dims = &T->system->dims;
  for (int number = r->moving ? STILL : 0; number < TRIALS; number++) {
    trial_velocity(dims->nv, number, p->v);
    int status = nsdae_kinematics_at(T, p->v, d->qdot);
    if (status < 0) return status;
    double s =
        nsdae_differences_step(dims->nq, nsdae_terms_time(T), T->q, d->qdot, cbrt(DBL_EPSILON));
    status = NSDAE_E_DERIVATIVE;
    for (int finer = 0; finer < 2 && status == NSDAE_E_DERIVATIVE; finer++, s *= shorter) {
      nsdae_error_clear(T->error);
      status = displaced(T, r, s, d->plus);
      if (status == NSDAE_OK) status = displaced(T, r, -s, d->minus);
      if (status == NSDAE_OK) status = judge_rates(T, r, number, p->v, s);
    }
    if (status < 0) return status;
  }
  return NSDAE_OK;
}

/* A row of Phi_q that vanishes where Phi = 0, though Phi does not, as of the square of a
 * constraint: no multiplier holds it. Along each trial velocity Phi is even in s: its first order
 * is less than 1e-3 of the second, which is above rounding. */
static int check_gradients(nsdae_projector *p, const nsdae_terms *T, const relation *r)
{
  const double none = 1e-6,
               s = 1e-3; /* above differences; terms of third order are s of the second */
  nsdae_differences *d = T->differences;
  char called[NSDAE_CALLED_SIZE];
  for (int i = 0; i < r->rows; i++) {
    int even = nsdae_rows_largest(&T->system->blocks, r->rate, i) < none;
    for (int number = 0; number < TRIALS && even; number++) {
      trial_velocity(T->system->dims.nv, number, p->v);
      int status = nsdae_kinematics_at(T, p->v, d->qdot);
      if (status == NSDAE_OK) status = displaced(T, r, s, d->plus);
      if (status == NSDAE_OK) status = displaced(T, r, -s, d->minus);
      if (status < 0) return status;
      double first = fabs(d->plus[i] - d->minus[i]) / 2;
      double second = fabs((d->plus[i] + d->minus[i]) / 2 - r->value[i]);
      even = second > s * s * none && first < 10 * s * second;
    }
    if (!even) continue;
    nsdae_error_set(T->error, NSDAE_E_RANK, "nsdae_sim_init", "constraint",
                    "the gradient of %s is zero at the start, and Phi is of second order there, as "
                    "the square of a constraint: give the constraint itself (start_check = no "
                    "accepts it)",
                    nsdae_system_called(T->system, NSDAE_NAME_CONSTRAINT, i, called));
    return nsdae_error_at(T->error, NSDAE_E_RANK, i, nsdae_terms_time(T));
  }
  return NSDAE_OK;
}

/* ---- accelerations, against differences of usual and of a thousand times finer steps */

enum { FINER = 10 };

static int agree(double given, double second, double rounding)
{
  double size = fabs(given) + fabs(second);
  return !isfinite(second) || fabs(given - second) <= 1e-3 * size + rounding * (1 + size);
}

/* Second rates along p->v by differences: of constraints, or of contacts and frictional joints, one
 * behind the other. */
static int second_rates(nsdae_projector *p, const nsdae_terms *T, int kind, int shorter,
                        double *out)
{
  const nsdae_system *s = T->system;
  nsdae_differences *d = T->differences;
  double t = nsdae_terms_time(T), *tangential = out + s->dims.k;
  int constraints = kind == NSDAE_NAME_CONSTRAINT, code;
  d->finer[1] = shorter;
  if (constraints)
    code = nsdae_differences_second(d, s->call.constraint, s->dims.m, t, T->q, p->v, out);
  else
    code = nsdae_differences_contacts(d, t, T->q, p->v, out, tangential,
                                      tangential + s->dims.k * s->dims.nt);
  d->finer[1] = 0;
  const char *callback = constraints ? "constraint" : "contact_bias";
  return nsdae_system_callback_status(code, code && d->failed ? d->failed : callback, t, T->error);
}

/* The first acceleration of the user's that neither differences have, of `count` entries, each of
 * one item. What is fast is right in finer steps; where those say something else again, as of a pin
 * in the very middle of its hole, nothing is known. */
static int judge_accelerations(const nsdae_terms *T, const char *callback, int kind, int each,
                               int count, const double *given, const double *second,
                               const double *finer)
{
  for (int i = 0; i < count; i++) {
    if (nsdae_system_exact(T->system, kind, i / each)) continue;
    double off = fabs(given[i] - finer[i]); /* NaN: wrong */
    if (agree(given[i], second[i], 1e-6) || agree(given[i], finer[i], 1e-3)) continue;
    if (!(fabs(second[i] - finer[i]) > 0.1 * off))
      return wrong_rate(T, callback, kind, i / each, 0, given[i], second[i]);
  }
  return NSDAE_OK;
}

/* omega, which the rates do not have: Phi'' with v constant. */
static int check_omega(nsdae_projector *p, const nsdae_terms *T)
{
  const nsdae_system *s = T->system;
  int m = s->dims.m;
  double *finer = p->start, *omega = p->start + m, *second = p->start + 2 * m;
  double t = nsdae_terms_time(T);
  if (!s->call.constraint_bias) return NSDAE_OK;
  trial_velocity(s->dims.nv, 0, p->v);
  memset(p->start, 0, 3 * (size_t)m * sizeof *p->start);
  int code = s->call.constraint_bias(t, T->q, p->v, finer, omega, s->user); /* and Phi_t */
  int status = nsdae_system_callback_status(code, "constraint_bias", t, T->error);
  if (status == NSDAE_OK) status = second_rates(p, T, NSDAE_NAME_CONSTRAINT, 0, second);
  if (status == NSDAE_OK) status = second_rates(p, T, NSDAE_NAME_CONSTRAINT, FINER, finer);
  if (status < 0) return status;
  return judge_accelerations(T, "constraint_bias", NSDAE_NAME_CONSTRAINT, 1, m, omega, second,
                             finer);
}

/* The same of contacts and frictional joints, which only event uses. */
static int check_acceleration(nsdae_projector *p, const nsdae_terms *T, double *work)
{
  const nsdae_system *s = T->system;
  const nsdae_dims *dims = &s->dims;
  int k = dims->k, kt = k * dims->nt, n = k + kt + dims->f;
  double *given = work, *second = work + n, *finer = second + n, t = nsdae_terms_time(T);
  if (!s->call.contact_acceleration || p->tools->options->method != NSDAE_METHOD_EVENT)
    return NSDAE_OK;
  trial_velocity(dims->nv, 0, p->v);
  memset(given, 0, (size_t)n * sizeof *given);
  int code = s->call.contact_acceleration(t, T->q, p->v, k ? given : NULL, kt ? given + k : NULL,
                                          dims->f ? given + k + kt : NULL, s->user);
  int status = nsdae_system_callback_status(code, "contact_acceleration", t, T->error);
  if (status == NSDAE_OK) status = second_rates(p, T, NSDAE_NAME_CONTACT, 0, second);
  if (status == NSDAE_OK) status = second_rates(p, T, NSDAE_NAME_CONTACT, FINER, finer);
  const int parts[][3] = {{NSDAE_NAME_CONTACT, 1, k},
                          {NSDAE_NAME_CONTACT, dims->nt, kt},
                          {NSDAE_NAME_FRICTIONAL_JOINT, 1, dims->f}};
  for (int part = 0, at = 0; part < 3 && status == NSDAE_OK; at += parts[part++][2])
    status = judge_accelerations(T, "contact_acceleration", parts[part][0], parts[part][1],
                                 parts[part][2], given + at, second + at, finer + at);
  return status;
}

/* Directions of friction that nothing can rub along. */
static int check_tangents(const nsdae_terms *T)
{
  const nsdae_system *s = T->system;
  const nsdae_dims *d = &s->dims;
  char called[NSDAE_CALLED_SIZE], why[NSDAE_TANGENT_TEXT];
  size_t n = (size_t)d->nv;
  for (int j = 0; s->call.gap_tangent && j < d->k * d->nt; j++) {
    size_t i = (size_t)(j / d->nt);
    const nsdae_contact_directions c = {s,
                                        d->nv,
                                        d->nt,
                                        NULL,
                                        T->by.normal.value + i * n,
                                        NULL,
                                        T->by.tangent.value + i * (size_t)d->nt * n};
    if (nsdae_system_exact(s, NSDAE_NAME_CONTACT, (int)i)) continue;
    if (!(s->contact[i].mu > 0) || !nsdae_tangent_useless(&c, j % d->nt, 0, why)) continue;
    return nsdae_error_set(T->error, NSDAE_E_DERIVATIVE, "nsdae_sim_init", "gap_tangent",
                           "gap_tangent: column %d (%s) %s (start_check = no accepts it)", j,
                           nsdae_system_called(s, NSDAE_NAME_CONTACT, (int)i, called), why);
  }
  return NSDAE_OK;
}

/* Whether any row of a kind has derivatives of the user's. */
static int any_users(const nsdae_system *s, int kind, int rows)
{
  int i = 0;
  while (i < rows && nsdae_system_exact(s, kind, i)) i++;
  return i < rows;
}

/* Late times leave too few digits to steps in time, so that nothing is reported there. */
static int check_derivatives(nsdae_projector *p, const nsdae_terms *T, double *work)
{
  const nsdae_system *s = T->system;
  const nsdae_dims *d = &s->dims;
  const relation constraints = {nsdae_system_jacobian_name(s),
                                s->call.constraint_bias ? "constraint_bias" : NULL,
                                NSDAE_NAME_CONSTRAINT,
                                d->m,
                                s->call.constraint,
                                T->constraint.phi,
                                &T->by.jacobian,
                                T->constraint.phi_t};
  const relation gaps = {"gap_normal",       s->call.contact_bias ? "contact_bias" : NULL,
                         NSDAE_NAME_CONTACT, d->k,
                         s->call.gap,        T->gap,
                         &T->by.normal,      T->w_N};
  if (!p->tools->options->start_check) return NSDAE_OK;
  /* degenerate elements, which the maker of the system knows */
  nsdae_error_set(T->error, NSDAE_E_ARGUMENT, "nsdae_sim_init", "gap_normal", "no normal");
  if (nsdae_system_explain(s, nsdae_terms_time(T), T->q, T->v, T->error)) return NSDAE_E_ARGUMENT;
  nsdae_error_clear(T->error);
  if (fabs(nsdae_terms_time(T)) > 1e4) return NSDAE_OK;
  int status = NSDAE_OK;
  int rows = any_users(s, NSDAE_NAME_CONSTRAINT, d->m);
  int contacts = any_users(s, NSDAE_NAME_CONTACT, d->k);
  int accelerations = contacts || any_users(s, NSDAE_NAME_FRICTIONAL_JOINT, d->f);
  if (rows) status = check_gradients(p, T, &constraints);
  if (status == NSDAE_OK && rows && (nsdae_system_has_jacobian(s) || s->call.constraint_bias))
    status = check_rates(p, T, &constraints);
  if (status == NSDAE_OK && rows) status = check_omega(p, T);
  if (status == NSDAE_OK && contacts && (s->call.gap_normal || s->call.contact_bias))
    status = check_rates(p, T, &gaps);
  if (status == NSDAE_OK) status = check_tangents(T);
  return status < 0 || !accelerations ? status : check_acceleration(p, T, work);
}

/* Prescribed motions of the maker: wrong rates of one would be a wrong start velocity. Late times
 * leave too few digits to steps in time. */
static int check_drives(const nsdae_terms *T)
{
  double t = nsdae_terms_time(T);
  nsdae_error_set(T->error, NSDAE_E_DERIVATIVE, "nsdae_sim_init", "drive", "no rate");
  if (fabs(t) <= 1e4 && nsdae_system_explain(T->system, t, T->q, T->v, T->error))
    return NSDAE_E_DERIVATIVE;
  nsdae_error_clear(T->error);
  return NSDAE_OK;
}

size_t nsdae_initial_size(const nsdae_dims *d)
{
  return 3 * ((size_t)d->k * (size_t)(1 + d->nt) + (size_t)d->f);
}

int nsdae_initial_check(nsdae_projector *p, nsdae_terms *T, double *work)
{
  const nsdae_sim_options *o = p->tools->options;
  for (int g = 0, first = 0; g < p->units.count; g++) {
    first = next_group(&p->units, g, first);
    double off = fabs(p->units.length[g] - 1);
    if (off > o->start_tol && is_rotation(&p->units, T->system->dims.nq, first))
      return refuse_start(T, "q0", NSDAE_NAME_COORDINATE, first,
                          "begins a group of unit length (by dq/dt) whose length has the error",
                          off, o->start_tol);
  }
  int status = o->start_check ? check_drives(T) : NSDAE_OK;
  if (status == NSDAE_OK) status = check_constraints(T, o->start_tol);
  if (status == NSDAE_OK) status = check_derivatives(p, T, work);
  return status < 0 ? status : nsdae_initial_overlap(T, o);
}

/* ---- putting one right */

/* Beside the state of the simulation; contacts of a list are those of the list. */
typedef struct bench {
  nsdae_system model;
  nsdae_stepper tools;
  nsdae_terms terms;
  nsdae_projector projection;
  nsdae_evals evals;
  nsdae_room contacts, rows;
} bench;

static void layout_projection(void *object, nsdae_arena *arena)
{
  bench *b = object;
  nsdae_terms_layout(&b->terms, arena);
  nsdae_units_layout(&b->projection, arena);
  nsdae_projector_layout(&b->projection, arena);
}

static int grow(bench *b)
{
  int status = nsdae_terms_grow(&b->terms, &b->contacts, &b->rows);
  if (status == NSDAE_OK) status = nsdae_projector_grow(&b->projection, &b->contacts, &b->rows);
  return status < 0 ? nsdae_error_memory(b->terms.error, "nsdae_sim_project") : status;
}

/* What is done there: with the time of the simulation's model. */
typedef int (*task)(bench *b, double t, double *q, double *v);

static int at_bench(nsdae_sim *sim, task work, double t, double *q, double *v)
{
  bench b = {.model = sim->model, .tools = sim->stepper};
  nsdae_arena arena;
  nsdae_system_track_no_more(&b.model);
  b.tools.system = &b.model;
  nsdae_stepper_prepare_terms(&b.tools, &b.terms);
  b.terms.differences = &sim->stepper.differences;
  b.terms.evals = &b.evals;
  b.projection.tools = &b.tools;
  b.projection.rows = sim->system->dims.m;
  b.projection.contacts.any = 1;
  b.contacts = sim->lists.contacts;
  b.rows = sim->lists.rows;
  if (nsdae_arena_build(&arena, layout_projection, &b) < 0)
    return nsdae_error_memory(&sim->error, "nsdae_sim_project");
  int status = grow(&b);
  while (status == NSDAE_OK && (status = work(&b, t, q, v)) == NSDAE_ARRAYS_GROW) {
    const nsdae_room taken[] = {b.terms.by.list.taken, b.terms.by.rows.taken};
    status = nsdae_sim_enlarge(sim, nsdae_terms_time(&b.terms), taken, &b.contacts, &b.rows);
    if (status == NSDAE_OK) status = grow(&b);
  }
  b.terms.differences = NULL; /* the simulation's */
  nsdae_terms_release(&b.terms);
  nsdae_projector_release(&b.projection);
  nsdae_arena_release(&arena);
  return status;
}

/* To the constraints and to gaps >= 0. */
static int put_right(nsdae_projector *p, nsdae_terms *T)
{
  nsdae_projector_clear(p);
  int status = nsdae_project_positions(p, T, 1);
  return status == NSDAE_OK ? nsdae_project_velocities(p, T) : status;
}

/* ---- of event */

/* A contact that starts below zero has no root at which it closes: it would sink through.
 * Tolerances of q do not bound its way either, which is the overlap over the gradient of the gap.
 * So event starts at gap 0. Redundant constraints may contradict each other within start_tol. */
static int touch(nsdae_projector *p, nsdae_terms *T)
{
  p->contacts.alone = 1;
  int status = put_right(p, T);
  p->contacts.alone = 0;
  return status == NSDAE_OK ? check_constraints(T, p->tools->options->start_tol) : status;
}

static int touch_at_bench(bench *b, double t, double *q, double *v)
{
  nsdae_terms_at(&b->terms, t, q, v);
  int status = nsdae_units_find(&b->projection, nsdae_terms_time(&b->terms), q);
  if (status == NSDAE_OK) status = touch(&b->projection, &b->terms);
  if (status < 0) return status;
  memcpy(q, b->terms.q, (size_t)b->model.dims.nq * sizeof *q);
  memcpy(v, b->terms.v, (size_t)b->model.dims.nv * sizeof *v);
  return NSDAE_OK;
}

int nsdae_initial_touch(nsdae_sim *sim, nsdae_terms *T)
{
  int overlaps = 0, status;
  if (sim->options.method != NSDAE_METHOD_EVENT) return NSDAE_OK;
  for (int i = 0; i < T->by.normal.count; i++) overlaps |= T->gap[i] < -nsdae_terms_touch(T);
  if (!overlaps) return NSDAE_OK;
  if (sim->model.tracked)
    status = at_bench(sim, touch_at_bench, T->t, T->q, T->v);
  else
    status = touch(&sim->projection, T);
  if (sim->model.tracked) nsdae_terms_forget(T);
  return status < 0 ? status : 1;
}

/* ---- nsdae_sim_project */

static int project_at_bench(bench *b, double t, double *q, double *v)
{
  nsdae_projector *p = &b->projection;
  const nsdae_dims *d = &b->model.dims;
  nsdae_terms_at(&b->terms, t, q, v);
  int status = nsdae_units_find(p, nsdae_terms_time(&b->terms), q);
  if (status < 0) return status;
  /* Quaternions get unit length; other groups keep theirs. */
  for (int g = 0, first = 0; g < p->units.count; g++) {
    first = next_group(&p->units, g, first);
    if (is_rotation(&p->units, d->nq, first)) p->units.length[g] = 1;
  }
  status = put_right(p, &b->terms);
  if (status < 0) return status;
  memcpy(q, b->terms.q, (size_t)d->nq * sizeof *q);
  memcpy(v, b->terms.v, (size_t)d->nv * sizeof *v);
  return NSDAE_OK;
}

NSDAE_SIM_CALL(NSDAE_MOVE, nsdae_sim_project, (nsdae_sim * sim, double t0, double *q0, double *v0),
               sim, t0, q0, v0)
{
  nsdae_error_clear(&sim->error);
  int status = nsdae_sim_check_state(sim, "nsdae_sim_project", t0, q0, v0);
  if (status < 0) return status;
  double epoch = sim->model.epoch; /* of the run, which is not touched */
  sim->model.epoch = t0;
  status = at_bench(sim, project_at_bench, 0, q0, v0);
  sim->model.epoch = epoch;
  return status;
}

/* Of the kinetic energy of the approach: 5 % in the velocities, as in monitors.c. */
static const double other_energy = 0.1;

int nsdae_initial_law(const nsdae_system *s, const nsdae_sim_options *o, const double *impulse,
                      nsdae_error *error)
{
  const nsdae_penalty_force law = {o->penalty_law, o->penalty_stiffness, o->penalty_exponent};
  double most = other_energy, given = 0;
  char called[NSDAE_CALLED_SIZE];
  int contact = -1;
  if (o->method != NSDAE_METHOD_PENALTY) return NSDAE_OK;
  for (int i = 0; i < s->dims.k; i++) {
    if ((s->tracked && !s->tracked->used[i]) || (impulse && impulse[i] == 0)) continue;
    double asked = s->contact[i].e_n, e = nsdae_penalty_restitution(&law, asked);
    double off = fabs(e * e - asked * asked);
    if (off > most) contact = i, most = off, given = e;
  }
  if (contact < 0) return NSDAE_OK;
  nsdae_error_set(
      error, NSDAE_WARN_RESTITUTION, impulse ? "nsdae_sim" : "nsdae_sim_init", "penalty_law",
      "%s has e_N = %.3g, and its penalty_law gives a restitution of %.3g: take "
      "kelvin-voigt, flores, or the e_N that gives the restitution wanted",
      nsdae_system_called(s, NSDAE_NAME_CONTACT, contact, called), s->contact[contact].e_n, given);
  long id = s->tracked ? s->tracked->id[contact] : contact;
  return nsdae_error_at(error, NSDAE_WARN_RESTITUTION, id >= 0 && id <= INT_MAX ? (int)id : -1,
                        NAN);
}
