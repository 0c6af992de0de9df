#include "phase.h"

#include <math.h>
#include <string.h>

#include "dense.h"
#include "direction.h"

#define AT(A, n, i, j) (A)[(size_t)(j) * (size_t)(n) + (size_t)(i)]

/* The forces in turn: k normal, k nt tangential, f of frictional joints. */
static int forces_of(const nsdae_dims *d)
{
  return d->k * (1 + d->nt) + d->f;
}

void nsdae_event_phase_layout(nsdae_event_phase *p, nsdae_arena *arena)
{
  const nsdae_dims *d = &p->setting->system->dims;
  long forces = forces_of(d);
  p->x = NSDAE_ARENA_DOUBLES(arena, (1 + forces) * d->nv);
  p->l = NSDAE_ARENA_DOUBLES(arena, (1 + forces) * d->m);
  p->border.row = nsdae_arena_take(arena, forces, sizeof *p->border.row);
  p->border.place = NSDAE_ARENA_INTS(arena, forces);
  p->border.A = NSDAE_ARENA_DOUBLES(arena, forces * forces);
  p->border.pivot = NSDAE_ARENA_INTS(arena, forces);
  p->border.f = NSDAE_ARENA_DOUBLES(arena, forces);
  p->modes.direction = NSDAE_ARENA_DOUBLES(arena, (long)d->k * d->nt);
  p->modes.blur = NSDAE_ARENA_DOUBLES(arena, d->k);
  p->moved = NSDAE_ARENA_DOUBLES(arena, p->setting->at.lambda);
  nsdae_bordered_layout(&p->newton, p->setting->system, (int)forces, p->setting->options->rank_tol,
                        arena);
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
    return m->related[force] ? NSDAE_ROW_RELATED : NSDAE_ROW_CLOSED;
  return p->setting->system->contact[i].mu > 0 ? NSDAE_ROW_RUBS : NSDAE_ROW_NONE;
}

