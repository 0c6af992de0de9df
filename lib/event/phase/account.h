/* What the forces do between instants: their impulses and the friction's work, integrated with the
 * motion, so that they are as accurate as its velocities and balance with them. In place of
 * y = [q, v, lambda, F] the integrators have z = [q, v, int lambda, int F, W, int T', int W F]:
 *   T'   what the kinetic energy should gain by the equations of motion, with forces of constraints
 *        and of what is closed or sticks that do no work, to be held against it
 *   W F  linear forces of the contacts in space [3 k]: W turns within a phase */
#ifndef NSDAE_EVENT_ACCOUNT_H
#define NSDAE_EVENT_ACCOUNT_H

#include "phase.h"
#include "power.h"

typedef struct nsdae_event_account {
  nsdae_event_phase *phase;
  double *y, *reaction; /* n, nv: of the point at work; Phi_q^T lambda */
  nsdae_power power;
} nsdae_event_account;

void nsdae_event_account_layout(nsdae_event_account *account, nsdae_arena *arena);

/* z' [whole] at z, or without the integrals q' and v' alone. 0; > 0: a smaller step may help; < 0:
 * a callback gave up. */
int nsdae_event_account_rate(nsdae_event_account *account, double t, const double *z, int integrals,
                             double *rate);

/* power [2 + 3 k] := the friction's power, zero for T', and the linear forces, at y with its
 * forces. A code as above. */
int nsdae_event_account_powers(nsdae_event_account *account, double t, const double *y,
                               double *power);

/* Adds what is between two z of the same phase to the step's result. */
void nsdae_event_account_phase(const nsdae_event_account *account, const double *from,
                               const double *to);

/* Adds impulses of contacts and frictional joints, and bilateral ones [m]. */
void nsdae_event_account_impact(const nsdae_event_account *account, const nsdae_impulses *impulses,
                                const double *multiplier);

#endif
