/* Most steps of a simulation end here, so that neither islands are looked for nor rows scaled.
 *
 * With r_i = max(-y_i, 0) where x_i = 0 and |y_i| where x_i > 0,
 *   |min(x_i / sx_i, y_i / sy_i)| <= r_i / s_i,   s_i = |b_i| + sum_j |a_ij x_j| <= sy_i.
 * The right side does not change when rows or columns are scaled, and its sum only runs over the
 * island of i: it bounds the residual of nsdae_dlcpres in every scaling, of the whole and of every
 * island (componentwise backward error, Oettli and Prager, Numer. Math. 6, 1964). It does so as
 * long as the s_i are not larger than b warrants, for which the active block has to be regular. */
#include "chain.h"

#include <float.h>
#include <math.h>
#include <string.h>

#include "enumerate.h"
#include "dense.h"

/* Bounds that a refinement cannot improve on by much, and such that are not for want of one. */
static const double ROUNDING = 2e-15, WRONG = 1e-6;

/* A sum so small against its terms is zero. */
static const double CANCELLED = 8 * DBL_EPSILON;

/* Sizes below this may be what underflow left. */
static const double TINY = DBL_MIN / DBL_EPSILON;

static int accept(nsdae_lcp_work *w, int stage, double residual)
{
  w->info->outcome = NSDAE_OUTCOME_SOLVED;
  w->info->stage = stage;
  w->info->residual = residual;
  for (int i = 0; i < w->n; i++) w->basis[i] = stage == NSDAE_LCP_WARM && w->basis[i];
  return 1;
}

int nsdae_lcp_guess_nothing(nsdae_lcp_work *w)
{
  if (!(w->options->stages & NSDAE_LCP_TRIVIAL)) return 0;
  for (int i = 0; i < w->n; i++)
    if (w->problem->b[i] < 0) return 0;
  for (int i = 0; i < w->n; i++) {
    w->x[i] = 0;
    w->y[i] = w->problem->b[i];
  }
  return accept(w, NSDAE_LCP_TRIVIAL, 0);
}

/* ---- the equations of an active set */

static const double *scaled_column(const nsdae_lcp_work *w, int j)
{
  return w->problem->A + (size_t)j * (size_t)w->problem->lda;
}

/* y += a x, s += |a x|. */
static void add_column(int n, const double *restrict a, double x, double *restrict y,
                       double *restrict s)
{
  for (int i = 0; i < n; i++) {
    double term = a[i] * x;
    y[i] += term;
    s[i] += fabs(term);
  }
}

/* ---- residual and its rounding */

/* Whether the rows say something: their sizes are neither infinite nor what underflow left. A row
 * without size has no term at all, rather than one that underflowed. */
static int are_sound(const nsdae_lcp_work *w, int size)
{
  for (int i = 0; i < w->n; i++) {
    double s = w->room.sizes[i];
    if (s >= TINY && s <= DBL_MAX) continue;
    if (s != 0) return 0;
    for (int j = 0; j < size; j++)
      if (scaled_column(w, w->room.index[j])[i] != 0 && w->x[w->room.index[j]] > 0) return 0;
  }
  return 1;
}

/* max_i r_i / s_i; a row without size has r_i = 0, and counts for nothing. */
static double bound(const nsdae_lcp_work *w)
{
  const double *restrict x = w->x, *restrict y = w->y, *restrict s = w->room.sizes;
  double worst = 0;
  for (int i = 0; i < w->n; i++) {
    double r = (x[i] > 0 ? fabs(y[i]) : -y[i]) / s[i];
    worst = r > worst ? r : worst;
  }
  return worst;
}

/* ---- solution of an active set */

/* rhs := A_BB^-1 rhs; the rest of terms that cancel is zero. */
static void divide(nsdae_lcp_work *w, int size)
{
  double *x = w->room.rhs, *s = w->room.cover;
  for (int j = 0; j < size; j++) {
    double held = x[j];
    x[j] = x[w->room.pivot[j] - 1];
    x[w->room.pivot[j] - 1] = held;
  }
  for (int j = 0; j < size; j++) s[j] = fabs(x[j]);
  for (int j = 0; j < size; j++) {
    const double *column = w->room.lu + (size_t)j * (size_t)size;
    add_column(size - j - 1, column + j + 1, -x[j], x + j + 1, s + j + 1);
  }
  for (int j = size - 1; j >= 0; j--) {
    const double *column = w->room.lu + (size_t)j * (size_t)size;
    x[j] = fabs(x[j]) > CANCELLED * s[j] ? x[j] / column[j] : 0;
    add_column(j, column, -x[j], x, s);
  }
}

