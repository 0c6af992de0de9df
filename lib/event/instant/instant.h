/* What happens at an instant, in this order: positions are brought back to the constraints and to
 * what is closed; contacts that approach are impacts; contacts left without approach are closed or
 * let go by the problem of accelerations, which also gives the modes; velocities are brought to
 * what is closed and what sticks. */
#ifndef NSDAE_EVENT_INSTANT_H
#define NSDAE_EVENT_INSTANT_H

#include "acceleration.h"
#include "impact.h"
#include "roots.h"

typedef struct nsdae_event_instant {
  nsdae_event_roots *roots;
  nsdae_event_acceleration acceleration;
  nsdae_event_impacts impacts;
  nsdae_event_projection projection;
} nsdae_event_instant;

/* At t, with the roots that were found, from the state and forces of y [n] to the state of the next
 * phase, and its modes. */
int nsdae_event_pass(nsdae_event_instant *instant, double t, double *y);

/* Whether constraints or what is closed have left zero by more than the integrator's error, as over
 * a long phase they do: then they are to be brought back. 0, 1, 2 if what is closed comes together
 * so fast that its gap may have a kink, or a status; so far that no such
 * error explains it is NSDAE_E_CONVERGENCE with the record. */
int nsdae_event_strayed(const nsdae_event_instant *instant, double t, const double *y);

/* Whether the range of redundant constraints has turned away from the phase's at t, y: then a new
 * phase is due. 0, 1, or a status. */
int nsdae_event_turned(const nsdae_event_instant *instant, double t, const double *y);

#endif
