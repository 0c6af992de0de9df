#include "roots.h"

#include <float.h>
#include <math.h>
#include <string.h>

/* With two directions a velocity is followed through the errors of the integration, from which it
 * is undecided at first which way it goes: this multiple of the tolerance. */
static const double TURNING = 100;

/* There too a motion that stops may turn within its velocity's error in ever shorter steps: after
 * this number a slow slip has stopped. */
enum { SHORT_STEPS = 20 };

/* Of the determinant of a phase with relations: then new ones are due. */
static const double RELATIONS_LEFT = 0.5;

void nsdae_event_roots_layout(nsdae_event_roots *r, nsdae_arena *arena)
{
  const nsdae_dims *d = &r->phase->setting->system->dims;
  r->count = 3 * d->k + 2 * d->f + 2;
  r->entry = nsdae_arena_take(arena, r->count, sizeof *r->entry);
  r->at = NSDAE_ARENA_DOUBLES(arena, r->phase->setting->at.n);
}

void nsdae_event_roots_name(nsdae_event_roots *r)
{
  const nsdae_dims *d = &r->phase->setting->system->dims;
  for (int kind = NSDAE_ROOT_NORMAL; kind <= NSDAE_ROOT_CHANGE; kind++)
    for (int i = 0; i < (kind >= NSDAE_ROOT_JAM ? 1 : kind <= NSDAE_ROOT_HELD ? d->k : d->f); i++) {
      nsdae_event_root *root = nsdae_event_root_of(r, (nsdae_root_kind)kind, i);
      root->kind = (nsdae_root_kind)kind;
      root->index = i;
    }
}

static int contact_rubs(const nsdae_event_phase *p, int i)
{
  return p->modes.contact[i] == NSDAE_MODE_SLIP && p->setting->system->contact[i].mu > 0;
}

/* A contact or frictional joint that has no direction to slide in yet. */
static int undecided(const nsdae_event_phase *p, const nsdae_event_root *root)
{
  int i = root->index, nt = p->setting->system->dims.nt;
  if (root->kind == NSDAE_ROOT_SLIP)
    return p->modes.frictional_joint[i] == NSDAE_MODE_SLIP && p->modes.slide_sense[i] == 0;
  int directed = root->kind == NSDAE_ROOT_NORMAL || root->kind == NSDAE_ROOT_TANGENT;
  if (!directed || !contact_rubs(p, i)) return 0;
  for (int j = i * nt; j < (i + 1) * nt; j++)
    if (p->modes.direction[j] != 0) return 0;
  return 1;
}

/* d . v_T of contact i; with an acceleration and omega in their place, its rate. */
static double along_direction(const nsdae_event_phase *p, const nsdae_terms *T, int i,
                              const double *w, const double *v)
{
  int nt = T->system->dims.nt;
  double along = 0;
  for (int j = i * nt; j < (i + 1) * nt; j++)
    along += p->modes.direction[j] * nsdae_terms_rate(T, &T->by.tangent, w, j, v);
  return along;
}

static int has_row(const nsdae_event_phase *p, nsdae_event_row_kind kind)
{
  int any = 0;
  for (int a = 0; a < p->rows.count; a++) any |= p->rows.row[a].kind == kind;
  return any;
}

/* At the point in work. The sine is measured only if that of the forces' equations, by another
 * order of elimination, comes near. */
static double change_point(const nsdae_event_phase *p)
{
  const nsdae_event_crossing *c = &p->crossing;
  int crosses = c->count > 0, rank = p->setting->system->dims.m - *p->modes.redundant;
  double sine;
  if (!crosses && !(c->least < NSDAE_CROSSING_NEAR * c->width)) return 1;
  if (nsdae_event_sine(p->setting, crosses ? c->rank : rank, &sine) < 0) return 1;
  return crosses ? 1.5 - sine / c->width : sine / c->width - 1;
}

