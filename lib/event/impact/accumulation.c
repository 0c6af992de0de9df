#include "accumulation.h"

#include <float.h>
#include <math.h>
#include <string.h>

#include "dense.h"
#include "errors.h"

/* ---- impact projection */

enum { PROJECTIONS = 4 };

/* Of the missing part, and of the tolerance: a change larger by this factor leads elsewhere.
 * Then rows nearly depend on each other and differ by no more than the integrator's errors:
 * positions and velocities are as near as they can be. */
static const double FAR = 100;

/* Rows whose sine is less depend on each other up to errors, which they would magnify. */
static const double LEAST_SINE = 1e-6;

void nsdae_event_projection_layout(nsdae_event_projection *p, nsdae_arena *arena)
{
  const nsdae_dims *d = &p->phase->setting->system->dims;
  int rows = d->m + d->k * (1 + d->nt) + d->f;
  double sine = fmax(p->phase->setting->options->rank_tol, LEAST_SINE);
  nsdae_least_layout(&p->least, p->phase->setting->system, rows, sine, arena);
  p->qdot = NSDAE_ARENA_DOUBLES(arena, d->nq);
}

/* Appends row j, with what velocities v are off by. */
static void append_rate(nsdae_event_projection *p, const nsdae_rows *rows, const double *w, int j,
                        const double *v)
{
  double missing = nsdae_terms_rate(p->phase->setting->here, rows, w, j, v);
  nsdae_least_append(&p->least, rows, j, missing);
}

/* Appends positions; returns the worst. */
static double append_positions(nsdae_event_projection *p, const int *closed)
{
  const nsdae_terms *T = p->phase->setting->here;
  const nsdae_dims *d = &T->system->dims;
  nsdae_least_start(&p->least);
  for (int i = 0; i < d->m; i++)
    nsdae_least_append(&p->least, &T->by.jacobian, i, T->constraint.phi[i]);
  for (int n = 0; n < d->k; n++) {
    int i = nsdae_system_contact(T->system, n);
    if (closed[i]) nsdae_least_append(&p->least, &T->by.normal, i, T->gap[i]);
  }
  return nsdae_largest(p->least.rows, p->least.c);
}

/* At the border of a change point the rows differ: by a sine of its width. */
static double far_of(const nsdae_event_phase *p)
{
  return p->crossing.at_border ? FAR / p->crossing.width : FAR;
}

int nsdae_event_project_positions(nsdae_event_projection *p, double t, const int *closed, double *y)
{
  nsdae_event_setting *s = p->phase->setting;
  for (int round = 0; round < PROJECTIONS; round++) {
    double worst = append_positions(p, closed);
    if (p->least.rows == 0 || worst <= 4 * DBL_EPSILON) break;
    int status = nsdae_least_solve(&p->least, s->here);
    if (status == NSDAE_OK) status = nsdae_kinematics_at(s->here, p->least.change, p->qdot);
    if (status < 0) return status;
    if (nsdae_largest(s->at.v, p->qdot) > far_of(p->phase) * (worst + nsdae_event_position_size(s)))
      break;
    for (int i = 0; i < s->at.v; i++) y[i] += p->qdot[i];
    nsdae_event_move(s, t, y);
    status = nsdae_terms_need(s->here, NSDAE_TERM_MASS | NSDAE_TERM_PHI | NSDAE_TERM_JACOBIAN |
                                           NSDAE_TERM_GAP | NSDAE_TERM_NORMAL);
    if (status < 0) return status;
  }
  return NSDAE_OK;
}

/* Starts with the rates of the constraints. */
static void append_rates(nsdae_event_projection *p, const double *v)
{
  const nsdae_terms *T = p->phase->setting->here;
  int m = T->system->dims.m;
  nsdae_least_start(&p->least);
  for (int i = 0; i < m; i++) append_rate(p, &T->by.jacobian, T->constraint.phi_t, i, v);
}

/* Whether in two directions a contact sticks, with forces that follow from the direction in which
 * another begins to slide: its velocity is then none. */
static int any_sticks(const nsdae_event_phase *p)
{
  const nsdae_dims *d = &p->setting->system->dims;
  int any = 0;
  for (int i = 0; i < d->k; i++) any |= d->nt == 2 && p->modes.contact[i] == NSDAE_MODE_STICK;
  return any;
}

