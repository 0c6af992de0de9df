/* A phase from the instant at its start on, step by step, and what its roots say of each step: by a
 * method of one step, which starts anew at no cost, and where that turns out to be held back by
 * stability, by backward differences (IDA) until the phase ends. */
#ifndef NSDAE_EVENT_INTEGRATOR_H
#define NSDAE_EVENT_INTEGRATOR_H

#include "account.h"
#include "dip.h"
#include "roots.h"
#include "smooth.h"
#include "tracking.h"

/* In tolerances of a position: contacts as near have a slot. Those that touch are half as near. */
#define NSDAE_EVENT_NEAR 2.0

typedef struct nsdae_event_integrator {
  nsdae_event_roots *roots;
  nsdae_event_account *account;
  nsdae_smooth smooth;     /* of z: see account.h; the modes say which of its two is at work */
  nsdae_fall fall;         /* of the roots, in the last step */
  nsdae_dip dip;           /* of the gaps, likewise */
  double *y, *z, *later;   /* n, whole: where it was last read */
  double *end;             /* whole: where the last step ended */
  int *fallen;             /* roots: in the last step */
  nsdae_tracking tracking; /* of the contacts of a list */
  int *late;               /* k, of the memory: in their slots since the base */
  int again;               /* steps that were done before: no contact is looked for */
  double ahead;            /* integrated and searched up to here */
  int pending;             /* an instant waits there */
} nsdae_event_integrator;

void nsdae_event_integrator_layout(nsdae_event_integrator *integrator, nsdae_arena *arena);
/* NSDAE_E_MEMORY, NSDAE_E_UNSUPPORTED. */
int nsdae_event_integrator_make(nsdae_event_integrator *integrator);
void nsdae_event_integrator_release(nsdae_event_integrator *integrator);
void nsdae_event_integrator_prepare(nsdae_event_integrator *integrator);

/* Starts at t from q and v of y, whose forces are then those of the modes' own equations; sets the
 * roots. NSDAE_E_CONVERGENCE, or a callback's status. */
int nsdae_event_integrator_start(nsdae_event_integrator *integrator, double t);

/* One step, from `ahead` to where it goes then; y is there. */
int nsdae_event_integrator_advance(nsdae_event_integrator *integrator);

/* Contacts that are new in their slots are open. */
void nsdae_event_open_fresh(nsdae_event_integrator *integrator);

/* q and v of y at t in the last step. */
int nsdae_event_integrator_read(nsdae_event_integrator *integrator, double t, double *y);

/* What the forces did between two times in the last step, for the step's result. */
int nsdae_event_integrator_account(nsdae_event_integrator *integrator, double from, double to);

#endif
