/* One call at a time on a simulation, from callbacks and threads: see sim_impl.h. */
#include "errors.h"
#include "refusal.h"
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

static int refuse_concurrent(const nsdae_sim *sim, const char *where)
{
  return nsdae_error_set(nsdae_refusal_on(sim), NSDAE_E_STATE, where, "sim",
                         "%s was called while another call on this simulation was in progress, in "
                         "a callback or in another thread: call it before or after, or give each "
                         "thread a simulation of its own",
                         where);
}

/* What the call before has written is seen after it: acquire here, release in leave. */
static int take(nsdae_guard *guard, enum nsdae_use use)
{
  int users = use == NSDAE_READ ? atomic_load_explicit(&guard->users, memory_order_relaxed) : 0;
  while (use == NSDAE_READ ? users >= 0 : users == 0)
    if (atomic_compare_exchange_weak_explicit(&guard->users, &users,
                                              use == NSDAE_READ ? users + 1 : -1,
                                              memory_order_acquire, memory_order_relaxed))
      return 1;
  return 0;
}

int nsdae_sim_enter(const nsdae_sim *sim, enum nsdae_use use, const char *where)
{
  if (!sim) return NSDAE_E_ARGUMENT;
  nsdae_guard *guard = guard_of(sim);
  if (is_mine(guard)) {
    if (!guard->showing) return refuse_concurrent(sim, where);
    if (use == NSDAE_MOVE) { /* nothing else writes to the record while an observer is called */
      nsdae_refusal_forget(sim);
      return nsdae_error_set(&((nsdae_sim *)sim)->error, NSDAE_E_STATE, where, "",
                             "%s was called by an observer, before the end of its step: return a "
                             "positive value to stop the run instead",
                             where);
    }
    guard->showing = use == NSDAE_READ; /* what it asks may call a callback */
    return NSDAE_OK;
  }
  if (!take(guard, use)) return refuse_concurrent(sim, where);
  if (use != NSDAE_READ)
    atomic_store_explicit(&guard->thread, nsdae_this_thread(), memory_order_relaxed);
  return NSDAE_OK;
}

void nsdae_sim_leave(const nsdae_sim *sim, enum nsdae_use use)
{
  nsdae_guard *guard = guard_of(sim);
  nsdae_refusal_forget(sim);
  if (is_mine(guard) && sim->observers.telling) {
    guard->showing = 1;
  } else if (use == NSDAE_READ) {
    atomic_fetch_sub_explicit(&guard->users, 1, memory_order_release);
  } else {
    atomic_store_explicit(&guard->thread, NULL, memory_order_relaxed);
    atomic_store_explicit(&guard->users, 0, memory_order_release);
  }
}
