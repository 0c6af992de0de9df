#include "errors.h"
#include "projection.h"

#include <float.h>
#include <math.h>
#include <string.h>

enum { PROJECTIONS = 4 };

void nsdae_event_projection_layout(nsdae_event_projection *p, nsdae_arena *arena)
{
  const nsdae_dims *d = &p->phase->setting->system->dims;
  long rows = d->m + (long)d->k * (1 + d->nt) + d->f;
  p->kkt.n = d->nv;
  p->kkt.m = (int)rows;
  p->kkt.rank_tol = p->phase->setting->options->rank_tol;
  nsdae_kkt_layout(&p->kkt, arena);
  p->J = NSDAE_ARENA_DOUBLES(arena, rows * d->nv);
  p->Jt = NSDAE_ARENA_DOUBLES(arena, rows * d->nv);
  p->c = NSDAE_ARENA_DOUBLES(arena, rows);
  p->change = NSDAE_ARENA_DOUBLES(arena, d->nv);
  p->qdot = NSDAE_ARENA_DOUBLES(arena, d->nq);
}

/* Appends the row W^T change = -missing. */
static void append(nsdae_event_projection *p, const double *W, int stride, double missing)
{
  int n = p->kkt.n;
  double *row = p->J + (size_t)p->rows * (size_t)n;
  for (int j = 0; j < n; j++) row[j] = W[(size_t)j * (size_t)stride];
  p->c[p->rows++] = -missing;
}

/* The change of least kinetic energy with the rows that were appended. */
static int project(nsdae_event_projection *p)
{
  int n = p->kkt.n, rows = p->rows;
  size_t width = (size_t)n, height = (size_t)rows;
  nsdae_kkt kkt = p->kkt;
  for (size_t i = 0; i < height; i++)
    for (size_t j = 0; j < width; j++) p->Jt[j * height + i] = p->J[i * width + j];
  kkt.m = rows;
  const nsdae_terms *T = p->phase->setting->here;
  int status = nsdae_kkt_factor(&kkt, T->M, n, p->Jt, rows);
  if (status < 0) return nsdae_terms_bad_mass(T, &kkt);
  memset(p->change, 0, (size_t)n * sizeof *p->change);
  nsdae_kkt_solve(&kkt, 1, p->change, n, p->c, rows);
  return NSDAE_OK;
}

/* Appends positions; returns the worst. */
static double append_positions(nsdae_event_projection *p, const int *closed)
{
  const nsdae_terms *T = p->phase->setting->here;
  const nsdae_dims *d = &T->system->dims;
  double worst = 0;
  p->rows = 0;
  for (int i = 0; i < d->m; i++) append(p, T->J + i, d->m, T->phi[i]);
  for (int i = 0; i < d->k; i++)
    if (closed[i]) append(p, T->W_N + (size_t)i * (size_t)d->nv, 1, T->gap[i]);
  for (int i = 0; i < p->rows; i++) worst = fmax(worst, fabs(p->c[i]));
  return worst;
}

