/* Filling the error record. */
#ifndef NSDAE_BASE_ERRORS_H
#define NSDAE_BASE_ERRORS_H

#include <nsdae/status.h>

/* The refusal of a call that would change what another call, or another thread, uses now: its error
 * record is the thread's own, for that of the handle is in use as well. */

/* The record of this thread, from now on of the last call on this handle. */
nsdae_error *nsdae_refusal_on(const void *handle);
/* It, while the last call of this thread on the handle is the refused one; else NULL. */
const nsdae_error *nsdae_refusal_of(const void *handle);
/* A later call on the handle was not refused. */
void nsdae_refusal_forget(const void *handle);

/* An address that no other thread has. */
const void *nsdae_this_thread(void);

#if defined(__GNUC__)
#define NSDAE_PRINTF(fmt, args) __attribute__((format(printf, fmt, args)))
#else
#define NSDAE_PRINTF(fmt, args)
#endif

/* Clears the record: status NSDAE_OK, no index, time NaN. error may be NULL. */
void nsdae_error_clear(nsdae_error *error);

/* Fills the record and returns status. where: the public function or the stage that found it;
 * argument: what it concerns ("" for none). error may be NULL. */
int nsdae_error_set(nsdae_error *error, int status, const char *where, const char *argument,
                    const char *format, ...) NSDAE_PRINTF(5, 6);

/* Adds index and time to the record and returns status. error may be NULL. */
int nsdae_error_at(nsdae_error *error, int status, int index, double time);

/* NSDAE_E_ARGUMENT, "ARGUMENT is NULL". */
int nsdae_error_null(nsdae_error *error, const char *where, const char *argument);

/* NSDAE_E_MEMORY, "out of memory". */
int nsdae_error_memory(nsdae_error *error, const char *where);

#endif
