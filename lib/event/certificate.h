/* The certificate of a record: see certificate.c. */
#ifndef NSDAE_EVENT_CERTIFICATE_H
#define NSDAE_EVENT_CERTIFICATE_H

#include "setting.h"

/* Whether what the step's result holds fulfils the laws of contact, with the point in work at its
 * end; redundant: constraints depend on each other, and are not judged. h: its length. NSDAE_OK, or
 * NSDAE_E_CONVERGENCE with the record, which names the contact or constraint. */
int nsdae_event_certify(const nsdae_event_setting *setting, int redundant, double h);

#endif
