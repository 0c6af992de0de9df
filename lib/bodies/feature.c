#include "narrow_phase.h"

#include "separating_axis.h"

int nsdae_solid_edges(const nsdae_solid_of *s)
{
  return s->shape == NSDAE_SHAPE_CAPSULE ? 1 : s->shape == NSDAE_SHAPE_BOX ? 12 : 0;
}

/* Two lines through x_i along unit vectors u, w, with d = x_1 - x_0 and m = u x w:
 * a = m . (d x w) / m^2,  b = m . (d x u) / m^2 are the places of their nearest points along u and
 * w;  n = +-m / |m|, towards line 1. (Written with scalar products alone the same cancels where the
 * lines are near parallel, as the square of their angle.) */
typedef struct two_lines {
  nsdae_jet3 x[2], u[2], m;
  nsdae_jet a, b;
} two_lines;

/* ---- lines */

/* hint: a vector that n is to point along. */
static nsdae_touch line_line(const two_lines *l, const double *hint, double r0, double r1)
{
  nsdae_touch touch = {.far = 0};
  double along = 0;
  for (int i = 0; i < 3; i++) along += hint[i] * l->m.at[i].x;
  nsdae_jet3 n = nsdae_jet3_scale(
      along < 0 ? -1 : 1, nsdae_jet3_times(nsdae_jet_inverse(nsdae_jet3_length(l->m)), l->m));
  nsdae_jet3 x0 = nsdae_jet3_add(l->x[0], nsdae_jet3_times(l->a, l->u[0]));
  nsdae_jet3 x1 = nsdae_jet3_add(l->x[1], nsdae_jet3_times(l->b, l->u[1]));
  touch.gap = nsdae_jet3_dot(n, nsdae_jet3_sub(l->x[1], l->x[0]));
  touch.gap.x -= r0 + r1;
  touch.normal = n;
  touch.at[0] = nsdae_jet3_add(x0, nsdae_jet3_scale(r0, n));
  touch.at[1] = nsdae_jet3_sub(x1, nsdae_jet3_scale(r1, n));
  return touch;
}

/* A segment or capsule: its ends, or between them its line; a segment without rounding is solid on
 * one side. */
static nsdae_touch against_rod(const nsdae_solid_of *s, const nsdae_pose *pose, nsdae_jet3 x1,
                               double r1)
{
  int axis = s->shape == NSDAE_SHAPE_SEGMENT ? 0 : 2;
  nsdae_jet3 end[2] = {nsdae_pose_point(pose, nsdae_solid_corner(s, 0)),
                       nsdae_pose_point(pose, nsdae_solid_corner(s, 1))};
  nsdae_jet3 u = nsdae_pose_direction(pose, s->R + 3 * axis);
  double along = nsdae_jet3_dot(u, nsdae_jet3_sub(x1, end[0])).x;
  if (along < 0 || along > 2 * s->half[axis])
    return nsdae_touch_point_point(end[along > 0], s->radius, 1, x1, r1);
  if (s->shape == NSDAE_SHAPE_SEGMENT && s->radius == 0)
    return nsdae_touch_plane_point(end[0], nsdae_pose_direction(pose, s->R + 3), x1, r1);
  return nsdae_touch_line_point(end[0], u, s->radius, x1, r1);
}

/* ---- a corner on a box */

/* Where a point in space is in a box's own frame. */
static void own_place(const nsdae_solid_of *s, const nsdae_pose *pose, nsdae_jet3 x1, double *place)
{
  double x[3], from[3];
  for (int i = 0; i < 3; i++) from[i] = x1.at[i].x - pose->r[i];
  nsdae_turn_back(pose->R, from, x);
  for (int i = 0; i < 3; i++) x[i] -= s->origin[i];
  nsdae_turn_back(s->R, x, place);
}

/* The corner of a box on whose sides a place lies. */
static nsdae_jet3 box_corner(const nsdae_solid_of *s, const nsdae_pose *pose, const double *place)
{
  double from[3], spot[3];
  for (int i = 0; i < 3; i++) from[i] = place[i] < 0 ? -s->half[i] : s->half[i];
  nsdae_turn(s->R, from, spot);
  for (int i = 0; i < 3; i++) spot[i] += s->origin[i];
  return nsdae_pose_point(pose, spot);
}

