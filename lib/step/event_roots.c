/* The functions whose falls through zero end a phase, each above zero while its mode holds:
 *
 *   open       g_N                    the gap closes
 *   closed     F_N                    the contact lets go
 *   sliding    d . v_T                it stops; with two directions d is that after the last step
 *   sticking   mu F_N - |F_T|         friction is used up
 *   slides     the same with v_S and mu |lambda| - |F_S|, and s lambda where lambda changes sign
 *
 * One that is zero at the start of a phase would be found there again and again. With a known rate
 * r > 0 it is divided by t - t_0, which makes it r at t_0 and leaves its further zeros where they
 * are (what rounding left at t_0 is taken off); without, it is lifted by what counts as zero
 * until it has left zero. */
#include <float.h>
#include <math.h>
#include <string.h>

#include "event.h"
#include "vector.h"

/* With two directions a velocity is followed through the errors of the integration, from which it
 * cannot be told at first which way it goes: so many times what counts as zero. */
static const double TURNING = 100;

static double speed_of(const nsdae_terms *T, int i)
{
  int n = T->system->dims.nv, nt = T->system->dims.nt;
  double speed = 0;
  for (int j = i * nt; j < (i + 1) * nt; j++)
    speed = hypot(speed, nsdae_dot(n, T->W_T + (size_t)(j * n), T->v) + T->w_T[j]);
  return speed;
}

double nsdae_event_stick_margin(const nsdae_event_method *e, const double *y, int i)
{
  const nsdae_system *s = e->stepper->system;
  const nsdae_dims *d = &s->dims;
  const double *F_T = y + nsdae_at_tangential(d) + i * d->nt;
  double friction = d->nt == 2 ? hypot(F_T[0], F_T[1]) : fabs(F_T[0]);
  return s->contact[i].mu * y[nsdae_at_normal(d) + i] - friction;
}

static double tangential_value(const nsdae_event_method *e, const nsdae_terms *T, const double *y,
                               int i)
{
  int n = T->system->dims.nv, nt = T->system->dims.nt;
  double along = 0;
  if (e->mode[i] == NSDAE_MODE_STICK) return nsdae_event_stick_margin(e, y, i);
  for (int j = i * nt; j < (i + 1) * nt; j++)
    along += e->direction[j] * (nsdae_dot(n, T->W_T + (size_t)(j * n), T->v) + T->w_T[j]);
  return along;
}

static double slip_value(const nsdae_event_method *e, const nsdae_terms *T, const double *y, int j)
{
  const nsdae_system *s = T->system;
  const nsdae_dims *d = &s->dims;
  double normal = e->normal_sense[j] * y[nsdae_at_lambda(d) + s->slide[j].constraint];
  if (e->slide_mode[j] == NSDAE_MODE_STICK)
    return s->slide[j].mu * normal - fabs(y[nsdae_at_slide(d) + j]);
  return e->slide_sense[j] * (nsdae_dot(d->nv, T->W_S + (size_t)(j * d->nv), T->v) + T->w_S[j]);
}

/* The function of that number as it is. */
static double value_of(const nsdae_event_method *e, const nsdae_terms *T, const double *y, int root)
{
  const nsdae_system *s = T->system;
  const nsdae_dims *d = &s->dims;
  if (root < d->k)
    return e->mode[root] == NSDAE_MODE_OPEN ? T->gap[root] : y[nsdae_at_normal(d) + root];
  root -= d->k;
  if (root < d->k) return tangential_value(e, T, y, root);
  root -= d->k;
  if (root < d->f) return e->normal_sense[root] * y[nsdae_at_lambda(d) + s->slide[root].constraint];
  return slip_value(e, T, y, root - d->f);
}

/* Terms that the functions in the set need. */
static unsigned terms_of(const nsdae_event_method *e)
{
  const nsdae_dims *d = &e->stepper->system->dims;
  unsigned terms = 0;
  for (int i = 0; i < d->k; i++) {
    if (e->mode[i] == NSDAE_MODE_OPEN || nsdae_event_related(e, i)) terms |= NSDAE_TERM_GAP;
    if (e->root[d->k + i].state != NSDAE_ROOT_OFF && e->mode[i] == NSDAE_MODE_SLIDE)
      terms |= NSDAE_TERM_TANGENT | NSDAE_TERM_BIAS;
  }
  for (int j = 0; j < d->f; j++)
    if (e->root[2 * d->k + d->f + j].state != NSDAE_ROOT_OFF &&
        e->slide_mode[j] == NSDAE_MODE_SLIDE)
      terms |= NSDAE_TERM_SLIDE;
  return terms;
}

