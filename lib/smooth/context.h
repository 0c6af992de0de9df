/* A SUNDIALS context that prints nothing. */
#ifndef NSDAE_SMOOTH_CONTEXT_H
#define NSDAE_SMOOTH_CONTEXT_H

#include <stdlib.h>

#include <sundials/sundials_context.h>
#include <sundials/sundials_version.h>

/* More than what a context and an integrator's record take together (some 10 kB). */
enum { NSDAE_CONTEXT_RESERVE = 65536 };

/* Version 7 takes a communicator and reports through the context, version 6 through the
 * integrator, which is silenced by its SetErrFile. Returns 0 when it was made.
 *
 * Up to 6.4 SUNContext_Create does not survive a table of its logger that finds no memory, and
 * CVodeCreate has no one yet to be silenced by: where the reserve is not to be had, it is not
 * called. */
static inline int nsdae_make_context(SUNContext *context)
{
  void *reserve = malloc(NSDAE_CONTEXT_RESERVE);
  if (!reserve) return -1;
  free(reserve);
#if SUNDIALS_VERSION_MAJOR >= 7
  if (SUNContext_Create(SUN_COMM_NULL, context) != 0) return -1;
  return SUNContext_ClearErrHandlers(*context) == 0 ? 0 : -1;
#else
  return SUNContext_Create(NULL, context);
#endif
}

#endif