/* Normal, tangential and of frictional joints. */
static void list_rows(nsdae_event_phase *p)
{
  const nsdae_terms *T = p->setting->here;
  nsdae_event_border *b = &p->border;
  const nsdae_event_row of[] = {
      {.rows = &T->by.normal, .w = T->w_N, .omega = T->omega.N, .gap = T->gap},
      {.rows = &T->by.tangent, .w = T->w_T, .omega = T->omega.T},
      {.rows = &T->by.frictional_joint,
       .w = T->frictional_joint.w,
       .omega = T->frictional_joint.omega}};
  b->count = 0;
  for (int l = 0, force = 0; l < 3; l++)
    for (int i = 0; i < of[l].rows->count; i++, force++) {
      nsdae_event_row *row = &b->row[b->count];
      nsdae_event_row_kind kind = kind_of(p, force);
      b->place[force] = kind == NSDAE_ROW_NONE ? -1 : b->count++;
      if (kind == NSDAE_ROW_NONE) continue;
      *row = of[l];
      row->kind = kind, row->force = force, row->index = i;
    }
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
    if (p->modes.frictional_joint[j] != NSDAE_MODE_OPEN) terms |= NSDAE_TERM_SLIDE;
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

void nsdae_event_sliding_direction(const nsdae_event_phase *p, int i, double *d)
{
  const nsdae_terms *T = p->setting->here;
  int nt = T->system->dims.nt;
  const double *last = p->modes.direction + i * nt;
  double v_t[2];
  for (int l = 0; l < nt; l++) d[l] = last[l];
  if (nt < 2 || (last[0] == 0 && last[1] == 0)) return;
  for (int l = 0; l < 2; l++) v_t[l] = nsdae_terms_tangent_rate(T, 2 * i + l, T->v);
  nsdae_direction_ahead(last, p->modes.slow, v_t, d);
}

void nsdae_event_direction_slope(const nsdae_event_phase *p, int i, int l, double *slope)
{
  const nsdae_terms *T = p->setting->here;
  const double *last = p->modes.direction + 2 * i;
  double v_t[2];
  slope[0] = slope[1] = 0;
  if (last[0] == 0 && last[1] == 0) return;
  for (int j = 0; j < 2; j++) v_t[j] = nsdae_terms_tangent_rate(T, 2 * i + j, T->v);
  nsdae_direction_slope(last, p->modes.slow, v_t, l, slope);
}

double nsdae_event_joint_friction(const nsdae_event_phase *p, int j)
{
  return p->setting->system->frictional_joint[j].mu * p->modes.normal_sense[j] *
         p->modes.slide_part[j];
}

/* x, l := K^-1 [F; c] with c from (6), and behind them K^-1 [w; 0] of every row. Of redundant
 * constraints in the combinations of the phase's start. */
static int solve(nsdae_event_phase *p)
{
  const nsdae_terms *T = p->setting->here;
  const nsdae_event_border *b = &p->border;
  const nsdae_sim_options *o = p->setting->options;
  double alpha2 = 2 * o->baumgarte_alpha, beta2 = o->baumgarte_beta * o->baumgarte_beta;
  int n = T->system->dims.nv, m = T->system->dims.m, redundant = *p->modes.redundant;
  int status = nsdae_kkt_factor_in(p->setting->kkt, T->M, &T->by.jacobian,
                                   redundant ? p->modes.basis : NULL, m - redundant);
  if (status < 0) return status;
  memcpy(p->x, T->F, (size_t)n * sizeof *p->x);
  for (int i = 0; i < m; i++)
    p->l[i] = -T->constraint.omega[i] - alpha2 * nsdae_terms_constraint_rate(T, i, T->v) -
              beta2 * T->constraint.phi[i];
  for (int a = 1; a <= b->count; a++) {
    double *x = p->x + (size_t)a * (size_t)n;
    memset(x, 0, (size_t)n * sizeof *x);
    memset(p->l + a * m, 0, (size_t)m * sizeof *p->l);
    nsdae_rows_add(&T->system->blocks, b->row[a - 1].rows, b->row[a - 1].index, 1, x);
  }
  return nsdae_kkt_solve(p->setting->kkt, 1 + b->count, p->x, n, p->l, m);
}

/* ---- the border */

double nsdae_event_wanted(const nsdae_event_phase *p, const nsdae_event_row *r)
{
  const nsdae_terms *T = p->setting->here;
  const nsdae_sim_options *o = p->setting->options;
  double rate = nsdae_terms_rate(T, r->rows, r->w, r->index, T->v);
  return -r->omega[r->index] - 2 * o->baumgarte_alpha * rate -
         o->baumgarte_beta * o->baumgarte_beta * (r->gap ? r->gap[r->index] : 0);
}

static void closed_row(nsdae_event_phase *p, int a)
{
  const nsdae_event_border *b = &p->border;
  const nsdae_event_row *r = &b->row[a];
  const nsdae_system *s = p->setting->system;
  size_t n = (size_t)s->dims.nv;
  b->f[a] = nsdae_event_wanted(p, r) - nsdae_rows_dot(&s->blocks, r->rows, r->index, p->x);
  for (int c = 0; c < b->count; c++)
    AT(b->A, b->count, a, c) =
        nsdae_rows_dot(&s->blocks, r->rows, r->index, p->x + (size_t)(c + 1) * n);
}

/* A force that follows from others, as relation or friction. */
static void following_row(nsdae_event_phase *p, int a)
{
  const nsdae_event_border *b = &p->border;
  const nsdae_system *s = p->setting->system;
  nsdae_event_row_kind kind = b->row[a].kind;
  int k = s->dims.k, nt = s->dims.nt, all = k * (1 + nt), force = b->row[a].force;
  double d[2];
  b->f[a] = 0;
  for (int c = 0; c < b->count; c++) {
    double part = kind == NSDAE_ROW_RELATED && b->row[c].force < all
                      ? AT(p->modes.relation, all, b->row[c].force, force)
                      : 0;
    AT(b->A, b->count, a, c) = (a == c) - part;
  }
  if (kind == NSDAE_ROW_RUBS) {
    int i = (force - k) / nt;
    nsdae_event_sliding_direction(p, i, d);
    AT(b->A, b->count, a, b->place[i]) = s->contact[i].mu * d[(force - k) % nt];
  }
  if (kind != NSDAE_ROW_SLIDE_RUBS) return;
  int j = force - all;
  const double *lambda = p->l + s->frictional_joint[j].constraint;
  double factor = nsdae_event_joint_friction(p, j);
  b->f[a] = -factor * *lambda;
  for (int c = 0; c < b->count; c++) AT(b->A, b->count, a, c) += factor * *(lambda += s->dims.m);
}

/* f := the forces; x, l := v', lambda with them. */
static int solve_border(nsdae_event_phase *p)
{
  const nsdae_event_border *b = &p->border;
  int n = p->setting->system->dims.nv, m = p->setting->system->dims.m;
  for (int a = 0; a < b->count; a++)
    b->row[a].kind == NSDAE_ROW_CLOSED ? closed_row(p, a) : following_row(p, a);
  if (nsdae_la_lu(b->count, b->A, b->count, b->pivot) != 0) return NSDAE_E_CONVERGENCE;
  nsdae_la_lu_solve(b->count, b->A, b->count, b->pivot, b->f);
  nsdae_add_product(n, b->count, p->x + n, b->f, p->x);
  nsdae_add_product(m, b->count, p->l + m, b->f, p->l);
  return NSDAE_OK;
}

int nsdae_event_forces(nsdae_event_phase *p, double t, double *y)
{
  nsdae_terms *T = p->setting->here;
  const nsdae_event_places *at = &p->setting->at;
  const nsdae_event_border *b = &p->border;
  memset(y + at->lambda, 0, (size_t)(at->n - at->lambda) * sizeof *y);
  nsdae_event_move(p->setting, t, y);
  int status = nsdae_terms_need(T, p->terms);
  if (status < 0) return status;
  status = solve(p);
  if (status < 0 && status != NSDAE_E_CONVERGENCE)
    return nsdae_terms_unsolved(T, p->setting->kkt, status);
  if (status == NSDAE_OK && b->count > 0) status = solve_border(p);
  if (status < 0) return status;
  memcpy(y + at->lambda, p->l, (size_t)T->system->dims.m * sizeof *y);
  for (int a = 0; a < b->count; a++) y[at->normal + b->row[a].force] = b->f[a];
  return NSDAE_OK;
}

double nsdae_event_yield(const nsdae_event_phase *p, int i)
{
  const nsdae_event_border *b = &p->border;
  memset(b->f, 0, (size_t)b->count * sizeof *b->f);
  b->f[b->place[i]] = 1;
  nsdae_la_lu_solve(b->count, b->A, b->count, b->pivot, b->f);
  return 1 / b->f[b->place[i]];
}
