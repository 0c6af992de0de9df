/* Smoothed maps whose epsilon goes to zero (continuation: Fukushima, Luo, Tseng, SIAM J. Optim. 12
 * (2002) 436; of interior points with the shift mu |u_T| the same path): the equations hold the
 * shift, so that there is no iteration over it, and where there are more impulses than freedoms the
 * path goes through the middle of the solutions. Two to five steps for each epsilon, which shrinks
 * the faster the fewer were needed. */
#include <math.h>
#include <string.h>

#include "newton.h"

enum { INNER = 15 };

static const double LEAST = 1e-6, TINY = 1e-13; /* below, rounding rules; TINY: regular matrices */

double nsdae_fc_path(nsdae_fc_newton *s, double loose, double tol)
{
  nsdae_fc *c = s->fc;
  double shrink = 0.3, now;
  s->alpha = TINY;
  s->search = 1;
  nsdae_fc_velocities(c, c->r, c->y, c->u);
  double residual = nsdae_fc_residual(c, c->r, c->u);
  for (s->epsilon = 1; s->epsilon > LEAST && !(residual <= tol); s->epsilon *= shrink) {
    int steps = 0;
    memcpy(s->centre, c->r, 3 * (size_t)c->n * sizeof *c->r);
    now = nsdae_fc_newton_map(s, c->r, c->u, 0);
    do {
      if (s->steps >= s->most) return residual;
      now = nsdae_fc_newton_step(s, now);
      steps++;
    } while (now > loose * c->n * s->epsilon * s->epsilon && steps < INNER);
    if (now != now) break;
    residual = nsdae_fc_residual(c, c->r, c->u);
    if (steps <= 2) shrink = fmax(0.6 * shrink, 0.03);
    if (steps >= 5) shrink = fmin(1.5 * shrink, 0.7);
  }
  return residual;
}
