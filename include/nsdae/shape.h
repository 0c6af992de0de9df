/* nsdae: shapes of bodies. BSD-3-Clause. */
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

#ifdef __cplusplus
}
#endif
#endif