/* How many rows contact i has: none, the normal, or all. */
static int rows_of(const nsdae_event_projection *p, const int *moving, int begin, int i)
{
  const nsdae_event_modes *m = &p->phase->modes;
  const nsdae_system *s = p->phase->setting->system;
  if (m->contact[i] == NSDAE_MODE_OPEN) return 0;
  int rests = begin && s->contact[i].mu > 0 && !moving[i];
  return rests || m->contact[i] == NSDAE_MODE_STICK ? 1 + s->dims.nt : 1;
}

static void append_velocities(nsdae_event_projection *p, const int *moving, int begin)
{
  const nsdae_terms *T = p->phase->setting->here;
  const nsdae_event_modes *m = &p->phase->modes;
  const nsdae_dims *d = &T->system->dims;
  append_rates(p, T->v);
  for (int n = 0; n < d->k; n++) {
    int i = nsdae_system_contact(T->system, n), rows = rows_of(p, moving, begin, i);
    if (rows > 0) append_rate(p, &T->by.normal, T->w_N, i, T->v);
    for (int j = i * d->nt; rows > 1 && j < (i + 1) * d->nt; j++)
      append_rate(p, &T->by.tangent, T->w_T, j, T->v);
  }
  for (int j = 0; j < d->f; j++)
    if (m->frictional_joint[j] == NSDAE_MODE_STICK)
      append_rate(p, &T->by.frictional_joint, T->frictional_joint.w, j, T->v);
}

/* The impulses of the projection are a part of the change of momentum. */
static void add_linear(const nsdae_event_projection *p, const int *moving, int begin)
{
  const nsdae_event_setting *s = p->phase->setting;
  const nsdae_dims *d = &s->system->dims;
  static const double none[2];
  const double *c = p->least.c + d->m;
  for (int n = 0; n < d->k && s->system->maker.sensors.contact_forces; n++) {
    int i = nsdae_system_contact(s->system, n), rows = rows_of(p, moving, begin, i);
    if (rows == 0) continue;
    nsdae_terms_add_linear(s->here, i, -1, *c, rows > 1 ? c + 1 : none,
                           s->result->impulses.linear + 3 * i);
    c += rows;
  }
}

/* The balance of energy of a change d that takes the rates A v + w of its rows to zero, with the
 * impulses L, M d = A^T L. On the rates it does the work L^T (A v + w) / 2 = -d^T M d / 2; moving
 * rows, as of drives and motors, give -L^T w = d^T M (v + d), which is zero if w is. Its impulses
 * are an error of the integration, not of the contacts: those of the record obey the laws of
 * contact. */
static void account_change(const nsdae_event_projection *p)
{
  const nsdae_event_setting *s = p->phase->setting;
  const nsdae_terms *T = s->here;
  const double *change = p->least.change;
  double *momentum = T->by.work;
  int n = T->system->dims.nv;
  memset(momentum, 0, (size_t)n * sizeof *momentum);
  nsdae_blocks_add_product(&T->system->blocks, T->M, change, momentum);
  double along = nsdae_dot(n, momentum, change);
  s->result->work -= along / 2;
  s->result->gain += nsdae_dot(n, momentum, T->v) + along;
}

int nsdae_event_project_velocities(nsdae_event_projection *p, const int *moving, double *y)
{
  nsdae_event_setting *s = p->phase->setting;
  int begin = moving && any_sticks(p->phase);
  append_velocities(p, moving, begin);
  if (p->least.rows == 0) return NSDAE_OK;
  double worst = nsdae_largest(p->least.rows, p->least.c);
  int status = nsdae_least_solve(&p->least, s->here);
  if (status < 0) return status;
  double size = far_of(p->phase) * (worst + nsdae_event_velocity_size(s));
  if (nsdae_largest(p->least.kkt.n, p->least.change) > size) return NSDAE_OK;
  account_change(p);
  add_linear(p, moving, begin);
  nsdae_add(p->least.kkt.n, 1, p->least.change, y + s->at.v);
  nsdae_terms_set_velocity(s->here, y + s->at.v);
  return NSDAE_OK;
}

