#include "impact.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "cone.h"
#include "errors.h"

/* Slower than so many times what counts as zero, what parts is closed. */
static const double SLOW = 4;

void nsdae_event_impacts_layout(nsdae_event_impacts *p, nsdae_arena *arena)
{
  const nsdae_dims *d = &p->acceleration->phase->setting->system->dims;
  long columns = (long)d->k * (1 + d->nt) + d->f;
  nsdae_contacts_layout(&p->problem, arena);
  double **of_velocity[] = {&p->momentum, &p->v, &p->size, &p->parting, &p->lost};
  for (int i = 0; i < 5; i++) *of_velocity[i] = NSDAE_ARENA_DOUBLES(arena, d->nv);
  p->multiplier = NSDAE_ARENA_DOUBLES(arena, d->m);
  p->velocity = NSDAE_ARENA_DOUBLES(arena, d->k);
  p->after = NSDAE_ARENA_DOUBLES(arena, d->k);
  p->closing = NSDAE_ARENA_DOUBLES(arena, d->k);
  p->force = NSDAE_ARENA_DOUBLES(arena, columns);
  p->xi = NSDAE_ARENA_DOUBLES(arena, columns);
  p->settles = NSDAE_ARENA_INTS(arena, d->k);
  p->records_max = 64 + 2 * d->k;
  p->record = nsdae_arena_take(arena, p->records_max, sizeof *p->record);
}

int nsdae_event_impacts_make(nsdae_event_impacts *p)
{
  const nsdae_event_setting *s = p->acceleration->phase->setting;
  p->law = calloc((size_t)s->system->dims.k + 1, sizeof *p->law);
  if (!p->law) return NSDAE_E_MEMORY;
  p->problem.system = s->system;
  p->problem.error = s->error;
  p->problem.law = p->law;
  nsdae_lcp_options_default(&p->problem.lcp_options);
  p->problem.lcp_options.tol = s->options->lcp_tol;
  nsdae_contacts_laws(&p->problem, s->options->polygon);
  return NSDAE_OK;
}

void nsdae_event_impacts_release(nsdae_event_impacts *p)
{
  free(p->law);
}

int nsdae_event_touches(const nsdae_event_setting *s, int i)
{
  const nsdae_terms *T = s->here;
  return T->gap[i] <= nsdae_event_position_size(s) &&
         nsdae_terms_rate(T, T->W_N, T->w_N, i, T->v) <= nsdae_event_velocity_size(s);
}

/* v+ of the momentum before, with v-_N of the contacts: M v + Phi_q^T Lambda = M v- + W Lambda_c,
 * Phi_q v = -Phi_t. */
static int solve(nsdae_event_impacts *p)
{
  nsdae_event_setting *s = p->acceleration->phase->setting;
  const nsdae_dims *d = &s->system->dims;
  size_t size = (size_t)d->nv * sizeof *p->v;
  memcpy(p->v, p->momentum, size);
  memcpy(p->size, p->momentum, size);
  for (int i = 0; i < d->m; i++) p->multiplier[i] = -s->here->phi_t[i];
  nsdae_kkt_solve(s->kkt, 1, p->v, d->nv, p->multiplier, d->m);
  nsdae_kkt_solve_mass(s->kkt, p->size);
  int status = nsdae_event_solve(s, &p->problem, s->here, p->size, p->v, p->multiplier);
  if (status == NSDAE_OK)
    nsdae_event_solve_cones(&p->problem, p->acceleration->phase->modes.direction, p->force, p->xi,
                            p->v, p->multiplier);
  return status;
}

/* The contacts' velocities before, zero where the integrator's errors could be all of it. */
static void approach(nsdae_event_impacts *p)
{
  double size = nsdae_event_velocity_size(p->acceleration->phase->setting);
  for (int i = 0; i < p->problem.system->dims.k; i++)
    p->problem.before[i] = fabs(p->velocity[i]) <= size ? 0 : p->velocity[i];
}

/* How fast what contact i can be closed with may be: what it gains or loses in accumulation_time
 * by the accelerations there are. */
static double slow_for(const nsdae_event_impacts *p, int i)
{
  const nsdae_event_setting *s = p->acceleration->phase->setting;
  const nsdae_terms *T = s->here;
  int n = T->system->dims.nv;
  double rate = fabs(T->omega_N[i]);
  for (int j = 0; j < n; j++) rate += fabs(T->W_N[i * n + j] * p->size[j]);
  return fmax(SLOW * nsdae_event_velocity_size(s), s->options->accumulation_time * rate);
}