/* The function as it is. */
static double value_of(const nsdae_event_phase *p, const nsdae_terms *T, const double *y,
                       const nsdae_event_root *root)
{
  const nsdae_system *s = T->system;
  const nsdae_event_modes *m = &p->modes;
  const nsdae_event_places *at = &p->setting->at;
  int i = root->index;
  if (root->kind == NSDAE_ROOT_NORMAL)
    return m->contact[i] == NSDAE_MODE_OPEN ? T->gap[i] : y[at->normal + i];
  if (root->kind == NSDAE_ROOT_CHANGE) return change_point(p);
  if (root->kind == NSDAE_ROOT_TANGENT)
    return m->contact[i] == NSDAE_MODE_STICK ? nsdae_event_stick_margin(p, y, i)
                                             : along_direction(p, T, i, T->w_T, T->v);
  /* a feature that is lost may have any gap: then as far below zero as it began above */
  if (root->kind == NSDAE_ROOT_HELD) return fmax(root->size - fabs(T->gap[i]), -root->size);
  if (root->kind == NSDAE_ROOT_JAM) {
    /* det A / det A(t_0), less 1/2 with relations. */
    int sign;
    double part = exp(nsdae_border_determinant(&p->border, &sign) - root->start);
    return root->rate * sign * part - (has_row(p, NSDAE_ROW_RELATED) ? RELATIONS_LEFT : 0);
  }
  const nsdae_frictional_joint *joint = &s->frictional_joint[i];
  double normal = joint->mu > 0 ? m->normal_sense[i] * y[at->lambda + joint->constraint] : 0;
  if (root->kind == NSDAE_ROOT_SIGN) return normal;
  if (m->frictional_joint[i] == NSDAE_MODE_STICK)
    return T->frictional_joint.bound[i] + joint->mu * normal +
           nsdae_terms_circle(s, i, y + at->lambda) - fabs(y[at->frictional_joint + i]);
  return m->slide_sense[i] * nsdae_terms_slide_rate(T, i, T->v);
}

/* Terms that the functions in the set need. */
static unsigned terms_of(const nsdae_event_roots *r)
{
  const nsdae_event_modes *m = &r->phase->modes;
  unsigned terms = 0;
  for (int e = 0; e < r->count; e++) {
    const nsdae_event_root *root = &r->entry[e];
    int i = root->index, on = root->state != NSDAE_ROOT_OFF;
    if ((root->kind == NSDAE_ROOT_NORMAL && m->contact[i] == NSDAE_MODE_OPEN) ||
        (on && root->kind == NSDAE_ROOT_HELD))
      terms |= NSDAE_TERM_GAP;
    if (on && root->kind == NSDAE_ROOT_TANGENT && m->contact[i] == NSDAE_MODE_SLIP)
      terms |= NSDAE_TERM_TANGENT | NSDAE_TERM_BIAS;
    if (on && root->kind == NSDAE_ROOT_SLIP) terms |= NSDAE_TERM_SLIDE | NSDAE_TERM_BOUND;
  }
  return terms;
}

/* The terms, and where something is closed the forces, at q and v of y: into r->at. */
static int evaluate(nsdae_event_roots *r, double t, const double *y)
{
  nsdae_event_phase *p = r->phase;
  int status = NSDAE_OK;
  memcpy(r->at, y, (size_t)p->setting->at.n * sizeof *y);
  if (p->terms & (NSDAE_TERM_NORMAL | NSDAE_TERM_SLIDE))
    status = nsdae_event_forces(p, t, r->at);
  else
    nsdae_event_move(p->setting, t, y);
  return status < 0 ? status : nsdae_terms_need(p->setting->here, terms_of(r));
}

/* Divided by the time since it was zero; so close to it that rounding rules, its rate. */
static double rising(const nsdae_event_root *root, double t, double value, double position)
{
  double least = 64 * DBL_EPSILON * (position / root->rate + fabs(t));
  return t - root->since > least ? (value - root->start) / (t - root->since) : root->rate;
}

/* A gap that is above the tolerance after the first step: as that of a contact which a list names
 * only then, so that both have the same root. */
static int has_risen(const nsdae_event_phase *p, const nsdae_event_root *root, double value)
{
  return root->state == NSDAE_ROOT_RISING && root->kind == NSDAE_ROOT_NORMAL &&
         p->modes.contact[root->index] == NSDAE_MODE_OPEN && value > root->size;
}

/* A velocity of sliding that is zero to rounding has no direction yet to be measured along: it is
 * out of the set until it has. One in the plane that starts within the tolerance and has one is
 * lifted: braked, it would slide on against its friction until the end of the step. */
static int is_out(const nsdae_event_phase *p, const nsdae_event_root *root)
{
  int masked = root->state == NSDAE_ROOT_MASKED &&
               (p->setting->system->dims.nt > 1 || !(root->start > -root->size));
  int slips = root->kind == NSDAE_ROOT_TANGENT && p->modes.contact[root->index] == NSDAE_MODE_SLIP;
  return root->state == NSDAE_ROOT_OFF || (masked && slips) ||
         (root->kind != NSDAE_ROOT_NORMAL && undecided(p, root));
}

