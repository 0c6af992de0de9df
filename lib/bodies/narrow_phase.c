#include "narrow_phase.h"

#include <float.h>
#include <string.h>

/* Unit vectors that points in one place have as a normal: any, and any across a line along u. */
static const double any[3] = {1, 0, 0};

static void across_line(const double *u, double n[3])
{
  const double up[3] = {0, 0, 1}; /* of a line in the plane the normal is in it too */
  nsdae_cross3(up, u, n);
  if (!nsdae_unit_vector(n, n)) memcpy(n, any, sizeof any);
}

/* n and g of a distance vector d; side = -1 where the solid lies outside. zero: n where d = 0. */
static inline nsdae_jet3 direction(nsdae_jet3 d, double side, const double *zero, nsdae_jet *length)
{
  nsdae_jet square = nsdae_jet3_dot(d, d);
  if (square.x == 0) {
    *length = nsdae_jet_of(0);
    return nsdae_jet3_scale(side, nsdae_jet3_of(zero));
  }
  *length = nsdae_jet_sqrt(square);
  return nsdae_jet3_scale(side, nsdae_jet3_times(nsdae_jet_inverse(*length), d));
}

/* x_0 rounded by r_0 (side -1: a hole of that radius), x_1 by r_1; d = x_1 - x_0:
 * g = side (|d| - r_0) - r_1,  n = side d / |d| */
static inline nsdae_touch touch_along(nsdae_jet3 x0, double r0, double side, nsdae_jet3 x1,
                                      double r1, nsdae_jet3 d, const double *zero)
{
  nsdae_touch touch;
  nsdae_jet length;
  touch.normal = direction(d, side, zero, &length);
  touch.gap = nsdae_jet_scale(side, length);
  touch.gap.x -= side * r0 + r1;
  touch.at[0] = nsdae_jet3_add(x0, nsdae_jet3_scale(side * r0, touch.normal));
  touch.at[1] = nsdae_jet3_sub(x1, nsdae_jet3_scale(r1, touch.normal));
  return touch;
}

static inline nsdae_touch point_point(nsdae_jet3 x0, double r0, double side, nsdae_jet3 x1,
                                      double r1)
{
  return touch_along(x0, r0, side, x1, r1, nsdae_jet3_sub(x1, x0), any);
}

/* The line through x_0 along the unit vector u: from the foot x_0 + (u . d) u. What rounding leaves
 * of u . d is taken off again, or it is the direction of a point within rounding of the line. */
