/* What every solver of an island takes and returns:
 *
 *   int solve(island *, iterate *, const budget *)
 *
 * It replaces the iterate by points of smaller residual, stops at the tolerance or when the budget
 * is used up, and calls no other solver than those that it is built of. Its arrays in the island
 * are work: no solver reads those of another. iterative_refinement alone may raise the residual, to
 * that of the data as given, which the scaled data have in doubt. */
#ifndef NSDAE_FRICTION_SOLVER_CONTRACT_H
#define NSDAE_FRICTION_SOLVER_CONTRACT_H

#include "anderson.h"
#include "farkas.h"
#include "newton_step.h"

/* A larger residual is not near a solution: Newton's method costs more than it finds there, and s
 * is worth no more than zero. With 1e-3, 1e-2 and 0.1 of 40 seeded problems 39
 * are solved. */
#define NSDAE_FC_NEAR 1e-2

/* The least proximal term: above the rounding of a matrix whose entries are about one. Of 72 seeded
 * convex problems 1e-13 leaves 2 above 1e-6, 1e-14 leaves 12. */
#define NSDAE_FC_REGULAR 1e-13

/* Work of the interior point for the second-order cone problem with s fixed. */
typedef struct nsdae_fc_socp {
  double *s;       /* n: mu |u_T|, added to u_N */
  double *a, *b;   /* 3 n: r and u + s e_N in rows where both cones are the second-order one */
  double *da, *db; /* 3 n: a step */
  double *rhs;     /* 3 n: of db + W^2 da */
  double *root;    /* 3 n: eigenvalues of W, along (1, axis), (1, -axis) and across them */
  double *axis;    /* 2 n: in the tangential plane */
  double *gap;     /* 3 n: velocities of r less those of b */
  double *end;     /* 3 n: the last solution */
} nsdae_fc_socp;

/* Work of iterative refinement: a point in double-double arithmetic. */
typedef struct nsdae_fc_refinement {
  double *high, *low;      /* 3 n: the point, its leading and its trailing parts */
  double *best, *best_low; /* 3 n: the best one */
  double *q;          /* 3 n: that of the island, replaced while it is solved for a correction */
  double *correction; /* 3 n: the iterate of a correction */
} nsdae_fc_refinement;

/* Work of Lemke's method. */
typedef struct nsdae_fc_as_lcp {
  int m;         /* rows that take part; 0: the island is no such problem */
  int bilateral; /* of these, the first */
  int n;         /* unknowns of the complementarity problem */
  int *row;      /* m: 3 k + j for row j of item k */
  double *W;     /* m x (m + 1): W + C of these rows, and q */
  double *A, *b; /* n x n, n */
  double *x, *y; /* n */
  int *basis;    /* n */
  double *work;
  int *iwork;
  int lwork, liwork;
} nsdae_fc_as_lcp;

/* A scaled island and the memory of its solvers. */
typedef struct nsdae_fc_island {
  nsdae_fc_scaled fc;
  nsdae_fc_newton newton;
  nsdae_fc_anderson anderson;
  nsdae_fc_socp socp;
  nsdae_fc_refinement refinement;
  nsdae_fc_as_lcp as_lcp;
  double *slip;            /* n: ratio |u_T| / |r_T| of the contacts that slide (one_contact.h) */
  int lost_paths;          /* of smoothing_homotopy, followed more closely by its next call */
  double *point;           /* 3 n: a point that a solver returns to */
  nsdae_fc_system *system; /* of a Newton step; its symbolic factorisation is kept */
  int analysed;            /* it is that of this island */
  nsdae_fc_farkas *farkas;
  double *proof; /* rows of the global problem: the vector of Farkas' lemma */
} nsdae_fc_island;

/* What has been done on an island. */
typedef struct nsdae_fc_work {
  double products; /* multiplications by J, or as much time */
  long sweeps;
  int steps; /* of Newton's method and interior points, a factorisation each */
  int interrupted;
} nsdae_fc_work;

typedef struct nsdae_fc_iterate {
  double *r;          /* 3 n: in: the first point; out: the best one */
  double *low;        /* 3 n: trailing part of a double-double solution, else zero; NULL: none */
  double residual;    /* of r, or of r + low; INFINITY: not evaluated yet */
  nsdae_fc_work work; /* so far, whoever did it */
} nsdae_fc_iterate;

