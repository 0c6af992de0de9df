/* Large islands without friction and without constraints: the linear complementarity problem
 *
 *   0 <= Lambda _|_ A Lambda + b >= 0,   A = W^T M^-1 W,  b = W^T M^-1 r + w + e v(-)
 *
 * by a primal-dual active set (Hintermueller, Ito, Kunisch, SIAM J. Optim. 13 (2002) 865) that
 * begins with the contacts that pressed in the step before: A Lambda = -b on the set, and the next
 * set is where Lambda > 0 or the velocity < 0. A is factored in its envelope, with the contacts in
 * the order of Cuthill and McKee: stacks and strings are banded. If the envelope saves nothing, the
 * set does not converge, or contacts are dependent, the next solver is tried (cone_island.h). */
#ifndef NSDAE_ACTIVE_SET_ISLAND_H
#define NSDAE_ACTIVE_SET_ISLAND_H

#include "island_equations.h"

typedef struct nsdae_active_set_island {
  int count;             /* contacts of the island at hand */
  const int *contact;    /* them */
  int *order, *position; /* count; count: place in the order, -1: not yet */
  int *first, *of_block; /* contacts by block of the system: blocks + 1; 2 contacts */
  int *touched;          /* blocks of the system: its number in the island */
  size_t *part, *at;     /* of U: 2 a contact; of A: where a row's envelope ends */
  int *low;              /* first column of a row in its envelope */
  int *active;           /* count, in the order: in the set */
  double *U, *A, *L;     /* parts; envelopes */
  double *b, *x, *u, *rest;
  nsdae_natural_residual residual;
  int rounds;
} nsdae_active_set_island;

void nsdae_active_set_layout(nsdae_active_set_island *set, const nsdae_system *system,
                             nsdae_arena *arena);
int nsdae_active_set_grow(nsdae_active_set_island *set, const nsdae_room *contacts);
void nsdae_active_set_release(nsdae_active_set_island *set);

int nsdae_active_set_fits(const nsdae_island_equations *whole, int island);

/* v, impulses, modes and velocities after of an island that fits. 1 where it is solved to tol; 0:
 * another way must be found, and nothing is changed. */
int nsdae_active_set_solve(nsdae_active_set_island *set, const nsdae_island_equations *whole,
                           int island, double tol, double *L_block);

#endif