/* The terms, and where something is closed the forces, at q and v of y: into e->at. */
static int evaluate(nsdae_event_method *e, double t, const double *y)
{
  nsdae_terms *T = &e->stepper->middle;
  int status = NSDAE_OK;
  memcpy(e->at, y, (size_t)e->n * sizeof *y);
  if (e->terms & (NSDAE_TERM_NORMAL | NSDAE_TERM_SLIDE))
    status = nsdae_event_forces(e, t, e->at);
  else
    nsdae_terms_at(T, t, y, y + T->system->dims.nq);
  return status < 0 ? status : nsdae_terms_need(T, terms_of(e));
}

/* Divided by the time since it was zero; so close to it that rounding rules, its rate. */
static double rising(const nsdae_root *root, double t, double value, double position)
{
  double least = 64 * DBL_EPSILON * (position / root->rate + fabs(t));
  return t - root->since > least ? (value - root->start) / (t - root->since) : root->rate;
}

/* A contact or slide that got a direction to slide in only now. */
static int undecided(const nsdae_event_method *e, int root)
{
  const nsdae_dims *d = &e->stepper->system->dims;
  if (root >= 2 * d->k + d->f) {
    int j = root - 2 * d->k - d->f;
    return e->slide_mode[j] == NSDAE_MODE_SLIDE && e->slide_sense[j] == 0;
  }
  if (root >= 2 * d->k) return 0;
  int i = root % d->k, nt = d->nt;
  if (e->mode[i] != NSDAE_MODE_SLIDE || !(e->stepper->system->contact[i].mu > 0)) return 0;
  for (int l = 0; l < nt; l++)
    if (e->direction[i * nt + l] != 0) return 0;
  return 1;
}

/* A velocity of sliding that is zero to rounding has no direction yet to be measured along: it is
 * out of the set until it has. */
static int is_out(const nsdae_event_method *e, int root)
{
  const nsdae_dims *d = &e->stepper->system->dims;
  int masked = e->root[root].state == NSDAE_ROOT_MASKED, contact = root - d->k;
  int slips = contact >= 0 && contact < d->k && e->mode[contact] == NSDAE_MODE_SLIDE;
  return e->root[root].state == NSDAE_ROOT_OFF || undecided(e, root) || (masked && slips);
}

int nsdae_event_root(double t, const double *y, const double *yp, double *g, void *user)
{
  nsdae_event_method *e = user;
  const nsdae_terms *T = &e->stepper->middle;
  double position = 0;
  (void)yp;
  if (evaluate(e, t, y) < 0) return -1;
  for (int i = 0; i < T->system->dims.nq + T->system->dims.nv; i++)
    position = fmax(position, fabs(y[i]));
  for (int i = 0; i < e->roots; i++) {
    const nsdae_root *root = &e->root[i];
    int out = is_out(e, i);
    g[i] = out ? 1 : value_of(e, T, e->at, i);
    if (root->state == NSDAE_ROOT_RISING) g[i] = rising(root, t, g[i], position);
    if (root->state == NSDAE_ROOT_MASKED && !out) g[i] += root->size;
  }
  return 0;
}

static double largest(int n, const double *a)
{
  double most = 0;
  for (int i = 0; i < n; i++) most = fmax(most, fabs(a[i]));
  return most;
}

double nsdae_event_position_size(const nsdae_event_method *e, const nsdae_terms *T)
{
  const nsdae_sim_options *o = e->stepper->options;
  return 10 * (o->rtol * largest(T->system->dims.nq, T->q) + o->atol);
}

double nsdae_event_velocity_size(const nsdae_event_method *e, const nsdae_terms *T)
{
  const nsdae_sim_options *o = e->stepper->options;
  double accuracy = 10 * (o->rtol * largest(T->system->dims.nv, T->v) + o->atol);
  return fmax(o->impact_velocity, accuracy);
}