/* v [nv] to the rates of the constraints and, of the contacts that are marked [k], to no velocity
 * apart, nor along where they stick; adds the impulses that do it to multiplier [m] and fills
 * normal [k] and tangential [k nt] with theirs, which may pull. The point in work stays. */
static int event_close(nsdae_event_projection *p, const int *closed, const int *sticks, double *v,
                       double *multiplier, double *normal, double *tangential)
{
  const nsdae_terms *T = p->phase->setting->here;
  const nsdae_dims *d = &T->system->dims;
  append_rates(p, v);
  for (int n = 0; n < d->k; n++) {
    int i = nsdae_system_contact(T->system, n);
    if (closed[i]) append_rate(p, &T->by.normal, T->w_N, i, v);
    for (int j = i * d->nt; closed[i] && sticks[i] && j < (i + 1) * d->nt; j++)
      append_rate(p, &T->by.tangent, T->w_T, j, v);
  }
  int status = nsdae_least_solve(&p->least, T), row = d->m;
  if (status < 0) return status;
  nsdae_add(d->nv, 1, p->least.change, v);
  nsdae_add(d->m, 1, p->least.c, multiplier);
  for (int n = 0; n < d->k; n++) {
    int i = nsdae_system_contact(T->system, n);
    normal[i] = closed[i] ? -p->least.c[row++] : 0;
    for (int j = i * d->nt; j < (i + 1) * d->nt; j++)
      tangential[j] = closed[i] && sticks[i] ? -p->least.c[row++] : 0;
  }
  return NSDAE_OK;
}

/* In accumulation_time: what is closed with more than that left is not told when it would end. */
static const double MOST = 1000;

/* Instants of a contact in a row after which errors alone keep it up. */
enum { PATIENCE = 50, EACH = 8 };

void nsdae_event_accumulation_layout(nsdae_event_accumulation *p, nsdae_arena *arena)
{
  const nsdae_dims *d = &p->acceleration->phase->setting->system->dims;
  nsdae_arena_ints(
      arena, d->k,
      (int **[]){&p->settles, &p->sticks, &p->friction.slider, &p->friction.pivot, NULL});
  nsdae_arena_doubles(arena, d->k, (double **[]){&p->after, &p->normal, &p->friction.P, NULL});
  nsdae_arena_doubles(arena, d->nv, (double **[]){&p->parting, &p->lost, &p->flight, NULL});
  p->reaction = NSDAE_ARENA_DOUBLES(arena, d->m);
  p->tangential = NSDAE_ARENA_DOUBLES(arena, (long)d->k * d->nt);
  p->friction.value = NSDAE_ARENA_DOUBLES(arena, (long)d->k * d->nt);
  p->friction.feed = NSDAE_ARENA_DOUBLES(arena, (long)d->k * d->k);
}

void nsdae_event_unsettle(nsdae_event_accumulation *p)
{
  const nsdae_dims *d = &p->acceleration->phase->setting->system->dims;
  memset(p->settles, 0, (size_t)d->k * sizeof *p->settles);
  memset(p->normal, 0, (size_t)d->k * sizeof *p->normal);
  memset(p->tangential, 0, (size_t)(d->k * d->nt) * sizeof *p->tangential);
  p->work = p->rest = 0;
}

/* The accelerations at v- with the contact forces of the phase that ends, from y: a row of angles
 * has no part of the weight but by the forces of joints, or of what lies on its body. */
int nsdae_event_take_flight(nsdae_event_accumulation *p, const double *y)
{
  const nsdae_event_phase *phase = p->acceleration->phase;
  const nsdae_event_setting *s = phase->setting;
  const nsdae_terms *T = s->here;
  const nsdae_dims *d = &T->system->dims;
  memcpy(p->flight, T->F, (size_t)d->nv * sizeof *p->flight);
  for (int i = 0; i < d->m; i++) p->reaction[i] = -T->constraint.omega[i];
  for (int n = 0; n < d->k; n++) {
    int i = nsdae_system_contact(T->system, n);
    if (phase->modes.contact[i] == NSDAE_MODE_OPEN) continue;
    nsdae_rows_add(&T->system->blocks, &T->by.normal, i, y[s->at.normal + i], p->flight);
    for (int j = i * d->nt; j < (i + 1) * d->nt; j++)
      nsdae_rows_add(&T->system->blocks, &T->by.tangent, j, y[s->at.tangential + j], p->flight);
  }
  return nsdae_terms_solve(T, s->kkt, 1, p->flight, p->reaction);
}