int nsdae_event_root_values(nsdae_event_roots *r, double t, const double *y, int begins, double *g)
{
  const nsdae_event_phase *p = r->phase;
  if (evaluate(r, t, y) < 0) return -1;
  double position = nsdae_largest(p->setting->at.lambda, y);
  for (int e = 0; e < r->count; e++) {
    nsdae_event_root *root = &r->entry[e];
    int out = is_out(p, root);
    g[e] = out ? 1 : value_of(p, p->setting->here, r->at, root);
    root->moved |= !out && g[e] > root->size;
    if (begins && has_risen(p, root, g[e])) root->state = NSDAE_ROOT_LIVE;
    if (root->state == NSDAE_ROOT_RISING) g[e] = rising(root, t, g[e], position);
    if (root->state == NSDAE_ROOT_MASKED && !out) g[e] += root->size;
  }
  return 0;
}

/* Size of a force that is zero up to the errors of the integration. */
static double force_size(const nsdae_event_setting *s, const double *y)
{
  int first = s->at.lambda;
  double most = fmax(nsdae_largest(s->at.n - first, y + first),
                     nsdae_largest(s->system->dims.nv, s->here->F));
  return 10 * (fmax(s->options->rtol, 1e-13) * most + s->options->atol);
}

/* Of a root that is made of forces: what the modes take for no acceleration, none, leaves of it.
 * With G of each row, none / G_N of F_N, and mu none / G_N + none / G_T of mu F_N - |F_T|. */
static double undecided_force(const nsdae_event_phase *p, const nsdae_event_root *root)
{
  const nsdae_system *s = p->setting->system;
  const nsdae_dims *d = &s->dims;
  double none = p->modes.none, most = 0;
  int i = root->index;
  if (root->kind == NSDAE_ROOT_SLIP)
    return nsdae_event_force_that_gives(p, d->k * (1 + d->nt) + i, none);
  if (root->kind != NSDAE_ROOT_NORMAL && root->kind != NSDAE_ROOT_TANGENT) return 0;
  double normal = nsdae_event_force_that_gives(p, i, none);
  if (root->kind == NSDAE_ROOT_NORMAL) return normal;
  for (int j = d->k + i * d->nt; j < d->k + (i + 1) * d->nt; j++)
    most = fmax(most, nsdae_event_force_that_gives(p, j, none));
  return s->contact[i].mu * normal + most;
}

/* Live where it is above zero; with a rate, rising from zero; else masked. */
static void start_root(const nsdae_event_phase *p, nsdae_event_root *root, double t, double value,
                       double rate, double size, double rate_size)
{
  double blur = root->kind == NSDAE_ROOT_TANGENT ? p->modes.blur[root->index] : 1;
  int gap = root->kind == NSDAE_ROOT_NORMAL && p->modes.contact[root->index] == NSDAE_MODE_OPEN;
  size *= blur;
  root->since = t;
  root->start = value;
  root->moved = value > size;
  root->rate = rate;
  root->size = size;
  if (value > size)
    root->state = NSDAE_ROOT_LIVE;
  else if (rate > rate_size && (gap || value > -size) && blur == 1)
    root->state = NSDAE_ROOT_RISING;
  else
    root->state = NSDAE_ROOT_MASKED;
  if (gap && value < -size) root->size = size - value; /* overlaps: no deeper than now */
}

static void start_sliding(const nsdae_event_phase *p, nsdae_event_root *root, double t,
                          double value, const double *a)
{
  const nsdae_terms *T = p->setting->here;
  double size = nsdae_event_velocity_size(p->setting);
  if (root->kind == NSDAE_ROOT_SLIP) {
    double rate =
        nsdae_terms_rate(T, &T->by.frictional_joint, T->frictional_joint.omega, root->index, a);
    start_root(p, root, t, value, p->modes.slide_sense[root->index] * rate, size, size);
    return;
  }
  double rate = along_direction(p, T, root->index, T->omega.T, a);
  /* what slides already and is braked will stop, however soon */
  int turning = T->system->dims.nt == 2 && !(value > size && rate < 0);
  start_root(p, root, t, value, rate, turning ? TURNING * size : size, 0);
  /* so slow a start is no rate to divide by */
  if (root->state == NSDAE_ROOT_RISING && !(rate > size)) root->state = NSDAE_ROOT_MASKED;
}

static int is_off(const nsdae_event_phase *p, const nsdae_event_root *root)
{
  int i = root->index;
  if (root->kind == NSDAE_ROOT_NORMAL) return 0;
  if (root->kind == NSDAE_ROOT_CHANGE) return p->setting->system->dims.m == 0;
  if (root->kind == NSDAE_ROOT_HELD)
    return p->modes.contact[i] == NSDAE_MODE_OPEN || !nsdae_event_is_related(p, i);
  if (root->kind == NSDAE_ROOT_JAM)
    return !has_row(p, NSDAE_ROW_RUBS) && !has_row(p, NSDAE_ROW_RELATED);
  if (root->kind == NSDAE_ROOT_TANGENT)
    return p->modes.contact[i] == NSDAE_MODE_OPEN || !(p->setting->system->contact[i].mu > 0);
  int loaded = p->setting->system->frictional_joint[i].mu > 0;
  return p->modes.frictional_joint[i] == NSDAE_MODE_OPEN ||
         (root->kind == NSDAE_ROOT_SIGN && !loaded);
}

