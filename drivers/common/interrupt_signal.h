/* Ctrl-C ends a run after its step, with the file closed. */
#ifndef NSDAE_DRIVER_INTERRUPT_H
#define NSDAE_DRIVER_INTERRUPT_H

#include <nsdae/nsdae.h>

/* From here on SIGINT and SIGTERM are noticed instead of deadly. */
void interrupt_catch(void);

/* Observer: stops the run that it sees. */
int interrupt_observe(const nsdae_record *record, nsdae_error *error, void *user);

/* NSDAE_OK, or NSDAE_E_STATE with the time of the record where one of them came. */
int interrupt_status(const nsdae_sim *sim, nsdae_error *error);

/* The same, asked inside a step, which then is dropped. */
int interrupt_asked(void *user);

/* One of them came. */
int interrupt_came(void);

#endif
