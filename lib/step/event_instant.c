/* What happens at an instant, in this order: positions are brought back to the constraints and to
 * what is closed; contacts that approach are an impact, one problem of velocities for all that
 * touch (Newton's restitution, Coulomb's friction with impulses); contacts left without approach
 * are closed or let go by one problem of accelerations,
 *
 *   0 <= F_N  _|_  g'' = W_N^T a + omega_N >= 0,   friction as in law.h, on sliding velocities
 * where there are any and on their rates where they are zero (Pfeiffer and Glocker, "Multibody
 * Dynamics with Unilateral Contacts", 1996, chapters 5 and 8)
 *
 * which also gives the modes; velocities are brought to what is closed and what sticks. */
#include <float.h>
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "errors.h"
#include "event.h"
#include "vector.h"

enum { PROJECTIONS = 4, DIRECTIONS = 20 };

/* Relative to W_N^T P W_N, the coefficient of a sliding contact that is none; and one that explains
 * why the integrator failed. */
static const double SINGULAR = 1e-10, NEARLY = 1e-3;

enum {
  ALL_TERMS = NSDAE_TERM_MASS | NSDAE_TERM_FORCE | NSDAE_TERM_PHI | NSDAE_TERM_JACOBIAN |
              NSDAE_TERM_PHI_T | NSDAE_TERM_OMEGA | NSDAE_TERM_GAP | NSDAE_TERM_NORMAL |
              NSDAE_TERM_TANGENT | NSDAE_TERM_BIAS | NSDAE_TERM_SLIDE | NSDAE_TERM_ACCELERATION
};

static nsdae_terms *here(const nsdae_event_method *e)
{
  return &e->stepper->middle;
}

static double normal_velocity(const nsdae_terms *T, int i, const double *v)
{
  int n = T->system->dims.nv;
  return nsdae_dot(n, T->W_N + (size_t)(i * n), v) + T->w_N[i];
}

/* The j-th tangential velocity of all. */
static double tangential_velocity(const nsdae_terms *T, int j, const double *v)
{
  int n = T->system->dims.nv;
  return nsdae_dot(n, T->W_T + (size_t)(j * n), v) + T->w_T[j];
}

/* ---- projection ---- */

/* Appends the row W^T dv = -c to what is projected on. */
static void append_row(nsdae_event_method *e, int *rows, const double *W, int stride, double c)
{
  int n = e->stepper->system->dims.nv;
  double *row = e->J + (size_t)(*rows) * (size_t)n;
  for (int j = 0; j < n; j++) row[j] = W[(size_t)j * (size_t)stride];
  e->c[(*rows)++] = -c;
}

/* dv of least kinetic energy with the rows that were appended; into e->a. The rows are stored as
 * columns of J^T, and the projector wants J. */
static int project(nsdae_event_method *e, int rows)
{
  const nsdae_terms *T = here(e);
  int n = T->system->dims.nv;
  double *J = e->J + (size_t)rows * (size_t)n;
  for (int i = 0; i < rows; i++)
    for (int j = 0; j < n; j++) J[j * rows + i] = e->J[i * n + j];
  nsdae_kkt kkt = e->projector;
  kkt.m = rows;
  int status = nsdae_kkt_factor(&kkt, T->M, n, J, rows);
  if (status < 0) return status;
  memset(e->a, 0, (size_t)n * sizeof *e->a);
  nsdae_kkt_solve(&kkt, 1, e->a, n, e->c, rows);
  return NSDAE_OK;
}

static int position_rows(nsdae_event_method *e, double *worst)
{
  const nsdae_terms *T = here(e);
  const nsdae_dims *d = &T->system->dims;
  int rows = 0;
  *worst = 0;
  for (int i = 0; i < d->m; i++) {
    append_row(e, &rows, T->J + i, d->m, T->phi[i]);
    *worst = fmax(*worst, fabs(T->phi[i]));
  }
  for (int i = 0; i < d->k; i++) {
    if (!e->candidate[i]) continue;
    append_row(e, &rows, T->W_N + (size_t)(i * d->nv), 1, T->gap[i]);
    *worst = fmax(*worst, fabs(T->gap[i]));
  }
  return rows;
}

