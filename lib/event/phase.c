#include "phase.h"

#include <float.h>
#include <math.h>
#include <string.h>

#include "dense.h"

#define AT(A, n, i, j) (A)[(size_t)(j) * (size_t)(n) + (size_t)(i)]

/* What stands in the row of a force. */
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

void nsdae_event_phase_layout(nsdae_event_phase *p, nsdae_arena *arena)
{
  const nsdae_dims *d = &p->setting->system->dims;
  long n = p->setting->at.n;
  p->other = NSDAE_ARENA_DOUBLES(arena, n);
  p->r = NSDAE_ARENA_DOUBLES(arena, n);
  p->K = NSDAE_ARENA_DOUBLES(arena, n * n);
  p->zero = NSDAE_ARENA_DOUBLES(arena, n);
  p->unit = NSDAE_ARENA_DOUBLES(arena, n);
  p->pivot = NSDAE_ARENA_INTS(arena, n);
  p->unknown = NSDAE_ARENA_INTS(arena, n);
  p->rates = NSDAE_ARENA_DOUBLES(arena, d->m);
  p->slip = NSDAE_ARENA_DOUBLES(arena, (long)d->k * d->nt);
  p->modes.direction = NSDAE_ARENA_DOUBLES(arena, (long)d->k * d->nt);
}

/* Callback's failure as a code of the integrator. */
static int code_of(const nsdae_event_phase *p, int status)
{
  if (status == NSDAE_OK) return 0;
  if (status == NSDAE_E_CALLBACK) return p->setting->error->code < 0 ? -1 : 1;
  return status == NSDAE_E_NONFINITE ? -1 : 1;
}

void nsdae_event_set_terms(nsdae_event_phase *p)
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
    if (p->modes.slide[j] != NSDAE_MODE_OPEN) terms |= NSDAE_TERM_SLIDE;
    if (p->modes.slide[j] == NSDAE_MODE_STICK) terms |= NSDAE_TERM_ACCELERATION;
  }
  p->terms = terms;
}

double nsdae_event_stick_margin(const nsdae_event_phase *p, const double *y, int i)
{
  int nt = p->setting->system->dims.nt;
  const double *F_T = y + p->setting->at.tangential + i * nt;
  double friction = nt == 2 ? hypot(F_T[0], F_T[1]) : fabs(F_T[0]);
  return p->setting->system->contact[i].mu * y[p->setting->at.normal + i] - friction;
}

/* u = v_T, but along the direction e of last at least the size of a velocity: then u / |u| goes
 * smoothly through the stop, where the root function e . v_T ends the phase. */
static double slip_ahead(const nsdae_event_phase *p, int i, const double *v_t, double *u)
{
  const double *last = p->modes.direction + 2 * i;
  double along = last[0] * v_t[0] + last[1] * v_t[1];
  double more = fmax(p->modes.slow - along, 0);
  for (int l = 0; l < 2; l++) u[l] = v_t[l] + more * last[l];
  return more;
}

/* Unit vector of sliding. While the residual is differenced, that with two directions is
 * d + (1 - d d^T) du / |u|: its curvature, over |u|, is no matter for a difference. */
static void sliding_direction(const nsdae_event_phase *p, const nsdae_terms *T, int i, double *d)
{
  int nt = T->system->dims.nt;
  const double *last = p->modes.direction + i * nt, *base = p->slip + i * nt;
  double v_t[2], u[2], du[2];
  for (int l = 0; l < nt; l++) d[l] = last[l];
  if (nt < 2 || (last[0] == 0 && last[1] == 0)) return;
  for (int l = 0; l < 2; l++) v_t[l] = nsdae_terms_rate(T, T->W_T, T->w_T, 2 * i + l, T->v);
  double more = slip_ahead(p, i, p->differencing ? base : v_t, u), size = hypot(u[0], u[1]);
  for (int l = 0; l < 2; l++) d[l] = u[l] / size;
  if (!p->differencing) return;
  for (int l = 0; l < 2; l++) du[l] = v_t[l] - base[l];
  double lost = more > 0 ? last[0] * du[0] + last[1] * du[1] : 0;
  for (int l = 0; l < 2; l++) du[l] -= lost * last[l];
  double along = d[0] * du[0] + d[1] * du[1];
  for (int l = 0; l < 2; l++) du[l] = (du[l] - along * d[l]) / size;
  for (int l = 0; l < 2; l++) d[l] += du[l];
}

