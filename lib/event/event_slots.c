/* Contacts of a list in slots, as event has them: see tracking.h. */
#include "event_method.h"

void nsdae_event_slots_settle(nsdae_event *e)
{
  int *fresh = e->integrator.tracking.fresh;
  for (int i = 0; e->setting.system->tracked && i < e->setting.system->dims.k; i++) {
    if (!fresh[i]) continue;
    fresh[i] = 0;
    e->base.rattle.last[i] = e->base.rattle.count[i] = 0;
  }
}

/* The tracking with the terms at a point. */
static nsdae_tracking *tracking_at(nsdae_event *e, double t, const double *q, const double *v)
{
  nsdae_tracking *tracking = &e->integrator.tracking;
  nsdae_terms_at(e->setting.here, t, q, v);
  tracking->near = NSDAE_EVENT_NEAR * nsdae_event_position_size(&e->setting);
  return tracking;
}

int nsdae_event_slots_begin(nsdae_event *e, const nsdae_terms *from)
{
  if (!e->setting.system->tracked) return NSDAE_OK;
  int status = nsdae_tracking_begin(tracking_at(e, from->t, from->q, from->v), e->setting.here,
                                    e->integrator.smooth.steps.max_step);
  nsdae_event_slots_settle(e);
  return status;
}

int nsdae_event_slots_add(nsdae_event *e, double t)
{
  const double *y = e->integrator.y;
  if (!e->setting.system->tracked || e->integrator.again) return NSDAE_OK;
  int status = nsdae_tracking_add(tracking_at(e, t, y, y + e->setting.at.v), e->setting.here);
  nsdae_event_open_fresh(&e->integrator);
  nsdae_event_slots_settle(e);
  return status;
}

int nsdae_event_slots_trim(nsdae_event *e, const nsdae_terms *from)
{
  int *keep = e->mode_before, k = e->setting.system->dims.k;
  if (!e->setting.system->tracked) return NSDAE_OK;
  for (int i = 0; i < k; i++)
    keep[i] = e->phase.modes.contact[i] != NSDAE_MODE_OPEN ||
              nsdae_event_root_of(&e->roots, NSDAE_ROOT_NORMAL, i)->found;
  return nsdae_tracking_trim(tracking_at(e, from->t, from->q, from->v), e->setting.here,
                             e->integrator.smooth.steps.max_step, keep);
}

int nsdae_event_slots_anew(void *own, nsdae_terms *at, double h)
{
  return nsdae_tracking_begin_anew(tracking_at(own, at->t, at->q, at->v), at, h);
}

int nsdae_event_slots_show(nsdae_event *e, nsdae_terms *from)
{
  nsdae_result *r = e->setting.result;
  int *needed = e->mode_before;
  if (!e->setting.system->tracked) return NSDAE_OK;
  for (int i = 0; i < e->setting.system->dims.k; i++) needed[i] = nsdae_result_takes_part(r, i);
  return nsdae_tracking_show(&e->integrator.tracking, from, &r->end, needed);
}
