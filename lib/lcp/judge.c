#include "judge.h"

#include <math.h>
#include <nsdae/kernels.h>
#include <stddef.h>
#include <string.h>

#include "active_set.h"
#include "dense.h"

double nsdae_chain_residual(nsdae_chain *c)
{
  double residual;
  nsdae_dlcpres(c->n, c->A, c->n > 0 ? c->n : 1, c->b, c->x, c->y, &residual, c->sizes);
  for (int i = 0; i < c->n; i++)
    if (!isfinite(c->x[i] * c->column[i]) || !isfinite(c->y[i] / c->row[i])) residual = INFINITY;
  return isnan(residual) || c->out_of_range ? INFINITY : residual;
}

/* Up to so many rows a solution with a residual above this part of tol is doubted: it owes more
 * than rounding, as where an x_i or y_i below zero was cut off; another stage mostly has a better.
 */
enum { DOUBTED = 40 };
static const double DOUBT = 1e-3;

int nsdae_chain_is_settled(const nsdae_chain *c)
{
  return c->info->outcome == NSDAE_LCP_SOLVED &&
         (c->n > DOUBTED || c->info->residual <= DOUBT * c->options->tol);
}

int nsdae_chain_judge(nsdae_chain *c, const int *basis, int stage)
{
  double residual = nsdae_chain_residual(c);
  if (!(residual < c->info->residual)) return 0;
  c->info->residual = residual;
  memcpy(c->best, c->x, (size_t)c->n * sizeof *c->best);
  if (residual > c->options->tol) return 0;
  for (int i = 0; i < c->n; i++) c->basis[i] = basis[i] != 0;
  c->info->outcome = NSDAE_LCP_SOLVED;
  c->info->stage = stage;
  return nsdae_chain_is_settled(c);
}

/* rhs = -b_B - A_BB x_B of the active set in c->index, for x_B in part. */
static void defect(nsdae_chain *c, int size, const double *part)
{
  for (int i = 0; i < size; i++) c->rhs[i] = -c->b[c->index[i]];
  for (int j = 0; j < size; j++) {
    const double *from = c->A + (size_t)c->index[j] * (size_t)c->n;
    for (int i = 0; i < size; i++) c->rhs[i] -= from[c->index[i]] * part[j];
  }
}

/* x on the active set: A_BB x_B = -b_B, all else zero. Returns 0, or 1 where A_BB is singular. One
 * refinement makes every row exact to its own terms, not to the largest (Skeel, Math. Comput. 35,
 * 1980). */
static int solve(nsdae_chain *c, const int *basis, double *x)
{
  double *part = c->sizes;
  int size = nsdae_lcp_gather(c->n, c->A, c->n, basis, c->lu, c->index);
  if (nsdae_la_lu(size, c->lu, size, c->pivot) != 0) return 1;
  memset(part, 0, (size_t)size * sizeof *part);
  for (int round = 0; round < 2; round++) {
    defect(c, size, part);
    nsdae_la_lu_solve(size, c->lu, size, c->pivot, c->rhs);
    for (int j = 0; j < size; j++) part[j] += c->rhs[j];
  }
  memset(x, 0, (size_t)c->n * sizeof *x);
  for (int j = 0; j < size; j++) x[c->index[j]] = fmax(part[j], 0);
  return 0;
}

int nsdae_chain_judge_basis(nsdae_chain *c, const int *basis, int stage)
{
  return solve(c, basis, c->x) == 0 && nsdae_chain_judge(c, basis, stage); /* zeros of x too */
}
