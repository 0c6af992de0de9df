/* Convex solids by their support maps: the point of a solid that is foremost along a direction.
 * Solids are cores with a rounding: a capsule is a segment, rounded by its radius. */
#ifndef NSDAE_BODIES_SUPPORT_H
#define NSDAE_BODIES_SUPPORT_H

#include "solid.h"

/* x := the point of the core that is foremost along d; both in the frame of the body. */
void nsdae_support(const nsdae_solid_of *solid, const double *d, double *x);

/* A rim or a ball at the end of a core: x := its foremost point along the unit vector d. */
void nsdae_round_end(const nsdae_solid_of *solid, const double *end, const double *d, double *x);

/* The supporting face of a solid along the unit vector n: of its faces, edges and sides at right
 * angles to n, up to a tilt of the sine NSDAE_TILT, the largest. */
enum { NSDAE_FACE = 16 };
typedef struct nsdae_face {
  int count; /* of points: 0 none, 2 a segment, else a polygon, anticlockwise seen from outside */
  double round;     /* of a segment: the distance of the solid's surface from it */
  double normal[3]; /* of a polygon: outer, of unit length */
  double disc; /* of a polygon whose corners are on the rim of a disc: its radius, else 0; corners 0
                  and 2 are opposite */
  int id[NSDAE_FACE];
  double x[NSDAE_FACE][3];
} nsdae_face;

void nsdae_supporting_face(const nsdae_solid_of *solid, const double *n, nsdae_face *face);

/* Contacts of two solids have numbers below this: the nearest points, corners, pairs of edges. */
static inline int nsdae_manifold_ids(const nsdae_solid_of *s0, const nsdae_solid_of *s1)
{
  return (1 + s0->points) * (1 + s1->points);
}

/* The signed distance g of two solids, its normal n from 0 to 1 and its points: see gjk.c.
 * 0: g > enough, and nothing is known of it. */
int nsdae_signed_distance(const nsdae_couple *two, double enough, nsdae_still *at);

#endif
