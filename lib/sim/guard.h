/* Who uses a simulation now. A call that changes it works alone. Calls that only read it may work
 * at the same time, in several threads. While an observer sees a record, its thread may read the
 * simulation and ask it, and nothing else. Every other call is NSDAE_E_STATE and touches neither
 * the simulation nor its error record: callbacks, threads of a pool and other threads alike. */
#ifndef NSDAE_SIM_GUARD_H
#define NSDAE_SIM_GUARD_H

#include "sim_impl.h"

/* NSDAE_OK; NSDAE_E_ARGUMENT where sim is NULL; NSDAE_E_STATE: refused. where: the function. */
int nsdae_sim_enter(const nsdae_sim *sim, enum nsdae_use use, const char *where);
/* After an enter that was NSDAE_OK. */
void nsdae_sim_leave(const nsdae_sim *sim, enum nsdae_use use);

/* The whole body of a public function: call, between enter and leave. */
#define NSDAE_SIM_GUARDED(sim, use, call)                   \
  do {                                                      \
    int guarded_ = nsdae_sim_enter((sim), (use), __func__); \
    if (guarded_ < 0) return guarded_;                      \
    guarded_ = (call);                                      \
    nsdae_sim_leave((sim), (use));                          \
    return guarded_;                                        \
  } while (0)

#endif
