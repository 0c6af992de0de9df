/* Continuous contact force: the bodies overlap by d and the contact is a spring with damping,
 *
 *   F_N = K d^n (1 + c d' / d'_0),   not below 0,    d'_0: closing velocity at first touch
 *
 *   hertz                  c = 0
 *   hunt-crossley          c = 3 (1 - e) / 2          Hunt and Crossley, J. Appl. Mech. 42, 1975
 *   lankarani-nikravesh    c = 3 (1 - e^2) / 4        Lankarani and Nikravesh, J. Mech. Des. 112,
 * 1990 flores                 c = 8 (1 - e) / (5 e)      Flores et al., Multibody Syst. Dyn. 25,
 * 2011 kelvin-voigt           F_N = K d + b d',  b = 2 zeta sqrt(K m), zeta = -ln e / sqrt(pi^2 +
 * ln^2 e),  m the contact's effective mass
 *
 * and Coulomb's friction regularised over the velocity v_r:  F_T = -mu F_N v_T / sqrt(v_T^2 +
 * v_r^2). */
#ifndef NSDAE_PENALTY_LAW_H
#define NSDAE_PENALTY_LAW_H

#include <nsdae/contact.h>

typedef struct nsdae_penalty_force {
  int kind;                   /* enum nsdae_penalty_law */
  double stiffness, exponent; /* K [N/m^n], n */
} nsdae_penalty_force;

/* Normal force for overlap d (0 where d <= 0), its rate, d'_0 > 0, restitution e, effective mass.
 */
double nsdae_penalty_normal(const nsdae_penalty_force *law, double d, double rate,
                            double start_rate, double e, double mass);

/* slope [2] := dF_N/dd, dF_N/dd' of the same, zero where the force is. */
void nsdae_penalty_slopes(const nsdae_penalty_force *law, double d, double rate, double start_rate,
                          double e, double mass, double *slope);

/* The restitution e' that the law gives where e is asked, with no other force on the contact. The
 * separable laws: m w dw / (1 + c w / v) = -K d^n dd from w = v to -e' v gives
 * c - ln(1 + c) = -c e' - ln(1 - c e'), whatever m, K, n and v are. kelvin-voigt ends at F_N = 0,
 * before d = 0: e' = exp(-2 zeta acos(zeta) / sqrt(1 - zeta^2)), e^-2 for zeta = 1. */
double nsdae_penalty_restitution(const nsdae_penalty_force *law, double e);

/* F_T / v_T: friction of a normal force at the slip speed. */
double nsdae_penalty_friction(double mu, double normal, double speed, double regularisation);

#endif
