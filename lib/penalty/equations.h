/* The equations of a smooth system with continuous contact forces (see penalty_law.h):
 *
 *   y = [q, v, Lambda, I_N, I_T, I_S, E, A]
 *   q' = H v,   [M Phi_q^T; Phi_q 0] [v'; lambda] = [F + W_N F_N + W_T F_T + W_S F_S;
 *                                                    -omega - 2 alpha Phi' - beta^2 Phi]
 *   Lambda' = lambda,  I' = the contact forces,  E' = -(F_N v_N + F_T v_T + F_S v_S)
 *   A' = F v + lambda Phi_t - F_N w_N - F_T w_T - F_S w_S + v^T M' v / 2,
 *   so that v^T M v / 2 should gain A - E; the errors of A are not controlled */
#ifndef NSDAE_PENALTY_EQUATIONS_H
#define NSDAE_PENALTY_EQUATIONS_H

#include "base.h"
#include "penalty_law.h"
#include "places.h"
#include "power.h"

/* Forces at the last evaluation. */
typedef struct nsdae_penalty_forces {
  double *normal, *tangential, *frictional_joint; /* k, k nt, f */
  double *v_n, *v_t, *v_s;                        /* velocities there */
  double *lambda;                                 /* m */
  double *U, *D; /* nv x f, m x f: a unit friction force on each slide */
} nsdae_penalty_forces;

typedef struct nsdae_penalty_equations {
  nsdae_stepper *stepper;
  nsdae_penalty_force law;
  nsdae_penalty_base base; /* within the memory of the step in work: how its contacts began */
  nsdae_penalty_forces at;
  double *shift; /* k: where a gap counts as zero */
  nsdae_power power;
} nsdae_penalty_equations;

void nsdae_penalty_equations_layout(nsdae_penalty_equations *equations, nsdae_arena *arena);

/* y', and the gaps, of whoever integrates; user: the equations. 0, or a code of ode.h. */
int nsdae_penalty_rate(double t, const double *y, double *ydot, void *user);
int nsdae_penalty_gaps(double t, const double *y, double *g, void *user);

/* Terms, matrices and forces at (t, y). NSDAE_OK, or what the terms return. */
int nsdae_penalty_evaluate(nsdae_penalty_equations *equations, double t, const double *y);

#endif
