/* Ctrl-C ends a run after its step, with the file closed. */
#ifndef NSDAE_DRIVER_INTERRUPT_H
#define NSDAE_DRIVER_INTERRUPT_H

#include <nsdae/nsdae.h>

/* From now on SIGINT, SIGTERM and SIGHUP set a flag; SIGHUP unless it is ignored. */
void interrupt_catch(void);

/* A file at the limit of its size is an error of the write, which is reported, and the file is
 * closed: no signal ends the program. */
void interrupt_not_by_size(void);

/* Observer: stops the run that it sees. */
int interrupt_observe(const nsdae_record *record, nsdae_error *error, void *user);

/* NSDAE_OK, or an error with the time of the record if one of them arrived. */
int interrupt_status(const nsdae_sim *sim, nsdae_error *error);

/* The same within a step, which is then discarded. */
int interrupt_asked(void *user);

/* One of them arrived. */
int interrupt_came(void);

#endif
