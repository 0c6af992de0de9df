/* The equations of a phase: see event.h. */
#include <float.h>
#include <math.h>
#include <string.h>

#include "dense.h"
#include "event.h"
#include "vector.h"

#define AT(A, n, i, j) (A)[(size_t)(j) * (size_t)(n) + (size_t)(i)]

int nsdae_event_code(const nsdae_stepper *s, int status)
{
  if (status == NSDAE_OK) return 0;
  if (status == NSDAE_E_CALLBACK) return s->error->code < 0 ? -1 : 1;
  return status == NSDAE_E_NONFINITE ? -1 : 1;
}

void nsdae_event_set_terms(nsdae_event_method *e)
{
  const nsdae_system *s = e->stepper->system;
  unsigned terms = NSDAE_TERM_MASS | NSDAE_TERM_FORCE | NSDAE_TERM_PHI | NSDAE_TERM_JACOBIAN |
                   NSDAE_TERM_PHI_T | NSDAE_TERM_OMEGA;
  for (int i = 0; i < s->dims.k; i++) {
    if (e->mode[i] == NSDAE_MODE_OPEN) continue;
    terms |= NSDAE_TERM_GAP | NSDAE_TERM_NORMAL | NSDAE_TERM_BIAS | NSDAE_TERM_ACCELERATION;
    if (s->contact[i].mu > 0) terms |= NSDAE_TERM_TANGENT;
  }
  for (int j = 0; j < s->dims.f; j++) {
    if (e->slide_mode[j] != NSDAE_MODE_OPEN) terms |= NSDAE_TERM_SLIDE;
    if (e->slide_mode[j] == NSDAE_MODE_STICK) terms |= NSDAE_TERM_ACCELERATION;
  }
  e->terms = terms;
}

/* The weights of Baumgarte's stabilisation. */
static double alpha2(const nsdae_event_method *e)
{
  return 2 * e->stepper->options->baumgarte_alpha;
}

static double beta2(const nsdae_event_method *e)
{
  double beta = e->stepper->options->baumgarte_beta;
  return beta * beta;
}

/* W^T (a + 2 alpha v) + omega + 2 alpha w + beta^2 g, of one column. */
static double closed_row(const nsdae_event_method *e, const double *W, double w, double omega,
                         double g, const double *v, const double *a)
{
  int n = e->stepper->system->dims.nv;
  return nsdae_dot(n, W, a) + omega + alpha2(e) * (nsdae_dot(n, W, v) + w) + beta2(e) * g;
}

/* v_T of contact i. */
static void slip_of(const nsdae_terms *T, int i, double *v_t)
{
  int n = T->system->dims.nv, nt = T->system->dims.nt;
  for (int j = i * nt, l = 0; l < nt; l++, j++)
    v_t[l] = nsdae_dot(n, T->W_T + (size_t)(j * n), T->v) + T->w_T[j];
}

/* u = v_T, but along the direction e of last at least the size of a velocity: then u / |u| goes
 * smoothly through the stop, where the root function e . v_T ends the phase. */
static double slip_ahead(const nsdae_event_method *e, int i, const double *v_t, double *u)
{
  const double *last = e->direction + 2 * i;
  double along = last[0] * v_t[0] + last[1] * v_t[1];
  double more = fmax(e->slow - along, 0);
  for (int l = 0; l < 2; l++) u[l] = v_t[l] + more * last[l];
  return more;
}

/* Unit vector of sliding. While the residual is differenced, that with two directions is
 * d + (1 - d d^T) du / |u|: its curvature, over |u|, is no matter for a difference. */
