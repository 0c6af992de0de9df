/* On a secondary ray the variables grow along a direction (x, z0, y) >= 0, x not zero, with
 *
 *   y = A x + d z0,   x_i y_i = 0
 *
 * (Cottle, Pang, Stone, "The Linear Complementarity Problem", 1992, theorem 4.4.1), so that (A x)_i
 * = -d_i z0 wherever x_i > 0. Where z0 > 0 that is negative: then x^T A x < 0, and A is neither
 * copositive nor semimonotone. Where z0 = 0, x^T A x = 0 and A is not strictly so. The basis names
 * the x_i that grow, but for the pair that has no part in it: every pair is tried for it, and what
 * comes out is checked on its own, in exact arithmetic. */
#include "ray.h"

#include <math.h>
#include <stddef.h>
#include <string.h>

#include "dense.h"
#include "exact.h"

/* Rows index[0 .. size] of the columns index[0 .. size - 1] of A and of d = 1, factored. */
static int factor(nsdae_chain *c, int size)
{
  size_t order = (size_t)size + 1;
  for (size_t j = 0; j <= (size_t)size; j++)
    for (size_t i = 0; i < order; i++)
      c->lu[j * order + i] =
          j == (size_t)size ? 1 : c->A[(size_t)c->index[j] * (size_t)c->n + (size_t)c->index[i]];
  return nsdae_la_lu(size + 1, c->lu, size + 1, c->pivot);
}

/* The direction, to the problem's own scale, in c->cover: index[size] is the pair out of the basis,
 * of which x (or y) grows at the rate one. */
static void direction(nsdae_chain *c, int size, int of_x)
{
  int k = c->index[size];
  for (int i = 0; i <= size; i++) {
    const double *column = c->A + (size_t)k * (size_t)c->n;
    c->rhs[i] = of_x ? -column[c->index[i]] : i == size;
  }
  nsdae_la_lu_solve(size + 1, c->lu, size + 1, c->pivot, c->rhs);
  memset(c->cover, 0, (size_t)c->n * sizeof *c->cover);
  for (int i = 0; i < size; i++) c->cover[c->index[i]] = c->rhs[i] * c->column[c->index[i]];
  if (of_x) c->cover[k] = c->column[k];
}

/* What x proves: x >= 0, not zero, and where it is positive A x is negative, or not positive. */
static int proves(const nsdae_chain *c, const double *x)
{
  const nsdae_lcp_problem *p = c->problem;
  int any = 0, proof = NSDAE_LCP_RAY_NOT_COPOSITIVE;
  for (int i = 0; i < c->n; i++) {
    if (!(x[i] >= 0 && isfinite(x[i]))) return NSDAE_LCP_RAY_NOTHING;
    if (x[i] == 0) continue;
    int sign = nsdae_exact_sign(c->n, p->A + i, p->lda, x);
    if (sign > 0) return NSDAE_LCP_RAY_NOTHING;
    if (sign == 0) proof = NSDAE_LCP_RAY_NOT_STRICTLY_COPOSITIVE;
    any = 1;
  }
  return any ? proof : NSDAE_LCP_RAY_NOTHING;
}

/* Small negative entries are rounding: the point with zeros for them is a candidate as good. */
static void clip(int n, double *x)
{
  double most = 0;
  for (int i = 0; i < n; i++) most = fmax(most, x[i]);
  for (int i = 0; i < n; i++)
    if (fabs(x[i]) < 1e-12 * most) x[i] = 0;
}

void nsdae_chain_read_ray(nsdae_chain *c)
{
  int size = 0;
  for (int i = 0; i < c->n; i++)
    if (c->trial[i]) c->index[size++] = i;
  if (c->n > NSDAE_RAY_MAX || size == c->n) return;
  for (int k = 0; k < c->n; k++) {
    if (c->trial[k]) continue;
    c->index[size] = k;
    if (factor(c, size) != 0) continue;
    for (int of_x = 0; of_x < 2; of_x++) {
      direction(c, size, of_x);
      clip(c->n, c->cover);
      int proof = proves(c, c->cover);
      if (proof == NSDAE_LCP_RAY_NOTHING) continue;
      c->info->ray = proof;
      if (proof == NSDAE_LCP_RAY_NOT_COPOSITIVE) return;
    }
  }
}