/* q to the constraints and the gaps of the candidates, by Newton's method along H. */
static int project_positions(nsdae_event_method *e, double t)
{
  nsdae_terms *T = here(e);
  const nsdae_dims *d = &T->system->dims;
  double worst;
  for (int round = 0; round < PROJECTIONS; round++) {
    int rows = position_rows(e, &worst), status;
    if (rows == 0 || worst <= 4 * DBL_EPSILON) break;
    status = project(e, rows);
    if (status == NSDAE_OK)
      status = nsdae_stepper_kinematics(e->stepper, t, T->q, e->a, e->stepper->qdot0);
    if (status < 0) return status;
    for (int i = 0; i < d->nq; i++) e->y[i] += e->stepper->qdot0[i];
    nsdae_terms_at(T, t, e->y, e->y + d->nq);
    status = nsdae_terms_need(T, NSDAE_TERM_MASS | NSDAE_TERM_PHI | NSDAE_TERM_JACOBIAN |
                                     NSDAE_TERM_GAP | NSDAE_TERM_NORMAL);
    if (status < 0) return status;
  }
  return NSDAE_OK;
}

/* v to the rates of the constraints, of what is closed and of what sticks. */
static int project_velocities(nsdae_event_method *e)
{
  nsdae_terms *T = here(e);
  const nsdae_dims *d = &T->system->dims;
  double *v = e->y + d->nq;
  int rows = 0, n = d->nv;
  for (int i = 0; i < d->m; i++) {
    double rate = T->phi_t[i];
    for (int j = 0; j < n; j++) rate += T->J[j * d->m + i] * v[j];
    append_row(e, &rows, T->J + i, d->m, rate);
  }
  for (int i = 0; i < d->k; i++) {
    if (e->mode[i] == NSDAE_OPEN) continue;
    append_row(e, &rows, T->W_N + (size_t)(i * n), 1, normal_velocity(T, i, v));
    for (int j = i * d->nt; e->mode[i] == NSDAE_STICK && j < (i + 1) * d->nt; j++)
      append_row(e, &rows, T->W_T + (size_t)(j * n), 1, tangential_velocity(T, j, v));
  }
  for (int j = 0; j < d->f; j++)
    if (e->slide_mode[j] == NSDAE_STICK)
      append_row(e, &rows, T->W_S + (size_t)(j * n), 1,
                 nsdae_dot(n, T->W_S + (size_t)(j * n), v) + T->w_S[j]);
  if (rows == 0) return NSDAE_OK;
  int status = project(e, rows);
  for (int i = 0; i < n && status == NSDAE_OK; i++) v[i] += e->a[i];
  nsdae_terms_set_velocity(T, v);
  return status;
}

/* ---- impact ---- */

/* What is left of the accumulation of contact i. A contact that comes back with the acceleration -a
 * bounces for 2 v(+) / a, then for e times that, and so on: 2 v(+) / (a (1 - e)) in all, but for
 * what a changes within that time. Infinite where the contact does not come back. */
static double rest_of(const nsdae_event_method *e, int i)
{
  const nsdae_terms *T = here(e);
  int n = T->system->dims.nv;
  double e_n = T->system->contact[i].e_n;
  double a = -nsdae_dot(n, T->W_N + (size_t)(i * n), e->r + T->system->dims.nq) - T->omega_N[i];
  return a > 0 && e_n < 1 ? -2 * e_n * e->velocity[i] / (a * (1 - e_n)) : INFINITY;
}

/* Keeps the intervals between impacts: an accumulation is recognised where the last two each were
 * shorter than the one before and less is left than matters. */
static void follow_accumulation(nsdae_event_method *e, int i, double t)
{
  double interval = t - e->last[i];
  if (interval == 0) return; /* again in the same instant */
  int shrinks = interval < e->interval[i];
  e->shrunk[i] = shrinks ? e->shrunk[i] + 1 : 0;
  e->interval[i] = interval;
  e->last[i] = t;
  e->rest[i] = e->shrunk[i] >= 2 ? rest_of(e, i) : INFINITY;
  e->settling[i] = e->rest[i] < e->stepper->options->accumulation_time;
}

static void record_impact(nsdae_event_method *e, int i, double t)
{
  nsdae_stepper *s = e->stepper;
  const nsdae_contacts *c = &s->contacts;
  int nt = s->system->dims.nt;
  nsdae_impact *impact = &s->impact[s->impacts++];
  *impact = (nsdae_impact){.time = e->settling[i] ? t + e->rest[i] : t,
                           .contact = i,
                           .normal_impulse = c->normal[i],
                           .velocity_before = e->velocity[i],
                           .velocity_after = c->after[i],
                           .accumulation = e->settling[i]};
  for (int l = 0; l < nt; l++) impact->tangential_impulse[l] = c->tangential[i * nt + l];
  e->settled += e->settling[i];
}

