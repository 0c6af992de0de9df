#include "narrow_phase.h"

#include <string.h>

/* n and g of a distance vector d; side = -1 where the solid lies outside. With d = 0 any direction
 * is as good as another. */
static inline nsdae_jet3 direction(nsdae_jet3 d, double side, nsdae_jet *length)
{
  const double x[3] = {side, 0, 0};
  nsdae_jet square = nsdae_jet3_dot(d, d);
  if (square.x == 0) {
    *length = nsdae_jet_of(0);
    return nsdae_jet3_of(x);
  }
  *length = nsdae_jet_sqrt(square);
  return nsdae_jet3_scale(side, nsdae_jet3_times(nsdae_jet_inverse(*length), d));
}

/* x_0 rounded by r_0 (side -1: a hole of that radius), x_1 by r_1:
 * g = side (|x_1 - x_0| - r_0) - r_1,  n = side (x_1 - x_0) / |x_1 - x_0| */
static inline nsdae_touch point_point(nsdae_jet3 x0, double r0, double side, nsdae_jet3 x1,
                                      double r1)
{
  nsdae_touch touch;
  nsdae_jet length;
  touch.normal = direction(nsdae_jet3_sub(x1, x0), side, &length);
  touch.gap = nsdae_jet_scale(side, length);
  touch.gap.x -= side * r0 + r1;
  touch.at[0] = nsdae_jet3_add(x0, nsdae_jet3_scale(side * r0, touch.normal));
  touch.at[1] = nsdae_jet3_sub(x1, nsdae_jet3_scale(r1, touch.normal));
  return touch;
}

/* The plane through x_0 with the unit normal n: g = n . (x_1 - x_0) - r_1 */
static inline nsdae_touch plane_point(nsdae_jet3 x0, nsdae_jet3 n, nsdae_jet3 x1, double r1)
{
  nsdae_jet height = nsdae_jet3_dot(n, nsdae_jet3_sub(x1, x0));
  nsdae_touch touch = {.gap = height, .normal = n};
  touch.gap.x -= r1;
  touch.at[0] = nsdae_jet3_sub(x1, nsdae_jet3_times(height, n));
  touch.at[1] = nsdae_jet3_sub(x1, nsdae_jet3_scale(r1, n));
  return touch;
}

/* Two lines through x_i along unit vectors u_i, with d = x_1 - x_0 and m = u_0 x u_1:
 * a = m . (d x u_1) / m^2,  b = m . (d x u_0) / m^2 are the places of their nearest points along
 * u_0 and u_1;  n = side m / |m|. (Written with scalar products alone the same cancels where the
 * lines are near parallel, as the square of their angle.) */
static inline nsdae_touch line_line(const nsdae_jet3 x[2], const nsdae_jet3 u[2], double side,
                                    const double r[2])
{
  nsdae_touch touch;
  nsdae_jet3 d = nsdae_jet3_sub(x[1], x[0]), m = nsdae_jet3_cross(u[0], u[1]);
  nsdae_jet square = nsdae_jet3_dot(m, m), inverse = nsdae_jet_inverse(square);
  nsdae_jet a = nsdae_jet_mul(inverse, nsdae_jet3_dot(m, nsdae_jet3_cross(d, u[1])));
  nsdae_jet b = nsdae_jet_mul(inverse, nsdae_jet3_dot(m, nsdae_jet3_cross(d, u[0])));
  nsdae_jet3 n =
      nsdae_jet3_scale(side, nsdae_jet3_times(nsdae_jet_inverse(nsdae_jet_sqrt(square)), m));
  nsdae_jet3 x0 = nsdae_jet3_add(x[0], nsdae_jet3_times(a, u[0]));
  nsdae_jet3 x1 = nsdae_jet3_add(x[1], nsdae_jet3_times(b, u[1]));
  touch.gap = nsdae_jet3_dot(n, d);
  touch.gap.x -= r[0] + r[1];
  touch.normal = n;
  touch.at[0] = nsdae_jet3_add(x0, nsdae_jet3_scale(r[0], n));
  touch.at[1] = nsdae_jet3_sub(x1, nsdae_jet3_scale(r[1], n));
  return touch;
}

/* ---- rims of cylinders
 *
 * The circle of radius r about x across the unit vector a. Its point foremost along d is at
 *
 *   x + r w / |w|,  w = d - (d . a) a
 *
 * If a is along d up to 1e-10 all are as near: w is then a direction of the body. */
static const double along_axis = 1e-20;

/* A direction across the axis of the rim of body i. */
static void across_rim(const nsdae_closest *c, int i, double *across)
{
  double other[3];
  nsdae_complete_frame(c->u[i], across, other);
}

static nsdae_jet3 rim_point(const nsdae_closest *c, const nsdae_couple *two, int i, nsdae_jet3 x,
                            nsdae_jet3 d, double r)
{
  nsdae_jet3 a = nsdae_pose_direction(two->pose[i], c->u[i]);
  nsdae_jet3 w = nsdae_jet3_sub(d, nsdae_jet3_times(nsdae_jet3_dot(d, a), a));
  nsdae_jet square = nsdae_jet3_dot(w, w);
  if (square.x < along_axis * nsdae_jet3_dot(d, d).x) {
    double across[3];
    across_rim(c, i, across);
    return nsdae_jet3_add(x, nsdae_jet3_scale(r, nsdae_pose_direction(two->pose[i], across)));
  }
  w = nsdae_jet3_times(nsdae_jet_inverse(nsdae_jet_sqrt(square)), w);
  return nsdae_jet3_add(x, nsdae_jet3_scale(r, w));
}

