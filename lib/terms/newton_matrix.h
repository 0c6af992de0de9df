/* The matrix of Newton's method in implicit integration. With c_j dq = H dv,
 *
 *   A = M + D / c_j + K / c_j^2,   D = -dF/dv,   K = -(dF/dq) H   [nv x nv, by blocks]
 *
 * in the symmetric parts of D and K. They come from the callbacks; else from one-sided differences
 * of F. Blocks of velocities that no row of the pattern has in common are displaced together
 * (Curtis, Powell and Reid, IMA J. Appl. Math. 13 (1974) 117; greedy colouring at distance two:
 * Coleman and More, SIAM J. Numer. Anal. 20 (1983) 187). The pattern: blocks that share a row of
 * Phi_q, and blocks that a callback coupled. A pair outside of it is missing from A: Newton's
 * method is slower then, and has the same solution. */
#ifndef NSDAE_TERMS_NEWTON_MATRIX_H
#define NSDAE_TERMS_NEWTON_MATRIX_H

#include "block_list.h"
#include "terms.h"

typedef struct nsdae_newton_matrix {
  const nsdae_system *system;
  double *A;               /* diagonal blocks, in the layout of M */
  nsdae_coupling coupling; /* the blocks below them */
  nsdae_block_pairs pairs;
  nsdae_block_list list;
  int *colour, colours;        /* of each block; 0: no differences */
  int *last;                   /* blocks + 1: block that a colour was last refused to */
  double *q, *v, *qdot, *unit; /* nq, nv, nq, nv: a displaced point, a direction */
  double *F, *X;               /* nv; nv x nv: D or K of a system without blocks */
} nsdae_newton_matrix;

/* Takes the arrays; system is set before. */
void nsdae_newton_matrix_layout(nsdae_newton_matrix *matrix, nsdae_arena *arena);

/* A pattern without couplings, which is that of a system of one block. NSDAE_OK or NSDAE_E_MEMORY.
 */
int nsdae_newton_matrix_make(nsdae_newton_matrix *matrix);

/* The pattern at the terms' point. Allocates. NSDAE_OK, NSDAE_E_MEMORY, what the terms
 * and callbacks return. */
int nsdae_newton_matrix_start(nsdae_newton_matrix *matrix, nsdae_terms *terms);

/* Takes the pairs that were missing in the last evaluation (pairs.missed > 0) into the pattern.
 * Allocates: between steps only. NSDAE_OK or NSDAE_E_MEMORY. */
int nsdae_newton_matrix_grow(nsdae_newton_matrix *matrix);

/* A and coupling at the terms' point. NSDAE_OK, NSDAE_E_CALLBACK, NSDAE_E_NONFINITE,
 * NSDAE_E_ARGUMENT: a block that there is not. */
int nsdae_terms_newton_matrix(nsdae_terms *terms, double cj, nsdae_newton_matrix *matrix);

void nsdae_newton_matrix_release(nsdae_newton_matrix *matrix);

#endif
