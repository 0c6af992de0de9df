#include "phase.h"

#include <math.h>
#include <string.h>

#include "dense.h"
#include "stalled_steps.h"
#include "vector.h"

/* ---- chattering */

enum { FEW = 2000, EACH = 64, MOST = FEW + 20 * EACH };

void nsdae_chattering_note(const nsdae_chattering *r, int contact, double t, double soon, int many)
{
  int *count = r->count + contact;
  if (!(t - r->last[contact] < soon))
    *count = 0;
  else
    *count = *count + many < MOST ? *count + many : MOST;
  r->last[contact] = t;
}

double nsdae_chattering_blur(const nsdae_chattering *r, int contact)
{
  return nsdae_chattering_growth(r->count[contact], FEW, EACH);
}

double nsdae_chattering_growth(int count, int few, double each)
{
  return exp2(fmin(fmax(count - few, 0) / each, 20));
}

/* ---- slip direction */

/* u; returns what was added to v_T along last. */
static double slip_ahead(const double *last, double slow, const double *v_t, double *u)
{
  double more = fmax(slow - last[0] * v_t[0] - last[1] * v_t[1], 0);
  for (int l = 0; l < 2; l++) u[l] = v_t[l] + more * last[l];
  return more;
}

/* d [2]: the unit vector u / |u| of u = v_T, but along the direction `last` at least `slow`: it
 * goes smoothly through a stop. Its derivative by v_T along l: (1 - d d^T) du / |u|. */
static void slip_direction_ahead(const double *last, double slow, const double *v_t, double *d)
{
  double u[2];
  slip_ahead(last, slow, v_t, u);
  double size = hypot(u[0], u[1]);
  for (int l = 0; l < 2; l++) d[l] = u[l] / size;
}

static void slip_direction_slope(const double *last, double slow, const double *v_t, int l,
                                 double *slope)
{
  double u[2], du[2];
  double more = slip_ahead(last, slow, v_t, u), size = hypot(u[0], u[1]);
  for (int j = 0; j < 2; j++) du[j] = (j == l) - (more > 0 ? last[l] * last[j] : 0);
  double along = (u[0] * du[0] + u[1] * du[1]) / size;
  for (int j = 0; j < 2; j++) slope[j] = (du[j] - along * u[j] / size) / size;
}

void nsdae_slip_direction_against(double *direction, int nt, const double *force)
{
  double size = nsdae_norm(nt, force);
  for (int l = 0; l < nt; l++) direction[l] = size > 0 ? -force[l] / size : 0;
}

void nsdae_event_phase_layout(nsdae_event_phase *p, nsdae_arena *arena)
{
  const nsdae_dims *d = &p->setting->system->dims;
  /* The forces in turn: k normal, k nt tangential, f of frictional joints. */
  long forces = d->k * (1 + d->nt) + d->f, most;
  nsdae_event_crossing_layout(&p->crossing, p->setting, arena);
  most = forces + nsdae_crossing_most(d->m);
  p->x = NSDAE_ARENA_DOUBLES(arena, d->nv);
  p->l = NSDAE_ARENA_DOUBLES(arena, d->m);
  p->circle = NSDAE_ARENA_DOUBLES(arena, d->f);
  p->rows.row = nsdae_arena_take(arena, most, sizeof *p->rows.row);
  p->rows.place = NSDAE_ARENA_INTS(arena, forces);
  p->rows.f = NSDAE_ARENA_DOUBLES(arena, most);
  p->modes.direction = NSDAE_ARENA_DOUBLES(arena, (long)d->k * d->nt);
  p->modes.blur = NSDAE_ARENA_DOUBLES(arena, d->k);
  p->moved = NSDAE_ARENA_DOUBLES(arena, p->setting->at.lambda);
  p->border.kkt = p->setting->kkt;
  nsdae_border_layout(&p->border, p->setting->system, (int)most, arena);
  nsdae_newton_kkt_layout(&p->newton, p->setting->system, (int)forces,
                          p->setting->options->rank_tol, arena);
}

