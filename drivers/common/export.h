/* Writes the problem of a step to a file, so that it can be solved without the model. */
#ifndef NSDAE_DRIVER_DUMP_H
#define NSDAE_DRIVER_DUMP_H

#include "settings.h"

typedef struct dump {
  nsdae_sim *sim;
  const settings *settings;
  long step;           /* of the record before the step that is to be kept, or the last one */
  double time, *q, *v; /* the same; NULL: none yet */
} dump;

/* Before the run: observes the requested step. After it: the last or the failed one.
 * A file that cannot be written is reported and does not end the run. */
void dump_begin(dump *d, nsdae_sim *sim, const settings *s);
void dump_end(dump *d, int status);

#endif