static void sliding_direction(const nsdae_event_method *e, const nsdae_terms *T, int i, double *d)
{
  int nt = T->system->dims.nt;
  const double *last = e->direction + i * nt, *base = e->slip + i * nt;
  double v_t[2], u[2], du[2];
  for (int l = 0; l < nt; l++) d[l] = last[l];
  if (nt < 2 || (last[0] == 0 && last[1] == 0)) return;
  slip_of(T, i, v_t);
  double more = slip_ahead(e, i, e->differencing ? base : v_t, u), size = hypot(u[0], u[1]);
  for (int l = 0; l < 2; l++) d[l] = u[l] / size;
  if (!e->differencing) return;
  for (int l = 0; l < 2; l++) du[l] = v_t[l] - base[l];
  double lost = more > 0 ? last[0] * du[0] + last[1] * du[1] : 0;
  for (int l = 0; l < 2; l++) du[l] -= lost * last[l];
  double along = d[0] * du[0] + d[1] * du[1];
  for (int l = 0; l < 2; l++) du[l] = (du[l] - along * d[l]) / size;
  for (int l = 0; l < 2; l++) d[l] += du[l];
}

/* Whether contact i, its j-th tangential row, slide j has a row of its own. */
static int has_row(const nsdae_event_method *e, int i)
{
  return e->mode[i] != NSDAE_MODE_OPEN && !nsdae_event_related(e, i);
}

static int has_stick_row(const nsdae_event_method *e, int j)
{
  const nsdae_dims *d = &e->stepper->system->dims;
  return e->mode[j / d->nt] == NSDAE_MODE_STICK && !nsdae_event_related(e, d->k + j);
}

static int has_slide_row(const nsdae_event_method *e, int j)
{
  return e->slide_mode[j] == NSDAE_MODE_STICK && e->slide_row[j];
}

/* F_p - sum r_l F_l, of that force of y */
static double relation_row(const nsdae_event_method *e, int number, const double *y)
{
  const nsdae_row_set *s = &e->rows;
  int p = e->relation[number], n = e->modes.columns;
  double sum = y[s->unknown[p]];
  const double *r = s->relation + (size_t)p * (size_t)n;
  for (int l = 0; l < s->columns; l++) sum -= r[l] * y[s->unknown[l]];
  return sum;
}

static void contact_rows(const nsdae_event_method *e, const nsdae_terms *T, const double *y,
                         const double *a, double *r)
{
  const nsdae_system *s = T->system;
  const nsdae_dims *d = &s->dims;
  size_t n = (size_t)d->nv;
  const double *F_N = y + nsdae_at_normal(d), *F_T = y + nsdae_at_tangential(d);
  double *r_N = r + nsdae_at_normal(d), *r_T = r + nsdae_at_tangential(d);
  for (int i = 0; i < d->k; i++) {
    int rubs = e->mode[i] == NSDAE_MODE_SLIDE && s->contact[i].mu > 0;
    double direction[2] = {0};
    r_N[i] = F_N[i];
    if (has_row(e, i))
      r_N[i] = closed_row(e, T->W_N + (size_t)i * n, T->w_N[i], T->omega_N[i], T->gap[i], T->v, a);
    else if (e->mode[i] != NSDAE_MODE_OPEN)
      r_N[i] = relation_row(e, i, y);
    if (rubs) sliding_direction(e, T, i, direction);
    for (int l = 0, j = i * d->nt; l < d->nt; l++, j++)
      r_T[j] = has_stick_row(e, j)
                   ? closed_row(e, T->W_T + (size_t)j * n, T->w_T[j], T->omega_T[j], 0, T->v, a)
               : e->mode[i] == NSDAE_MODE_STICK ? relation_row(e, d->k + j, y)
                                                : F_T[j] + s->contact[i].mu * F_N[i] * direction[l];
  }
}

static void slide_rows(const nsdae_event_method *e, const nsdae_terms *T, const double *y,
                       const double *a, double *r)
{
  const nsdae_system *s = T->system;
  const nsdae_dims *d = &s->dims;
  const double *lambda = y + nsdae_at_lambda(d), *F_S = y + nsdae_at_slide(d);
  for (int j = 0; j < d->f; j++) {
    double normal = e->normal_sense[j] * lambda[s->slide[j].constraint];
    r[nsdae_at_slide(d) + j] = has_slide_row(e, j)
                                   ? closed_row(e, T->W_S + (size_t)j * (size_t)d->nv, T->w_S[j],
                                                T->omega_S[j], 0, T->v, a)
                                   : F_S[j] + s->slide[j].mu * normal * e->slide_part[j];
  }
}

