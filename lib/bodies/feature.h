/* Features: the places where two solids can touch, one contact each. A corner of solid 1 (with its
 * rounding) against the core of solid 0, or an edge of the one against an edge of the other.
 *
 * Whichever part is nearest, the geometry is one of four: a point against a point, a line or a
 * plane, and a line against a line. Each gives jets of the gap, of the normal n (from 0 to 1) and
 * of the two points of contact c_0, c_1, which wander over their bodies:
 *
 *   xi = c'_1 - c'_0 of the material points there:   v_N = n . xi = g',   v_T = t . xi
 *   xi' (with v' = 0) = w_1 x (c'_1 - x'_1(c_1)) - w_0 x (c'_0 - x'_0(c_0)) with x'_i the velocity
 * of the body's material point and c'_i that of the place */
#ifndef NSDAE_BODIES_FEATURE_H
#define NSDAE_BODIES_FEATURE_H

#include "solid.h"

/* "disc", "box" */
const char *nsdae_solid_name(int shape);

/* The number of edges of a solid (in space). */
int nsdae_solid_edges(const nsdae_solid_of *solid);
/* The edges of two solids that can be the nearest of both. */
void nsdae_find_facing(const nsdae_couple *two, nsdae_facing *facing);

/* The contact of a feature between two solids, in its order. */
nsdae_touch nsdae_feature_touch(const nsdae_feature *feature, const nsdae_couple *two);

#endif
