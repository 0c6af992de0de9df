/* Arms of rotations in W_T, in space, as far as the gap and the kinematics tell.
 *
 * Three velocities w that move four coordinates e as an angular velocity moves a quaternion (the
 * columns of de/dt = H w are at right angles to e and to each other, and |e| / 2 long) turn a body.
 * With r from its centre to where it touches, the columns n, t_1, t_2 of W along its translations
 * and a, b_1, b_2 along its rotations are, in axes that C turns into those of the translations,
 *
 *   a = C^T (r x n),  b_j = C^T (r x t_j):   C (a n^T + b_1 t_1^T + b_2 t_2^T) = [r x],
 *
 * skew-symmetric, for n, t_1, t_2 are at right angles. C is 1 or the rotation of e, which has its
 * scalar first or last, one way or the other: the same at all contacts of the body. And a turn
 * about the point of contact, at right angles to n, opens the gap by
 *
 *   v^T H v <= -r . n
 *
 * (see moment_arms.h, where the sense of a rotation is not known; here it is), which a ball's arms
 * with the other sign break. Which velocities turn which body is guessed, so this is a doubt, too.
 */
#ifndef NSDAE_SYSTEM_LEVERS_H
#define NSDAE_SYSTEM_LEVERS_H

#include "moment_arms.h"

/* Brings the quaternions in q, which is arms->q, to length one: for others R(e) need be no
 * rotation.
 */
int nsdae_moment_arm_check_unit(const nsdae_moment_arms *arms, double *H, double *q);

/* As nsdae_moment_arms_doubt, where nt = 2; H [3 nq] and turns [nv] are work. */
int nsdae_moment_arm_check_doubt(nsdae_moment_arms *arms, double *H, int *turns, double tol,
                                 char *text, size_t size);

#endif
