/* Smoothed maps whose epsilon goes to zero (continuation: Fukushima, Luo, Tseng, SIAM J. Optim. 12
 * (2002) 436; of interior points with the shift mu |u_T| the same path): the equations hold the
 * shift, so that there is no iteration over it, and where there are more impulses than freedoms the
 * path goes through the middle of the solutions. Two to five steps for each epsilon, which shrinks
 * the faster the fewer were needed. */
#include <math.h>
#include <string.h>

#include "newton.h"

enum { INNER = 15 };

/* Where a path of a problem much like this one may begin. */
static const double MARK = 0.1;

static const double LEAST = 1e-6, TINY = 1e-13; /* below, rounding rules; TINY: regular matrices */

/* Where the path begins: a point of it has r o u^ = epsilon^2, and Newton's method does not get
 * from zero to impulses that are larger by far than epsilon, as those of masses unlike each other
 * are. */
static const double FIRST[] = {1, 1e3, 1e6};

/* Newton steps until the map is small for this epsilon; their number, 0 where there was none. */
static int settle(nsdae_fc_newton *s, double loose)
{
  nsdae_fc *c = s->fc;
  memcpy(s->centre, c->r, 3 * (size_t)c->n * sizeof *c->r);
  double now = nsdae_fc_newton_map(s, c->r, c->u, 0), goal = loose * c->n * s->epsilon * s->epsilon;
  int steps = 0;
  do {
    if (s->steps >= s->most) return 0;
    now = nsdae_fc_newton_step(s, now);
    steps++;
  } while (now > goal && steps < INNER);
  return isnan(now) ? 0 : steps;
}

/* The first point of the path, from r = 0. */
static int begin(nsdae_fc_newton *s, double loose)
{
  nsdae_fc *c = s->fc;
  int steps = INNER;
  for (size_t k = 0; k < sizeof FIRST / sizeof *FIRST && steps == INNER; k++) {
    memset(c->r, 0, 3 * (size_t)c->n * sizeof *c->r);
    nsdae_fc_velocities(c, c->r, c->y, c->u);
    s->epsilon = FIRST[k];
    steps = settle(s, loose);
  }
  return steps;
}

/* The same from a place of the path before, whose problem was much the same. */
static int resume(nsdae_fc_newton *s, double loose)
{
  nsdae_fc *c = s->fc;
  if (!(s->mark_epsilon > 0)) return 0;
  memcpy(c->r, s->mark, 3 * (size_t)c->n * sizeof *c->r);
  nsdae_fc_velocities(c, c->r, c->y, c->u);
  s->epsilon = s->mark_epsilon;
  int steps = settle(s, loose);
  return steps < INNER ? steps : 0;
}

static void mark(nsdae_fc_newton *s)
{
  nsdae_fc *c = s->fc;
  if (s->mark_epsilon > 0 || s->epsilon > MARK) return;
  memcpy(s->mark, c->r, 3 * (size_t)c->n * sizeof *c->r);
  s->mark_epsilon = s->epsilon;
}

double nsdae_fc_path(nsdae_fc_newton *s, double loose, double tol)
{
  nsdae_fc *c = s->fc;
  double shrink = 0.3;
  s->alpha = TINY;
  s->search = 1;
  int steps = resume(s, loose);
  s->mark_epsilon = 0;
  if (steps == 0) steps = begin(s, loose);
  double residual = nsdae_fc_residual(c, c->r, c->u);
  while (steps > 0 && !(residual <= tol)) {
    mark(s);
    if (steps <= 2) shrink = fmax(0.6 * shrink, 0.03);
    if (steps >= 5) shrink = fmin(1.5 * shrink, 0.7);
    s->epsilon *= shrink;
    if (!(s->epsilon > LEAST)) break;
    steps = settle(s, loose);
    if (steps > 0) residual = nsdae_fc_residual(c, c->r, c->u);
  }
  return residual;
}
