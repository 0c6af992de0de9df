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

/* x - P(x - y) for y = u^, where x is large and y small next to it: inside the cone it is y, in the
 * polar cone x, and between them y plus what separates z = x - y from the cone, which is l along
 * (-mu, d) / sqrt(1 + mu^2), d = z_T / |z_T|, l = (|z_T| - mu z_N) / sqrt(1 + mu^2). */
static inline void nsdae_fc_map_of_cone(double mu, const double x[3], const double y[3],
                                        double F[3])
{
  double z[3] = {x[0] - y[0], x[1] - y[1], x[2] - y[2]}, t = nsdae_fc_length(z[1], z[2]);
  int inside = z[0] >= 0 && t <= mu * z[0], polar = mu * t <= -z[0];
  double big = mu > 1 ? mu : 1, a = 1 / big, b = mu / big; /* 1 and mu, scaled */
  double l = inside || polar ? 0 : (a * t - b * z[0]) / (a * a + b * b);
  F[0] = polar && !inside ? x[0] : y[0] - b * l;
  for (int k = 1; k < 3; k++)
    F[k] = polar && !inside ? x[k] : y[k] + (l == 0 ? 0 : a * l * (z[k] / t));
}

/* Largest entry of the natural map r - P(r - u^) of an item; NaN where there is one. */
static inline double nsdae_fc_natural(int kind, double mu, const double r[3], const double u[3])
{
  if (kind == NSDAE_FC_BILATERAL) return fabs(u[0]);
  if (kind == NSDAE_FC_NORMAL) {
    double n = r[0] - u[0] > 0 ? u[0] : r[0]; /* r - max(0, r - u) */
    return fmax(fabs(n), fmax(fabs(r[1]), fabs(r[2])));
  }
  double y[3] = {u[0] + mu * nsdae_fc_length(u[1], u[2]), u[1], u[2]}, F[3], most = 0;
  nsdae_fc_map_of_cone(mu, r, y, F);
  for (int k = 0; k < 3; k++)
    if (!(fabs(F[k]) <= most) && most == most) most = fabs(F[k]);
  return most;
}

#endif
