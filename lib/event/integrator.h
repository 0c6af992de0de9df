/* A phase from the instant at its start on: SUNDIALS IDA, step by step, and what its roots say of
 * each step. */
#ifndef NSDAE_EVENT_INTEGRATOR_H
#define NSDAE_EVENT_INTEGRATOR_H

#include "dae.h"
#include "roots.h"

typedef struct nsdae_event_integrator {
  nsdae_event_roots *roots;
  nsdae_dae *dae;
  double *y, *yp;     /* n: at the last instant, then where it was last read */
  double *order;      /* n: 1 differential, 0 algebraic */
  int *fallen;        /* roots: as the integrator says */
  double *gap, *rate; /* 4 k: of the contacts at the start, the middle and the end of the
                         last step, and where they were looked at last */
  double known;       /* the time of the third, or NaN */
  double ahead;       /* integrated up to here */
  int pending;        /* an instant waits there */
  int code;           /* the integrator's, of the last failure */
} nsdae_event_integrator;

void nsdae_event_integrator_layout(nsdae_event_integrator *integrator, nsdae_arena *arena);
/* NSDAE_E_MEMORY, NSDAE_E_UNSUPPORTED. */
int nsdae_event_integrator_make(nsdae_event_integrator *integrator);

/* Starts at t from y, yp, which are then consistent with the modes' own equations; sets the roots.
 * NSDAE_E_CONVERGENCE with the code; or a callback's status. */
int nsdae_event_integrator_start(nsdae_event_integrator *integrator, double t);

/* One step, from `ahead` to where it goes then; y is there. */
int nsdae_event_integrator_advance(nsdae_event_integrator *integrator);

/* y at t in the last step. */
int nsdae_event_integrator_read(nsdae_event_integrator *integrator, double t, double *y);

#endif
