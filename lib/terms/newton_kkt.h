/* The equations of motion in implicit form, y = [q, v, lambda, forces], as an index-1 problem:
 *
 *   r_q = q' - H v,   r_v = M v' + Phi_q^T lambda - F - W phi
 *   r_lambda = Phi_q v' + omega + 2 alpha Phi' + beta^2 Phi
 *
 * all but r_q at q* = q - r_q / cj, see ida.h; and Newton's method for them. With dq = (H dv - r_q)
 * / cj, l = dlambda / cj, A = M + D / cj + K / cj^2, and without what is small as
 * 1 / cj is, the change of M, Phi_q and W along the motion:
 *
 *   A dv + Phi_q^T l - W dphi / cj = r_v / cj,   Phi_q dv = r_lambda / (cj + 2 alpha + beta^2 / cj)
 *
 * The rows of the forces are the border (border.h). */
#ifndef NSDAE_TERMS_NEWTON_KKT_H
#define NSDAE_TERMS_NEWTON_KKT_H

#include "border.h"
#include "block_list.h"
#include "terms.h"

/* ---- The matrix of Newton's method in implicit integration. With c_j dq = H dv,
 *
 *   A = M + D / c_j + K / c_j^2,   D = -dF/dv,   K = -(dF/dq) H   [nv x nv, by blocks]
 *
 * in the symmetric parts of D and K. They come from the callbacks; else from one-sided differences
 * of F. Blocks of velocities that no row of the pattern has in common are displaced together
 * (Curtis, Powell and Reid, IMA J. Appl. Math. 13 (1974) 117; greedy colouring at distance two:
 * Coleman and More, SIAM J. Numer. Anal. 20 (1983) 187). The pattern: blocks that share a row of
 * Phi_q, and blocks that a callback coupled. A pair outside of it is missing from A: Newton's
 * method is slower then, and has the same solution. */

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

/* A pattern without couplings, which is that of a system of one block; its pairs are released by
 * nsdae_block_pairs_release. NSDAE_OK or NSDAE_E_MEMORY.
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

/* ---- newton_kkt.c */

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

/* Factors K at the terms' point, with the independent rows of a basis (nsdae_kkt_factor_coupled).
 * No force is in the border yet. A status with the record. */
int nsdae_newton_kkt_factor(nsdae_newton_kkt *newton, nsdae_terms *terms, double cj,
                            const double *basis, int rank);

/* Of y [n] and y': r_q, and room [nq + nv] := q*, v. */
int nsdae_newton_kkt_move(nsdae_terms *terms, double t, const double *y, const double *ydot,
                          double cj, double *room, double *r);

/* r_v without forces, and r_lambda, at the terms' point. */
void nsdae_newton_kkt_residual(const nsdae_terms *terms, double alpha, double beta, const double *y,
                               const double *ydot, double *r);

/* The first nq + nv + m of x = dy from those of r, and phi [count] from the right-hand sides of the
 * border to dphi / cj. */
int nsdae_newton_kkt_solve(const nsdae_newton_kkt *newton, nsdae_terms *terms, double cj,
                           double alpha, double beta, const double *r, double *x, double *phi);

#endif