/* Contacts that touch, or have just left, and part slowly, as candidates; how many do part. */
static int choose_slow(nsdae_event_impacts *p)
{
  nsdae_event_setting *s = p->acceleration->phase->setting;
  const nsdae_dims *d = &s->system->dims;
  const nsdae_event_findings *is = &p->acceleration->is;
  const nsdae_terms *T = s->here;
  int part = 0;
  memcpy(p->size, s->here->F, (size_t)d->nv * sizeof *p->size);
  nsdae_kkt_solve_mass(s->kkt, p->size);
  for (int i = 0; i < d->k; i++) {
    int near = is->touching[i] || T->gap[i] <= nsdae_event_position_size(s);
    p->after[i] = nsdae_terms_rate(T, T->W_N, T->w_N, i, p->v);
    is->candidate[i] = near && p->after[i] <= slow_for(p, i);
    part += is->candidate[i] && p->after[i] > nsdae_event_velocity_size(s);
  }
  return part;
}

/* d^T M d / 2 */
static double energy_of(const nsdae_terms *T, const double *d)
{
  int n = T->system->dims.nv;
  double twice = 0;
  for (int j = 0; j < n; j++) twice += d[j] * nsdae_dot(n, T->M + (size_t)(j * n), d);
  return twice / 2;
}

/* T, with v_c in v and v+ in parting; and whether all that parts is slow. */
static double rest_of(nsdae_event_impacts *p, const double *before, int *slow)
{
  const nsdae_event_setting *s = p->acceleration->phase->setting;
  const nsdae_terms *T = s->here;
  double power = 0, height = 0, size = SLOW * nsdae_event_velocity_size(s);
  *slow = 1;
  for (int i = 0; i < T->system->dims.nv; i++) {
    p->parting[i] -= p->v[i];
    p->lost[i] = before[i] - p->v[i];
  }
  for (int i = 0; i < T->system->dims.k; i++) {
    if (!p->settles[i]) continue;
    power += p->acceleration->problem.normal[i] * p->after[i];
    height += p->acceleration->problem.normal[i] * fmax(T->gap[i], 0);
    *slow &= p->after[i] <= size;
  }
  double left = energy_of(T, p->parting) + height, q = left / (energy_of(T, p->lost) + height);
  return q < 1 && power > 0 ? 4 * left / (power * (1 - sqrt(q))) : INFINITY;
}

/* With e_N = 0 some of the set may still part, as others push them; what follows pushes back. */
static int close_set(nsdae_event_impacts *p)
{
  const nsdae_terms *T = p->acceleration->phase->setting->here;
  for (int i = 0; i < T->system->dims.k; i++)
    p->problem.after[i] = nsdae_terms_rate(T, T->W_N, T->w_N, i, p->v);
  int status = nsdae_event_close(p->projection, p->settles, p->v, p->multiplier, p->closing);
  p->closing_work = nsdae_dot(T->system->dims.k, p->closing, p->problem.after) / 2;
  return status;
}

/* Whether this impact is the first of an accumulation that ends now: then the solution is that with
 * the set closed; else it is as before. before [nv] is v-. */
static int settle(nsdae_event_impacts *p, const double *before)
{
  nsdae_event_setting *s = p->acceleration->phase->setting;
  const nsdae_contacts *held = &p->acceleration->problem;
  int k = s->system->dims.k, any = 0, slow;
  if (choose_slow(p) == 0) return NSDAE_OK;
  memcpy(p->parting, p->v, (size_t)s->system->dims.nv * sizeof *p->v);
  nsdae_terms_set_velocity(s->here, p->v);
  int status = nsdae_terms_need(s->here, NSDAE_EVENT_TERMS);
  if (status < 0) return status;
  nsdae_event_set_laws(p->acceleration, 1);
  int solved = nsdae_event_accelerate(p->acceleration) == NSDAE_OK;
  nsdae_error_clear(s->error);
  for (int i = 0; i < k; i++) {
    p->settles[i] = solved && p->acceleration->is.candidate[i] && held->normal[i] > 0;
    if (p->settles[i]) p->problem.before[i] = 0;
    any |= p->settles[i];
  }
  if (!any) return NSDAE_OK;
  status = solve(p);
  if (status == NSDAE_OK) status = close_set(p);
  if (status < 0) return status;
  p->rest = rest_of(p, before, &slow);
  if (p->rest < s->options->accumulation_time) return NSDAE_OK;
  p->rest = 0; /* closed now, before it would end */
  if (slow) return NSDAE_OK;
  memset(p->settles, 0, (size_t)k * sizeof *p->settles);
  memset(p->closing, 0, (size_t)k * sizeof *p->closing);
  p->closing_work = 0;
  approach(p);
  return solve(p);
}