/* The forces in turn: k normal, k nt tangential, f of slides. */
static int forces_of(const nsdae_dims *d)
{
  return d->k * (1 + d->nt) + d->f;
}

static row_kind kind_of(const nsdae_event_phase *p, int force)
{
  const nsdae_system *s = p->setting->system;
  const nsdae_dims *d = &s->dims;
  int slide = force - d->k * (1 + d->nt);
  if (slide >= 0)
    return p->modes.slide[slide] == NSDAE_MODE_STICK && p->modes.slide_row[slide] ? ROW_CLOSED
           : p->modes.slide[slide] != NSDAE_MODE_OPEN                             ? ROW_SLIDE_RUBS
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
    return (column){T->W_N + j * n, T->w_N[j], T->omega_N[j], T->gap[j]};
  }
  j = (size_t)(force - d->k);
  if (force < d->k * (1 + d->nt)) return (column){T->W_T + j * n, T->w_T[j], T->omega_T[j], 0};
  j = (size_t)(force - d->k * (1 + d->nt));
  return (column){T->W_S + j * n, T->w_S[j], T->omega_S[j], 0};
}

/* W^T (a + 2 alpha v) + omega + 2 alpha w + beta^2 g: Baumgarte's stabilisation. */
static double closed_row(const nsdae_terms *T, const nsdae_sim_options *o, int force,
                         const double *a)
{
  int n = T->system->dims.nv;
  column c = column_of(T, force);
  return nsdae_dot(n, c.W, a) + c.omega + 2 * o->baumgarte_alpha * (nsdae_dot(n, c.W, T->v) + c.w) +
         o->baumgarte_beta * o->baumgarte_beta * c.gap;
}

static double force_row(const nsdae_event_phase *p, const nsdae_terms *T, const double *y,
                        const double *a, int force, row_kind kind)
{
  const nsdae_system *s = T->system;
  int k = s->dims.k, nt = s->dims.nt, all = k * (1 + nt);
  const double *F = y + p->setting->at.normal;
  double d[2];
  if (kind == ROW_CLOSED) return closed_row(T, p->setting->options, force, a);
  if (kind == ROW_RELATED)
    return F[force] - nsdae_dot(all, p->modes.relation + (size_t)force * (size_t)all, F);
  if (kind == ROW_RUBS) {
    int i = (force - k) / nt;
    sliding_direction(p, T, i, d);
    return F[force] + s->contact[i].mu * F[i] * d[(force - k) % nt];
  }
  if (kind == ROW_NONE) return F[force];
  int j = force - all;
  double normal = p->modes.normal_sense[j] * y[p->setting->at.lambda + s->slide[j].constraint];
  return F[force] + s->slide[j].mu * normal * p->modes.slide_part[j];
}

static void constraint_rows(const nsdae_event_phase *p, const nsdae_terms *T, const double *y,
                            const double *a, double *r)
{
  const nsdae_dims *d = &T->system->dims;
  const nsdae_sim_options *o = p->setting->options;
  double alpha2 = 2 * o->baumgarte_alpha, beta2 = o->baumgarte_beta * o->baumgarte_beta;
  double *sum = *p->modes.redundant ? p->rates : r;
  const double *lambda = y + p->setting->at.lambda, *B = p->modes.range;
  for (int i = 0; i < d->m; i++) {
    sum[i] = T->omega[i] + alpha2 * T->phi_t[i] + beta2 * T->phi[i];
    for (int j = 0; j < d->nv; j++) sum[i] += AT(T->J, d->m, i, j) * (a[j] + alpha2 * T->v[j]);
  }
  if (!*p->modes.redundant) return;
  for (int i = 0; i < d->m; i++) sum[i] -= lambda[i];
  memcpy(r, lambda, (size_t)d->m * sizeof *r);
  nsdae_add_product(d->m, d->m, B, sum, r);
}