static nsdae_event_row_kind kind_of(const nsdae_event_phase *p, int force)
{
  const nsdae_dims *d = &p->setting->system->dims;
  const nsdae_event_modes *m = &p->modes;
  int i = force < d->k ? force : (force - d->k) / (d->nt > 0 ? d->nt : 1);
  int j = force - d->k * (1 + d->nt);
  if (j >= 0 && m->frictional_joint[j] == NSDAE_MODE_OPEN) return NSDAE_ROW_NONE;
  if (j >= 0)
    return m->frictional_joint[j] == NSDAE_MODE_STICK && m->slide_row[j] ? NSDAE_ROW_CLOSED
                                                                         : NSDAE_ROW_SLIDE_RUBS;
  if (m->contact[i] == NSDAE_MODE_OPEN) return NSDAE_ROW_NONE;
  if (force < d->k || m->contact[i] == NSDAE_MODE_STICK)
    return nsdae_event_is_related(p, force) ? NSDAE_ROW_RELATED : NSDAE_ROW_CLOSED;
  return p->setting->system->contact[i].mu > 0 ? NSDAE_ROW_RUBS : NSDAE_ROW_NONE;
}

/* The n-th row of those of kind l: contacts by their numbers. */
static int row_in_order(const nsdae_system *s, int l, int n)
{
  int nt = s->dims.nt;
  if (l == 2) return n;
  return l == 0 ? nsdae_system_contact(s, n) : nsdae_system_contact(s, n / nt) * nt + n % nt;
}

/* The number of a direction that is held, which is no force of y: behind those that are. */
static int first_held(const nsdae_event_phase *p)
{
  const nsdae_dims *d = &p->setting->system->dims;
  return d->k * (1 + d->nt) + d->f;
}

/* Normal, tangential, of frictional joints, and of directions that are held. */
static void list_rows(nsdae_event_phase *p)
{
  const nsdae_terms *T = p->setting->here;
  nsdae_event_rows *b = &p->rows;
  const nsdae_event_row of[] = {
      {.rows = &T->by.normal, .w = T->w_N, .omega = T->omega.N, .gap = T->gap},
      {.rows = &T->by.tangent, .w = T->w_T, .omega = T->omega.T},
      {.rows = &T->by.frictional_joint,
       .w = T->frictional_joint.w,
       .omega = T->frictional_joint.omega}};
  b->count = 0;
  for (int l = 0, first = 0; l < 3; first += of[l++].rows->count)
    for (int n = 0; n < of[l].rows->count; n++) {
      int i = row_in_order(T->system, l, n), force = first + i;
      nsdae_event_row *row = &b->row[b->count];
      nsdae_event_row_kind kind = kind_of(p, force);
      b->place[force] = kind == NSDAE_ROW_NONE ? -1 : b->count++;
      if (kind == NSDAE_ROW_NONE) continue;
      *row = of[l];
      row->kind = kind, row->force = force, row->index = i;
    }
  for (int j = 0; j < p->crossing.count; j++)
    b->row[b->count++] = (nsdae_event_row){
        .kind = NSDAE_ROW_HELD, .rows = &p->crossing.rows, .force = first_held(p) + j, .index = j};
}

void nsdae_event_begin_phase(nsdae_event_phase *p)
{
  const nsdae_system *s = p->setting->system;
  unsigned terms = NSDAE_TERM_MASS | NSDAE_TERM_FORCE | NSDAE_TERM_PHI | NSDAE_TERM_JACOBIAN |
                   NSDAE_TERM_PHI_T | NSDAE_TERM_OMEGA;
  for (int i = 0; i < s->dims.k; i++) {
    if (p->modes.contact[i] == NSDAE_MODE_OPEN) continue;
    terms |= NSDAE_TERM_GAP | NSDAE_TERM_NORMAL | NSDAE_TERM_BIAS | NSDAE_TERM_ACCELERATION;
    if (s->contact[i].mu > 0) terms |= NSDAE_TERM_TANGENT;
  }
  for (int j = 0; j < s->dims.f; j++) {
    if (p->modes.frictional_joint[j] != NSDAE_MODE_OPEN)
      terms |= NSDAE_TERM_SLIDE | NSDAE_TERM_BOUND;
    if (p->modes.frictional_joint[j] == NSDAE_MODE_STICK) terms |= NSDAE_TERM_ACCELERATION;
  }
  p->terms = terms;
  list_rows(p);
}

