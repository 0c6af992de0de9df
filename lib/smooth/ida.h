/* A differential-algebraic problem of index 1 in implicit form, F(t, y, y') = 0, by SUNDIALS IDA:
 * backward differences of variable order 1 to 5 and step (Brenan, Campbell and Petzold, "Numerical
 * Solution of Initial-Value Problems in Differential-Algebraic Equations", SIAM 1996; Hindmarsh et
 * al., ACM Trans. Math. Softw. 31 (2005) 363), with the caller's factors of Newton's matrix
 *
 *   dF/dy + cj dF/dy',   cj = alpha / h
 *
 * Of a system of mechanics y = [q, v, a], with the algebraic unknowns a (multipliers and forces):
 *
 *   r_q = q' - H v,   r_v = M v' + J^T lambda - W f - F,   r_a = 0 at the level of accelerations
 *
 * The error is controlled of q and v alone, in the norm of SUNDIALS and with the weights of
 * runge_kutta.h. Newton's iteration converges in a too: IDA starts it from extrapolated a, whose
 * errors would grow from step to step. The bound is that of runge_kutta.h for the impulse of a step
 * h: h |da| <= 10 rtol times what the largest force makes in `longest`. The caller searches for
 * roots, on nsdae_ida_read. */
#ifndef NSDAE_IDA_H
#define NSDAE_IDA_H

#include <nsdae/status.h>

typedef struct nsdae_ida nsdae_ida;

/* Each callback: 0 done, > 0 try a smaller step, < 0 give up. */
typedef struct nsdae_ida_problem {
  int n, differential; /* entries of y; the first of them have a derivative in F: q and v */
  int positions;       /* q, the first of those */
  /* r [n] := F(t, y, y'). cj is that of the step in work. With it F may be evaluated at
   * q* = q - r_q / cj in place of q, what Newton's step makes of q without a change of v: the zeros
   * are the same, and the rest of Newton's system, dq* = H dv / cj, does not depend on r_q. */
  int (*residual)(double t, const double *y, const double *ydot, double cj, double *r, void *user);
  /* factors Newton's matrix at (t, y, y') with cj; the arrays are not to be kept */
  int (*setup)(double t, const double *y, const double *ydot, double cj, void *user);
  /* x [n] := solution with r [n] on the right, which may be written to, by the last factors. cj is
   * that of the step in work and differs from that of the factors by some tenths: where it stands
   * in the open, as in dq = (H dv + r_q) / cj, this one is right. */
  int (*solve)(double cj, double *r, double *x, void *user);
  void *user;
} nsdae_ida_problem;

/* Error weights: see runge_kutta.h; of positions, l = longest max |q'|. */
typedef struct nsdae_ida_tolerances {
  double rtol, atol, longest;
  double force;    /* smaller forces are none */
  double step_max; /* no step is longer; INFINITY: no bound */
} nsdae_ida_tolerances;

/* NSDAE_OK; NSDAE_E_MEMORY; NSDAE_E_UNSUPPORTED if the library was built without SUNDIALS. Nothing
 * is allocated later. */
int nsdae_ida_create(const nsdae_ida_problem *problem, nsdae_ida **ida);
void nsdae_ida_destroy(nsdae_ida **ida);

/* Starts (anew) at t from consistent y and ydot [n]: F(t, y, y') = 0. first: length of the first
 * step, or 0 for one from the size of y'. */
int nsdae_ida_start(nsdae_ida *ida, const nsdae_ida_tolerances *tolerances, double t,
                    const double *y, const double *ydot, double first);

/* One step of its own choice, from *t on entry to *t. NSDAE_OK; NSDAE_E_CALLBACK if a callback
 * failed; NSDAE_E_CONVERGENCE otherwise. Then *t is where it was, and nsdae_ida_failure names the
 * reason as SUNDIALS does. */
int nsdae_ida_advance(nsdae_ida *ida, double *t);
const char *nsdae_ida_failure(const nsdae_ida *ida);

/* y (derivative = 0) or y' (1) [n] at t within the last step, or at the start. NSDAE_OK, or
 * NSDAE_E_CONVERGENCE if t is outside of it. */
int nsdae_ida_read(nsdae_ida *ida, double t, int derivative, double *y);

#endif
