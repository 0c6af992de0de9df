/* How far two solids of corners are apart along one axis, and along which the most: of what
 * overlaps that is the axis of least depth (the separating axes of polyhedra: S. Gottschalk, M. C.
 * Lin, D. Manocha, SIGGRAPH 1996, for boxes). Of convex solids that overlap the largest of these
 * separations is minus the least way that parts them, and changes no faster than they move; so the
 * contacts of a pair are those of that axis, and none is deeper. */
#ifndef NSDAE_BODIES_SEPARATING_AXIS_H
#define NSDAE_BODIES_SEPARATING_AXIS_H

#include "solid.h"

/* In parts of the sizes of both: the tolerance, for rounding and the drift of blocks that lie
 * flush; and how far beside a face what overlaps is still over it. */
#define NSDAE_SLACK  1e-6
#define NSDAE_BESIDE 1e-4

typedef struct nsdae_separating_axis {
  double most; /* separation of the cores along the best axis, negative where they overlap */
  double face; /* the same along the best outer normal of a face of solid 0; -INFINITY: none */
  int axis;    /* which: an axis of the box */
  double side; /* 1 or -1: along it or back */
  double slack, beside; /* [m] */
} nsdae_separating_axis;

/* Of boxes and capsules. most is that of the faces of solid 0 alone where these are apart by more
 * than slack. */
nsdae_separating_axis nsdae_separating_axis_find(const nsdae_couple *two);

#endif
