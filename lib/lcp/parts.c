/* A problem whose matrix falls apart is solved island by island: that is exact, and whatever a
 * stage costs or misses it costs or misses on the island. A proof for an island is one for the
 * whole, with zeros elsewhere.
 *
 * An island is judged by its own b. Where b is nothing but the rounding of larger terms elsewhere
 * that can be too strict, so a point that fails there is judged once more as a whole. A proof
 * has no scale and stands, but where all b of its island are below the rounding of the largest. */
#include <float.h>
#include <math.h>
#include <stddef.h>
#include <string.h>

#include "chain.h"
#include "guess.h"
#include "islands.h"
#include "judge.h"

/* Rows that cost no more to factor as one than to sort into islands. */
enum { FEW = 32 };

/* One island in the workspace of the whole. */
typedef struct part {
  nsdae_lcp_problem problem;
  nsdae_lcp_info info;
  nsdae_chain chain;
} part;

static int order_of(int stage)
{
  static const int order[] = {NSDAE_LCP_TRIVIAL,  NSDAE_LCP_WARM,    NSDAE_LCP_LEMKE,
                              NSDAE_LCP_COVERING, NSDAE_LCP_FURTHER, NSDAE_LCP_PROVE,
                              NSDAE_LCP_ENUMERATE};
  for (int i = 0; i < 7; i++)
    if (stage == order[i]) return i;
  return -1;
}

static int largest_island(const nsdae_chain *c)
{
  int most = 0;
  for (int island = 0; island < c->n; island++) {
    if (c->label[island] != island) continue;
    int size = nsdae_islands_members(c->n, c->label, island, c->member);
    most = size > most ? size : most;
  }
  return most;
}

/* Whether an island of m rows has room, its problem and the workspace of its own solver: always up
 * to some 18 000 rows in all, where an int begins to be too small for the size of it. */
static int fits(int m, int lwork)
{
  return nsdae_chain_size(m) + (double)m * (m + 3) <= lwork;
}

/* Solves the island whose m members are listed; returns its status. */
static int solve_part(const nsdae_chain *c, part *p, int m, double *work, int *iwork)
{
  double *A = work, *b = A + (size_t)m * (size_t)m, *x = b + m, *y = x + m;
  for (int j = 0; j < m; j++) {
    const double *column = c->problem->A + (size_t)c->member[j] * (size_t)c->problem->lda;
    for (int i = 0; i < m; i++) A[(size_t)j * (size_t)m + (size_t)i] = column[c->member[i]];
    b[j] = c->problem->b[c->member[j]];
    iwork[j] = c->basis[c->member[j]];
  }
  p->problem = (nsdae_lcp_problem){.n = m, .A = A, .lda = m, .b = b};
  p->info = (nsdae_lcp_info){.residual = INFINITY};
  p->chain = (nsdae_chain){.problem = &p->problem,
                           .options = c->options,
                           .info = &p->info,
                           .n = m,
                           .basis = iwork,
                           .x = x,
                           .y = y};
  nsdae_chain_lay_out(&p->chain, y + m, iwork + m);
  return nsdae_chain_run_whole(&p->chain);
}

static void scatter(nsdae_chain *c, const part *p)
{
  for (int i = 0; i < p->problem.n; i++) {
    c->x[c->member[i]] = p->chain.x[i];
    c->y[c->member[i]] = p->chain.y[i];
    c->basis[c->member[i]] = p->chain.basis[i];
  }
}

/* What is to be said of the whole: the worst of all. */
static void merge(nsdae_lcp_info *whole, const nsdae_lcp_info *one)
{
  whole->pivots += one->pivots;
  whole->residual = fmax(whole->residual, one->residual);
  if (one->ray && !whole->ray) whole->ray = one->ray;
  if (one->outcome == NSDAE_LCP_SOLVED && order_of(one->stage) > order_of(whole->stage))
    whole->stage = one->stage;
}

/* All islands; returns the first that is proved to have no solution, or else the first that was not
 * solved, or -1. */
static int solve_all(nsdae_chain *c, double *work, int *iwork, int *proved)
{
  part p;
  int failed = -1;
  *c->info = (nsdae_lcp_info){.outcome = NSDAE_LCP_SOLVED};
  for (int island = 0; island < c->n; island++) {
    if (c->label[island] != island) continue;
    int m = nsdae_islands_members(c->n, c->label, island, c->member);
    int status = solve_part(c, &p, m, work, iwork);
    scatter(c, &p);
    merge(c->info, &p.info);
    if (status == NSDAE_OK || *proved || (failed >= 0 && status != NSDAE_E_INFEASIBLE)) continue;
    failed = island;
    *proved = status == NSDAE_E_INFEASIBLE;
  }
  return failed;
}

/* Whether the b of an island are what rounding may leave of the largest. */
static int is_rounding(const nsdae_chain *c, int island)
{
  double largest = 0, here = 0;
  for (int i = 0; i < c->n; i++) {
    double size = fabs(c->problem->b[i]);
    largest = fmax(largest, size);
    if (c->label[i] == island) here = fmax(here, size);
  }
  return here <= DBL_EPSILON * largest;
}

/* Whether the point, judged as a whole, is a solution. */
static int judge_whole(nsdae_chain *c, double *work, int *iwork)
{
  int stage = c->info->stage;
  c->info->residual = INFINITY;
  c->info->outcome = NSDAE_LCP_UNSOLVED;
  nsdae_chain_lay_out(c, work, iwork);
  nsdae_chain_equilibrate(c);
  for (int i = 0; i < c->n; i++) c->x[i] /= c->column[i];
  nsdae_chain_judge(c, c->basis, stage);
  nsdae_chain_hand_over(c);
  return c->info->outcome == NSDAE_LCP_SOLVED;
}

/* What the failed island says is said of the whole. */
static int report(nsdae_chain *c, int failed, double *work, int *iwork)
{
  part p;
  int m = nsdae_islands_members(c->n, c->label, failed, c->member);
  int status = solve_part(c, &p, m, work, iwork);
  c->info->outcome = p.info.outcome;
  c->info->stage = p.info.stage;
  c->info->proof = p.info.proof;
  c->info->ray = p.info.ray;
  if (p.info.proof != NSDAE_LCP_PROOF_FARKAS) return status;
  for (int i = 0; i < c->n; i++) c->y[i] = 0;
  scatter(c, &p);
  return status;
}

int nsdae_chain_run(nsdae_chain *c, double *work, int lwork, int *iwork)
{
  if (c->n == 0) {
    *c->info = (nsdae_lcp_info){.outcome = NSDAE_LCP_SOLVED, .stage = NSDAE_LCP_TRIVIAL};
    return NSDAE_OK;
  }
  if (nsdae_guess_nothing(c) || (c->n <= FEW && nsdae_guess_basis(c))) return NSDAE_OK;
  int islands = nsdae_islands_find(c->n, c->problem->A, c->problem->lda, c->label);
  if (islands < 2 && c->n > FEW && nsdae_guess_basis(c)) return NSDAE_OK;
  if (islands < 2 || !fits(largest_island(c), lwork)) return nsdae_chain_run_whole(c);
  int proved = 0, failed = solve_all(c, work, iwork, &proved);
  int stands = proved && !is_rounding(c, failed);
  if (failed < 0 || (!stands && judge_whole(c, work, iwork))) return NSDAE_OK;
  return report(c, failed, work, iwork);
}
