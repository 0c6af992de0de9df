/* The geometries of contact between points, lines and planes that feature.h speaks of. */
#ifndef NSDAE_BODIES_TOUCH_H
#define NSDAE_BODIES_TOUCH_H

#include "feature.h"

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
nsdae_touch nsdae_touch_far(const nsdae_solid_of *s0, const nsdae_solid_of *s1);

/* The contact of a corner of solid s1 against the polygon or rounded segment s0; met is theirs. */
nsdae_touch nsdae_polygon_touch(const nsdae_solid_of *s0, const nsdae_solid_of *s1, int corner,
                                const nsdae_pose *pose0, const nsdae_pose *pose1,
                                const nsdae_meeting *met);

/* The same as it is now, without rates: lists need no more, and want it for every block of many. */
typedef struct nsdae_flat {
  int far;
  double gap, normal[2], at[2][2]; /* n; c_i */
} nsdae_flat;
nsdae_flat nsdae_polygon_flat(const nsdae_solid_of *s0, const nsdae_solid_of *s1, int corner,
                              const nsdae_pose *pose0, const nsdae_pose *pose1,
                              const nsdae_meeting *met);

static inline const double *nsdae_solid_corner(const nsdae_solid_of *s, int i)
{
  return s->point + 3 * i;
}

#endif