/* The face of a box across an axis, on its side 1 or -1. */
static nsdae_touch on_face(const nsdae_solid_of *s, const nsdae_pose *pose, int axis, double side,
                           nsdae_jet3 x1, double r1)
{
  double n[3], on[3];
  for (int i = 0; i < 3; i++) {
    n[i] = side * s->R[3 * axis + i];
    on[i] = side; /* any corner of that face */
  }
  return nsdae_touch_plane_point(box_corner(s, pose, on), nsdae_pose_direction(pose, n), x1, r1);
}

/* One coordinate beyond its half edge is a face, two an edge, three a corner; none is inside, where
 * the nearest face counts. */
static nsdae_touch nearest_on_box(const nsdae_solid_of *s, const nsdae_pose *pose,
                                  const double *place, nsdae_jet3 x1, double r1)
{
  int beyond = 0, deepest = 0, within = 0;
  for (int i = 0; i < 3; i++) {
    beyond += fabs(place[i]) > s->half[i];
    if (fabs(place[i]) <= s->half[i]) within = i;
    if (fabs(place[i]) - s->half[i] > fabs(place[deepest]) - s->half[deepest]) deepest = i;
  }
  if (beyond <= 1) return on_face(s, pose, deepest, place[deepest] < 0 ? -1 : 1, x1, r1);
  nsdae_jet3 corner = box_corner(s, pose, place);
  if (beyond == 2)
    return nsdae_touch_line_point(corner, nsdae_pose_direction(pose, s->R + 3 * within), 0, x1, r1);
  return nsdae_touch_point_point(corner, 0, 1, x1, r1);
}

/* Whether a place is beside the face across an axis by no more than slack. */
static int is_over(const nsdae_solid_of *s, const double *place, int axis, double slack)
{
  for (int i = 0; i < 3; i++)
    if (i != axis && fabs(place[i]) > s->half[i] + slack) return 0;
  return 1;
}

/* Whether the face that is the least deep can be another than the nearest one to a corner: it is
 * within the box, or came out on the side that is away from its solid. */
static int may_be_over(const nsdae_couple *two, const double *place)
{
  const nsdae_solid_of *s0 = two->solid[0], *s1 = two->solid[1];
  double beside = NSDAE_BESIDE * (s0->size + s1->size), middle[3];
  int out = 0, axis = 0;
  for (int i = 0; i < 3; i++) {
    if (fabs(place[i]) <= s0->half[i] + beside) continue;
    axis = i;
    out++;
  }
  if (out != 1) return out == 0;
  own_place(s0, two->pose[0], nsdae_pose_point(two->pose[1], s1->origin), middle);
  /* in the middle rounding says which side that is */
  return fabs(middle[axis]) <= beside || place[axis] * middle[axis] < 0;
}

/* Corners of what overlaps a box touch the face that is the least deep in it, not each the face
 * that is nearest to it: blocks that lie flush keep the common face, though at their corners others
 * are as near. None is deeper than the overlap. */
static nsdae_touch corner_on_box(const nsdae_couple *two, nsdae_jet3 x1)
{
  const nsdae_solid_of *s0 = two->solid[0], *s1 = two->solid[1];
  const nsdae_pose *pose0 = two->pose[0];
  double place[3];
  own_place(s0, pose0, x1, place);
  if (s1->points == 1 || !may_be_over(two, place))
    return nearest_on_box(s0, pose0, place, x1, s1->radius);
  nsdae_separating_axis o = nsdae_separating_axis_find(two);
  int by_edges = o.face < o.most - o.slack; /* then no corner in the box is deeper than they are */
  if (o.most > o.slack || by_edges || !is_over(s0, place, o.axis, o.beside))
    return nearest_on_box(s0, pose0, place, x1, s1->radius);
  if (o.side * place[o.axis] - s0->half[o.axis] < o.most - o.slack) return nsdae_touch_far(two);
  return on_face(s0, pose0, o.axis, o.side, x1, s1->radius);
}