/* r of the terms at their point: first M a + Phi_q^T lambda - sum W F - F. */
static int residual_of(nsdae_event_phase *p, nsdae_terms *T, const double *y, const double *yp,
                       double *r)
{
  const nsdae_dims *d = &T->system->dims;
  const nsdae_event_places *at = &p->setting->at;
  const double *a = yp + at->v;
  double *momentum = r + at->v;
  int status = nsdae_terms_need(T, p->terms);
  if (status == NSDAE_OK) status = nsdae_event_kinematics(p->setting, T->v, r);
  if (status < 0) return code_of(p, status);
  for (int i = 0; i < d->nq; i++) r[i] = yp[i] - r[i];
  for (int i = 0; i < d->nv; i++) momentum[i] = -T->F[i];
  nsdae_add_product(d->nv, d->nv, T->M, a, momentum);
  nsdae_add_transposed(d->m, d->nv, 1, T->J, y + at->lambda, momentum);
  constraint_rows(p, T, y, a, r + at->lambda);
  for (int force = 0; force < forces_of(d); force++) {
    row_kind kind = kind_of(p, force);
    double push = -y[at->normal + force];
    if (kind != ROW_NONE) nsdae_add_product(d->nv, 1, column_of(T, force).W, &push, momentum);
    r[at->normal + force] = force_row(p, T, y, a, force, kind);
  }
  return 0;
}

int nsdae_event_residual(nsdae_event_phase *p, double t, const double *y, const double *yp,
                         double *r)
{
  nsdae_event_move(p->setting, t, y);
  return residual_of(p, p->setting->here, y, yp, r);
}

/* Columns of q and v by one-sided differences of the residual: they hold the forces' stiffness and
 * damping, and the curvature of all that is closed. */
static int differenced_columns(nsdae_event_phase *p, const double *y, const double *yp,
                               const double *r, int first, int count, double *J)
{
  nsdae_terms *T = p->setting->here;
  int nq = T->system->dims.nq, n = p->setting->at.n;
  memcpy(p->other, y, (size_t)n * sizeof *y);
  for (int j = first; j < first + count; j++) {
    double step = sqrt(DBL_EPSILON) * fmax(fabs(y[j]), 1);
    p->other[j] = y[j] + step;
    step = p->other[j] - y[j];
    if (j < nq)
      nsdae_event_move(p->setting, T->t, p->other);
    else
      nsdae_terms_set_velocity(T, p->other + nq);
    p->differencing = 1;
    int code = residual_of(p, T, p->other, yp, p->r);
    p->differencing = 0;
    if (code != 0) return code;
    for (int i = 0; i < n; i++) AT(J, n, i, j) += (p->r[i] - r[i]) / step;
    p->other[j] = y[j];
  }
  return 0;
}

static void redundant_entries(const nsdae_event_phase *p, const nsdae_terms *T, double c, double *J)
{
  int m = T->system->dims.m, n = p->setting->at.n, lambda = p->setting->at.lambda;
  const double *B = p->modes.range;
  for (int l = 0; l < m; l++)
    for (int i = 0; i < m; i++) {
      AT(J, n, lambda + i, lambda + l) += (i == l) - AT(B, m, i, l);
      for (int j = 0; j < T->system->dims.nv; j++)
        AT(J, n, lambda + i, p->setting->at.v + j) += c * AT(B, m, i, l) * AT(T->J, m, l, j);
    }
}

/* The entries of q', v' and lambda. */
static void inertia_entries(const nsdae_event_phase *p, const nsdae_terms *T, double c, double *J)
{
  const nsdae_dims *d = &T->system->dims;
  int n = p->setting->at.n, nq = d->nq, lambda = p->setting->at.lambda;
  for (int i = 0; i < nq; i++) AT(J, n, i, i) += c;
  for (int j = 0; j < d->nv; j++)
    for (int i = 0; i < d->nv; i++) AT(J, n, nq + i, nq + j) += c * AT(T->M, d->nv, i, j);
  for (int i = 0; i < d->m; i++) {
    for (int j = 0; j < d->nv; j++) {
      AT(J, n, nq + j, lambda + i) += AT(T->J, d->m, i, j);
      if (!*p->modes.redundant) AT(J, n, lambda + i, nq + j) += c * AT(T->J, d->m, i, j);
    }
  }
  if (*p->modes.redundant) redundant_entries(p, T, c, J);
}

