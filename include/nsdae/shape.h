/* nsdae: shapes of bodies. BSD-3-Clause. */
#ifndef NSDAE_SHAPE_H
#define NSDAE_SHAPE_H

#ifdef __cplusplus
extern "C" {
#endif

/* Shapes, planar and spatial. */
enum nsdae_shape {
  NSDAE_SHAPE_POINT,   /* a marker */
  NSDAE_SHAPE_DISC,    /* planar, with an optional hole; spatial, without thickness, across z */
  NSDAE_SHAPE_SEGMENT, /* straight line between two points: rod, string, spring */
  NSDAE_SHAPE_POLYGON, /* planar, filled */
  NSDAE_SHAPE_PATH,    /* open line through points */
  NSDAE_SHAPE_SPHERE,
  NSDAE_SHAPE_CAPSULE, /* all points within a radius of a segment along z of its frame */
  NSDAE_SHAPE_BOX,
  NSDAE_SHAPE_PLANE,       /* half-space (spatial) or half-plane (planar): floor, wall */
  NSDAE_SHAPE_POLYHEDRON,  /* convex, spatial */
  NSDAE_SHAPE_CYLINDER,    /* along z of its frame */
  NSDAE_SHAPE_CONE,        /* round, its apex towards z, the origin at half its height */
  NSDAE_SHAPE_ELLIPSOID,   /* axes along those of its frame */
  NSDAE_SHAPE_MESH,        /* surface of triangles, spatial; the ground's */
  NSDAE_SHAPE_HEIGHT_FIELD /* heights on a grid, spatial; the ground's */
};

/* Shape and pose of a body, for programs that draw trajectories (nsdae-animate, nsdae-vtk). These
 * programs evaluate the formulas of the pose for every record, e.g. "L/2*sin(theta)". A formula has
 * at most 255 characters:
 *
 * - numbers, pi, + - * / ^ ( )
 * - sin cos tan asin acos atan atan2 sqrt exp log abs min max hypot
 * - the time t
 * - coordinates q0 .. q<nq-1>, or their names
 * - names of the model's parameters
 *
 * Planar: x is to the right, y upwards. Spatial: z is upwards. A text that is NULL or empty is not
 * given. */
typedef struct nsdae_body {
  const char *name; /* unique among the bodies */
  int shape;        /* enum nsdae_shape */
  /* Lengths, >= 0 [m]; unused ones 0:
   *
   * - disc: radius, radius of its hole or 0
   * - segment, path: width, 0 for a thin line
   * - sphere: radius
   * - capsule: radius, length between the centres of its caps
   * - cylinder: radius, length
   * - cone: radius of its base, height
   * - box: edge lengths along x, y, z of its frame
   * - ellipsoid: axes (diameters) along x, y, z of its frame
   * - plane: outward normal, of any length */
  double size[3];
  int points;                /* polygon: >= 3; path: >= 2; polyhedron: 3 for each triangle of its
                                surface; else 0 */
  const double *point;       /* [3 points] x, y, z of each in the body's frame; a triangle is
                                anticlockwise seen from outside */
  const char *position[3];   /* x, y, z of the body's origin; default 0 */
  const char *angle;         /* angle of its frame about z [rad]; default 0 */
  const char *quaternion[4]; /* w, x, y, z: rotates its frame into space, of any length > 0; give
                                all four or none, and not with angle */
  const char *end[3];        /* SEGMENT only: its other end; give at least one coordinate */
  const char *colour;        /* "#rrggbb"; none: the programs choose */
} nsdae_body;

#ifdef __cplusplus
}
#endif
#endif