static void keep_impulses(nsdae_event_method *e, double t)
{
  nsdae_stepper *s = e->stepper;
  const nsdae_contacts *c = &s->contacts;
  const nsdae_dims *d = &s->system->dims;
  for (int i = 0; i < d->m; i++) e->multiplier[i] += s->impulse[i];
  for (int i = 0; i < d->k; i++) {
    e->normal[i] += c->normal[i];
    if (c->normal[i] > 0) record_impact(e, i, t);
    e->settling[i] = 0;
  }
  for (int j = 0; j < d->k * d->nt; j++) e->tangential[j] += c->tangential[j];
  for (int j = 0; j < d->f; j++) e->friction[j] += c->slide_impulse[j];
  e->work += nsdae_contacts_work(c);
  s->worst_residual = fmax(s->worst_residual, c->info.residual);
}

/* One problem for all that touch. */
static int impact(nsdae_event_method *e, double t)
{
  nsdae_stepper *s = e->stepper;
  nsdae_terms *T = here(e);
  nsdae_contacts *c = &s->contacts;
  const nsdae_dims *d = &s->system->dims;
  double *v = e->y + d->nq, size = nsdae_event_velocity_size(e, T);
  nsdae_contacts_close_marked(c, e->touching);
  nsdae_contacts_before(c, T, v, 0);
  memset(e->r, 0, (size_t)e->n * sizeof *e->r);
  if (e->ahead >= t) nsdae_dae_interpolate(e->dae, t, 1, e->r); /* v' until now */
  for (int i = 0; i < d->k; i++) {
    if (fabs(c->before[i]) <= size) c->before[i] = 0; /* closed, and beside one that is hit */
    e->velocity[i] = c->before[i];
    if (e->touching[i] && c->before[i] < 0) follow_accumulation(e, i, t);
    if (e->settling[i]) c->before[i] = 0;
  }
  nsdae_stepper_momentum(T->M, v, 0, T->F, d->nv, s->r);
  int status = nsdae_stepper_impact(s, T, s->r, s->v);
  if (status < 0) return status;
  for (int i = 0; i < d->k; i++)
    if (e->touching[i]) c->before[i] = e->velocity[i];
  keep_impulses(e, t);
  memcpy(v, s->v, (size_t)d->nv * sizeof *v);
  nsdae_terms_set_velocity(T, v);
  return nsdae_terms_need(T, ALL_TERMS);
}

/* ---- modes ---- */

/* Fills the direction of sliding of contact i; 0 where it has none. At a slip that was found at
 * zero there is none. */
static int slides(nsdae_event_method *e, int i, int impacted)
{
  const nsdae_terms *T = here(e);
  const nsdae_dims *d = &T->system->dims;
  double v_t[2] = {0}, speed = 0, *direction = e->direction + i * d->nt;
  if (!(T->system->contact[i].mu > 0)) return 0;
  if (e->breakaway[i] && !impacted) return 1;
  int slid = 0;
  for (int l = 0; l < d->nt; l++) {
    v_t[l] = tangential_velocity(T, i * d->nt + l, e->y + d->nq);
    speed = hypot(speed, v_t[l]);
    slid |= e->mode[i] == NSDAE_SLIDE && direction[l] != 0;
  }
  int stopped = !impacted && e->found[d->k + i] && slid &&
                (d->nt == 1 || speed <= 10 * nsdae_event_velocity_size(e, T));
  int moves = speed > nsdae_event_velocity_size(e, T) && !stopped;
  for (int l = 0; l < d->nt; l++) direction[l] = moves ? v_t[l] / speed : 0;
  return moves;
}

static int slide_sense(nsdae_event_method *e, int j, int impacted)
{
  const nsdae_terms *T = here(e);
  const nsdae_dims *d = &T->system->dims;
  int n = d->nv, found = e->found[2 * d->k + d->f + j];
  if (e->slide_breakaway[j] && !impacted) return e->slide_sense[j];
  double speed = nsdae_dot(n, T->W_S + (size_t)(j * n), e->y + d->nq) + T->w_S[j];
  int stopped = !impacted && found && e->slide_mode[j] == NSDAE_SLIDE && e->slide_sense[j] != 0;
  if (stopped || !(fabs(speed) > nsdae_event_velocity_size(e, T))) return 0;
  return speed > 0 ? 1 : -1;
}

