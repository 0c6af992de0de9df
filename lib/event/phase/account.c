#include "account.h"

#include <math.h>
#include <string.h>

#include "stalled_steps.h"

void nsdae_event_account_layout(nsdae_event_account *a, nsdae_arena *arena)
{
  const nsdae_event_setting *s = a->phase->setting;
  a->y = NSDAE_ARENA_DOUBLES(arena, s->at.n);
  nsdae_power_layout(&a->power, s->system, arena);
  a->reaction = NSDAE_ARENA_DOUBLES(arena, s->system->dims.nv);
}

/* Power of the friction of what slides, at the state y and the terms there. */
static double friction_power(const nsdae_event_phase *p, const double *y)
{
  const nsdae_terms *T = p->setting->here;
  const nsdae_dims *d = &T->system->dims;
  double power = 0;
  for (int j = 0; j < d->k * d->nt && (p->terms & NSDAE_TERM_TANGENT); j++)
    if (p->modes.contact[j / d->nt] == NSDAE_MODE_SLIP)
      power += y[p->setting->at.tangential + j] * nsdae_terms_tangent_rate(T, j, T->v);
  for (int j = 0; j < d->f; j++)
    if (p->modes.frictional_joint[j] == NSDAE_MODE_SLIP)
      power += y[p->setting->at.frictional_joint + j] * nsdae_terms_slide_rate(T, j, T->v);
  return power;
}

static void linear_forces(const nsdae_event_phase *p, const double *y, double *linear)
{
  const nsdae_event_places *at = &p->setting->at;
  memset(linear, 0, (size_t)(at->whole - at->n - 2) * sizeof *linear);
  nsdae_terms_add_all_linear(p->setting->here, y + at->normal, y + at->tangential, linear);
}

/* Power that constraints, closed contacts and what sticks take though they do none: their forces
 * times the rates that should be zero. A mechanism that locks, as where redundant constraints have
 * become independent by their drift, loses its energy here. */
static double leak(const nsdae_event_phase *p, const double *y)
{
  const nsdae_terms *T = p->setting->here;
  const nsdae_dims *d = &T->system->dims;
  const nsdae_event_places *at = &p->setting->at;
  double power = 0;
  for (int i = 0; i < d->m; i++)
    power -= y[at->lambda + i] * nsdae_terms_constraint_rate(T, i, T->v);
  for (int n = 0; n < d->k; n++) {
    int i = nsdae_system_contact(T->system, n);
    if (p->modes.contact[i] == NSDAE_MODE_OPEN) continue;
    power += y[at->normal + i] * nsdae_terms_normal_rate(T, i, T->v);
    for (int j = i * d->nt; p->modes.contact[i] == NSDAE_MODE_STICK && j < (i + 1) * d->nt; j++)
      power += y[at->tangential + j] * nsdae_terms_tangent_rate(T, j, T->v);
  }
  for (int j = 0; j < d->f; j++)
    if (p->modes.frictional_joint[j] == NSDAE_MODE_STICK)
      power += y[at->frictional_joint + j] * nsdae_terms_slide_rate(T, j, T->v);
  return power;
}

/* lambda := of least norm with the same Phi_q^T lambda, where constraints are redundant. */
static int least_norm(nsdae_event_account *a, double *lambda)
{
  nsdae_event_setting *s = a->phase->setting;
  if (!*a->phase->modes.redundant || a->phase->crossing.count > 0) return NSDAE_OK;
  int status = nsdae_event_factor(s);
  return status < 0 ? status
                    : nsdae_kkt_least_norm(s->kkt, &s->here->by.jacobian, lambda, a->reaction);
}

int nsdae_event_account_rate(nsdae_event_account *a, double t, const double *z, int integrals,
                             double *rate)
{
  nsdae_event_phase *p = a->phase;
  const nsdae_event_places *at = &p->setting->at;
  double *y = a->y;
  memcpy(y, z, (size_t)at->lambda * sizeof *z);
  int status = nsdae_event_forces(p, t, y);
  if (status == NSDAE_OK) status = nsdae_kinematics_at(p->setting->here, y + at->v, rate);
  if (status == NSDAE_OK && integrals)
    status = nsdae_power_rate(&a->power, p->setting->here, p->x, rate, &rate[at->n + 1]);
  if (status == NSDAE_OK && integrals) rate[at->n + 1] -= leak(p, y);
  if (status == NSDAE_OK && integrals) status = least_norm(a, y + at->lambda);
  if (status < 0) return nsdae_progress_code(status, p->setting->error);
  memcpy(rate + at->v, p->x, (size_t)(at->lambda - at->v) * sizeof *rate);
  if (!integrals) return 0;
  memcpy(rate + at->lambda, y + at->lambda, (size_t)(at->n - at->lambda) * sizeof *rate);
  rate[at->n] = friction_power(p, y);
  linear_forces(p, y, &rate[at->n + 2]);
  return 0;
}

int nsdae_event_account_powers(nsdae_event_account *a, double t, const double *y, double *power)
{
  nsdae_event_phase *p = a->phase;
  const unsigned rubs = NSDAE_TERM_NORMAL | NSDAE_TERM_TANGENT | NSDAE_TERM_SLIDE;
  const nsdae_event_places *at = &p->setting->at;
  memset(power, 0, (size_t)(at->whole - at->n) * sizeof *power);
  if (!(p->terms & rubs)) return 0;
  nsdae_event_move(p->setting, t, y);
  int status = nsdae_terms_need(p->setting->here, p->terms & (rubs | NSDAE_TERM_BIAS));
  if (status < 0) return nsdae_progress_code(status, p->setting->error);
  power[0] = friction_power(p, y);
  linear_forces(p, y, power + 2);
  return 0;
}

void nsdae_event_account_phase(const nsdae_event_account *a, const double *from, const double *to)
{
  const nsdae_event_setting *s = a->phase->setting;
  const nsdae_event_places *at = &s->at;
  const nsdae_dims *d = &s->system->dims;
  nsdae_result *r = s->result;
  nsdae_impulses *sum = &r->impulses;
  nsdae_add_change(d->m, from + at->lambda, to + at->lambda, r->multiplier);
  nsdae_add_change(d->k, from + at->normal, to + at->normal, sum->normal);
  nsdae_add_change(d->k * d->nt, from + at->tangential, to + at->tangential, sum->tangential);
  nsdae_add_change(d->f, from + at->frictional_joint, to + at->frictional_joint,
                   sum->frictional_joint_impulse);
  nsdae_add_change(3 * d->k, from + at->n + 2, to + at->n + 2, sum->linear);
  r->work += to[at->n] - from[at->n];
  r->gain +=
      *a->phase->modes.integrator == NSDAE_INTEGRATOR_IDA ? NAN : to[at->n + 1] - from[at->n + 1];
  r->turnover += fabs(to[at->n + 1] - from[at->n + 1]);
}

void nsdae_event_account_impact(const nsdae_event_account *a, const nsdae_impulses *from,
                                const double *multiplier)
{
  const nsdae_event_setting *s = a->phase->setting;
  const nsdae_dims *d = &s->system->dims;
  nsdae_impulses *to = &s->result->impulses;
  nsdae_add(d->m, 1, multiplier, s->result->multiplier);
  nsdae_add(d->k, 1, from->normal, to->normal);
  nsdae_add(d->k * d->nt, 1, from->tangential, to->tangential);
  nsdae_add(d->f, 1, from->frictional_joint_impulse, to->frictional_joint_impulse);
  nsdae_terms_add_all_linear(s->here, from->normal, from->tangential, to->linear);
}
