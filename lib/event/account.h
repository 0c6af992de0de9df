/* What the forces do between instants: their impulses and the friction's work, as Gauss' integrals
 * of the integrator's polynomials, three points to a piece, which is exact for its highest order.
 */
#ifndef NSDAE_EVENT_ACCOUNT_H
#define NSDAE_EVENT_ACCOUNT_H

#include "integrator.h"

typedef struct nsdae_event_account {
  nsdae_event_integrator *integrator;
  double *reaction; /* nv: Phi_q^T lambda */
} nsdae_event_account;

void nsdae_event_account_layout(nsdae_event_account *account, nsdae_arena *arena);

/* Adds a piece of one step of the integrator to the step's result. */
int nsdae_event_account_phase(nsdae_event_account *account, double from, double to);

/* Adds impulses of contacts and slides, and bilateral ones [m]. */
void nsdae_event_account_impact(nsdae_event_account *account, const nsdae_impulses *impulses,
                                const double *multiplier);

#endif
