/* An implicit problem r(t, y, y') = 0 of index 1, by SUNDIALS IDA: variable-order BDF with error
 * control, dense output and root finding. */
#ifndef NSDAE_DAE_H
#define NSDAE_DAE_H

#include <nsdae/status.h>

typedef struct nsdae_dae nsdae_dae;

/* The callbacks: 0 done, > 0 try a smaller step, < 0 give up. */
typedef struct nsdae_dae_problem {
  int n, roots;
  int sparse;          /* sparse factors of J instead of dense ones */
  const double *order; /* n: 1 where y_i' occurs, 0 where y_i is algebraic */
  int (*residual)(double t, const double *y, const double *yp, double *r, void *user);
  /* J [n x n] = dr/dy + c dr/dy'; r is the residual there. J comes zeroed. */
  int (*jacobian)(double t, double c, const double *y, const double *yp, const double *r, double *J,
                  void *user);
  int (*root)(double t, const double *y, const double *yp, double *g, void *user);
  void *user;
} nsdae_dae_problem;

/* max_step: longest step. Only falls of the root functions through zero are reported.
 * NSDAE_E_MEMORY; NSDAE_E_UNSUPPORTED where the library was built without SUNDIALS. */
int nsdae_dae_create(const nsdae_dae_problem *problem, double rtol, double atol, double max_step,
                     nsdae_dae **dae);
void nsdae_dae_destroy(nsdae_dae **dae);

/* Starts (anew) at t towards the time after it. On entry y holds the state and a guess of its
 * algebraic part, yp a guess of y'; on return both are consistent (IDACalcIC).
 * NSDAE_OK; NSDAE_E_CONVERGENCE with the integrator's code in *code; NSDAE_E_CALLBACK. */
int nsdae_dae_start(nsdae_dae *dae, double t, double after, double *y, double *yp, int *code);

/* One step of the integrator's own choice from *t on; *t is where it got to. With *root the
 * functions found [roots] that are not zero fell through zero there. NSDAE_OK, or as above. */
int nsdae_dae_advance(nsdae_dae *dae, double *t, int *root, int *found, int *code);

/* y [n] (derivative 0) or y' [n] (1) at t within the last step. NSDAE_OK or NSDAE_E_CONVERGENCE. */
int nsdae_dae_interpolate(nsdae_dae *dae, double t, int derivative, double *y);

#endif
