/* Near a solution where items are locked in one another kinks are everywhere, and proximal points
 * creep from each to the next. Of all r with much the same u an interior point takes the middle
 * one, far from kinks: from there Newton's method gets to the solution, or to a better shift. */
#include "middle.h"

#include <math.h>
#include <string.h>

#include "further.h"

/* Convex problems at most, and of them those in a row whose shift is not off by less by a factor,
 * after which they are given up. */
enum { MIDDLES = 100, FRUITLESS = 12 };
static const double FRUIT = 0.7;

/* Newton's method is tried where the shift is off by so much less than where it was tried before;
 * its steps. */
enum { FROM_MIDDLE = 150 };
static const double NEARER = 0.5;

/* As near as that they lead to a solution. */
static const double MIDWAY = 1e-4;

/* The solution of the convex problem; 0: not found. */
static int to_the_middle(nsdae_fc_chain *c)
{
  if (!nsdae_fc_ready(c)) return 0;
  int found = nsdae_fc_interior_run(&c->interior, &c->newton);
  return nsdae_fc_count(c, NSDAE_FRICTION_FURTHER) || found;
}

static int try_newton(nsdae_fc_chain *c)
{
  if (!nsdae_fc_ready(c)) return 0;
  c->newton.most = FROM_MIDDLE;
  nsdae_fc_proximal(&c->newton, 1e-8, c->tol);
  return nsdae_fc_count(c, NSDAE_FRICTION_FURTHER) || nsdae_fc_arrived(c);
}

/* By how much the shift is off at fc->u. */
static double off(const nsdae_fc_chain *c)
{
  double square = 0;
  for (int k = 0; k < c->fc.n; k++) {
    double by = nsdae_fc_slip(&c->fc, k) - c->interior.shift[k];
    square += by * by;
  }
  return sqrt(square);
}

/* The next shift, by what the last few were off: where items stay as they are it is affine in the
 * one before. It takes the rows of normal impulses for the time. */
static void extrapolate(nsdae_fc_chain *c)
{
  nsdae_fc_anderson *s = &c->walked.shifts;
  memset(s->before, 0, nsdae_fc_bytes(c));
  memset(c->fc.r, 0, nsdae_fc_bytes(c));
  for (int k = 0; k < c->fc.n; k++) {
    s->before[3 * k] = c->interior.shift[k];
    c->fc.r[3 * k] = nsdae_fc_slip(&c->fc, k);
  }
  nsdae_fc_anderson_extrapolate(s, &c->fc);
  for (int k = 0; k < c->fc.n; k++) c->interior.shift[k] = fmax(0, c->fc.r[3 * k]);
}

/* Back to where the interior point ended. */
static void return_to_middle(nsdae_fc_chain *c)
{
  memcpy(c->fc.r, c->interior.middle, nsdae_fc_bytes(c));
  nsdae_fc_velocities(&c->fc, c->fc.r, c->fc.y, c->fc.u);
}

static int through_the_middle(nsdae_fc_chain *c)
{
  double least = INFINITY, tried = INFINITY;
  nsdae_fc_anderson_begin(&c->walked.shifts);
  nsdae_fc_shift(&c->fc, c->interior.shift);
  for (int k = 0, since = 0; k < MIDDLES && since < FRUITLESS; k++, since++) {
    if (!to_the_middle(c)) return 0;
    if (nsdae_fc_arrived(c)) return 1;
    return_to_middle(c);
    double drift = off(c);
    if (drift < FRUIT * least) least = drift, since = -1;
    if (drift < NEARER * tried) {
      tried = drift;
      if (try_newton(c)) return 1;
    }
    return_to_middle(c);
    extrapolate(c);
    return_to_middle(c);
  }
  return 0;
}

int nsdae_fc_middle_on(nsdae_fc_chain *c)
{
  const double before = c->info.residual;
  if (!c->patient || c->fc.local || c->options->max_iterations > 0) return 0;
  nsdae_fc_velocities(&c->fc, c->fc.r, c->fc.y, c->fc.u);
  if (!(nsdae_fc_residual(&c->fc, c->fc.r, c->fc.u) < MIDWAY)) return 0;
  memcpy(c->interior.held, c->fc.r, nsdae_fc_bytes(c));
  if (through_the_middle(c)) return 1;
  const double *from = c->info.residual < before ? c->best : c->interior.held;
  memcpy(c->fc.r, from, nsdae_fc_bytes(c));
  return 0;
}
