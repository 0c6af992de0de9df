/* Where the integrator starts, at contacts that close and open: see penalty.c. */
#include <math.h>
#include <string.h>

#include "errors.h"
#include "penalty.h"
#include "vector.h"

/* Contacts of a list in slots: which are near, and what is known of a new one. An open contact has
 * no force, so that a step remains right whichever of them have slots. */

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
static int slots_begin(nsdae_penalty *p, const nsdae_terms *from)
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

/* Of IDA's last step the first one after a new start. */
static const double FIRST = 0.1;

/* Whether the law has a force for contact i. */
int nsdae_penalty_check_law(const nsdae_stepper *s, const char *where, int i)
{
  int flores = s->options->penalty_law == NSDAE_PENALTY_FLORES;
  if (!flores || s->system->contact[i].e_n > 0) return NSDAE_OK;
  nsdae_error_set(s->error, NSDAE_E_ARGUMENT, where, "e_n",
                  "e_n = 0 is outside its range: the law flores needs it greater than 0");
  nsdae_system_name_item(s->system, NSDAE_NAME_CONTACT, i, s->error);
  return NSDAE_E_ARGUMENT;
}

/* The velocity of the largest change at t, in units of its tolerance; -1: the equations have no
 * solution there, as the error record says. */
static int fastest(nsdae_penalty *p, double t)
{
  const nsdae_sim_options *o = p->equations.stepper->options;
  const double *v = p->qv + nsdae_penalty_dims(p)->nq;
  double *rate = p->z[0], most = 0;
  int found = -1;
  if (nsdae_penalty_rate(t, p->qv, rate, 0, &p->equations) != 0) return -1;
  for (int i = 0; i < nsdae_penalty_dims(p)->nv; i++) {
    double change = fabs(rate[nsdae_penalty_dims(p)->nq + i]) / (o->rtol * fabs(v[i]) + o->atol);
    if (change > most) most = change, found = i;
  }
  return found;
}

int nsdae_penalty_failed(nsdae_penalty *p, int status, double t)
{
  nsdae_stepper *s = p->equations.stepper;
  const char *cause = p->integrator.cause;
  if (status == NSDAE_ARRAYS_GROW) return status;
  if (s->error->status != NSDAE_OK) return s->error->status;
  int velocity = fastest(p, t);
  if (s->error->status != NSDAE_OK) return s->error->status;          /* no solution there */
  status = status == NSDAE_E_CALLBACK ? NSDAE_E_CONVERGENCE : status; /* none failed */
  nsdae_error_set(s->error, status, "nsdae_penalty", "rtol",
                  "the integrator failed at t = %g: no step length satisfies rtol and atol%s%s: "
                  "try a larger rtol or a smaller penalty_stiffness%s",
                  nsdae_system_time(s->system, t), *cause ? ", reason of SUNDIALS: " : "", cause,
                  velocity < 0 ? "" : "; fastest change");
  s->error->time = nsdae_system_time(s->system, t);
  if (velocity >= 0) nsdae_system_name_item(s->system, NSDAE_NAME_VELOCITY, velocity, s->error);
  return status;
}

/* The largest force applied, or what would stop the bodies in a dt. */
static double force_of(const nsdae_penalty *p)
{
  nsdae_stepper *s = p->equations.stepper;
  const nsdae_terms *T = &s->middle;
  int n = nsdae_penalty_dims(p)->nv;
  memset(s->r, 0, (size_t)n * sizeof *s->r);
  nsdae_blocks_add_product(&s->system->blocks, T->M, T->v, s->r);
  return fmax(nsdae_largest(n, T->F), nsdae_largest(n, s->r) / s->options->dt);
}

/* The integrator starts at qv and the base's t. Within rounding of zero a gap can have the wrong
 * sign for its contact, and would cross zero again at once, without an end: it is looked at from
 * where it has twice that. */