/* Size of a force that is zero but for the errors of the integration. */
static double force_size(const nsdae_event_method *e)
{
  const nsdae_dims *d = &e->stepper->system->dims;
  const nsdae_sim_options *o = e->stepper->options;
  const double *force = e->y + nsdae_at_lambda(d);
  double most =
      fmax(largest(e->n - nsdae_at_lambda(d), force), largest(d->nv, e->stepper->middle.F));
  return 10 * (fmax(o->rtol, 1e-13) * most + o->atol);
}

/* Live where it is above zero; with a rate, rising from zero; else masked. */
static void start_root(nsdae_root *root, double t, double value, double rate, double size,
                       double rate_size)
{
  root->since = t;
  root->start = value;
  root->rate = rate;
  root->size = size;
  if (value > size)
    root->state = NSDAE_ROOT_LIVE;
  else if (rate > rate_size && value > -size)
    root->state = NSDAE_ROOT_RISING;
  else
    root->state = NSDAE_ROOT_MASKED;
  if (value < -size) root->size = -2 * value; /* starts below zero: counts from there */
}

static void start_contact(nsdae_event_method *e, const nsdae_terms *T, int i, double t)
{
  const nsdae_dims *d = &T->system->dims;
  int n = d->nv, nt = d->nt;
  const double *W = T->W_N + (size_t)(i * n), *a = e->yp + d->nq;
  double v_size = nsdae_event_velocity_size(e, T), force = force_size(e);
  nsdae_root *normal = &e->root[i], *tangential = &e->root[d->k + i];
  if (e->mode[i] == NSDAE_MODE_OPEN)
    start_root(normal, t, value_of(e, T, e->y, i), nsdae_dot(n, W, T->v) + T->w_N[i],
               nsdae_event_position_size(e, T), v_size);
  else
    start_root(normal, t, value_of(e, T, e->y, i), 0, force, 0);
  tangential->state = NSDAE_ROOT_OFF;
  if (e->mode[i] == NSDAE_MODE_OPEN || !(T->system->contact[i].mu > 0)) return;
  if (e->mode[i] == NSDAE_MODE_STICK) {
    start_root(tangential, t, value_of(e, T, e->y, d->k + i), 0, force, 0);
    return;
  }
  double rate = 0;
  for (int j = i * nt; j < (i + 1) * nt; j++)
    rate += e->direction[j] * (nsdae_dot(n, T->W_T + (size_t)(j * n), a) + T->omega_T[j]);
  start_root(tangential, t, value_of(e, T, e->y, d->k + i), rate,
             nt == 2 ? TURNING * v_size : v_size, 0);
  /* so slow a start is no rate to divide by */
  if (tangential->state == NSDAE_ROOT_RISING && !(rate > v_size))
    tangential->state = NSDAE_ROOT_MASKED;
}

static void start_slide(nsdae_event_method *e, const nsdae_terms *T, int j, double t)
{
  const nsdae_dims *d = &T->system->dims;
  int n = d->nv, number = 2 * d->k + j;
  double v_size = nsdae_event_velocity_size(e, T), force = force_size(e);
  nsdae_root *normal = &e->root[number], *slip = &e->root[number + d->f];
  normal->state = slip->state = NSDAE_ROOT_OFF;
  if (e->slide_mode[j] == NSDAE_MODE_OPEN) return;
  start_root(normal, t, value_of(e, T, e->y, number), 0, force, 0);
  double value = value_of(e, T, e->y, number + d->f);
  if (e->slide_mode[j] == NSDAE_MODE_STICK) {
    start_root(slip, t, value, 0, force, 0);
    return;
  }
  double rate =
      e->slide_sense[j] * (nsdae_dot(n, T->W_S + (size_t)(j * n), e->yp + d->nq) + T->omega_S[j]);
  start_root(slip, t, value, rate, v_size, v_size);
}

int nsdae_event_set_roots(nsdae_event_method *e, double t)
{
  nsdae_terms *T = &e->stepper->middle;
  const nsdae_dims *d = &T->system->dims;
  nsdae_terms_at(T, t, e->y, e->y + d->nq);
  int status = nsdae_terms_need(T, NSDAE_TERM_FORCE | NSDAE_TERM_GAP | NSDAE_TERM_NORMAL |
                                       NSDAE_TERM_TANGENT | NSDAE_TERM_BIAS | NSDAE_TERM_SLIDE |
                                       NSDAE_TERM_ACCELERATION);
  if (status < 0) return status;
  for (int i = 0; i < d->k; i++) start_contact(e, T, i, t);
  for (int j = 0; j < d->f; j++) start_slide(e, T, j, t);
  return NSDAE_OK;
}