static void set_laws(nsdae_event_method *e, int impacted)
{
  const nsdae_system *s = e->stepper->system;
  int nt = s->dims.nt;
  for (int i = 0; i < s->dims.k; i++) {
    if (!e->candidate[i]) continue;
    e->moving[i] = slides(e, i, impacted);
    e->law[i] = e->moving[i] ? nsdae_law_sliding(nt, s->contact[i].mu, e->direction + i * nt)
                             : e->resting[i];
  }
  for (int j = 0; j < s->dims.f; j++) e->sliding_sense[j] = slide_sense(e, j, impacted);
}

/* Accelerations and forces of the candidates under their laws; into e->a, e->lambda, e->modes. */
static int accelerate(nsdae_event_method *e)
{
  nsdae_stepper *s = e->stepper;
  nsdae_terms T = *here(e);
  int n = s->system->dims.nv, m = s->system->dims.m;
  T.w_N = T.omega_N;
  T.w_T = T.omega_T;
  T.w_S = T.omega_S;
  nsdae_contacts_close_marked(&e->modes, e->candidate);
  memcpy(e->a, T.F, (size_t)n * sizeof *e->a);
  memcpy(s->size, T.F, (size_t)n * sizeof *s->size);
  for (int i = 0; i < m; i++) e->lambda[i] = -T.omega[i];
  nsdae_kkt_solve(&s->kkt, 1, e->a, n, e->lambda, m);
  nsdae_kkt_solve_mass(&s->kkt, s->size);
  s->problem = &e->modes;
  int status = nsdae_contacts_solve(&e->modes, &T, &s->kkt, s->size, e->a, e->lambda);
  if (nsdae_contacts_any(&e->modes)) {
    s->lcps++;
    s->lcp_pivots += e->modes.info.pivots;
    s->worst_residual = fmax(s->worst_residual, e->modes.info.residual);
  }
  return status;
}

/* A contact that slides and whose own coefficient W_N^T P (W_N - mu W_T d) is not above zero pulls
 * itself in: then there is no force, or two (Painleve 1895). */
static int paradox(nsdae_event_method *e, double t, int status, double least)
{
  const nsdae_contacts *c = &e->modes;
  for (int a = 0; a < c->active_count; a++) {
    int i = c->active[a], row = c->first_row[a];
    double coefficient = c->A[(size_t)row * (size_t)c->rows + (size_t)row];
    double scale = c->G[(size_t)c->first_column[a] * (size_t)(c->columns + 1)];
    if (c->law[i].kind != NSDAE_SLIDING || coefficient > least * scale) continue;
    const char *what = coefficient > SINGULAR * scale ? "a contact force that grows without bound"
                       : status < 0                   ? "no contact force that solves the equations"
                                                      : "two solutions";
    nsdae_error_set(e->stepper->error, NSDAE_E_PAINLEVE, "nsdae_event", "mu",
                    "contact %d has %s at t = %.17g (Painleve's paradox: its friction feeds its "
                    "normal force, coefficient %.3g): take less friction, or method = implicit, "
                    "which resolves it by an impulse",
                    i, what, t, coefficient);
    e->stepper->error->index = i;
    e->stepper->error->time = t;
    return NSDAE_E_PAINLEVE;
  }
  return status;
}

static double acceleration_size(const nsdae_event_method *e)
{
  double most = 0;
  for (int i = 0; i < e->stepper->system->dims.nv; i++) {
    most = fmax(most, fabs(e->a[i]));
    most = fmax(most, fabs(e->stepper->size[i]));
  }
  return 1e-10 * most;
}

/* Whether friction can move contact or slide in this column of the problem at all. */
static int powerless(const nsdae_contacts *c, int column)
{
  return c->G[(size_t)column * (size_t)(c->columns + 1)] == 0;
}

static void point_against(double *direction, int nt, const double *force)
{
  double size = 0;
  for (int l = 0; l < nt; l++) size = hypot(size, force[l]);
  for (int l = 0; l < nt; l++) direction[l] = size > 0 ? -force[l] / size : 0;
}

