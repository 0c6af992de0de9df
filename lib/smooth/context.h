/* A SUNDIALS context that prints nothing. */
#ifndef NSDAE_SMOOTH_CONTEXT_H
#define NSDAE_SMOOTH_CONTEXT_H

#include <sundials/sundials_context.h>
#include <sundials/sundials_version.h>

/* Version 7 takes a communicator and reports through the context, version 6 through the
 * integrator, which is silenced by its SetErrFile. Returns 0 when it was made. */
static inline int nsdae_make_context(SUNContext *context)
{
#if SUNDIALS_VERSION_MAJOR >= 7
  if (SUNContext_Create(SUN_COMM_NULL, context) != 0) return -1;
  return SUNContext_ClearErrHandlers(*context) == 0 ? 0 : -1;
#else
  return SUNContext_Create(NULL, context);
#endif
}

#endif
