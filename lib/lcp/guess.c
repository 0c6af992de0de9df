/* Most steps of a simulation end here, so that neither islands are looked for nor rows scaled.
 *
 * With r_i = max(-y_i, 0) where x_i = 0 and |y_i| where x_i > 0,
 *   |min(x_i / sx_i, y_i / sy_i)| <= r_i / s_i,   s_i = |b_i| + sum_j |a_ij x_j| <= sy_i.
 * The right side does not change when rows or columns are scaled, and its sum only runs over the
 * island of i: it bounds the residual of nsdae_dlcpres in every scaling, of the whole and of every
 * island (componentwise backward error, Oettli and Prager, Numer. Math. 6, 1964). Where x_i should
 * be zero and is rounding, s_i may be no more than that; then the part of sy_i that comes from the
 * largest b of the island is added, which takes islands and even rows after all. */
#include "guess.h"

#include <float.h>
#include <math.h>
#include <stddef.h>
#include <string.h>

#include "dense.h"
#include "equilibrate.h"

/* Bounds that a refinement cannot improve on by much, and such that are not for want of one. */
static const double ROUNDING = 2e-15, WRONG = 1e-6;

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
  int size = 0;
  double *lu = c->lu;
  for (int i = 0; i < c->n; i++)
    if (c->basis[i]) c->index[size++] = i;
  for (int j = 0; j < size; j++) {
    const double *column = column_of(c, c->index[j]);
    for (int i = 0; i < size; i++) *lu++ = column[c->index[i]];
  }
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

/* max_i r_i / (s_i + 1e-3 largest_i); a row without size has r_i = 0, and counts for nothing. */
static double bound(const nsdae_chain *c, const double *restrict largest)
{
  const double *restrict x = c->x, *restrict y = c->y, *restrict s = c->sizes;
  double worst = 0;
  for (int i = 0; i < c->n; i++) {
    double r = (x[i] > 0 ? fabs(y[i]) : -y[i]) / (s[i] + 1e-3 * largest[i]);
    worst = r > worst ? r : worst;
  }
  return worst;
}

/* Adds what solves A_BB x_B = -y_B to x. */
static void correct(nsdae_chain *c, int size)
{
  for (int j = 0; j < size; j++) c->rhs[j] = -c->y[c->index[j]];
  nsdae_la_lu_solve(size, c->lu, size, c->pivot, c->rhs);
  for (int j = 0; j < size; j++) {
    double x = c->x[c->index[j]] + c->rhs[j];
    c->x[c->index[j]] = x > 0 ? x : 0;
  }
}

/* Whether every x_i > 0 has a b_k < 0 beside it. On an island with b >= 0 the chain takes x = 0,
 * and so must do who solves all islands as one. */
static int is_pushed(const nsdae_chain *c, int size)
{
  const double *b = c->problem->b;
  for (int j = 0; j < size; j++) {
    const double *column = column_of(c, c->index[j]);
    int k = 0, i = c->index[j];
    if (c->x[i] == 0 || b[i] < 0) continue;
    while (k < c->n && (b[k] >= 0 || column[k] == 0)) k++;
    if (k == c->n) return 0;
  }
  return 1;
}

/* The same by islands; largest_i becomes the largest |b_k| of the island of i. */
static int is_island_pushed(nsdae_chain *c)
{
  int *pushed = c->trial, all = 1;
  const int *label = c->label;
  double *largest = c->cover;
  nsdae_chain_find_islands(c);
  for (int i = 0; i < c->n; i++) largest[i] = pushed[i] = 0;
  for (int i = 0; i < c->n; i++) {
    double b = c->problem->b[i], most = largest[label[i]];
    largest[label[i]] = fabs(b) > most ? fabs(b) : most;
    pushed[label[i]] |= b < 0;
  }
  for (int i = 0; i < c->n; i++) {
    largest[i] = largest[label[i]];
    all &= pushed[label[i]] || c->x[i] == 0;
  }
  return all;
}

static void fill(nsdae_chain *c, double value)
{
  for (int i = 0; i < c->n; i++) c->cover[i] = value;
}

static double largest_b(const nsdae_chain *c)
{
  double most = 0;
  for (int i = 0; i < c->n; i++)
    most = fabs(c->problem->b[i]) > most ? fabs(c->problem->b[i]) : most;
  return most;
}

/* x with the active set of that size, refined once where that is of use. Returns the bound with
 * nothing for the largest b, or where that is of no use with the largest of all. */
static double solve(nsdae_chain *c, int size, double *strict)
{
  double error = WRONG;
  memset(c->x, 0, (size_t)c->n * sizeof *c->x);
  memcpy(c->y, c->problem->b, (size_t)c->n * sizeof *c->y);
  for (int round = 0; round < 2 && error > ROUNDING && error <= WRONG; round++) {
    correct(c, size);
    multiply(c, size);
    fill(c, 0);
    error = *strict = bound(c, c->cover);
    if (error <= WRONG) continue;
    fill(c, largest_b(c));
    error = bound(c, c->cover);
  }
  return error;
}

int nsdae_guess_basis(nsdae_chain *c)
{
  double strict, tol = c->options->tol;
  int size = c->options->stages & NSDAE_LCP_WARM ? factor(c) : 0;
  int may_rest = !(c->options->stages & NSDAE_LCP_TRIVIAL);
  if (size == 0 || !(solve(c, size, &strict) <= tol) || !are_sound(c, size)) return 0;
  if (!(strict <= tol && (may_rest || is_pushed(c, size)))) {
    if (!is_island_pushed(c) && !may_rest) return 0;
    if (!(strict <= tol) && nsdae_is_even(c->n, c->problem->A, c->problem->lda, c->point))
      strict = bound(c, c->cover);
  }
  return strict <= tol && accept(c, NSDAE_LCP_WARM, strict);
}
