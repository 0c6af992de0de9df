/* On a secondary ray the variables grow along a direction (x, z0, y) >= 0, x not zero, with
 *
 *   y = A x + d z0,   x_i y_i = 0
 *
 * (Cottle, Pang, Stone, "The Linear Complementarity Problem", 1992, theorem 4.4.1), so that (A x)_i
 * = -d_i z0 wherever x_i > 0. Where z0 > 0 that is negative: then x^T A x < 0, and A is neither
 * copositive nor semimonotone. Where z0 = 0, x^T A x = 0 and A is not strictly so. The basis names
 * the x_i that grow, except the pair that has no part in it: every pair is tried for it, and the
 * result is checked in exact arithmetic. */
#include "proof.h"

#include <math.h>
#include <string.h>

#include "dense.h"
#include "separation.h"

/* The direction, to the problem's own scale, in w->room.cover: index[size] is the pair out of the
 * basis, of which x (or y) grows at the rate one. */
static void direction(nsdae_lcp_work *w, int size, int of_x)
{
  int k = w->room.index[size];
  for (int i = 0; i <= size; i++) {
    const double *column = w->scaled.A + (size_t)k * (size_t)w->n;
    w->room.rhs[i] = of_x ? -column[w->room.index[i]] : i == size;
  }
  nsdae_la_lu_solve(size + 1, w->room.lu, size + 1, w->room.pivot, w->room.rhs);
  memset(w->room.cover, 0, (size_t)w->n * sizeof *w->room.cover);
  for (int i = 0; i < size; i++)
    w->room.cover[w->room.index[i]] = w->room.rhs[i] * w->scaled.column[w->room.index[i]];
  if (of_x) w->room.cover[k] = w->scaled.column[k];
}

/* What x proves: x >= 0, not zero, and where it is positive A x is negative, or not positive. */
static int proves(const nsdae_lcp_work *w, const double *x)
{
  const nsdae_lcp_problem *p = w->problem;
  int any = 0, proof = NSDAE_LCP_RAY_NOT_COPOSITIVE;
  for (int i = 0; i < w->n; i++) {
    if (!(x[i] >= 0 && isfinite(x[i]))) return NSDAE_LCP_RAY_NOTHING;
    if (x[i] == 0) continue;
    int sign = nsdae_exact_sign(w->n, p->A + i, p->lda, x);
    if (sign > 0) return NSDAE_LCP_RAY_NOTHING;
    if (sign == 0) proof = NSDAE_LCP_RAY_NOT_STRICTLY_COPOSITIVE;
    any = 1;
  }
  return any ? proof : NSDAE_LCP_RAY_NOTHING;
}

void nsdae_lcp_read_ray(nsdae_lcp_work *w)
{
  int size = 0;
  for (int i = 0; i < w->n; i++)
    if (w->room.trial[i]) w->room.index[size++] = i;
  if (w->n > NSDAE_RAY_MAX || size == w->n) return;
  for (int k = 0; k < w->n; k++) {
    if (w->room.trial[k]) continue;
    w->room.index[size] = k;
    /* Rows index[0 .. size] of the columns index[0 .. size - 1] of A and of d = 1, factored. */
    double *to = w->room.lu;
    for (int j = 0; j <= size; j++)
      for (int i = 0; i <= size; i++) {
        size_t column = (size_t)w->room.index[j] * (size_t)w->n;
        *to++ = j == size ? 1 : w->scaled.A[column + (size_t)w->room.index[i]];
      }
    if (nsdae_la_lu(size + 1, w->room.lu, size + 1, w->room.pivot) != 0) continue;
    for (int of_x = 0; of_x < 2; of_x++) {
      direction(w, size, of_x);
      /* Small negative entries are rounding: the point with zeros for them is a candidate as good.
       */
      double most = 0;
      for (int i = 0; i < w->n; i++) most = fmax(most, w->room.cover[i]);
      for (int i = 0; i < w->n; i++)
        if (fabs(w->room.cover[i]) < 1e-12 * most) w->room.cover[i] = 0;
      int proof = proves(w, w->room.cover);
      if (proof == NSDAE_LCP_RAY_NOTHING) continue;
      w->info->ray = proof;
      if (proof == NSDAE_LCP_RAY_NOT_COPOSITIVE) return;
    }
  }
}
