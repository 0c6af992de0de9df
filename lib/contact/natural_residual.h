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

/* A constraint with the velocity u beside what is asked of it. */
static inline void nsdae_natural_residual_row(nsdae_natural_residual *m, double u)
{
  nsdae_natural_residual_raise(&m->left, fabs(u));
}

/* A contact of 1 + nt rows; x = d Lambda, u; those that it does not have are zero. */
static inline void nsdae_natural_residual_contact(nsdae_natural_residual *m, double mu,
                                                  const double x[3], const double u[3])
{
  if (mu > 0)
    nsdae_natural_residual_raise(&m->left, nsdae_fc_natural(NSDAE_FC_CONE, mu, x, NULL, u));
  else
    nsdae_natural_residual_raise(&m->left, fabs(x[0] - u[0] > 0 ? u[0] : x[0]));
}

static inline void nsdae_natural_residual_add(nsdae_natural_residual *sum,
                                              const nsdae_natural_residual *one)
{
  nsdae_natural_residual_raise(&sum->left, one->left);
  nsdae_natural_residual_raise(&sum->speed, one->speed);
}

static inline double nsdae_natural_residual_scaled(const nsdae_natural_residual *m)
{
  if (!isfinite(m->speed)) return NAN;
  return m->speed > 0 ? m->left / m->speed : m->left;
}

#endif
