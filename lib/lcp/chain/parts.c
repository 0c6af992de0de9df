/* A problem whose matrix falls apart is solved island by island: that is exact, and whatever a
 * stage costs or misses it costs or misses on the island. A proof for an island is one for the
 * whole, with zeros elsewhere.
 *
 * An island is judged by its own b. Where b is nothing but the rounding of larger terms elsewhere
 * that can be too strict, so a point that fails there is judged once more as a whole. A proof
 * has no scale and stands, but where all b of its island are below the rounding of the largest. */
#include <float.h>
#include <limits.h>
#include <math.h>
#include <string.h>

#include "chain.h"

/* Rows that cost no more to factor as one than to sort into islands. */
enum { FEW = 32 };

/* A problem and the islands that it falls into, which take turns in its workspace. */
typedef struct parts {
  nsdae_lcp_work *whole;
  double *work;
  int *iwork;
  int *label, *member; /* n, n: see islands.c; behind all that an island works in */
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

int nsdae_lcp_islands_run(nsdae_lcp_work *w, double *work, int lwork, int *iwork)
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