/* How fast what contact i can be closed with may be: what it gains or loses by the accelerations
 * there are in accumulation_time, or on as short a way as the integrator's errors. */
static double slow_for(const nsdae_event_accumulation *p, int i)
{
  const nsdae_event_setting *s = p->acceleration->phase->setting;
  const nsdae_terms *T = s->here;
  const nsdae_blocks *b = &T->system->blocks;
  double rate = fabs(T->omega.N[i]) + fmax(nsdae_rows_dot_sizes(b, &T->by.normal, i, p->lost),
                                           nsdae_rows_dot_sizes(b, &T->by.normal, i, p->flight));
  double way = sqrt(2 * rate * nsdae_event_position_size(s));
  return fmax(way, fmax(NSDAE_EVENT_SLOW * nsdae_event_velocity_size(s),
                        s->options->accumulation_time * rate));
}

/* The candidates; how many of them part. M^-1 F is in `lost`. */
static int choose_slow(nsdae_event_accumulation *p, double most)
{
  nsdae_event_setting *s = p->acceleration->phase->setting;
  const nsdae_event_findings *is = &p->acceleration->is;
  const nsdae_terms *T = s->here;
  int part = 0;
  p->slow = nsdae_event_velocity_size(s);
  memcpy(p->lost, T->F, (size_t)T->system->dims.nv * sizeof *p->lost);
  nsdae_kkt_solve_mass(s->kkt, p->lost);
  for (int i = 0; i < T->system->dims.k; i++) {
    int near = is->touching[i] || T->gap[i] <= nsdae_event_position_size(s);
    p->after[i] = nsdae_terms_normal_rate(T, i, T->v);
    is->candidate[i] = near && p->after[i] <= fmin(slow_for(p, i), most);
    if (is->candidate[i]) p->slow = fmax(p->slow, NSDAE_EVENT_SLOW * p->after[i]);
    part += is->candidate[i] && p->after[i] > nsdae_event_velocity_size(s);
  }
  return part;
}

/* Whether friction holds contact i: it rests, and does not begin to slide. */
static int stays(const nsdae_event_accumulation *p, int i)
{
  const nsdae_contacts *held = &p->acceleration->problem;
  int nt = held->system->dims.nt;
  double rate = nsdae_norm(nt, held->results->after_t + i * nt);
  return held->system->contact[i].mu > 0 && !p->acceleration->is.moving[i] &&
         rate <= nsdae_event_acceleration_size(p->acceleration);
}

/* v+ of `parting` with nothing left apart, nor along, of all candidates: into `lost`. The problem
 * of accelerations is asked there, at the limit. */
static int move_to_limit(nsdae_event_accumulation *p)
{
  nsdae_event_setting *s = p->acceleration->phase->setting;
  const nsdae_terms *T = s->here;
  const nsdae_dims *d = &T->system->dims;
  memcpy(p->lost, p->parting, (size_t)d->nv * sizeof *p->lost);
  for (int i = 0; i < d->k; i++) {
    p->settles[i] = p->acceleration->is.candidate[i];
    p->sticks[i] = T->system->contact[i].mu > 0 && nsdae_terms_slip(T, i, T->v) <= p->slow;
  }
  int status = event_close(p->projection, p->settles, p->sticks, p->lost, p->reaction, p->normal,
                           p->tangential);
  nsdae_terms_set_velocity(s->here, p->lost);
  return status < 0 ? status : nsdae_terms_need(s->here, NSDAE_EVENT_TERMS);
}