int nsdae_penalty_start_integrator(nsdae_penalty *p)
{
  const nsdae_penalty_base *b = &p->equations.base;
  nsdae_stepper *s = p->equations.stepper;
  const double hair = 1e-12 * s->options->dt * s->options->friction_velocity;
  nsdae_terms *T = &s->middle;
  p->ahead = *b->t;
  p->gaps.pending = 0;
  nsdae_smooth_set(&p->integrator, *b->is_stiff ? NSDAE_INTEGRATOR_IDA : s->options->integrator);
  p->integrator.first = p->integrator.steps.h = *b->first;
  nsdae_error_clear(s->error);
  nsdae_power_start(&p->equations.power);
  nsdae_dip_start(&p->gaps.dip);
  int status = nsdae_penalty_evaluate(&p->equations, p->ahead, p->qv);
  if (status == NSDAE_OK) status = nsdae_terms_need(T, NSDAE_TERM_MASS | NSDAE_TERM_FORCE);
  if (status < 0) return status;
  p->integrator.steps.force = force_of(p);
  memcpy(p->force, p->equations.at.normal, (size_t)nsdae_penalty_dims(p)->k * sizeof *p->force);
  p->gaps.depth = 0;
  for (int i = 0; i < nsdae_penalty_dims(p)->k; i++) {
    double gap = T->gap[i];
    if (b->closed[i]) p->gaps.depth = fmax(p->gaps.depth, -gap);
    int wrong = b->closed[i] ? gap >= 0 : gap <= 0;
    p->gaps.shift[i] = wrong ? 2 * gap + (b->closed[i] ? hair : -hair) : 0;
  }
  status = nsdae_smooth_start(&p->integrator, p->ahead, p->qv);
  if (status < 0) return nsdae_penalty_failed(p, status, p->ahead);
  const nsdae_counters counted = *s->counters; /* a start is no work of the step */
  status = nsdae_terms_need(T, NSDAE_TERM_MASS | NSDAE_TERM_JACOBIAN);
  if (status == NSDAE_OK) status = nsdae_stepper_factor(s, T, T->M);
  *s->counters = counted;
  if (status < 0) return status;
  p->equations.rank = s->kkt.rank; /* IDA starts at the point of the last factorisation */
  if (s->kkt.rank < s->kkt.m) nsdae_kkt_basis(&s->kkt, p->equations.basis);
  return NSDAE_OK;
}

/* The base is at t, where q and v are qv, from the last one on. */
int nsdae_penalty_move_base(nsdae_penalty *p, double t)
{
  nsdae_penalty_base *b = &p->equations.base;
  const nsdae_dims *d = nsdae_penalty_dims(p);
  double *z = p->z[0];
  if (*b->steps > 0) {
    const nsdae_smooth *g = &p->integrator;
    double within = fmax(g->from, fmin(t, g->to));
    int status = nsdae_smooth_read(&p->integrator, within, nsdae_penalty_at(d).size, z);
    if (status < 0) return status;
    nsdae_add(d->k, 1, z + nsdae_penalty_at(d).normal, b->impulse);
    nsdae_add(d->k * d->nt, 1, z + nsdae_penalty_at(d).tangential, b->impulse_t);
    *b->first = g->is_stiff ? FIRST * (g->to - g->from) : g->steps.h;
  }
  *b->t = t;
  *b->steps = 0;
  memcpy(b->qv, p->qv, (size_t)(d->nq + d->nv) * sizeof *b->qv);
  memcpy(b->peak, p->peak, (size_t)d->k * sizeof *b->peak);
  return NSDAE_OK;
}

/* The integrator starts anew from here: that is the base from now on. */
int nsdae_penalty_start(nsdae_penalty *p, double t, int stiff)
{
  int status = nsdae_penalty_move_base(p, t);
  /* The integrator from here on: IDA as long as a contact is closed that has made the
   * equations stiff. */
  int by_option = p->equations.stepper->options->integrator, any = 0;
  for (int i = 0; i < nsdae_penalty_dims(p)->k; i++) any |= p->equations.base.closed[i];
  *p->equations.base.is_stiff = by_option == NSDAE_INTEGRATOR_IDA ||
                                (by_option == NSDAE_INTEGRATOR_AUTO && p->integrator.ida &&
                                 (stiff || (p->integrator.is_stiff && any)));
  return status < 0 ? status : nsdae_penalty_start_integrator(p);
}

/* A contact closes here: its d'_0, its effective mass 1 / (W_N^T P W_N). */
static int close_contact(nsdae_penalty *p, int i, double t)
{
  nsdae_stepper *s = p->equations.stepper;
  nsdae_terms *T = &s->middle;
  const nsdae_dims *d = nsdae_penalty_dims(p);
  nsdae_penalty_base *b = &p->equations.base;
  int status = nsdae_penalty_check_law(s, "nsdae_penalty", i);
  if (status == NSDAE_OK) status = nsdae_terms_need(T, NSDAE_TERM_MASS | NSDAE_TERM_JACOBIAN);
  if (status == NSDAE_OK) status = nsdae_stepper_factor(s, T, T->M);
  if (status < 0) return status;
  memset(s->r, 0, (size_t)d->nv * sizeof *s->r);
  memset(s->impulse, 0, (size_t)d->m * sizeof *s->impulse);
  nsdae_rows_add(&s->system->blocks, &T->by.normal, i, 1, s->r);
  status = nsdae_terms_solve(T, &s->kkt, 1, s->r, s->impulse);
  if (status < 0) return status;
  double inverse = nsdae_rows_dot(&s->system->blocks, &T->by.normal, i, s->r);
  b->mass[i] = inverse > 0 ? 1 / inverse : 0;
  b->closed[i] = 1;
  b->since[i] = t;
  b->start_rate[i] = fmax(-nsdae_terms_normal_rate(T, i, T->v), s->options->friction_velocity);
  b->impulse[i] = 0;
  memset(b->impulse_t + (size_t)i * (size_t)d->nt, 0, (size_t)d->nt * sizeof *b->impulse_t);
  p->peak[i] = 0;
  return NSDAE_OK;
}

