/* Fixed point on s = mu |u_T| (Acary, Cadoux, Lemarechal, Malick, ZAMM 91 (2011) 155; De Saxce and
 * Feng 1998): with s fixed the problem is a convex second-order cone problem, whose solution by an
 * interior point has the next s. Steps of s are extrapolated by Anderson's method. Each time the
 * residual has fallen, semismooth Newton is tried. */
#include <math.h>
#include <string.h>

#include "solver_contract.h"

/* Progress is a reduction by this factor: of the error of s, which FRUITLESS convex problems in a
 * row may lack, and of the residual since Newton's method was tried last. With 0.5, 0.7 and 0.85 of
 * 40 seeded problems 39 are solved to 1e-8; with 6, 12 and 24 in a row 39, 39 and 40. */
static const double PROGRESS = 0.7;
enum { FRUITLESS = 12 };

int nsdae_fc_aclm(nsdae_fc_island *s, nsdae_fc_iterate *it, const nsdae_fc_budget *b)
{
  double tried = INFINITY, least = INFINITY;
  if (!nsdae_fc_system_ready(s)) return NSDAE_FC_NO_MEMORY;
  nsdae_fc_socp_begin(s, it);
  nsdae_fc_anderson_begin(&s->anderson);
  for (int since = 0; since < FRUITLESS && nsdae_fc_socp_run(s, it, b); since++) {
    double residual = nsdae_fc_offer(s, it), error = 0;
    if (residual <= b->tol) return 1;
    for (int k = 0; k < s->fc.n; k++) {
      double by = nsdae_fc_s_of(&s->fc, k) - s->socp.s[k];
      error += by * by;
    }
    error = sqrt(error); /* |mu |u_T| - s| */
    if (error < PROGRESS * least) least = error, since = -1;
    if (residual < PROGRESS * tried) {
      tried = residual;
      if (nsdae_fc_proximal_points(s, it, b) <= b->tol) return 1;
      nsdae_fc_set_point(s, s->socp.end);
    }
    /* The next s, extrapolated; the rows of normal impulses take its place for the time. Back at
     * the solution of the convex problem then. */
    memset(s->anderson.before, 0, nsdae_fc_bytes(s));
    memset(s->fc.r, 0, nsdae_fc_bytes(s));
    for (int k = 0; k < s->fc.n; k++) {
      s->anderson.before[3 * k] = s->socp.s[k];
      s->fc.r[3 * k] = nsdae_fc_s_of(&s->fc, k);
    }
    nsdae_fc_anderson_collect(&s->anderson, &s->fc);
    nsdae_fc_anderson_extrapolate(&s->anderson, &s->fc);
    for (int k = 0; k < s->fc.n; k++) s->socp.s[k] = fmax(0, s->fc.r[3 * k]);
    nsdae_fc_set_point(s, s->socp.end);
  }
  return it->residual <= b->tol;
}