int nsdae_event_find_set(nsdae_event_accumulation *p, const double *v, double most)
{
  nsdae_event_setting *s = p->acceleration->phase->setting;
  const nsdae_contacts *held = &p->acceleration->problem;
  int any = 0;
  p->fastest = 0;
  memcpy(p->parting, v, (size_t)s->system->dims.nv * sizeof *v);
  nsdae_terms_set_velocity(s->here, v);
  int status = nsdae_terms_need(s->here, NSDAE_EVENT_TERMS);
  if (status < 0 || choose_slow(p, most) == 0) return status;
  status = move_to_limit(p);
  if (status < 0) return status;
  nsdae_event_set_laws(p->acceleration, 1, p->slow);
  int solved = nsdae_event_accelerate(p->acceleration, NSDAE_PAINLEVE_EXACT) == NSDAE_OK;
  nsdae_error_clear(s->error);
  double none = nsdae_event_acceleration_size(p->acceleration); /* others carry what has no force */
  for (int i = 0; i < s->system->dims.k; i++) {
    p->settles[i] = solved && p->acceleration->is.candidate[i] &&
                    (held->results->normal[i] > 0 || !(held->results->after[i] > none));
    p->sticks[i] = p->settles[i] && stays(p, i);
    if (p->settles[i]) p->fastest = fmax(p->fastest, p->after[i]);
    any |= p->settles[i];
  }
  if (!any) nsdae_event_unsettle(p);
  return any;
}

/* Half of what the closing's impulses do at the velocities of v. */
static double half_work(const nsdae_event_accumulation *p, const double *v)
{
  const nsdae_terms *T = p->acceleration->phase->setting->here;
  const nsdae_dims *d = &T->system->dims;
  double sum = 0;
  for (int i = 0; i < d->k; i++) sum += p->normal[i] * nsdae_terms_normal_rate(T, i, v);
  for (int j = 0; j < d->k * d->nt; j++)
    sum += p->tangential[j] * nsdae_terms_tangent_rate(T, j, v);
  return sum / 2;
}

/* [v]^T M [v] / 2 */
static int energy_apart(nsdae_event_accumulation *p, const double *v, double *energy)
{
  const nsdae_terms *T = p->acceleration->phase->setting->here;
  memcpy(p->lost, v, (size_t)T->system->dims.nv * sizeof *v);
  int status = event_close(p->projection, p->settles, p->sticks, p->lost, p->reaction, p->normal,
                           p->tangential);
  for (int i = 0; i < T->system->dims.nv; i++) p->lost[i] -= v[i];
  *energy = nsdae_terms_energy(T, p->lost);
  return status;
}

/* v [nv], multiplier [m] := those of `lost` and `reaction` with the friction of what slides. */
static int rub(nsdae_event_accumulation *p, double *v, double *multiplier)
{
  const nsdae_event_setting *s = p->acceleration->phase->setting;
  const nsdae_terms *T = s->here;
  const nsdae_dims *d = &T->system->dims;
  memset(v, 0, (size_t)d->nv * sizeof *v);
  memset(multiplier, 0, (size_t)d->m * sizeof *multiplier);
  for (int n = 0; n < d->k; n++) {
    int i = nsdae_system_contact(T->system, n);
    for (int j = i * d->nt; j < (i + 1) * d->nt; j++)
      nsdae_rows_add(&T->system->blocks, &T->by.tangent, j, p->friction.value[j], v);
  }
  int status = nsdae_terms_solve(T, s->kkt, 1, v, multiplier);
  nsdae_add(d->nv, 1, p->lost, v);
  nsdae_add(d->m, 1, p->reaction, multiplier);
  return status;
}

/* v and multiplier to the closed set with the friction so far. */
static int close_rubbed(nsdae_event_accumulation *p, double *v, double *multiplier)
{
  int status = rub(p, v, multiplier);
  return status < 0 ? status
                    : event_close(p->projection, p->settles, p->sticks, v, multiplier, p->normal,
                                  p->tangential);
}

/* T of contact i for the normal impulse P. */
static void set_friction(nsdae_event_accumulation *p, int i, double P)
{
  const nsdae_event_phase *phase = p->acceleration->phase;
  const nsdae_system *s = phase->setting->system;
  for (int l = 0, j = i * s->dims.nt; l < s->dims.nt; l++, j++)
    p->friction.value[j] = -s->contact[i].mu * P * phase->modes.direction[j];
}

