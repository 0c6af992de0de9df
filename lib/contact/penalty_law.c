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

double nsdae_penalty_friction(double mu, double normal, double speed, double regularisation)
{
  return -mu * normal / sqrt(speed * speed + regularisation * regularisation);
}
