/* In place of dae_ida.c where the library is built without SUNDIALS. */
#include <stddef.h>

#include "dae.h"

int nsdae_dae_create(const nsdae_dae_problem *problem, double rtol, double atol, double max_step,
                     nsdae_dae **dae)
{
  (void)problem;
  (void)rtol;
  (void)atol;
  (void)max_step;
  *dae = NULL;
  return NSDAE_E_UNSUPPORTED;
}

void nsdae_dae_destroy(nsdae_dae **dae)
{
  (void)dae;
}

int nsdae_dae_start(nsdae_dae *dae, double t, double after, double *y, double *yp, int *code)
{
  (void)dae;
  (void)t;
  (void)after;
  (void)y;
  (void)yp;
  (void)code;
  return NSDAE_E_UNSUPPORTED;
}

int nsdae_dae_advance(nsdae_dae *dae, double *t, int *root, int *found, int *code)
{
  (void)dae;
  (void)t;
  (void)root;
  (void)found;
  (void)code;
  return NSDAE_E_UNSUPPORTED;
}

int nsdae_dae_interpolate(nsdae_dae *dae, double t, int derivative, double *y)
{
  (void)dae;
  (void)t;
  (void)derivative;
  (void)y;
  return NSDAE_E_UNSUPPORTED;
}
