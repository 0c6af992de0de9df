/* Each callback alone: what it writes beyond its arrays, leaves out, or writes that is no number.
 */
#ifndef NSDAE_SYSTEM_PROBE_H
#define NSDAE_SYSTEM_PROBE_H

#include "system_impl.h"

/* What is the same of all callbacks: for what goes through them all. From callbacks.list. */

enum { NSDAE_OUTPUTS_MAX = 3 };

typedef struct nsdae_place {
  double t;
  const double *q, *v;
} nsdae_place;

/* One array of a callback; rows and columns are of enum nsdae_name_kind, -1 where it has none. */
typedef struct nsdae_output {
  const char *name;
  int row, column;
  int directions; /* contacts count once for each tangential direction */
  int nullable;   /* NULL is handed over where it is empty */
} nsdae_output;

typedef struct nsdae_callback {
  const char *name;
  int (*given)(const nsdae_system *system);
  int (*call)(const nsdae_system *system, const nsdae_place *at, double *const *out, const int *ld);
  int outputs;
  nsdae_output output[NSDAE_OUTPUTS_MAX];
} nsdae_callback;

extern const nsdae_callback nsdae_callbacks[];
extern const int nsdae_callbacks_count;

/* That of the name, or NULL. */
const nsdae_callback *nsdae_callback_of(const char *name);

/* How many rows or columns an output has; 1 where kind is -1. */
int nsdae_output_extent(const nsdae_system *system, const nsdae_output *output, int kind);

/* Ends the error's text with what an entry belongs to: ': velocity 1 "y", contact 3 "stop"'. */
void nsdae_output_name_entry(const nsdae_system *system, const nsdae_output *output, int row,
                             int column, nsdae_error *error);

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
