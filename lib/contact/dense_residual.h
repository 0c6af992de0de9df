/* The natural residual of a solution of a dense island (natural_residual.h): of the laws of its
 * contacts and frictional joints and of its rows, with v as it is and as it would be without any
 * impulse. A polygon is no cone: it leaves what its complementarity problem leaves, relative to the
 * fastest.
 *
 * rounded: less what rounding explains. */
#ifndef NSDAE_DENSE_RESIDUAL_H
#define NSDAE_DENSE_RESIDUAL_H

#include "dense_island.h"

nsdae_natural_residual nsdae_dense_residual(const nsdae_dense_island *dense, int rounded);

#endif