/* Mode of a contact that rests, under friction, from the problem's solution. */
static int resting_mode(nsdae_event_method *e, int a)
{
  const nsdae_contacts *c = &e->modes;
  int i = c->active[a], nt = e->stepper->system->dims.nt, mode = c->mode[i];
  const double *force = c->tangential + i * nt, *rate = c->after_t + i * nt;
  double *direction = e->direction + i * nt;
  if (powerless(c, c->first_column[a] + 1)) return NSDAE_SLIDE;
  if (nt == 2 && mode == NSDAE_STICK &&
      hypot(force[0], force[1]) > e->stepper->system->contact[i].mu * c->normal[i])
    mode = NSDAE_SLIDE; /* outside the cone though inside the polygon around it */
  if (mode == NSDAE_SLIDE) point_against(direction, nt, force);
  if (mode == NSDAE_SLIDE && nt == 2) {
    double speed = hypot(rate[0], rate[1]);
    for (int l = 0; l < nt && speed > acceleration_size(e); l++) direction[l] = rate[l] / speed;
  }
  return mode;
}

static void read_contacts(nsdae_event_method *e)
{
  const nsdae_contacts *c = &e->modes;
  const nsdae_dims *d = &e->stepper->system->dims;
  double size = acceleration_size(e);
  for (int i = 0; i < d->k; i++) e->mode[i] = NSDAE_OPEN;
  for (int a = 0; a < c->active_count; a++) {
    int i = c->active[a];
    if (!(c->normal[i] > 0) && c->after[i] > size) continue;
    e->mode[i] = NSDAE_SLIDE; /* also where it touches without a force */
    if (c->normal[i] > 0 && c->law[i].kind != NSDAE_SLIDING && c->law[i].columns > 1)
      e->mode[i] = resting_mode(e, a);
  }
}

static void read_slides(nsdae_event_method *e)
{
  const nsdae_contacts *c = &e->modes;
  const nsdae_system *s = e->stepper->system;
  for (int i = 0; i < c->slide_count; i++) {
    int j = c->slide[i];
    double force = c->slide_impulse[j], rate = c->slide_after[j];
    e->slide_mode[j] = c->slide_mode[j];
    e->slide_sense[j] = e->sliding_sense[j];
    if (!e->sliding_sense[j] && powerless(c, c->columns - c->slide_count + i))
      e->slide_mode[j] = NSDAE_SLIDE, e->slide_sense[j] = (rate > 0) - (rate < 0);
    else if (!e->sliding_sense[j] && e->slide_mode[j] == NSDAE_SLIDE)
      e->slide_sense[j] = force != 0 ? (force < 0) - (force > 0) : (rate > 0) - (rate < 0);
    double normal = e->lambda[s->slide[j].constraint];
    int turned = e->found[2 * s->dims.k + j];
    e->normal_sense[j] = turned ? -e->normal_sense[j] : normal < 0 ? -1 : 1;
  }
}

/* Whether a contact that was let go would come back at once. */
static int comes_back(const nsdae_event_method *e)
{
  const nsdae_terms *T = here(e);
  int n = T->system->dims.nv, any = 0;
  for (int i = 0; i < T->system->dims.k; i++) {
    if (!e->released[i]) continue;
    double rate = nsdae_dot(n, T->W_N + (size_t)(i * n), e->a) + T->omega_N[i];
    if (rate >= -acceleration_size(e)) continue;
    e->released[i] = 0;
    e->candidate[i] = 1;
    any = 1;
  }
  return any;
}

/* Whether a contact or slide whose friction was used up would rather slide the other way: then it
 * is asked again without a direction. */
static int sticks_after_all(nsdae_event_method *e)
{
  const nsdae_contacts *c = &e->modes;
  const nsdae_dims *d = &e->stepper->system->dims;
  double size = acceleration_size(e);
  int any = 0;
  for (int i = 0; i < d->k; i++) {
    double along = 0;
    for (int l = 0; l < d->nt; l++)
      along += e->direction[i * d->nt + l] * c->after_t[i * d->nt + l];
    if (!e->breakaway[i] || along >= -size) continue;
    e->breakaway[i] = 0;
    any = 1;
  }
  for (int j = 0; j < d->f; j++) {
    if (!e->slide_breakaway[j] || e->slide_sense[j] * c->slide_after[j] >= -size) continue;
    e->slide_breakaway[j] = 0;
    any = 1;
  }
  return any;
}

