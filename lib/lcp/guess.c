/* Most steps of a simulation end here, so that neither islands are looked for nor rows scaled.
 *
 * With r_i = max(-y_i, 0) where x_i = 0 and |y_i| where x_i > 0,
 *   |min(x_i / sx_i, y_i / sy_i)| <= r_i / s_i,   s_i = |b_i| + sum_j |a_ij x_j| <= sy_i.
 * The right side does not change when rows or columns are scaled, and its sum only runs over the
 * island of i: it bounds the residual of nsdae_dlcpres in every scaling, of the whole and of every
 * island (componentwise backward error, Oettli and Prager, Numer. Math. 6, 1964). It does so as
 * long as the s_i are not larger than b warrants, for which the active block has to be regular. */
#include "guess.h"

#include <float.h>
#include <math.h>
#include <stddef.h>
#include <string.h>

#include "active_set.h"
#include "dense.h"
#include "residual.h"

/* Bounds that a refinement cannot improve on by much, and such that are not for want of one. */
static const double ROUNDING = 2e-15, WRONG = 1e-6;

/* A sum so small against its terms is zero. */
static const double CANCELLED = 8 * DBL_EPSILON;

/* Sizes below this may be what underflow left. */
static const double TINY = DBL_MIN / DBL_EPSILON;

static int accept(nsdae_chain *c, int stage, double residual)
{
  c->info->outcome = NSDAE_LCP_SOLVED;
  c->info->stage = stage;
  c->info->residual = residual;
  for (int i = 0; i < c->n; i++) c->basis[i] = stage == NSDAE_LCP_WARM && c->basis[i];
  return 1;
}

int nsdae_guess_nothing(nsdae_chain *c)
{
  if (!(c->options->stages & NSDAE_LCP_TRIVIAL)) return 0;
  for (int i = 0; i < c->n; i++)
    if (c->problem->b[i] < 0) return 0;
  for (int i = 0; i < c->n; i++) {
    c->x[i] = 0;
    c->y[i] = c->problem->b[i];
  }
  return accept(c, NSDAE_LCP_TRIVIAL, 0);
}

static const double *column_of(const nsdae_chain *c, int j)
{
  return c->problem->A + (size_t)j * (size_t)c->problem->lda;
}

/* The factors of A_BB, B in c->index; returns the size of B, or 0 where there is nothing to solve.
 */
