/* The solution of the equations island by island, each by a solver that fits it (worker.h), on
 * several threads if asked for, to the same bits. */
#ifndef NSDAE_ISLAND_DISPATCH_H
#define NSDAE_ISLAND_DISPATCH_H

#include "thread_pool.h"
#include "worker.h"

typedef struct nsdae_island_dispatch {
  nsdae_error *error;
  nsdae_contact_islands islands;
  nsdae_factorisation factorisation;
  nsdae_cone_island kept; /* the largest of the second pass */
  nsdae_thread_pool *pool;
  nsdae_contact_shares shares; /* of the contact lists */
  nsdae_worker *worker;
  int workers;
  nsdae_solved sum;           /* over the workers */
  const nsdae_solved *solved; /* of the last equations: that, or of one worker */
} nsdae_island_dispatch;

/* NSDAE_OK; NSDAE_E_MEMORY without memory or threads. Released as far as it was made. */
int nsdae_island_dispatch_make(nsdae_island_dispatch *dispatch, const nsdae_system *system,
                               int threads, nsdae_error *error);
void nsdae_island_dispatch_release(nsdae_island_dispatch *dispatch);
/* Settings, which may change between runs. */
void nsdae_island_dispatch_prepare(nsdae_island_dispatch *dispatch, const nsdae_contacts *of,
                                   double rank_tol, int least_norm);
void nsdae_island_dispatch_rank(nsdae_island_dispatch *dispatch, double rank_tol, int least_norm);
void nsdae_island_dispatch_layout(nsdae_island_dispatch *dispatch, const nsdae_system *system,
                                  nsdae_arena *arena);
int nsdae_island_dispatch_grow(nsdae_island_dispatch *dispatch, const nsdae_system *system,
                               const nsdae_room *contacts, const nsdae_room *rows);

/* Memory of the sparse factors of the rows of Phi_q at the terms' point, which the islands of these
 * rows find there: NSDAE_OK or NSDAE_E_MEMORY. */
int nsdae_island_dispatch_reserve(nsdae_island_dispatch *dispatch, const nsdae_terms *terms);

/* v and lambda of every island and of free blocks, and the impulses; a status with the record of
 * the first island that failed. */
int nsdae_island_dispatch_solve(nsdae_island_dispatch *dispatch, nsdae_island_equations *whole);

/* r := M^-1 r, M of the terms' point and of the last solution; NSDAE_OK or NSDAE_E_MASS. */
int nsdae_island_dispatch_solve_mass(nsdae_island_dispatch *dispatch, const nsdae_terms *terms,
                                     double *r);

#endif