/* The column of a force, and its row but for the columns of q and v. */
static void force_entries(const nsdae_event_phase *p, const nsdae_terms *T, int force, double c,
                          double *J)
{
  const nsdae_system *s = T->system;
  int k = s->dims.k, nt = s->dims.nt, all = k * (1 + nt), n = p->setting->at.n;
  int first = p->setting->at.normal, row = first + force, v = p->setting->at.v;
  row_kind kind = kind_of(p, force);
  double d[2];
  for (int i = 0; i < s->dims.nv && kind != ROW_NONE; i++)
    AT(J, n, v + i, row) -= column_of(T, force).W[i];
  if (kind == ROW_CLOSED) {
    for (int j = 0; j < s->dims.nv; j++) AT(J, n, row, v + j) += c * column_of(T, force).W[j];
    return;
  }
  AT(J, n, row, row) += 1;
  if (kind == ROW_RELATED)
    for (int l = 0; l < all; l++) AT(J, n, row, first + l) -= AT(p->modes.relation, all, l, force);
  if (kind == ROW_RUBS) {
    int i = (force - k) / nt;
    sliding_direction(p, T, i, d);
    AT(J, n, row, first + i) += s->contact[i].mu * d[(force - k) % nt];
  }
  if (kind != ROW_SLIDE_RUBS) return;
  int j = force - all, lambda = p->setting->at.lambda + s->slide[j].constraint;
  AT(J, n, row, lambda) += s->slide[j].mu * p->modes.normal_sense[j] * p->modes.slide_part[j];
}

int nsdae_event_jacobian(nsdae_event_phase *p, double t, double c, const double *y,
                         const double *yp, const double *r, double *J)
{
  nsdae_terms *T = p->setting->here;
  const nsdae_dims *d = &T->system->dims;
  nsdae_event_move(p->setting, t, y);
  int status = nsdae_terms_need(T, p->terms);
  if (status < 0) return code_of(p, status);
  inertia_entries(p, T, c, J);
  for (int force = 0; force < forces_of(d); force++) force_entries(p, T, force, c, J);
  for (int j = 0; j < d->k * d->nt && d->nt == 2 && (p->terms & NSDAE_TERM_TANGENT); j++)
    p->slip[j] = nsdae_terms_rate(T, T->W_T, T->w_T, j, T->v);
  int code = differenced_columns(p, y, yp, r, d->nq, d->nv, J);
  return code ? code : differenced_columns(p, y, yp, r, 0, d->nq, J);
}

/* The unknowns of the forces' equations: v', lambda and the forces that are not zero anyway. */
static int gather_unknowns(nsdae_event_phase *p)
{
  const nsdae_event_places *at = &p->setting->at;
  int count = 0;
  for (int i = at->v; i < at->n; i++)
    if (i < at->normal || kind_of(p, i - at->normal) != ROW_NONE) p->unknown[count++] = i;
  return count;
}

/* K, n x n, to the equations of the unknowns, count x count. */
static void gather_equations(nsdae_event_phase *p, int count)
{
  size_t n = (size_t)p->setting->at.n, to = 0;
  for (int j = 0; j < count; j++)
    for (int i = 0; i < count; i++)
      p->K[to++] = p->K[(size_t)p->unknown[j] * n + (size_t)p->unknown[i]];
}

int nsdae_event_forces(nsdae_event_phase *p, double t, double *y)
{
  nsdae_terms *T = p->setting->here;
  int first = p->setting->at.lambda, n = p->setting->at.n;
  memset(y + first, 0, (size_t)(n - first) * sizeof *y);
  memset(p->K, 0, (size_t)n * (size_t)n * sizeof *p->K);
  nsdae_event_move(p->setting, t, y);
  int code = residual_of(p, T, y, p->zero, p->r);
  if (code != 0) return p->setting->error->status;
  inertia_entries(p, T, 1, p->K);
  for (int force = 0; force < forces_of(&T->system->dims); force++)
    force_entries(p, T, force, 1, p->K);
  int count = p->unknowns = gather_unknowns(p);
  gather_equations(p, count);
  for (int i = 0; i < count; i++) p->unit[i] = p->r[p->unknown[i]];
  if (nsdae_la_lu(count, p->K, count, p->pivot) != 0) return NSDAE_E_CONVERGENCE;
  nsdae_la_lu_solve(count, p->K, count, p->pivot, p->unit);
  for (int i = 0; i < count; i++) p->r[p->unknown[i]] = p->unit[i];
  for (int i = 0; i < count; i++)
    if (p->unknown[i] >= first) y[p->unknown[i]] = -p->unit[i];
  return NSDAE_OK;
}

double nsdae_event_yield(const nsdae_event_phase *p, int i)
{
  int row = 0, count = p->unknowns;
  while (row < count && p->unknown[row] != p->setting->at.normal + i) row++;
  memset(p->unit, 0, (size_t)count * sizeof *p->unit);
  p->unit[row] = 1;
  nsdae_la_lu_solve(count, p->K, count, p->pivot, p->unit);
  return 1 / p->unit[row];
}