static int factor(nsdae_chain *c)
{
  int size = nsdae_lcp_gather(c->n, c->problem->A, c->problem->lda, c->basis, c->lu, c->index);
  return size > 0 && nsdae_la_lu(size, c->lu, size, c->pivot) == 0 ? size : 0;
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

/* y and s of the head of A x + b; A and b are finite, so that x_j = 0 adds nothing. */
static void multiply(nsdae_chain *c, int size)
{
  for (int i = 0; i < c->n; i++) {
    c->y[i] = c->problem->b[i];
    c->sizes[i] = fabs(c->y[i]);
  }
  for (int j = 0; j < size; j++)
    if (c->x[c->index[j]] > 0)
      add_column(c->n, column_of(c, c->index[j]), c->x[c->index[j]], c->y, c->sizes);
}

/* Whether a row without size has no term at all, rather than one that underflowed. */
static int is_empty(const nsdae_chain *c, int i, int size)
{
  for (int j = 0; j < size; j++)
    if (column_of(c, c->index[j])[i] != 0 && c->x[c->index[j]] > 0) return 0;
  return 1;
}

/* Whether rows of that size say something: neither infinite nor what underflow left. */
static int are_sound(const nsdae_chain *c, int size)
{
  for (int i = 0; i < c->n; i++) {
    double s = c->sizes[i];
    if (!(s >= TINY && s <= DBL_MAX) && !(s == 0 && is_empty(c, i, size))) return 0;
  }
  return 1;
}

/* max_i r_i / s_i; a row without size has r_i = 0, and counts for nothing. */
static double bound(const nsdae_chain *c)
{
  const double *restrict x = c->x, *restrict y = c->y, *restrict s = c->sizes;
  double worst = 0;
  for (int i = 0; i < c->n; i++) {
    double r = (x[i] > 0 ? fabs(y[i]) : -y[i]) / s[i];
    worst = r > worst ? r : worst;
  }
  return worst;
}

/* rhs := A_BB^-1 rhs; what is left of terms that cancel is zero. */
static void divide(nsdae_chain *c, int size)
{
  double *x = c->rhs, *s = c->cover;
  for (int j = 0; j < size; j++) {
    double held = x[j];
    x[j] = x[c->pivot[j] - 1];
    x[c->pivot[j] - 1] = held;
  }
  for (int j = 0; j < size; j++) s[j] = fabs(x[j]);
  for (int j = 0; j < size; j++) {
    const double *column = c->lu + (size_t)j * (size_t)size;
    add_column(size - j - 1, column + j + 1, -x[j], x + j + 1, s + j + 1);
  }
  for (int j = size - 1; j >= 0; j--) {
    const double *column = c->lu + (size_t)j * (size_t)size;
    x[j] = fabs(x[j]) > CANCELLED * s[j] ? x[j] / column[j] : 0;
    add_column(j, column, -x[j], x, s);
  }
}

/* x with the active set of that size, refined once where that is of use; what is zero at first
 * stays so. Returns its bound. */
static double solve(nsdae_chain *c, int size)
{
  double error = WRONG;
  memset(c->x, 0, (size_t)c->n * sizeof *c->x);
  memcpy(c->y, c->problem->b, (size_t)c->n * sizeof *c->y);
  for (int round = 0; round < 2 && error > ROUNDING && error <= WRONG; round++) {
    for (int j = 0; j < size; j++) c->rhs[j] = -c->y[c->index[j]];
    divide(c, size);
    for (int j = 0; j < size; j++) {
      double *x = c->x + c->index[j], sum = *x + c->rhs[j];
      if (round == 0 || *x > 0) *x = sum > 0 ? sum : 0;
    }
    multiply(c, size);
    error = bound(c);
  }
  return error;
}

/* The largest share of itself by which an x_j > 0 changes where the rows of the head change by
 * their rounding, in irregular parts of it, so that no symmetry cancels them. */
static double sensitivity(nsdae_chain *c, int size)
{
  double worst = 0, part = 0;
  for (int j = 0; j < size; j++) {
    part += part < 0.5 ? 0.6180339887498949 : -0.3819660112501051;
    c->rhs[j] = (j % 2 ? part : -part) * DBL_EPSILON * c->sizes[c->index[j]];
  }
  divide(c, size);
  for (int j = 0; j < size; j++) {
    double x = c->x[c->index[j]], change = fabs(c->rhs[j]);
    if (!isfinite(change)) return INFINITY;
    if (x > 0 && change > worst * x) worst = change / x;
  }
  return worst;
}

/* Whether the column of x_j has an entry in a row that is reached. */
static int is_reached(const nsdae_chain *c, int j)
{
  const double *column = column_of(c, j);
  for (int i = 0; i < c->n && !c->trial[j]; i++)
    if (c->trial[i] && column[i] != 0) return 1;
  return c->trial[j];
}

static void spread(const nsdae_chain *c, int j)
{
  const double *column = column_of(c, j);
  for (int i = 0; i < c->n; i++) c->trial[i] |= i == j || column[i] != 0;
}

/* How many x_j > 0 are not reached; from those that are it goes on to the rows of their columns. */
static int count_left(const nsdae_chain *c, int size, int goes_on)
{
  int left = 0;
  for (int k = 0; k < size; k++) {
    int j = c->index[k], reached = c->x[j] == 0 || is_reached(c, j);
    left += !reached;
    if (reached && goes_on && c->x[j] > 0) spread(c, j);
  }
  return left;
}

/* Whether every x_j > 0 has a b_i < 0 on its island, as far as the columns of such x_j lead. On an
 * island with b >= 0 the chain takes x = 0, and so must do who solves all islands as one. */
static int is_pushed(const nsdae_chain *c, int size)
{
  for (int i = 0; i < c->n; i++) c->trial[i] = c->problem->b[i] < 0;
  int left = count_left(c, size, 0);
  for (int round = 0; round < 3 && left > 0; round++) left = count_left(c, size, 1);
  return left == 0;
}

int nsdae_guess_basis(nsdae_chain *c)
{
  int stages = c->options->stages, size = stages & NSDAE_LCP_WARM ? factor(c) : 0;
  if (size == 0) return 0;
  double residual = solve(c, size);
  if (!(residual <= c->options->tol) || !are_sound(c, size)) return 0;
  residual = fmax(residual, sensitivity(c, size) / NSDAE_LCP_FAR);
  if (!(residual <= c->options->tol)) return 0;
  if ((stages & NSDAE_LCP_TRIVIAL) && !is_pushed(c, size)) return 0;
  return accept(c, NSDAE_LCP_WARM, residual);
}
