/* For nsdae_system_check: the callbacks for D = -dF/dv and K = -(dF/dq) H, dense or by blocks. */
#ifndef NSDAE_SYSTEM_CHECK_FORCES_H
#define NSDAE_SYSTEM_CHECK_FORCES_H

#include "differences.h"

/* Keeps the worst entry of D and K in *worst. NSDAE_OK; a callback's failure with the system's
 * record; NSDAE_E_MEMORY. */
int nsdae_system_check_forces(nsdae_system *system, nsdae_differences *differences, double t,
                              const double *q, const double *v, nsdae_check *worst);

#endif
