/* An initial value problem y' = f(t, y) by an explicit pair (tableau below; Hairer, Norsett and
 * Wanner, "Solving Ordinary Differential Equations I", II.4 to II.6): a step needs no step before
 * it, so that a start costs nothing. The error's estimate is in the norm of SUNDIALS, sqrt(sum (x_i
 * / w_i)^2 / count) with w_i = rtol |y_i| + atol; accepted below 1. Of positions, the first of y,
 * the error is relative to the way l that they go in a time `span`, where that is less than |y_i|:
 *
 *   w_i = rtol min(|y_i|, l) + atol,  l = span max |y_j'|,  j among them,
 *
 * as a motion is the same wherever its origin is. The stages that the continuous extension alone
 * needs are evaluated at the first reading inside a step. */
#ifndef NSDAE_RUNGE_KUTTA_H
#define NSDAE_RUNGE_KUTTA_H

#include "arena.h"
#include "stalled_steps.h"

/* ---- tableau.c: Butcher tableaus of explicit pairs with first same as last (FSAL) and continuous
 * extension,
 *
 *   k_i = f(t + c_i h, y + h sum_j a_ij k_j),   y_1 = y + h sum_j b_j k_j,   b = row s of a,
 *   error h |e_5|^2 / sqrt(|e_5|^2 + 0.01 |e_3|^2),  e_q = sum_j e_qj k_j;  without e_3: h |e_5|,
 *
 * Dormand and Prince 5(4): J. Comp. Appl. Math. 6 (1980) 19; DOP853, 8(5,3): Hairer, Norsett and
 * Wanner, "Solving Ordinary Differential Equations I", II.5, II.6 and II.10, with the coefficients
 * of their program dop853.f. */

enum { NSDAE_TABLEAU_WIDTH = 16, NSDAE_TABLEAU_DENSE = 8 };

typedef struct nsdae_tableau {
  int stages;    /* s, those of y_1; k_s is f(y_1) */
  int all;       /* with k_s and those of the continuous extension alone */
  int part;      /* k_1 .. k_part have no weight in b, e, d */
  int order;     /* the error is h^order */
  int dense;     /* coefficients of the continuous extension */
  double border; /* of stability on the negative real axis, |h lambda| */
  const double *c;
  const double (*a)[NSDAE_TABLEAU_WIDTH];
  const double *e5, *e3;
  const double (*d)[NSDAE_TABLEAU_WIDTH]; /* of the coefficients from the fifth on */
} nsdae_tableau;

extern const nsdae_tableau nsdae_dopri5, nsdae_dop853;

typedef struct nsdae_runge_kutta {
  int n,
      controlled; /* the error's estimate is of the first of y; f does not depend on the others */
  int positions;  /* how many there are, or 0 */
  int forces;     /* behind what is controlled: integrals of forces, whose error is bounded too */
  double force;   /* smaller forces are none to that bound */
  double rtol, atol, max_step, span;
  /* 0 done, > 0 try a smaller step, < 0 give up; whole: not only of what is controlled */
  int (*rate)(double t, const double *y, double *ydot, int whole, void *user);
  void *user;
  const nsdae_tableau *pair; /* changed before a start only */
  double t, h, last,
      from; /* where it is; the next step; the last one, the extension's: its start */
  double *y, *k[NSDAE_TABLEAU_WIDTH]; /* n: at t; of the last step, k[stages] belongs to t */
  double *dense[NSDAE_TABLEAU_DENSE]; /* n: of the last step */
  double *trial, *sum;                /* n */
  double way, rough;                  /* l; see nsdae_runge_kutta_is_rough */
  int border, is_dense; /* steps at the border of stability, less those that were not; dense is */
  nsdae_progress progress;
} nsdae_runge_kutta;

/* Takes the arrays; n and controlled are set before. */
void nsdae_runge_kutta_layout(nsdae_runge_kutta *rk, nsdae_arena *arena);

/* Starts (anew) at t, y [n]; h: the next step before, or 0. NSDAE_OK; NSDAE_E_CALLBACK where f
 * gives up or refuses its point. */
int nsdae_runge_kutta_start(nsdae_runge_kutta *rk, double t, const double *y);

/* One step of its own choice. NSDAE_OK; NSDAE_E_CONVERGENCE where no step is short enough;
 * NSDAE_E_CALLBACK. */
int nsdae_runge_kutta_advance(nsdae_runge_kutta *rk);

/* Back to the start of the last step; the next one is that part of it. */
void nsdae_runge_kutta_retreat(nsdae_runge_kutta *rk, double part);

/* The last step again, from its start to a t within it: no stage is evaluated beyond. 0, or a code
 * of f, after which there is no last step. */
int nsdae_runge_kutta_land(nsdae_runge_kutta *rk, double t);

/* The first `count` of y at t within the last step; before the first, where it started. NSDAE_OK;
 * NSDAE_E_CALLBACK where f gives up, NSDAE_E_CONVERGENCE where it refuses a stage. */
int nsdae_runge_kutta_read(nsdae_runge_kutta *rk, double t, int count, double *y);

/* Whether the last step was read inside, and f has a kink there that the step's end does not show:
 * a shorter step is needed. */
int nsdae_runge_kutta_is_rough(const nsdae_runge_kutta *rk);

/* Whether steps have for long been held back by stability, not by accuracy: f is stiff. */
int nsdae_runge_kutta_stiff(const nsdae_runge_kutta *rk);

#endif
