/* Impulses and work of the forces between instants: Gauss' integrals of the integrator's
 * polynomials, three points to a piece, which is exact for its highest order. */
#include <string.h>

#include "event.h"
#include "vector.h"

/* Power of the friction of what slides, at the state y and the terms there. */
static double friction_power(const nsdae_event_method *e, const double *y)
{
  const nsdae_terms *T = &e->stepper->middle;
  const nsdae_dims *d = &T->system->dims;
  int n = d->nv;
  double power = 0;
  for (int j = 0; j < d->k * d->nt && (e->terms & NSDAE_TERM_TANGENT); j++)
    if (e->mode[j / d->nt] == NSDAE_MODE_SLIDE)
      power += y[nsdae_at_tangential(d) + j] *
               (nsdae_dot(n, T->W_T + (size_t)(j * n), T->v) + T->w_T[j]);
  for (int j = 0; j < d->f; j++)
    if (e->slide_mode[j] == NSDAE_MODE_SLIDE)
      power +=
          y[nsdae_at_slide(d) + j] * (nsdae_dot(n, T->W_S + (size_t)(j * n), T->v) + T->w_S[j]);
  return power;
}

/* Multipliers lambda of least norm with the same Phi_q^T lambda, where constraints are redundant.
 */
static int least_norm(nsdae_event_method *e, double t, const double *y, double *lambda)
{
  nsdae_stepper *s = e->stepper;
  nsdae_terms *T = &s->middle;
  const nsdae_dims *d = &s->system->dims;
  int redundant = 0;
  for (int i = 0; i < d->m; i++) redundant |= !e->independent[i];
  if (!redundant) return NSDAE_OK;
  nsdae_terms_at(T, t, y, y + d->nq);
  int status = nsdae_terms_need(T, NSDAE_TERM_MASS | NSDAE_TERM_JACOBIAN);
  if (status == NSDAE_OK) status = nsdae_stepper_factor(s, T, T->M);
  if (status < 0) return status;
  memset(s->r, 0, (size_t)d->nv * sizeof *s->r);
  nsdae_add_transposed(d->m, d->nv, 1, T->J, lambda, s->r);
  memset(lambda, 0, (size_t)d->m * sizeof *lambda);
  nsdae_kkt_solve(&s->kkt, 1, s->r, d->nv, lambda, d->m);
  return NSDAE_OK;
}

static void add_scaled(int n, double scale, const double *a, double *sum)
{
  for (int i = 0; i < n; i++) sum[i] += scale * a[i];
}

/* Integrals of the forces and of the friction's power over a piece of one step of the integrator.
 * Without contacts and friction the integrator's multipliers are good enough for their mean. */
int nsdae_event_account(nsdae_event_method *e, double from, double to)
{
  static const double at[3] = {0.1127016653792583, 0.5, 0.8872983346207417};
  static const double weight[3] = {5.0 / 18, 8.0 / 18, 5.0 / 18};
  const nsdae_dims *d = &e->stepper->system->dims;
  const double *y = e->at;
  int status = NSDAE_OK, exact = (e->terms & (NSDAE_TERM_NORMAL | NSDAE_TERM_SLIDE)) != 0;
  for (int g = 0; (exact || d->m > 0) && g < 3; g++) {
    double t = from + at[g] * (to - from), h = weight[g] * (to - from);
    status = nsdae_dae_interpolate(e->dae, t, 0, e->at);
    if (status == NSDAE_OK && exact) status = nsdae_event_forces(e, t, e->at);
    if (status == NSDAE_OK && exact) e->work += h * friction_power(e, y);
    if (status == NSDAE_OK) status = least_norm(e, t, y, e->at + nsdae_at_lambda(d));
    if (status < 0) break;
    add_scaled(d->m, h, y + nsdae_at_lambda(d), e->multiplier);
    add_scaled(d->k, h, y + nsdae_at_normal(d), e->normal);
    add_scaled(d->k * d->nt, h, y + nsdae_at_tangential(d), e->tangential);
    add_scaled(d->f, h, y + nsdae_at_slide(d), e->friction);
  }
  return status;
}
