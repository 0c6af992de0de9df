/* Painleve's paradox. A contact that slides and whose own coefficient W_N^T P (W_N - mu W_T d) is
 * not above zero pulls itself in: then there is no force, or two (Painleve 1895), unless others
 * that press keep it from that: the problem without its row has no solution then in which it
 * opens. The same of frictional joints (Klein 1909): none is
 * NSDAE_E_PAINLEVE, of two one is taken. Several together can do so as well: where a problem of
 * accelerations is unsolved, the first contact that slides is to blame. */
#ifndef NSDAE_EVENT_PAINLEVE_H
#define NSDAE_EVENT_PAINLEVE_H

#include "contacts.h"

/* What a coefficient counts as zero up to, relative to W_N^T P W_N: of a problem as it is, and of
 * one near which an integrator failed. */
typedef enum nsdae_painleve_margin {
  NSDAE_PAINLEVE_EXACT,
  NSDAE_PAINLEVE_NEAR
} nsdae_painleve_margin;

/* The status of the problem at t, or NSDAE_E_PAINLEVE with the record. by_rows: it was solved as a
 * complementarity problem. */
int nsdae_painleve_judge(const nsdae_contacts *contacts, int status, int by_rows,
                         nsdae_painleve_margin margin, double t);

/* Whether the j-th slide of the solved problem slides in a known direction and has a second
 * solution: the friction that a unit of its multiplier calls for feeds more than that unit. */
int nsdae_painleve_twofold(const nsdae_contacts *contacts, int j);

/* NSDAE_E_PAINLEVE with the record: the contact's force is without bound at t, where a unit of it
 * gives no more than the coefficient. */
int nsdae_painleve_unbounded(const nsdae_contacts *contacts, int contact, double t,
                             double coefficient);

#endif
