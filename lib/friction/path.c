/* Smoothed maps whose epsilon goes to zero (continuation: Fukushima, Luo, Tseng, SIAM J. Optim. 12
 * (2002) 436; of interior points with the shift mu |u_T| the same path): the equations hold the
 * shift, so that there is no iteration over it, and where there are more impulses than freedoms the
 * path goes through the middle of the solutions. Two to five steps for each epsilon, which shrinks
 * the faster the fewer were needed. */
#include <math.h>
#include <string.h>

#include "newton.h"

enum { INNER = 15 };

/* Where the path of a problem much like the one before begins: further down (DOWN, LOWEST) where it
 * was found in few steps there, further up (UP, HIGHEST) where it was not. Shifts that go far
 * change more of it, and so do masses unlike each other. */
enum { QUICK = 5 };
static const double DOWN = 0.5, LOWEST = 1e-3, UP = 10, HIGHEST = 1e3;

/* What is left of epsilon after the shortest of steps. */
static const double SHORTEST = 0.85;

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
  if (steps == 0 || steps >= INNER) {
    s->mark_at = fmin(UP * s->mark_at, HIGHEST);
    return 0;
  }
  if (steps <= QUICK) s->mark_at = fmax(DOWN * s->mark_at, LOWEST);
  return steps;
}

static void mark(nsdae_fc_newton *s)
{
  nsdae_fc *c = s->fc;
  if (s->mark_epsilon > 0 || s->epsilon > s->mark_at) return;
  memcpy(s->mark, c->r, 3 * (size_t)c->n * sizeof *c->r);
  s->mark_epsilon = s->epsilon;
}

/* The next point of a path, epsilon shrunk; its steps, 0 where there was none. The path of a convex
 * problem has no folds, and what has not been found again of it is lost: back to where it was, and
 * with shorter steps. */
static int go_down(nsdae_fc_newton *s, double loose, double *shrink)
{
  nsdae_fc *c = s->fc;
  const double from = s->epsilon;
  if (s->shift) memcpy(s->best, c->r, 3 * (size_t)c->n * sizeof *c->r);
  for (; *shrink < SHORTEST && from * *shrink > LEAST; *shrink = sqrt(*shrink)) {
    s->epsilon = from * *shrink;
    int steps = settle(s, loose);
    if (!s->shift || (steps > 0 && steps < INNER)) return steps;
    memcpy(c->r, s->best, 3 * (size_t)c->n * sizeof *c->r);
    nsdae_fc_velocities(c, c->r, c->y, c->u);
    if (s->steps >= s->most) return 0;
  }
  return 0;
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
    steps = go_down(s, loose, &shrink);
    if (steps > 0) residual = nsdae_fc_residual(c, c->r, c->u);
  }
  return residual;
}