/* A resting contact with two directions slides along its own acceleration: d = v_T' / |v_T'|, found
 * by substitution. */
static int settle_directions(nsdae_event_method *e)
{
  const nsdae_system *s = e->stepper->system;
  int nt = s->dims.nt, status = NSDAE_OK;
  for (int round = 0; nt == 2 && round < DIRECTIONS && status == NSDAE_OK; round++) {
    double moved = 0;
    for (int i = 0; i < s->dims.k; i++) {
      double *d = e->direction + 2 * i, *rate = e->modes.after_t + 2 * i;
      double speed = hypot(rate[0], rate[1]);
      if (!e->candidate[i] || e->mode[i] != NSDAE_SLIDE || !(s->contact[i].mu > 0)) continue;
      if (round > 0 && e->law[i].kind == NSDAE_SLIDING && e->candidate[i] == 2 &&
          speed > acceleration_size(e)) {
        moved = fmax(moved, hypot(rate[0] / speed - d[0], rate[1] / speed - d[1]));
        d[0] = rate[0] / speed;
        d[1] = rate[1] / speed;
      }
      if (e->law[i].kind == NSDAE_POLYGON) {
        e->candidate[i] = 2; /* its direction follows its acceleration */
        moved = 1;
      }
      e->law[i] = nsdae_law_sliding(nt, s->contact[i].mu, d);
    }
    if (!(moved > 1e-13)) break;
    status = accelerate(e);
    if (status == NSDAE_OK) read_contacts(e);
  }
  return status;
}

static double slip_rate(const nsdae_event_method *e, int i)
{
  int nt = e->stepper->system->dims.nt;
  double rate = 0;
  for (int l = 0; l < nt; l++) rate = hypot(rate, e->modes.after_t[i * nt + l]);
  return rate;
}

/* Others hold it. Where one just broke away its neighbours are about to. */
void nsdae_event_hold_resting(nsdae_event_method *e)
{
  const nsdae_contacts *c = &e->modes;
  int any = 0;
  double size = acceleration_size(e);
  for (int i = 0; i < e->stepper->system->dims.k; i++) any |= e->breakaway[i];
  for (int a = 0; a < c->active_count && !any; a++) {
    int i = c->active[a];
    if (e->mode[i] != NSDAE_SLIDE || e->moving[i] || !(c->normal[i] > 0)) continue;
    if (c->law[i].columns == 1 || powerless(c, c->first_column[a] + 1)) continue;
    if (slip_rate(e, i) <= size) e->mode[i] = NSDAE_STICK;
  }
}

/* Whether a contact at rest starts in a direction that is not known to be right. */
static int begins_to_slide(const nsdae_event_method *e)
{
  const nsdae_dims *d = &e->stepper->system->dims;
  double size = acceleration_size(e);
  int any = 0;
  for (int i = 0; i < d->k && d->nt == 2; i++)
    any |= e->mode[i] == NSDAE_SLIDE && !e->moving[i] && slip_rate(e, i) > size;
  return any;
}

/* What slides in the solution with the cones: d is against its friction, which is all used. */
static void read_cones(nsdae_event_method *e)
{
  const nsdae_contacts *c = &e->modes;
  double size = acceleration_size(e);
  read_contacts(e);
  for (int a = 0; a < c->active_count; a++) {
    int i = c->active[a];
    if (e->mode[i] == NSDAE_OPEN || c->law[i].kind != NSDAE_POLYGON || !(c->normal[i] > 0))
      continue;
    if (powerless(c, c->first_column[a] + 1)) continue;
    e->mode[i] = slip_rate(e, i) > size ? NSDAE_SLIDE : NSDAE_STICK;
    if (e->mode[i] == NSDAE_SLIDE) point_against(e->direction + 2 * i, 2, c->tangential + 2 * i);
  }
}

static int find_modes(nsdae_event_method *e, double t, int impacted)
{
  int status;
  do {
    set_laws(e, impacted);
    status = accelerate(e);
    status = paradox(e, t, status, SINGULAR);
    if (status < 0) return status;
  } while (comes_back(e) || (!impacted && sticks_after_all(e)));
  read_contacts(e);
  read_slides(e);
  if (!begins_to_slide(e) && nsdae_event_find_rows(e, t) == NSDAE_OK) return NSDAE_OK;
  if (nsdae_event_solve_cones(e))
    read_cones(e);
  else
    status = settle_directions(e);
  return status < 0 ? status : nsdae_event_find_rows(e, t);
}

