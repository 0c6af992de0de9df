/* Newmark's rule (gamma = 1/2, beta = 1/4) on the index-1 form with Baumgarte's stabilisation,
 * Eq. (6) of Zhang, Gu and Sun:
 *
 *   [ M      Phi_q^T ] [ a      ]   [ F                                                    ]
 *   [ Phi_q  0       ] [ lambda ] = [ -omega - 2 alpha (Phi_q v + Phi_t) - beta^2 Phi      ]
 *   q1 = q0 + h v0 + h^2/4 (a0 + a1),   v1 = v0 + h/2 (a0 + a1)
 *
 * of second order, solved for a1 by fixed-point iteration. Where dq/dt = H(q) v, q1 takes the mean
 * of H v at both ends. */
#ifndef NSDAE_NEWMARK_H
#define NSDAE_NEWMARK_H

#include <nsdae/sim.h>

#include "terms.h"

typedef struct nsdae_newmark {
  const nsdae_system *system;
  nsdae_error *error;
  /* M a + Phi_q^T lambda = r, Phi_q a = c at the terms' point, with c in lambda; a status */
  int (*solve)(void *of, nsdae_terms *terms, const double *r, double *a, double *lambda);
  void *of;
  const nsdae_sim_options *options; /* alpha and beta, the most iterations */
  double tol;
  int iterations;                /* of the last step */
  int have_start;                /* a0 and lambda0 belong to the start of the next step */
  double *a0, *lambda0;          /* nv, m: the caller's, who keeps them from step to step */
  double *a1, *lambda1;          /* nv, m */
  double *q, *v, *qdot0, *qdot1; /* nq, nv, nq, nq */
} nsdae_newmark;

/* system, error and options are set before; solve, tol, a0 and lambda0 before a step. */
void nsdae_newmark_layout(nsdae_newmark *newmark, nsdae_arena *arena);

/* One step of length h from start into end, at t_end, which is that up to rounding. multiplier
 * [m]: mean lambda. NSDAE_OK; NSDAE_E_CONVERGENCE; what the terms return. */
int nsdae_newmark_step(nsdae_newmark *newmark, nsdae_terms *start, nsdae_terms *end, double t_end,
                       double h, double *multiplier);

#endif
