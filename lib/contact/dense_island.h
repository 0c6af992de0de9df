/* A small island in dense arrays: its blocks and rows are gathered, its contacts stay where they
 * are, and are solved by what solves a small system as a whole (kkt.h, contacts.h), with its
 * proofs. */
#ifndef NSDAE_DENSE_ISLAND_H
#define NSDAE_DENSE_ISLAND_H

#include "island_equations.h"

enum { NSDAE_DENSE_V = 48, NSDAE_DENSE_M = 36, NSDAE_DENSE_ROWS = 48 };

typedef struct nsdae_dense_island {
  nsdae_kkt kkt; /* of the island at hand, one block */
  nsdae_rows J;  /* its rows of Phi_q */
  nsdae_contacts contacts;
  const double *M;        /* of one block that of the whole, else the one that follows */
  double *gathered;       /* NSDAE_DENSE_V^2 */
  double *r, *v, *size;   /* NSDAE_DENSE_V */
  double *free, *column;  /* the same: M^-1 r less v; M^-1 W of a column */
  double *lambda, *asked; /* NSDAE_DENSE_M; asked: -Phi_t */
  int *place;             /* of a block of the system: where it begins in the island at hand */
  int ends[2];            /* the island is one block, from 0 */
  size_t squares[2];      /* likewise, of M */
  nsdae_blocks blocks;
} nsdae_dense_island;

void nsdae_dense_island_prepare(nsdae_dense_island *dense, const nsdae_system *system,
                                nsdae_error *error, const nsdae_lcp_options *options,
                                double rank_tol);
void nsdae_dense_island_layout(nsdae_dense_island *dense, nsdae_arena *arena);

/* Whether an island fits. */
int nsdae_dense_island_fits(const nsdae_island_equations *whole, int island);

/* v and lambda of the island's blocks and rows from r and lambda = -Phi_t, without contacts or
 * with them and their impulses, modes and velocities after; residual: of the contacts and their
 * rows, if there are contacts. NSDAE_OK; NSDAE_E_MASS, and NSDAE_E_RANK unless least_norm allows
 * it, of kkt without a record; NSDAE_E_LCP, NSDAE_E_INFEASIBLE, NSDAE_E_NONFINITE with it. */
int nsdae_dense_island_solve(nsdae_dense_island *dense, const nsdae_island_equations *whole,
                             int island, int least_norm, nsdae_natural_residual *residual);

#endif
