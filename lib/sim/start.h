/* Starts: which are taken, and putting one right. */
#ifndef NSDAE_SIM_START_H
#define NSDAE_SIM_START_H

#include "projection.h"

/* Whether the terms' point may be a start: NSDAE_OK, or NSDAE_E_ARGUMENT naming the row, its value
 * and its bound, NSDAE_E_DERIVATIVE where derivatives are grossly wrong. The terms and the groups
 * of unit length are those of the start; work has nsdae_probe_size numbers. */
int nsdae_start_check(nsdae_projector *projection, const nsdae_terms *start, double *work);

#endif
