/* Arms of rotations in W_T, in the plane, as far as the gap tells.
 *
 * A body's point of contact stays where it is while the body turns about it. With n and t along the
 * translations of the body, a = W_N and b = W_T along a rotation theta, that turn begins with
 *
 *   v = e_theta - a n - b t,   W_N v = W_T v = 0,
 *
 * and what touches rolls. Let r be from the centre to the point of contact, s = +-1 the sense of
 * theta, p = n x t: a = s r x n, b = s r x t. While theta grows by one the point of contact moves
 * by rho t, rho the joint radius of curvature of what touches, n and t turn by alpha = t . n', and
 * r changes by rho t and by the turn. So
 *
 *   b' = (s p - alpha) a        the rate of b along v,                                         (1)
 *   v^T H v = |b| - rho <= |b|  where r points away from n; H: second derivatives of the gap.  (2)
 *
 * (On a plane alpha = 0; where a corner of what is touched carries an edge of the body rho = 0,
 * |alpha| = 1 and b' = 0.) Everything but s is given or seen from the gap, so that an arm that is
 * left out or scaled breaks (1) where a is not zero, and (2) where it becomes too short for a
 * corner. s is one for all contacts of a body: the sign of one arm among several is seen, too.
 *
 * No gap tells the rest. A body that is grown by c all around, before a wall that is moved back
 * by c, has the same gap in every place, and arms that are longer by c: (1) gives b up to a
 * constant. And seen in a mirror the gap is the same, so that nothing gives the sign of all arms.
 *
 * Not every velocity alone in M is a rotation of a rigid body. One without a constant inertia is
 * none, nor is one that leaves gap and directions as they are; others may yet break (1): so this is
 * a doubt, not an error. */
#ifndef NSDAE_SYSTEM_ARMS_H
#define NSDAE_SYSTEM_ARMS_H

#include "differences.h"
#include "tangent_check.h"

typedef struct nsdae_moment_arms {
  nsdae_contact_directions all; /* of all contacts: their columns one behind the other */
  nsdae_differences *differences;
  double t;
  const double *q;
  double *v, *rate, *bend; /* work: nv, nq, k + nv */
} nsdae_moment_arms;

/* Directions of contacts at a place against what gap, mass and kinematics tell of them: see
 * tangent_check.h. */

typedef struct nsdae_directions {
  nsdae_differences *differences; /* whose system it is; set before */
  nsdae_moment_arms arms;
  double *M, *normal, *other, *tangent; /* as in the terms; nv x k, nv x k, nv x k nt */
  double *mass, *place, *q;             /* nv: diagonal of M, see below; nq: elsewhere, and here */
  double *turn;                         /* 3 nq */
  int *turns, *set;                     /* nv */
} nsdae_directions;

void nsdae_directions_layout(nsdae_directions *directions, nsdae_arena *arena);

/* Evaluates them at (t, q), W_N by differences where it is not given (and right, as far as anybody
 * looked), and W_N and M a little elsewhere. A callback's code. */
int nsdae_directions_at(nsdae_directions *directions, double t, const double *q);

/* The first column of W_T, of a contact with friction, that is wrong as far as translations of
 * bodies tell, and why; -1: none. */
int nsdae_directions_wrong(const nsdae_directions *directions, double tol,
                           char why[NSDAE_TANGENT_TEXT]);

/* The first doubt, of arms and of gaps that are no lengths, as text; "": none. A callback's code.
 */
int nsdae_directions_doubt(nsdae_directions *directions, double tol, char *text, size_t size);

#endif