double nsdae_event_stick_margin(const nsdae_event_phase *p, const double *y, int i)
{
  const nsdae_event_places *at = &p->setting->at;
  int nt = p->setting->system->dims.nt;
  return p->setting->system->contact[i].mu * y[at->normal + i] -
         nsdae_norm(nt, y + at->tangential + i * nt);
}

int nsdae_event_hardly_slides(const nsdae_event_phase *p, int i)
{
  const nsdae_terms *T = p->setting->here;
  return nsdae_terms_slip(T, i, T->v) <= 10 * nsdae_event_velocity_size(p->setting);
}

/* d [nt] of contact i that slides. */
static void sliding_direction(const nsdae_event_phase *p, int i, double *d)
{
  const nsdae_terms *T = p->setting->here;
  int nt = T->system->dims.nt;
  const double *last = p->modes.direction + i * nt;
  double v_t[2];
  for (int l = 0; l < nt; l++) d[l] = last[l];
  if (nt < 2 || (last[0] == 0 && last[1] == 0)) return;
  for (int l = 0; l < 2; l++) v_t[l] = nsdae_terms_tangent_rate(T, 2 * i + l, T->v);
  slip_direction_ahead(last, p->modes.slow, v_t, d);
}

/* Of frictional joint j that slides: -F_S / lambda without b; F_S without lambda. */
static double joint_friction(const nsdae_event_phase *p, int j)
{
  return p->setting->system->frictional_joint[j].mu * p->modes.normal_sense[j] *
         p->modes.slide_part[j];
}

static double dry_friction(const nsdae_event_phase *p, int j)
{
  return -(p->setting->here->frictional_joint.bound[j] + p->circle[j]) * p->modes.slide_part[j];
}

/* ---- the border */

/* At the point in work. W^T v' of what is closed, by Baumgarte's stabilisation: W^T (v' + 2 alpha
 * v)
 * + omega + 2 alpha w + beta^2 g = 0. */
static double wanted(const nsdae_event_phase *p, const nsdae_event_row *r)
{
  const nsdae_terms *T = p->setting->here;
  const nsdae_sim_options *o = p->setting->options;
  double rate = nsdae_terms_rate(T, r->rows, r->w, r->index, T->v);
  return -r->omega[r->index] - 2 * o->baumgarte_alpha * rate -
         o->baumgarte_beta * o->baumgarte_beta * (r->gap ? r->gap[r->index] : 0);
}

/* The row of friction of a contact that slides. Of Newton's method also with the derivative of the
 * direction by v_T. */
static void add_sliding(const nsdae_event_phase *p, nsdae_border *b, int a, const double *y,
                        double cj)
{
  const nsdae_terms *T = p->setting->here;
  int nt = T->system->dims.nt, j = p->rows.row[a].index, i = j / nt;
  const double *last = p->modes.direction + i * nt;
  double mu = T->system->contact[i].mu, d[2], v_t[2], turn[2];
  sliding_direction(p, i, d);
  *nsdae_border_entry(b, a, p->rows.place[i]) = mu * d[j % nt];
  if (!y || nt < 2 || (last[0] == 0 && last[1] == 0)) return;
  for (int l = 0; l < nt; l++) v_t[l] = nsdae_terms_tangent_rate(T, 2 * i + l, T->v);
  for (int l = 0; l < nt; l++) {
    slip_direction_slope(last, p->modes.slow, v_t, l, turn);
    nsdae_border_depend(b, a, &T->by.tangent, i * nt + l,
                        mu * y[p->setting->at.normal + i] / cj * turn[j % nt]);
  }
}

