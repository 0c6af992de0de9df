/* The large islands, and those of true cones: one problem of impulses by blocks, in its global form
 *
 *   M v = r + [W, -Phi_q^T] (Lambda, .),  u = W^T v + w + e v(-),  Phi_q v + Phi_t = 0
 *
 * (see nsdae/friction.h), warm from the last impulses. v is formed again from the impulses; what of
 * it is smaller than the certificate can tell from zero, is zero. */
#ifndef NSDAE_PILE_H
#define NSDAE_PILE_H

#include <nsdae/friction.h>

#include "local.h"

typedef struct nsdae_pile {
  nsdae_friction_solver *solver;
  nsdae_friction_options options;
  nsdae_friction_options last; /* those that the last problem was solved with */
  nsdae_friction_info info;    /* of the last problem */
  nsdae_friction_problem problem;
  int items, m, parts;
  size_t values, squares;
  int *number; /* blocks of the system: its number in the problem */
  int *member; /* blocks of the problem: that of the system */
  int *size;   /* blocks */
  double *M, *f;
  int *item;                      /* contact or row of each item */
  int *rows;                      /* contacts */
  double *mu, *w, *r, *u, *guess; /* guess: where the solver began */
  int *first, *block;
  double *value;
  double *L;     /* of the largest block */
  double slow;   /* velocities of contacts below it are none */
  double *lever; /* nv of the system: the largest entry of H along each velocity */
} nsdae_pile;

/* system: sizes; then room for contacts, for their values and those of rows of Phi_q. */
void nsdae_pile_layout(nsdae_pile *pile, const nsdae_system *system, nsdae_arena *arena);
int nsdae_pile_grow(nsdae_pile *pile, const nsdae_system *system, const nsdae_room *contacts,
                    const nsdae_room *rows);
void nsdae_pile_release(nsdae_pile *pile);

/* An empty problem; an island more; the solution of all. NSDAE_OK, NSDAE_E_MASS, NSDAE_E_LCP,
 * NSDAE_E_INFEASIBLE, NSDAE_E_NONFINITE, NSDAE_E_MEMORY with the record. */
void nsdae_pile_begin(nsdae_pile *pile);
void nsdae_pile_add_contacts(nsdae_pile *pile, const nsdae_whole *whole, int island);
void nsdae_pile_add_rows(nsdae_pile *pile, const nsdae_whole *whole, int island);
int nsdae_pile_solve(nsdae_pile *pile, const nsdae_whole *whole, double tol, nsdae_error *error);

#endif
