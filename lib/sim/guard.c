/* One call at a time on a simulation, from callbacks and threads: see sim_impl.h. */
#include <math.h>
#include <stdio.h>

#include "errors.h"
#include "sim_impl.h"

/* The guard is all that a call which reads changes. */
static nsdae_guard *guard_of(const nsdae_sim *sim)
{
  return &((nsdae_sim *)sim)->guard;
}

/* Only this thread stores its own address there, so that the order of stores is no matter. */
static int is_mine(nsdae_guard *guard)
{
  return atomic_load_explicit(&guard->thread, memory_order_relaxed) == nsdae_this_thread();
}

static int refuse_left(const nsdae_call *call)
{
  return nsdae_error_set(
      nsdae_refusal_on(call->sim), NSDAE_E_STATE, call->where, "sim",
      "a callback left %s by an exception or longjmp: the simulation can only be "
      "destroyed; to stop a call, return a negative value from the callback",
      guard_of(call->sim)->where);
}

static int refuse_concurrent(const nsdae_call *call)
{
  return nsdae_error_set(
      nsdae_refusal_on(call->sim), NSDAE_E_STATE, call->where, "sim",
      "%s was called while another call on this simulation was in progress, in a callback or in "
      "another thread: call it before or after, or give each thread a simulation of its own. If a "
      "callback left by longjmp, destroy the simulation in the function that ran it",
      call->where);
}

/* A call within one of the same thread. */
static int enter_within(nsdae_call *call, nsdae_guard *guard)
{
  if (!guard->showing) return refuse_concurrent(call);
  if (call->use >= NSDAE_MOVE) { /* nothing else writes to the record in an observer */
    nsdae_refusal_forget(call->sim);
    return nsdae_error_set(&((nsdae_sim *)call->sim)->error, NSDAE_E_STATE, call->where, "",
                           "%s was called by an observer, before the end of its step: return a "
                           "positive value to stop the run instead",
                           call->where);
  }
  guard->showing = call->use == NSDAE_READ; /* what it asks may call a callback */
  call->entered = call->nested = 1;
  return NSDAE_OK;
}

/* What the call before has written is seen after it: acquire here, release in leave. */
static int take(nsdae_guard *guard, enum nsdae_use use)
{
  int users = use == NSDAE_READ ? atomic_load_explicit(&guard->users, memory_order_relaxed) : 0;
  while (use == NSDAE_READ ? users >= 0 : users == 0)
    if (atomic_compare_exchange_weak_explicit(&guard->users, &users,
                                              use == NSDAE_READ ? users + 1 : NSDAE_ALONE,
                                              memory_order_acquire, memory_order_relaxed))
      return 1;
  return 0;
}

static void mark_as_left(nsdae_guard *guard)
{
  guard->showing = 0;
  atomic_store_explicit(&guard->thread, NULL, memory_order_relaxed);
  atomic_store_explicit(&guard->users, NSDAE_LEFT, memory_order_release);
}

int nsdae_sim_enter(nsdae_call *call)
{
  if (!call->sim) return NSDAE_E_ARGUMENT;
  nsdae_guard *guard = guard_of(call->sim);
  if (is_mine(guard)) {
    if (call->frame < guard->frame) return enter_within(call, guard);
    mark_as_left(guard);
  }
  if (!take(guard, call->use)) {
    int users = NSDAE_LEFT,
        left = atomic_load_explicit(&guard->users, memory_order_acquire) == users;
    if (!left) return refuse_concurrent(call);
    if (call->use != NSDAE_END) return refuse_left(call);
    if (!atomic_compare_exchange_strong(&guard->users, &users, NSDAE_ALONE)) return NSDAE_E_STATE;
  }
  if (call->use != NSDAE_READ) {
    guard->frame = call->frame;
    guard->where = call->where;
    atomic_store_explicit(&guard->thread, nsdae_this_thread(), memory_order_relaxed);
  }
  call->entered = 1;
  return NSDAE_OK;
}

void nsdae_sim_leave(nsdae_call *call)
{
  if (!call->entered) return;
  nsdae_guard *guard = guard_of(call->sim);
  nsdae_refusal_forget(call->sim);
  if (call->nested) {
    guard->showing = 1;
  } else if (call->use == NSDAE_READ) {
    atomic_fetch_sub_explicit(&guard->users, 1, memory_order_release);
  } else if (!call->returned) {
    mark_as_left(guard);
  } else {
    atomic_store_explicit(&guard->thread, NULL, memory_order_relaxed);
    atomic_store_explicit(&guard->users, 0, memory_order_release);
  }
}

/* A point whose values are not finite does not become the state. */

/* One array of a record, `each` numbers for every item of a kind (-1: of none). */
typedef struct part {
  const char *name;
  const double *value;
  int count, kind, each;
} part;

enum { OF_NONE = -1, OF_ONE = -2 }; /* kinds of what has numbers and no names, and of one number */

