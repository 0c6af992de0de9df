/* The part of nsdae_system_check that large systems have: M by blocks, rows of Phi_q, lists. */
#ifndef NSDAE_SYSTEM_CHECK_BLOCKS_H
#define NSDAE_SYSTEM_CHECK_BLOCKS_H

#include "differences.h"
#include "system_impl.h"

/* Keeps the entry in worst if its error is larger. */
void nsdae_check_keep(nsdae_check *worst, const char *term, int row, int column, double given,
                      double difference);

/* The worst entry goes into worst, whose error comes as the largest so far. NSDAE_OK, also with a
 * wrong entry; NSDAE_E_CALLBACK, NSDAE_E_MEMORY and what a list refuses, with the system's error.
 */
int nsdae_system_check_lists(nsdae_system *system, nsdae_differences *differences, double t,
                             const double *q, const double *v, nsdae_check *worst);

#endif
