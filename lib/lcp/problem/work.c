/* Memory, scales, and the way back to the problem as it was given. */
#include "work.h"

#include <math.h>
#include <nsdae/kernels.h>
#include <string.h>

#include "dense.h"
#include "dictionary.h"
#include "enumerate.h"
#include "vector.h"

/* ---- judge */

/* Residual of w->x, in equilibrated rows and columns; w->y := A x + b. Infinite where an x_i or y_i
 * of the problem as given is not a finite number, and where b is out of range. */
static double point_residual(nsdae_lcp_work *w)
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
  double residual = point_residual(w);
  if (!(residual < w->info->residual)) return 0;
  w->info->residual = residual;
  memcpy(w->best, w->x, (size_t)w->n * sizeof *w->best);
  if (residual > w->options->tol) return 0;
  for (int i = 0; i < w->n; i++) w->basis[i] = basis[i] != 0;
  w->info->outcome = NSDAE_OUTCOME_SOLVED;
  w->info->stage = stage;
  return nsdae_lcp_is_settled(w);
}

/* x on the active set: A_BB x_B = -b_B, all else zero. One refinement makes every row exact to its
 * own terms, not to the largest (Skeel, Math. Comput. 35, 1980). */
int nsdae_lcp_judge_basis(nsdae_lcp_work *w, const int *basis, int stage)
{
  double *x = w->x;
  int n = w->n;
  const nsdae_lcp_point p = {.n = n,
                             .lda = n,
                             .a = w->scaled.A,
                             .b = w->scaled.b,
                             .x = x,
                             .lu = w->room.lu,
                             .basis = basis,
                             .pivot = w->room.pivot,
                             .index = w->room.index};
  int size = nsdae_lcp_active_set(&p);
  if (size < 0) return 0;
  for (int i = 0; i < size; i++) w->room.rhs[i] = -p.b[p.index[i]];
  for (int j = 0; j < size; j++) {
    const double *from = p.a + (size_t)p.index[j] * (size_t)n;
    for (int i = 0; i < size; i++) w->room.rhs[i] -= from[p.index[i]] * x[p.index[j]];
  }
  nsdae_la_lu_solve(size, p.lu, size, p.pivot, w->room.rhs);
  for (int j = 0; j < size; j++) x[p.index[j]] = fmax(x[p.index[j]] + w->room.rhs[j], 0);
  return nsdae_lcp_judge(w, basis, stage); /* zeros of x too */
}

void nsdae_lcp_hand_over(nsdae_lcp_work *w)
{
  int found = w->info->residual < INFINITY, proof = w->info->proof == NSDAE_PROOF_FARKAS;
  for (int i = 0; i < w->n; i++) w->x[i] = found ? w->best[i] : 0;
  w->info->residual = point_residual(w); /* y too may be that of another point */
  /* Rows and columns as the problem was given; y is that of x as it can be written. */
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
  for (int i = 0; proof && i < w->n; i++) w->y[i] = w->room.point[i];
}

/* The workspace that nsdae_dlemke asks for. */
static int lemke_size(int n)
{
  return nsdae_dictionary_size(n, nsdae_lemke_block(n));
}

double nsdae_lcp_work_doubles(int n)
{
  return 4.0 * n * n + 13.0 * n + lemke_size(n) + 1;
}

int nsdae_lcp_work_ints(int n)
{
  return 6 * n + 1;
}

void nsdae_lcp_work_lay_out(nsdae_lcp_work *w, double *work, int *iwork)
{
  nsdae_lcp_room *r = &w->room;
  size_t n = (size_t)w->n;
  w->scaled.A = work;
  w->scaled.b = w->scaled.A + n * n;
  w->scaled.row = w->scaled.b + n;
  w->scaled.column = w->scaled.row + n;
  w->best = w->scaled.column + n;
  r->lemke_size = lemke_size((int)n);
  r->lu = w->best + n;
  r->wide = r->lu + n * n;
  r->cover = r->wide + 2 * n * n + 4 * n;
  r->rhs = r->cover + n;
  r->sizes = r->rhs + n;
  r->point = r->sizes + n;
  r->lemke = r->point + 2 * n;
  r->trial = iwork;
  r->pivot = r->trial + n;
  r->index = r->pivot + n;
  r->allowed = r->index + 2 * n + 1;
}

void nsdae_lcp_work_scale(nsdae_lcp_work *w)
{
  size_t n = (size_t)w->n;
  for (size_t j = 0; j < n; j++)
    memcpy(w->scaled.A + j * n, w->problem->A + j * (size_t)w->problem->lda,
           n * sizeof *w->scaled.A);
  for (size_t i = 0; i < n; i++) w->scaled.b[i] = w->problem->b[i];
  nsdae_equilibrate(w->n, w->scaled.A, w->scaled.b, w->scaled.row, w->scaled.column, w->room.point,
                    w->room.index);
  double before = nsdae_largest(w->n, w->problem->b), after = nsdae_largest(w->n, w->scaled.b);
  w->scaled.out_of_range = before > 0 && !(after > 0x1p-900 && after < 0x1p900);
}
