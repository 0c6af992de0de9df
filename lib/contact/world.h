/* The contacts by list of a step, and the equations of a step of a system by blocks:
 *
 *   M v + Phi_q^T Lambda = r + W Lambda_c,   Phi_q v = -Phi_t,   contact laws
 *
 * solved island by island (worker.h), on several threads where that is asked for, to the same bits.
 * Each contact begins with what it did in the step before, by its id. */
#ifndef NSDAE_WORLD_H
#define NSDAE_WORLD_H

#include "thread_pool.h"
#include "listed.h"
#include "worker.h"

typedef struct nsdae_world {
  const nsdae_system *system;
  nsdae_error *error;
  nsdae_closed *closed; /* of the step in work, with what they do */
  nsdae_impulses *results;
  const nsdae_terms *home; /* where they were found closed */
  int *item, *place;       /* their entries there; in another list */
  nsdae_coefficients *law;
  nsdae_ids ids;
  nsdae_graph islands;
  int *hit; /* islands with an impact */
  nsdae_pile pile;
  nsdae_thread_pool *crew;
  nsdae_worker *worker;
  int workers;
  nsdae_solved solved; /* of the last equations */
} nsdae_world;

/* NULL without memory or threads. Released as far as it was made. */
nsdae_world *nsdae_world_make(const nsdae_system *system, int threads, nsdae_error *error);
void nsdae_world_release(nsdae_world *world);
/* Settings, which may change between runs. */
void nsdae_world_prepare(nsdae_world *world, const nsdae_lcp_options *options, double rank_tol,
                         int least_norm);
void nsdae_world_layout(nsdae_world *world, nsdae_arena *arena);
int nsdae_world_grow(nsdae_world *world, const nsdae_room *contacts, const nsdae_room *rows);

/* Closes the contacts with a gap that is not above zero at the terms' point: into closed, results,
 * as they were in last, was. NSDAE_OK, NSDAE_ARRAYS_GROW, NSDAE_E_ARGUMENT where an id comes twice,
 * what the callback failed with. */
int nsdae_world_close(nsdae_world *world, nsdae_terms *terms, nsdae_closed *closed,
                      nsdae_impulses *results, const nsdae_closed *last, const nsdae_impulses *was);
/* The same contacts at another point; those that are no longer within reach keep their directions.
 */
int nsdae_world_meet(nsdae_world *world, nsdae_terms *terms, double reach);

/* Velocities W^T v + w of the closed contacts, of all or of those with an impact, into before. */
void nsdae_world_before(nsdae_world *world, const nsdae_terms *terms, const double *v,
                        int impacts_only);
/* Finds the islands of the closed contacts and of the terms' rows; NSDAE_OK or NSDAE_E_RANK. */
int nsdae_world_join(nsdae_world *world, const nsdae_terms *terms);
/* Which islands have an impact. */
void nsdae_world_mark_hit(nsdae_world *world);

/* v and lambda, which comes as -Phi_t, of r; size: how large the terms of v were. Without contacts
 * it is as if none were closed. */
int nsdae_world_solve(nsdae_world *world, const nsdae_terms *terms, const double *M,
                      const double *r, int with_contacts, double *v, double *size, double *lambda);

/* y += scale Phi_q^T lambda over the islands without impact; y += scale W Lambda of the closed
 * contacts, skip_impacts leaves out those with one. */
void nsdae_world_add_constraints(const nsdae_world *world, const nsdae_terms *terms, double scale,
                                 const double *lambda, double *y);
void nsdae_world_add_impulse(const nsdae_world *world, const nsdae_terms *terms, double scale,
                             int skip_impacts, double *y);
/* r := M^-1 r by blocks; NSDAE_OK or NSDAE_E_MASS. */
int nsdae_world_solve_mass(nsdae_world *world, const double *M, double *r);

/* Work of the impulses, and what of it moving surfaces did: sum of Lambda w at the point. */
double nsdae_world_work(const nsdae_world *world);
double nsdae_world_carried(const nsdae_world *world, const nsdae_terms *terms);

#endif
