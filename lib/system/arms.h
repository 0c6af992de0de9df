/* Arms of rotations in W_T, in the plane, as far as the gap tells.
 *
 * A body's point of contact stays where it is while the body turns about it, and the gap, which is
 * the least distance, does not become larger than there. With n and t along the translations of the
 * body, a = W_N and b = W_T along a rotation theta, that turn begins with
 *
 *   v = e_theta - a n - b t,   W_N v = W_T v = 0,
 *
 * and goes on with the centripetal acceleration theta'^2 r of the arm r, whose part along n is b
 * or -b, as theta turns with the axes of n and t or against them. So, with H the gap's second
 * derivatives,
 *
 *   v^T H v <= |b|,
 *
 * with equality at a corner; the difference is the joint radius of curvature of what touches.
 * A b that is left out, or too short, breaks it where the gap bends by more. Which sense theta has
 * no gap can tell: seen in a mirror it is the same. But all contacts of a body have one sense:
 * where the gap bends (v^T H v > -|b|, so that the arm points away from n), the sign of b (n x t)
 * is the same.
 *
 * Not every coordinate that bends a gap is a rotation of a rigid body: a lift's platform rises by
 * l sin q and does not slip. So this is a doubt, not an error. */
#ifndef NSDAE_SYSTEM_ARMS_H
#define NSDAE_SYSTEM_ARMS_H

#include "differences.h"
#include "tangents.h"

typedef struct nsdae_arms {
  nsdae_contact_directions all; /* of all contacts: their columns one behind the other */
  nsdae_differences *differences;
  double t;
  const double *q;
  double *v, *bend; /* work: nv, 2 k */
} nsdae_arms;

/* v^T H v of contact i along arms->v: the even part of g'', without what moves by itself. v is used
 * up. A callback's code. */
int nsdae_arms_bend(nsdae_arms *arms, int i, double *bend);

/* The first doubt as text of that size, "" where there is none; a callback's code. */
int nsdae_arms_doubt(nsdae_arms *arms, double tol, char *text, size_t size);

#endif
