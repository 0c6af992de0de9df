/* The certificate of a record: see certificate.c. */
#ifndef NSDAE_EVENT_CERTIFICATE_H
#define NSDAE_EVENT_CERTIFICATE_H

#include "phase.h"

/* Whether the step's result, which started at `from` and whose end is the point in work, fulfils
 * the laws of contact. NSDAE_OK; or NSDAE_E_CONVERGENCE with the record, which names the contact or
 * constraint; or a callback's status. */
int nsdae_event_certify(const nsdae_event_phase *phase, const nsdae_terms *from);

#endif