/* A new record; or, after so many that only one for each contact and the next instant is left, that
 * of the same contact in this instant. In order of time: the end of an accumulation comes later. */
static nsdae_impact *place_for(nsdae_event_impacts *p, int contact, double t)
{
  int last = p->records - 1, at = p->records;
  int full = p->records + 2 * p->problem.system->dims.k >= p->records_max;
  while (full && last >= 0 && (p->record[last].contact != contact || p->record[last].time != t))
    last--;
  if (full && last >= 0) return &p->record[last];
  for (; at > 0 && p->record[at - 1].time > t; at--) p->record[at] = p->record[at - 1];
  p->records++;
  p->record[at] =
      (nsdae_impact){.time = t, .contact = contact, .velocity_before = p->velocity[contact]};
  return &p->record[at];
}

static void record(nsdae_event_impacts *p, int i)
{
  const nsdae_contacts *c = &p->problem;
  int nt = c->system->dims.nt;
  int ends = p->settles[i];
  double t = p->acceleration->phase->setting->here->t;
  nsdae_impact *impact = place_for(p, i, ends ? t + p->rest : t);
  impact->normal_impulse += c->normal[i] + p->closing[i];
  impact->velocity_after = ends ? 0 : c->after[i];
  impact->accumulation |= ends;
  for (int l = 0; l < nt; l++) impact->tangential_impulse[l] += c->tangential[i * nt + l];
}

/* One problem for all that touch. */
static int impact(nsdae_event_impacts *p, double *y)
{
  nsdae_event_setting *s = p->acceleration->phase->setting;
  nsdae_terms *T = s->here;
  nsdae_contacts *c = &p->problem;
  const nsdae_dims *d = &s->system->dims;
  double *v = y + s->at.v;
  nsdae_contacts_close_marked(c, p->acceleration->is.touching);
  nsdae_contacts_before(c, T, v, 0);
  memcpy(p->velocity, c->before, (size_t)d->k * sizeof *p->velocity);
  memset(p->settles, 0, (size_t)d->k * sizeof *p->settles);
  memset(p->closing, 0, (size_t)d->k * sizeof *p->closing);
  p->closing_work = 0;
  memset(p->momentum, 0, (size_t)d->nv * sizeof *p->momentum);
  nsdae_add_product(d->nv, d->nv, T->M, v, p->momentum);
  approach(p);
  int status = solve(p), ends = 0;
  if (status == NSDAE_OK) status = settle(p, v);
  if (status < 0) return status;
  memcpy(c->before, p->velocity, (size_t)d->k * sizeof *c->before);
  nsdae_event_account_impact(p->account, c, p->multiplier);
  p->account->work += p->closing_work;
  for (int i = 0; i < d->k; i++) {
    ends |= p->settles[i];
    p->account->normal[i] += p->closing[i];
    if (c->normal[i] > 0 && c->normal[i] + p->closing[i] > 0) record(p, i);
  }
  p->accumulations += ends;
  memcpy(v, p->v, (size_t)d->nv * sizeof *v);
  nsdae_terms_set_velocity(T, v);
  return nsdae_terms_need(T, NSDAE_EVENT_TERMS);
}

static int approaching(const nsdae_event_impacts *p)
{
  const nsdae_event_setting *s = p->acceleration->phase->setting;
  const nsdae_terms *T = s->here;
  for (int i = 0; i < T->system->dims.k; i++)
    if (p->acceleration->is.touching[i] &&
        nsdae_terms_rate(T, T->W_N, T->w_N, i, T->v) < -nsdae_event_velocity_size(s))
      return 1;
  return 0;
}

/* An impact may drive another contact that touches, and parted or rested before it, together: then
 * that is the next, at the same time. A body that just fits between two others, and loses nothing,
 * goes on so for ever: past events_max the step is not the method's any more. */
int nsdae_event_collide(nsdae_event_impacts *p, double *y)
{
  const nsdae_event_setting *s = p->acceleration->phase->setting;
  int *touching = p->acceleration->is.touching, *mode = p->acceleration->phase->modes.contact;
  int count = 0;
  while (approaching(p) && count < s->options->events_max) {
    int status = impact(p, y);
    if (status < 0) return status;
    for (int i = 0; i < s->system->dims.k; i++)
      touching[i] = mode[i] != NSDAE_MODE_OPEN || nsdae_event_touches(s, i);
    count++;
  }
  p->endless |= approaching(p);
  return count;
}