static void constraint_rows(const nsdae_event_method *e, const nsdae_terms *T, const double *y,
                            const double *a, double *r)
{
  const nsdae_dims *d = &T->system->dims;
  const double *lambda = y + nsdae_at_lambda(d);
  r += nsdae_at_lambda(d);
  for (int i = 0; i < d->m; i++) {
    double sum = T->omega[i] + alpha2(e) * T->phi_t[i] + beta2(e) * T->phi[i];
    for (int j = 0; j < d->nv; j++) sum += AT(T->J, d->m, i, j) * (a[j] + alpha2(e) * T->v[j]);
    r[i] = e->independent[i] ? sum : lambda[i];
  }
}

/* M a + Phi_q^T lambda - W_N F_N - W_T F_T - W_S F_S - F */
static void momentum_rows(const nsdae_event_method *e, const nsdae_terms *T, const double *y,
                          const double *a, double *r)
{
  const nsdae_dims *d = &T->system->dims;
  int n = d->nv;
  for (int i = 0; i < n; i++) r[i] = -T->F[i];
  nsdae_add_product(n, n, T->M, a, r);
  nsdae_add_transposed(d->m, n, 1, T->J, y + nsdae_at_lambda(d), r);
  for (int i = 0; i < d->k; i++) {
    double push = -y[nsdae_at_normal(d) + i];
    if (e->mode[i] == NSDAE_MODE_OPEN) continue;
    nsdae_add_product(n, 1, T->W_N + (size_t)(i * n), &push, r);
    if (!(T->system->contact[i].mu > 0)) continue;
    for (int j = i * d->nt; j < (i + 1) * d->nt; j++) {
      push = -y[nsdae_at_tangential(d) + j];
      nsdae_add_product(n, 1, T->W_T + (size_t)(j * n), &push, r);
    }
  }
  for (int j = 0; j < d->f; j++) {
    double push = -y[nsdae_at_slide(d) + j];
    if (e->slide_mode[j] != NSDAE_MODE_OPEN)
      nsdae_add_product(n, 1, T->W_S + (size_t)(j * n), &push, r);
  }
}

/* r of the terms at their point. */
static int residual_of(nsdae_event_method *e, nsdae_terms *T, const double *y, const double *yp,
                       double *r)
{
  const nsdae_dims *d = &T->system->dims;
  const double *a = yp + d->nq;
  int status = nsdae_terms_need(T, e->terms);
  if (status == NSDAE_OK) status = nsdae_stepper_kinematics(e->stepper, T->t, T->q, T->v, r);
  if (status < 0) return nsdae_event_code(e->stepper, status);
  for (int i = 0; i < d->nq; i++) r[i] = yp[i] - r[i];
  momentum_rows(e, T, y, a, r + d->nq);
  constraint_rows(e, T, y, a, r);
  contact_rows(e, T, y, a, r);
  slide_rows(e, T, y, a, r);
  return 0;
}

int nsdae_event_residual(double t, const double *y, const double *yp, double *r, void *user)
{
  nsdae_event_method *e = user;
  nsdae_terms *T = &e->stepper->middle;
  nsdae_terms_at(T, t, y, y + T->system->dims.nq);
  return residual_of(e, T, y, yp, r);
}

/* Columns of q and v by one-sided differences of the residual: they hold the forces' stiffness and
 * damping, and the curvature of all that is closed. */
