/* A corner against a convex polygon. Outside, the nearest edge or corner of the polygon counts.
 * Inside or on it the edge that separates the two solids best (the axis of least overlap): of
 * blocks that lie flush the common face, though at their corners another one is as near.
 *
 *   separation of an edge with the outer normal n at x:  s = min_i n . (p_i - x), p_i the other's
 *   corners; two convex polygons overlap where no edge of either has s > 0 */
#include "touch.h"

/* Places along an edge that are at its end but for rounding and drift, in parts of its length. */
static const double at_end = 1e-6;

/* Outer unit normal of the edge from corner i, in the body's frame; its length. */
static double edge_normal(const nsdae_solid_of *s, int i, double *n)
{
  const double *p = nsdae_solid_corner(s, i), *next = nsdae_solid_corner(s, (i + 1) % s->points);
  double x = next[0] - p[0], y = next[1] - p[1], length = sqrt(x * x + y * y);
  n[0] = y / length;
  n[1] = -x / length;
  n[2] = 0;
  return length;
}

/* A solid and its pose. */
typedef struct placed {
  const nsdae_solid_of *solid;
  const nsdae_pose *pose;
} placed;

typedef struct separation {
  double value;
  int edge, corner; /* of the polygon; of the other solid */
} separation;

/* The largest s of the edges of a polygon, and which corner is the lowest there. */
static separation separate(placed polygon, placed other)
{
  separation best = {.value = -INFINITY};
  const nsdae_pose *from = polygon.pose, *to = other.pose;
  const double apart[3] = {to->r[0] - from->r[0], to->r[1] - from->r[1], 0};
  for (int e = 0; e < polygon.solid->points; e++) {
    double n[3], in_space[3], own[3], least = INFINITY;
    int lowest = 0;
    edge_normal(polygon.solid, e, n);
    nsdae_turn(from->R, n, in_space);
    nsdae_turn_back(to->R, in_space, own);
    for (int i = 0; i < other.solid->points; i++) {
      double height = nsdae_dot3(own, nsdae_solid_corner(other.solid, i));
      if (height < least) {
        least = height;
        lowest = i;
      }
    }
    double s = least + nsdae_dot3(in_space, apart) -
               nsdae_dot3(n, nsdae_solid_corner(polygon.solid, e)) - other.solid->radius;
    if (s > best.value) best = (separation){s, e, lowest};
  }
  return best;
}

static nsdae_touch on_edge(placed polygon, int edge, nsdae_jet3 x1, double r1)
{
  double n[3];
  edge_normal(polygon.solid, edge, n);
  return nsdae_touch_plane_point(
      nsdae_pose_point(polygon.pose, nsdae_solid_corner(polygon.solid, edge)),
      nsdae_pose_direction(polygon.pose, n), x1, r1);
}

/* Which edge of the polygon is the highest under the point x of its frame, and where along it. */
typedef struct place {
  int edge;
  double height, along, length;
} place;

static place find_place(const nsdae_solid_of *s, const double *x)
{
  place highest = {.height = -INFINITY};
  for (int i = 0; i < s->points; i++) {
    double n[3], length = edge_normal(s, i, n);
    const double *p = nsdae_solid_corner(s, i);
    double height = n[0] * (x[0] - p[0]) + n[1] * (x[1] - p[1]);
    double along = -n[1] * (x[0] - p[0]) + n[0] * (x[1] - p[1]);
    if (height > highest.height) highest = (place){i, height, along, length};
  }
  return highest;
}

/* Two that cross as swords do overlap though no corner is inside: the corner that is the lowest
 * under the edge that separates best stands for that. The edge, or -1. */
static int crossed_edge(placed polygon, placed other, int corner)
{
  if (other.solid->shape != NSDAE_SHAPE_POLYGON) return -1;
  separation here = separate(polygon, other);
  if (here.value >= 0 || here.corner != corner) return -1;
  double there = separate(other, polygon).value;
  return there >= 0 || there > here.value ? -1 : here.edge;
}

nsdae_touch nsdae_polygon_touch(const nsdae_solid_of *s0, const nsdae_solid_of *s1, int corner,
                                const nsdae_pose *pose0, const nsdae_pose *pose1)
{
  placed polygon = {s0, pose0}, other = {s1, pose1};
  nsdae_jet3 x1 = nsdae_pose_point(pose1, nsdae_solid_corner(s1, corner));
  double x[3], from[3];
  for (int i = 0; i < 3; i++) from[i] = x1.at[i].x - pose0->r[i];
  nsdae_turn_back(pose0->R, from, x);
  place at = find_place(s0, x);
  double slack = at_end * at.length;
  if (at.height <= slack) return on_edge(polygon, separate(polygon, other).edge, x1, s1->radius);
  int crossed = crossed_edge(polygon, other, corner);
  if (crossed >= 0) return on_edge(polygon, crossed, x1, 0);
  if (at.along >= 0 && at.along <= at.length) return on_edge(polygon, at.edge, x1, s1->radius);
  int end = (at.edge + (at.along > 0)) % s0->points;
  return nsdae_touch_point_point(nsdae_pose_point(pose0, nsdae_solid_corner(s0, end)), 0, 1, x1,
                                 s1->radius);
}
