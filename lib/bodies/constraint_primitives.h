/* Elements: the scalar constraints that joints are made of, between two bodies.
 *
 *   ALONG     n . (x_1 - x_0) - f           n fixed in body 0, or in space
 *   BETWEEN   (-sin f a + cos f b) . c      a, b at right angles in body 0, c in body 1
 *   DISTANCE  |x_1 - x_0| - f
 *   TURN      theta_1 - ratio theta_0 - offset - f
 *
 * with f(t) the prescribed motion, or a constant. */
#ifndef NSDAE_BODIES_ELEMENT_H
#define NSDAE_BODIES_ELEMENT_H

#include <nsdae/bodies.h>

#include "pose.h"

typedef enum nsdae_primitive_kind {
  NSDAE_PRIMITIVE_ALONG,
  NSDAE_PRIMITIVE_BETWEEN,
  NSDAE_PRIMITIVE_DISTANCE,
  NSDAE_PRIMITIVE_TURN
} nsdae_primitive_kind;

typedef struct nsdae_primitive {
  nsdae_primitive_kind kind;
  int joint, joint_kind; /* that it is of, and its enum nsdae_joint_kind */
  int body[2];
  int in_space;               /* ALONG: n is */
  double point[2][3];         /* x_i in their bodies' frames */
  double a[3], b[3];          /* n, or a and b: in the frame of body 0 (or in space) */
  double c[3];                /* in the frame of body 1 */
  double ratio, offset, rest; /* rest: f without drive */
  nsdae_drive_fn drive;       /* or NULL */
  void *user;
} nsdae_primitive;

/* Its value with rate and omega, its explicit rate Phi_t, and its row of Phi_q. */
typedef struct nsdae_primitive_value {
  nsdae_jet phi;
  double phi_t;
  nsdae_velocity_row row;
} nsdae_primitive_value;

/* From the poses of its two bodies; 0 or what the drive returned. */
int nsdae_primitive_evaluate(const nsdae_primitive *element, double t, const nsdae_pose pose[2],
                             nsdae_primitive_value *value);

#endif
