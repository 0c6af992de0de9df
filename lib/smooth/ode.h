/* A stiff initial value problem y' = f(t, y), by SUNDIALS CVODE: variable-order BDF with error
 * control and root finding. */
#ifndef NSDAE_ODE_H
#define NSDAE_ODE_H

#include <nsdae/status.h>

typedef struct nsdae_ode nsdae_ode;

/* f and the root functions g: 0 done, > 0 try a smaller step, < 0 give up. */
typedef struct nsdae_ode_problem {
  int n, roots;
  int controlled; /* the error is controlled of the first of y, and f depends on no others; 0: all
                   */
  int (*rate)(double t, const double *y, double *ydot, void *user);
  /* in place of f in differences around y_0, where f bends too much for them: linear in velocities
   * however far apart in size; NULL: f itself */
  int (*near)(double t, const double *y_0, const double *y, double *ydot, void *user);
  int (*root)(double t, const double *y, double *g, void *user);
  void *user;
} nsdae_ode_problem;

/* NSDAE_E_MEMORY; NSDAE_E_UNSUPPORTED where the library was built without SUNDIALS. */
int nsdae_ode_create(const nsdae_ode_problem *problem, double rtol, double atol, nsdae_ode **ode);
/* Other tolerances and largest step (infinite: no bound), before the next start. */
void nsdae_ode_tolerances(nsdae_ode *ode, double rtol, double atol, double step_max);
/* From the next start on the error of the first of y, positions, is relative to the way that they
 * go in `longest`, where that is less than they are: see runge_kutta.h. */
void nsdae_ode_positions(nsdae_ode *ode, int positions, double longest);
void nsdae_ode_destroy(nsdae_ode **ode);

/* Starts (anew) at t, y [n]. */
int nsdae_ode_start(nsdae_ode *ode, double t, const double *y);

enum { NSDAE_ODE_STEP, NSDAE_ODE_ROOT, NSDAE_ODE_END };

/* One step of the integrator's own choice, not past t_end; *what says how it ended. t and y [n]
 * are where it got to (on entry *t where it was), found [roots] the direction in which each root
 * was crossed, 0 where it was not. NSDAE_OK; NSDAE_E_CONVERGENCE with the integrator's code in
 * *code; NSDAE_E_CALLBACK. */
int nsdae_ode_advance(nsdae_ode *ode, double t_end, double *t, double *y, int *what, int *found,
                      int *code);

/* y [n] at t within the last step. NSDAE_OK or NSDAE_E_CONVERGENCE. */
int nsdae_ode_read(nsdae_ode *ode, double t, double *y);

/* Evaluations of f so far. */
long nsdae_ode_rates(const nsdae_ode *ode);

#endif
