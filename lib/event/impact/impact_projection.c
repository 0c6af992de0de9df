#include "impact_projection.h"

#include <float.h>
#include <math.h>
#include <string.h>

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

int nsdae_event_project_positions(nsdae_event_projection *p, double t, const int *closed, double *y)
{
  nsdae_event_setting *s = p->phase->setting;
  for (int round = 0; round < PROJECTIONS; round++) {
    double worst = append_positions(p, closed);
    if (p->least.rows == 0 || worst <= 4 * DBL_EPSILON) break;
    int status = nsdae_least_solve(&p->least, s->here);
    if (status == NSDAE_OK) status = nsdae_kinematics_at(s->here, p->least.change, p->qdot);
    if (status < 0) return status;
    if (nsdae_largest(s->at.v, p->qdot) > FAR * (worst + nsdae_event_position_size(s))) break;
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

static void append_velocities(nsdae_event_projection *p, const int *moving)
{
  const nsdae_terms *T = p->phase->setting->here;
  const nsdae_event_modes *m = &p->phase->modes;
  const nsdae_dims *d = &T->system->dims;
  int begin = moving && any_sticks(p->phase);
  append_rates(p, T->v);
  for (int n = 0; n < d->k; n++) {
    int i = nsdae_system_contact(T->system, n);
    if (m->contact[i] == NSDAE_MODE_OPEN) continue;
    append_rate(p, &T->by.normal, T->w_N, i, T->v);
    int rests = begin && T->system->contact[i].mu > 0 && !moving[i];
    for (int j = i * d->nt; (rests || m->contact[i] == NSDAE_MODE_STICK) && j < (i + 1) * d->nt;
         j++)
      append_rate(p, &T->by.tangent, T->w_T, j, T->v);
  }
  for (int j = 0; j < d->f; j++)
    if (m->frictional_joint[j] == NSDAE_MODE_STICK)
      append_rate(p, &T->by.frictional_joint, T->frictional_joint.w, j, T->v);
}

/* Of the change, for the balance of energy: (v + change / 2)^T M change. Its impulses are an error
 * of the integration, not of the contacts: those of the record obey the laws of contact. */
static double work_of(const nsdae_event_projection *p)
{
  const nsdae_terms *T = p->phase->setting->here;
  const double *change = p->least.change;
  double *momentum = T->by.work;
  int n = T->system->dims.nv;
  memset(momentum, 0, (size_t)n * sizeof *momentum);
  nsdae_blocks_add_product(&T->system->blocks, T->M, change, momentum);
  return nsdae_dot(n, momentum, T->v) + nsdae_dot(n, momentum, change) / 2;
}

int nsdae_event_project_velocities(nsdae_event_projection *p, const int *moving, double *y)
{
  nsdae_event_setting *s = p->phase->setting;
  append_velocities(p, moving);
  if (p->least.rows == 0) return NSDAE_OK;
  double worst = nsdae_largest(p->least.rows, p->least.c);
  int status = nsdae_least_solve(&p->least, s->here);
  if (status < 0) return status;
  double size = FAR * (worst + nsdae_event_velocity_size(s));
  if (nsdae_largest(p->least.kkt.n, p->least.change) > size) return NSDAE_OK;
  s->result->work += work_of(p);
  nsdae_add(p->least.kkt.n, 1, p->least.change, y + s->at.v);
  nsdae_terms_set_velocity(s->here, y + s->at.v);
  return NSDAE_OK;
}

int nsdae_event_close(nsdae_event_projection *p, const int *closed, const int *sticks, double *v,
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
