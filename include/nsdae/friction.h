/* nsdae: frictional contact problems. BSD-3-Clause.
 *
 * Signorini's condition and Coulomb's cone, without a polygon. Find impulses r and velocities u
 * with
 *
 *   global form:  M v = f + H r,   u = H^T v + w + C r
 *   local form:   u = W r + q + C r,          where W = H^T M^-1 H,  q = H^T M^-1 f + w
 *
 *   contact c:    K* contains u^ = u + mu |u_T| e_N,  K contains r,  u^ . r = 0,
 *                 K = {r : |r_T| <= mu r_N},  K* = {u : mu |u_T| <= u_N}  (dual cone)
 *   bilateral:    u = 0, r free
 *
 * (De Saxce and Feng, Math. Comput. Modelling 28 (1998) 225; Acary and Brogliato, "Numerical
 * Methods for Nonsmooth Dynamical Systems", 2008). M is symmetric positive definite, W symmetric
 * positive semidefinite, C >= 0 diagonal; r need not be unique. */
#ifndef NSDAE_FRICTION_H
#define NSDAE_FRICTION_H

#include <nsdae/certificate.h>
#include <nsdae/status.h>

#ifdef __cplusplus
extern "C" {
#endif

/* Which of its two forms a problem is given in. */
enum nsdae_friction_form { NSDAE_FRICTION_GLOBAL = 0, NSDAE_FRICTION_LOCAL = 1 };

/* A problem. Its items are the contacts, in order, and after them the bilateral rows, one item
 * each. r, u, w and compliance hold the rows of the items one after another, m in all: of a contact
 * the normal row first, then its 0, 1 or 2 tangential ones; of a bilateral row itself.
 *
 * Rows by blocks: item i touches the blocks block[first[i]] .. block[first[i + 1] - 1], each at
 * most once, in any order; value holds their dense parts in that order, one after another without
 * gaps, each column-major with one column for each row of the item: global  block b of v, part of
 * H: size[b] x rows of i (a direction is one column) local   item j, part of W: rows of j x rows of
 * i; W_ji (for j = i the diagonal part) must stand in item i and its transpose in item j. An item
 * without a diagonal part has zero there. Nothing is changed by the solver. */
typedef struct nsdae_friction_problem {
  int form;                 /* enum nsdae_friction_form */
  int contacts;             /* >= 0 */
  int bilateral;            /* bilateral rows, >= 0 */
  const int *rows;          /* contacts: 1 (frictionless), 2 (planar) or 3 (spatial); NULL: all 3 */
  const double *mu;         /* contacts: coefficient of friction, >= 0; not read where rows is 1 */
  const double *w;          /* m: w of the global form, q of the local one */
  const double *compliance; /* m: diagonal of C, >= 0; NULL: zero */
  int blocks;               /* global: blocks of v, >= 0; local: 0 */
  const int *size;          /* blocks: rows of each, >= 1 */
  const double *M;          /* dense diagonal blocks of M, size x size each, one after another */
  const double *f;          /* sum of size */
  const int *first;         /* contacts + bilateral + 1, from 0, not decreasing */
  const int *block;         /* first[contacts + bilateral] */
  const double *value;      /* H or W as above */
} nsdae_friction_problem;

/* X(name, value, word, what it does): the solvers of an island, the one list that makes the enum
 * and the names. docs/friction.md has their equations, conditions and order. */
#define NSDAE_FRICTION_STAGE_LIST(X)                                                               \
  X(NSDAE_FRICTION_TRIVIAL, 1, "trivial", "r = 0")                                                 \
  X(NSDAE_FRICTION_WARM, 2, "warm", "nsgs and semismooth Newton from r on entry")                  \
  X(NSDAE_FRICTION_AS_LCP, 4, "as-lcp", "small, frictionless or planar: Lemke's method")           \
  X(NSDAE_FRICTION_NSGS, 8, "nsgs", "nonlinear block Gauss-Seidel")                                \
  X(NSDAE_FRICTION_SMOOTHING_HOMOTOPY, 16, "smoothing-homotopy", "path of smoothed natural maps")  \
  X(NSDAE_FRICTION_FARKAS, 32, "farkas", "proof that no u has u_N >= 0, whatever the friction")    \
  X(NSDAE_FRICTION_SEMISMOOTH_NEWTON, 64, "semismooth-newton", "Newton's method, proximal points") \
  X(NSDAE_FRICTION_ACLM, 128, "aclm", "fixed point on s = mu |u_T| of convex problems")            \
  X(NSDAE_FRICTION_SOCP_INTERIOR_POINT, 256, "socp-interior-point", "one convex problem, s fixed") \
  X(NSDAE_FRICTION_ITERATIVE_REFINEMENT, 512, "iterative-refinement", "in double-double arithmetic")

/* options.stages is a sum of these. */
enum nsdae_friction_stage {
  NSDAE_FRICTION_NONE = 0,
  NSDAE_FRICTION_ALL = 1023,
#define NSDAE_FRICTION_STAGE_ENUM(name, value, word, text) name = value,
  NSDAE_FRICTION_STAGE_LIST(NSDAE_FRICTION_STAGE_ENUM)
#undef NSDAE_FRICTION_STAGE_ENUM
};

/* What a solve is doing, for options.progress. */
typedef struct nsdae_friction_progress {
  int stage;       /* enum nsdae_friction_stage */
  int island;      /* from 0 */
  int islands;     /* in all */
  int contacts;    /* of this island, with its bilateral rows */
  double residual; /* of its best point so far */
  double share;    /* of its budget that is used up */
  long sweeps;     /* of block Gauss-Seidel so far */
  int iterations;  /* steps of Newton's method and interior points so far */
} nsdae_friction_progress;

/* Called where a solver of an island begins, and about ten times a second. Not 0: the solve ends
 * with NSDAE_E_INTERRUPTED, and r is the best point so far. */
typedef int (*nsdae_friction_progress_fn)(const nsdae_friction_progress *progress, void *user);

/* Fill with nsdae_friction_options_default first. Bounds are on an island, over all its solvers. */
typedef struct nsdae_friction_options {
  double tol;         /* bound on the residual of a solution, in (0, 1] */
  int stages;         /* sum of enum nsdae_friction_stage; default NSDAE_FRICTION_ALL */
  int max_sweeps;     /* of block Gauss-Seidel, >= 0; 0: as the budget allows */
  int max_iterations; /* steps of Newton's method and interior points, >= 0; 0: as above */
  int refine;         /* Newton steps from a solution on, while its residual falls, >= 0; then r is
                         in the cones to the last bit. Default 0: neither */
  double budget;      /* multiplications by J = L^-1 H or W, or as much time, >= 0; 0: 1e9 over the
                         contacts, at most 2e4 times the contacts: a minute or so at most */
  nsdae_friction_progress_fn progress; /* NULL: nobody is called */
  void *user;                          /* its last argument */
} nsdae_friction_options;

/* How a problem was solved, or was not. */
typedef struct nsdae_friction_info {
  int outcome;        /* enum nsdae_outcome */
  int stage;          /* enum nsdae_friction_stage that ended it: the largest of all islands */
  int proof;          /* enum nsdae_proof */
  int islands;        /* parts that share no block, solved one by one */
  long sweeps;        /* of block Gauss-Seidel, over all islands */
  int iterations;     /* Newton steps, over all islands */
  int factorisations; /* of sparse matrices, over all islands */
  double residual;    /* see nsdae_friction_residual, of the r handed over */
} nsdae_friction_info;

/* tol 1e-10, every stage, the default budget, no callback. NULL is left alone. */
NSDAE_API void nsdae_friction_options_default(nsdae_friction_options *options);

/* Name of a stage ("nsgs"); "unknown" for any other value. Those of outcomes and proofs are
 * in nsdae/certificate.h. */
NSDAE_API const char *nsdae_friction_stage_name(int stage);

/* Whether the problem is one: NSDAE_OK; NSDAE_E_ARGUMENT a size, an index or a coefficient is
 * outside its range, or W is not symmetric to 1e-10 of its diagonal; NSDAE_E_NONFINITE a NaN or an
 * infinity; NSDAE_E_MASS a block of M is not symmetric positive definite; NSDAE_E_MEMORY. error
 * (may be NULL) names the argument, its value and its bound. */
NSDAE_API int nsdae_friction_check(const nsdae_friction_problem *problem, nsdae_error *error);

/* Solves the problem; allocates its own memory. Parts that share no block are solved one by one.
 *   problem  see above
 *   options  NULL: the defaults
 *   r [m]    in: a guess, with the stage NSDAE_FRICTION_WARM (zero: none; taken as zero where it
 *            is not finite); out: the solution, or the best point found. With NSDAE_PROOF_FARKAS
 *            l: zero in tangential rows, >= 0 in normal ones, with H l = 0 (W l = 0), C l = 0 and
 *            w . l < 0 (local form: q . l), so that no u with u_N >= 0 and bilateral rows at rest
 * is reached, whatever r: it would have l . u = w . l. That is proved on the data as given, of l in
 * exact arithmetic, or of an l that l is to rounding (lib/friction/problem/farkas.c).
 *
 *   u [m]    out: the velocities of r, computed afresh from the data; with a proof those of r = 0
 *   info     may be NULL
 *
 * NSDAE_OK solved; NSDAE_E_INFEASIBLE proved without solution; NSDAE_E_LCP no solution found;
 * NSDAE_E_INTERRUPTED options.progress asked for it; r is the best point in both cases. With any
 * other status (those of nsdae_friction_check) r and u are as they were. */
NSDAE_API int nsdae_friction_solve(const nsdae_friction_problem *problem,
                                   const nsdae_friction_options *options, double *r, double *u,
                                   nsdae_friction_info *info);

/* The residual of a point, free of units: with d_c the mean of the diagonal entries of W + C of
 * contact c and s = max |q|,
 *
 *   x = r d_c / s,  y = (u + mu |u_T| e_N) / s,  residual = max |x - P_K(x - y)|
 *
 * over all entries of all contacts, and |u| / s over the bilateral rows; u is computed from r.
 * Where s = 0 it is of d_c r and u themselves. NaN where r is not finite or a product overflows. Of
 * a contact whose mu is far above 1 it is that of u_T as rounded: zero may be 1e-16, and mu |u_T|
 * anything up to 1e-16 mu.
 *   r [m]     a point
 *   u [m]     out: its velocities; may be NULL
 *   residual  out
 * Status as of nsdae_friction_check. */
NSDAE_API int nsdae_friction_residual(const nsdae_friction_problem *problem, const double *r,
                                      double *u, double *residual);

/* nsdae_friction_solve for a double-double solution, r + low, if doubles alone hold none: where
 * bodies differ in mass by 1e6 and more, impulses x = r d_c / s (see nsdae_friction_residual) get
 * as large, their last digit 1e-10, and no r of doubles has a residual of 1e-12.
 *
 *   low [m]  out: what r does not hold of the solution, at most half its last digit; zero where r
 *            alone is one. NULL: nsdae_friction_solve
 *
 * Everything else as there; the certificate is that of r + low. With NSDAE_E_INFEASIBLE low is as
 * it was. */
NSDAE_API int nsdae_friction_solve_twice(const nsdae_friction_problem *problem,
                                         const nsdae_friction_options *options, double *r,
                                         double *low, double *u, nsdae_friction_info *info);

/* nsdae_friction_residual of r + low, in twice the precision where that is needed; low [m], NULL:
 * zero. */
NSDAE_API int nsdae_friction_residual_twice(const nsdae_friction_problem *problem, const double *r,
                                            const double *low, double *u, double *residual);

/* A solver that keeps its memory and its symbolic factorisations from one problem to the next, for
 * steps: nothing is allocated for a problem no larger than those before. */
typedef struct nsdae_friction_solver nsdae_friction_solver;

/* NSDAE_OK or NSDAE_E_MEMORY. */
NSDAE_API int nsdae_friction_create(nsdae_friction_solver **solver);

/* nsdae_friction_solve with the memory of the solver. */
NSDAE_API int nsdae_friction_solver_solve(nsdae_friction_solver *solver,
                                          const nsdae_friction_problem *problem,
                                          const nsdae_friction_options *options, double *r,
                                          double *u, nsdae_friction_info *info);

/* Takes the address and sets it to NULL; NULL is left alone. */
NSDAE_API void nsdae_friction_destroy(nsdae_friction_solver **solver);

#ifdef __cplusplus
}
#endif
#endif