/* item: of a kind that entry index belongs to. */
static int refuse_nonfinite(const nsdae_result *result, const char *name, int index, int kind,
                            int item)
{
  const nsdae_terms *end = &result->end;
  char place[16] = "";
  if (kind != OF_ONE) snprintf(place, sizeof place, "[%d]", index);
  nsdae_error_set(end->error, NSDAE_E_NONFINITE, "nsdae_sim", name,
                  "%s%s overflows at t = %g: the step was discarded; make dt smaller", name, place,
                  nsdae_terms_time(end));
  if (kind >= 0) nsdae_system_name_item(end->system, kind, item, end->error);
  return nsdae_error_at(end->error, NSDAE_E_NONFINITE, index, nsdae_terms_time(end));
}

static double sum_of(const nsdae_impact *p)
{
  return p->normal_impulse + p->tangential_impulse[0] + p->tangential_impulse[1] +
         p->velocity_before + p->velocity_after + p->peak_force;
}

/* Which of the values is not finite; NSDAE_OK where none is. */
static int find_not_finite(const nsdae_point *point)
{
  const nsdae_result *result = &point->result;
  const nsdae_record *r = &point->record;
  const nsdae_dims *d = &result->end.system->dims;
  int k = r->contacts.count, contact = d->k > 0 ? NSDAE_NAME_CONTACT : OF_NONE;
  const part parts[] = {
      {"time", &r->time, 1, OF_ONE, 1},
      {"q", r->q, d->nq, NSDAE_NAME_COORDINATE, 1},
      {"v", r->v, d->nv, NSDAE_NAME_VELOCITY, 1},
      {"kinetic", &r->kinetic, 1, OF_ONE, 1},
      {"potential", &r->potential, 1, OF_ONE, 1},
      {"dissipated", &r->dissipated, 1, OF_ONE, 1},
      {"multiplier", r->multiplier, d->m, NSDAE_NAME_CONSTRAINT, 1},
      {"gap", r->contacts.gap, k, contact, 1},
      {"normal_impulse", r->contacts.normal_impulse, k, contact, 1},
      {"tangential_impulse", r->contacts.tangential_impulse, k * d->nt, contact, d->nt},
      {"frictional_joint_impulse", r->frictional_joint_impulse, d->f, NSDAE_NAME_FRICTIONAL_JOINT,
       1},
      {"work of the forces", &point->work.forces, 1, OF_ONE, 1},
      {"certificate.work", &r->certificate.work, 1, OF_ONE, 1},
      {"certificate.unexplained", &r->certificate.unexplained, 1, OF_ONE, 1},
      {"certificate.constraint_rate", &r->certificate.constraint_rate, 1, OF_ONE, 1},
      {"certificate.complementarity", &r->certificate.complementarity, 1, OF_ONE, 1},
      {"lcp_residual", &r->lcp_residual, 1, OF_ONE, 1},
      {"constraint_drift", &r->constraint_drift, 1, OF_ONE, 1}};
  for (const part *p = parts; p < parts + sizeof parts / sizeof *parts; p++)
    for (int i = 0; i < p->count; i++)
      if (!isfinite(p->value[i])) return refuse_nonfinite(result, p->name, i, p->kind, i / p->each);
  double energy = r->kinetic + r->potential + r->dissipated;
  if (!isfinite(energy)) return refuse_nonfinite(result, "energy", 0, OF_ONE, 0);
  for (int i = 0; i < r->impacts; i++)
    if (!isfinite(sum_of(&r->impact[i])))
      return refuse_nonfinite(result, "impact", i, contact, r->impact[i].contact);
  return NSDAE_OK;
}

static double sum(const double *a, int n)
{
  double s = 0;
  for (int i = 0; i < n; i++) s += a[i];
  return s;
}

/* A finite sum has finite terms: where it is none they are looked at one by one. In it are not: the
 * energies, of which work and unexplained are sums; v, of which kinetic is none unless all are
 * finite. */
int nsdae_point_finite(const nsdae_point *point)
{
  const nsdae_record *r = &point->record;
  const nsdae_dims *d = &point->result.end.system->dims;
  int k = r->contacts.count;
  const nsdae_certificate *c = &r->certificate;
  double all = r->time + c->work + c->unexplained + r->lcp_residual + r->constraint_drift +
               c->constraint_rate + c->complementarity;
  all += sum(r->q, d->nq) + sum(r->multiplier, d->m) + sum(r->contacts.gap, k) +
         sum(r->contacts.normal_impulse, k) + sum(r->contacts.tangential_impulse, k * d->nt) +
         sum(r->frictional_joint_impulse, d->f);
  for (int i = 0; i < r->impacts; i++) all += sum_of(&r->impact[i]);
  return isfinite(all) ? NSDAE_OK : find_not_finite(point);
}
