/* Contacts whose normal turns faster than the steps: a gap with a kink, as of a disc that falls
 * flat. */
#ifndef NSDAE_EVENT_KINK_H
#define NSDAE_EVENT_KINK_H

#include "instant.h"

/* Constraints or closed contacts strayed at the point in work, and the error says so: where a
 * contact has a kink in its gap within dt of motion, the error names it instead. q [nq] is work.
 * Returns the error's status. */
int nsdae_event_explain_strayed(nsdae_event_instant *instant, double *q);

#endif
