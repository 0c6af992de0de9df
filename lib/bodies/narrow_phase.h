/* Features: the places where two solids can touch, one contact each. A corner of one solid (with
 * its rounding) against the core of the other, the base, or an edge of the one against an edge of
 * the other. Of two solids in their order, corners of the second come first, then those of the
 * first, then edges.
 *
 * A feature has its closest parts: a point against a point, a line or a plane, or a line against a
 * line. They give the gap, the normal n (from 0 to 1, the base is 0) and the two points of contact
 * c_0, c_1, which wander over their bodies; and the jets of all of these:
 *
 *   xi = c'_1 - c'_0 of the material points there:   v_N = n . xi = g',   v_T = t . xi
 *   xi' (with v' = 0) = w_1 x (c'_1 - x'_1(c_1)) - w_0 x (c'_0 - x'_0(c_0)) with x'_i the velocity
 * of the body's material point and c'_i that of the place */
#ifndef NSDAE_BODIES_NARROW_PHASE_H
#define NSDAE_BODIES_NARROW_PHASE_H

#include "solid.h"

/* What is closest to what. */
enum {
  NSDAE_POINT_POINT,
  NSDAE_LINE_POINT,
  NSDAE_PLANE_POINT,
  NSDAE_LINE_LINE,
  NSDAE_ELLIPSOID_POINT, /* the ellipsoid about x_0 */
  NSDAE_PLANE_ELLIPSOID, /* that about x_1 */
  NSDAE_SIDE_POINT       /* the side of the cone or cylinder with the base about x_0 */
};

/* The closest parts, each in its body's frame: points, unit vectors along lines and the unit normal
 * of a plane (u_0), roundings. half: half axes of an ellipsoid along those of its solid, the last
 * may be 0: a disc; of a side the radius, by how much it decreases up to the top, and the height.
 */
typedef struct nsdae_closest {
  int kind;
  double side; /* -1: x_0 is a hole's centre; two lines: n is along -(u_0 x u_1) */
  double radius[2], x[2][3], u[2][3];
  double half[3];
} nsdae_closest;

/* The contact of them, and its values alone. */
nsdae_touch nsdae_closest_touch(const nsdae_closest *closest, const nsdae_couple *two);
nsdae_still nsdae_closest_still(const nsdae_closest *closest, const nsdae_couple *two);

static inline const double *nsdae_solid_corner(const nsdae_solid_of *s, int i)
{
  return s->point + 3 * i;
}

/* Whether its surface is curved other than by a rounding. */
static inline int nsdae_solid_is_smooth(const nsdae_solid_of *s)
{
  return s->shape == NSDAE_SHAPE_CYLINDER || s->shape == NSDAE_SHAPE_CONE ||
         s->shape == NSDAE_SHAPE_ELLIPSOID || (s->shape == NSDAE_SHAPE_DISC && s->points > 1);
}

/* Flat and straight parts of two solids touch along each other up to a tilt of this sine; beyond it
 * they only graze. Their gap is there already the sine times their length; a body that turns by
 * 10 rad/s tilts by a fifth of it in a step of 2 ms. Piles of tests/system/pairs.c rest with 0.03,
 * 0.1 and 0.3; without a bound one keeps moving. */
#define NSDAE_TILT 0.1

/* "disc", "box" */
const char *nsdae_solid_name(int shape);
/* What is wrong with a solid's own numbers, into the record. */
int nsdae_solid_check(const nsdae_solid *solid, nsdae_error *error);

/* The number of edges of a solid (in space). */
static inline int nsdae_solid_edges(const nsdae_solid_of *solid)
{
  return solid->hull ? solid->hull->edges : 0;
}

/* Two solids in the order of nsdae_pair_features whose gaps of at most reach are asked for. */
void nsdae_meet(const nsdae_couple *two, double reach, nsdae_meeting *met);

/* The separations of two planar solids, and the closest parts of a corner and the polygon or
 * rounded segment base, 0 or 1 of the meeting: see nsdae_feature_closest. */
void nsdae_find_separations(nsdae_meeting *met);
int nsdae_polygon_closest(const nsdae_meeting *met, int base, int corner, nsdae_closest *closest);

/* The separating axis of two solids with edges of which one is a polyhedron, and their features. */
void nsdae_find_polyhedra(nsdae_meeting *met);
int nsdae_polyhedra_near(const nsdae_meeting *met, const nsdae_feature *feature);
/* Those edges k of solid 0 and l of solid 1 that may touch, in order, until visit returns < 0. */
typedef int (*nsdae_edges_fn)(void *to, int k, int l);
int nsdae_polyhedra_each(const nsdae_meeting *met, nsdae_edges_fn visit, void *to);
int nsdae_polyhedra_edges(const nsdae_meeting *met, const nsdae_feature *feature,
                          nsdae_closest *closest);
/* The closest parts of a polyhedron, base 0 or 1 of the meeting, and a point of the frame of its
 * body. */
int nsdae_polyhedron_closest(const nsdae_meeting *met, int base, const double *x,
                             nsdae_closest *closest);

/* The closest parts of a smooth shape (solid 0) and a point of the frame of the body of solid 1. */
void nsdae_point_on_smooth(const nsdae_couple *two, const double *x, nsdae_closest *closest);
/* A corner of a smooth shape (solid 1: see feature.c) on a plane with the normal u_0: the kind of
 * the contact and half axes. 0: it does not touch. */
int nsdae_smooth_on_plane(const nsdae_couple *two, int corner, nsdae_closest *closest);

/* Whether the contacts of two shapes have all their rates: by every method. Else a manifold. */
int nsdae_pair_is_exact(const nsdae_solid_of *solid0, const nsdae_solid_of *solid1);

/* Contacts of two solids of which one is curved, and the parts of one of them: a point on a plane
 * of body 0, for its value alone, as the rates of the plane are not known. 0: the solids are
 * further apart than enough; it is not among them. */
int nsdae_find_manifold(const nsdae_couple *two, double enough, nsdae_manifold *manifold);
int nsdae_manifold_closest(const nsdae_meeting *met, int number, nsdae_closest *closest);

/* A contact of two solids: its number, its closest parts and the solids in their order. */
typedef int (*nsdae_contact_fn)(void *to, long number, const nsdae_closest *closest,
                                const nsdae_couple *two);

/* The closest parts of a feature of two solids that met, and these with the base first. 0: another
 * feature is nearer, or the gap is larger than the reach; there are none then. */
int nsdae_feature_closest(const nsdae_feature *feature, const nsdae_meeting *met,
                          nsdae_closest *closest);
nsdae_couple nsdae_feature_couple(const nsdae_feature *feature, const nsdae_meeting *met);

#endif
