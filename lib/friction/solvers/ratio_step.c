#include "ratio_step.h"

#include <math.h>

#include "simd.h"
#include "block_sweep.h"
#include "vector.h"

/* Sweeps drift where of the square of one this much is left. What only converges slowly leaves a
 * little less. */
static const double DRIFTS = 0.98;

/* Longest step, in sweeps; the shortest is one. */
static const double FARTHEST = 300;

/* Items that drift by less than this part of the largest are ignored: their state changes at every
 * turn, and sweeps see to them. */
static const double PART = 0.1;

/* Whose mu^2 r_N^2 - |r_T|^2 is at most this part of mu^2 r_N^2 slides. Here r is extrapolated:
 * some that slide are a little inside, and end the stride early. */
static const double SLIDES = 1e-6;

/* By how much item k drifts, as the residual sees it. */
static double size(const nsdae_fc_scaled *c, int k, const double *way)
{
  const double *d = way + 3 * k;
  return c->items.weight[k] * nsdae_larger(fabs(d[0]), nsdae_larger(fabs(d[1]), fabs(d[2])));
}

/* The least positive root of a t^2 + 2 b t + c, c < 0, below most; or that. */
static double root(double a, double b, double c, double most)
{
  const double D = b * b - a * c;
  if (!(D > 0)) return most;
  const double q = -(b + copysign(sqrt(D), b)), t[2] = {q / a, c / q};
  for (int k = 0; k < 2; k++)
    if (t[k] > 0 && t[k] < most) most = t[k];
  return most;
}

/* How far r + t d stays as it is: it opens where r_N = 0, and slides where it does not yet at
 * |r_T + t d_T| = mu (r_N + t d_N). */
static double reach(const double *r, const double *d, double mu, double most)
{
  if (r[0] + most * d[0] < 0) most = -r[0] / d[0];
  const double bound = mu * r[0], by = mu * d[0];
  const double c = r[1] * r[1] + r[2] * r[2] - bound * bound;
  if (!(c < -SLIDES * bound * bound)) return most;
  return root(d[1] * d[1] + d[2] * d[2] - by * by, r[1] * d[1] + r[2] * d[2] - bound * by, c, most);
}

/* To the first change of state of an item that drifts much; in sweeps. */
static double first_change(const nsdae_fc_scaled *c, const double *way)
{
  double most = 0, far = FARTHEST;
  for (int k = 0; k < c->n; k++) most = nsdae_larger(most, size(c, k, way));
  for (int k = 0; k < c->n; k++) {
    if (c->items.kind[k] == NSDAE_FC_BILATERAL || !(c->r[3 * k] > 0)) continue;
    if (size(c, k, way) >= PART * most) far = reach(c->r + 3 * k, way + 3 * k, c->items.mu[k], far);
  }
  return far;
}

void nsdae_fc_ratio_step(nsdae_fc_anderson *s, nsdae_fc_scaled *c)
{
  if (s->held < NSDAE_FC_WINDOW || !(s->left >= DRIFTS)) return;
  nsdae_fc_anderson_leave(s, c);
  const double far = first_change(c, s->before);
  if (!(far > 1)) return;
  nsdae_simd_add(3 * c->n, far, s->before, c->r);
  for (int k = 0; k < c->n; k++)
    if (c->items.kind[k] != NSDAE_FC_BILATERAL) nsdae_fc_project(c->items.mu[k], c->r + 3 * k);
  nsdae_fc_sweep_begin(c);
  nsdae_fc_anderson_begin(s);
}
