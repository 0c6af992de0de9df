/* An island of one contact, frictionless or planar, without constraints: in closed form. With the
 * Delassus matrix G [2 x 2] and the velocities b without impulse,
 *
 *   open    b_N >= 0,                     Lambda = 0
 *   stick   G Lambda = -b,                Lambda_N > 0,  |Lambda_T| <= mu Lambda_N
 *   slide   Lambda_T = -s mu Lambda_N,    xi_N = 0,  s xi_T >= 0,    s = +-1
 *
 * the first of these that holds. Where none does, or more than rounding is left of a law, the
 * complementarity problem is asked (dense_island.h). */
#ifndef NSDAE_SINGLE_H
#define NSDAE_SINGLE_H

#include "island_equations.h"

enum { NSDAE_SINGLE_COLUMNS = 2 };

/* One block: its factor, its directions W, U = M^-1 W, the velocity without impulse. */
typedef struct nsdae_single_side {
  int b, n, at;
  nsdae_block_factor factor;
  double L[NSDAE_CONTACT_WIDTH * NSDAE_CONTACT_WIDTH], U[NSDAE_SINGLE_COLUMNS][NSDAE_CONTACT_WIDTH],
      v[NSDAE_CONTACT_WIDTH];
} nsdae_single_side;

typedef struct nsdae_single {
  int contact, sides, columns;
  nsdae_single_side side[2];
  double mu, G[NSDAE_SINGLE_COLUMNS][NSDAE_SINGLE_COLUMNS], b[NSDAE_SINGLE_COLUMNS]; /* offsets */
  double x[NSDAE_SINGLE_COLUMNS];                                                    /* Lambda */
} nsdae_single;

/* Whether an island is of this kind. */
int nsdae_single_fits(const nsdae_island_equations *whole, int island);

/* v of its blocks, impulse, mode and velocities after. 1 where it is solved, else 0; residual: the
 * residual of the laws, at rounding level. */
int nsdae_single_solve(nsdae_single *single, const nsdae_island_equations *whole, int island,
                       nsdae_natural_residual *residual);

#endif
