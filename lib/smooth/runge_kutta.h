/* An initial value problem y' = f(t, y) by the explicit pair of Dormand and Prince, orders 5 and 4,
 * with its continuous extension (Dormand and Prince, J. Comp. Appl. Math. 6, 1980; Hairer, Norsett
 * and Wanner, "Solving Ordinary Differential Equations I", II.4 to II.6): a step needs no step
 * before it, so that a start costs nothing.
 *
 *   k_i = f(t + c_i h, y + h sum_j a_ij k_j),  y_1 = y + h sum_j a_7j k_j,
 *   the error's estimate h sum_j e_j k_j, in the norm of SUNDIALS, sqrt(sum (x_i / w_i)^2 / count)
 * with w_i = rtol |y_i| + atol; accepted below 1. Of positions, the first of y, the error is
 * relative to the way l that they go in the longest step, where that is less than |y_i|:
 *
 *   w_i = rtol min(|y_i|, l) + atol,  l = max_step max |y_j'|,  j among them,
 *
 * as a motion is the same wherever its origin is */
#ifndef NSDAE_RUNGE_KUTTA_H
#define NSDAE_RUNGE_KUTTA_H

#include "arena.h"
#include "stalled_steps.h"

typedef struct nsdae_runge_kutta {
  int n,
      controlled; /* the error's estimate is of the first of y; f does not depend on the others */
  int positions;  /* how many there are, or 0 */
  int forces;     /* behind what is controlled: integrals of forces, whose error is bounded too */
  double force;   /* smaller forces are none to that bound */
  double rtol, atol, max_step;
  /* 0 done, > 0 try a smaller step, < 0 give up; whole: not only of what is controlled */
  int (*rate)(double t, const double *y, double *ydot, int whole, void *user);
  void *user;
  double t, h, last;   /* where it is; the next step; the last one, which the extension is of */
  double *y;           /* n: at t */
  double *k[7];        /* n: k[6] belongs to t */
  double *dense[5];    /* n: of the last step */
  double *trial, *sum; /* n */
  double way;          /* l */
  int border;          /* steps at the border of stability, less those that were not */
  nsdae_progress progress;
} nsdae_runge_kutta;

/* Takes the arrays; n and controlled are set before. */
void nsdae_runge_kutta_layout(nsdae_runge_kutta *rk, nsdae_arena *arena);

/* Starts (anew) at t, y [n]. NSDAE_OK; NSDAE_E_CALLBACK where f gives up or refuses its point. */
int nsdae_runge_kutta_start(nsdae_runge_kutta *rk, double t, const double *y);

/* One step of its own choice. NSDAE_OK; NSDAE_E_CONVERGENCE where no step is short enough;
 * NSDAE_E_CALLBACK. */
int nsdae_runge_kutta_advance(nsdae_runge_kutta *rk);

/* Back to t, the start of the last step; the next is that part of it. */
void nsdae_runge_kutta_retreat(nsdae_runge_kutta *rk, double t, double part);

/* The last step again, from its start to a t within it: no stage is evaluated beyond. 0, or a code
 * of f, after which there is no last step. */
int nsdae_runge_kutta_land(nsdae_runge_kutta *rk, double from, double t);

/* The first `count` of y at t within the last step; before the first, where it started. */
void nsdae_runge_kutta_read(const nsdae_runge_kutta *rk, double t, int count, double *y);

/* Whether steps have for long been held back by stability, not by accuracy: f is stiff. */
int nsdae_runge_kutta_stiff(const nsdae_runge_kutta *rk);

#endif
