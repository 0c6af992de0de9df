/* nsdae: frictional contact problems. BSD-3-Clause.
 *
 * Signorini's condition and Coulomb's second-order cone (no polygon). Find impulses r and
 * velocities u with
 *
 *   global form:  M v = f + H r,   u = H^T v + w + C r
 *   local form:   u = W r + q + C r,          where W = H^T M^-1 H,  q = H^T M^-1 f + w
 *
 *   contact c:    K* contains u^ = u + mu |u_T| e_N,  K contains r,  u^ . r = 0,
 *                 K = {r : |r_T| <= mu r_N},  K* = {u : mu |u_T| <= u_N}  (dual cone)
 *   bilateral:    u = 0, r free
 *
 * M is symmetric positive definite, W symmetric positive semidefinite, C >= 0 diagonal. r need not
 * be unique. Sources: De Saxce and Feng, Math. Comput. Modelling 28 (1998) 225; Acary and
 * Brogliato, "Numerical Methods for Nonsmooth Dynamical Systems", 2008. */
#ifndef NSDAE_FRICTION_H
#define NSDAE_FRICTION_H

#include <nsdae/certificate.h>
#include <nsdae/status.h>

#ifdef __cplusplus
extern "C" {
#endif

/* Form of a problem. */
enum nsdae_friction_form { NSDAE_FRICTION_GLOBAL = 0, NSDAE_FRICTION_LOCAL = 1 };

/* A problem. Its items are the contacts, followed by the bilateral rows (one item each). r, u, w
 * and compliance have m entries: the rows of the items in order. A contact has its normal row, then
 * 0, 1 or 2 tangential rows.
 *
 * Block-sparse Jacobian: item i touches the blocks block[first[i]] .. block[first[i + 1] - 1], each
 * at most once, in any order. value has their dense parts in that order, without gaps. Each part is
 * column-major, with one column for each row of the item:
 *
 *   global  block b of v, part of H: size[b] x rows of i (a direction is one column)
 *   local   item j, part of W: rows of j x rows of i
 *
 * In the local form W_ji is in item i and its transpose in item j; for j = i it is the diagonal
 * part. An item without a diagonal part has a zero diagonal part. The solver changes none of these
 * arrays. */
typedef struct nsdae_friction_problem {
  int form;                 /* enum nsdae_friction_form */
  int contacts;             /* >= 0 */
  int bilateral;            /* bilateral rows, >= 0 */
  const int *rows;          /* [contacts] 1 (frictionless), 2 (planar) or 3 (spatial); NULL: all
                               3 */
  const double *mu;         /* [contacts] coefficient of friction, >= 0; ignored if rows is 1 */
  const double *w;          /* [m] global: w; local: q */
  const double *compliance; /* [m] diagonal of C, >= 0; NULL: zero */
  int blocks;               /* global: number of blocks of v, >= 0; local: 0 */
  const int *size;          /* [blocks] rows of each block, >= 1 */
  const double *M;          /* dense diagonal blocks of M, size x size each, one after another */
  const double *f;          /* [sum of size] */
  const int *first;         /* [contacts + bilateral + 1], starts with 0, nondecreasing */
  const int *block;         /* [first[contacts + bilateral]] */
  const double *value;      /* entries of H or W, see above */
} nsdae_friction_problem;

/* X(name, value, word, text): the solvers of an island. This list defines the enum and the names;
 * docs/friction.md has equations, conditions and order. */
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

/* Bits of options.stages. */
enum nsdae_friction_stage {
  NSDAE_FRICTION_NONE = 0,
  NSDAE_FRICTION_ALL = 1023,
#define NSDAE_FRICTION_STAGE_ENUM(name, value, word, text) name = value,
  NSDAE_FRICTION_STAGE_LIST(NSDAE_FRICTION_STAGE_ENUM)
#undef NSDAE_FRICTION_STAGE_ENUM
};

/* State of a solve, for options.progress. */
typedef struct nsdae_friction_progress {
  int stage;       /* enum nsdae_friction_stage */
  int island;      /* from 0 */
  int islands;     /* number of islands */
  int contacts;    /* contacts and bilateral rows of this island */
  double residual; /* of its best iterate */
  double share;    /* fraction of its budget used */
  long sweeps;     /* block Gauss-Seidel sweeps so far */
  int iterations;  /* Newton and interior-point steps so far */
} nsdae_friction_progress;

/* Called at the start of every solver of an island, and about ten times a second. A value other
 * than 0 ends the solve with NSDAE_E_INTERRUPTED; r is then the best iterate. */
typedef int (*nsdae_friction_progress_fn)(const nsdae_friction_progress *progress, void *user);

/* Initialise with nsdae_friction_options_default. Limits apply to an island, over all its solvers.
 */
typedef struct nsdae_friction_options {
  double tol;         /* tolerance of the residual, in (0, 1] */
  int stages;         /* sum of enum nsdae_friction_stage; default NSDAE_FRICTION_ALL */
  int max_sweeps;     /* block Gauss-Seidel sweeps, >= 0; 0: limited by budget only */
  int max_iterations; /* Newton and interior-point steps, >= 0; 0: limited by budget only */
  int refine;         /* Newton steps after convergence, while the residual decreases, >= 0; then
                         r is in the cones to the last bit. 0 (default): neither */
  double budget;      /* multiplications by J = L^-1 H or W, or the equivalent time, >= 0; 0: 1e9
                         / contacts, at most 2e4 contacts (about a minute at most) */
  nsdae_friction_progress_fn progress; /* NULL: no callback */
  void *user;                          /* last argument of progress */
} nsdae_friction_options;

/* Result of a solve. */
typedef struct nsdae_friction_info {
  int outcome;        /* enum nsdae_outcome */
  int stage;          /* enum nsdae_friction_stage that solved it: the largest of all islands */
  int proof;          /* enum nsdae_proof */
  int islands;        /* number of islands (parts without a common block), solved separately */
  long sweeps;        /* block Gauss-Seidel sweeps of all islands */
  int iterations;     /* Newton and interior-point steps of all islands */
  int factorisations; /* sparse factorisations of all islands */
  double residual;    /* nsdae_friction_residual of the returned r */
} nsdae_friction_info;

/* Defaults: tol 1e-10, all stages, default budget, no callback. NULL is allowed. */
NSDAE_API void nsdae_friction_options_default(nsdae_friction_options *options);

/* Name of a stage ("nsgs"); "unknown" for any other value. nsdae/certificate.h has the names of
 * outcomes and proofs. */
NSDAE_API const char *nsdae_friction_stage_name(int stage);

/* Validates a problem. error (may be NULL) names the argument, its value and its bound.
 *
 * - NSDAE_E_ARGUMENT: a size, index or coefficient is out of range, or the asymmetry of W exceeds
 *  1e-10 of its diagonal
 * - NSDAE_E_NONFINITE: a value is NaN or infinite
 * - NSDAE_E_MASS: a block of M is not symmetric positive definite
 * - NSDAE_E_MEMORY */
NSDAE_API int nsdae_friction_check(const nsdae_friction_problem *problem, nsdae_error *error);

/* Solves a problem; allocates its own memory. Islands (parts without a common block) are solved
 * separately.
 *
 *   options  NULL: defaults
 *   r [m]    in: initial guess of the stage NSDAE_FRICTION_WARM (zero: none; used as zero if it is
 *            not finite); out: the solution or the best iterate; with NSDAE_PROOF_FARKAS l, below
 *   u [m]    out: velocities of r, recomputed from the data; with a proof those of r = 0
 *   info     may be NULL
 *
 * Farkas vector l: zero in tangential rows, >= 0 in normal rows, H l = 0 (local form: W l = 0), C l
 * = 0 and w . l < 0 (q . l < 0). A velocity u with u_N >= 0 and zero bilateral rows has l . u >= 0.
 * Every reachable velocity has l . u = w . l < 0. The proof uses exact arithmetic on the data as
 * given, for l or for a vector that rounds to l (lib/friction/problem/farkas.c).
 *
 * - NSDAE_OK: solved
 * - NSDAE_E_INFEASIBLE: no solution exists (proved)
 * - NSDAE_E_LCP: no solution found; r is the best iterate
 * - NSDAE_E_INTERRUPTED: options.progress ended the solve; r is the best iterate
 * - any other status (see nsdae_friction_check): r and u are unchanged */
NSDAE_API int nsdae_friction_solve(const nsdae_friction_problem *problem,
                                   const nsdae_friction_options *options, double *r, double *u,
                                   nsdae_friction_info *info);

/* Residual of a point, dimensionless. d_c is the mean diagonal entry of W + C of contact c, s = max
 * |q|:
 *
 *   x = r d_c / s,  y = (u + mu |u_T| e_N) / s,  residual = max |x - P_K(x - y)|
 *
 * The maximum is over all entries of all contacts, and |u| / s over the bilateral rows. u is
 * computed from r. If s is 0 or the rounding of its terms, s = 1. The residual is NaN if r is not
 * finite or a product overflows. For mu far above 1 it is limited by the rounding of u_T: an error
 * of 1e-16 in u_T is 1e-16 mu in y.
 *
 *   r [m]     a point
 *   u [m]     out: its velocities; may be NULL
 *   residual  out
 *
 * Status as nsdae_friction_check. */
NSDAE_API int nsdae_friction_residual(const nsdae_friction_problem *problem, const double *r,
                                      double *u, double *residual);

/* nsdae_friction_solve for a double-double solution r + low. It is needed if the masses of the
 * bodies differ by 1e6 and more. Then x = r d_c / s (see nsdae_friction_residual) is as large and
 * its last digit is 1e-10. No r in double precision has a residual of 1e-12.
 *
 *   low [m]  out: trailing part of the solution, at most half the last digit of r; zero if r alone
 *            is a solution. NULL: nsdae_friction_solve
 *
 * All else as nsdae_friction_solve. The certificate applies to r + low. With NSDAE_E_INFEASIBLE low
 * is unchanged. */
NSDAE_API int nsdae_friction_solve_twice(const nsdae_friction_problem *problem,
                                         const nsdae_friction_options *options, double *r,
                                         double *low, double *u, nsdae_friction_info *info);

/* nsdae_friction_residual of r + low, in double-double arithmetic if necessary; low [m], NULL:
 * zero. */
NSDAE_API int nsdae_friction_residual_twice(const nsdae_friction_problem *problem, const double *r,
                                            const double *low, double *u, double *residual);

/* A solver that reuses memory and symbolic factorisations from problem to problem, for time
 * stepping. A problem no larger than earlier ones needs no allocation. */
typedef struct nsdae_friction_solver nsdae_friction_solver;

/* Creates a solver. NSDAE_OK or NSDAE_E_MEMORY. */
NSDAE_API int nsdae_friction_create(nsdae_friction_solver **solver);

/* nsdae_friction_solve with the memory of the solver. */
NSDAE_API int nsdae_friction_solver_solve(nsdae_friction_solver *solver,
                                          const nsdae_friction_problem *problem,
                                          const nsdae_friction_options *options, double *r,
                                          double *u, nsdae_friction_info *info);

/* Frees the solver and sets *solver to NULL; NULL is allowed. */
NSDAE_API void nsdae_friction_destroy(nsdae_friction_solver **solver);

#ifdef __cplusplus
}
#endif
#endif
