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
#ifndef NSDAE_BODIES_NARROW_PHASE_H
#define NSDAE_BODIES_NARROW_PHASE_H

#include "solid.h"

/* n and g of a distance vector d; side = -1 where the solid lies outside. */
nsdae_jet3 nsdae_direction(nsdae_jet3 d, double side, nsdae_jet *length);

/* A point x_1 with the rounding r_1 against a point with the rounding r_0 (side -1: a hole), a line
 * along the unit vector u, a plane with the unit normal n. */
nsdae_touch nsdae_touch_point_point(nsdae_jet3 x0, double r0, double side, nsdae_jet3 x1,
                                    double r1);
nsdae_touch nsdae_touch_line_point(nsdae_jet3 x0, nsdae_jet3 u, double r0, nsdae_jet3 x1,
                                   double r1);
nsdae_touch nsdae_touch_plane_point(nsdae_jet3 x0, nsdae_jet3 n, nsdae_jet3 x1, double r1);

/* A contact that another feature stands for: the gap is constant; it has no places and directions.
 */
nsdae_touch nsdae_touch_far(const nsdae_couple *two);

/* Whether a solid of the plane has edges that can separate: a segment without rounding is a side.
 */
int nsdae_has_edges(const nsdae_solid_of *solid);

/* The meeting of two planar solids. */
nsdae_meeting nsdae_find_meeting(const nsdae_couple *two, double enough);

/* The contact of a corner of solid 1 against the polygon or rounded segment 0; met is theirs. */
nsdae_touch nsdae_polygon_touch(const nsdae_couple *two, int corner, const nsdae_meeting *met);

/* A contact as it is now, without rates: lists need no more, and want it for each of many. Values
 * are those of the jets, to the last bit. */
typedef struct nsdae_still {
  int far;
  double gap, normal[3], at[2][3]; /* n; c_i */
} nsdae_still;

nsdae_still nsdae_still_of(const nsdae_touch *touch);
/* As nsdae_touch_point_point, and nsdae_touch_plane_point with the normal that is set. */
void nsdae_still_point(nsdae_still *still, const double *x0, double r0, double side,
                       const double *x1, double r1);
void nsdae_still_plane(nsdae_still *still, const double *x0, const double *x1, double r1);
/* The corner of solid 1 against what is round or a hole, solid 0; as nsdae_polygon_touch. */
nsdae_still nsdae_round_still(const nsdae_couple *two, int corner);
nsdae_still nsdae_polygon_still(const nsdae_couple *two, int corner, const nsdae_meeting *met);

/* x := r + R s */
static inline void nsdae_pose_put(const nsdae_pose *pose, const double *s, double *x)
{
  nsdae_turn(pose->R, s, x);
  for (int i = 0; i < 3; i++) x[i] += pose->r[i];
}

static inline const double *nsdae_solid_corner(const nsdae_solid_of *s, int i)
{
  return s->point + 3 * i;
}

/* "disc", "box" */
const char *nsdae_solid_name(int shape);

/* The number of edges of a solid (in space). */
int nsdae_solid_edges(const nsdae_solid_of *solid);
/* The edges of two solids that can be the nearest of both. */
void nsdae_find_facing(const nsdae_couple *two, nsdae_facing *facing);

/* The contact of a feature between two solids, in its order. */
nsdae_touch nsdae_feature_touch(const nsdae_feature *feature, const nsdae_couple *two);

#endif
