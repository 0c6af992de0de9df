/* Surfaces of triangles that stand still: their triangles, edges and corners, and a tree of boxes.
 *
 *   side k of a triangle runs from its corner k to corner k + 1; a triangle is anticlockwise seen
 *   from outside. Beneath it is material, as deep as the thickness.
 *
 * Neighbours in one plane are one face: nothing is an edge between them. An edge and a corner of
 * the surface touch if they are sharp: not flat, and not in a valley. */
#ifndef NSDAE_BODIES_MESH_H
#define NSDAE_BODIES_MESH_H

#include "narrow_phase.h"

enum { NSDAE_TRIANGLES_MAX = 1 << 24 }; /* sides and nodes have numbers of type int */

typedef struct nsdae_mesh {
  int points, triangles, leaves; /* leaves: a power of two */
  double thickness;
  double rounding;  /* of places on it */
  double flat;      /* how far from a plane the corners of a face are at most */
  double *point;    /* points x 3, in the body's frame */
  double *normal;   /* triangles x 3: outer unit normals */
  double *box;      /* nodes x 6, least and largest coordinates of triangles with their thickness;
                       below node i are 2 i + 1 and 2 i + 2 */
  int (*corner)[3]; /* of each triangle; of points in the same place the first */
  int (*beside)[3]; /* the triangle across side k; -1: none, or several */
  int *face;        /* the first triangle of its face: the plane of that is the face's */
  int *piece;       /* of each point: the first point of what is connected with it */
  int *order;       /* triangles by leaves */
  unsigned short *mark; /* NSDAE_SHARP_SIDE << k and the others */
  int turned[2];        /* two of opposite order along their common side; equal: none */
} nsdae_mesh;

/* Marks of side or corner k; what is sharp has it in one triangle alone. */
enum { NSDAE_SHARP_SIDE = 1, NSDAE_SHARP_CORNER = 8, NSDAE_VALLEY = 64 };

/* Points x 3 and triangles x 3 numbers of points. */
typedef struct nsdae_surface {
  int points, triangles;
  const double *point;
  const int *triangle;
  void *memory;
} nsdae_surface;

/* That of a MESH, or of a HEIGHT_FIELD, which has memory of its own, to be released. Numbers are
 * checked: NSDAE_OK, NSDAE_E_ARGUMENT, NSDAE_E_NONFINITE, NSDAE_E_MEMORY. */
int nsdae_surface_of(const nsdae_solid *solid, nsdae_surface *surface, nsdae_error *error);
void nsdae_surface_release(nsdae_surface *surface);
/* That with its frame in the body's, R and origin. Errors as above. */
int nsdae_mesh_create(const nsdae_surface *surface, double thickness, const double *R,
                      const double *origin, const nsdae_mesh **mesh, nsdae_error *error);
/* The middle of its box, and the largest distance of what it is made of from there. */
void nsdae_mesh_extent(const nsdae_mesh *mesh, double *middle, double *size);
/* Triangles x 9 in the body's frame; their number. */
int nsdae_mesh_triangles(const nsdae_mesh *mesh, double *triangle);
/* Nothing of one that is not made. */
void nsdae_mesh_release(const nsdae_mesh *mesh);

/* Triangles whose boxes meet the box from low to high, until visit returns other than 0, which is
 * returned. */
typedef int (*nsdae_mesh_fn)(void *to, int triangle);
int nsdae_mesh_visit(const nsdae_mesh *mesh, const double *low, const double *high,
                     nsdae_mesh_fn visit, void *to);

/* The same about x. */
int nsdae_mesh_about(const nsdae_mesh *mesh, const double *x, double within, nsdae_mesh_fn visit,
                     void *to);

/* The height of x over the plane of a triangle; how far it is beyond side k, in that plane; whether
 * it is in the material beneath the triangle, or beside it by no more than within. */
double nsdae_mesh_height(const nsdae_mesh *mesh, int triangle, const double *x);
double nsdae_mesh_beyond(const nsdae_mesh *mesh, int triangle, int k, const double *x);
int nsdae_mesh_is_beneath(const nsdae_mesh *mesh, int triangle, const double *x, double within);

static inline const double *nsdae_mesh_corner(const nsdae_mesh *m, int t, int k)
{
  return m->point + 3 * m->corner[t][k % 3];
}

/* Numbers for the parts of a mesh: triangles, sides, points. */
static inline long nsdae_mesh_parts(const nsdae_mesh *m)
{
  return 4L * m->triangles + m->points;
}

/* The contacts of a mesh (solid 0) and another solid whose gap is at most the reach. */
int nsdae_mesh_contacts(const nsdae_couple *two, double reach, nsdae_contact_fn add, void *to);

#endif
