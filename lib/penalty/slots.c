/* Contacts of a list in slots: which are near, and what is known of a new one. An open contact has
 * no force, so that a step remains right whichever of them have slots. */
#include "penalty.h"

#include <math.h>
#include <string.h>

/* The terms at t in the last step, for the contacts that are tracked in it. */
static int look_at(double t, nsdae_terms **terms, void *user)
{
  nsdae_penalty *p = user;
  double *qv = p->equations.room;
  *terms = &p->equations.stepper->middle;
  int status = nsdae_penalty_read(p, t, qv);
  nsdae_terms_at(*terms, t, qv, qv + nsdae_penalty_dims(p)->nq);
  return status;
}

void nsdae_penalty_slots_layout(nsdae_penalty *p, nsdae_arena *arena)
{
  const nsdae_stepper *s = p->equations.stepper;
  p->slots.tracking = (nsdae_tracking){.model = s->system,
                                       .table = s->system->tracked,
                                       .error = s->error,
                                       .look = look_at,
                                       .user = p};
  p->slots.keep = NSDAE_ARENA_INTS(arena, s->system->dims.k);
  if (s->system->tracked) nsdae_tracking_layout(&p->slots.tracking, arena);
}

/* Contacts that got a slot are open, and nothing is known of them. */
static void take_fresh(nsdae_penalty *p)
{
  const nsdae_penalty_base *b = &p->equations.base;
  size_t nt = (size_t)nsdae_penalty_dims(p)->nt;
  for (int i = 0; i < nsdae_penalty_dims(p)->k; i++) {
    if (!p->slots.tracking.fresh[i]) continue;
    b->closed[i] = p->gaps.found[i] = p->slots.tracking.fresh[i] = 0;
    b->since[i] = b->mass[i] = b->impulse[i] = b->peak[i] = 0;
    memset(b->impulse_t + (size_t)i * nt, 0, nt * sizeof *b->impulse_t);
    b->start_rate[i] = 1;
    p->gaps.shift[i] = p->force[i] = p->peak[i] = 0;
  }
}

/* The table is that of the memory. */
void nsdae_penalty_slots_keep(const nsdae_penalty *p, nsdae_memory *memory)
{
  if (!nsdae_penalty_is_tracked(p)) return;
  nsdae_tracking_store(&p->slots.tracking);
  memory->slots = nsdae_system_contacts(p->equations.stepper->system);
}

/* Within which contacts close and open: as far as a zero is moved, and rounding. One that overlaps
 * may go on with another id, as where a corner leaves an edge, at a depth up to twice that. */
static double near(const nsdae_penalty *p, const nsdae_terms *at)
{
  double most = fmax(nsdae_terms_touch(at), 2 * p->gaps.depth);
  for (int i = 0; i < nsdae_penalty_dims(p)->k; i++) most = fmax(most, fabs(p->gaps.shift[i]));
  return most;
}

/* Terms at the start of a motion, or of a dt. */
static nsdae_terms *terms_at(nsdae_penalty *p, const nsdae_terms *from)
{
  nsdae_terms *T = &p->equations.stepper->middle;
  nsdae_terms_at(T, from->t, from->q, from->v);
  p->slots.tracking.near = near(p, from);
  return T;
}

/* Those near the start of a run. */
int nsdae_penalty_slots_begin(nsdae_penalty *p, const nsdae_terms *from)
{
  if (!nsdae_penalty_is_tracked(p)) return NSDAE_OK;
  int status =
      nsdae_tracking_begin(&p->slots.tracking, terms_at(p, from), p->integrator.steps.max_step);
  take_fresh(p);
  return status;
}

/* Those near the start of a dt keep their slots: so do those that are closed or about to close, and
 * those whose zero is moved. */
int nsdae_penalty_slots_trim(nsdae_penalty *p, const nsdae_terms *from)
{
  if (!nsdae_penalty_is_tracked(p)) return NSDAE_OK;
  for (int i = 0; i < nsdae_penalty_dims(p)->k; i++)
    p->slots.keep[i] = p->equations.base.closed[i] || (p->gaps.pending && p->gaps.found[i]) ||
                       p->gaps.shift[i] != 0;
  return nsdae_tracking_trim(&p->slots.tracking, terms_at(p, from), p->integrator.steps.max_step,
                             p->slots.keep);
}

/* Those near the step from `from`. A replay has those of then, of which its gaps are known from the
 * start: so none are kept from the step before. */
int nsdae_penalty_slots_cover(nsdae_penalty *p, double from)
{
  if (!nsdae_penalty_is_tracked(p)) return NSDAE_OK;
  nsdae_dip_start(&p->gaps.dip);
  p->slots.tracking.near = near(p, &p->equations.stepper->middle);
  int added = p->slots.replays ? 0 : nsdae_tracking_cover(&p->slots.tracking, from, p->ahead);
  if (added > 0) take_fresh(p);
  return added < 0 ? added : NSDAE_OK;
}

/* Those that close at `ahead`, each listed in time. What is closed there may have become deeper in
 * the step, and may just have left its feature: its depth is that just before. */
int nsdae_penalty_slots_close(nsdae_penalty *p, double from)
{
  nsdae_tracking *tracking = &p->slots.tracking;
  if (!nsdae_penalty_is_tracked(p) || p->slots.replays) return NSDAE_OK;
  for (int i = 0; i < nsdae_penalty_dims(p)->k; i++) {
    int closed = p->equations.base.closed[i];
    tracking->closes[i] = p->gaps.found[i] && !closed;
    if (!closed) continue;
    tracking->near = fmax(tracking->near, 2 * (p->gaps.fall.low[i] - p->gaps.shift[i]));
  }
  return nsdae_tracking_close(tracking, from, p->ahead);
}

/* The gaps of a step by slots: at its start those of the contacts that have them now, at its end
 * those of all that did something in it. */
int nsdae_penalty_slots_show(nsdae_penalty *p, nsdae_terms *from, nsdae_result *result)
{
  if (!nsdae_penalty_is_tracked(p)) return NSDAE_OK;
  for (int i = 0; i < nsdae_penalty_dims(p)->k; i++)
    p->slots.keep[i] = nsdae_result_takes_part(result, i);
  return nsdae_tracking_show(&p->slots.tracking, from, &result->end, p->slots.keep);
}

int nsdae_penalty_slots_anew(void *own, nsdae_terms *at, double h)
{
  nsdae_penalty *p = own;
  terms_at(p, at);
  return nsdae_tracking_begin_anew(&p->slots.tracking, at, h);
}
