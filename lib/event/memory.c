#include <string.h>

#include "event_method.h"

/* Contacts of a list in slots, as event has them: see tracking.h. */

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
  int status = nsdae_tracking_show(&e->integrator.tracking, from, &r->end, needed);
  for (int i = 0; i < e->setting.system->dims.k && status == NSDAE_OK; i++)
    if (!e->integrator.tracking.seen[i]) r->impulses.mode[i] = NSDAE_MODE_OPEN;
  return status;
}

/* Base and modes, behind the warm start of implicit, which may step in. */
static void lay(nsdae_event_base *b, nsdae_event_modes *m, nsdae_tracking *tracking,
                const nsdae_stepper *s, nsdae_memory_part *part)
{
  const nsdae_dims *d = &s->system->dims;
  size_t nt = (size_t)d->nt, f = (size_t)d->f;
  int **of_slide[] = {&m->frictional_joint, &m->slide_sense, &m->normal_sense, &m->slide_row};
  int **of_one[] = {&m->redundant, &b->steps, &b->instants, &b->idle, &b->tiny, &m->integrator};
  for (int i = 0; i < 2; i++) b->basis[i] = nsdae_stepper_lay_basis(s, part);
  m->contact = nsdae_memory_wholes(part, NSDAE_BY_SLOT(1));
  b->rattle.count = nsdae_memory_wholes(part, NSDAE_BY_SLOT(1));
  for (int i = 0; i < 4; i++) *of_slide[i] = nsdae_memory_wholes(part, NSDAE_OF_ALL(f));
  m->related = nsdae_memory_wholes(part, NSDAE_BY_SLOT(1 + nt));
  for (int i = 0; i < 6; i++) *of_one[i] = nsdae_memory_wholes(part, NSDAE_OF_ALL(1));
  b->finer = nsdae_memory_wholes(part, NSDAE_OF_ALL(2));
  b->difference_error = nsdae_memory_reals(part, NSDAE_OF_ALL(2));
  m->slide_part = nsdae_memory_reals(part, NSDAE_OF_ALL(f));
  m->relation = nsdae_memory_reals(part, NSDAE_BY_PAIR((1 + nt) * (1 + nt)));
  m->basis = nsdae_memory_reals(part, NSDAE_OF_ALL((size_t)nsdae_kkt_basis_size(&s->kkt)));
  b->y = nsdae_memory_reals(part, NSDAE_OF_ALL((size_t)d->nq + (size_t)d->nv));
  b->direction = nsdae_memory_reals(part, NSDAE_BY_SLOT(nt));
  b->blur = nsdae_memory_reals(part, NSDAE_BY_SLOT(1));
  b->rattle.last = nsdae_memory_reals(part, NSDAE_BY_SLOT(1));
  double **real[] = {&b->t, &b->slow, &b->none, &b->goal, &b->h};
  for (int i = 0; i < 5; i++) *real[i] = nsdae_memory_reals(part, NSDAE_OF_ALL(1));
  b->late = nsdae_memory_wholes(part, NSDAE_BY_SLOT(s->system->tracked != NULL));
  if (s->system->tracked) nsdae_tracking_lay(tracking, s->system, part);
}

void nsdae_event_memory_lay(const nsdae_stepper *s, nsdae_memory_part *part)
{
  nsdae_event_base base;
  nsdae_event_modes modes;
  nsdae_tracking tracking;
  lay(&base, &modes, &tracking, s, part);
}

void nsdae_event_lay(nsdae_event_base *b, nsdae_event_instant *p, nsdae_tracking *tracking,
                     const nsdae_stepper *s, nsdae_memory *memory)
{
  nsdae_memory_part part = {
      .real = memory->real, .whole = memory->whole, .slots = (size_t)s->system->dims.k};
  lay(b, &p->roots->phase->modes, tracking, s, &part);
  nsdae_contacts_remember(&p->impacts.problem, b->basis[0]);
  nsdae_contacts_remember(&p->acceleration.problem, b->basis[1]);
}

void nsdae_event_save(nsdae_event_base *b, const nsdae_event_integrator *g, double t)
{
  const nsdae_event_phase *p = g->roots->phase;
  const nsdae_dims *d = &p->setting->system->dims;
  size_t n = (size_t)p->setting->at.lambda, kt = (size_t)d->k * (size_t)d->nt;
  *b->t = t;
  if (p->setting->system->tracked) memset(b->late, 0, (size_t)d->k * sizeof *b->late);
  *b->steps = 0;
  *b->h = g->smooth.steps.h;
  *b->slow = p->modes.slow;
  *b->none = p->modes.none;
  memcpy(b->blur, p->modes.blur, (size_t)d->k * sizeof *b->blur);
  memcpy(b->y, g->y, n * sizeof *b->y);
  memcpy(b->direction, p->modes.direction, kt * sizeof *b->direction);
  /* What a slot keeps is of the contact in it: without one, zeros, as in a slot that was never
   * used. (A direction is zero when the slot is used again: nsdae_event_open_fresh.) */
  const nsdae_system *s = p->setting->system;
  const nsdae_tracked *tracked = s->tracked;
  for (int i = 0; tracked && i < s->dims.k; i++) {
    if (tracked->used[i]) continue;
    b->blur[i] = b->rattle.last[i] = b->rattle.count[i] = 0;
  }
}

void nsdae_event_restore(const nsdae_event_base *b, nsdae_event_integrator *g)
{
  nsdae_event_phase *p = g->roots->phase;
  const nsdae_dims *d = &p->setting->system->dims;
  size_t n = (size_t)p->setting->at.lambda, kt = (size_t)d->k * (size_t)d->nt;
  p->modes.slow = *b->slow;
  g->smooth.steps.h = *b->h;
  p->modes.none = *b->none;
  memcpy(p->modes.blur, b->blur, (size_t)d->k * sizeof *b->blur);
  memcpy(g->y, b->y, n * sizeof *b->y);
  memcpy(p->modes.direction, b->direction, kt * sizeof *b->direction);
}