static void open_contact(nsdae_penalty *p, nsdae_result *result, int i)
{
  const nsdae_dims *d = nsdae_penalty_dims(p);
  const nsdae_penalty_base *b = &p->equations.base;
  b->closed[i] = 0;
  if (!(b->start_rate[i] > p->equations.stepper->options->impact_velocity)) return;
  nsdae_impact *impact = &result->impact[result->impacts++];
  *impact = (nsdae_impact){.time = nsdae_system_time(p->equations.stepper->system, b->since[i]),
                           .contact = i,
                           .velocity_before = -b->start_rate[i],
                           .normal_impulse = b->impulse[i],
                           .velocity_after = p->equations.at.v_n[i],
                           .peak_force = p->peak[i],
                           .id = i,
                           .block = {-1, -1}};
  for (int l = 0, j = i * d->nt; l < d->nt; l++, j++)
    impact->tangential_impulse[l] = b->impulse_t[j];
}

/* Gaps that crossed zero: contacts begin and end, and the integrator starts anew. A gap within its
 * rounding crosses zero any number of times: a contact opens while it moves apart alone, and closes
 * while it does not. One that is no longer listed has opened; one that was not before closes
 * wherever it is, as another feature of two bodies. */
int nsdae_penalty_switch_contacts(nsdae_penalty *p, nsdae_result *result, double t)
{
  int status = nsdae_penalty_move_base(p, t);
  if (status == NSDAE_OK) status = nsdae_penalty_evaluate(&p->equations, t, p->qv);
  for (int i = 0; i < nsdae_penalty_dims(p)->k && status == NSDAE_OK; i++) {
    double v_n = p->equations.at.v_n[i];
    int closed = p->equations.base.closed[i];
    int near = p->equations.stepper->middle.gap[i] < NSDAE_FAR;
    int appears = nsdae_penalty_is_tracked(p) && p->gaps.fall.low[i] >= NSDAE_FAR;
    if (!p->gaps.found[i]) continue;
    if (closed && (v_n > 0 || !near))
      open_contact(p, result, i);
    else if (!closed && (v_n <= 0 || appears) && near)
      status = close_contact(p, i, t);
  }
  return status < 0 ? status : nsdae_penalty_start(p, t, 0);
}

/* How near a contact is at hand that moves with v_n: less than a billionth of dt away. */
static double reach(const nsdae_penalty *p, int i)
{
  return fmax(-p->equations.at.v_n[i], 0) * 1e-9 * p->equations.stepper->options->dt;
}

/* From a state that this method did not lead to. */
int nsdae_penalty_begin(nsdae_penalty *p, const nsdae_terms *from)
{
  const nsdae_dims *d = nsdae_penalty_dims(p);
  nsdae_penalty_base *b = &p->equations.base;
  memcpy(p->qv, from->q, (size_t)d->nq * sizeof *p->qv);
  memcpy(p->qv + d->nq, from->v, (size_t)d->nv * sizeof *p->qv);
  *b->steps = *b->is_stiff = p->integrator.is_stiff = 0;
  *b->first = 0;
  for (int i = 0; i < d->k; i++) b->closed[i] = 0, b->start_rate[i] = 1;
  for (int i = 0; i < d->k; i++) p->gaps.shift[i] = 0; /* nothing of a run before */
  p->gaps.pending = 0;
  p->gaps.depth = 0;
  int status = slots_begin(p, from);
  if (status == NSDAE_OK) status = nsdae_penalty_evaluate(&p->equations, from->t, p->qv);
  for (int i = 0; i < d->k && status == NSDAE_OK; i++)
    if (p->equations.stepper->middle.gap[i] <= reach(p, i)) status = close_contact(p, i, from->t);
  return status < 0 ? status : nsdae_penalty_start(p, from->t, 0);
}
