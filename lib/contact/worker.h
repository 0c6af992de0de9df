/* What one thread solves islands with: each by the first solver that fits it.
 *
 *   pass  solver       island
 *   0     blocks       of small blocks, without constraints, as if no contact were closed
 *   0     one contact  no cone, no constraints, in closed form (single.h)
 *   0     dense        small, no cone; small with frictional joints; polygons (dense_island.h)
 *   0     constraints  no contacts: sparse equations (sparse_kkt.h)
 *   1     cones        the rest (cone_island.h); to a tolerance by its size (accuracy.h)
 *
 * Pass 0 are many small ones, pass 1 few large ones. An island is solved from what it is alone, and
 * writes what is its own: which worker does it, and after which others, changes no bit. */
#ifndef NSDAE_WORKER_H
#define NSDAE_WORKER_H

#include "cone_island.h"
#include "sparse_kkt.h"
#include "dense_island.h"
#include "single.h"

/* What an island leaves [velocity], see natural_residual.h, and its tolerance. */
typedef struct nsdae_island_residual {
  double left, tol;
} nsdae_island_residual;

typedef struct nsdae_solved {
  nsdae_natural_residual residual; /* of the contacts and their rows */
  nsdae_island_residual worst;     /* of the island that is furthest above its tolerance */
  long pivots;
  double tol;        /* the largest tolerance of them; 0: none was solved */
  double hidden;     /* of an island by its own speed, above its tolerance; 0: there is none */
  double kept, left; /* smallest sine that counts in the rank, largest that does not */
  double noise;      /* relative error that the cones leave in velocities; 0: none were solved */
  int lcps, rank, islands, contacts; /* contacts of the largest island */
  const nsdae_contacts *problem;     /* that failed, or of the only island; NULL: none, or not of
                                        this kind */
  const nsdae_single *single;        /* the same of one contact */
  const nsdae_cone_island *cones;    /* the largest of pass 1; NULL: there was none */
} nsdae_solved;

typedef struct nsdae_worker {
  nsdae_error error; /* of the island that failed */
  int failed;        /* which; -1: none */
  nsdae_dense_island dense;
  nsdae_single single;
  nsdae_sparse_kkt sparse;
  nsdae_cone_island cones;
  nsdae_friction_solver *solver;
  int all_dense; /* every island with constraints is */
  double *L;     /* of the largest block */
  nsdae_accuracy accuracy;
  int least_norm;
  nsdae_solved solved; /* by this worker, in the step at hand */
} nsdae_worker;

/* Another with what this one did: sums of whole numbers and maxima, in any order the same. */
void nsdae_solved_add(nsdae_solved *sum, const nsdae_solved *one);

/* An island in this pass: NSDAE_OK, NSDAE_NEXT: the next pass, or a failure with the record. */
enum { NSDAE_NEXT = 1 };
int nsdae_worker_solve(nsdae_worker *worker, const nsdae_island_equations *whole, int island,
                       int pass);

/* x [size of the block] := M_b^-1 x, M by the blocks of the terms; v of a block that nothing
 * touches. */
int nsdae_worker_solve_block(nsdae_worker *worker, const nsdae_terms *terms, const double *M, int b,
                             double *x);
int nsdae_worker_solve_free(nsdae_worker *worker, const nsdae_island_equations *whole, int b);

#endif
