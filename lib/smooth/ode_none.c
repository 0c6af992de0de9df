/* In a library that was built without SUNDIALS. */
#include "ode.h"

#include <stddef.h>

/* Nothing here reads its arguments. */
#pragma GCC diagnostic ignored "-Wunused-parameter"

int nsdae_ode_create(const nsdae_ode_problem *problem, double rtol, double atol, nsdae_ode **ode)
{
  *ode = NULL;
  return NSDAE_E_UNSUPPORTED;
}

void nsdae_ode_tolerances(nsdae_ode *ode, double rtol, double atol, double step_max) {}

void nsdae_ode_positions(nsdae_ode *ode, int positions, double longest) {}

void nsdae_ode_destroy(nsdae_ode **ode)
{
  *ode = NULL;
}

int nsdae_ode_start(nsdae_ode *ode, double t, const double *y)
{
  return NSDAE_E_UNSUPPORTED;
}

int nsdae_ode_advance(nsdae_ode *ode, double t_end, double *t, double *y, int *what, int *found,
                      int *code)
{
  return NSDAE_E_UNSUPPORTED;
}

int nsdae_ode_read(nsdae_ode *ode, double t, double *y)
{
  return NSDAE_E_UNSUPPORTED;
}

long nsdae_ode_rates(const nsdae_ode *ode)
{
  return 0;
}