static void add_row(const nsdae_event_phase *p, nsdae_border *b, const nsdae_event_row *row,
                    const double *y, double cj)
{
  const nsdae_system *s = p->setting->system;
  int all = s->dims.k * (1 + s->dims.nt), a = (int)(row - p->rows.row);
  if (row->kind == NSDAE_ROW_CLOSED || row->kind == NSDAE_ROW_HELD) {
    nsdae_border_depend(b, a, row->rows, row->index, 1);
    return;
  }
  *nsdae_border_entry(b, a, a) = 1;
  for (int c = 0; c < p->rows.count && row->kind == NSDAE_ROW_RELATED; c++)
    if (p->rows.row[c].force < all)
      *nsdae_border_entry(b, a, c) -= nsdae_event_relation(p, row->force, p->rows.row[c].force);
  if (row->kind == NSDAE_ROW_RUBS) add_sliding(p, b, a, y, cj);
  if (row->kind != NSDAE_ROW_SLIDE_RUBS || s->frictional_joint[row->index].mu == 0) return;
  b->row[a].multiplier = s->frictional_joint[row->index].constraint;
  b->row[a].h = joint_friction(p, row->index);
}

/* The border of the rows at the point in work; with y not NULL that of Newton's method at y, see
 * newton.c. NSDAE_E_CONVERGENCE: it is singular. */
static int factor_border(const nsdae_event_phase *p, nsdae_border *b, const double *y, double cj)
{
  b->count = 0;
  for (int a = 0; a < p->rows.count; a++)
    nsdae_border_add(b, p->rows.row[a].rows, p->rows.row[a].index);
  for (int a = 0; a < p->rows.count; a++) add_row(p, b, &p->rows.row[a], y, cj);
  return nsdae_border_factor(b, p->setting->here);
}

/* x, l, f := v', lambda, F of the equations (6) and the rows, with the friction circles as they
 * are. */
static int solve_factored(nsdae_event_phase *p)
{
  const nsdae_terms *T = p->setting->here;
  const nsdae_sim_options *o = p->setting->options;
  double alpha2 = 2 * o->baumgarte_alpha, beta2 = o->baumgarte_beta * o->baumgarte_beta;
  memcpy(p->x, T->F, (size_t)T->system->dims.nv * sizeof *p->x);
  for (int i = 0; i < T->system->dims.m; i++)
    p->l[i] = -T->constraint.omega[i] - alpha2 * nsdae_terms_constraint_rate(T, i, T->v) -
              beta2 * T->constraint.phi[i];
  for (int a = 0; a < p->rows.count; a++) {
    const nsdae_event_row *row = &p->rows.row[a];
    p->rows.f[a] = row->kind == NSDAE_ROW_CLOSED ? wanted(p, row)
                   : row->kind == NSDAE_ROW_HELD ? nsdae_event_held(&p->crossing, row->index, T->t)
                   : row->kind == NSDAE_ROW_SLIDE_RUBS ? dry_friction(p, row->index)
                                                       : 0;
  }
  return nsdae_border_solve(&p->border, T, p->x, p->l, p->rows.f);
}

/* The same with the friction circles of l. Redundant constraints in the combinations of the phase's
 * start. */
static int solve(nsdae_event_phase *p)
{
  const nsdae_terms *T = p->setting->here;
  int m = T->system->dims.m, held = p->crossing.count;
  int redundant = held ? p->crossing.redundant : *p->modes.redundant;
  const double *basis = held ? p->crossing.basis : p->modes.basis;
  int status = nsdae_kkt_factor_coupled(p->setting->kkt, T->M, NULL, &T->by.jacobian,
                                        redundant ? basis : NULL, m - redundant);
  if (m > 0) p->crossing.least = fmin(p->crossing.least, status < 0 ? 0 : p->setting->kkt->kept);
  if (status == NSDAE_OK) status = factor_border(p, &p->border, NULL, INFINITY);
  if (status < 0) return status;
  nsdae_circles circles = nsdae_circles_begin(T, NULL, NULL, NSDAE_CIRCLE_PART,
                                              nsdae_largest(T->system->dims.nv, T->F), p->circle);
  do status = solve_factored(p);
  while (nsdae_circles_again(&circles, p->l, &status));
  return status;
}

