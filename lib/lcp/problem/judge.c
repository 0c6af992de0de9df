#include "judge.h"

#include <math.h>
#include <nsdae/kernels.h>
#include <stddef.h>
#include <string.h>

#include "active_set.h"
#include "dense.h"

double nsdae_lcp_residual(nsdae_lcp_work *w)
{
  double residual;
  nsdae_dlcpres(w->n, w->scaled.A, w->n > 0 ? w->n : 1, w->scaled.b, w->x, w->y, &residual,
                w->room.sizes);
  for (int i = 0; i < w->n; i++)
    if (!isfinite(w->x[i] * w->scaled.column[i]) || !isfinite(w->y[i] / w->scaled.row[i]))
      residual = INFINITY;
  return isnan(residual) || w->scaled.out_of_range ? INFINITY : residual;
}

/* Up to this number of rows a solution with a residual above this part of tol is doubted: it owes
 * more than rounding, as where an x_i or y_i below zero was cut off; another stage mostly has a
 * better.
 */
enum { DOUBTED = 40 };
static const double DOUBT = 1e-3;

int nsdae_lcp_is_settled(const nsdae_lcp_work *w)
{
  return w->info->outcome == NSDAE_OUTCOME_SOLVED &&
         (w->n > DOUBTED || w->info->residual <= DOUBT * w->options->tol);
}

int nsdae_lcp_judge(nsdae_lcp_work *w, const int *basis, int stage)
{
  double residual = nsdae_lcp_residual(w);
  if (!(residual < w->info->residual)) return 0;
  w->info->residual = residual;
  memcpy(w->best, w->x, (size_t)w->n * sizeof *w->best);
  if (residual > w->options->tol) return 0;
  for (int i = 0; i < w->n; i++) w->basis[i] = basis[i] != 0;
  w->info->outcome = NSDAE_OUTCOME_SOLVED;
  w->info->stage = stage;
  return nsdae_lcp_is_settled(w);
}

/* x on the active set: A_BB x_B = -b_B, all else zero. Returns 0, or 1 where A_BB is singular. One
 * refinement makes every row exact to its own terms, not to the largest (Skeel, Math. Comput. 35,
 * 1980). */
static int solve_basis(nsdae_lcp_work *w, const int *basis, double *x)
{
  double *part = w->room.sizes;
  int size = nsdae_lcp_gather(w->n, w->scaled.A, w->n, basis, w->room.lu, w->room.index);
  if (nsdae_la_lu(size, w->room.lu, size, w->room.pivot) != 0) return 1;
  memset(part, 0, (size_t)size * sizeof *part);
  for (int round = 0; round < 2; round++) {
    /* rhs = -b_B - A_BB x_B of the active set in w->room.index, for x_B in part. */
    for (int i = 0; i < size; i++) w->room.rhs[i] = -w->scaled.b[w->room.index[i]];
    for (int j = 0; j < size; j++) {
      const double *from = w->scaled.A + (size_t)w->room.index[j] * (size_t)w->n;
      for (int i = 0; i < size; i++) w->room.rhs[i] -= from[w->room.index[i]] * part[j];
    }
    nsdae_la_lu_solve(size, w->room.lu, size, w->room.pivot, w->room.rhs);
    for (int j = 0; j < size; j++) part[j] += w->room.rhs[j];
  }
  memset(x, 0, (size_t)w->n * sizeof *x);
  for (int j = 0; j < size; j++) x[w->room.index[j]] = fmax(part[j], 0);
  return 0;
}

int nsdae_lcp_judge_basis(nsdae_lcp_work *w, const int *basis, int stage)
{
  return solve_basis(w, basis, w->x) == 0 && nsdae_lcp_judge(w, basis, stage); /* zeros of x too */
}

/* Rows and columns as the problem was given; y is that of x as it can be written. */
static void scale_back(nsdae_lcp_work *w)
{
  int rounded = 0;
  double residual;
  for (int i = 0; i < w->n; i++) {
    double x = w->x[i] * w->scaled.column[i];
    rounded |= x / w->scaled.column[i] != w->x[i];
    w->room.rhs[i] = x / w->scaled.column[i];
  }
  if (rounded)
    nsdae_dlcpres(w->n, w->scaled.A, w->n, w->scaled.b, w->room.rhs, w->y, &residual,
                  w->room.sizes);
  for (int i = 0; i < w->n; i++) {
    w->x[i] *= w->scaled.column[i];
    w->y[i] /= w->scaled.row[i];
  }
}

void nsdae_lcp_hand_over(nsdae_lcp_work *w)
{
  int found = w->info->residual < INFINITY, proof = w->info->proof == NSDAE_PROOF_FARKAS;
  if (w->info->outcome != NSDAE_OUTCOME_SOLVED ||
      memcmp(w->x, w->best, (size_t)w->n * sizeof *w->x) != 0) { /* else y is that of x */
    for (int i = 0; i < w->n; i++) w->x[i] = found ? w->best[i] : 0;
    w->info->residual = nsdae_lcp_residual(w);
  }
  scale_back(w);
  for (int i = 0; proof && i < w->n; i++) w->y[i] = w->room.point[i];
}
