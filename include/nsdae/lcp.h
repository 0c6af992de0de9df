/* nsdae: linear complementarity problems. BSD-3-Clause.
 *
 * Find x, y with  y = A x + b,  x >= 0,  y >= 0,  x'y = 0  (Cottle, Pang, Stone, "The Linear
 * Complementarity Problem", 1992). */
#ifndef NSDAE_LCP_H
#define NSDAE_LCP_H

#include <nsdae/certificate.h>
#include <nsdae/params.h>
#include <nsdae/status.h>

#ifdef __cplusplus
extern "C" {
#endif

/* A and b of y = A x + b; neither is changed. */
typedef struct nsdae_lcp_problem {
  int n;           /* rows, >= 0 */
  const double *A; /* n x n, column-major */
  int lda;         /* >= max(1, n) */
  const double *b; /* n */
} nsdae_lcp_problem;

/* X(name, value, word, text): the solvers of the chain, in the order of their use. This list
 * defines the enum, the names and the order. */
#define NSDAE_LCP_STAGE_LIST(X)                                                             \
  X(NSDAE_LCP_TRIVIAL, 1, "trivial", "b >= 0: x = 0")                                       \
  X(NSDAE_LCP_WARM, 2, "warm", "the active set given on entry: one factorisation")          \
  X(NSDAE_LCP_LEMKE, 4, "lemke", "lexicographic Lemke, covering vector of ones")            \
  X(NSDAE_LCP_NEWTON, 8, "newton", "n >= 100: a few of the starts of further")              \
  X(NSDAE_LCP_COVERING, 16, "covering", "Lemke with other covering vectors")                \
  X(NSDAE_LCP_PROVE, 32, "prove", "the proof that no x >= 0 has A x + b >= 0")              \
  X(NSDAE_LCP_FURTHER, 64, "further", "damped Newton on semismooth equations, many starts") \
  X(NSDAE_LCP_ENUMERATE, 128, "enumerate", "small n: all active sets, or the proof of none")

/* Bits of options.stages. */
enum nsdae_lcp_stage {
  NSDAE_LCP_NONE = 0,
  NSDAE_LCP_ALL = 255,
#define NSDAE_LCP_STAGE_ENUM(name, value, word, text) name = value,
  NSDAE_LCP_STAGE_LIST(NSDAE_LCP_STAGE_ENUM)
#undef NSDAE_LCP_STAGE_ENUM
};

/* Property of A that the secondary ray of Lemke's method proves, by its direction x >= 0, x != 0.
 * It is checked in exact arithmetic on A as given. */
enum nsdae_lcp_ray {
  NSDAE_LCP_RAY_NOTHING = 0,
  NSDAE_LCP_RAY_NOT_COPOSITIVE = 1,         /* (A x)_i < 0 for all i with x_i > 0: A is not
                                               copositive (x^T A x < 0) and not semimonotone,
                                               therefore neither positive semidefinite nor P0 */
  NSDAE_LCP_RAY_NOT_STRICTLY_COPOSITIVE = 2 /* (A x)_i <= 0 for all i with x_i > 0: A is not
                                               strictly copositive and not strictly semimonotone,
                                               therefore neither positive definite nor P */
};

/* Initialise with nsdae_lcp_options_default. */
typedef struct nsdae_lcp_options {
  double tol;        /* tolerance of the scaled natural residual, in (0, 1] */
  int max_pivots;    /* per run of Lemke's method, >= 0; 0: 50 n + 100 */
  int stages;        /* sum of enum nsdae_lcp_stage; default NSDAE_LCP_ALL */
  int enumerate_max; /* largest n for enumeration, in [0, 24] */
} nsdae_lcp_options;

/* Result of a solve. */
typedef struct nsdae_lcp_info {
  int outcome;     /* enum nsdae_outcome */
  int stage;       /* enum nsdae_lcp_stage that solved it */
  int proof;       /* enum nsdae_proof */
  int ray;         /* enum nsdae_lcp_ray; searched if there is no solution and n <= 60 */
  int pivots;      /* number of pivots of all stages */
  double residual; /* residual of the returned x, of the equilibrated problem: max_i |min(x_i /
                      sx_i, y_i / sy_i)| (see nsdae_dlcpres); entries of x below 1e-308 are as
                      rounded to doubles */
} nsdae_lcp_info;

/* Defaults: tol 1e-10, all stages, enumeration up to n = 12. NULL is allowed. */
NSDAE_API void nsdae_lcp_options_default(nsdae_lcp_options *options);

/* Names of a stage ("lemke") and of the property that a ray proves ("not copositive"); "unknown"
 * for any other value. nsdae/certificate.h has the names of outcomes and proofs. */
NSDAE_API const char *nsdae_lcp_stage_name(int stage);
NSDAE_API const char *nsdae_lcp_ray_name(int ray);

/* Solves a problem; allocates its workspace once. If a permutation makes A block diagonal, its
 * blocks are solved separately. info then has the largest residual, the sum of the pivots and the
 * last stage of any block.
 *
 *   problem  n in [0, 20000]; A, b, x and y may be NULL if n = 0
 *   options  NULL: defaults
 *   x [n]    in: initial guess; its positive entries are the active set tried first (zero: none);
 *            out: the solution, the best iterate, or zero
 *   y [n]    out: A x + b; without a solution see below
 *   info     may be NULL
 *
 * Proofs are checked in exact arithmetic on A and b as given:
 *
 * - NSDAE_PROOF_FARKAS: y returns u >= 0 with A^T u <= 0 and b^T u < 0. Every x >= 0 then has u^T
 *  (A x + b) < 0: no x >= 0 has A x + b >= 0.
 * - NSDAE_PROOF_ENUMERATED: some x >= 0 has A x + b >= 0, but none is complementary.
 *
 * Status:
 *
 * - NSDAE_OK: solved
 * - NSDAE_E_INFEASIBLE: no solution exists (proved)
 * - NSDAE_E_LCP: no solution found
 * - NSDAE_E_ARGUMENT (missing or out of range), NSDAE_E_NONFINITE (A or b), NSDAE_E_MEMORY: x and y
 *  are unchanged */
NSDAE_API int nsdae_lcp_solve(const nsdae_lcp_problem *problem, const nsdae_lcp_options *options,
                              double *x, double *y, nsdae_lcp_info *info);

/* nsdae_lcp_solve in the caller's workspace, without allocation.
 *
 *   basis [n]  in: not 0 if x_i is expected to be positive, 0 if y_i is; out: 1 and 0, the basis of
 *              the solution, in which an x_i may be zero (undefined without a solution)
 *   work [lwork], iwork [liwork]: at least the sizes for n from nsdae_lcp_workspace */
NSDAE_API int nsdae_lcp_solve_in(const nsdae_lcp_problem *problem, const nsdae_lcp_options *options,
                                 int *basis, double *x, double *y, nsdae_lcp_info *info,
                                 double *work, int lwork, int *iwork, int liwork);

/* Sizes of the workspace, each at least 1. NSDAE_E_ARGUMENT: n is outside [0, 20000] or a size is
 * NULL. */
NSDAE_API int nsdae_lcp_workspace(int n, int *lwork, int *liwork);

#ifdef __cplusplus
}
#endif
#endif