/* The terms of the modes at the point in work, with the rows of every closed contact that a list
 * has there. */
static int need(const nsdae_event_phase *p)
{
  nsdae_terms *T = p->setting->here;
  int unlisted = 0, status = nsdae_terms_need(T, p->terms);
  for (int i = 0; T->system->tracked && i < T->system->dims.k && status == NSDAE_OK; i++)
    unlisted |= p->modes.contact[i] != NSDAE_MODE_OPEN && !(T->gap[i] < NSDAE_FAR);
  if (!unlisted) return status;
  status = nsdae_tracking_widen(p->setting->tracking, T, p->setting->options->dt);
  return status < 0 ? status : nsdae_terms_need(T, p->terms);
}

int nsdae_event_forces(nsdae_event_phase *p, double t, double *y)
{
  nsdae_terms *T = p->setting->here;
  const nsdae_event_places *at = &p->setting->at;
  memset(y + at->lambda, 0, (size_t)(at->n - at->lambda) * sizeof *y);
  nsdae_event_move(p->setting, t, y);
  int status = need(p);
  if (status < 0) return status;
  status = solve(p);
  if (status < 0 && status != NSDAE_E_CONVERGENCE)
    return nsdae_terms_unsolved(T, p->setting->kkt, status);
  if (status < 0) return status;
  memcpy(y + at->lambda, p->l, (size_t)T->system->dims.m * sizeof *y);
  for (int a = 0; a < p->rows.count - p->crossing.count; a++)
    y[at->normal + p->rows.row[a].force] = p->rows.f[a];
  return NSDAE_OK;
}

double nsdae_event_yield(const nsdae_event_phase *p, int i)
{
  const nsdae_border *b = &p->border;
  double *f = p->rows.f;
  memset(f, 0, (size_t)b->count * sizeof *f);
  f[p->rows.place[i]] = 1;
  nsdae_la_lu_solve(b->count, b->B, b->most, b->pivot, f);
  return 1 / f[p->rows.place[i]];
}

double nsdae_event_force_that_gives(const nsdae_event_phase *p, int force, double a)
{
  const nsdae_system *s = p->setting->system;
  int place = p->rows.place[force];
  if (place < 0) return 0;
  const nsdae_event_row *r = &p->rows.row[place];
  const double *x = nsdae_border_response(&p->border, place);
  double G = nsdae_rows_dot(&s->blocks, r->rows, r->index, x);
  return G > 0 ? a / G : 0;
}

/* The equations of a phase for IDA (newton_kkt.h), with the rows of phase.h for the forces:
 *
 *   closed:   r_p = W_p^T v' + omega_p + 2 alpha v_p + beta^2 g
 *   sliding:  r_p = F_p + mu F_N d,  or F_p + (b + mu |lambda|) s
 *   related:  r_p = F_p - sum_l r_l F_l
 *
 * Newton's method, with phi = dF / cj and c = cj + 2 alpha + beta^2 / cj:
 *
 *   closed:   W_p^T dv = r_p / c
 *   sliding:  phi_p + mu d phi_N + mu F_N / cj d'(v_T) W_T^T dv = r_p / cj,
 *             d' = (1 - d d^T) / |v_T| */

/* ---- the residual */

/* mu |lambda| s of frictional joint j. */
static double load_friction(const nsdae_event_phase *p, int j, const double *y)
{
  const nsdae_frictional_joint *joint = &p->setting->system->frictional_joint[j];
  if (joint->mu == 0) return 0;
  return joint_friction(p, j) * y[p->setting->at.lambda + joint->constraint];
}

