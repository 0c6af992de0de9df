/* The proximal point method (Rockafellar, SIAM J. Control Optim. 14 (1976) 877) replaces u by
 * u + alpha (r - z), and z by the solution of that, with alpha -> 0. Where there are more impulses
 * than freedoms each of these problems has one solution near z nevertheless; it is solved by
 * Newton's method on the natural map (semismooth: Qi and Sun, Math. Program. 58 (1993) 353), with
 * whole steps: each is a choice of which items are open, stick and slide, and the next one mends
 * it, where a line search stands still at the first kink. */
#include <math.h>
#include <string.h>

#include "newton.h"

/* Steps of one problem, and of one of those that creep; how often alpha is held then at most. */
enum { INNER = 30, SMALL_INNER = 8, HELD = 60 };

/* A problem counts as solved where its map has lost this factor, squared. */
static const double GAIN = 1e-4;

/* A proximal term that leaves of an error in the velocities as good as nothing, and keeps the
 * matrix from what rounding makes of a singular one. */
static const double SLIGHT = 1e-10;

static void velocities(nsdae_fc *c)
{
  nsdae_fc_velocities(c, c->r, c->y, c->u);
}

/* Solves with the centre at fc->r, or leaves that; returns the steps, 0 where it failed. */
static int solve(nsdae_fc_newton *s, int inner, double tol)
{
  nsdae_fc *c = s->fc;
  size_t bytes = 3 * (size_t)c->n * sizeof *c->r;
  memcpy(s->centre, c->r, bytes);
  double start = nsdae_fc_newton_map(s, c->r, c->u, 0), now = start;
  double goal = fmax(GAIN * start, 1e-2 * tol * tol), most = 1e4 * fmax(start, 1e-3);
  int steps = 0;
  while (now > goal && now <= most && steps < inner && s->steps < s->most) {
    now = nsdae_fc_newton_step(s, now);
    steps++;
  }
  if (now <= goal) return steps;
  memcpy(c->r, s->centre, bytes);
  velocities(c);
  return 0;
}

static void keep(nsdae_fc_newton *s, double residual, double *best)
{
  if (!(residual < *best)) return;
  memcpy(s->best, s->fc->r, 3 * (size_t)s->fc->n * sizeof *s->best);
  *best = residual;
}

static double back_to_best(nsdae_fc_newton *s, double residual, double best)
{
  if (!(best < residual)) return residual;
  memcpy(s->fc->r, s->best, 3 * (size_t)s->fc->n * sizeof *s->best);
  velocities(s->fc);
  return best;
}

double nsdae_fc_proximal(nsdae_fc_newton *s, double alpha, double tol)
{
  nsdae_fc *c = s->fc;
  double factor = 0.1, best = INFINITY;
  int failures = 0;
  s->alpha = alpha;
  s->epsilon = 0;
  s->search = 0;
  velocities(c);
  double residual = nsdae_fc_residual(c, c->r, c->u);
  while (!(residual <= tol) && s->steps < s->most) {
    int steps = solve(s, INNER, tol);
    if (steps == 0) {
      s->alpha *= 10;
      factor = sqrt(factor);
      if (++failures > s->failures || s->alpha > 1e3) break;
      continue;
    }
    double before = residual;
    residual = nsdae_fc_residual(c, c->r, c->u);
    keep(s, residual, &best);
    if (steps <= 5 || residual > 0.3 * before) s->alpha = fmax(s->alpha * factor, 1e-14);
    factor = fmax(factor * factor, 0.1);
  }
  return back_to_best(s, residual, best);
}

double nsdae_fc_creep(nsdae_fc_newton *s, int idle, double tol)
{
  nsdae_fc *c = s->fc;
  double best = INFINITY, half = INFINITY, good = 0;
  int hold = 0, held = 0, since = s->steps;
  s->alpha = 1e-5;
  s->epsilon = 0;
  s->search = 0;
  velocities(c);
  double residual = nsdae_fc_residual(c, c->r, c->u);
  while (!(residual <= tol) && s->steps < s->most && s->steps - since < idle && s->alpha < 1) {
    if (solve(s, SMALL_INNER, tol) == 0) {
      s->alpha = good > s->alpha ? good : 10 * s->alpha;
      good = 0;
      hold = held = 2 * held + 2 < HELD ? 2 * held + 2 : HELD;
      continue;
    }
    good = s->alpha;
    residual = nsdae_fc_residual(c, c->r, c->u);
    keep(s, residual, &best);
    if (best < half) {
      half = best / 2;
      since = s->steps;
    }
    if (hold > 0)
      hold--;
    else
      s->alpha = fmax(s->alpha / 2, 1e-14);
  }
  return back_to_best(s, residual, best);
}

double nsdae_fc_refine(nsdae_fc_newton *s, int steps)
{
  nsdae_fc *c = s->fc;
  size_t bytes = 3 * (size_t)c->n * sizeof *c->r;
  double residual, best;
  s->alpha = SLIGHT;
  s->epsilon = 0;
  s->search = 0;
  velocities(c);
  best = nsdae_fc_residual(c, c->r, c->u);
  memcpy(s->best, c->r, bytes);
  for (int k = 0; k < steps && best > 0; k++) {
    memcpy(s->centre, c->r, bytes);
    if (isnan(nsdae_fc_newton_step(s, INFINITY))) break;
    residual = nsdae_fc_residual(c, c->r, c->u);
    if (!(residual < best)) break;
    best = residual;
    memcpy(s->best, c->r, bytes);
  }
  memcpy(c->r, s->best, bytes);
  velocities(c);
  return best;
}
