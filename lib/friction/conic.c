/* The problem with its shift mu |u_T| fixed is convex: its path has no folds. Its solution says
 * what the next shift is; where that is the same, the problem is solved (De Saxce and Feng 1998;
 * Acary, Cadoux, Lemarechal, Malick 2011: such a fixed point exists). Where little slides few of
 * them are enough, and of bodies that rest the first one is zero. Else they go there slowly, by
 * much the same step each time where bodies gather speed: so steps in the direction of the one
 * before get longer. Newton's method goes on from where the residual has shrunk. Where the shift
 * does not settle, as of impacts that make walls of blocks slide, it wanders near solutions, none
 * of which keeps it: curves that begin there lead to one. */
#include "conic.h"

#include <math.h>
#include <string.h>

#include "cone.h"
#include "curves.h"
#include "further.h"

/* Newton's method is tried at the first shifts, and then where the residual is so much smaller than
 * where it was tried before; its steps. */
enum { FIRST = 3, ATTEMPT = 150 };
static const double SHRUNK = 0.7;

/* Convex problems before the first curve; Newton steps of them between two curves, at least where
 * the residual is no smaller. */
enum { SETTLED = 40, MEANWHILE = 2500 };

/* A step is along the one before where the cosine between them is above the first of these; then it
 * is longer by the second one, up to the third. */
static const double ALONG = 0.8, STRETCH = 1.5, LONGEST = 4;

/* c->slip to the next shift, stride times as far as mu |u_T|; returns the next stride. */
static double move_shift(nsdae_fc_chain *c, double stride)
{
  double now = 0, before = 0, both = 0;
  for (int k = 0; k < c->fc.n; k++) {
    const double *u = c->fc.u + 3 * k;
    double step = c->fc.items.mu[k] * nsdae_fc_length(u[1], u[2]) - c->slip[k];
    now += step * step;
    before += c->drift[k] * c->drift[k];
    both += step * c->drift[k];
    c->drift[k] = step;
  }
  if (both > ALONG * sqrt(now) * sqrt(before))
    stride = fmin(STRETCH * stride, LONGEST);
  else
    stride = both > 0 ? fmax(1, stride / 2) : 1;
  for (int k = 0; k < c->fc.n; k++) c->slip[k] = fmax(0, c->slip[k] + stride * c->drift[k]);
  return stride;
}

/* The convex problem, from a place of the path of the one before; its velocities are in fc.u. */
static void solve_convex(nsdae_fc_chain *c)
{
  c->newton.shift = c->slip;
  nsdae_fc_path(&c->newton, 1e-3, c->tol);
  c->newton.shift = NULL;
  nsdae_fc_velocities(&c->fc, c->fc.r, c->fc.y, c->fc.u);
}

static int try_newton(nsdae_fc_chain *c, int most, int stage)
{
  if (!nsdae_fc_ready(c)) return 0;
  if (most > 0 && most < c->newton.most) c->newton.most = most;
  nsdae_fc_proximal(&c->newton, 1e-8, c->tol);
  return nsdae_fc_count(c, stage) || nsdae_fc_arrived(c);
}

/* What a run of convex problems has tried. */
typedef struct nsdae_fc_trials {
  double newton, curve; /* residual where Newton's method was tried last, and a curve */
  int number, spent;    /* of the next curve; steps when the last one ended */
} nsdae_fc_trials;

/* A curve where the residual has shrunk, or where shifts have taken as much time as a curve. */
static int try_curve(nsdae_fc_chain *c, nsdae_fc_trials *t, double residual)
{
  if (!(residual < SHRUNK * t->curve) && c->seen.spent - t->spent < MEANWHILE) return 0;
  t->curve = fmin(residual, t->curve);
  int found = nsdae_fc_anchored_curves(c, t->number++);
  t->spent = c->seen.spent;
  return found;
}

/* What goes on from the solution of the convex problem k: Newton's method, and a curve from there,
 * or from where Newton's method ended. */
static int go_on(nsdae_fc_chain *c, nsdae_fc_trials *t, int k, int stage)
{
  const int lost = c->newton.steps >= c->newton.most; /* that was not solved */
  double residual = nsdae_fc_residual(&c->fc, c->fc.r, c->fc.u);
  if (!lost && (k < FIRST || residual < SHRUNK * t->newton)) {
    t->newton = residual;
    if (try_newton(c, k < FIRST ? 0 : ATTEMPT, stage)) return 1;
  }
  const int bounded = c->options->max_sweeps > 0 || c->options->max_iterations > 0;
  return k >= SETTLED && c->patient && !bounded && try_curve(c, t, residual);
}

int nsdae_fc_conic(nsdae_fc_chain *c, int most, double budget, int stage)
{
  nsdae_fc_trials trials = {.newton = INFINITY, .curve = INFINITY};
  double stride = 1;
  const int before = c->seen.spent;
  memset(c->drift, 0, (size_t)c->fc.n * sizeof *c->drift);
  c->newton.mark_epsilon = 0;
  for (int k = 0; k < most && (c->seen.spent - before) * (double)c->fc.n < budget; k++) {
    if (!nsdae_fc_ready(c)) return 0;
    solve_convex(c);
    stride = move_shift(c, stride);
    if (nsdae_fc_count(c, stage) || go_on(c, &trials, k, stage)) return 1;
  }
  return 0;
}
