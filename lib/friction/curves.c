#include "curves.h"

#include <math.h>
#include <string.h>

#include "further.h"

/* Curves from one place and another; steps of one of them for each item: what has not ended then
 * goes back and forth, as where there is no solution. */
enum { CURVES = 12 };
static const double PIECES = 2000;

/* log(epsilon) of the first place along a curve from which Newton's method may get to the end, and
 * of where folds are behind, as a rule; of an anchored one the same, which has fewer of them and
 * keeps its compliance for longer. */
static const double FIRST_LEAP = -3, STRAIGHT = -13.8, LATE_LEAP = -10.5, LATE_STRAIGHT = -16;

/* Newton steps of one attempt. */
enum { ATTEMPT = 150 };

/* Of anchored curves: steps of one; how often one may begin where the one before ended, and by how
 * much the residual has to be less there; what is left of the compliance then. */
enum { ANCHORED = 5000, AGAIN = 12 };
static const double FALLEN = 0.7, SOFTER = 0.3;

/* Nearer to a solution they begin further down, but not where paths of convex problems end. */
static const double NEAREST = 0.03;

/* Newton's method from the point at hand, which stays as it is where that leads nowhere. */
static int leap(nsdae_fc_chain *c)
{
  nsdae_fc_newton *s = &c->newton;
  double *here = c->anderson.before;
  const int most = s->most;
  memcpy(here, c->fc.r, nsdae_fc_bytes(c));
  if (s->steps + ATTEMPT < most) s->most = s->steps + ATTEMPT;
  nsdae_fc_proximal(s, 1e-4, c->tol);
  s->most = most;
  if (nsdae_fc_judge(c, NSDAE_FRICTION_FURTHER) || nsdae_fc_arrived(c)) return 1;
  memcpy(c->fc.r, here, nsdae_fc_bytes(c));
  nsdae_fc_velocities(&c->fc, c->fc.r, c->fc.y, c->fc.u);
  return 0;
}

/* Along the curve, with Newton's method from every place where epsilon has shrunk by a factor, and
 * from its end; on: whether it is at one of its points still. */
static int go_along(nsdae_fc_chain *c, double first, double straight, int *on)
{
  nsdae_fc_newton *s = &c->newton;
  nsdae_fc_curve *curve = &c->curve;
  int found = 0;
  for (double to = first; *on && !found && curve->l > straight; to = fmin(to, curve->l) - 1) {
    *on = nsdae_fc_curve_follow(curve, s, to);
    found = *on && leap(c);
  }
  if (!*on || found) return found;
  nsdae_fc_curve_descend(curve, s, c->tol);
  return nsdae_fc_judge(c, NSDAE_FRICTION_FURTHER) || nsdae_fc_arrived(c);
}

/* Counts the steps of a curve, and goes on from where it ended. */
static int finish(nsdae_fc_chain *c, int found)
{
  if (nsdae_fc_count(c, NSDAE_FRICTION_FURTHER) || found || nsdae_fc_arrived(c)) return 1;
  return c->options->max_iterations == 0 && nsdae_fc_creep_on(c);
}

/* One curve; where it is lost it may have passed the last fold, too. */
static int along(nsdae_fc_chain *c, double stiffness, int number)
{
  int on = nsdae_fc_curve_begin(&c->curve, &c->newton, stiffness, number);
  int found = go_along(c, FIRST_LEAP, STRAIGHT, &on) || (on && leap(c));
  return finish(c, found);
}

int nsdae_fc_curves(nsdae_fc_chain *c, double each, double all)
{
  static const double stiffness[] = {0.1, 0.02, 1, 0.1, 0.3, 0.05};
  const int before = c->seen.spent;
  for (int k = 0; k < CURVES; k++) {
    int left = (int)(all / c->fc.n) - (c->seen.spent - before);
    if (left <= 0 || (k > 0 && c->info.residual <= NSDAE_FC_NEARLY) || !nsdae_fc_ready(c)) return 0;
    if (c->options->max_iterations == 0)
      c->newton.most = (int)fmin(fmin(each / c->fc.n, PIECES * c->fc.n), left);
    if (along(c, stiffness[k % 6], k < 3 ? 0 : k)) return 1;
  }
  return 0;
}

int nsdae_fc_anchored_curves(nsdae_fc_chain *c, int number, double usual)
{
  static const double epsilon[] = {1e-3, 1e-3, 3e-3}, first[] = {0.01, 0.1, 0.03};
  double before, residual = nsdae_fc_residual(&c->fc, c->fc.r, c->fc.u);
  const double near = residual < usual ? fmax(NEAREST, residual / usual) : 1;
  double compliance = near * first[number % 3];
  for (int k = 0; k < AGAIN; k++, compliance *= SOFTER) {
    if (!nsdae_fc_ready(c)) return 0;
    c->newton.most = ANCHORED;
    int on = nsdae_fc_curve_anchor(&c->curve, &c->newton, near * epsilon[number % 3], compliance);
    int found = go_along(c, LATE_LEAP, LATE_STRAIGHT, &on);
    before = residual;
    residual = nsdae_fc_residual(&c->fc, c->fc.r, c->fc.u);
    if (!on) return nsdae_fc_count(c, NSDAE_FRICTION_FURTHER) || nsdae_fc_arrived(c);
    if (finish(c, found || leap(c))) return 1;
    if (!(residual < FALLEN * before)) return 0;
  }
  return 0;
}