nsdae_touch nsdae_closest_touch(const nsdae_closest *c, const nsdae_couple *two)
{
  nsdae_jet3 x[2], u[2];
  for (int i = 0; i < 2; i++) x[i] = nsdae_pose_point(two->pose[i], c->x[i]);
  if (c->kind == NSDAE_POINT_POINT)
    return point_point(x[0], c->radius[0], c->side, x[1], c->radius[1]);
  if (c->kind == NSDAE_RIM_POINT) {
    x[0] = rim_point(c, two, 0, x[0], nsdae_jet3_sub(x[1], x[0]), c->radius[0]);
    return point_point(x[0], 0, 1, x[1], c->radius[1]);
  }
  u[0] = nsdae_pose_direction(two->pose[0], c->u[0]);
  if (c->kind == NSDAE_PLANE_POINT) return plane_point(x[0], u[0], x[1], c->radius[1]);
  if (c->kind == NSDAE_PLANE_RIM) {
    x[1] = rim_point(c, two, 1, x[1], u[0], -c->radius[1]);
    return plane_point(x[0], u[0], x[1], 0);
  }
  if (c->kind == NSDAE_LINE_LINE) {
    u[1] = nsdae_pose_direction(two->pose[1], c->u[1]);
    return line_line(x, u, c->side, c->radius);
  }
  /* from the foot x_0 + (u . d) u */
  nsdae_jet s = nsdae_jet3_dot(u[0], nsdae_jet3_sub(x[1], x[0]));
  x[0] = nsdae_jet3_add(x[0], nsdae_jet3_times(s, u[0]));
  return point_point(x[0], c->radius[0], c->side, x[1], c->radius[1]);
}

/* ---- values alone, in the order of operations of the jets */

/* The places on the lines that are nearest to each other become x; n. */
static void still_lines(double x[2][3], double u[2][3], double side, const double *d, double *n)
{
  double m[3], e[3];
  nsdae_cross3(u[0], u[1], m);
  double square = nsdae_dot3(m, m), inverse = 1 / square, length = 1 / sqrt(square);
  for (int i = 0; i < 2; i++) {
    nsdae_cross3(d, u[1 - i], e);
    double along = inverse * nsdae_dot3(m, e);
    for (int j = 0; j < 3; j++) x[i][j] += along * u[i][j];
  }
  for (int j = 0; j < 3; j++) n[j] = side * (length * m[j]);
}

/* x := the point of the rim of body i. */
static void still_rim(const nsdae_closest *c, const nsdae_couple *two, int i, const double *d,
                      double r, double *x)
{
  double a[3], across[3], w[3];
  nsdae_turn(two->pose[i]->R, c->u[i], a);
  double part = nsdae_dot3(d, a);
  for (int j = 0; j < 3; j++) w[j] = d[j] - part * a[j];
  double square = nsdae_dot3(w, w), inverse = 1 / sqrt(square);
  if (square < along_axis * nsdae_dot3(d, d)) {
    across_rim(c, i, across);
    nsdae_turn(two->pose[i]->R, across, w);
    inverse = 1;
  }
  for (int j = 0; j < 3; j++) x[j] += r * (inverse * w[j]);
}

nsdae_still nsdae_closest_still(const nsdae_closest *c, const nsdae_couple *two)
{
  nsdae_still s;
  int rim = c->kind == NSDAE_PLANE_RIM, plane = c->kind == NSDAE_PLANE_POINT || rim;
  int lines = c->kind == NSDAE_LINE_LINE, round = c->kind == NSDAE_RIM_POINT;
  double r0 = round ? 0 : c->radius[0], r1 = rim ? 0 : c->radius[1];
  double x[2][3], u[2][3], d[3], *n = s.normal;
  for (int i = 0; i < 2; i++) {
    nsdae_pose_put(two->pose[i], c->x[i], x[i]);
    if (i == 0 ? c->kind != NSDAE_POINT_POINT : lines) nsdae_turn(two->pose[i]->R, c->u[i], u[i]);
  }
  if (rim) still_rim(c, two, 1, u[0], -c->radius[1], x[1]);
  for (int j = 0; j < 3; j++) d[j] = x[1][j] - x[0][j];
  if (round) still_rim(c, two, 0, d, c->radius[0], x[0]);
  for (int j = 0; j < 3 && round; j++) d[j] = x[1][j] - x[0][j];
  if (c->kind == NSDAE_LINE_POINT) {
    double along = nsdae_dot3(u[0], d);
    for (int j = 0; j < 3; j++) x[0][j] += along * u[0][j];
    for (int j = 0; j < 3; j++) d[j] = x[1][j] - x[0][j];
  }
  if (lines) still_lines(x, u, c->side, d, n);
  if (plane) memcpy(n, u[0], sizeof s.normal);
  if (plane || lines) {
    double height = nsdae_dot3(n, d);
    if (plane) r0 = 0;
    s.gap = height - (r0 + r1);
    for (int j = 0; j < 3; j++) s.at[0][j] = plane ? x[1][j] - height * n[j] : x[0][j] + r0 * n[j];
  } else {
    double square = nsdae_dot3(d, d), length = sqrt(square), inverse = 1 / length;
    for (int j = 0; j < 3; j++) n[j] = square == 0 ? 0 : c->side * (inverse * d[j]);
    if (square == 0) n[0] = c->side;
    s.gap = c->side * length - (c->side * r0 + r1);
    for (int j = 0; j < 3; j++) s.at[0][j] = x[0][j] + c->side * r0 * n[j];
  }
  for (int j = 0; j < 3; j++) s.at[1][j] = x[1][j] - r1 * n[j];
  return s;
}
