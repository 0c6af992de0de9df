/* Observers: each sees every record once, in the order in which they were added. A step is the
 * state when all have seen it; when one fails, it is its turn again as soon as the step is tried
 * again. */
#include <string.h>

#include "errors.h"
#include "refusal.h"
#include "sim_impl.h"

NSDAE_SIM_CALL(NSDAE_ASK, nsdae_sim_observe,
               (nsdae_sim * sim, nsdae_observer_fn observer, void *user), sim, observer, user)
{
  nsdae_observers *o = &sim->observers;
  nsdae_error_clear(&sim->error);
  if (!observer)
    return nsdae_error_set(&sim->error, NSDAE_E_ARGUMENT, "nsdae_sim_observe", "observer",
                           "observer is NULL");
  if (o->count == NSDAE_OBSERVERS_MAX)
    return nsdae_error_set(&sim->error, NSDAE_E_ARGUMENT, "nsdae_sim_observe", "observer",
                           "there are %d observers already, the maximum", NSDAE_OBSERVERS_MAX);
  o->of[o->count++] = (nsdae_observation){observer, user};
  return NSDAE_OK;
}

NSDAE_SIM_CALL(NSDAE_ASK, nsdae_sim_unobserve,
               (nsdae_sim * sim, nsdae_observer_fn observer, void *user), sim, observer, user)
{
  nsdae_observers *o = &sim->observers;
  int i = 0;
  while (i < o->count && (o->of[i].call != observer || o->of[i].user != user)) i++;
  if (i == o->count) return NSDAE_OK;
  o->count--;
  o->turn -= i < o->turn;
  memmove(o->of + i, o->of + i + 1, (size_t)(o->count - i) * sizeof *o->of);
  return NSDAE_OK;
}

static int call(nsdae_sim *sim, nsdae_observation observer, const nsdae_record *record)
{
  nsdae_error_clear(&sim->error);
  nsdae_refusal_forget(sim); /* that of a callback */
  sim->observers.telling = sim->guard.showing = 1;
  int status = observer.call(record, &sim->error, observer.user);
  sim->observers.telling = sim->guard.showing = 0;
  if (status >= 0 || sim->error.status != NSDAE_OK) return status;
  nsdae_error_set(&sim->error, status, "nsdae_sim", "observer",
                  "an observer returned %d (%s) at t = %.17g", status, nsdae_status_message(status),
                  record->time);
  sim->error.code = status;
  return nsdae_error_at(&sim->error, status, -1, record->time);
}

int nsdae_observers_tell(nsdae_sim *sim, const nsdae_record *record)
{
  nsdae_observers *o = &sim->observers;
  while (o->turn < o->count) {
    nsdae_observation observer = o->of[o->turn++];
    int status = call(sim, observer, record);
    if (status > 0) o->stop = 1;
    if (status >= 0) continue;
    /* it is its turn again, unless it took itself out */
    o->turn -= o->turn > 0 && o->of[o->turn - 1].call == observer.call &&
               o->of[o->turn - 1].user == observer.user;
    return status;
  }
  int stop = o->stop;
  o->turn = o->stop = 0;
  return stop ? NSDAE_STOPPED : NSDAE_OK;
}