static inline nsdae_touch line_point(nsdae_jet3 x0, nsdae_jet3 u, double r0, double side,
                                     nsdae_jet3 x1, double r1)
{
  const double value[3] = {u.at[0].x, u.at[1].x, u.at[2].x};
  double across[3];
  nsdae_jet3 d = nsdae_jet3_sub(x1, x0);
  for (int pass = 0; pass < 2; pass++) {
    nsdae_jet3 along = nsdae_jet3_times(nsdae_jet3_dot(u, d), u);
    x0 = nsdae_jet3_add(x0, along);
    d = nsdae_jet3_sub(d, along);
  }
  across_line(value, across);
  return touch_along(x0, r0, side, x1, r1, d, across);
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

/* ---- ellipsoids of the half axes a_k along unit vectors u_k, the last of which may be 0
 *
 * A disc is flat one, and a rim its edge. With D = diag(a_k) the point foremost along d is at
 *
 *   x + D^2 d / |D d|
 *
 * If d is across a disc up to 1e-10 all its points are as near: it is the one along u_0 then. */
static const double across_disc = 1e-20;

static nsdae_jet3 foremost(const double *half, const nsdae_pose *pose, const double *R,
                           nsdae_jet3 x, nsdae_jet3 d)
{
  nsdae_jet3 sum = {{{0, 0, 0}}};
  nsdae_jet square = nsdae_jet_of(0);
  for (int k = 0; k < 3; k++) {
    nsdae_jet3 u = nsdae_pose_direction(pose, R + 3 * k);
    nsdae_jet along = nsdae_jet3_dot(d, u), scaled = nsdae_jet_scale(half[k] * half[k], along);
    sum = nsdae_jet3_add(sum, nsdae_jet3_times(scaled, u));
    square = nsdae_jet_add(square, nsdae_jet_mul(scaled, along));
  }
  if (square.x < across_disc * half[0] * half[0])
    return nsdae_jet3_add(x, nsdae_jet3_scale(half[0], nsdae_pose_direction(pose, R)));
  return nsdae_jet3_add(x, nsdae_jet3_times(nsdae_jet_inverse(nsdae_jet_sqrt(square)), sum));
}

/* The point z of the surface that is the nearest to y (D. Eberly, Distance from a point to an
 * ellipse, an ellipsoid, or a hyperellipsoid, 2013):
 *
 *   z_k = a_k^2 y_k / (t + a_k^2),   F(t) = sum_k (a_k y_k / (t + a_k^2))^2 - 1 = 0
 *
 * for the largest root t. The unknown is s = t + a_m^2 with the least half axis a_m, the sum
 * b_k = a_k^2 - a_m^2 with it cancels nothing. 1 / sqrt(F + 1) is concave and increases in s > 0
 * (Conn, Gould, Toint, Trust-region methods, 2000, lemma 7.3.1), so Newton's iterates increase up
 * to the root once they are before it, as where one term alone is 1. They end where rounding does
 * not let them increase. */
static double secular_root(const double *half, const double *b, const double *y)
{
  double s = 0;
  for (int k = 0; k < 3; k++)
    if (half[k] > 0) s = fmax(s, half[k] * fabs(y[k]) - b[k]);
  for (;;) {
    double sum = 0, slope = 0;
    for (int k = 0; k < 3; k++) {
      if (!(half[k] > 0)) continue;
      double part = half[k] * y[k] / (s + b[k]);
      sum += part * part;
      slope += part * part / (s + b[k]);
    }
    double next = s + (sqrt(sum) - 1) * sum / slope;
    if (!(next > s)) return s;
    s = next;
  }
}

/* Its jet: each Newton step with the derivative at the value alone makes one order of it exact.
 * w_k = y_k / (t + a_k^2), and these are along the normal. On the plane of symmetry across the
 * least axis both sides may be as near: it is one of them. */
static void nearest_on_ellipsoid(const double *half, nsdae_jet y[3], nsdae_jet w[3])
{
  int least = half[1] < half[0];
  if (half[2] < half[least]) least = 2;
  double value[3], b[3];
  if (fabs(y[least].x) < DBL_EPSILON * half[least])
    y[least].x = copysign(DBL_EPSILON * half[least], y[least].x);
  for (int k = 0; k < 3; k++) {
    value[k] = y[k].x;
    b[k] = (half[k] - half[least]) * (half[k] + half[least]);
  }
  nsdae_jet s = nsdae_jet_of(secular_root(half, b, value));
  for (int order = 0;; order++) {
    nsdae_jet F = nsdae_jet_of(-1);
    double slope = 0;
    for (int k = 0; k < 3; k++) {
      nsdae_jet sum = s;
      sum.x += b[k];
      w[k] = half[k] > 0 ? nsdae_jet_mul(y[k], nsdae_jet_inverse(sum)) : nsdae_jet_of(0);
      nsdae_jet square = nsdae_jet_scale(half[k] * half[k], nsdae_jet_mul(w[k], w[k]));
      F = nsdae_jet_add(F, square);
      if (half[k] > 0) slope += 2 * square.x / sum.x;
    }
    if (order == 2) return;
    s.d += F.d / slope;
    s.dd += F.dd / slope;
  }
}

/* The axes u of solid 0, and the coordinates y of d along them. */
static void along_axes(const nsdae_couple *two, nsdae_jet3 d, nsdae_jet3 u[3], nsdae_jet y[3])
{
  for (int k = 0; k < 3; k++) {
    u[k] = nsdae_pose_direction(two->pose[0], two->solid[0]->R + 3 * k);
    y[k] = nsdae_jet3_dot(d, u[k]);
  }
}

/* n is along sum_k w_k u_k; of a disc, outside its rim, along x_1 - z. */
static nsdae_touch ellipsoid_point(const nsdae_closest *c, const nsdae_couple *two, nsdae_jet3 x0,
                                   nsdae_jet3 x1)
{
  nsdae_jet3 u[3], z = x0, normal = {{{0, 0, 0}}};
  nsdae_jet y[3], w[3], length;
  along_axes(two, nsdae_jet3_sub(x1, x0), u, y);
  nearest_on_ellipsoid(c->half, y, w);
  for (int k = 0; k < 3; k++) {
    nsdae_jet3 part = nsdae_jet3_times(w[k], u[k]);
    z = nsdae_jet3_add(z, nsdae_jet3_scale(c->half[k] * c->half[k], part));
    normal = nsdae_jet3_add(normal, part);
  }
  if (c->half[2] == 0) return point_point(z, 0, 1, x1, c->radius[1]);
  return plane_point(z, direction(normal, 1, any, &length), x1, c->radius[1]);
}

/* The side of a cone, or of a cylinder, touches as its tangent plane does: with e across the axis
 * u_2 to the point, the radius r at the base x_0, and i less of it at the height h above that,
 *
 *   n = (h e + i u_2) / sqrt(h^2 + i^2),  through x_0 + r e */
static nsdae_touch side_point(const nsdae_closest *c, const nsdae_couple *two, nsdae_jet3 x0,
                              nsdae_jet3 x1)
{
  double r = c->half[0], i = c->half[1], h = c->half[2], side = hypot(h, i);
  nsdae_jet3 u[3];
  nsdae_jet y[3], length;
  along_axes(two, nsdae_jet3_sub(x1, x0), u, y);
  nsdae_jet3 across = nsdae_jet3_add(nsdae_jet3_times(y[0], u[0]), nsdae_jet3_times(y[1], u[1]));
  nsdae_jet3 e = direction(across, 1, any, &length);
  if (length.x == 0) e = u[0];
  nsdae_jet3 n = nsdae_jet3_add(nsdae_jet3_scale(h / side, e), nsdae_jet3_scale(i / side, u[2]));
  return plane_point(nsdae_jet3_add(x0, nsdae_jet3_scale(r, e)), n, x1, c->radius[1]);
}

nsdae_touch nsdae_closest_touch(const nsdae_closest *c, const nsdae_couple *two)
{
  nsdae_jet3 x[2], u[2];
  for (int i = 0; i < 2; i++) x[i] = nsdae_pose_point(two->pose[i], c->x[i]);
  if (c->kind == NSDAE_POINT_POINT)
    return point_point(x[0], c->radius[0], c->side, x[1], c->radius[1]);
  if (c->kind == NSDAE_ELLIPSOID_POINT) return ellipsoid_point(c, two, x[0], x[1]);
  if (c->kind == NSDAE_SIDE_POINT) return side_point(c, two, x[0], x[1]);
  u[0] = nsdae_pose_direction(two->pose[0], c->u[0]);
  if (c->kind == NSDAE_PLANE_POINT) return plane_point(x[0], u[0], x[1], c->radius[1]);
  if (c->kind == NSDAE_PLANE_ELLIPSOID) {
    x[1] = foremost(c->half, two->pose[1], two->solid[1]->R, x[1], nsdae_jet3_scale(-1, u[0]));
    return plane_point(x[0], u[0], x[1], 0);
  }
  if (c->kind == NSDAE_LINE_LINE) {
    u[1] = nsdae_pose_direction(two->pose[1], c->u[1]);
    return line_line(x, u, c->side, c->radius);
  }
  return line_point(x[0], u[0], c->radius[0], c->side, x[1], c->radius[1]);
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

nsdae_still nsdae_closest_still(const nsdae_closest *c, const nsdae_couple *two)
{
  nsdae_still s;
  if (c->kind > NSDAE_LINE_LINE) { /* of smooth shapes: few of many contacts */
    const nsdae_touch touch = nsdae_closest_touch(c, two);
    s.gap = touch.gap.x;
    for (int j = 0; j < 3; j++) {
      s.normal[j] = touch.normal.at[j].x;
      for (int i = 0; i < 2; i++) s.at[i][j] = touch.at[i].at[j].x;
    }
    return s;
  }
  int plane = c->kind == NSDAE_PLANE_POINT, lines = c->kind == NSDAE_LINE_LINE;
  double r0 = c->radius[0], r1 = c->radius[1];
  double x[2][3], u[2][3], d[3], zero[3], *n = s.normal;
  memcpy(zero, any, sizeof zero);
  for (int i = 0; i < 2; i++) {
    nsdae_pose_put(two->pose[i], c->x[i], x[i]);
    if (i == 0 ? c->kind != NSDAE_POINT_POINT : lines) nsdae_turn(two->pose[i]->R, c->u[i], u[i]);
  }
  for (int j = 0; j < 3; j++) d[j] = x[1][j] - x[0][j];
  if (c->kind == NSDAE_LINE_POINT) {
    for (int pass = 0; pass < 2; pass++) {
      double along = nsdae_dot3(u[0], d);
      for (int j = 0; j < 3; j++) x[0][j] += along * u[0][j];
      for (int j = 0; j < 3; j++) d[j] -= along * u[0][j];
    }
    across_line(u[0], zero);
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
    for (int j = 0; j < 3; j++) n[j] = c->side * (square == 0 ? zero[j] : inverse * d[j]);
    s.gap = c->side * length - (c->side * r0 + r1);
    for (int j = 0; j < 3; j++) s.at[0][j] = x[0][j] + c->side * r0 * n[j];
  }
  for (int j = 0; j < 3; j++) s.at[1][j] = x[1][j] - r1 * n[j];
  return s;
}
