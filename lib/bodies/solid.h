/* A solid in its body's frame, a feature of two solids, and two of them at a moment. */
#ifndef NSDAE_BODIES_SOLID_H
#define NSDAE_BODIES_SOLID_H

#include <nsdae/bodies.h>

#include "hull.h"
#include "pose.h"

/* What it touches: see nsdae_solid. */
typedef struct nsdae_filter {
  int material, group, exclude;
} nsdae_filter;

/* A solid as the world keeps it: in its body's frame. */
typedef struct nsdae_solid_of {
  int body, shape, hollow, points;
  nsdae_filter filter;
  double radius, half[3]; /* half edges or axes; segment: half[0]; capsule: half[2]; cylinder, cone
                             and disc in space, whose radius is 0: its radius twice, half[2] */
  double size; /* largest distance of its points from its origin, with the rounding; 0 of a plane */
  double width;           /* see sizes.c; INFINITY of a plane and a hole */
  double origin[3], R[9]; /* its frame in the body's; of a plane column 2 is the normal */
  double turn[4];         /* spatial: the same as a unit quaternion; planar: turn[0] the angle */
  double *point;          /* points x 3: its corners in the body's frame; smooth: see feature.c */
  double *edge; /* behind the corners; planar, of more than one corner: points x 4, the outer unit
                   normal of the edge from each corner (3) and its length; spatial: faces x 4, outer
                   unit normal n of each face and n . x of its points */
  const nsdae_hull *hull;        /* spatial, of more than one corner */
  const struct nsdae_mesh *mesh; /* a mesh or height field, which has no corners here */
} nsdae_solid_of;

typedef struct nsdae_feature {
  int number; /* in order among those of the pair */
  int edges;  /* 0: a corner of solid[1] against solid[0]; 1: an edge of each */
  int solid[2];
  int part[2]; /* the corner in part[1]; the edges */
  double mu, e_n, e_t;
} nsdae_feature;

/* Two solids with the poses of their bodies. */
typedef struct nsdae_couple {
  const nsdae_solid_of *solid[2];
  const nsdae_pose *pose[2];
} nsdae_couple;

/* A contact at a moment. */
typedef struct nsdae_touch {
  nsdae_jet gap;
  nsdae_jet3 normal, at[2]; /* n, c_i */
} nsdae_touch;

/* Its values alone, to the last bit those of the jets. */
typedef struct nsdae_still {
  double gap, normal[3], at[2][3]; /* n; c_i */
} nsdae_still;

/* How far two planar solids are apart along the best outer normal of an edge of one, and which
 * edge; of a line also beyond its ends. -INFINITY: has no edges. */
typedef struct nsdae_separation {
  double value, ends;
  int edge;
  double above[3]; /* height of the other's points over that edge: see nsdae_height_above */
} nsdae_separation;

/* above_x p_x + above_y p_y + above_0. No contact of a corner at p is nearer than this height over
 * any edge, the roundings apart. */
static inline double nsdae_height_above(const double *above, const double *p)
{
  return above[0] * p[0] + above[1] * p[1] + above[2];
}

/* The same of two solids in space: see separating_axis.h. Separations are of the cores, negative if
 * they overlap; [s]: along the best outer normal of a face of solid s, -INFINITY if it has none. */
typedef struct nsdae_separating_axis {
  double cosine[9]; /* [3 j + i]: of axis i of solid 0 and axis j of solid 1 */
  double way[2][3]; /* from the origin of solid s to the other's, in its frame */
  double most;      /* along the best axis */
  double face[2];
  int axis[2];          /* that face: across this axis of the box */
  double side[2];       /* on its side 1 or -1 */
  double edges[9];      /* [3 i + j]: along m, axis i of solid 0 x axis j of solid 1 */
  double scale[9];      /* 1 / |m|, negative if m is from 1 to 0; 0: the axes are parallel */
  double slack, beside; /* [m] */
} nsdae_separating_axis;

/* The same if one of them is a polyhedron: see polyhedra.c. */
typedef struct nsdae_polyhedra {
  double turn[2][9], way[2][3]; /* a point p of the other's body is at turn p + way in that of s */
  double most, face[2];
  int best[2]; /* that face */
  double slack, beside;
  unsigned near[2][NSDAE_CORNERS_MAX / 32]; /* bit i % 32 of [s][i / 32]: corner i of solid s may be
                                               within enough of the other */
} nsdae_polyhedra;

/* Contacts of two solids of which one is curved: see manifold.c. */
enum { NSDAE_MANIFOLD = 32 };
typedef struct nsdae_manifold {
  int count, number[NSDAE_MANIFOLD + 1]; /* the last for the nearest points */
  nsdae_still at[NSDAE_MANIFOLD + 1];
} nsdae_manifold;

/* Two solids at a moment, and what all their features go by. Features that can have a gap of at
 * most the reach: bit i of corners[base] for corner i of the other (those from 32 on can); in space
 * bit j of edges[i] for edge i of solid 0 and j of solid 1. Of the 144 pairs of edges of two boxes
 * these are few, for nine directions. */
enum { NSDAE_EDGES_MAX = 12 };
typedef struct nsdae_meeting {
  nsdae_couple two;
  double enough; /* a feature whose cores are apart by more may be left out; INFINITY: none */
  int far;       /* all are */
  int polyhedra; /* which of the union: the third */
  int curved;    /* the last */
  unsigned corners[2], edges[NSDAE_EDGES_MAX];
  union {
    nsdae_separation by[2]; /* in the plane: by edges of each */
    nsdae_separating_axis axis;
    nsdae_polyhedra hulls;
    nsdae_manifold manifold;
  };
} nsdae_meeting;

#endif
