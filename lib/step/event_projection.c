/* Back to the constraints, to what is closed and to what sticks, by the change of least kinetic
 * energy. */
#include <float.h>
#include <math.h>
#include <string.h>

#include "event_instant.h"
#include "vector.h"

enum { PROJECTIONS = 4 };

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
  const nsdae_terms *T = nsdae_event_here(e);
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
  const nsdae_terms *T = nsdae_event_here(e);
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
int nsdae_event_project_positions(nsdae_event_method *e, double t)
{
  nsdae_terms *T = nsdae_event_here(e);
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
int nsdae_event_project_velocities(nsdae_event_method *e)
{
  nsdae_terms *T = nsdae_event_here(e);
  const nsdae_dims *d = &T->system->dims;
  double *v = e->y + d->nq;
  int rows = 0, n = d->nv;
  for (int i = 0; i < d->m; i++) {
    double rate = T->phi_t[i];
    for (int j = 0; j < n; j++) rate += T->J[j * d->m + i] * v[j];
    append_row(e, &rows, T->J + i, d->m, rate);
  }
  for (int i = 0; i < d->k; i++) {
    if (e->mode[i] == NSDAE_MODE_OPEN) continue;
    append_row(e, &rows, T->W_N + (size_t)(i * n), 1, nsdae_event_normal_velocity(T, i, v));
    for (int j = i * d->nt; e->mode[i] == NSDAE_MODE_STICK && j < (i + 1) * d->nt; j++)
      append_row(e, &rows, T->W_T + (size_t)(j * n), 1, nsdae_event_tangential_velocity(T, j, v));
  }
  for (int j = 0; j < d->f; j++)
    if (e->slide_mode[j] == NSDAE_MODE_STICK)
      append_row(e, &rows, T->W_S + (size_t)(j * n), 1,
                 nsdae_dot(n, T->W_S + (size_t)(j * n), v) + T->w_S[j]);
  if (rows == 0) return NSDAE_OK;
  int status = project(e, rows);
  for (int i = 0; i < n && status == NSDAE_OK; i++) v[i] += e->a[i];
  nsdae_terms_set_velocity(T, v);
  return status;
}
