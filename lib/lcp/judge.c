#include "judge.h"

#include <math.h>
#include <nsdae/kernels.h>
#include <stddef.h>
#include <string.h>

#include "dense.h"

double nsdae_chain_residual(nsdae_chain *c)
{
  double residual;
  size_t n = (size_t)c->n;
  for (size_t i = 0; i < n; i++) c->rhs[i] = c->x[i] / c->column[i];
  nsdae_dlcpres(c->n, c->A, c->n > 0 ? c->n : 1, c->b, c->rhs, c->y, &residual, c->sizes);
  for (size_t i = 0; i < n; i++) c->y[i] /= c->row[i];
  return residual;
}

int nsdae_chain_judge(nsdae_chain *c, int stage)
{
  double residual = nsdae_chain_residual(c);
  if (!(residual < c->info->residual)) return 0;
  c->info->residual = residual;
  memcpy(c->best, c->x, (size_t)c->n * sizeof *c->best);
  if (residual > c->options->tol) return 0;
  c->info->outcome = NSDAE_LCP_SOLVED;
  c->info->stage = stage;
  return 1;
}

/* x on the active set: A_BB x_B = -b_B, all else zero. Returns 0, or 1 where A_BB is singular. */
static int solve(nsdae_chain *c, const int *basis, double *x)
{
  int n = c->n, size = 0;
  for (int i = 0; i < n; i++)
    if (basis[i]) c->index[size++] = i;
  for (int j = 0; j < size; j++) {
    const double *from = c->A + (size_t)c->index[j] * (size_t)n;
    for (int i = 0; i < size; i++) c->lu[(size_t)j * (size_t)size + (size_t)i] = from[c->index[i]];
    c->rhs[j] = -c->b[c->index[j]];
  }
  if (nsdae_la_lu(size, c->lu, size, c->pivot) != 0) return 1;
  nsdae_la_lu_solve(size, c->lu, size, c->pivot, c->rhs);
  memset(x, 0, (size_t)n * sizeof *x);
  for (int j = 0; j < size; j++) x[c->index[j]] = fmax(c->rhs[j], 0) * c->column[c->index[j]];
  return 0;
}

int nsdae_chain_judge_basis(nsdae_chain *c, const int *basis, int stage)
{
  if (solve(c, basis, c->x) != 0 || !nsdae_chain_judge(c, stage)) return 0;
  for (int i = 0; i < c->n; i++) c->basis[i] = basis[i] && c->x[i] > 0;
  return 1;
}
