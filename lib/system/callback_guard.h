/* Each callback alone: what it writes beyond its arrays, leaves out, or writes that is no number.
 */
#ifndef NSDAE_SYSTEM_PROBE_H
#define NSDAE_SYSTEM_PROBE_H

#include "system_impl.h"

typedef struct nsdae_callback_guard {
  const nsdae_system *system;
  const char *where; /* the function that asks */
  double t;
  const double *q, *v;
  double *work; /* nsdae_callback_guard_size */
  nsdae_error *error;
  int finite; /* whether a value that is none is reported */
} nsdae_callback_guard;

/* Numbers of work that the largest of the callbacks needs. */
size_t nsdae_callback_guard_size(const nsdae_system *system);

/* Calls every callback that is given, at one point. NSDAE_OK; NSDAE_E_CALLBACK (it failed, wrote
 * beyond an array, or never wrote an entry that has no value of its own), NSDAE_E_NONFINITE. */
int nsdae_callback_guard_callbacks(const nsdae_callback_guard *probe);

#endif