/* x with the active set of that size, refined once where that is of use; what is zero at first
 * stays so. Returns its bound. */
static double solve_active_set(nsdae_lcp_work *w, int size)
{
  double error = WRONG;
  memset(w->x, 0, (size_t)w->n * sizeof *w->x);
  memcpy(w->y, w->problem->b, (size_t)w->n * sizeof *w->y);
  for (int round = 0; round < 2 && error > ROUNDING && error <= WRONG; round++) {
    for (int j = 0; j < size; j++) w->room.rhs[j] = -w->y[w->room.index[j]];
    divide(w, size);
    for (int j = 0; j < size; j++) {
      double *x = w->x + w->room.index[j], sum = *x + w->room.rhs[j];
      if (round == 0 || *x > 0) *x = sum > 0 ? sum : 0;
    }
    /* y and s of the head of A x + b; A and b are finite, so that x_j = 0 adds nothing. */
    for (int i = 0; i < w->n; i++) {
      w->y[i] = w->problem->b[i];
      w->room.sizes[i] = fabs(w->y[i]);
    }
    for (int j = 0; j < size; j++) {
      double x = w->x[w->room.index[j]];
      if (x > 0) add_column(w->n, scaled_column(w, w->room.index[j]), x, w->y, w->room.sizes);
    }
    error = bound(w);
  }
  return error;
}

/* The largest share of itself by which an x_j > 0 changes where the rows of the head change by
 * their rounding, in irregular parts of it, so that no symmetry cancels them. */
static double sensitivity(nsdae_lcp_work *w, int size)
{
  double worst = 0, part = 0;
  for (int j = 0; j < size; j++) {
    part += part < 0.5 ? 0.6180339887498949 : -0.3819660112501051;
    w->room.rhs[j] = (j % 2 ? part : -part) * DBL_EPSILON * w->room.sizes[w->room.index[j]];
  }
  divide(w, size);
  for (int j = 0; j < size; j++) {
    double x = w->x[w->room.index[j]], change = fabs(w->room.rhs[j]);
    if (!isfinite(change)) return INFINITY;
    if (x > 0 && change > worst * x) worst = change / x;
  }
  return worst;
}

/* Whether x_j acts on a row with b_i < 0. */
static int acts(const nsdae_lcp_work *w, int j)
{
  const double *column = scaled_column(w, j), *b = w->problem->b;
  int i = 0;
  while (i < w->n && !(b[i] < 0 && column[i] != 0)) i++;
  return i < w->n;
}

/* Whether every x_j > 0 has a b_i < 0 on its island. On an island with b >= 0 the chain takes x =
 * 0, and so must do who solves all islands as one. */
static int is_pushed(const nsdae_lcp_work *w, int size)
{
  int *label = w->room.allowed, *pushed = w->room.trial, all = 1;
  for (int k = 0; k < size; k++)
    all = all && (w->x[w->room.index[k]] == 0 || acts(w, w->room.index[k]));
  if (all) return 1;
  nsdae_islands_find(w->n, w->problem->A, w->problem->lda, label);
  memset(pushed, 0, (size_t)w->n * sizeof *pushed);
  for (int i = 0; i < w->n; i++) pushed[label[i]] |= w->problem->b[i] < 0;
  for (int k = 0; k < size; k++)
    if (w->x[w->room.index[k]] > 0 && !pushed[label[w->room.index[k]]]) return 0;
  return 1;
}

/* ---- the guess */

int nsdae_lcp_guess_basis(nsdae_lcp_work *w)
{
  const nsdae_lcp_problem *p = w->problem;
  int stages = w->options->stages;
  if (!(stages & NSDAE_LCP_WARM)) return 0;
  int size = nsdae_lcp_gather(w->n, p->A, p->lda, w->basis, w->room.lu, w->room.index);
  if (size == 0 || nsdae_la_lu(size, w->room.lu, size, w->room.pivot) != 0) return 0;
  double residual = solve_active_set(w, size);
  if (!(residual <= w->options->tol) || !are_sound(w, size)) return 0;
  residual = fmax(residual, sensitivity(w, size) / NSDAE_LCP_FAR);
  if (!(residual <= w->options->tol)) return 0;
  if ((stages & NSDAE_LCP_TRIVIAL) && !is_pushed(w, size)) return 0;
  return accept(w, NSDAE_LCP_WARM, residual);
}
