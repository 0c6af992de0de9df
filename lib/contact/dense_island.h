/* An island whose contacts are one complementarity problem in dense arrays, with its proofs
 * (kkt.h, contacts.h). It has those with few rows of such a problem, of the one block of a system
 * some more, and whatever their size polygons and frictional joints with a load, with cones in turn
 * (cones.h).
 * Where the island is the whole system, it is read and written where it stands; else its blocks are
 * gathered. One factorisation does for all solutions with it. */
#ifndef NSDAE_DENSE_ISLAND_H
#define NSDAE_DENSE_ISLAND_H

#include "island_equations.h"

/* Velocities, rows of Phi_q and of the complementarity problem of an island; of one that has
 * contacts and constraints; rows of the problem where the system is one block: a column of 100
 * unilateral contacts in one block takes 274 us. */
enum {
  NSDAE_DENSE_V = 48,
  NSDAE_DENSE_M = 36,
  NSDAE_DENSE_ROWS = 48,
  NSDAE_DENSE_JOINTED = 480,
  NSDAE_DENSE_ONE = 150
};

/* Velocities, rows of Phi_q and the parts of these, contacts, rows of the problem. */
typedef struct nsdae_dense_size {
  int n, m, parts, contacts, rows;
} nsdae_dense_size;

/* Blocks and rows of an island that is a part of the system; of a block of the system, where
 * its velocities begin in it, and its number in it. */
typedef struct nsdae_gathered {
  nsdae_blocks blocks;
  nsdae_rows J; /* values are the terms' */
  double *M, *r, *v, *size, *lambda;
  int *start, *number;
} nsdae_gathered;

/* The island at hand: of the system or gathered. */
typedef struct nsdae_island_view {
  const nsdae_blocks *blocks;
  const nsdae_rows *J;
  const double *M, *r;
  double *v, *size, *lambda;
  int whole;
} nsdae_island_view;

typedef struct nsdae_dense_island {
  nsdae_kkt kkt;
  nsdae_contacts contacts;
  nsdae_dense_size most, need; /* that there is room for; that an island had */
  nsdae_gathered gathered;
  nsdae_island_view at;
  long factored;         /* number of the factorisation of kkt */
  long closed;           /* of the contacts, if they are those of the whole system; else -1 */
  int island;            /* it is of */
  int solves;            /* the last solution was of a contact problem */
  double *free, *column; /* n: M^-1 r less v; M^-1 W of a column */
  double *asked;         /* m: -Phi_t */
  double *was;           /* contacts: impulses of another solution */
  int *basis;            /* bases before it */
  nsdae_arena arena;
} nsdae_dense_island;

/* of: settings of the contacts of the whole. */
void nsdae_dense_island_prepare(nsdae_dense_island *dense, const nsdae_contacts *of,
                                nsdae_error *error, double rank_tol);
/* Room for the islands that fit, rows: of the list of rows of Phi_q; and for one that needed more.
 * NSDAE_OK or NSDAE_E_MEMORY. */
int nsdae_dense_island_grow(nsdae_dense_island *dense, const nsdae_room *rows);
void nsdae_dense_island_release(nsdae_dense_island *dense);

/* Whether an island fits; whether each of the system does. */
int nsdae_dense_island_fits(const nsdae_dense_island *dense, const nsdae_island_equations *whole,
                            int island);
int nsdae_dense_island_fits_all(const nsdae_dense_island *dense);

/* v and lambda of the island's blocks and rows from r and lambda = -Phi_t, without contacts or
 * with them and their impulses, modes and velocities after; residual: of the contacts and their
 * rows, if there are contacts. NSDAE_OK; NSDAE_ARRAYS_GROW; NSDAE_E_MASS, and NSDAE_E_RANK unless
 * least_norm allows it, of kkt without a record; others of kkt, without; NSDAE_E_LCP,
 * NSDAE_E_INFEASIBLE, NSDAE_E_NONFINITE with it. */
int nsdae_dense_island_solve(nsdae_dense_island *dense, const nsdae_island_equations *whole,
                             int island, int least_norm, nsdae_natural_residual *residual);

/* r := M^-1 r of the whole system. 0 if the last factorisation was of something else. */
int nsdae_dense_island_solve_mass(const nsdae_dense_island *dense, long factorisation, double *r);

#endif
