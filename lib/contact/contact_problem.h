/* The contact problem of a step: the one way in from the methods. The equations of a step are
 *
 *   M v + Phi_q^T Lambda = r + W Lambda_c,   Phi_q v = -Phi_t,   contact laws
 *
 * for fixed contacts as one island, the system (contacts.h), for a contact list island by island
 * (island_dispatch.h). A closed contact has a number, its place in the impulses and in the rows of
 * the terms: that of a fixed contact is its own, those of a list count from 0 in the order of the
 * list. Contacts of a list start from their impulses in the step before, by id. */
#ifndef NSDAE_CONTACT_PROBLEM_H
#define NSDAE_CONTACT_PROBLEM_H

#include "island_dispatch.h"
#include "listed.h"

typedef struct nsdae_problem {
  const nsdae_system *system;
  nsdae_error *error;
  int least_norm;           /* of redundant constraints, instead of NSDAE_E_RANK */
  nsdae_kkt *kkt;           /* of fixed contacts; NULL: a list */
  nsdae_contacts *contacts; /* the same */
  nsdae_closed *closed;     /* of a list, of the step in work */
  nsdae_impulses *results;  /* of the step in work */
  const nsdae_terms *home;  /* where the contacts were found closed */
  int *item, *place;        /* entries of the list there; in another list */
  nsdae_coefficients *law;
  nsdae_ids ids;
  int *hit; /* islands with an impact */
  nsdae_island_dispatch dispatch;
} nsdae_problem;

/* For a contact list: NSDAE_OK or NSDAE_E_MEMORY. Released as far as it was made. */
int nsdae_problem_make(nsdae_problem *problem, const nsdae_system *system, int threads,
                       nsdae_error *error);
void nsdae_problem_release(nsdae_problem *problem);
/* Settings, which may change between runs; kkt and contacts are those of fixed contacts. */
void nsdae_problem_prepare(nsdae_problem *problem, const nsdae_lcp_options *options,
                           double rank_tol);
void nsdae_problem_layout(nsdae_problem *problem, nsdae_arena *arena);
int nsdae_problem_grow(nsdae_problem *problem, const nsdae_room *contacts, const nsdae_room *rows);

/* Closes the contacts with a gap that is not above zero at the terms' point: into closed, results,
 * as they were in last, was. NSDAE_OK; of a list NSDAE_ARRAYS_GROW, NSDAE_E_ARGUMENT if an id comes
 * twice, the failure of the callback. */
int nsdae_problem_close_list(nsdae_problem *problem, nsdae_terms *terms, const nsdae_closed *last,
                             const nsdae_impulses *was);
static inline int nsdae_problem_close(nsdae_problem *p, nsdae_terms *terms, nsdae_closed *closed,
                                      nsdae_impulses *results, const nsdae_closed *last,
                                      const nsdae_impulses *was)
{
  p->closed = closed;
  p->results = results;
  p->home = terms;
  if (!p->contacts) return nsdae_problem_close_list(p, terms, last, was);
  nsdae_contacts_close(p->contacts, terms, results);
  return NSDAE_OK;
}
/* The same contacts at another point; those of a list that are not within reach keep their
 * directions. */
int nsdae_problem_update(nsdae_problem *problem, nsdae_terms *terms, double reach);

/* How many are closed, and the number of the a-th; whether there is anything to solve for. */
static inline int nsdae_problem_count(const nsdae_problem *p)
{
  return p->contacts ? p->contacts->active_count : p->closed->count;
}
static inline int nsdae_problem_contact(const nsdae_problem *p, int a)
{
  return p->contacts ? p->contacts->active[a] : a;
}
/* Their coefficients, by number. */
static inline const nsdae_coefficients *nsdae_problem_laws(const nsdae_problem *p)
{
  return p->contacts ? p->system->contact : p->law;
}
static inline int nsdae_problem_any(const nsdae_problem *p)
{
  return p->contacts ? nsdae_contacts_any(p->contacts) : p->closed->count > 0;
}

/* Velocities W^T v + w of the closed contacts, of all or of those with an impact, into before. */
void nsdae_problem_before(nsdae_problem *problem, const nsdae_terms *terms, const double *v,
                          int impacts_only);
/* Factors M and the terms' Phi_q, or finds the islands; hold: redundant rows as before, of fixed
 * contacts. NSDAE_OK, NSDAE_E_MASS, NSDAE_E_RANK with the record. */
int nsdae_problem_find_islands(nsdae_problem *problem, const nsdae_terms *terms);
static inline int nsdae_problem_factor(nsdae_problem *p, nsdae_terms *terms, const double *M,
                                       int hold)
{
  nsdae_solved *solved = &p->dispatch.solved;
  if (!p->kkt) return nsdae_problem_find_islands(p, terms);
  p->kkt->hold = hold;
  int status = nsdae_terms_factor(terms, M, p->kkt, p->least_norm);
  p->kkt->hold = 0;
  solved->rank = p->kkt->rank;
  solved->kept = p->kkt->kept;
  solved->left = p->kkt->left;
  return status;
}
/* After it: which islands have an impact. */
void nsdae_problem_mark_hit(nsdae_problem *problem);

/* v and lambda, which comes as -Phi_t, of r; size: how large the terms of v were, if there is
 * anything closed. Without contacts it is as if none were. */
int nsdae_problem_solve(nsdae_problem *problem, const nsdae_terms *terms, const double *M,
                        const double *r, int with_contacts, double *v, double *size,
                        double *lambda);
/* r := M^-1 r; NSDAE_OK or NSDAE_E_MASS. */
int nsdae_problem_solve_mass(nsdae_problem *problem, const double *M, double *r);

/* y += scale Phi_q^T lambda over the islands without impact; y += scale W Lambda, skip_impacts
 * leaves out the closed contacts with one, and with any such the frictional joints. */
void nsdae_problem_add_constraints(const nsdae_problem *problem, const nsdae_terms *terms,
                                   double scale, int any_impact, const double *lambda, double *y);
void nsdae_problem_add_impulse(const nsdae_problem *problem, const nsdae_terms *terms, double scale,
                               int skip_impacts, double *y);

/* Work of the impulses; what of it the moving surfaces of a list did: sum of Lambda w; residual. */
double nsdae_problem_work(const nsdae_problem *problem);
double nsdae_problem_carried(const nsdae_problem *problem, const nsdae_terms *terms);
double nsdae_problem_residual(const nsdae_problem *problem);

#endif