static void start(const nsdae_event_phase *p, nsdae_event_root *root, double t, const double *y,
                  const double *a)
{
  const nsdae_terms *T = p->setting->here;
  int i = root->index, contact = root->kind <= NSDAE_ROOT_HELD;
  int mode = contact ? p->modes.contact[i] : p->modes.frictional_joint[i];
  root->state = NSDAE_ROOT_OFF;
  root->rate = 1;
  if (is_off(p, root)) return;
  if (root->kind == NSDAE_ROOT_CHANGE) { /* off where a width is all there is */
    root->state = value_of(p, T, y, root) > 0 ? NSDAE_ROOT_LIVE : NSDAE_ROOT_OFF;
    return;
  }
  if (root->kind == NSDAE_ROOT_JAM) {
    int sign;
    root->state = NSDAE_ROOT_LIVE;
    root->start = nsdae_border_determinant(&p->border, &sign);
    root->rate = sign;
    return;
  }
  if (root->kind == NSDAE_ROOT_HELD) root->size = nsdae_event_position_size(p->setting);
  double value = value_of(p, T, y, root);
  if (root->kind == NSDAE_ROOT_HELD)
    root->state = value > 0 ? NSDAE_ROOT_LIVE : NSDAE_ROOT_MASKED;
  else if (root->kind == NSDAE_ROOT_NORMAL && mode == NSDAE_MODE_OPEN)
    start_root(p, root, t, value, nsdae_terms_normal_rate(T, i, T->v),
               nsdae_event_position_size(p->setting), nsdae_event_velocity_size(p->setting));
  else if (root->kind == NSDAE_ROOT_NORMAL || root->kind == NSDAE_ROOT_SIGN ||
           mode == NSDAE_MODE_STICK)
    start_root(p, root, t, value, 0, force_size(p->setting, y) + undecided_force(p, root), 0);
  else
    start_sliding(p, root, t, value, a);
}

int nsdae_event_set_roots(nsdae_event_roots *r, double t, const double *y, const double *a)
{
  nsdae_event_setting *s = r->phase->setting;
  nsdae_event_move(s, t, y);
  int status = nsdae_terms_need(
      s->here, NSDAE_TERM_FORCE | NSDAE_TERM_GAP | NSDAE_TERM_NORMAL | NSDAE_TERM_TANGENT |
                   NSDAE_TERM_BIAS | NSDAE_TERM_SLIDE | NSDAE_TERM_ACCELERATION | NSDAE_TERM_BOUND);
  for (int e = 0; e < r->count && status == NSDAE_OK; e++) start(r->phase, &r->entry[e], t, y, a);
  return status;
}

void nsdae_event_start_late(nsdae_event_roots *r, double t, const int *marked)
{
  for (int e = 0; e < r->count; e++) {
    nsdae_event_root *root = &r->entry[e];
    if (root->kind > NSDAE_ROOT_HELD || !marked[root->index]) continue;
    *root = (nsdae_event_root){.kind = root->kind,
                               .index = root->index,
                               .state = root->kind == NSDAE_ROOT_NORMAL ? NSDAE_ROOT_LIVE
                                                                        : NSDAE_ROOT_OFF,
                               .moved = 1,
                               .since = t,
                               .rate = 1,
                               .size = nsdae_event_position_size(r->phase->setting)};
  }
}

/* How fast an undecided one slides. */
static double undecided_speed(const nsdae_event_phase *p, const nsdae_event_root *root)
{
  const nsdae_terms *T = p->setting->here;
  if (root->kind == NSDAE_ROOT_TANGENT) return nsdae_terms_slip(T, root->index, T->v);
  return fabs(nsdae_terms_slide_rate(T, root->index, T->v));
}

/* A masked function after a step: 1 where it asks for an instant. */
static int watch(const nsdae_event_phase *p, const double *y, nsdae_event_root *root)
{
  double value = root->kind == NSDAE_ROOT_NORMAL || !undecided(p, root)
                     ? value_of(p, p->setting->here, y, root)
                     : undecided_speed(p, root);
  /* what presses or moves without a direction needs one */
  if (value > root->size && undecided(p, root)) return root->moved = 1;
  if (value > root->size) root->state = NSDAE_ROOT_LIVE;
  return value < -root->size;
}

