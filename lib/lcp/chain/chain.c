/* One stage after the other until the residual, computed afresh from A and b, is below the
 * tolerance.
 */
#include "chain.h"

#include <float.h>
#include <limits.h>
#include <math.h>
#include <nsdae/lcp.h>
#include <stddef.h>
#include <stdlib.h>
#include <string.h>

#include "disjoint_sets.h"
#include "finite.h"
#include "lcp_methods.h"
#include "proof.h"

/* A problem whose matrix falls apart is solved island by island: that is exact, and whatever a
 * stage costs or misses it costs or misses on the island. A proof for an island is one for the
 * whole, with zeros elsewhere.
 *
 * An island is judged by its own b. Where b is nothing but the rounding of larger terms elsewhere
 * that can be too strict, so a point that fails there is judged once more as a whole. A proof
 * has no scale and stands, but where all b of its island are below the rounding of the largest. */

/* Rows that cost no more to factor as one than to sort into islands. */
enum { FEW = 32 };

/* A problem and the islands that it falls into, which take turns in its workspace. */
typedef struct parts {
  nsdae_lcp_work *whole;
  double *work;
  int *iwork;
  int *label, *member; /* n, n: see chain.h; behind all that an island works in */
} parts;

/* One island in the workspace of the whole. */
typedef struct part {
  nsdae_lcp_problem problem;
  nsdae_lcp_info info;
  nsdae_lcp_work chain;
} part;

/* ---- memory */

/* Doubles for an island of m rows: its A, b, x and y, and what the chain works in. */
static double doubles_for(int m)
{
  return nsdae_lcp_work_doubles(m) + (double)m * (m + 3);
}

/* Ints for the same: its basis, and what the chain works in. */
static int ints_for(int m)
{
  return nsdae_lcp_work_ints(m) + m;
}

/* For all of that, with room for the problem of an island beside it as far as an int can say so. */
int nsdae_lcp_workspace(int n, int *lwork, int *liwork)
{
  if (n < 0 || n > NSDAE_LCP_LARGEST || !lwork || !liwork) return NSDAE_E_ARGUMENT;
  *lwork = (int)fmin(doubles_for(n), INT_MAX);
  *liwork = ints_for(n) + 2 * n;
  return NSDAE_OK;
}

static int largest_island(const parts *p)
{
  int most = 0, n = p->whole->n;
  for (int island = 0; island < n; island++) {
    if (p->label[island] != island) continue;
    int size = nsdae_islands_members(n, p->label, island, p->member);
    most = size > most ? size : most;
  }
  return most;
}

/* ---- one island */

/* Solves the island whose m members are listed; returns its status. */
static int solve_part(const parts *p, part *one, int m)
{
  const nsdae_lcp_work *w = p->whole;
  double *A = p->work, *b = A + (size_t)m * (size_t)m, *x = b + m, *y = x + m;
  for (int j = 0; j < m; j++) {
    const double *column = w->problem->A + (size_t)p->member[j] * (size_t)w->problem->lda;
    for (int i = 0; i < m; i++) A[(size_t)j * (size_t)m + (size_t)i] = column[p->member[i]];
    b[j] = w->problem->b[p->member[j]];
    p->iwork[j] = w->basis[p->member[j]];
  }
  one->problem = (nsdae_lcp_problem){.n = m, .A = A, .lda = m, .b = b};
  one->info = (nsdae_lcp_info){.residual = INFINITY};
  one->chain = (nsdae_lcp_work){.problem = &one->problem,
                                .options = w->options,
                                .info = &one->info,
                                .n = m,
                                .basis = p->iwork,
                                .x = x,
                                .y = y};
  nsdae_lcp_work_lay_out(&one->chain, y + m, p->iwork + m);
  return nsdae_lcp_chain_run(&one->chain);
}

static void scatter_island(const parts *p, const part *one)
{
  for (int i = 0; i < one->problem.n; i++) {
    p->whole->x[p->member[i]] = one->chain.x[i];
    p->whole->y[p->member[i]] = one->chain.y[i];
    p->whole->basis[p->member[i]] = one->chain.basis[i];
  }
}

