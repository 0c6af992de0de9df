#include "narrow_phase.h"

/* n and g of a distance vector d; side = -1 where the solid lies outside. With d = 0 any direction
 * is as good as another. */
nsdae_jet3 nsdae_direction(nsdae_jet3 d, double side, nsdae_jet *length)
{
  const double x[3] = {side, 0, 0};
  if (nsdae_jet3_dot(d, d).x == 0) {
    *length = nsdae_jet_of(0);
    return nsdae_jet3_of(x);
  }
  *length = nsdae_jet3_length(d);
  return nsdae_jet3_scale(side, nsdae_jet3_times(nsdae_jet_inverse(*length), d));
}

/* x_0 rounded by r_0 (side -1: a hole of that radius), x_1 by r_1:
 * g = side (|x_1 - x_0| - r_0) - r_1,  n = side (x_1 - x_0) / |x_1 - x_0| */
nsdae_touch nsdae_touch_point_point(nsdae_jet3 x0, double r0, double side, nsdae_jet3 x1, double r1)
{
  nsdae_touch touch = {.far = 0};
  nsdae_jet length;
  touch.normal = nsdae_direction(nsdae_jet3_sub(x1, x0), side, &length);
  touch.gap = nsdae_jet_scale(side, length);
  touch.gap.x -= side * r0 + r1;
  touch.at[0] = nsdae_jet3_add(x0, nsdae_jet3_scale(side * r0, touch.normal));
  touch.at[1] = nsdae_jet3_sub(x1, nsdae_jet3_scale(r1, touch.normal));
  return touch;
}

/* The line through x_0 along the unit vector u: from its foot f = x_0 + (u . d) u, d = x_1 - x_0 */
nsdae_touch nsdae_touch_line_point(nsdae_jet3 x0, nsdae_jet3 u, double r0, nsdae_jet3 x1, double r1)
{
  nsdae_jet s = nsdae_jet3_dot(u, nsdae_jet3_sub(x1, x0));
  return nsdae_touch_point_point(nsdae_jet3_add(x0, nsdae_jet3_times(s, u)), r0, 1, x1, r1);
}

/* The plane through x_0 with the unit normal n: g = n . (x_1 - x_0) - r_1 */
nsdae_touch nsdae_touch_plane_point(nsdae_jet3 x0, nsdae_jet3 n, nsdae_jet3 x1, double r1)
{
  nsdae_jet height = nsdae_jet3_dot(n, nsdae_jet3_sub(x1, x0));
  nsdae_touch touch = {.gap = height, .normal = n};
  touch.gap.x -= r1;
  touch.at[0] = nsdae_jet3_sub(x1, nsdae_jet3_times(height, n));
  touch.at[1] = nsdae_jet3_sub(x1, nsdae_jet3_scale(r1, n));
  return touch;
}

nsdae_touch nsdae_touch_far(const nsdae_couple *two)
{
  return (nsdae_touch){.far = 1, .gap = nsdae_jet_of(two->solid[0]->size + two->solid[1]->size)};
}

nsdae_still nsdae_still_of(const nsdae_touch *touch)
{
  nsdae_still still = {.far = touch->far, .gap = touch->gap.x};
  nsdae_jet3_values(touch->normal, still.normal);
  for (int j = 0; j < 2; j++) nsdae_jet3_values(touch->at[j], still.at[j]);
  return still;
}

void nsdae_still_point(nsdae_still *still, const double *x0, double r0, double side,
                       const double *x1, double r1)
{
  double *n = still->normal;
  const double d[3] = {x1[0] - x0[0], x1[1] - x0[1], x1[2] - x0[2]};
  double length = sqrt(nsdae_dot3(d, d)), inverse = length > 0 ? 1 / length : 0;
  for (int i = 0; i < 3; i++) n[i] = side * (inverse * d[i]);
  if (!(length > 0)) n[0] = side;
  still->gap = side * length - (side * r0 + r1);
  for (int i = 0; i < 3; i++) {
    still->at[0][i] = x0[i] + side * r0 * n[i];
    still->at[1][i] = x1[i] - r1 * n[i];
  }
}

void nsdae_still_plane(nsdae_still *still, const double *x0, const double *x1, double r1)
{
  const double d[3] = {x1[0] - x0[0], x1[1] - x0[1], x1[2] - x0[2]}, *n = still->normal;
  double height = nsdae_dot3(n, d);
  still->gap = height - r1;
  for (int i = 0; i < 3; i++) {
    still->at[0][i] = x1[i] - height * n[i];
    still->at[1][i] = x1[i] - r1 * n[i];
  }
}

nsdae_still nsdae_round_still(const nsdae_couple *two, int corner)
{
  const nsdae_solid_of *s0 = two->solid[0], *s1 = two->solid[1];
  nsdae_still still = {.far = 0};
  double x0[3], x1[3];
  nsdae_pose_put(two->pose[0], s0->origin, x0);
  nsdae_pose_put(two->pose[1], nsdae_solid_corner(s1, corner), x1);
  nsdae_still_point(&still, x0, s0->radius, s0->hollow ? -1 : 1, x1, s1->radius);
  return still;
}