/* With two directions of friction a contact goes on in that of its velocity, while it has one. */
static int follow_directions(nsdae_event_phase *p, double t, const double *y)
{
  nsdae_terms *T = p->setting->here;
  int any = 0, k = T->system->dims.k;
  for (int i = 0; i < k; i++) any |= T->system->dims.nt == 2 && contact_rubs(p, i);
  if (!any) return NSDAE_OK;
  nsdae_event_move(p->setting, t, y);
  int status = nsdae_terms_need(T, NSDAE_TERM_TANGENT | NSDAE_TERM_BIAS);
  for (int i = 0; i < k && status == NSDAE_OK; i++) {
    if (!contact_rubs(p, i) || !(along_direction(p, T, i, T->w_T, T->v) > p->modes.slow)) continue;
    for (int j = 2 * i; j < 2 * i + 2; j++)
      p->modes.direction[j] = nsdae_terms_tangent_rate(T, j, T->v);
    double *d = p->modes.direction + 2 * i, speed = hypot(d[0], d[1]);
    for (int l = 0; l < 2; l++) d[l] /= speed;
  }
  return status;
}

int nsdae_event_watch_roots(nsdae_event_roots *r, double t, const double *y)
{
  nsdae_event_phase *p = r->phase;
  int any = 0, count = 0;
  for (int e = 0; e < r->count; e++) r->entry[e].found = 0;
  int status = follow_directions(p, t, y);
  if (status == NSDAE_OK && r->short_steps > SHORT_STEPS) status = nsdae_event_stop_slow(r, t, y);
  for (int e = 0; e < r->count; e++) {
    const nsdae_event_root *root = &r->entry[e];
    any |= root->found || root->state == NSDAE_ROOT_MASKED;
  }
  if (status < 0 || !any) return status;
  status = evaluate(r, t, y);
  for (int e = 0; e < r->count && status == NSDAE_OK; e++) {
    nsdae_event_root *root = &r->entry[e];
    if (root->state == NSDAE_ROOT_MASKED) root->found = watch(p, r->at, root);
    count += root->found;
  }
  return status < 0 ? status : count;
}

int nsdae_event_stop_slow(nsdae_event_roots *r, double t, const double *y)
{
  nsdae_event_phase *p = r->phase;
  nsdae_event_move(p->setting, t, y);
  const nsdae_terms *T = p->setting->here;
  int count = 0, status = nsdae_terms_need(p->setting->here, NSDAE_TERM_TANGENT | NSDAE_TERM_BIAS);
  for (int i = 0; i < T->system->dims.k && status == NSDAE_OK; i++) {
    nsdae_event_root *root = nsdae_event_root_of(r, NSDAE_ROOT_TANGENT, i);
    if (root->state != NSDAE_ROOT_LIVE || !contact_rubs(p, i)) continue;
    root->found |= nsdae_event_hardly_slides(p, i);
    count += root->found;
  }
  return status < 0 ? status : count;
}

int nsdae_event_inconsistent(const nsdae_event_roots *r)
{
  const nsdae_event_modes *m = &r->phase->modes;
  double most = 1;
  int worst = -1;
  for (int e = 0; e < r->count; e++) {
    const nsdae_event_root *root = &r->entry[e];
    int contact = root->kind <= NSDAE_ROOT_HELD, i = root->index;
    int mode = contact ? m->contact[i] : m->frictional_joint[i];
    int is_force = (root->kind == NSDAE_ROOT_NORMAL && mode != NSDAE_MODE_OPEN) ||
                   root->kind == NSDAE_ROOT_SIGN ||
                   ((root->kind == NSDAE_ROOT_TANGENT || root->kind == NSDAE_ROOT_SLIP) &&
                    mode == NSDAE_MODE_STICK);
    if (root->state == NSDAE_ROOT_OFF || !is_force || !(-root->start > most * root->size)) continue;
    most = -root->start / root->size;
    worst = e;
  }
  return worst;
}

int nsdae_event_unbounded(const nsdae_event_roots *r, double part)
{
  const nsdae_event_phase *p = r->phase;
  int worst = -1;
  for (int i = 0; i < p->setting->system->dims.k; i++) {
    if (!contact_rubs(p, i) || nsdae_event_is_related(p, i)) continue;
    double alone = nsdae_event_force_that_gives(p, i, 1); /* 1 / G */
    double left = fabs(nsdae_event_yield(p, i)) * alone;
    if (!(left <= part)) continue;
    part = left;
    worst = i;
  }
  return worst;
}
