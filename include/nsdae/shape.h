/* nsdae: names of shapes, for contacts between bodies and for pictures of them. BSD-3-Clause. */
#ifndef NSDAE_SHAPE_H
#define NSDAE_SHAPE_H

enum nsdae_shape {
  NSDAE_SHAPE_POINT,
  NSDAE_SHAPE_DISC,
  NSDAE_SHAPE_SEGMENT,
  NSDAE_SHAPE_POLYGON,
  NSDAE_SHAPE_PATH,
  NSDAE_SHAPE_SPHERE,
  NSDAE_SHAPE_CAPSULE,
  NSDAE_SHAPE_BOX,
  NSDAE_SHAPE_PLANE
};

#endif
