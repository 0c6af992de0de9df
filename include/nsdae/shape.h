/* nsdae: what bodies look like. BSD-3-Clause. */
#ifndef NSDAE_SHAPE_H
#define NSDAE_SHAPE_H

#ifdef __cplusplus
extern "C" {
#endif

/* Shapes that a body can have, planar and spatial. */
enum nsdae_shape {
  NSDAE_SHAPE_POINT,   /* a mark */
  NSDAE_SHAPE_DISC,    /* planar, with a hole if wanted */
  NSDAE_SHAPE_SEGMENT, /* straight from one place to another: rod, string, spring */
  NSDAE_SHAPE_POLYGON, /* planar, filled */
  NSDAE_SHAPE_PATH,    /* open line through points */
  NSDAE_SHAPE_SPHERE,
  NSDAE_SHAPE_CAPSULE, /* what is within a radius of a segment along its own z */
  NSDAE_SHAPE_BOX,
  NSDAE_SHAPE_PLANE /* half of the space, or of the plane: floor, wall */
};

/* What a body looks like and where it is, for the programs that draw trajectories (nsdae-animate,
 * nsdae-vtk). Places are formulas, worked out by those programs for every record: numbers,
 * + - * / ^ ( ), sin cos tan asin acos atan atan2 sqrt exp log abs min max hypot, pi, the time t,
 * the coordinates q0 .. q<nq-1> or by their names, and the model's parameters by theirs, e.g.
 * "L/2*sin(theta)"; at most 255 characters. In the plane x is to the right and y upwards, in space
 * z is upwards. Text that is NULL or empty is not given. */
typedef struct nsdae_body {
  const char *name; /* other than those of the other bodies */
  int shape;        /* enum nsdae_shape */
  /* Lengths, >= 0 [m]: disc: radius, radius of its hole or 0; segment, path: width, 0 for a thin
   * line; sphere: radius; capsule: radius, length between the centres of its ends; box: edges
   * along its own x, y, z. Plane: its normal, away from what is solid, of any length. Unused ones
   * 0. */
  double size[3];
  int points;                /* polygon: >= 3; path: >= 2; else 0 */
  const double *point;       /* [3 points] x, y, z of each in the body's own frame */
  const char *position[3];   /* x, y, z of the body's origin; not given: 0 */
  const char *angle;         /* of its frame about z [rad]; not given: none */
  const char *quaternion[4]; /* w, x, y, z: turns its frame into space, of any length but 0; all or
                                none, and not with an angle */
  const char *end[3];        /* of a segment alone: its other end; at least one is given */
} nsdae_body;

#ifdef __cplusplus
}
#endif
#endif