static int differenced_columns(nsdae_event_method *e, const double *y, const double *yp,
                               const double *r, int first, int count, double *J)
{
  nsdae_terms *T = &e->stepper->middle;
  int nq = T->system->dims.nq;
  memcpy(e->other, y, (size_t)e->n * sizeof *y);
  for (int j = first; j < first + count; j++) {
    double step = sqrt(DBL_EPSILON) * fmax(fabs(y[j]), 1);
    e->other[j] = y[j] + step;
    step = e->other[j] - y[j];
    if (j < nq)
      nsdae_terms_at(T, T->t, e->other, e->other + nq);
    else
      nsdae_terms_set_velocity(T, e->other + nq);
    e->differencing = 1;
    int code = residual_of(e, T, e->other, yp, e->r);
    e->differencing = 0;
    if (code != 0) return code;
    for (int i = 0; i < e->n; i++) AT(J, e->n, i, j) += (e->r[i] - r[i]) / step;
    e->other[j] = y[j];
  }
  return 0;
}

/* J(row, columns of v) += scale W^T, of one column of W. */
static void add_row(const nsdae_event_method *e, int row, double scale, const double *W, double *J)
{
  const nsdae_dims *d = &e->stepper->system->dims;
  for (int j = 0; j < d->nv; j++) AT(J, e->n, row, d->nq + j) += scale * W[j];
}

/* J(rows of momentum, column) -= W */
static void subtract_column(const nsdae_event_method *e, int column, const double *W, double *J)
{
  const nsdae_dims *d = &e->stepper->system->dims;
  for (int i = 0; i < d->nv; i++) AT(J, e->n, d->nq + i, column) -= W[i];
}

static void inertia_entries(const nsdae_event_method *e, const nsdae_terms *T, double c, double *J)
{
  const nsdae_dims *d = &T->system->dims;
  int nq = d->nq, lambda = nsdae_at_lambda(d);
  for (int i = 0; i < nq; i++) AT(J, e->n, i, i) += c;
  for (int j = 0; j < d->nv; j++)
    for (int i = 0; i < d->nv; i++) AT(J, e->n, nq + i, nq + j) += c * AT(T->M, d->nv, i, j);
  for (int i = 0; i < d->m; i++) {
    for (int j = 0; j < d->nv; j++) {
      AT(J, e->n, nq + j, lambda + i) += AT(T->J, d->m, i, j);
      if (e->independent[i]) AT(J, e->n, lambda + i, nq + j) += c * AT(T->J, d->m, i, j);
    }
    if (!e->independent[i]) AT(J, e->n, lambda + i, lambda + i) += 1;
  }
}

static void relation_entries(const nsdae_event_method *e, int number, double *J)
{
  const nsdae_row_set *s = &e->rows;
  int p = e->relation[number], n = e->modes.columns, row = s->unknown[p];
  const double *r = s->relation + (size_t)p * (size_t)n;
  AT(J, e->n, row, row) += 1;
  for (int l = 0; l < s->columns; l++) AT(J, e->n, row, s->unknown[l]) -= r[l];
}

static void normal_entries(const nsdae_event_method *e, const nsdae_terms *T, int i, double c,
                           double *J)
{
  int n = T->system->dims.nv, row = nsdae_at_normal(&T->system->dims) + i;
  const double *W = T->W_N + (size_t)(i * n);
  if (e->mode[i] != NSDAE_MODE_OPEN) subtract_column(e, row, W, J);
  if (has_row(e, i))
    add_row(e, row, c, W, J);
  else if (e->mode[i] != NSDAE_MODE_OPEN)
    relation_entries(e, i, J);
  else
    AT(J, e->n, row, row) += 1;
}

