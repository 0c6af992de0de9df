/* The residuals of the laws of contacts and constraints, over all islands of a step: with W = H^T
 * M^-1 H, d the mean of the diagonal entries of a contact's block, u its velocities by v, before
 * what is rounding in it is put to zero (with e v(-) and the motion of surfaces), q those without
 * any impulse, and K its cone (in the plane of two rows, of one without friction),
 *
 *   max |d Lambda - P_K(d Lambda - (u + mu |u_T| e_N))| / max |q|,   of constraints |u| / max |q|,
 *
 * as by nsdae_friction_residual. The map is of degree one in (Lambda, u): so each island says what
 * it leaves [velocity] and how fast its contacts are without impulses, and the whole has one scale,
 * that of the fastest. An island is solved by its own, which is the stricter. */
#ifndef NSDAE_NATURAL_RESIDUAL_H
#define NSDAE_NATURAL_RESIDUAL_H

#include <math.h>

#include "cone.h"

typedef struct nsdae_natural_residual {
  double left, speed; /* numerator and denominator; NaN where one is */
  double hidden; /* what contacts leave beside `left`, below the rounding of their velocities */
} nsdae_natural_residual;

static inline void nsdae_natural_residual_raise(double *most, double x)
{
  if (!(x <= *most) && *most == *most) *most = x;
}

/* Velocity q of a row without impulses. */
static inline void nsdae_natural_residual_speed(nsdae_natural_residual *m, double q)
{
  nsdae_natural_residual_raise(&m->speed, fabs(q));
}

/* The residual of a contact; of a constraint with the velocity u beside what is asked of it. */
static inline void nsdae_natural_residual_row(nsdae_natural_residual *m, double u)
{
  nsdae_natural_residual_raise(&m->left, fabs(u));
}

/* Largest entry of the natural map of a contact, x = d Lambda: without friction; and of one in the
 * plane, as cone.h has it in space: with y = u + mu |u_T| e_N and z = x - y it is y in the cone, x
 * in the polar cone, and between them y plus what separates z from the cone. */
static inline double nsdae_natural_normal(double x, double u)
{
  return fabs(x - u > 0 ? u : x);
}

static inline double nsdae_natural_planar(double mu, const double x[2], const double u[2])
{
  double y = u[0] + mu * fabs(u[1]), z = x[0] - y, z_T = x[1] - u[1], most;
  const double big = mu > 1 ? mu : 1, a = 1 / big, b = mu / big; /* 1 and mu, scaled */
  int inside = z >= 0 && fabs(z_T) <= mu * z, polar = !inside && mu * fabs(z_T) <= -z;
  double l =
      inside || polar ? 0 : (mu > 1 ? fabs(z_T) / mu - z : fabs(z_T) - mu * z) / (a * a + b * b);
  most = fabs(polar ? x[0] : y - b * l);
  nsdae_natural_residual_raise(&most, fabs(polar ? x[1] : u[1] + copysign(a * l, z_T)));
  return most;
}

static inline void nsdae_natural_residual_add(nsdae_natural_residual *sum,
                                              const nsdae_natural_residual *one)
{
  nsdae_natural_residual_raise(&sum->left, one->left);
  nsdae_natural_residual_raise(&sum->speed, one->speed);
  nsdae_natural_residual_raise(&sum->hidden, one->hidden);
}

static inline double nsdae_natural_residual_scaled(const nsdae_natural_residual *m)
{
  if (!isfinite(m->speed)) return NAN;
  return m->speed > 0 ? m->left / m->speed : m->left;
}

#endif
