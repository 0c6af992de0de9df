/* Contacts in two tangential directions with Coulomb's cone itself: the closed ones as a problem of
 * nsdae/friction.h in the local form, with the Delassus matrix G for W,
 *
 *   xi = G Lambda + offset,   K* contains xi + mu |xi_T| e_N,  orthogonal to Lambda in K,
 *
 * solved from the impulses of the step before and then refined until rounding rules, so that what
 * sticks does not creep. Nothing is allocated after nsdae_cones_open.
 *
 * A frictional joint (slides.h) with a bound b of its own is a further contact of the problem, in
 * the plane, with mu = 1 and a normal row that no other row touches, xi_N = d (Lambda_N - b): its
 * law gives Lambda_N = b and |Lambda_T| <= b. d = min(G_jj, max |offset| / b) has the scale of its
 * tangential row, and d b at most that of the problem: a large bound costs no digits.
 *
 * If the friction of a joint is bounded by |lambda|, contacts and joints are solved in turn, each
 * with the impulses of the others held, until those no longer change (block Gauss-Seidel: Jean,
 * "The non-smooth contact dynamics method", 1999). */
#ifndef NSDAE_CONES_H
#define NSDAE_CONES_H

#include <nsdae/friction.h>

#include "arena.h"

struct nsdae_contacts;

typedef struct nsdae_cones {
  int most; /* contacts that a problem may have; 0: no contact of the system has a cone */
  int room; /* contacts and joints that the arrays are for */
  nsdae_friction_solver *solver;
  nsdae_friction_options options;
  nsdae_friction_info info;
  nsdae_friction_problem problem; /* the last one, of the arrays that follow */
  int *rows, *first, *block;      /* most, most + 1, most^2 */
  double *mu, *q, *W;             /* most, 3 most, 9 most^2 */
  double *r, *u;                  /* 3 most: impulses and velocities of the closed contacts */
  double *guess;                  /* 3 most: where the solver began */
  double *free, *held, *lambda;   /* columns, columns, m: with slides, the offset without contacts
                                     and slides, the frictional joints' impulses, lambda */
} nsdae_cones;

/* Takes the arrays for this number of contacts and columns; most is set before. */
void nsdae_cones_layout(nsdae_cones *cones, long contacts, long columns, long m,
                        nsdae_arena *arena);

/* A solver with memory for the largest problem: NSDAE_OK or NSDAE_E_MEMORY. */
int nsdae_cones_open(nsdae_cones *cones);
void nsdae_cones_close(nsdae_cones *cones);

/* Whether a closed contact has a cone. */
int nsdae_cones_any(const struct nsdae_contacts *contacts);

/* Impulses of the closed contacts into lcp.x, from G and the offsets, and what the solver says of
 * them into lcp.info; with slides, their impulses and modes into the results too. lambda [m] is
 * that without contacts and frictional joints. NSDAE_OK, NSDAE_E_LCP or NSDAE_E_INFEASIBLE. */
int nsdae_cones_solve(struct nsdae_contacts *contacts, const double *lambda);

/* Brings impulses [columns] of all closed contacts, such as those of a polygon, to their cones. 1;
 * 0 where that was not found, or has slides or contacts whose direction is known: then nothing is
 * changed. */
int nsdae_cones_improve(struct nsdae_contacts *contacts, double *impulse);

/* impulse [columns] := that of rest, u = 0 of all closed contacts, where Coulomb's law has it among
 * its solutions: of the convex problem with s = 0. 1, or 0: nothing is changed. */
int nsdae_cones_rest(struct nsdae_contacts *contacts, double *impulse);

/* The problem that was solved last, whatever the contacts' laws: of those with a cone as it was
 * solved; of others, which were a complementarity problem, as problem says it. NSDAE_OK; or
 * NSDAE_E_STATE where there were slides and no cones, or contacts whose direction was known. */
int nsdae_cones_describe(struct nsdae_contacts *contacts);

/* The problem of one contact: its rows, G and q by rows, Lambda. */
void nsdae_cones_describe_one(nsdae_cones *cones, int rows, double mu, const double *G,
                              const double *q, const double *x);

/* enum nsdae_mode of the a-th closed contact. */
int nsdae_cones_mode(const struct nsdae_contacts *contacts, int a);

#endif