/* All bounds are on the work of the iterate, which counts from the first solver on. */
typedef struct nsdae_fc_budget {
  double tol;      /* residual of a solution */
  double products; /* multiplications by J */
  long sweeps;
  int steps;
  int double_double; /* the caller takes r + low */
  /* NULL, or called about ten times a second; not 0: interrupt. */
  int (*watch)(const nsdae_fc_iterate *iterate, void *user);
  void *user;
} nsdae_fc_budget;

/* How a solver ended. */
enum {
  NSDAE_FC_NO_MEMORY = -1,
  NSDAE_FC_UNSOLVED = 0,
  NSDAE_FC_SOLVED = 1,
  NSDAE_FC_INFEASIBLE = 2 /* island->proof has the proof */
};

typedef int nsdae_fc_solve(nsdae_fc_island *, nsdae_fc_iterate *, const nsdae_fc_budget *);

nsdae_fc_solve nsdae_fc_trivial;             /* r = 0 */
nsdae_fc_solve nsdae_fc_nsgs;                /* nonlinear block Gauss-Seidel, from iterate->r */
nsdae_fc_solve nsdae_fc_nsgs_plain;          /* without extrapolation */
nsdae_fc_solve nsdae_fc_semismooth_newton;   /* in proximal points, from iterate->r */
nsdae_fc_solve nsdae_fc_smoothing_homotopy;  /* from r = 0 */
nsdae_fc_solve nsdae_fc_aclm;                /* fixed point on s, from iterate->r */
nsdae_fc_solve nsdae_fc_socp_interior_point; /* one convex problem, s that of iterate->r */
nsdae_fc_solve nsdae_fc_lcp;                 /* Lemke's method, planar and frictionless islands */
nsdae_fc_solve nsdae_fc_refine;              /* in double-double, from iterate->r */
nsdae_fc_solve nsdae_fc_infeasible;          /* Farkas' lemma */

/* Take the arrays of the solvers. */
void nsdae_fc_socp_layout(nsdae_fc_socp *socp, const nsdae_fc_scaled *fc, nsdae_arena *arena);
void nsdae_fc_refinement_layout(nsdae_fc_refinement *refinement, const nsdae_fc_scaled *fc,
                                nsdae_arena *arena);
void nsdae_fc_as_lcp_layout(nsdae_fc_as_lcp *s, const nsdae_fc_scaled *fc, nsdae_arena *arena);

/* Bytes of r. */
static inline size_t nsdae_fc_bytes(const nsdae_fc_island *island)
{
  return 3 * (size_t)island->fc.n * sizeof(double);
}

/* Counts products multiplications by J. Returns 0 if the budget is used up or the caller
 * interrupts: then the solver ends. */
int nsdae_fc_spend(const nsdae_fc_island *island, nsdae_fc_iterate *iterate,
                   const nsdae_fc_budget *budget, double products);

/* The same of a sweep, and of a step with its factorisation; counted only if it may be done. */
int nsdae_fc_spend_sweep(const nsdae_fc_island *island, nsdae_fc_iterate *iterate,
                         const nsdae_fc_budget *budget);
int nsdae_fc_spend_step(const nsdae_fc_island *island, nsdae_fc_iterate *iterate,
                        const nsdae_fc_budget *budget);

/* Goes to the point r [3 n]: fc.r, fc.y and fc.u. */
void nsdae_fc_set_point(nsdae_fc_island *island, const double *r);

/* Makes fc.r, whose velocities are fc.u, the iterate if its residual is smaller; returns it. */
double nsdae_fc_offer(nsdae_fc_island *island, nsdae_fc_iterate *iterate);

/* Prepares the linear system for this island; 0: out of memory. */
int nsdae_fc_system_ready(nsdae_fc_island *island);

/* Semismooth Newton with proximal points from fc.r on, for the solvers that are built of it: ends
 * there at the best of its points, whose residual is returned. */
double nsdae_fc_proximal_points(nsdae_fc_island *island, nsdae_fc_iterate *iterate,
                                const nsdae_fc_budget *budget);

/* The convex problem with s = socp.s, from fc.r on; 0: not solved. */
int nsdae_fc_socp_run(nsdae_fc_island *island, nsdae_fc_iterate *iterate,
                      const nsdae_fc_budget *budget);

/* At most this number of Newton steps from the iterate, a solution. Each that reduces the residual
 * is kept.
 */
void nsdae_fc_polish(nsdae_fc_island *island, nsdae_fc_iterate *iterate,
                     const nsdae_fc_budget *budget, int steps);

#endif
