/* The bilateral rows b of a global problem are eliminated; the contacts c remain, in the local
 * form. With J = L^-1 H, S = J_b^T J_b + C_b = R R^T (Cholesky) and T = R^-1 J_b^T J_c,
 *
 *   W = J_c^T J_c - T^T T,   q = q_c - T^T R^-1 q_b,   R^T r_b = -(R^-1 q_b + T r_c)
 *
 * (static condensation; Guyan, AIAA J. 3 (1965) 380). Sweeps then need not carry impulses through
 * chains of joints row by row. S has an entry for two rows that share a block. It is factored in
 * its envelope (skyline; Jennings, Comput. J. 9 (1966) 281): in the order in which joints are
 * added, chains and trees of bodies have a narrow one. */
#ifndef NSDAE_FRICTION_STATIC_CONDENSATION_H
#define NSDAE_FRICTION_STATIC_CONDENSATION_H

#include "global_problem.h"

/* Part of a column of J_c on one block: its column of T has the rows low .. high - 1. */
typedef struct nsdae_fc_condensed_part {
  int block, low, high;
  const double *J;
  size_t at; /* in T */
} nsdae_fc_condensed_part;

/* S in its envelope. */
typedef struct nsdae_fc_envelope {
  int *start, *touching; /* blocks + 1: first of each in touching, the rows that touch it */
  int *first, *end;      /* rows: of the envelope; where its component of S ends */
  size_t *at;            /* rows + 1: of R */
  double *R;             /* by rows, each from first on */
} nsdae_fc_envelope;

typedef struct nsdae_fc_condensed {
  const nsdae_fc_global *global;
  nsdae_friction_problem problem; /* of the contacts */
  int rows, parts;                /* bilateral rows; parts of all columns of J_c */
  nsdae_fc_envelope S;
  int *column; /* columns of J_c + 1: its first part */
  nsdae_fc_condensed_part *part;
  double *T, *g;      /* g [rows]: R^-1 q_b */
  double *q, *W;      /* of the local problem */
  double *base;       /* m: an approximate solution, from which g and q correct; else zero */
  int *entry, *block; /* the same: first, block */
  size_t *item;       /* contacts: its first number of W */
  size_t sizes[3];    /* of R, T, W */
  nsdae_arena memory[2];
} nsdae_fc_condensed;

/* Condenses a problem without its masses. 1: done; 0: it has no such rows, it would be larger than
 * the problem, or the rows are dependent (to a sine of 1e-6); NSDAE_E_MEMORY. */
int nsdae_fc_condense(nsdae_fc_condensed *condensed, const nsdae_fc_global *global);

/* The same problem about the approximate solution r [m] with the velocities u [m] of the global
 * one: g = R^-1 u_b, q = u_c - T^T g - W r_c. Its solution is a step of iterative refinement
 * (Wilkinson, Rounding Errors in Algebraic Processes, 1963). */
void nsdae_fc_condensed_correct(nsdae_fc_condensed *condensed, const double *r, const double *u);

/* Bilateral entries of r [m] from those of the contacts. */
void nsdae_fc_condensed_multipliers(const nsdae_fc_condensed *condensed, double *r);

void nsdae_fc_condensed_release(nsdae_fc_condensed *condensed);

#endif
