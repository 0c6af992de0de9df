/* Coulomb's cone K = {|r_T| <= mu r_N} in three rows, normal first. */
#ifndef NSDAE_FRICTION_CONE_H
#define NSDAE_FRICTION_CONE_H

#include <math.h>

#include "double_double.h"

/* What an item asks of its rows; those that it does not have are zero throughout. */
enum nsdae_fc_kind { NSDAE_FC_CONE, NSDAE_FC_NORMAL, NSDAE_FC_BILATERAL };

static inline double nsdae_fc_length(double a, double b)
{
  return sqrt(a * a + b * b);
}

/* x := nearest point of K (its polar cone: mu |x_T| <= -x_N). With mu above 1 divided by
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

/* The place of z = x - y, x in one double an entry, or two: if the bodies of a stack differ in mass
 * by 1e6, impulses are as much larger than the velocities that they change, and one double does not
 * hold by how much x is outside the cone. */
typedef struct nsdae_fc_place {
  double z[3], t;    /* z and |z_T|, rounded */
  double over;       /* a |z_T| - b z_N, (a, b) = (1, mu) / max(1, mu): of z as it is */
  int inside, polar; /* in K; P(z) = 0 and not inside */
} nsdae_fc_place;

/* over in twice the precision, rest what z does not hold of it. With t as rounded, |z_T| = t +
 * (z_T^2 - t^2) / (2 t); what that leaves out is of the order of the square of rounding. */
static inline double nsdae_fc_over(double mu, const nsdae_fc_place *p, const double rest[3])
{
  double square = 0, part = 0, high = p->t, low = 0;
  for (int k = 1; k < 3; k++) {
    nsdae_dd_add(p->z[k], p->z[k], &square, &part);
    part += 2 * p->z[k] * rest[k];
  }
  nsdae_dd_add(-p->t, p->t, &square, &part);
  low = p->t > 0 ? (square + part) / (2 * p->t) : nsdae_fc_length(rest[1], rest[2]);
  if (mu > 1) { /* divided by it */
    high = p->t / mu;
    low = (low + fma(-high, mu, p->t)) / mu;
  }
  double b = mu > 1 ? 1 : mu;
  nsdae_dd_add(-b, p->z[0], &high, &low);
  return high + (low - b * rest[0]);
}

/* Of x + low; low NULL: of x. */
static inline nsdae_fc_place nsdae_fc_place_of(double mu, const double x[3], const double *low,
                                               const double y[3])
{
  nsdae_fc_place p;
  double rest[3] = {0};
  for (int k = 0; k < 3; k++) {
    p.z[k] = x[k];
    nsdae_dd_add(-1, y[k], p.z + k, rest + k);
    if (low) nsdae_dd_add(1, low[k], p.z + k, rest + k);
  }
  p.t = nsdae_fc_length(p.z[1], p.z[2]);
  p.inside = p.z[0] >= 0 && p.t <= mu * p.z[0];
  if (low) {
    p.over = nsdae_fc_over(mu, &p, rest);
    p.inside = p.z[0] >= 0 && p.over <= 0;
  } else
    p.over = mu > 1 ? p.t / mu - p.z[0] : p.t - mu * p.z[0];
  p.polar = !p.inside && mu * p.t <= -p.z[0];
  return p;
}

/* x - P(x - y) for y = u^, where x is large and y small next to it: inside the cone it is y, in the
 * polar cone x, and between them y plus what separates z = x - y from the cone, which is l along
 * (-mu, d) / sqrt(1 + mu^2), d = z_T / |z_T|, l = (|z_T| - mu z_N) / sqrt(1 + mu^2). */
static inline void nsdae_fc_map_of_place(double mu, const nsdae_fc_place *p, const double x[3],
                                         const double y[3], double F[3])
{
  double big = mu > 1 ? mu : 1, a = 1 / big, b = mu / big; /* 1 and mu, scaled */
  double l = p->inside || p->polar ? 0 : p->over / (a * a + b * b);
  F[0] = p->polar ? x[0] : y[0] - b * l;
  for (int k = 1; k < 3; k++)
    F[k] = p->polar ? x[k] : y[k] + (l == 0 ? 0 : a * l * (p->z[k] / p->t));
}

/* Largest entry of the natural map r - P(r - u^) of an item, of r + low (NULL: of r); NaN if
 * there is one. */
static inline double nsdae_fc_natural(int kind, double mu, const double r[3], const double *low,
                                      const double u[3])
{
  if (kind == NSDAE_FC_BILATERAL) return fabs(u[0]);
  if (kind == NSDAE_FC_NORMAL) {
    double n = r[0] - u[0] > 0 ? u[0] : r[0]; /* r - max(0, r - u) */
    return fmax(fabs(n), fmax(fabs(r[1]), fabs(r[2])));
  }
  double y[3] = {u[0] + mu * nsdae_fc_length(u[1], u[2]), u[1], u[2]}, F[3], most = 0;
  nsdae_fc_place p = nsdae_fc_place_of(mu, r, low, y);
  nsdae_fc_map_of_place(mu, &p, r, y, F);
  for (int k = 0; k < 3; k++)
    if (!(fabs(F[k]) <= most) && most == most) most = fabs(F[k]);
  return most;
}

#endif