/* ---- all islands */

/* All islands; the certificate of the whole is the worst of all, of the stages the last. Returns
 * the first that is proved to have no solution, or else the first that was not solved, or -1. */
static int solve_all(const parts *p, int *proved)
{
  part one;
  nsdae_lcp_info *info = p->whole->info;
  int failed = -1, n = p->whole->n;
  *info = (nsdae_lcp_info){.outcome = NSDAE_OUTCOME_SOLVED};
  for (int island = 0; island < n; island++) {
    if (p->label[island] != island) continue;
    int m = nsdae_islands_members(n, p->label, island, p->member);
    int status = solve_part(p, &one, m);
    scatter_island(p, &one);
    info->pivots += one.info.pivots;
    info->residual = fmax(info->residual, one.info.residual);
    if (!info->ray) info->ray = one.info.ray;
    if (one.info.outcome == NSDAE_OUTCOME_SOLVED && one.info.stage > info->stage)
      info->stage = one.info.stage;
    if (status == NSDAE_OK || *proved || (failed >= 0 && status != NSDAE_E_INFEASIBLE)) continue;
    failed = island;
    *proved = status == NSDAE_E_INFEASIBLE;
  }
  return failed;
}

/* Whether the b of an island are what rounding may leave of the largest. */
static int is_rounding(const parts *p, int island)
{
  double largest = 0, here = 0;
  for (int i = 0; i < p->whole->n; i++) {
    double size = fabs(p->whole->problem->b[i]);
    largest = fmax(largest, size);
    if (p->label[i] == island) here = fmax(here, size);
  }
  return here <= DBL_EPSILON * largest;
}

/* Whether the point, judged as a whole, is a solution. */
static int judge_whole(const parts *p)
{
  nsdae_lcp_work *w = p->whole;
  int stage = w->info->stage;
  w->info->residual = INFINITY;
  w->info->outcome = NSDAE_OUTCOME_UNSOLVED;
  nsdae_lcp_work_lay_out(w, p->work, p->iwork);
  nsdae_lcp_work_scale(w);
  for (int i = 0; i < w->n; i++) w->x[i] /= w->scaled.column[i];
  nsdae_lcp_judge(w, w->basis, stage);
  nsdae_lcp_hand_over(w);
  return w->info->outcome == NSDAE_OUTCOME_SOLVED;
}

/* The same for each island of the problem alone, where it has more than one; work and iwork are
 * those that w was laid out in. */
static int islands_run(nsdae_lcp_work *w, double *work, int lwork, int *iwork)
{
  int *label = iwork + ints_for(w->n);
  parts p = {.whole = w, .work = work, .iwork = iwork, .label = label, .member = label + w->n};
  if (w->n == 0) {
    *w->info = (nsdae_lcp_info){.outcome = NSDAE_OUTCOME_SOLVED, .stage = NSDAE_LCP_TRIVIAL};
    return NSDAE_OK;
  }
  if (nsdae_lcp_guess_nothing(w) || (w->n <= FEW && nsdae_lcp_guess_basis(w))) return NSDAE_OK;
  int islands = nsdae_islands_find(w->n, w->problem->A, w->problem->lda, label);
  if (islands < 2 && w->n > FEW && nsdae_lcp_guess_basis(w)) return NSDAE_OK;
  /* The whole where there is one island, or where an int is too small for the size of the
   * workspace: that begins at some 18 000 rows. */
  if (islands < 2 || doubles_for(largest_island(&p)) > lwork) return nsdae_lcp_chain_run(w);
  int proved = 0, failed = solve_all(&p, &proved);
  int stands = proved && !is_rounding(&p, failed);
  if (failed < 0 || (!stands && judge_whole(&p))) return NSDAE_OK;
  /* The certificate of the failed island is that of the whole. */
  part one;
  int m = nsdae_islands_members(w->n, label, failed, p.member), status = solve_part(&p, &one, m);
  w->info->outcome = one.info.outcome;
  w->info->stage = one.info.stage;
  w->info->proof = one.info.proof;
  w->info->ray = one.info.ray;
  if (one.info.proof != NSDAE_PROOF_FARKAS) return status;
  memset(w->y, 0, (size_t)w->n * sizeof *w->y);
  scatter_island(&p, &one);
  return status;
}

