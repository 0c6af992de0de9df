/* Coulomb's cone K = {|r_T| <= mu r_N} in three rows, normal first. */
#ifndef NSDAE_FRICTION_CONE_H
#define NSDAE_FRICTION_CONE_H

#include <math.h>

/* What an item asks of its rows; those that it does not have are zero throughout. */
enum nsdae_fc_kind { NSDAE_FC_CONE, NSDAE_FC_NORMAL, NSDAE_FC_BILATERAL };

static inline double nsdae_fc_length(double a, double b)
{
  return sqrt(a * a + b * b);
}

/* x := nearest point of K (its polar cone is where mu |x_T| <= -x_N). With mu above 1 divided by
 * it, so that mu^2 does not overflow. */
static inline void nsdae_fc_project(double mu, double x[3])
{
  double t = nsdae_fc_length(x[1], x[2]);
  if (x[0] >= 0 && t <= mu * x[0]) return;
  if (mu * t <= -x[0]) {
    x[0] = x[1] = x[2] = 0;
    return;
  }
  double n = mu > 1 ? (x[0] / mu + t) / mu / (1 / mu / mu + 1) : (x[0] + mu * t) / (1 + mu * mu);
  x[0] = n;
  x[1] *= mu * n / t;
  x[2] *= mu * n / t;
}

/* Largest entry of the natural map r - P(r - u^) of an item; NaN where there is one. */
static inline double nsdae_fc_natural(int kind, double mu, const double r[3], const double u[3])
{
  if (kind == NSDAE_FC_BILATERAL) return fabs(u[0]);
  if (kind == NSDAE_FC_NORMAL) {
    double n = r[0] - u[0] > 0 ? u[0] : r[0]; /* r - max(0, r - u) */
    return fmax(fabs(n), fmax(fabs(r[1]), fabs(r[2])));
  }
  double slip = nsdae_fc_length(u[1], u[2]), most = 0;
  double x[3] = {r[0] - u[0] - mu * slip, r[1] - u[1], r[2] - u[2]};
  nsdae_fc_project(mu, x);
  for (int k = 0; k < 3; k++) {
    double gap = fabs(r[k] - x[k]);
    if (!(gap <= most)) most = gap;
  }
  return most;
}

#endif