/* How far an undecided one is from zero: the normal force, or the speed of sliding. */
static double undecided_value(const nsdae_event_method *e, const nsdae_terms *T, const double *y,
                              int root)
{
  const nsdae_dims *d = &T->system->dims;
  int j = root - 2 * d->k - d->f;
  if (root < d->k) return y[nsdae_at_normal(d) + root];
  if (root < 2 * d->k) return speed_of(T, root - d->k);
  (void)e;
  return fabs(nsdae_dot(d->nv, T->W_S + (size_t)(j * d->nv), T->v) + T->w_S[j]);
}

/* A masked function after a step: 1 where it asks for an instant. */
static int watch(nsdae_event_method *e, const nsdae_terms *T, const double *y, int number)
{
  nsdae_root *root = &e->root[number];
  if (undecided(e, number)) return undecided_value(e, T, y, number) > root->size;
  double value = value_of(e, T, y, number);
  if (value > root->size) root->state = NSDAE_ROOT_LIVE;
  return value < -root->size;
}

static int slides_in_plane(const nsdae_event_method *e, int i)
{
  const nsdae_system *s = e->stepper->system;
  return s->dims.nt == 2 && e->mode[i] == NSDAE_MODE_SLIDE && s->contact[i].mu > 0;
}

/* With two directions of friction a contact goes on in that of its velocity, while it has one. */
static int follow_directions(nsdae_event_method *e, double t)
{
  nsdae_terms *T = &e->stepper->middle;
  const nsdae_dims *d = &T->system->dims;
  int any = 0, n = d->nv;
  for (int i = 0; i < d->k; i++) any |= slides_in_plane(e, i);
  if (!any) return NSDAE_OK;
  if (nsdae_dae_interpolate(e->dae, t, 0, e->y) < 0) return NSDAE_E_CONVERGENCE;
  nsdae_terms_at(T, t, e->y, e->y + d->nq);
  int status = nsdae_terms_need(T, NSDAE_TERM_TANGENT | NSDAE_TERM_BIAS);
  for (int i = 0; i < d->k && status == NSDAE_OK; i++) {
    double *last = e->direction + 2 * i, v_t[2] = {0};
    if (!slides_in_plane(e, i)) continue;
    for (int l = 0, j = 2 * i; l < 2; l++, j++)
      v_t[l] = nsdae_dot(n, T->W_T + (size_t)(j * n), T->v) + T->w_T[j];
    double along = last[0] * v_t[0] + last[1] * v_t[1], speed = hypot(v_t[0], v_t[1]);
    if (!(along > e->slow)) continue;
    for (int l = 0; l < 2; l++) last[l] = v_t[l] / speed;
  }
  return status;
}

/* Whether contact i is closed by others alone. */
static int has_no_row(const nsdae_event_method *e, int i)
{
  return e->mode[i] != NSDAE_MODE_OPEN && nsdae_event_related(e, i);
}

/* Contacts that others closed, and do no longer. */
static int watch_gaps(nsdae_event_method *e, const nsdae_terms *T)
{
  int count = 0;
  for (int i = 0; i < T->system->dims.k; i++) {
    if (!has_no_row(e, i) || e->found[i]) continue;
    e->found[i] = fabs(T->gap[i]) > nsdae_event_position_size(e, T);
    count += e->found[i];
  }
  return count;
}

int nsdae_event_watch_roots(nsdae_event_method *e, double t)
{
  nsdae_terms *T = &e->stepper->middle;
  int any = 0, count = 0, status = follow_directions(e, t);
  for (int i = 0; i < e->roots; i++) {
    e->found[i] = 0;
    any |= e->root[i].state == NSDAE_ROOT_MASKED;
  }
  for (int i = 0; i < T->system->dims.k; i++) any |= has_no_row(e, i);
  if (status < 0 || !any) return status;
  if (nsdae_dae_interpolate(e->dae, t, 0, e->y) < 0) return NSDAE_E_CONVERGENCE;
  status = evaluate(e, t, e->y);
  if (status < 0) return status;
  for (int i = 0; i < e->roots; i++) {
    if (e->root[i].state != NSDAE_ROOT_MASKED) continue;
    e->found[i] = watch(e, T, e->at, i);
    count += e->found[i];
  }
  return count + watch_gaps(e, T);
}
