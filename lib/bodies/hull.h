/* Convex polyhedra: corners, faces and edges of the hull of points.
 *
 *   edge e runs from corner edge[e][0] to edge[e][1]; seen from outside face edge[e][2] is on its
 *   left and edge[e][3] on its right.   Euler: corners - edges + faces = 2 */
#ifndef NSDAE_BODIES_HULL_H
#define NSDAE_BODIES_HULL_H

#include <nsdae/status.h>

enum { NSDAE_CORNERS_MAX = 1024 }; /* a pair of edges has a number below 3 * 1024 squared */

typedef struct nsdae_hull {
  int corners, faces, edges;
  double *corner; /* corners x 3; NULL of a box and a capsule */
  int *first;     /* faces + 1: where the corners of face f begin in ring */
  int *ring;      /* corners of each face, anticlockwise seen from outside */
  int (*edge)[4];
} nsdae_hull;

/* Of a box (corner i at the side bit j of i along axis j) and of the segment of a capsule. */
extern const nsdae_hull nsdae_box_hull, nsdae_capsule_hull;

/* The hull of points x 3, made by Qhull. NSDAE_E_ARGUMENT, NSDAE_E_NONFINITE, NSDAE_E_MEMORY,
 * NSDAE_E_UNSUPPORTED: the library was built without it. */
int nsdae_hull_create(int points, const double *point, const nsdae_hull **hull, nsdae_error *error);
/* Nothing of one that is not made. */
void nsdae_hull_release(const nsdae_hull *hull);

/* The outer unit normal of a face with these corners x 3; 0: it has no area. */
int nsdae_hull_normal(const nsdae_hull *hull, const double *corner, int face, double normal[3]);

/* Triangles x 9 of the faces of a hull with these corners x 3, each face from its first corner;
 * their number, 2 corners - 4. */
int nsdae_hull_triangles(const nsdae_hull *hull, const double *corner, double *triangle);

/* One to be filled: corners, first and ring. NULL: no memory. Then its edges are found and it is
 * checked: NSDAE_E_ARGUMENT if it is no convex polyhedron. */
nsdae_hull *nsdae_hull_new(int corners, int faces, int sides);
int nsdae_hull_close(nsdae_hull *hull, nsdae_error *error);

#endif