/* The contacts of the set that slide with friction. */
static int list_sliders(nsdae_event_accumulation *p)
{
  const nsdae_system *s = p->acceleration->phase->setting->system;
  int count = 0;
  for (int n = 0; n < s->dims.k; n++) {
    int i = nsdae_system_contact(s, n);
    if (p->settles[i] && p->acceleration->is.moving[i] && s->contact[i].mu > 0)
      p->friction.slider[count++] = i;
  }
  return count;
}

/* The same with T = -mu P d. Without a solution, as of friction that feeds P by as much as itself,
 * what slides has no friction in the closing. */
static int close_with_friction(nsdae_event_accumulation *p, double *v, double *multiplier)
{
  nsdae_event_closing_friction *f = &p->friction;
  const nsdae_dims *d = &p->acceleration->phase->setting->system->dims;
  int count = list_sliders(p);
  memset(f->value, 0, (size_t)(d->k * d->nt) * sizeof *f->value);
  int status = close_rubbed(p, v, multiplier);
  for (int a = 0; a < count; a++) f->P[a] = p->normal[f->slider[a]];
  for (int b = 0; b < count && status == NSDAE_OK; b++) {
    set_friction(p, f->slider[b], 1);
    status = close_rubbed(p, v, multiplier);
    for (int a = 0; a < count; a++)
      f->feed[(size_t)b * (size_t)count + (size_t)a] =
          (a == b) - (p->normal[f->slider[a]] - f->P[a]);
    set_friction(p, f->slider[b], 0);
  }
  if (status < 0) return status;
  int solved = nsdae_la_lu(count, f->feed, count, f->pivot) == 0;
  if (solved) nsdae_la_lu_solve(count, f->feed, count, f->pivot, f->P);
  for (int a = 0; a < count; a++) set_friction(p, f->slider[a], solved ? f->P[a] : 0);
  if (count > 0) status = close_rubbed(p, v, multiplier);
  nsdae_add(d->k * d->nt, 1, f->value, p->tangential);
  return status;
}

/* How fast contact i still parts, or slides where it should stick. */
static double rest_of(const nsdae_event_accumulation *p, int i, const double *v)
{
  const nsdae_terms *T = p->acceleration->phase->setting->here;
  double rate = fabs(nsdae_terms_normal_rate(T, i, v));
  return p->sticks[i] ? fmax(rate, nsdae_terms_slip(T, i, v)) : rate;
}

/* Of rows that depend on each other the impulses are not unique: one that the closing would have
 * pull, and that others close as well, leaves it to them. impulse [k] is there before. */
static int leave_to_others(nsdae_event_accumulation *p, const double *impulse, double *v,
                           double *multiplier)
{
  const nsdae_event_setting *s = p->acceleration->phase->setting;
  int status = NSDAE_OK;
  for (int n = 0; n < s->system->dims.k && status == NSDAE_OK; n++) {
    int i = nsdae_system_contact(s->system, n);
    if (!p->settles[i] || !(impulse[i] + p->normal[i] < 0)) continue;
    p->settles[i] = 0;
    status = close_with_friction(p, v, multiplier);
    if (status < 0 || rest_of(p, i, v) <= nsdae_event_velocity_size(s)) continue;
    p->settles[i] = 1;
    status = close_with_friction(p, v, multiplier);
  }
  return status;
}

int nsdae_event_close_set(nsdae_event_accumulation *p, const double *before, const double *impulse,
                          double *v, double *multiplier)
{
  const nsdae_dims *d = &p->acceleration->phase->setting->system->dims;
  int status = energy_apart(p, before, &p->all);
  if (status == NSDAE_OK) status = energy_apart(p, p->parting, &p->left);
  memcpy(p->lost, v, (size_t)d->nv * sizeof *v);
  memcpy(p->reaction, multiplier, (size_t)d->m * sizeof *multiplier);
  if (status == NSDAE_OK) status = close_with_friction(p, v, multiplier);
  if (status == NSDAE_OK) status = leave_to_others(p, impulse, v, multiplier);
  p->work = half_work(p, p->lost) + half_work(p, v);
  return status;
}

/* The forces that follow with the set closed: at v_c the slip may be larger than at the limit, and
 * the friction may part what the limit holds. */