/* r of a force that follows from others. */
static double following(const nsdae_event_phase *p, const nsdae_event_row *row, const double *y)
{
  const nsdae_system *s = p->setting->system;
  const double *force = y + p->setting->at.normal;
  int k = s->dims.k, nt = s->dims.nt, all = k * (1 + nt), i = row->force;
  double r = force[i], d[2];
  for (int a = 0; row->kind == NSDAE_ROW_RELATED && a < p->rows.count; a++)
    if (p->rows.row[a].force < all)
      r -= nsdae_event_relation(p, i, p->rows.row[a].force) * force[p->rows.row[a].force];
  if (row->kind == NSDAE_ROW_RELATED) return r;
  if (row->kind == NSDAE_ROW_SLIDE_RUBS)
    return r - dry_friction(p, i - all) + load_friction(p, i - all, y);
  sliding_direction(p, (i - k) / nt, d);
  return r + s->contact[(i - k) / nt].mu * d[(i - k) % nt] * force[(i - k) / nt];
}

int nsdae_event_residual(double t, const double *y, const double *ydot, double cj, double *r,
                         nsdae_event_phase *p)
{
  const nsdae_event_places *at = &p->setting->at;
  const nsdae_event_rows *b = &p->rows;
  const nsdae_terms *T = p->setting->here;
  const nsdae_system *s = T->system;
  const nsdae_sim_options *o = p->setting->options;
  int status = nsdae_newton_kkt_move(p->setting->here, t, y, ydot, cj, p->moved, r);
  nsdae_event_move(p->setting, t, p->moved);
  if (status == NSDAE_OK) status = need(p);
  if (status < 0) return nsdae_progress_code(status, p->setting->error);
  nsdae_newton_kkt_residual(T, o->baumgarte_alpha, o->baumgarte_beta, y, ydot, r);
  memcpy(r + at->normal, y + at->normal, (size_t)(at->n - at->normal) * sizeof *r);
  for (int j = 0; j < s->dims.f; j++) p->circle[j] = nsdae_terms_circle(s, j, y + at->lambda);
  for (int a = 0; a < b->count; a++) {
    const nsdae_event_row *row = &b->row[a];
    nsdae_rows_add(&s->blocks, row->rows, row->index, -y[at->normal + row->force], r + at->v);
    r[at->normal + row->force] =
        row->kind == NSDAE_ROW_CLOSED
            ? nsdae_rows_dot(&s->blocks, row->rows, row->index, ydot + at->v) - wanted(p, row)
            : following(p, row, y);
  }
  return 0;
}

/* ---- Newton's matrix */

int nsdae_event_newton_setup(double t, const double *y, const double *ydot, double cj,
                             nsdae_event_phase *p)
{
  nsdae_event_setting *s = p->setting;
  int redundant = *p->modes.redundant;
  (void)ydot;
  nsdae_event_move(s, t, y);
  int status = need(p);
  if (status == NSDAE_OK)
    status = nsdae_newton_kkt_factor(&p->newton, s->here, cj, redundant ? p->modes.basis : NULL,
                                     s->system->dims.m - redundant);
  if (status == NSDAE_OK) status = factor_border(p, &p->newton.border, y, cj);
  return nsdae_progress_code(status, s->error);
}

int nsdae_event_newton_solve(double cj, double *r, double *x, nsdae_event_phase *p)
{
  const nsdae_event_setting *s = p->setting;
  const nsdae_event_places *at = &s->at;
  const nsdae_event_rows *b = &p->rows;
  const nsdae_sim_options *o = s->options;
  double alpha = o->baumgarte_alpha, beta = o->baumgarte_beta;
  for (int a = 0; a < b->count; a++) {
    const nsdae_event_row *row = &b->row[a];
    double c =
        row->kind == NSDAE_ROW_CLOSED ? cj + 2 * alpha + (row->gap ? beta * beta / cj : 0) : cj;
    b->f[a] = r[at->normal + row->force] / c;
  }
  memcpy(x + at->normal, r + at->normal, (size_t)(at->n - at->normal) * sizeof *x);
  int status = nsdae_newton_kkt_solve(&p->newton, s->here, cj, alpha, beta, r, x, b->f);
  for (int a = 0; a < b->count; a++) x[at->normal + b->row[a].force] = cj * b->f[a];
  return nsdae_progress_code(status, s->error);
}