/* ---- islands */

int nsdae_islands_find(int n, const double *A, int lda, int *label)
{
  int count = n;
  nsdae_sets_begin(label, n);
  for (int j = 0; j < n && count > 1; j++) {
    const double *column = A + (size_t)j * (size_t)lda;
    int mine = nsdae_sets_root(label, j);
    for (int i = 0; i < n; i++) {
      if (label[i] == mine || column[i] == 0) continue;
      if (nsdae_sets_root(label, i) == mine) continue;
      mine = nsdae_sets_join(label, i, mine);
      count--;
    }
  }
  for (int i = 0; i < n; i++) label[i] = nsdae_sets_root(label, i);
  return count;
}

int nsdae_islands_members(int n, const int *label, int island, int *member)
{
  int count = 0;
  for (int i = island; i < n; i++)
    if (label[i] == island) member[count++] = i;
  return count;
}

/* b >= 0, and the active set of the caller: neither needs a search. */
static int try_trivial(nsdae_lcp_work *w)
{
  for (int i = 0; i < w->n; i++)
    if (w->scaled.b[i] < 0) return 0;
  memset(w->room.trial, 0, (size_t)w->n * sizeof *w->room.trial);
  memset(w->x, 0, (size_t)w->n * sizeof *w->x);
  return nsdae_lcp_judge(w, w->room.trial, NSDAE_LCP_TRIVIAL);
}

static int try_warm(nsdae_lcp_work *w)
{
  int any = 0;
  for (int i = 0; i < w->n; i++) any |= w->basis[i];
  return any && nsdae_lcp_judge_basis(w, w->basis, NSDAE_LCP_WARM);
}

/* With a solution at hand, if a doubted one, there is nothing to be proved. */
static int prove(nsdae_lcp_work *w)
{
  return w->info->outcome != NSDAE_OUTCOME_SOLVED && nsdae_lcp_prove(w);
}

static int enumerate(nsdae_lcp_work *w)
{
  if (w->n > w->options->enumerate_max) return 0;
  if (w->info->outcome != NSDAE_OUTCOME_SOLVED && nsdae_lcp_prove_all(w)) return 1;
  for (long set = 0; set < 1L << w->n; set++) {
    for (int i = 0; i < w->n; i++) w->room.trial[i] = (int)(set >> i & 1);
    if (nsdae_lcp_judge_basis(w, w->room.trial, NSDAE_LCP_ENUMERATE)) return 1;
  }
  return 0;
}

/* In the order of their bits. Each returns whether the chain ends with it: with a proof, or
 * settled.
 */
static int (*const stages[])(nsdae_lcp_work *) = {try_trivial,
                                                  try_warm,
                                                  nsdae_lcp_try_lemke,
                                                  nsdae_lcp_try_newton,
                                                  nsdae_lcp_try_coverings,
                                                  prove,
                                                  nsdae_lcp_try_further,
                                                  enumerate};

int nsdae_lcp_chain_run(nsdae_lcp_work *w)
{
  nsdae_lcp_work_scale(w);
  for (size_t k = 0; k < sizeof stages / sizeof *stages; k++)
    if ((w->options->stages & 1 << k) && stages[k](w)) break;
  int status = w->info->outcome == NSDAE_OUTCOME_SOLVED       ? NSDAE_OK
               : w->info->outcome == NSDAE_OUTCOME_INFEASIBLE ? NSDAE_E_INFEASIBLE
                                                              : NSDAE_E_LCP;
  if (status != NSDAE_OK && w->ray && w->n <= NSDAE_RAY_MAX) {
    /* The ray again, from which a later stage took the arrays. */
    int pivots;
    if (nsdae_lcp_lemke_once(w, NULL, &pivots) == 1) nsdae_lcp_read_ray(w);
  }
  nsdae_lcp_hand_over(w);
  return status;
}

/* The solver as it is called: arguments, workspace, names. */