int nsdae_event_project_positions(nsdae_event_projection *p, double t, const int *closed, double *y)
{
  nsdae_event_setting *s = p->phase->setting;
  for (int round = 0; round < PROJECTIONS; round++) {
    double worst = append_positions(p, closed);
    if (p->rows == 0 || worst <= 4 * DBL_EPSILON) break;
    int status = project(p);
    if (status == NSDAE_OK) status = nsdae_event_kinematics(s, p->change, p->qdot);
    if (status < 0) return status;
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
  p->rows = 0;
  for (int i = 0; i < m; i++) append(p, T->J + i, m, nsdae_terms_constraint_rate(T, i, v));
}

static void append_velocities(nsdae_event_projection *p)
{
  const nsdae_terms *T = p->phase->setting->here;
  const nsdae_event_modes *m = &p->phase->modes;
  const nsdae_dims *d = &T->system->dims;
  size_t n = (size_t)d->nv;
  append_rates(p, T->v);
  for (int i = 0; i < d->k; i++) {
    if (m->contact[i] == NSDAE_MODE_OPEN) continue;
    append(p, T->W_N + (size_t)i * n, 1, nsdae_terms_rate(T, T->W_N, T->w_N, i, T->v));
    for (int j = i * d->nt; m->contact[i] == NSDAE_MODE_STICK && j < (i + 1) * d->nt; j++)
      append(p, T->W_T + (size_t)j * n, 1, nsdae_terms_rate(T, T->W_T, T->w_T, j, T->v));
  }
  for (int j = 0; j < d->f; j++)
    if (m->slide[j] == NSDAE_MODE_STICK)
      append(p, T->W_S + (size_t)j * n, 1, nsdae_terms_rate(T, T->W_S, T->w_S, j, T->v));
}

/* The impulses that did it, in the order of the rows; and their work, the change of v^T M v / 2. */
static void account(const nsdae_event_projection *p)
{
  const nsdae_event_setting *s = p->phase->setting;
  const nsdae_terms *T = s->here;
  const nsdae_event_modes *m = &p->phase->modes;
  const nsdae_dims *d = &T->system->dims;
  nsdae_impulses *to = &s->result->impulses;
  int n = d->nv, row = d->m;
  nsdae_add(d->m, 1, p->c, s->result->multiplier);
  for (int i = 0; i < d->k; i++) {
    if (m->contact[i] == NSDAE_MODE_OPEN) continue;
    to->normal[i] -= p->c[row++];
    for (int j = i * d->nt; m->contact[i] == NSDAE_MODE_STICK && j < (i + 1) * d->nt; j++)
      to->tangential[j] -= p->c[row++];
  }
  for (int j = 0; j < d->f; j++)
    if (m->slide[j] == NSDAE_MODE_STICK) to->slide_impulse[j] -= p->c[row++];
  for (int j = 0; j < n; j++)
    s->result->work +=
        nsdae_dot(n, T->M + (size_t)j * (size_t)n, p->change) * (T->v[j] + p->change[j] / 2);
}

int nsdae_event_project_velocities(nsdae_event_projection *p, double *y)
{
  nsdae_event_setting *s = p->phase->setting;
  append_velocities(p);
  if (p->rows == 0) return NSDAE_OK;
  int status = project(p);
  if (status < 0) return status;
  account(p);
  nsdae_add(p->kkt.n, 1, p->change, y + s->at.v);
  nsdae_terms_set_velocity(s->here, y + s->at.v);
  return NSDAE_OK;
}

int nsdae_event_close(nsdae_event_projection *p, const int *closed, const int *sticks, double *v,
                      double *multiplier, double *normal, double *tangential)
{
  const nsdae_terms *T = p->phase->setting->here;
  const nsdae_dims *d = &T->system->dims;
  size_t n = (size_t)d->nv;
  append_rates(p, v);
  for (int i = 0; i < d->k; i++) {
    if (closed[i]) append(p, T->W_N + (size_t)i * n, 1, nsdae_terms_rate(T, T->W_N, T->w_N, i, v));
    for (int j = i * d->nt; closed[i] && sticks[i] && j < (i + 1) * d->nt; j++)
      append(p, T->W_T + (size_t)j * n, 1, nsdae_terms_rate(T, T->W_T, T->w_T, j, v));
  }
  int status = project(p), row = d->m;
  if (status < 0) return status;
  for (int j = 0; j < d->nv; j++) v[j] += p->change[j];
  for (int i = 0; i < d->m; i++) multiplier[i] += p->c[i];
  for (int i = 0; i < d->k; i++) {
    normal[i] = closed[i] ? -p->c[row++] : 0;
    for (int j = i * d->nt; j < (i + 1) * d->nt; j++)
      tangential[j] = closed[i] && sticks[i] ? -p->c[row++] : 0;
  }
  return NSDAE_OK;
}
