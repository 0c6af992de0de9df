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

#include <nsdae/bodies.h>

#include "pose.h"

/* A solid as the world keeps it: in its body's frame. */
typedef struct nsdae_solid_of {
  int body, shape, hollow, points, material;
  double radius, half[3]; /* half edges; segment: half[0]; capsule: half[2] */
  double
      size; /* largest distance of its corners from its origin, with the rounding; 0 of a plane */
  double origin[3], R[9]; /* its frame in the body's; of a plane column 2 is the normal */
  double turn[4];         /* spatial: the same as a unit quaternion */
  double *point;          /* points x 3: its corners in the body's frame */
  double *edge; /* planar, of more than one corner: points x 4, the outer unit normal of the edge
                   from each corner (3) and its length, behind the corners */
} nsdae_solid_of;

typedef struct nsdae_feature {
  int number; /* in order among those of the pair */
  int edges;  /* 0: a corner of solid[1] against solid[0]; 1: an edge of each */
  int solid[2];
  int part[2]; /* the corner in part[1]; the edges */
  double mu, e_n, e_t;
} nsdae_feature;

/* A contact at a moment. */
typedef struct nsdae_touch {
  nsdae_jet gap;
  nsdae_jet3 normal, at[2]; /* n, c_i */
  int far; /* another feature is nearer: the gap is positive and constant, and all there is */
} nsdae_touch;

/* "disc", "box" */
const char *nsdae_solid_name(int shape);

/* Corners of a solid: one where it has no extent but its rounding; and its edges (in space). */
int nsdae_solid_corners(const nsdae_solid_of *solid);
int nsdae_solid_edges(const nsdae_solid_of *solid);
/* Which edges of two solids can be the nearest of both: bit j of of[i] for edge i of solid 0 and j
 * of solid 1. Of the 144 pairs of two boxes these are few, for nine directions. */
enum { NSDAE_EDGES_MAX = 12 };
typedef struct nsdae_facing {
  unsigned of[NSDAE_EDGES_MAX];
} nsdae_facing;
void nsdae_find_facing(const nsdae_solid_of *solid0, const nsdae_solid_of *solid1,
                       const nsdae_pose *pose0, const nsdae_pose *pose1, nsdae_facing *facing);

/* Whether a solid of the plane has edges that can separate: a segment without rounding is a side.
 */
int nsdae_has_edges(const nsdae_solid_of *solid);

/* How far two planar solids are apart along the best outer normal of an edge of each, and which
 * edge; of a line also beyond its ends. All its features go by that. -INFINITY: has no edges. Where
 * one edge separates them by more than enough that is all it says. */
typedef struct nsdae_meeting {
  double value[2], ends[2];
  int edge[2];
  double above[2][3]; /* height of the other's points over that edge: see nsdae_height_above */
} nsdae_meeting;
nsdae_meeting nsdae_find_meeting(const nsdae_solid_of *solid0, const nsdae_solid_of *solid1,
                                 const nsdae_pose *pose0, const nsdae_pose *pose1, double enough);

/* The same of the solids in the other order. */
nsdae_meeting nsdae_meeting_turned(const nsdae_meeting *met);
/* above_x p_x + above_y p_y + above_0. No contact of a corner at p is nearer than this height over
 * any edge, the roundings apart. */
static inline double nsdae_height_above(const double *above, const double *p)
{
  return above[0] * p[0] + above[1] * p[1] + above[2];
}

/* The contact of a feature between two solids with these poses of their bodies; met: of planar
 * solids where it is known, else NULL. */
nsdae_touch nsdae_feature_touch(const nsdae_feature *feature, const nsdae_solid_of *solid0,
                                const nsdae_solid_of *solid1, const nsdae_pose *pose0,
                                const nsdae_pose *pose1, const nsdae_meeting *met);

#endif
