/* The refusal of a call that would change what another call, or another thread, uses now: its error
 * record is the thread's own, for that of the handle is in use as well. */
#ifndef NSDAE_BASE_REFUSAL_H
#define NSDAE_BASE_REFUSAL_H

#include <nsdae/status.h>

/* The record of this thread, from now on of the last call on this handle. */
nsdae_error *nsdae_refusal_on(const void *handle);
/* It, while the last call of this thread on the handle is the refused one; else NULL. */
const nsdae_error *nsdae_refusal_of(const void *handle);
/* A later call on the handle was not refused. */
void nsdae_refusal_forget(const void *handle);

/* An address that no other thread has. */
const void *nsdae_this_thread(void);

#endif
