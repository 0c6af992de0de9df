/* The contact problem of a step: the one way in from the methods. The equations of a step are
 *
 *   M v + Phi_q^T Lambda = r + W Lambda_c,   Phi_q v = -Phi_t,   contact laws
 *
 * and are solved island by island (island_dispatch.h). A closed contact has a number, its place in
 * the impulses and in the rows of the terms: that of a fixed contact is its own, those of a list
 * count from 0 in the order of the list. Contacts start from their impulses in the step before. */
#ifndef NSDAE_CONTACT_PROBLEM_H
#define NSDAE_CONTACT_PROBLEM_H

#include <nsdae/sim.h>

#include "island_dispatch.h"
#include "listed.h"

/* Of the closed contacts of a list, by number. */
typedef struct nsdae_picked {
  int *item, *place; /* entries of it; of another list */
  nsdae_coefficients *law;
  nsdae_ids ids;
} nsdae_picked;

typedef struct nsdae_problem {
  const nsdae_system *system;
  nsdae_error *error;
  nsdae_contacts *contacts;      /* settings, and the bases of fixed contacts and joints */
  nsdae_closed *closed;          /* of the step in work */
  nsdae_impulses *results;       /* of the step in work */
  const nsdae_terms *home;       /* where the contacts were found closed */
  int count, *number;            /* closed contacts */
  const nsdae_coefficients *law; /* by number */
  nsdae_picked picked;
  nsdae_contact_warm warm;
  int *hit;                /* islands with an impact */
  double *joint_bound;     /* f: largest impulse of a frictional joint without a load */
  double *joint_own;       /* f: that without its friction circle */
  nsdae_joint_row *beside; /* f */
  nsdae_island_dispatch dispatch;
} nsdae_problem;

/* NSDAE_OK or NSDAE_E_MEMORY. Released as far as it was made. */
int nsdae_problem_make(nsdae_problem *problem, const nsdae_system *system, int threads,
                       nsdae_error *error);
void nsdae_problem_release(nsdae_problem *problem);
/* Settings, which may change between runs. */
void nsdae_problem_prepare(nsdae_problem *problem, nsdae_contacts *contacts, double rank_tol,
                           int least_norm);
void nsdae_problem_layout(nsdae_problem *problem, nsdae_arena *arena);
int nsdae_problem_grow(nsdae_problem *problem, const nsdae_room *contacts, const nsdae_room *rows);

/* Closes the contacts with a gap that is not above zero at the terms' point: into closed, results,
 * as they were in last, was. NSDAE_OK; of a list NSDAE_ARRAYS_GROW, NSDAE_E_ARGUMENT if an id comes
 * twice, the failure of the callback. */
int nsdae_problem_close(nsdae_problem *problem, nsdae_terms *terms, nsdae_closed *closed,
                        nsdae_impulses *results, const nsdae_closed *last,
                        const nsdae_impulses *was);
/* The same contacts at another point; those of a list that are not within reach keep their
 * directions. */
int nsdae_problem_update(nsdae_problem *problem, nsdae_terms *terms, double reach);

/* Whether there is anything to solve for. */
static inline int nsdae_problem_any(const nsdae_problem *p)
{
  return p->count + p->dispatch.islands.joints > 0;
}

/* Velocities W^T v + w of the closed contacts, of all, and of the frictional joints, or of those
 * with an impact, into before. */
void nsdae_problem_before(nsdae_problem *problem, const nsdae_terms *terms, const double *v,
                          int impacts_only);
/* Finds the islands at the terms' point, whose equations are factored anew; hold: redundant rows as
 * before. NSDAE_OK, or NSDAE_E_RANK with the record. */
int nsdae_problem_factor(nsdae_problem *problem, const nsdae_terms *terms, int hold);
/* After it: which islands have an impact. */
void nsdae_problem_mark_hit(nsdae_problem *problem, const nsdae_terms *terms);

/* After it, with M: the rows of position motors in a step h, of slides.h; the middle of the step is
 * this time ahead of the terms' point. NSDAE_OK, or that of a drive that failed. */
int nsdae_problem_position(nsdae_problem *problem, const nsdae_terms *terms, double h,
                           double ahead);

/* The frictional joints' bounds of impulse: these shares [s] of the bounds at two points. */
void nsdae_problem_bound(nsdae_problem *problem, double share, const nsdae_terms *terms,
                         double others, const nsdae_terms *other);

/* v and lambda, which comes as -Phi_t, of r; size: how large the terms of v were. Without contacts
 * it is as if none were closed. NSDAE_E_MASS, NSDAE_E_RANK and those of the contacts, with the
 * record. */
int nsdae_problem_solve(nsdae_problem *problem, const nsdae_terms *terms, const double *M,
                        const double *r, int with_contacts, double *v, double *size,
                        double *lambda);

/* y += scale Phi_q^T lambda, y += scale W Lambda; any_impact, skip_impacts: but not of islands, nor
 * of contacts, with an impact. */
void nsdae_problem_add_constraints(const nsdae_problem *problem, const nsdae_terms *terms,
                                   double scale, int any_impact, const double *lambda, double *y);
void nsdae_problem_add_impulse(const nsdae_problem *problem, const nsdae_terms *terms, double scale,
                               int skip_impacts, double *y);

/* The linear impulses of the results, whose sum is the change of momentum: none; += W Lambda at the
 * terms' point. What nsdae_problem_add_impulse adds is added to them, too. */
void nsdae_problem_no_linear(nsdae_problem *problem);
void nsdae_problem_add_linear(nsdae_problem *problem, const nsdae_terms *terms);

/* Work of the impulses, and that of position motors apart; what of it the moving surfaces of a list
 * did: sum of Lambda w; residual. */
double nsdae_problem_work(const nsdae_problem *problem, double *motors);
double nsdae_problem_carried(const nsdae_problem *problem, const nsdae_terms *terms);
/* The problem that was solved last, if it was one of these; NSDAE_OK, or NSDAE_E_STATE. */
int nsdae_problem_describe(nsdae_problem *problem, const nsdae_contacts *dense,
                           const nsdae_single *single, const nsdae_cone_island *cones,
                           nsdae_step_friction *friction);
static inline double nsdae_problem_residual(const nsdae_problem *p)
{
  return nsdae_natural_residual_scaled(&p->dispatch.solved->residual);
}

#endif
