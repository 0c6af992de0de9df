/* The large islands, and those of true cones: each a problem of impulses by blocks, in its global
 * form
 *
 *   M v = r + [W, -Phi_q^T] (Lambda, .),  u = W^T v + w + e v(-),  Phi_q v + Phi_t = 0
 *
 * (see nsdae/friction.h), warm from the last impulses. v is formed again from the impulses; what of
 * it is smaller than the certificate can tell from zero, is zero.
 *
 * All are gathered one behind the other, and then solved in any order. */
#ifndef NSDAE_PILE_H
#define NSDAE_PILE_H

#include <nsdae/friction.h>

#include "local.h"

/* Those of all islands, or from where one begins. */
typedef struct nsdae_pile_arrays {
  int *member; /* blocks of the problem: that of the system */
  int *size;   /* blocks */
  double *M, *f;
  int *item; /* contact or row of each item */
  int *rows; /* contacts */
  double *mu, *w, *r, *u;
  double *guess;      /* r before it was solved */
  int *first, *block; /* first: items + 1, of each island from 0 */
  double *value;
} nsdae_pile_arrays;

/* What islands before this one take of the arrays, and what it has itself. */
typedef struct nsdae_pile_part {
  int island, contacts;
  int driven; /* a velocity is asked of a row or a contact */
  int block, velocity, item, m, entry;
  size_t square, value;
  double tol; /* that it was solved with last */
  int refine;
} nsdae_pile_part;

/* A part's problem as it was solved last. */
typedef struct nsdae_pile_last {
  nsdae_friction_problem problem;
  nsdae_friction_options options;
  const double *guess, *r, *u;
} nsdae_pile_last;

typedef struct nsdae_pile {
  nsdae_pile_arrays at;
  int parts;
  nsdae_pile_part *part; /* parts + 1: the last one is their end */
  int *number;           /* blocks of the system: its number in its island */
  double *lever;         /* nv of the system: the largest entry of H along each velocity */
} nsdae_pile;

/* system: sizes; then room for contacts, for their values and those of rows of Phi_q. */
void nsdae_pile_layout(nsdae_pile *pile, const nsdae_system *system, nsdae_arena *arena);
int nsdae_pile_grow(nsdae_pile *pile, const nsdae_system *system, const nsdae_room *contacts,
                    const nsdae_room *rows);
void nsdae_pile_release(nsdae_pile *pile);

/* No island; one more. */
void nsdae_pile_begin(nsdae_pile *pile);
void nsdae_pile_add(nsdae_pile *pile, const nsdae_whole *whole, int island);

/* Solves a part, by a solver of its own: NSDAE_OK, NSDAE_E_MASS, NSDAE_E_LCP, NSDAE_E_INFEASIBLE,
 * NSDAE_E_NONFINITE, NSDAE_E_MEMORY with the record. L has room for a block; info: what the solver
 * says of it; misfit: its residual, not scaled. */
typedef struct nsdae_pile_work {
  nsdae_friction_solver *solver;
  double *L, tol;
  nsdae_error *error;
  nsdae_friction_info info;
  nsdae_misfit misfit;
} nsdae_pile_work;
int nsdae_pile_solve(const nsdae_pile *pile, const nsdae_whole *whole, int part,
                     nsdae_pile_work *work);

/* The part of most contacts, as it was solved. */
nsdae_pile_last nsdae_pile_largest(const nsdae_pile *pile);

#endif