static int closed_forces(nsdae_event_accumulation *p, const double *closed)
{
  nsdae_event_setting *s = p->acceleration->phase->setting;
  nsdae_terms_set_velocity(s->here, closed);
  if (nsdae_terms_need(s->here, NSDAE_EVENT_TERMS) < 0) return 0;
  nsdae_event_set_laws(p->acceleration, 1, nsdae_event_velocity_size(s));
  int solved = nsdae_event_accelerate(p->acceleration, NSDAE_PAINLEVE_EXACT) == NSDAE_OK;
  nsdae_error_clear(s->error);
  return solved;
}

/* Of contact i of the set: the impulse of a velocity that is none, u / G. */
static double undecided_impulse(const nsdae_event_accumulation *p, int i)
{
  const nsdae_contacts *c = &p->acceleration->problem;
  for (int a = 0; a < c->active_count; a++) {
    double G = c->delassus.G[(size_t)c->first_column[a] * (size_t)(c->columns + 1)];
    if (c->active[a] == i && G > 0)
      return nsdae_event_velocity_size(p->acceleration->phase->setting) / G;
  }
  return 0;
}

/* The most instants in a row of any contact of the set. */
static int most_rattles(const nsdae_event_accumulation *p)
{
  int most = 0;
  for (int i = 0; i < p->acceleration->problem.system->dims.k; i++)
    if (p->settles[i] && p->rattles[i] > most) most = p->rattles[i];
  return most;
}

/* Whether with what the forces do until the end, or within accumulation_time, nothing pulls and
 * what sticks is in its cone. What slides has all the friction of these forces, so that its closing
 * is in the cone alone. After many instants in a row, which errors keep up, the tolerance doubles
 * with every EACH of them. */
static int is_admissible(const nsdae_event_accumulation *p, const nsdae_impulses *impact)
{
  const nsdae_event_acceleration *a = p->acceleration;
  const nsdae_system *s = a->phase->setting->system;
  int nt = s->dims.nt;
  double rest = fmin(p->rest, a->phase->setting->options->accumulation_time);
  double growth = nsdae_chattering_growth(most_rattles(p), PATIENCE, EACH);
  for (int i = 0; i < s->dims.k; i++) {
    if (!p->settles[i]) continue;
    double closing = impact->normal[i] + p->normal[i], along[2] = {0};
    double normal = closing + a->problem.results->normal[i] * rest;
    double none = growth * undecided_impulse(p, i);
    for (int l = 0, j = i * nt; l < nt; l++, j++)
      along[l] = impact->tangential[j] + p->tangential[j];
    double most = s->contact[i].mu * (p->sticks[i] ? normal : closing);
    if (normal < -none || nsdae_norm(nt, along) > most + none) return 0;
  }
  return 1;
}

int nsdae_event_ends(nsdae_event_accumulation *p, const double *closed,
                     const nsdae_impulses *impact)
{
  const nsdae_event_setting *s = p->acceleration->phase->setting;
  const nsdae_terms *T = s->here;
  const double *F = p->acceleration->problem.results->normal;
  double power = 0;
  int undecided = most_rattles(p) > PATIENCE; /* or several */
  for (int n = 0, count = 0; n < T->system->dims.k; n++) {
    int i = nsdae_system_contact(T->system, n);
    if (!p->settles[i] && p->acceleration->is.touching[i] && /* a closing that drives it in */
        nsdae_terms_normal_rate(T, i, closed) < -nsdae_event_velocity_size(s))
      return 0;
    if (!p->settles[i]) continue;
    power += F[i] * p->after[i];
    undecided |= ++count > 1;
  }
  double flight = power > 0 ? 4 * p->left / power : INFINITY;
  p->rest = p->left < p->all ? flight / (1 - sqrt(p->left / p->all)) : INFINITY;
  p->early = !(p->rest < s->options->accumulation_time);
  double told = undecided ? nsdae_event_position_size(s) : nsdae_event_rounding(s);
  int ends = !p->early || p->fastest <= NSDAE_EVENT_SLOW * nsdae_event_velocity_size(s) ||
             p->fastest * flight / 4 <= told;
  ends = ends && closed_forces(p, closed) && is_admissible(p, impact);
  if (!isfinite(p->rest) || p->rest > MOST * s->options->accumulation_time) p->rest = 0;
  return ends;
}