int nsdae_event_diagnose(nsdae_event_method *e, double t)
{
  nsdae_stepper *s = e->stepper;
  nsdae_terms *T = here(e);
  nsdae_error kept = *s->error;
  const nsdae_dims *d = &s->system->dims;
  nsdae_terms_at(T, t, e->y, e->y + d->nq);
  int status = nsdae_terms_need(T, ALL_TERMS);
  if (status == NSDAE_OK) status = nsdae_stepper_factor(s, T, T->M);
  if (status == NSDAE_OK) {
    for (int i = 0; i < d->k; i++) e->candidate[i] = e->mode[i] != NSDAE_OPEN;
    memset(e->found, 0, (size_t)e->roots * sizeof *e->found);
    set_laws(e, 0);
    status = paradox(e, t, accelerate(e), NEARLY);
  }
  if (status == NSDAE_E_PAINLEVE) return status;
  *s->error = kept;
  return NSDAE_OK;
}

/* ---- the instant ---- */

/* Whether the friction of contact i breaks away. Where how friction shares was chosen, a contact at
 * its limit is no reason to slide until all that stick are. */
static int breaks_away(const nsdae_event_method *e, int i)
{
  const nsdae_dims *d = &e->stepper->system->dims;
  int shared = 0, all = 1;
  if (e->mode[i] != NSDAE_STICK) return 0;
  for (int j = 0; j < d->k; j++) {
    if (e->mode[j] != NSDAE_STICK) continue;
    for (int l = 0; l < d->nt; l++) shared |= nsdae_event_related(e, d->k + j * d->nt + l);
    all &= e->found[d->k + j] || nsdae_event_stick_margin(e, e->y, j) <= e->root[d->k + j].size;
  }
  return shared ? all : e->found[d->k + i];
}

/* What was found, in terms of the modes so far. */
static void sort_found(nsdae_event_method *e)
{
  const nsdae_dims *d = &e->stepper->system->dims;
  for (int i = 0; i < d->k; i++) {
    int closed = e->mode[i] != NSDAE_OPEN;
    int undecided =
        closed && e->root[i].state == NSDAE_ROOT_MASKED && e->y[nsdae_at_normal(d) + i] > 0;
    e->touching[i] = closed || e->found[i];
    e->candidate[i] = closed;
    e->released[i] = closed && e->found[i] && !undecided;
    e->breakaway[i] = breaks_away(e, i);
    if (e->breakaway[i])
      point_against(e->direction + i * d->nt, d->nt, e->y + nsdae_at_tangential(d) + i * d->nt);
  }
  for (int j = 0; j < d->f; j++) {
    double force = e->y[nsdae_at_slide(d) + j];
    e->slide_breakaway[j] = e->found[2 * d->k + d->f + j] && e->slide_mode[j] == NSDAE_STICK;
    if (e->slide_breakaway[j]) e->slide_sense[j] = (force < 0) - (force > 0);
  }
}

/* Whether contact i touches but for the integrator's error, and does not part. */
static int touches(const nsdae_event_method *e, int i)
{
  const nsdae_terms *T = here(e);
  const double *v = e->y + T->system->dims.nq;
  return T->gap[i] <= nsdae_event_position_size(e, T) &&
         normal_velocity(T, i, v) <= nsdae_event_velocity_size(e, T);
}

static void add_touching(nsdae_event_method *e)
{
  const nsdae_terms *T = here(e);
  double x_size = nsdae_event_position_size(e, T);
  for (int i = 0; i < T->system->dims.k; i++) {
    if (touches(e, i)) e->touching[i] = 1;
    if (e->touching[i] && fabs(T->gap[i]) <= 2 * x_size) e->candidate[i] = 1;
  }
}

static int approaching(nsdae_event_method *e)
{
  const nsdae_terms *T = here(e);
  const double *v = e->y + T->system->dims.nq;
  double size = nsdae_event_velocity_size(e, T);
  for (int i = 0; i < T->system->dims.k; i++)
    if (e->touching[i] && normal_velocity(T, i, v) < -size) return 1;
  return 0;
}

/* An impact may drive another contact that touches, and parted or rested before it, together: then
 * that is the next, at the same time. */
