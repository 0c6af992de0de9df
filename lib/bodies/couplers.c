/* Couplers: Phi = s_1 - p(s_0) of coordinates of two joints.
 *
 * A rotation in space is known up to k_i turns. Phi then is known up to the multiples of a period:
 *
 *   s_1 rotation                    Phi + 2 pi k_1
 *   s_0 rotation, p linear          Phi - 2 pi p_1 k_0
 *   both, p linear with p_1 = n/m   Phi + 2 pi (k_1 - k_0 n/m): multiples of 2 pi / m
 *
 * and has its value nearest to 0: of gears with m teeth, within half a tooth. */
#include <math.h>

#include "bodies_impl.h"

enum { TEETH = 256 };

/* The least m with m ratio an integer to rounding, or 0. */
static int denominator(double ratio)
{
  for (int m = 1; m <= TEETH; m++)
    if (fabs(m * ratio - round(m * ratio)) <= 1e-12 * m * (1 + fabs(ratio))) return m;
  return 0;
}

static int check_polynomial(nsdae_bodies *b, int index, const double *p, int *degree)
{
  *degree = 0;
  for (int i = 0; i < NSDAE_COUPLER_COEFFICIENTS; i++) {
    if (!isfinite(p[i]))
      return nsdae_bodies_refuse(b, NSDAE_E_NONFINITE, "coupler", "p", index,
                                 "p[%d] = %g is not a finite number", i, p[i]);
    if (p[i] != 0) *degree = i;
  }
  if (*degree > 0) return NSDAE_OK;
  return nsdae_bodies_refuse(b, NSDAE_E_ARGUMENT, "coupler", "p", index,
                             "p[1] .. p[%d] are zero: the coordinates are not coupled",
                             NSDAE_DEGREE);
}

/* 0: Phi is unique; < 0: a status. */
static double period_of(nsdae_bodies *b, int index, const nsdae_primitive *s0,
                        const nsdae_primitive *s1, const double *p, int degree)
{
  int turns0 = nsdae_primitive_is_periodic(s0), turns1 = nsdae_primitive_is_periodic(s1);
  if (degree > 1 || !turns0) return turns1 ? 2 * nsdae_pi : 0;
  if (!turns1) return 2 * nsdae_pi * fabs(p[1]);
  int teeth = denominator(p[1]);
  if (teeth > 0) return 2 * nsdae_pi / teeth;
  return nsdae_bodies_refuse(b, NSDAE_E_ARGUMENT, "coupler", "p", index,
                             "p[1] = %.17g of two rotations in space is not a fraction n/m with m "
                             "<= %d: they are gears with n and m teeth",
                             p[1], TEETH);
}

int nsdae_bodies_add_coupler(nsdae_bodies *b, const nsdae_coupler *coupler)
{
  int status = nsdae_bodies_open(b, coupler, "coupler"), index = 0, degree;
  if (status < 0) return status;
  for (int i = 0; i < b->constraint.count; i++) index += nsdae_constraint_at(b, i)->joint < 0;
  const nsdae_primitive *s[2];
  for (int i = 0; i < 2; i++) {
    s[i] = nsdae_bodies_joint_coordinate(b, "coupler", index, coupler->joint[i],
                                         coupler->coordinate[i], 0);
    if (!s[i]) return b->error.status;
  }
  if (s[0] == s[1])
    return nsdae_bodies_refuse(b, NSDAE_E_ARGUMENT, "coupler", "joint", index,
                               "both are coordinate %d of joint %d: they must be different",
                               coupler->coordinate[0], coupler->joint[0]);
  status = check_polynomial(b, index, coupler->p, &degree);
  double period = status < 0 ? 0 : period_of(b, index, s[0], s[1], coupler->p, degree);
  if (b->error.status < 0) return b->error.status;
  nsdae_bodies_constraint *c = nsdae_list_add(b, &b->constraint, sizeof *c);
  if (!c) return NSDAE_E_MEMORY;
  *c = (nsdae_bodies_constraint){.value = *s[1],
                                 .joint = -1 - index,
                                 .master =
                                     NSDAE_COORDINATES * coupler->joint[0] + coupler->coordinate[0],
                                 .period = period};
  for (int i = 0; i < NSDAE_COUPLER_COEFFICIENTS; i++) c->p[i] = coupler->p[i];
  return index;
}
