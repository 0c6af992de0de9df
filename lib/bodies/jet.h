/* Jets: a quantity x along the motion, with its rate x' and with x'' as it would be if no body's
 * velocities changed. With q'' = 0 in that sense the second derivative of a constraint or gap is
 * its omega:  Phi'' = Phi_q v' + omega. Every geometric formula is written once, on jets, and is
 * exact in all three. */
#ifndef NSDAE_BODIES_JET_H
#define NSDAE_BODIES_JET_H

#include <math.h>

typedef struct nsdae_jet {
  double x, d, dd;
} nsdae_jet;

typedef struct nsdae_jet3 {
  nsdae_jet at[3];
} nsdae_jet3;

static inline nsdae_jet nsdae_jet_of(double x)
{
  return (nsdae_jet){x, 0, 0};
}

static inline nsdae_jet nsdae_jet_add(nsdae_jet a, nsdae_jet b)
{
  return (nsdae_jet){a.x + b.x, a.d + b.d, a.dd + b.dd};
}

static inline nsdae_jet nsdae_jet_sub(nsdae_jet a, nsdae_jet b)
{
  return (nsdae_jet){a.x - b.x, a.d - b.d, a.dd - b.dd};
}

static inline nsdae_jet nsdae_jet_mul(nsdae_jet a, nsdae_jet b)
{
  return (nsdae_jet){a.x * b.x, a.d * b.x + a.x * b.d, a.dd * b.x + 2 * a.d * b.d + a.x * b.dd};
}

/* f(a) of a function with the value f and derivatives f', f'' at a.x */
static inline nsdae_jet nsdae_jet_chain(nsdae_jet a, double f, double f1, double f2)
{
  return (nsdae_jet){f, f1 * a.d, f1 * a.dd + f2 * a.d * a.d};
}

static inline nsdae_jet nsdae_jet_sqrt(nsdae_jet a)
{
  double root = sqrt(a.x);
  return nsdae_jet_chain(a, root, 0.5 / root, -0.25 / (root * a.x));
}

static inline nsdae_jet nsdae_jet_inverse(nsdae_jet a)
{
  double inverse = 1 / a.x;
  return nsdae_jet_chain(a, inverse, -inverse * inverse, 2 * inverse * inverse * inverse);
}

static inline nsdae_jet nsdae_jet_scale(double s, nsdae_jet a)
{
  return (nsdae_jet){s * a.x, s * a.d, s * a.dd};
}

static inline nsdae_jet3 nsdae_jet3_add(nsdae_jet3 a, nsdae_jet3 b)
{
  for (int i = 0; i < 3; i++) a.at[i] = nsdae_jet_add(a.at[i], b.at[i]);
  return a;
}

static inline nsdae_jet3 nsdae_jet3_sub(nsdae_jet3 a, nsdae_jet3 b)
{
  for (int i = 0; i < 3; i++) a.at[i] = nsdae_jet_sub(a.at[i], b.at[i]);
  return a;
}

static inline nsdae_jet3 nsdae_jet3_times(nsdae_jet s, nsdae_jet3 a)
{
  for (int i = 0; i < 3; i++) a.at[i] = nsdae_jet_mul(s, a.at[i]);
  return a;
}

static inline nsdae_jet3 nsdae_jet3_scale(double s, nsdae_jet3 a)
{
  for (int i = 0; i < 3; i++) a.at[i] = nsdae_jet_scale(s, a.at[i]);
  return a;
}

static inline nsdae_jet nsdae_jet3_dot(nsdae_jet3 a, nsdae_jet3 b)
{
  nsdae_jet sum = nsdae_jet_mul(a.at[0], b.at[0]);
  for (int i = 1; i < 3; i++) sum = nsdae_jet_add(sum, nsdae_jet_mul(a.at[i], b.at[i]));
  return sum;
}

static inline nsdae_jet3 nsdae_jet3_cross(nsdae_jet3 a, nsdae_jet3 b)
{
  nsdae_jet3 c;
  for (int i = 0; i < 3; i++) {
    int j = (i + 1) % 3, k = (i + 2) % 3;
    c.at[i] = nsdae_jet_sub(nsdae_jet_mul(a.at[j], b.at[k]), nsdae_jet_mul(a.at[k], b.at[j]));
  }
  return c;
}

static inline nsdae_jet nsdae_jet3_length(nsdae_jet3 a)
{
  return nsdae_jet_sqrt(nsdae_jet3_dot(a, a));
}

static inline nsdae_jet3 nsdae_jet3_of(const double *x)
{
  return (nsdae_jet3){{{x[0], 0, 0}, {x[1], 0, 0}, {x[2], 0, 0}}};
}

#endif
