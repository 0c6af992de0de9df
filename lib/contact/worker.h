/* What one thread solves islands with, each by what fits it: what is free by its mass alone, single
 * contacts in closed form (single.h), small ones as dense systems (local.h), large ones without
 * friction in their envelope (stack.h), true cones as problems by blocks (pile.h), large ones
 * without contacts as sparse equations (sparse_kkt.h).
 *
 * An island is solved from what it is alone, and writes what is its own: which worker does it, and
 * after which others, changes no bit. */
#ifndef NSDAE_WORKER_H
#define NSDAE_WORKER_H

#include "pile.h"
#include "sparse_kkt.h"
#include "stack.h"

typedef struct nsdae_solved {
  nsdae_misfit misfit; /* of the contacts and their rows */
  long pivots;
  double kept, left; /* smallest sine that counts in the rank, largest that does not */
  double noise;      /* relative error that the cones leave in velocities; 0: none were solved */
  int lcps, rank, islands, contacts; /* contacts of the largest island */
  const nsdae_contacts *problem;     /* that failed; NULL: none, or not of this kind */
  const nsdae_pile *pile;            /* of the islands with cones; NULL: there was none */
} nsdae_solved;

typedef struct nsdae_worker {
  nsdae_error error; /* of the island that failed */
  int failed;        /* which; -1: none */
  nsdae_local local;
  nsdae_stack stack;
  nsdae_sparse_kkt sparse;
  nsdae_friction_solver *solver;
  double *L; /* of the largest block */
  double tol;
  int least_norm;
  nsdae_solved solved; /* by this worker, in the step at hand */
} nsdae_worker;

void nsdae_worker_prepare(nsdae_worker *worker, const nsdae_system *system,
                          const nsdae_lcp_options *options, double rank_tol, int least_norm);
void nsdae_worker_layout(nsdae_worker *worker, const nsdae_system *system, nsdae_arena *arena);
/* Room for islands of all contacts: NSDAE_OK or NSDAE_E_MEMORY. */
int nsdae_worker_grow(nsdae_worker *worker, const nsdae_room *contacts);
void nsdae_worker_release(nsdae_worker *worker);

/* Nothing is solved yet. */
void nsdae_worker_begin(nsdae_worker *worker);

/* Another with what this one did: sums of whole numbers and maxima, in any order the same. */
void nsdae_solved_add(nsdae_solved *sum, const nsdae_solved *one);

/* An island; cones: 1 where it was left to nsdae_worker_solve_cones, else 0. A status, with the
 * record. */
int nsdae_worker_solve(nsdae_worker *worker, const nsdae_whole *whole, int island,
                       int with_contacts, int *cones);

/* A part of the pile. */
int nsdae_worker_solve_cones(nsdae_worker *worker, nsdae_pile *pile, const nsdae_whole *whole,
                             int part);

/* x [size of the block] := M_b^-1 x */
int nsdae_worker_solve_block(nsdae_worker *worker, const nsdae_system *system, const double *M,
                             int b, double *x);

#endif
