/* Homotopy from a smooth neighbour of the natural map to the map itself (Fukushima, Luo, Tseng,
 * SIAM J. Optim. 12 (2002) 436): eigenvalues l of r - u^ go to (l + sqrt(l^2 + 4 e^2)) / 2 in place
 * of max(0, l), |u_T| to sqrt(|u_T|^2 + e^2) - e. Its points have r o u^ = e^2, the central path of
 * an interior point with s = mu |u_T| among the unknowns: no outer iteration over s. e falls from 1
 * to 1e-6, two to five Newton steps each, the faster the fewer were needed; e = 0 is left to
 * semismooth Newton. A call follows one path; the next call follows it ten times as closely. */
#include <math.h>
#include <string.h>

#include "solver_contract.h"

/* Newton steps of one point; five are usual. With 8, 15 and 30 of 40 seeded problems 39 are solved
 * to 1e-8. */
enum { INNER = 15 };

/* Distance from the path relative to e, of the first path; each path that is lost is followed again
 * at a tenth, at most this number of times. With 1e-2, 1e-3 and 1e-4 40, 39 and 40 of the 40 are
 * solved; with 1, 3 and 6 times 39. */
static const double LOOSE = 1e-3;
enum { TIGHTER = 3 };

/* Last e: below, rounding decides. With 1e-5, 1e-6 and 1e-7 39 of the 40 are solved. */
static const double LAST = 1e-6;

/* First e: a point of the path has r o u^ = e^2, and Newton's method does not get from zero to
 * impulses that are larger by far than e, as those of unlike masses are. */
static const double FIRST[] = {1, 1e3, 1e6};

/* Newton steps until the map is small for this e; their number, 0 if there was none. */
static int correct(nsdae_fc_island *s, nsdae_fc_iterate *it, const nsdae_fc_budget *b, double loose)
{
  nsdae_fc_newton *newton = &s->newton;
  memcpy(newton->centre, s->fc.r, nsdae_fc_bytes(s));
  double now = nsdae_fc_newton_map(newton, s->fc.r, s->fc.u, 0);
  double goal = loose * s->fc.n * newton->epsilon * newton->epsilon;
  int steps = 0;
  do {
    if (!nsdae_fc_spend_step(s, it, b)) return 0;
    now = nsdae_fc_newton_step(newton, now);
    steps++;
  } while (now > goal && steps < INNER);
  return isnan(now) ? 0 : steps;
}

/* Along the path to its end; returns the residual there. */
static double follow(nsdae_fc_island *s, nsdae_fc_iterate *it, const nsdae_fc_budget *b,
                     double loose)
{
  double shrink = 0.3, residual = INFINITY;
  int steps = INNER;
  s->newton.alpha = NSDAE_FC_REGULAR;
  s->newton.search = 1;
  for (size_t k = 0; k < sizeof FIRST / sizeof *FIRST && steps == INNER; k++) {
    memset(s->fc.r, 0, nsdae_fc_bytes(s)); /* the first point, from r = 0 */
    nsdae_fc_set_point(s, s->fc.r);
    s->newton.epsilon = FIRST[k];
    steps = correct(s, it, b, loose);
  }
  while (steps > 0) {
    residual = nsdae_fc_offer(s, it);
    if (residual <= b->tol) break;
    if (steps <= 2) shrink = fmax(0.6 * shrink, 0.03);
    if (steps >= 5) shrink = fmin(1.5 * shrink, 0.7);
    if (!(s->newton.epsilon * shrink > LAST)) break;
    s->newton.epsilon *= shrink;
    steps = correct(s, it, b, loose);
  }
  return residual;
}

int nsdae_fc_smoothing_homotopy(nsdae_fc_island *s, nsdae_fc_iterate *it, const nsdae_fc_budget *b)
{
  if (!nsdae_fc_system_ready(s)) return NSDAE_FC_NO_MEMORY;
  if (s->lost_paths > TIGHTER) return it->residual <= b->tol;
  double end = follow(s, it, b, LOOSE * pow(0.1, s->lost_paths));
  if (end <= b->tol || (end < NSDAE_FC_NEAR && nsdae_fc_proximal_points(s, it, b) <= b->tol))
    return 1;
  if (nsdae_fc_spend(s, it, b, 0)) s->lost_paths++;
  return it->residual <= b->tol;
}