/* ---- an edge on an edge */

/* The axis along which edge i of a box or capsule runs, and the signs of its place on the others.
 */
static int edge_of(const nsdae_solid_of *s, int i, double *sign)
{
  int axis = s->shape == NSDAE_SHAPE_BOX ? i / 4 : 2;
  for (int j = 0; j < 3; j++) sign[j] = 0;
  if (s->shape != NSDAE_SHAPE_BOX) return axis;
  sign[(axis + 1) % 3] = i % 2 ? 1 : -1;
  sign[(axis + 2) % 3] = i / 2 % 2 ? 1 : -1;
  return axis;
}

/* Two solids in space: their axes (columns), and the way from the one's origin to the other's. */
typedef struct two_solids {
  double axes[2][9], way[3];
} two_solids;

static two_solids in_space(const nsdae_couple *couple)
{
  const nsdae_solid_of *const *s = couple->solid;
  const nsdae_pose *const *pose = couple->pose;
  two_solids two;
  double at[2][3];
  for (int i = 0; i < 2; i++) {
    for (int j = 0; j < 3; j++) nsdae_turn(pose[i]->R, s[i]->R + 3 * j, two.axes[i] + 3 * j);
    nsdae_turn(pose[i]->R, s[i]->origin, at[i]);
  }
  for (int i = 0; i < 3; i++) two.way[i] = at[1][i] + pose[1]->r[i] - at[0][i] - pose[0]->r[i];
  return two;
}

/* The unit vector at right angles to an axis of each, from 0 to 1, in the frame of solid 0, and its
 * opposite in that of solid 1; 0 where the axes are parallel. */
static int between_axes(const two_solids *two, int axis0, int axis1, double n[2][3])
{
  /* edges nearer to parallel than this, as the square of their angle, touch by their corners as
   * well: there these are as near up to 1e-8 of their length, and of places eight digits are left
   */
  const double parallel = 1e-16;
  double m[3];
  nsdae_cross3(two->axes[0] + 3 * axis0, two->axes[1] + 3 * axis1, m);
  double square = nsdae_dot3(m, m);
  if (square < parallel) return 0;
  double scale = (nsdae_dot3(m, two->way) < 0 ? -1 : 1) / sqrt(square);
  for (int side = 0; side < 2; side++, scale = -scale)
    for (int i = 0; i < 3; i++) n[side][i] = scale * nsdae_dot3(m, two->axes[side] + 3 * i);
  return 1;
}

/* Whether the direction n (in the solid's frame) leaves a box between the two faces of the edge, or
 * along one of them up to rounding; a capsule's line is round. */
static int leaves_by(const double *sign, const double *n)
{
  const double rounding = 1e-4;
  for (int i = 0; i < 3; i++)
    if (sign[i] * n[i] < -rounding) return 0;
  return 1;
}

/* The edges of a box along an axis, or of a capsule, that a direction leaves: bit i for edge i. */
static unsigned leaving(const nsdae_solid_of *s, int axis, const double *n)
{
  int box = s->shape == NSDAE_SHAPE_BOX, first = box ? 4 * axis : 0;
  unsigned mask = 0;
  for (int i = first; i < first + (box ? 4 : 1); i++) {
    double sign[3];
    edge_of(s, i, sign);
    if (leaves_by(sign, n)) mask |= 1u << i;
  }
  return mask;
}

void nsdae_find_facing(const nsdae_couple *couple, nsdae_facing *facing)
{
  const nsdae_solid_of *s0 = couple->solid[0], *s1 = couple->solid[1];
  two_solids two = in_space(couple);
  *facing = (nsdae_facing){{0}};
  for (int i = s0->shape == NSDAE_SHAPE_BOX ? 0 : 2; i < 3; i++)
    for (int j = s1->shape == NSDAE_SHAPE_BOX ? 0 : 2; j < 3; j++) {
      double n[2][3];
      if (!between_axes(&two, i, j, n)) continue;
      unsigned first = leaving(s0, i, n[0]), second = leaving(s1, j, n[1]);
      for (int k = 0; k < NSDAE_EDGES_MAX; k++)
        if (first >> k & 1) facing->of[k] |= second;
    }
}