static void contact_entries(const nsdae_event_method *e, const nsdae_terms *T, int i, double c,
                            double *J)
{
  const nsdae_system *s = T->system;
  const nsdae_dims *d = &s->dims;
  size_t n = (size_t)d->nv;
  int rubs = e->mode[i] != NSDAE_MODE_OPEN && s->contact[i].mu > 0;
  double direction[2] = {0};
  normal_entries(e, T, i, c, J);
  if (rubs && e->mode[i] == NSDAE_MODE_SLIDE) sliding_direction(e, T, i, direction);
  for (int l = 0; l < d->nt; l++) {
    int j = i * d->nt + l, row = nsdae_at_tangential(d) + j;
    if (rubs) subtract_column(e, row, T->W_T + (size_t)j * n, J);
    if (has_stick_row(e, j)) {
      add_row(e, row, c, T->W_T + (size_t)j * n, J);
    } else if (e->mode[i] == NSDAE_MODE_STICK) {
      relation_entries(e, d->k + j, J);
    } else {
      AT(J, e->n, row, row) += 1;
      AT(J, e->n, row, nsdae_at_normal(d) + i) += s->contact[i].mu * direction[l];
    }
  }
}

static void slide_entries(const nsdae_event_method *e, const nsdae_terms *T, int j, double c,
                          double *J)
{
  const nsdae_system *s = T->system;
  const nsdae_dims *d = &s->dims;
  const double *W = T->W_S + (size_t)j * (size_t)d->nv;
  int row = nsdae_at_slide(d) + j, lambda = nsdae_at_lambda(d) + s->slide[j].constraint;
  if (e->slide_mode[j] != NSDAE_MODE_OPEN) subtract_column(e, row, W, J);
  if (has_slide_row(e, j)) {
    add_row(e, row, c, W, J);
    return;
  }
  AT(J, e->n, row, row) += 1;
  AT(J, e->n, row, lambda) += s->slide[j].mu * e->normal_sense[j] * e->slide_part[j];
}

int nsdae_event_jacobian(double t, double c, const double *y, const double *yp, const double *r,
                         double *J, void *user)
{
  nsdae_event_method *e = user;
  nsdae_terms *T = &e->stepper->middle;
  const nsdae_dims *d = &T->system->dims;
  nsdae_terms_at(T, t, y, y + d->nq);
  int status = nsdae_terms_need(T, e->terms);
  if (status < 0) return nsdae_event_code(e->stepper, status);
  inertia_entries(e, T, c, J);
  for (int i = 0; i < d->k; i++) contact_entries(e, T, i, c, J);
  for (int i = 0; i < d->k && d->nt == 2 && (e->terms & NSDAE_TERM_TANGENT); i++)
    slip_of(T, i, e->slip + 2 * i);
  for (int j = 0; j < d->f; j++) slide_entries(e, T, j, c, J);
  int code = differenced_columns(e, y, yp, r, d->nq, d->nv, J);
  return code ? code : differenced_columns(e, y, yp, r, 0, d->nq, J);
}

int nsdae_event_forces(nsdae_event_method *e, double t, double *y)
{
  nsdae_terms *T = &e->stepper->middle;
  const nsdae_dims *d = &T->system->dims;
  int nq = d->nq, first = nsdae_at_lambda(d), rows = e->n - nq;
  double *K = e->K + (size_t)nq * (size_t)(e->n + 1), *z = e->r + nq;
  memset(y + first, 0, (size_t)(e->n - first) * sizeof *y);
  memset(e->K, 0, (size_t)e->n * (size_t)e->n * sizeof *e->K);
  nsdae_terms_at(T, t, y, y + nq);
  int code = residual_of(e, T, y, e->zero, e->r);
  if (code != 0) return e->stepper->error->status;
  inertia_entries(e, T, 1, e->K);
  for (int i = 0; i < d->k; i++) contact_entries(e, T, i, 1, e->K);
  for (int j = 0; j < d->f; j++) slide_entries(e, T, j, 1, e->K);
  if (nsdae_la_lu(rows, K, e->n, e->pivot) != 0) return NSDAE_E_CONVERGENCE;
  nsdae_la_lu_solve(rows, K, e->n, e->pivot, z);
  for (int i = first; i < e->n; i++) y[i] = -e->r[i];
  return NSDAE_OK;
}
