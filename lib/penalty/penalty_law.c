#include "penalty_law.h"

#include <math.h>

static double damping(int kind, double e)
{
  switch (kind) {
  case NSDAE_PENALTY_HUNT_CROSSLEY:
    return 1.5 * (1 - e);
  case NSDAE_PENALTY_LANKARANI_NIKRAVESH:
    return 0.75 * (1 - e * e);
  case NSDAE_PENALTY_FLORES:
    return 1.6 * (1 - e) / e;
  default:
    return 0;
  }
}

/* zeta of the half oscillation that leaves with e times the velocity it came with; 1 for e = 0. */
static double damping_ratio(double e)
{
  const double pi = 3.14159265358979324;
  if (e <= 0) return 1;
  return -log(e) / sqrt(pi * pi + log(e) * log(e));
}

double nsdae_penalty_normal(const nsdae_penalty_force *law, double d, double rate,
                            double start_rate, double e, double mass)
{
  double force;
  if (!(d > 0)) return 0;
  if (law->kind == NSDAE_PENALTY_KELVIN_VOIGT)
    force = law->stiffness * d + 2 * damping_ratio(e) * sqrt(law->stiffness * mass) * rate;
  else
    force =
        law->stiffness * pow(d, law->exponent) * (1 + damping(law->kind, e) * rate / start_rate);
  return fmax(force, 0);
}

void nsdae_penalty_slopes(const nsdae_penalty_force *law, double d, double rate, double start_rate,
                          double e, double mass, double *slope)
{
  double K = law->stiffness, n = law->exponent, c = damping(law->kind, e) / start_rate;
  int any = nsdae_penalty_normal(law, d, rate, start_rate, e, mass) > 0;
  slope[0] = slope[1] = 0;
  if (any && law->kind == NSDAE_PENALTY_KELVIN_VOIGT) {
    slope[0] = K;
    slope[1] = 2 * damping_ratio(e) * sqrt(K * mass);
  } else if (any) {
    slope[0] = n * K * pow(d, n - 1) * (1 + c * rate);
    slope[1] = K * pow(d, n) * c;
  }
}

/* The work of the way in less that of the way out, times c^2; it falls with e'. */
static double work_left(double c, double e)
{
  return c * (1 + e) + log1p(-c * e) - log1p(c);
}

/* By halving. c below 1e-5 leaves rounding of the difference; the series is then as good. */
static double separable(double c)
{
  double low = 0, high = c > 1 ? 1 / c : 1;
  if (c < 1e-5) return 1 - 2 * c / 3;
  for (int i = 0; i < 60; i++) {
    double middle = (low + high) / 2;
    if (work_left(c, middle) > 0)
      low = middle;
    else
      high = middle;
  }
  return low;
}

double nsdae_penalty_restitution(const nsdae_penalty_force *law, double e)
{
  if (law->kind != NSDAE_PENALTY_KELVIN_VOIGT) return separable(damping(law->kind, e));
  double zeta = damping_ratio(e);
  return zeta < 1 ? exp(-2 * zeta * acos(zeta) / sqrt(1 - zeta * zeta)) : exp(-2);
}

double nsdae_penalty_friction(double mu, double normal, double speed, double regularisation)
{
  return -mu * normal / sqrt(speed * speed + regularisation * regularisation);
}
