/* Impacts: one problem of velocities for all that touch, with Newton's restitution and Coulomb's
 * friction; and the accumulation of impacts of a contact. */
#include <math.h>
#include <string.h>

#include "event_instant.h"
#include "vector.h"

/* What is left of the accumulation of contact i. A contact that comes back with the acceleration -a
 * bounces for 2 v(+) / a, then for e times that, and so on: 2 v(+) / (a (1 - e)) in all, but for
 * what a changes within that time. Infinite where the contact does not come back. */
static double rest_of(const nsdae_event_method *e, int i)
{
  const nsdae_terms *T = nsdae_event_here(e);
  int n = T->system->dims.nv;
  double e_n = T->system->contact[i].e_n;
  double a = -nsdae_dot(n, T->W_N + (size_t)(i * n), e->r + T->system->dims.nq) - T->omega_N[i];
  return a > 0 && e_n < 1 ? -2 * e_n * e->velocity[i] / (a * (1 - e_n)) : INFINITY;
}

/* Keeps the intervals between impacts: an accumulation is recognised where the last two each were
 * shorter than the one before and less is left than matters. */
static void follow_accumulation(nsdae_event_method *e, int i, double t)
{
  double interval = t - e->last[i];
  if (interval == 0) return; /* again in the same instant */
  int shrinks = interval < e->interval[i];
  e->shrunk[i] = shrinks ? e->shrunk[i] + 1 : 0;
  e->interval[i] = interval;
  e->last[i] = t;
  e->rest[i] = e->shrunk[i] >= 2 ? rest_of(e, i) : INFINITY;
  e->settling[i] = e->rest[i] < e->stepper->options->accumulation_time;
}

/* A new record; or, after so many that only one for each contact and the next instant is left, that
 * of the same contact in this instant. */
static nsdae_impact *place_for(nsdae_event_method *e, int i, double t, double velocity_before)
{
  nsdae_result *r = e->result;
  int last = r->impacts - 1, full = r->impacts + 2 * r->end.system->dims.k >= r->impacts_max;
  while (last >= e->first_impact && r->impact[last].contact != i) last--;
  if (full && last >= e->first_impact) return &r->impact[last];
  r->impact[r->impacts] =
      (nsdae_impact){.time = t, .contact = i, .velocity_before = velocity_before};
  return &r->impact[r->impacts++];
}

static void record_impact(nsdae_event_method *e, int i, double t)
{
  nsdae_stepper *s = e->stepper;
  const nsdae_contacts *c = &s->contacts;
  int nt = s->system->dims.nt;
  nsdae_impact *impact = place_for(e, i, e->settling[i] ? t + e->rest[i] : t, e->velocity[i]);
  impact->normal_impulse += c->results->normal[i];
  impact->velocity_after = c->results->after[i];
  impact->accumulation |= e->settling[i];
  for (int l = 0; l < nt; l++) impact->tangential_impulse[l] += c->results->tangential[i * nt + l];
  e->settled += e->settling[i];
}

static void keep_impulses(nsdae_event_method *e, double t)
{
  nsdae_stepper *s = e->stepper;
  const nsdae_contacts *c = &s->contacts;
  const nsdae_dims *d = &s->system->dims;
  for (int i = 0; i < d->m; i++) e->multiplier[i] += s->impulse[i];
  for (int i = 0; i < d->k; i++) {
    e->normal[i] += c->results->normal[i];
    if (c->results->normal[i] > 0) record_impact(e, i, t);
    e->settling[i] = 0;
  }
  for (int j = 0; j < d->k * d->nt; j++) e->tangential[j] += c->results->tangential[j];
  for (int j = 0; j < d->f; j++) e->friction[j] += c->results->slide_impulse[j];
  e->work += nsdae_contacts_work(c);
  e->result->worst_residual = fmax(e->result->worst_residual, c->lcp.info.residual);
}

/* One problem for all that touch. */
static int impact(nsdae_event_method *e, double t)
{
  nsdae_stepper *s = e->stepper;
  nsdae_terms *T = nsdae_event_here(e);
  nsdae_contacts *c = &s->contacts;
  const nsdae_dims *d = &s->system->dims;
  double *v = e->y + d->nq, size = nsdae_event_velocity_size(e, T);
  nsdae_contacts_close_marked(c, e->touching, &e->result->impulses);
  nsdae_contacts_before(c, T, v, 0);
  memset(e->r, 0, (size_t)e->n * sizeof *e->r);
  if (e->ahead >= t) nsdae_dae_interpolate(e->dae, t, 1, e->r); /* v' until now */
  for (int i = 0; i < d->k; i++) {
    if (fabs(c->results->before[i]) <= size)
      c->results->before[i] = 0; /* closed, and beside one that is hit */
    e->velocity[i] = c->results->before[i];
    if (e->touching[i] && c->results->before[i] < 0) follow_accumulation(e, i, t);
    if (e->settling[i]) c->results->before[i] = 0;
  }
  nsdae_stepper_momentum(T->M, v, 0, T->F, d->nv, s->r);
  int status = nsdae_stepper_impact(s, e->result, T, s->r, s->v);
  if (status < 0) return status;
  for (int i = 0; i < d->k; i++)
    if (e->touching[i]) c->results->before[i] = e->velocity[i];
  keep_impulses(e, t);
  memcpy(v, s->v, (size_t)d->nv * sizeof *v);
  nsdae_terms_set_velocity(T, v);
  return nsdae_terms_need(T, NSDAE_EVENT_TERMS);
}

/* Whether contact i touches but for the integrator's error, and does not part. */
int nsdae_event_touches(const nsdae_event_method *e, int i)
{
  const nsdae_terms *T = nsdae_event_here(e);
  const double *v = e->y + T->system->dims.nq;
  return T->gap[i] <= nsdae_event_position_size(e, T) &&
         nsdae_event_normal_velocity(T, i, v) <= nsdae_event_velocity_size(e, T);
}

static int approaching(nsdae_event_method *e)
{
  const nsdae_terms *T = nsdae_event_here(e);
  const double *v = e->y + T->system->dims.nq;
  double size = nsdae_event_velocity_size(e, T);
  for (int i = 0; i < T->system->dims.k; i++)
    if (e->touching[i] && nsdae_event_normal_velocity(T, i, v) < -size) return 1;
  return 0;
}

/* An impact may drive another contact that touches, and parted or rested before it, together: then
 * that is the next, at the same time. A body that just fits between two others, and loses nothing,
 * goes on so for ever: past events_max the step is not the method's any more. */
int nsdae_event_impacts(nsdae_event_method *e, double t, int *any)
{
  int k = e->stepper->system->dims.k, status = NSDAE_OK, left = e->stepper->options->events_max;
  e->first_impact = e->result->impacts;
  for (; status == NSDAE_OK && left > 0 && approaching(e); left--) {
    status = impact(e, t);
    for (int i = 0; i < k && status == NSDAE_OK; i++)
      e->touching[i] = e->mode[i] != NSDAE_MODE_OPEN || nsdae_event_touches(e, i);
    *any = 1;
  }
  e->endless |= status == NSDAE_OK && approaching(e);
  return status;
}