/* Of solids that overlap only the edges of the axis of least depth touch; see separating_axis.h.
 * Lines along a face are as deep as the face up to rounding, and do. */
static nsdae_touch edges(const nsdae_feature *f, const nsdae_couple *two)
{
  const nsdae_solid_of *const *s = two->solid;
  two_solids placed = in_space(two);
  two_lines l = {.a = {0}};
  double sign[2][3], n[2][3], middle[3];
  int axis[2];
  for (int i = 0; i < 2; i++) axis[i] = edge_of(s[i], f->part[i], sign[i]);
  if (!between_axes(&placed, axis[0], axis[1], n) || !leaves_by(sign[0], n[0]) ||
      !leaves_by(sign[1], n[1]))
    return nsdae_touch_far(two);
  for (int i = 0; i < 2; i++) {
    for (int j = 0; j < 3; j++) { /* in the body's frame */
      middle[j] = s[i]->origin[j];
      for (int k = 0; k < 3; k++) middle[j] += s[i]->R[3 * k + j] * sign[i][k] * s[i]->half[k];
    }
    l.x[i] = nsdae_pose_point(two->pose[i], middle);
    l.u[i] = nsdae_pose_direction(two->pose[i], s[i]->R + 3 * axis[i]);
  }
  nsdae_jet3 d = nsdae_jet3_sub(l.x[1], l.x[0]);
  l.m = nsdae_jet3_cross(l.u[0], l.u[1]);
  nsdae_jet inverse = nsdae_jet_inverse(nsdae_jet3_dot(l.m, l.m));
  l.a = nsdae_jet_mul(inverse, nsdae_jet3_dot(l.m, nsdae_jet3_cross(d, l.u[1])));
  l.b = nsdae_jet_mul(inverse, nsdae_jet3_dot(l.m, nsdae_jet3_cross(d, l.u[0])));
  if (fabs(l.a.x) > s[0]->half[axis[0]] || fabs(l.b.x) > s[1]->half[axis[1]])
    return nsdae_touch_far(two);
  nsdae_touch touch = line_line(&l, placed.way, s[0]->radius, s[1]->radius);
  double apart = touch.gap.x + s[0]->radius + s[1]->radius;
  if (apart >= 0) return touch;
  nsdae_separating_axis o = nsdae_separating_axis_find(two);
  return apart < o.most - o.slack ? nsdae_touch_far(two) : touch;
}

/* ---- interface */

nsdae_touch nsdae_feature_touch(const nsdae_feature *f, const nsdae_couple *two)
{
  const nsdae_solid_of *s0 = two->solid[0], *s1 = two->solid[1];
  if (f->edges) return edges(f, two);
  int rounded = s0->shape == NSDAE_SHAPE_SEGMENT && s0->radius > 0 && s1->points > 1;
  if (s0->shape == NSDAE_SHAPE_POLYGON || rounded) {
    nsdae_meeting met;
    if (s1->points > 1) met = nsdae_find_meeting(two, INFINITY);
    return nsdae_polygon_touch(two, f->part[1], &met);
  }
  nsdae_jet3 x1 = nsdae_pose_point(two->pose[1], nsdae_solid_corner(s1, f->part[1]));
  if (s0->shape == NSDAE_SHAPE_BOX) return corner_on_box(two, x1);
  if (s0->shape == NSDAE_SHAPE_SEGMENT || s0->shape == NSDAE_SHAPE_CAPSULE)
    return against_rod(s0, two->pose[0], x1, s1->radius);
  nsdae_jet3 x0 = nsdae_pose_point(two->pose[0], s0->origin);
  if (s0->shape != NSDAE_SHAPE_PLANE)
    return nsdae_touch_point_point(x0, s0->radius, s0->hollow ? -1 : 1, x1, s1->radius);
  nsdae_jet3 n = nsdae_pose_direction(two->pose[0], s0->R + 6);
  return nsdae_touch_plane_point(x0, n, x1, s1->radius);
}
