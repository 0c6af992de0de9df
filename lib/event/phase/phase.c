#include "phase.h"

#include <math.h>
#include <string.h>

#include "direction.h"

#define AT(A, n, i, j) (A)[(size_t)(j) * (size_t)(n) + (size_t)(i)]

/* The row of a force. */
typedef enum row_kind {
  ROW_NONE,      /* F = 0 */
  ROW_CLOSED,    /* what it holds has no acceleration */
  ROW_RELATED,   /* others hold it: F = sum r_l F_l */
  ROW_RUBS,      /* F_T = -mu F_N d */
  ROW_SLIDE_RUBS /* F_S = -mu |lambda| s */
} row_kind;

/* W, w, omega of a force, and the gap that it closes. */
typedef struct column {
  const double *W;
  double w, omega, gap;
} column;

/* The forces in turn: k normal, k nt tangential, f of frictional joints. */
static int forces_of(const nsdae_dims *d)
{
  return d->k * (1 + d->nt) + d->f;
}

void nsdae_event_phase_layout(nsdae_event_phase *p, nsdae_arena *arena)
{
  const nsdae_dims *d = &p->setting->system->dims;
  long n = (long)d->nv + d->m + forces_of(d);
  p->x = NSDAE_ARENA_DOUBLES(arena, n);
  p->unit = NSDAE_ARENA_DOUBLES(arena, n);
  p->place = NSDAE_ARENA_INTS(arena, forces_of(d));
  p->rates = NSDAE_ARENA_DOUBLES(arena, d->m);
  p->modes.direction = NSDAE_ARENA_DOUBLES(arena, (long)d->k * d->nt);
  p->modes.blur = NSDAE_ARENA_DOUBLES(arena, d->k);
  p->slip = NSDAE_ARENA_DOUBLES(arena, (long)d->k * d->nt);
  p->K.most = (int)n;
  nsdae_lu_layout(&p->K, arena);
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
  nsdae_lu_forget(&p->K);
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

static void sliding_direction(const nsdae_event_phase *p, const nsdae_terms *T, int i, double *d)
{
  int nt = T->system->dims.nt;
  const double *last = p->modes.direction + i * nt;
  double v_t[2];
  for (int l = 0; l < nt; l++) d[l] = last[l];
  if (nt < 2 || (last[0] == 0 && last[1] == 0)) return;
  for (int l = 0; l < 2; l++) v_t[l] = nsdae_terms_tangent_rate(T, 2 * i + l, T->v);
  nsdae_direction_ahead(last, p->modes.slow, v_t, p->linear ? p->slip + 2 * i : NULL, d);
}

static row_kind kind_of(const nsdae_event_phase *p, int force)
{
  const nsdae_system *s = p->setting->system;
  const nsdae_dims *d = &s->dims;
  int frictional_joint = force - d->k * (1 + d->nt);
  if (frictional_joint >= 0)
    return p->modes.frictional_joint[frictional_joint] == NSDAE_MODE_STICK &&
                   p->modes.slide_row[frictional_joint]
               ? ROW_CLOSED
           : p->modes.frictional_joint[frictional_joint] != NSDAE_MODE_OPEN ? ROW_SLIDE_RUBS
                                                                            : ROW_NONE;
  int i = force < d->k ? force : (force - d->k) / d->nt, mode = p->modes.contact[i];
  if (mode == NSDAE_MODE_OPEN) return ROW_NONE;
  if (force < d->k || mode == NSDAE_MODE_STICK)
    return p->modes.related[force] ? ROW_RELATED : ROW_CLOSED;
  return s->contact[i].mu > 0 ? ROW_RUBS : ROW_NONE;
}

static column column_of(const nsdae_terms *T, int force)
{
  const nsdae_dims *d = &T->system->dims;
  size_t n = (size_t)d->nv, j;
  if (force < d->k) {
    j = (size_t)force;
    return (column){T->by.normal.value + j * n, T->w_N[j], T->omega.N[j], T->gap[j]};
  }
  j = (size_t)(force - d->k);
  if (force < d->k * (1 + d->nt))
    return (column){T->by.tangent.value + j * n, T->w_T[j], T->omega.T[j], 0};
  j = (size_t)(force - d->k * (1 + d->nt));
  return (column){T->by.frictional_joint.value + j * n, T->frictional_joint.w[j],
                  T->frictional_joint.omega[j], 0};
}

/* Entry of K: rows and columns are nv accelerations, m multipliers, then the forces by place. */
static double *entry(const nsdae_event_phase *p, int row, int col)
{
  return p->K.A + (size_t)col * (size_t)p->K.n + (size_t)row;
}

/* The unknowns; what is zero anyway is none. */
static void place_forces(nsdae_event_phase *p)
{
  const nsdae_dims *d = &p->setting->system->dims;
  p->K.n = d->nv + d->m;
  for (int force = 0; force < forces_of(d); force++)
    p->place[force] = kind_of(p, force) == ROW_NONE ? -1 : p->K.n++;
  if (p->K.n == d->nv) return; /* M and F fill them */
  memset(p->K.A, 0, (size_t)p->K.n * (size_t)p->K.n * sizeof *p->K.A);
  memset(p->x, 0, (size_t)p->K.n * sizeof *p->x);
}

/* M v' + Phi_q^T lambda = F, and the rows (6). */
static void inertia_rows(nsdae_event_phase *p, const nsdae_terms *T)
{
  const nsdae_dims *d = &T->system->dims;
  const nsdae_sim_options *o = p->setting->options;
  double alpha2 = 2 * o->baumgarte_alpha, beta2 = o->baumgarte_beta * o->baumgarte_beta;
  int n = d->nv, m = d->m;
  for (int j = 0; j < n; j++) {
    double *to = entry(p, 0, j);
    p->x[j] = T->F[j];
    for (int i = 0; i < n; i++) to[i] = AT(T->M, n, i, j);
    for (int i = 0; i < m; i++)
      *entry(p, j, n + i) = *entry(p, n + i, j) = AT(T->by.jacobian.value, m, i, j);
  }
  for (int i = 0; i < m; i++)
    p->x[n + i] = -T->constraint.omega[i] - alpha2 * nsdae_terms_constraint_rate(T, i, T->v) -
                  beta2 * T->constraint.phi[i];
}

/* Of redundant constraints: Z Z^T of the rows, and (1 - Z Z^T) lambda. */
static void combine_rows(nsdae_event_phase *p, const nsdae_terms *T)
{
  int n = T->system->dims.nv, m = T->system->dims.m;
  const double *B = p->modes.range;
  memcpy(p->rates, p->x + n, (size_t)m * sizeof *p->rates);
  memset(p->x + n, 0, (size_t)m * sizeof *p->rates);
  nsdae_add_product(m, m, B, p->rates, p->x + n);
  for (int j = 0; j < n; j++) {
    double *combined = entry(p, n, j);
    memset(combined, 0, (size_t)m * sizeof *combined);
    nsdae_add_product(m, m, B, T->by.jacobian.value + (size_t)j * (size_t)m, combined);
  }
  for (int l = 0; l < m; l++)
    for (int i = 0; i < m; i++) *entry(p, n + i, n + l) = (i == l) - AT(B, m, i, l);
}

/* W^T (v' + 2 alpha v) + omega + 2 alpha w + beta^2 g = 0: Baumgarte's stabilisation. */
static void closed_row(nsdae_event_phase *p, const nsdae_terms *T, int force)
{
  int n = T->system->dims.nv, row = p->place[force];
  const nsdae_sim_options *o = p->setting->options;
  column c = column_of(T, force);
  for (int j = 0; j < n; j++) *entry(p, row, j) = c.W[j];
  p->x[row] = -c.omega - 2 * o->baumgarte_alpha * (nsdae_dot(n, c.W, T->v) + c.w) -
              o->baumgarte_beta * o->baumgarte_beta * c.gap;
}

/* A force that follows from others, as relation or friction. */
static void following_row(nsdae_event_phase *p, const nsdae_terms *T, int force, row_kind kind)
{
  const nsdae_system *s = T->system;
  int k = s->dims.k, nt = s->dims.nt, all = k * (1 + nt), row = p->place[force];
  double d[2];
  *entry(p, row, row) = 1;
  for (int l = 0; l < all && kind == ROW_RELATED; l++)
    if (p->place[l] >= 0) *entry(p, row, p->place[l]) -= AT(p->modes.relation, all, l, force);
  if (kind == ROW_RUBS) {
    int i = (force - k) / nt;
    sliding_direction(p, T, i, d);
    *entry(p, row, p->place[i]) = s->contact[i].mu * d[(force - k) % nt];
  }
  if (kind != ROW_SLIDE_RUBS) return;
  int j = force - all, lambda = s->dims.nv + s->frictional_joint[j].constraint;
  *entry(p, row, lambda) =
      s->frictional_joint[j].mu * p->modes.normal_sense[j] * p->modes.slide_part[j];
}

static void force_row(nsdae_event_phase *p, const nsdae_terms *T, int force)
{
  row_kind kind = kind_of(p, force);
  if (kind == ROW_NONE) return;
  column c = column_of(T, force);
  for (int i = 0; i < T->system->dims.nv; i++) *entry(p, i, p->place[force]) = -c.W[i];
  if (kind == ROW_CLOSED)
    closed_row(p, T, force);
  else
    following_row(p, T, force, kind);
}

int nsdae_event_forces(nsdae_event_phase *p, double t, double *y)
{
  nsdae_terms *T = p->setting->here;
  const nsdae_event_places *at = &p->setting->at;
  const nsdae_dims *d = &T->system->dims;
  memset(y + at->lambda, 0, (size_t)(at->n - at->lambda) * sizeof *y);
  nsdae_event_move(p->setting, t, y);
  int status = nsdae_terms_need(T, p->terms);
  if (status < 0) return status;
  place_forces(p);
  inertia_rows(p, T);
  if (*p->modes.redundant) combine_rows(p, T);
  for (int force = 0; force < forces_of(d); force++) force_row(p, T, force);
  if (nsdae_lu_factor(&p->K) != 0) return NSDAE_E_CONVERGENCE;
  nsdae_lu_solve(&p->K, p->x);
  memcpy(y + at->lambda, p->x + d->nv, (size_t)d->m * sizeof *y);
  for (int force = 0; force < forces_of(d); force++)
    if (p->place[force] >= 0) y[at->normal + force] = p->x[p->place[force]];
  return NSDAE_OK;
}

int nsdae_event_linearise(nsdae_event_phase *p, double t, const double *from)
{
  nsdae_terms *T = p->setting->here;
  const nsdae_dims *d = &T->system->dims;
  p->linear = 0;
  if (!from || d->nt < 2 || !(p->terms & NSDAE_TERM_TANGENT)) return NSDAE_OK;
  nsdae_event_move(p->setting, t, from);
  int status = nsdae_terms_need(T, p->terms);
  if (status < 0) return status;
  for (int j = 0; j < d->k * d->nt; j++) p->slip[j] = nsdae_terms_tangent_rate(T, j, T->v);
  p->linear = 1;
  return NSDAE_OK;
}

double nsdae_event_yield(const nsdae_event_phase *p, int i)
{
  int row = p->place[i];
  memset(p->unit, 0, (size_t)p->K.n * sizeof *p->unit);
  p->unit[row] = 1;
  nsdae_lu_solve(&p->K, p->unit);
  return 1 / p->unit[row];
}
