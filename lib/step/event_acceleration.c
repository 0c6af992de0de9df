/* The problem of accelerations: the laws of what may stay closed, its solution, and Painleve's
 * paradox where it has none or two. */
#include <math.h>
#include <string.h>

#include "errors.h"
#include "event_instant.h"
#include "vector.h"

/* Relative to W_N^T P W_N, the coefficient of a sliding contact that is none; and one that explains
 * why the integrator failed. */
static const double SINGULAR = 1e-10, NEARLY = 1e-3;

/* Fills the direction of sliding of contact i; 0 where it has none. At a slip that was found at
 * zero there is none. */
static int slides(nsdae_event_method *e, int i, int impacted)
{
  const nsdae_terms *T = nsdae_event_here(e);
  const nsdae_dims *d = &T->system->dims;
  double v_t[2] = {0}, speed = 0, *direction = e->direction + i * d->nt;
  if (!(T->system->contact[i].mu > 0)) return 0;
  if (e->breakaway[i] && !impacted) return 1;
  int slid = 0;
  for (int l = 0; l < d->nt; l++) {
    v_t[l] = nsdae_event_tangential_velocity(T, i * d->nt + l, e->y + d->nq);
    speed = hypot(speed, v_t[l]);
    slid |= e->mode[i] == NSDAE_MODE_SLIDE && direction[l] != 0;
  }
  int stopped = !impacted && e->found[d->k + i] && slid &&
                (d->nt == 1 || speed <= 10 * nsdae_event_velocity_size(e, T));
  int moves = speed > nsdae_event_velocity_size(e, T) && !stopped;
  for (int l = 0; l < d->nt; l++) direction[l] = moves ? v_t[l] / speed : 0;
  return moves;
}

static int slide_sense(nsdae_event_method *e, int j, int impacted)
{
  const nsdae_terms *T = nsdae_event_here(e);
  const nsdae_dims *d = &T->system->dims;
  int n = d->nv, found = e->found[2 * d->k + d->f + j];
  if (e->slide_breakaway[j] && !impacted) return e->slide_sense[j];
  double speed = nsdae_dot(n, T->W_S + (size_t)(j * n), e->y + d->nq) + T->w_S[j];
  int stopped =
      !impacted && found && e->slide_mode[j] == NSDAE_MODE_SLIDE && e->slide_sense[j] != 0;
  if (stopped || !(fabs(speed) > nsdae_event_velocity_size(e, T))) return 0;
  return speed > 0 ? 1 : -1;
}

void nsdae_event_set_laws(nsdae_event_method *e, int impacted)
{
  const nsdae_system *s = e->stepper->system;
  int nt = s->dims.nt;
  for (int i = 0; i < s->dims.k; i++) {
    if (!e->candidate[i]) continue;
    e->moving[i] = slides(e, i, impacted);
    e->law[i] = e->moving[i] ? nsdae_law_sliding(nt, s->contact[i].mu, e->direction + i * nt)
                             : e->resting[i];
  }
  for (int j = 0; j < s->dims.f; j++) e->sliding_sense[j] = slide_sense(e, j, impacted);
}

static int solve(nsdae_event_method *e)
{
  nsdae_stepper *s = e->stepper;
  nsdae_terms T = *nsdae_event_here(e);
  int n = s->system->dims.nv, m = s->system->dims.m;
  T.w_N = T.omega_N;
  T.w_T = T.omega_T;
  T.w_S = T.omega_S;
  nsdae_contacts_close_marked(&e->modes, e->candidate, &e->forces);
  memcpy(e->a, T.F, (size_t)n * sizeof *e->a);
  memcpy(s->size, T.F, (size_t)n * sizeof *s->size);
  for (int i = 0; i < m; i++) e->lambda[i] = -T.omega[i];
  nsdae_kkt_solve(&s->kkt, 1, e->a, n, e->lambda, m);
  nsdae_kkt_solve_mass(&s->kkt, s->size);
  e->result->problem = &e->modes;
  int status = nsdae_contacts_solve(&e->modes, &T, &s->kkt, s->size, e->a, e->lambda);
  if (nsdae_contacts_any(&e->modes)) {
    e->result->counters.lcps++;
    e->result->counters.lcp_pivots += e->modes.lcp.info.pivots;
    e->result->worst_residual = fmax(e->result->worst_residual, e->modes.lcp.info.residual);
  }
  return status;
}

/* A contact that slides and whose own coefficient W_N^T P (W_N - mu W_T d) is not above zero pulls
 * itself in: then there is no force, or two (Painleve 1895). */
static int paradox(nsdae_event_method *e, double t, int status, double least)
{
  const nsdae_contacts *c = &e->modes;
  for (int a = 0; a < c->active_count; a++) {
    int i = c->active[a], row = c->first_row[a];
    double coefficient = c->lcp.A[(size_t)row * (size_t)c->rows + (size_t)row];
    double scale = c->delassus.G[(size_t)c->first_column[a] * (size_t)(c->columns + 1)];
    if (c->law[i].kind != NSDAE_SLIDING || coefficient > least * scale) continue;
    const char *what = coefficient > SINGULAR * scale ? "a contact force that grows without bound"
                       : status < 0                   ? "no contact force that solves the equations"
                                                      : "two solutions";
    nsdae_error_set(e->stepper->error, NSDAE_E_PAINLEVE, "nsdae_event", "mu",
                    "contact %d has %s at t = %.17g (Painleve's paradox: its friction feeds its "
                    "normal force, coefficient %.3g): take less friction, or method = implicit, "
                    "which resolves it by an impulse",
                    i, what, t, coefficient);
    e->stepper->error->index = i;
    e->stepper->error->time = t;
    return NSDAE_E_PAINLEVE;
  }
  return status;
}

int nsdae_event_accelerate(nsdae_event_method *e, double t)
{
  return paradox(e, t, solve(e), SINGULAR);
}

int nsdae_event_diagnose(nsdae_event_method *e, double t)
{
  nsdae_stepper *s = e->stepper;
  nsdae_terms *T = nsdae_event_here(e);
  nsdae_error kept = *s->error;
  const nsdae_dims *d = &s->system->dims;
  nsdae_terms_at(T, t, e->y, e->y + d->nq);
  int status = nsdae_terms_need(T, NSDAE_EVENT_TERMS);
  if (status == NSDAE_OK) status = nsdae_stepper_factor(s, T, T->M);
  if (status == NSDAE_OK) {
    for (int i = 0; i < d->k; i++) e->candidate[i] = e->mode[i] != NSDAE_MODE_OPEN;
    memset(e->found, 0, (size_t)e->roots * sizeof *e->found);
    nsdae_event_set_laws(e, 0);
    status = paradox(e, t, solve(e), NEARLY);
  }
  if (status == NSDAE_E_PAINLEVE) return status;
  *s->error = kept;
  return NSDAE_OK;
}

double nsdae_event_acceleration_size(const nsdae_event_method *e)
{
  double most = 0;
  for (int i = 0; i < e->stepper->system->dims.nv; i++) {
    most = fmax(most, fabs(e->a[i]));
    most = fmax(most, fabs(e->stepper->size[i]));
  }
  return 1e-10 * most;
}
