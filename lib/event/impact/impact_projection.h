/* Back to the constraints, to what is closed and to what sticks, by the change of least kinetic
 * energy. */
#ifndef NSDAE_EVENT_PROJECTION_H
#define NSDAE_EVENT_PROJECTION_H

#include "least.h"
#include "phase.h"

typedef struct nsdae_event_projection {
  nsdae_event_phase *phase;
  nsdae_least least; /* the change of q along H, or of v */
  double *qdot;      /* nq */
} nsdae_event_projection;

void nsdae_event_projection_layout(nsdae_event_projection *projection, nsdae_arena *arena);

/* y's q to the constraints and to the gaps that are marked [k], by Newton's method along H; y's v
 * to the rates of the constraints, of what is closed and of what sticks in the phase's modes.
 * moving [k] is 0 where a contact begins to slide: beside one that sticks, in two directions, its
 * velocity is none, too; NULL: nothing begins. The point in work is y then. A status of the
 * factorisation or a callback. */
int nsdae_event_project_positions(nsdae_event_projection *projection, double t, const int *closed,
                                  double *y);
int nsdae_event_project_velocities(nsdae_event_projection *projection, const int *moving,
                                   double *y);

/* v [nv] to the rates of the constraints and, of the contacts that are marked [k], to no velocity
 * apart, nor along where they stick; adds the impulses that do it to multiplier [m] and fills
 * normal [k] and tangential [k nt] with theirs, which may pull. The point in work stays. */
int nsdae_event_close(nsdae_event_projection *projection, const int *closed, const int *sticks,
                      double *v, double *multiplier, double *normal, double *tangential);

#endif
