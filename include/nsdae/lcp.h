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

/* X(name, value, word, what it does): the stages of the chain in the order in which they are tried,
 * the one list that makes the enum, the names and the order. */
#define NSDAE_LCP_STAGE_LIST(X)                                                             \
  X(NSDAE_LCP_TRIVIAL, 1, "trivial", "b >= 0: x = 0")                                       \
  X(NSDAE_LCP_WARM, 2, "warm", "the active set given on entry: one factorisation")          \
  X(NSDAE_LCP_LEMKE, 4, "lemke", "lexicographic Lemke, covering vector of ones")            \
  X(NSDAE_LCP_NEWTON, 8, "newton", "n >= 100: a few of the starts of further")              \
  X(NSDAE_LCP_COVERING, 16, "covering", "Lemke with other covering vectors")                \
  X(NSDAE_LCP_PROVE, 32, "prove", "the proof that no x >= 0 has A x + b >= 0")              \
  X(NSDAE_LCP_FURTHER, 64, "further", "damped Newton on semismooth equations, many starts") \
  X(NSDAE_LCP_ENUMERATE, 128, "enumerate", "small n: all active sets, or the proof of none")

/* options.stages is a sum of these. */
enum nsdae_lcp_stage {
  NSDAE_LCP_NONE = 0,
  NSDAE_LCP_ALL = 255,
#define NSDAE_LCP_STAGE_ENUM(name, value, word, text) name = value,
  NSDAE_LCP_STAGE_LIST(NSDAE_LCP_STAGE_ENUM)
#undef NSDAE_LCP_STAGE_ENUM
};

/* What the secondary ray on which Lemke's method ended proves about A: by its direction x >= 0, x
 * not zero, checked in exact arithmetic on A as given. */
enum nsdae_lcp_ray {
  NSDAE_LCP_RAY_NOTHING = 0,
  NSDAE_LCP_RAY_NOT_COPOSITIVE = 1,         /* (A x)_i < 0 wherever x_i > 0: A is not copositive
                                               (x^T A x < 0) and not semimonotone, and so neither
                                               positive semidefinite nor P0 */
  NSDAE_LCP_RAY_NOT_STRICTLY_COPOSITIVE = 2 /* (A x)_i <= 0 wherever x_i > 0: A is not strictly
                                               copositive and not strictly semimonotone, and so
                                               neither positive definite nor P */
};

/* Fill with nsdae_lcp_options_default first. */
typedef struct nsdae_lcp_options {
  double tol;        /* bound on the scaled natural residual of a solution, in (0, 1] */
  int max_pivots;    /* per run of Lemke, >= 0; 0: 50 n + 100 */
  int stages;        /* sum of enum nsdae_lcp_stage; default NSDAE_LCP_ALL */
  int enumerate_max; /* largest n that enumeration takes on, in [0, 24] */
} nsdae_lcp_options;

/* How a problem was solved, or was not. */
typedef struct nsdae_lcp_info {
  int outcome;     /* enum nsdae_outcome */
  int stage;       /* enum nsdae_lcp_stage that ended it */
  int proof;       /* enum nsdae_proof */
  int ray;         /* enum nsdae_lcp_ray; looked for where there is no solution to hand over and n
                      is at most 60 */
  int pivots;      /* over all stages */
  double residual; /* max_i |min(x_i / sx_i, y_i / sy_i)| of the equilibrated problem (see
                      nsdae_dlcpres) of the x handed over, which below 1e-308 is that rounded
                      to doubles */
} nsdae_lcp_info;

/* tol 1e-10, every stage, enumeration up to n = 12. NULL is left alone. */
NSDAE_API void nsdae_lcp_options_default(nsdae_lcp_options *options);

/* Names of a stage ("lemke") and of what a ray proves ("not copositive"); "unknown" for any other
 * value. Those of outcomes and proofs are in nsdae/certificate.h. */
NSDAE_API const char *nsdae_lcp_stage_name(int stage);
NSDAE_API const char *nsdae_lcp_ray_name(int ray);

/* Solves the problem; allocates its own workspace, once. A problem whose matrix falls apart into
 * parts that no entry joins is solved part by part; info then has the largest residual, the sum of
 * the pivots, and the last stage that a part took.
 *   problem  n in [0, 20000]; A and b may be NULL where n = 0, and so may x and y
 *   options  NULL: the defaults
 *   x [n]    in: a guess whose positive entries are the active set tried first (zero: none);
 *            out: the solution, or the best point found, or zero
 *   y [n]    out: A x + b; with NSDAE_PROOF_FARKAS, u >= 0 with A^T u <= 0 and b^T u < 0: for
 *            x >= 0, u^T (A x + b) < 0, so that no x >= 0 has A x + b >= 0. With
 *            NSDAE_PROOF_ENUMERATED an x >= 0 has, but no complementary one. Proofs are checked in
 *            exact arithmetic on A and b as given
 *   info     may be NULL
 * NSDAE_OK solved; NSDAE_E_INFEASIBLE proved without solution; NSDAE_E_LCP no solution found.
 * With NSDAE_E_ARGUMENT (missing or outside its range), NSDAE_E_NONFINITE (a NaN or an infinity in
 * A or b) and NSDAE_E_MEMORY, x and y are as they were. */
NSDAE_API int nsdae_lcp_solve(const nsdae_lcp_problem *problem, const nsdae_lcp_options *options,
                              double *x, double *y, nsdae_lcp_info *info);

/* The same in the caller's workspace, without allocation.
 *   basis [n]  in: not 0 where x_i is thought positive, 0 where y_i is; out: 1 and 0, that of the
 *              solution, in which an x_i may be zero (of no use where none was found)
 *   work [lwork], iwork [liwork]: at least the sizes for n from nsdae_lcp_workspace */
NSDAE_API int nsdae_lcp_solve_in(const nsdae_lcp_problem *problem, const nsdae_lcp_options *options,
                                 int *basis, double *x, double *y, nsdae_lcp_info *info,
                                 double *work, int lwork, int *iwork, int liwork);

/* Both sizes are at least 1; NSDAE_E_ARGUMENT where n is outside [0, 20000] or a size is NULL. */
NSDAE_API int nsdae_lcp_workspace(int n, int *lwork, int *liwork);

#ifdef __cplusplus
}
#endif
#endif
