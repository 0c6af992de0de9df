/* A step along a ray, as of Lemke's method, for Gauss-Seidel sweeps with Anderson's extrapolation.
 * If few items are locked, each sweep changes r by the same f, along the null space of W over the
 * sticking items, until one of them opens or slides. The extrapolation cannot remove such a part:
 * f - F c, its least-squares residual, is nearly f. W does not see that direction, so that r may
 * follow it to the first change of state of an item (the ratio test). Without it nine steps of a
 * sliding pile take 10 times as long, each from the one before. */
#include <math.h>

#include "anderson.h"
#include "simd.h"
#include "vector.h"

/* Sensitivities below: the work of 108 warm starts of seeded problems, geometric mean. */

/* Least |f - F c|^2 / |f|^2 of a ray. With 0.96 and 0.99 the work is 1.28 and 0.95 times as much,
 * and one is unsolved. */
static const double REMAINING = 0.98;

/* Longest step, in sweeps; the shortest is one. With 150 and 600: 0.94 and 1.09 times. */
static const double LONGEST = 300;

/* Items whose change is less than this share of the largest do not bound the step: their state
 * changes in most sweeps, which correct it. With 0.05 and 0.2: 1.03 and 1.01 times. */
static const double SHARE = 0.1;

/* An item slides if mu^2 r_N^2 - |r_T|^2 is at most this share of mu^2 r_N^2: r is extrapolated,
 * and some sliding items are a little inside the cone. With 1e-5 and 1e-7: 1.03 and 1.02 times. */
static const double SLIDES = 1e-6;

/* Largest change of item k along d, in the units of the residual. */
static double change(const nsdae_fc_scaled *c, int k, const double *d)
{
  const double normal = fabs(d[3 * k]), a = fabs(d[3 * k + 1]), b = fabs(d[3 * k + 2]);
  return c->items.weight[k] * nsdae_larger(normal, nsdae_larger(a, b));
}

/* The least positive root of a t^2 + 2 b t + c, c < 0, below most; or that. */
static double positive_root(double a, double b, double c, double most)
{
  const double D = b * b - a * c;
  if (!(D > 0)) return most;
  const double q = -(b + copysign(sqrt(D), b)), t[2] = {q / a, c / q};
  for (int k = 0; k < 2; k++)
    if (t[k] > 0 && t[k] < most) most = t[k];
  return most;
}

/* The least t < most at which the state of r + t d changes: it opens at r_N = 0; if it sticks, it
 * slides at |r_T + t d_T| = mu (r_N + t d_N). */
static double first_bound(const double *r, const double *d, double mu, double most)
{
  if (r[0] + most * d[0] < 0) most = -r[0] / d[0];
  const double bound = mu * r[0], by = mu * d[0];
  const double c = r[1] * r[1] + r[2] * r[2] - bound * bound;
  if (!(c < -SLIDES * bound * bound)) return most;
  return positive_root(d[1] * d[1] + d[2] * d[2] - by * by, r[1] * d[1] + r[2] * d[2] - bound * by,
                       c, most);
}

void nsdae_fc_ratio_step(nsdae_fc_anderson *s, nsdae_fc_scaled *c)
{
  if (s->held < NSDAE_FC_WINDOW || !(s->left >= REMAINING)) return;
  nsdae_fc_anderson_remainder(s, c);
  /* The least t at which an item changes its state. */
  const double *d = s->before;
  double most = 0, far = LONGEST;
  for (int k = 0; k < c->n; k++) most = nsdae_larger(most, change(c, k, d));
  for (int k = 0; k < c->n; k++) {
    if (c->items.kind[k] == NSDAE_FC_BILATERAL || !(c->r[3 * k] > 0)) continue;
    if (change(c, k, d) >= SHARE * most)
      far = first_bound(c->r + 3 * k, d + 3 * k, c->items.mu[k], far);
  }
  if (!(far > 1)) return;
  nsdae_simd_add(3 * c->n, far, d, c->r);
  for (int k = 0; k < c->n; k++)
    if (c->items.kind[k] != NSDAE_FC_BILATERAL) nsdae_fc_project(c->items.mu[k], c->r + 3 * k);
  nsdae_fc_sweep_begin(c);
  nsdae_fc_anderson_begin(s);
}
