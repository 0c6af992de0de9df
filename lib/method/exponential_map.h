/* Motion of coordinates whose length the kinematics keeps, H(q)^T q = 0: quaternions, and points on
 * a circle. A group of them moves on the sphere |q| = const by its exponential map, which is the
 * great circle from q in the direction of the rate r, q^T r = 0:
 *
 *   q(h) = cos(a) q + sin(a) / a  h r,   a = h |r| / |q|
 *
 * Of a quaternion with r = q (0, w) / 2 this is q exp(h w / 2): exact for constant w, of any angle
 * (Hairer, Lubich, Wanner, Geometric Numerical Integration, 2006, sections IV.8 and VII.5).
 *
 * The factor |q_start| / |q| keeps the rounding of the length from growing with the steps.
 *
 * The trapezoidal rule takes the mean of the rates at q_0 and q_1. r_1 is brought to q_0 by
 * parallel transport along the great circle through both, which is the reflection
 *
 *   P r_1 = r_1 - 2 s (s^T r_1) / (s^T s),   s = q_0 + q_1,   as q_1^T r_1 = 0
 *
 * q_1 = exp(q_0; h/2 (r_0 + P r_1)) is symmetric in its ends, hence of second order. */
#ifndef NSDAE_EXPONENTIAL_MAP_H
#define NSDAE_EXPONENTIAL_MAP_H

/* Groups of coordinates whose length the kinematics keeps. */
typedef struct nsdae_units {
  int count;
  int *of;         /* nq: group of each coordinate; -1: none */
  double *length;  /* count, at most nq: at the start */
  double *work[2]; /* count, at most nq */
} nsdae_units;

/* to [nq] := from moved by h rate; coordinates without a group along the straight line. */
void nsdae_units_move(const nsdae_units *units, int nq, const double *from, double h,
                      const double *rate, double *to);
/* rate [nq], at q_1, := the mean of it and of rate_0, at q_0. */
void nsdae_units_mean_rate(const nsdae_units *units, int nq, const double *q_0,
                           const double *rate_0, const double *q_1, double *rate);

#endif