void nsdae_lcp_options_default(nsdae_lcp_options *options)
{
  if (!options) return;
  *options = (nsdae_lcp_options){.tol = 1e-10, .stages = NSDAE_LCP_ALL, .enumerate_max = 12};
}

const char *nsdae_lcp_stage_name(int stage)
{
  switch (stage) {
  case NSDAE_LCP_NONE:
    return "none";
#define NAME(name, value, word, text) \
  case value:                         \
    return word;
    NSDAE_LCP_STAGE_LIST(NAME)
#undef NAME
  default:
    return "unknown";
  }
}

const char *nsdae_lcp_ray_name(int ray)
{
  static const char *const name[] = {"nothing", "not copositive", "not strictly copositive"};
  return ray >= 0 && ray <= NSDAE_LCP_RAY_NOT_STRICTLY_COPOSITIVE ? name[ray] : "unknown";
}

/* Status of what both ways of calling take. */
static int check_solve(const nsdae_lcp_problem *p, const nsdae_lcp_options *o, const double *x,
                       const double *y)
{
  if (!p || p->n < 0 || p->n > NSDAE_LCP_LARGEST || p->lda < 1 || p->lda < p->n)
    return NSDAE_E_ARGUMENT;
  if (p->n > 0 && (!p->A || !p->b || !x || !y)) return NSDAE_E_ARGUMENT;
  if (!(o->tol > 0 && o->tol <= 1) || o->max_pivots < 0 || o->stages < 0 ||
      o->stages > NSDAE_LCP_ALL || o->enumerate_max < 0 || o->enumerate_max > 24)
    return NSDAE_E_ARGUMENT;
  int finite = nsdae_lcp_finite(p->n, 1, p->b, 1) && nsdae_lcp_finite(p->n, p->n, p->A, p->lda);
  return finite ? NSDAE_OK : NSDAE_E_NONFINITE;
}

int nsdae_lcp_solve_in(const nsdae_lcp_problem *problem, const nsdae_lcp_options *options,
                       int *basis, double *x, double *y, nsdae_lcp_info *info, double *work,
                       int lwork, int *iwork, int liwork)
{
  nsdae_lcp_options defaults;
  nsdae_lcp_info own;
  int need, ineed;
  nsdae_lcp_options_default(&defaults);
  nsdae_lcp_work w = {.problem = problem,
                      .options = options ? options : &defaults,
                      .info = info ? info : &own,
                      .basis = basis,
                      .x = x,
                      .y = y};
  *w.info = (nsdae_lcp_info){.residual = INFINITY};
  int status = check_solve(problem, w.options, x, y);
  if (status != NSDAE_OK) return status;
  w.n = problem->n;
  nsdae_lcp_workspace(w.n, &need, &ineed);
  if (!work || lwork < need || !iwork || liwork < ineed || (w.n > 0 && !basis))
    return NSDAE_E_ARGUMENT;
  nsdae_lcp_work_lay_out(&w, work, iwork);
  return islands_run(&w, work, lwork, iwork);
}

int nsdae_lcp_solve(const nsdae_lcp_problem *problem, const nsdae_lcp_options *options, double *x,
                    double *y, nsdae_lcp_info *info)
{
  nsdae_lcp_options defaults;
  int lwork, liwork;
  if (info) *info = (nsdae_lcp_info){.residual = INFINITY};
  nsdae_lcp_options_default(&defaults);
  int status = check_solve(problem, options ? options : &defaults, x, y);
  if (status != NSDAE_OK) return status;
  size_t n = (size_t)problem->n;
  nsdae_lcp_workspace(problem->n, &lwork, &liwork);
  char *block = malloc((size_t)lwork * sizeof(double) + ((size_t)liwork + n) * sizeof(int));
  if (!block) return NSDAE_E_MEMORY;
  double *work = (double *)(void *)block;
  int *iwork = (int *)(void *)(block + (size_t)lwork * sizeof(double)), *basis = iwork + liwork;
  for (size_t i = 0; i < n; i++) basis[i] = x[i] > 0;
  status = nsdae_lcp_solve_in(problem, options, basis, x, y, info, work, lwork, iwork, liwork);
  free(block);
  return status;
}
