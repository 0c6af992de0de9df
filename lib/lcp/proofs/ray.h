/* What a secondary ray of Lemke's method proves about the matrix. */
#ifndef NSDAE_LCP_RAY_H
#define NSDAE_LCP_RAY_H

#include "work.h"

/* Largest problem whose ray is looked at. */
enum { NSDAE_RAY_MAX = 60 };

/* Sets info->ray from the basis in w->trial, on which Lemke's method with the covering vector of
 * ones ended without a blocking row. */
void nsdae_lcp_read_ray(nsdae_lcp_work *w);

#endif