static int impacts(nsdae_event_method *e, double t, int *any)
{
  const nsdae_stepper *s = e->stepper;
  int k = s->system->dims.k, status = NSDAE_OK;
  while (status == NSDAE_OK && approaching(e) && s->impacts + k <= s->impacts_max) {
    status = impact(e, t);
    for (int i = 0; i < k && status == NSDAE_OK; i++)
      e->touching[i] = e->mode[i] != NSDAE_OPEN || touches(e, i);
    *any = 1;
  }
  return status;
}

/* Touching, not let go, without a velocity apart. */
static void choose_candidates(nsdae_event_method *e, int impacted)
{
  const nsdae_terms *T = here(e);
  const double *v = e->y + T->system->dims.nq;
  double size = nsdae_event_velocity_size(e, T);
  for (int i = 0; i < T->system->dims.k; i++) {
    if (impacted) e->released[i] = 0;
    e->candidate[i] = e->touching[i] && !e->released[i] && !(normal_velocity(T, i, v) > size);
  }
}

static void find_independent(nsdae_event_method *e)
{
  const nsdae_kkt *kkt = &e->stepper->kkt;
  for (int i = 0; i < kkt->m; i++) e->independent[i] = kkt->rank == kkt->m;
  for (int i = 0; i < kkt->rank && kkt->rank < kkt->m; i++) e->independent[kkt->column[i] - 1] = 1;
}

/* y' and the forces of the new phase. Of the redundant constraints' multipliers only those of the
 * independent ones are guessed here; nsdae_dae_start solves for them. */
static int fill_state(nsdae_event_method *e, double t)
{
  const nsdae_terms *T = here(e);
  const nsdae_dims *d = &T->system->dims;
  const nsdae_contacts *c = &e->modes;
  double *force = e->y + nsdae_at_lambda(d);
  memset(e->yp, 0, (size_t)e->n * sizeof *e->yp);
  memset(force, 0, (size_t)(e->n - nsdae_at_lambda(d)) * sizeof *force);
  memcpy(e->yp + d->nq, e->a, (size_t)d->nv * sizeof *e->a);
  memcpy(force, e->lambda, (size_t)d->m * sizeof *force);
  for (int i = 0; i < d->m; i++)
    if (!e->independent[i]) force[i] = 0;
  for (int i = 0; i < d->k; i++) {
    if (e->mode[i] == NSDAE_OPEN) continue;
    e->y[nsdae_at_normal(d) + i] = c->normal[i];
    for (int j = i * d->nt; j < (i + 1) * d->nt; j++)
      e->y[nsdae_at_tangential(d) + j] = c->tangential[j];
  }
  for (int j = 0; j < d->f; j++) e->y[nsdae_at_slide(d) + j] = c->slide_impulse[j];
  return nsdae_stepper_kinematics(e->stepper, t, T->q, e->y + d->nq, e->yp);
}

/* Everything at the point of e->y, with the matrices factored. */
static int arrive(nsdae_event_method *e, double t)
{
  nsdae_terms *T = here(e);
  const nsdae_dims *d = &T->system->dims;
  nsdae_terms_at(T, t, e->y, e->y + d->nq);
  int status = nsdae_terms_need(T, ALL_TERMS);
  if (status < 0) return status;
  add_touching(e);
  status = project_positions(e, t);
  if (status == NSDAE_OK) status = nsdae_terms_need(T, ALL_TERMS);
  if (status == NSDAE_OK) status = nsdae_stepper_factor(e->stepper, T, T->M);
  if (status == NSDAE_OK) find_independent(e);
  return status;
}

int nsdae_event_instant(nsdae_event_method *e, double t)
{
  sort_found(e);
  int status = arrive(e, t);
  if (status < 0) return status;
  int impacted = 0;
  status = impacts(e, t, &impacted);
  if (status < 0) return status;
  choose_candidates(e, impacted);
  status = find_modes(e, t, impacted);
  if (status < 0) return status;
  memcpy(e->stepper->v, e->a, (size_t)e->stepper->system->dims.nv * sizeof *e->a);
  status = project_velocities(e);
  memcpy(e->a, e->stepper->v, (size_t)e->stepper->system->dims.nv * sizeof *e->a);
  if (status == NSDAE_OK) status = fill_state(e, t);
  e->slow = nsdae_event_velocity_size(e, here(e));
  e->instant = t;
  e->changes++;
  return status;
}
