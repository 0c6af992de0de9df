/* How far two solids of corners are apart along one axis, and along which the most: of what
 * overlaps that is the axis of least depth (the separating axes of polyhedra: S. Gottschalk, M. C.
 * Lin, D. Manocha, SIGGRAPH 1996, for boxes). Of convex solids that overlap the largest of these
 * separations is minus the least way that parts them, and changes no faster than they move; so the
 * contacts of a pair are those of that axis, and none is deeper. No contact of solids that are
 * apart is nearer than the separation along any axis. */
#ifndef NSDAE_BODIES_SEPARATING_AXIS_H
#define NSDAE_BODIES_SEPARATING_AXIS_H

#include "solid.h"

/* In parts of the sizes of both: the tolerance, for rounding and the drift of blocks that lie
 * flush; and how far beside a face what overlaps is still over it. */
#define NSDAE_SLACK  1e-6
#define NSDAE_BESIDE 1e-4

/* Half edges of a box; of a capsule those of its segment. */
void nsdae_half_edges(const nsdae_solid_of *solid, double half[3]);

/* Of boxes and capsules; 0 where they are apart by more than enough along an axis: it says no more
 * then. */
int nsdae_find_separating_axis(const nsdae_couple *two, double enough, nsdae_separating_axis *o);

#endif
