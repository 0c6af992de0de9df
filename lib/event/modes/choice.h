/* The modes of the next phase, from the problem of accelerations, which is asked again where its
 * answer is not what was assumed. */
#ifndef NSDAE_EVENT_CHOICE_H
#define NSDAE_EVENT_CHOICE_H

#include "acceleration.h"

/* Modes of all, with accelerations and forces. NSDAE_OK; NSDAE_E_PAINLEVE, NSDAE_E_CONVERGENCE, or
 * of the problem, with the record. */
int nsdae_event_choose_modes(nsdae_event_acceleration *acceleration, int impacted);

/* direction [nt] := -force / |force|, or 0. */
void nsdae_event_point_against(double *direction, int nt, const double *force);

#endif
