/* See ida.h, in a library that was built without SUNDIALS. */
#include "ida.h"

#include <stddef.h>

/* Nothing here reads its arguments. */
#pragma GCC diagnostic ignored "-Wunused-parameter"

int nsdae_ida_create(const nsdae_ida_problem *problem, nsdae_ida **ida)
{
  *ida = NULL;
  return NSDAE_E_UNSUPPORTED;
}

void nsdae_ida_destroy(nsdae_ida **ida)
{
  *ida = NULL;
}

int nsdae_ida_start(nsdae_ida *ida, const nsdae_ida_tolerances *tolerances, double t,
                    const double *y, const double *ydot, double first)
{
  return NSDAE_E_UNSUPPORTED;
}

int nsdae_ida_advance(nsdae_ida *ida, double *t)
{
  return NSDAE_E_UNSUPPORTED;
}

const char *nsdae_ida_failure(const nsdae_ida *ida)
{
  return "";
}

int nsdae_ida_read(nsdae_ida *ida, double t, int derivative, double *y)
{
  return NSDAE_E_UNSUPPORTED;
}
