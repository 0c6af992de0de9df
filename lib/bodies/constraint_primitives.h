/* Constraint primitives: scalar coordinates of two bodies. Joints, limits, springs and couplers are
 * made of them.
 *
 *   ALONG      n . (x_1 - x_0) - offset              n fixed in body 0, or in space
 *   SQUARE     a . c                                 a in body 0, c in body 1
 *   DISTANCE   |x_1 - x_0| - offset
 *   TURN       theta_1 - ratio theta_0 - offset      planar: turns are counted
 *   ANGLE      atan2(c . b, c . a) - offset          a, b at right angles in body 0: the angle of
 *                                                    body 1 about a x b, in (-pi, pi] - offset
 *   SPIN       0, with the rate a . (w_1 - w_0)      a in body 0: a velocity without a coordinate
 */
#ifndef NSDAE_BODIES_ELEMENT_H
#define NSDAE_BODIES_ELEMENT_H

#include <nsdae/bodies.h>

#include "pose.h"

typedef enum nsdae_primitive_kind {
  NSDAE_PRIMITIVE_ALONG,
  NSDAE_PRIMITIVE_SQUARE,
  NSDAE_PRIMITIVE_DISTANCE,
  NSDAE_PRIMITIVE_TURN,
  NSDAE_PRIMITIVE_ANGLE,
  NSDAE_PRIMITIVE_SPIN
} nsdae_primitive_kind;

typedef struct nsdae_primitive {
  nsdae_primitive_kind kind;
  int body[2];
  int in_space;       /* ALONG: n is */
  double point[2][3]; /* x_i in their bodies' frames */
  double a[3], b[3];  /* n, or a and b: in the frame of body 0 (or in space) */
  double c[3];        /* in the frame of body 1 */
  double ratio, offset;
} nsdae_primitive;

/* The wrench of a unit force along a coordinate: force at the points at[i], + on body 1, - on body
 * 0, and torque, whose share of body 0 is -ratio torque. */
typedef struct nsdae_wrench {
  nsdae_jet3 force, torque, at[2];
  double ratio;
} nsdae_wrench;

/* The coordinate with rate and omega, its wrench, and its row of velocities, which is the wrench
 * about the centres of the bodies. */
typedef struct nsdae_primitive_value {
  nsdae_jet phi;
  nsdae_wrench wrench;
  nsdae_velocity_row row;
} nsdae_primitive_value;

/* From the poses of its two bodies. */
void nsdae_primitive_evaluate(const nsdae_primitive *primitive, const nsdae_pose pose[2],
                              nsdae_primitive_value *value);

/* Whether it is an angle in space, which is known up to turns. */
static inline int nsdae_primitive_is_periodic(const nsdae_primitive *primitive)
{
  return primitive->kind == NSDAE_PRIMITIVE_ANGLE;
}

/* Turns a and b of an ANGLE by the angle: its cut, where it jumps by a turn, is opposite of it. */
void nsdae_primitive_turn_cut(nsdae_primitive *primitive, double angle);

/* "m", "rad" or "1" */
const char *nsdae_primitive_unit(const nsdae_primitive *primitive);

#endif
