/* Each callback alone: what it writes beyond its arrays, leaves out, or writes that is no number.
 */
#ifndef NSDAE_SYSTEM_PROBE_H
#define NSDAE_SYSTEM_PROBE_H

#include "callbacks.h"

/* Calls every callback that is given, at one point; the error of the system says what was found.
 * NSDAE_OK; NSDAE_E_CALLBACK (it failed, wrote beyond an array, or never wrote an entry that has no
 * value of its own), NSDAE_E_NONFINITE, NSDAE_E_MEMORY. */
int nsdae_system_probe(nsdae_system *system, const nsdae_point *at);

#endif
