#include "account.h"

#include <string.h>

void nsdae_event_account_layout(nsdae_event_account *a, nsdae_arena *arena)
{
  a->reaction = NSDAE_ARENA_DOUBLES(arena, a->integrator->roots->phase->setting->system->dims.nv);
}

/* Power of the friction of what slides, at the state y and the terms there. */
static double friction_power(const nsdae_event_phase *p, const double *y)
{
  const nsdae_terms *T = p->setting->here;
  const nsdae_dims *d = &T->system->dims;
  double power = 0;
  for (int j = 0; j < d->k * d->nt && (p->terms & NSDAE_TERM_TANGENT); j++)
    if (p->modes.contact[j / d->nt] == NSDAE_MODE_SLIDE)
      power += y[p->setting->at.tangential + j] * nsdae_terms_rate(T, T->W_T, T->w_T, j, T->v);
  for (int j = 0; j < d->f; j++)
    if (p->modes.slide[j] == NSDAE_MODE_SLIDE)
      power += y[p->setting->at.slide + j] * nsdae_terms_rate(T, T->W_S, T->w_S, j, T->v);
  return power;
}

/* Multipliers lambda of least norm with the same Phi_q^T lambda, where constraints are redundant.
 */
static int least_norm(nsdae_event_account *a, double t, const double *y, double *lambda)
{
  nsdae_event_phase *p = a->integrator->roots->phase;
  nsdae_terms *T = p->setting->here;
  const nsdae_dims *d = &T->system->dims;
  if (!*p->modes.redundant) return NSDAE_OK;
  nsdae_event_move(p->setting, t, y);
  int status = nsdae_terms_need(T, NSDAE_TERM_MASS | NSDAE_TERM_JACOBIAN);
  if (status == NSDAE_OK) status = nsdae_event_factor(p->setting);
  if (status < 0) return status;
  memset(a->reaction, 0, (size_t)d->nv * sizeof *a->reaction);
  nsdae_add_transposed(d->m, d->nv, 1, T->J, lambda, a->reaction);
  memset(lambda, 0, (size_t)d->m * sizeof *lambda);
  nsdae_kkt_solve(p->setting->kkt, 1, a->reaction, d->nv, lambda, d->m);
  return NSDAE_OK;
}

static void add_scaled(int n, double scale, const double *a, double *sum)
{
  for (int i = 0; i < n; i++) sum[i] += scale * a[i];
}

/* Without contacts and friction the integrator's multipliers are good enough for their mean. */
int nsdae_event_account_phase(nsdae_event_account *a, double from, double to)
{
  static const double at[3] = {0.1127016653792583, 0.5, 0.8872983346207417};
  static const double weight[3] = {5.0 / 18, 8.0 / 18, 5.0 / 18};
  nsdae_event_phase *p = a->integrator->roots->phase;
  const nsdae_event_places *place = &p->setting->at;
  const nsdae_dims *d = &p->setting->system->dims;
  nsdae_result *result = p->setting->result;
  double *y = a->integrator->roots->at;
  int status = NSDAE_OK, exact = (p->terms & (NSDAE_TERM_NORMAL | NSDAE_TERM_SLIDE)) != 0;
  for (int g = 0; (exact || d->m > 0) && g < 3; g++) {
    double t = from + at[g] * (to - from), h = weight[g] * (to - from);
    status = nsdae_event_integrator_read(a->integrator, t, y);
    if (status == NSDAE_OK && exact) status = nsdae_event_forces(p, t, y);
    if (status == NSDAE_OK && exact) result->work += h * friction_power(p, y);
    if (status == NSDAE_OK) status = least_norm(a, t, y, y + place->lambda);
    if (status < 0) break;
    add_scaled(d->m, h, y + place->lambda, result->multiplier);
    add_scaled(d->k, h, y + place->normal, result->impulses.normal);
    add_scaled(d->k * d->nt, h, y + place->tangential, result->impulses.tangential);
    add_scaled(d->f, h, y + place->slide, result->impulses.slide_impulse);
  }
  return status;
}

void nsdae_event_account_impact(nsdae_event_account *a, const nsdae_impulses *from,
                                const double *multiplier)
{
  const nsdae_event_setting *s = a->integrator->roots->phase->setting;
  const nsdae_dims *d = &s->system->dims;
  nsdae_impulses *to = &s->result->impulses;
  add_scaled(d->m, 1, multiplier, s->result->multiplier);
  add_scaled(d->k, 1, from->normal, to->normal);
  add_scaled(d->k * d->nt, 1, from->tangential, to->tangential);
  add_scaled(d->f, 1, from->slide_impulse, to->slide_impulse);
}
