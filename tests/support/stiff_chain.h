/* A chain of n equal links on spherical joints with viscous friction in each: rigid in its joints,
 * of rates up to 4 damping / J = 2000 1/s next to a swing of a second. By blocks: link i is a block
 * with q = [centre of mass, quaternion], v = [its velocity, angular velocity in the link's axes].
 *
 *   x of a link is its length 2h, joint i between +h of link i-1 (i = 0: the origin) and -h of link
 * i Phi_i = r_i - h R_i e_x - r_i-1 - h R_i-1 e_x,   torque on link i: -d (w_i - w_i-1)
 *
 * If all links turn about y alone, theta_i is the angle below the horizontal and
 *
 *   sum_j m a_ij (cos(theta_i - theta_j) theta_j'' + sin(theta_i - theta_j) theta_j'^2) + J
 * theta_i'' = m g b_i cos theta_i - d (theta_i' - theta_i-1') + d (theta_i+1' - theta_i'), a_ij =
 * sum_k c_ki c_kj,  b_i = sum_k c_ki,  c_ki = 2h (k > i), h (k = i), 0 (k < i). */
#ifndef NSDAE_TESTS_STIFF_CHAIN_H
#define NSDAE_TESTS_STIFF_CHAIN_H

#include <nsdae/nsdae.h>

typedef struct stiff_chain {
  int n;
  double damping; /* of each joint [N m s] */
} stiff_chain;

/* chain must outlive the system; derivatives: with the callbacks for D and K. NULL without memory.
 */
nsdae_system *stiff_chain_system(stiff_chain *chain, int derivatives);

/* At rest, links turned by 0.5 rad to and fro about axes at right angles to x that differ from link
 * to link: q [7 n], v [6 n]. */
void stiff_chain_start(const stiff_chain *chain, double *q, double *v);

/* A planar state by its angles and rates [n]. */
void stiff_chain_place(const stiff_chain *chain, const double *theta, const double *rate, double *q,
                       double *v);

/* theta'' [n] of a planar state by the equations of the angles. */
void stiff_chain_accelerations(const stiff_chain *chain, const double *theta, const double *rate,
                               double *theta_dd);

/* theta and rate [n] after the time T by `steps` equal steps of the classical method of Runge and
 * Kutta; stable for steps up to 2.7 J / 4 damping. */
void stiff_chain_swing(const stiff_chain *chain, double T, long steps, double *theta, double *rate);

#endif
