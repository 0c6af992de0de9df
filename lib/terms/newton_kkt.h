/* Newton's equations of an index-1 problem of mechanics: the saddle-point matrix of
 * A = M + D / cj + K / cj^2 (newton_matrix.h) and Phi_q, with a border (border.h) of contact
 * forces. */
#ifndef NSDAE_TERMS_NEWTON_KKT_H
#define NSDAE_TERMS_NEWTON_KKT_H

#include "border.h"
#include "newton_matrix.h"

typedef struct nsdae_newton_kkt {
  nsdae_newton_matrix matrix;
  nsdae_kkt kkt;
  nsdae_border border;
  int started; /* the pattern is known */
} nsdae_newton_kkt;

/* Takes the arrays, for `most` forces; make allocates more, which release frees. NSDAE_OK or
 * NSDAE_E_MEMORY. */
void nsdae_newton_kkt_layout(nsdae_newton_kkt *newton, const nsdae_system *system, int most,
                             double rank_tol, nsdae_arena *arena);
int nsdae_newton_kkt_make(nsdae_newton_kkt *newton);
void nsdae_newton_kkt_release(nsdae_newton_kkt *newton);

/* The pattern of A and the sparse factors' analysis at the terms' point, once: allocates what a run
 * needs. NSDAE_OK, NSDAE_E_MEMORY, what the terms and callbacks return. */
int nsdae_newton_kkt_start(nsdae_newton_kkt *newton, nsdae_terms *terms);

/* Factors K at the terms' point, with the independent rows of a basis (nsdae_kkt_factor_in). No
 * force is in the border yet. A status with the record. */
int nsdae_newton_kkt_factor(nsdae_newton_kkt *newton, nsdae_terms *terms, double cj,
                            const double *basis, int rank);

#endif
