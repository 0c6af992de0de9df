/* A corner against a convex polygon, or against a rounded segment, which is one of two corners.
 * Outside, the nearest edge or corner counts. Of solids that overlap each corner touches the edge
 * that separates the two best: of blocks that lie flush the common one, though at their corners
 * another is as near. None is deeper than the overlap, which is the best separation by an edge of
 * either (see overlap.h: the axis of least depth). The corner that is the lowest there lies over
 * that edge, and touches though it came out on the other side, as of two that cross as swords.
 *
 *   separation by an edge with the outer normal n at x:  s = min_i n . (p_i - x), p_i the other's
 *   corners; two convex polygons overlap where no edge of either has s > 0 */
#include "touch.h"

/* What counts as nothing, rounding and drift, and how far beside an edge what overlaps is still
 * over it, in parts of the edge's length. */
static const double drift = 1e-6, beside = 1e-4;

/* Outer unit normal of the edge from corner i, in the body's frame. */
static const double *edge_normal(const nsdae_solid_of *s, int i)
{
  return s->edge + 4 * i;
}

/* A solid and its pose. */
typedef struct placed {
  const nsdae_solid_of *solid;
  const nsdae_pose *pose;
} placed;

/* Height of the other solid's points p above the point x along n, both of the polygon's frame:
 * above[0] p_x + above[1] p_y + above[2]. */
static void heights(placed polygon, placed other, const double *n, const double *x, double *above)
{
  const nsdae_pose *from = polygon.pose, *to = other.pose;
  double in_space[3], own[3];
  nsdae_turn(from->R, n, in_space);
  nsdae_turn_back(to->R, in_space, own);
  above[0] = own[0];
  above[1] = own[1];
  above[2] = in_space[0] * (to->r[0] - from->r[0]) + in_space[1] * (to->r[1] - from->r[1]) -
             n[0] * x[0] - n[1] * x[1];
}

/* That of its lowest corner. */
static double lowest(const nsdae_solid_of *s, const double *above)
{
  double least = INFINITY;
  for (int i = 0; i < s->points; i++)
    least = fmin(least, nsdae_height_above(above, nsdae_solid_corner(s, i)));
  return least;
}

/* The largest s of the edges of a polygon. */
static void separate(placed polygon, placed other, int side, nsdae_meeting *met)
{
  for (int e = 0; e < polygon.solid->points; e++) {
    double above[3];
    const double *n = edge_normal(polygon.solid, e);
    heights(polygon, other, n, nsdae_solid_corner(polygon.solid, e), above);
    double s = lowest(other.solid, above);
    if (s <= met->value[side]) continue;
    met->value[side] = s;
    met->edge[side] = e;
    for (int i = 0; i < 3; i++) met->above[side][i] = above[i];
  }
}

/* Beyond the ends of a line, along it: where two lie in one line its edges separate nothing. */
static double separate_ends(placed line, placed other)
{
  double most = -INFINITY;
  for (int e = 0; e < 2; e++) {
    double above[3];
    const double *n = edge_normal(line.solid, e);
    const double along[3] = {-n[1], n[0], 0}; /* from corner e to the other */
    heights(line, other, along, nsdae_solid_corner(line.solid, 1 - e), above);
    most = fmax(most, lowest(other.solid, above));
  }
  return most;
}

/* The line of an edge, r_0 above it. */
static nsdae_touch on_edge(placed polygon, int edge, nsdae_jet3 x1, double r1)
{
  const double *n = edge_normal(polygon.solid, edge);
  nsdae_jet3 normal = nsdae_pose_direction(polygon.pose, n);
  nsdae_jet3 x0 = nsdae_pose_point(polygon.pose, nsdae_solid_corner(polygon.solid, edge));
  return nsdae_touch_plane_point(
      nsdae_jet3_add(x0, nsdae_jet3_scale(polygon.solid->radius, normal)), normal, x1, r1);
}

/* Where a point is along an edge and how high above it. */
typedef struct place {
  int edge;
  double height, along, length;
} place;

static place place_on(const nsdae_solid_of *s, int edge, const double *x)
{
  const double *n = edge_normal(s, edge), length = n[3];
  const double *p = nsdae_solid_corner(s, edge);
  return (place){edge, n[0] * (x[0] - p[0]) + n[1] * (x[1] - p[1]),
                 -n[1] * (x[0] - p[0]) + n[0] * (x[1] - p[1]), length};
}

/* On the edge that is the highest under the point x of the polygon's frame. */
static place find_place(const nsdae_solid_of *s, const double *x)
{
  place highest = {.height = -INFINITY};
  for (int i = 0; i < s->points; i++) {
    place on = place_on(s, i, x);
    if (on.height > highest.height) highest = on;
  }
  return highest;
}

/* Whether a solid has edges of its own that can separate: a segment without rounding is a side. */
static int has_edges(const nsdae_solid_of *s)
{
  return s->shape == NSDAE_SHAPE_POLYGON || (s->points > 1 && s->radius > 0);
}

nsdae_meeting nsdae_find_meeting(const nsdae_solid_of *s0, const nsdae_solid_of *s1,
                                 const nsdae_pose *pose0, const nsdae_pose *pose1)
{
  const placed solid[2] = {{s0, pose0}, {s1, pose1}};
  nsdae_meeting met = {.value = {-INFINITY, -INFINITY}, .ends = {-INFINITY, -INFINITY}};
  for (int i = 0; i < 2; i++) {
    if (!has_edges(solid[i].solid) || solid[1 - i].solid->points == 0) continue;
    separate(solid[i], solid[1 - i], i, &met);
    if (solid[i].solid->points == 2) met.ends[i] = separate_ends(solid[i], solid[1 - i]);
  }
  return met;
}

nsdae_meeting nsdae_meeting_turned(const nsdae_meeting *met)
{
  nsdae_meeting other;
  for (int i = 0; i < 2; i++) {
    other.value[i] = met->value[1 - i];
    other.ends[i] = met->ends[1 - i];
    other.edge[i] = met->edge[1 - i];
    for (int j = 0; j < 3; j++) other.above[i][j] = met->above[1 - i][j];
  }
  return other;
}

/* The edge that a corner at x touches where the two overlap; NONE where they do not, or it is
 * aside; FAR where it is deeper than they overlap. */
enum { NONE = -1, FAR = -2 };

static int overlapped_edge(placed polygon, const nsdae_meeting *met, const double *x, place at)
{
  double slack = drift * at.length, most = fmax(met->value[0], met->value[1]);
  if (fmax(most, met->ends[0]) > slack) return NONE;
  place on = place_on(polygon.solid, met->edge[0], x);
  int over = fabs(on.along - on.length / 2) <= (0.5 + beside) * on.length;
  int inside = at.height <= slack && polygon.solid->points > 2; /* a line has no inside */
  if (!inside && !over) return NONE;
  return on.height < most - slack ? FAR : met->edge[0];
}

/* Where the corner at p of the other's frame is: in space x_1 and on the polygon at. What it
 * touches: an edge, NONE: the end of at that is near, FAR. */
static int touched(placed polygon, placed other, const double *p, const nsdae_meeting *met,
                   double *x1, place *at)
{
  double x[3], from[3];
  nsdae_turn(other.pose->R, p, x1);
  for (int i = 0; i < 3; i++) {
    x1[i] += other.pose->r[i];
    from[i] = x1[i] - polygon.pose->r[i];
  }
  nsdae_turn_back(polygon.pose->R, from, x);
  *at = find_place(polygon.solid, x);
  int edge = other.solid->points > 1 ? overlapped_edge(polygon, met, x, *at)
             : at->height <= 0       ? at->edge
                                     : NONE;
  if (edge == NONE && at->along >= 0 && at->along <= at->length) return at->edge;
  if (edge >= 0) *at = place_on(polygon.solid, edge, x);
  return edge;
}

static int near_end(const nsdae_solid_of *s, place at)
{
  return (at.edge + (at.along > 0)) % s->points;
}

nsdae_touch nsdae_polygon_touch(const nsdae_solid_of *s0, const nsdae_solid_of *s1, int corner,
                                const nsdae_pose *pose0, const nsdae_pose *pose1,
                                const nsdae_meeting *met)
{
  const placed polygon = {s0, pose0}, other = {s1, pose1};
  const double *p = nsdae_solid_corner(s1, corner);
  double now[3];
  place at;
  int edge = touched(polygon, other, p, met, now, &at);
  if (edge == FAR) return nsdae_touch_far(s0, s1);
  nsdae_jet3 x1 = nsdae_pose_point(pose1, p);
  if (edge != NONE) return on_edge(polygon, edge, x1, s1->radius);
  nsdae_jet3 end = nsdae_pose_point(pose0, nsdae_solid_corner(s0, near_end(s0, at)));
  return nsdae_touch_point_point(end, s0->radius, 1, x1, s1->radius);
}

nsdae_flat nsdae_polygon_flat(const nsdae_solid_of *s0, const nsdae_solid_of *s1, int corner,
                              const nsdae_pose *pose0, const nsdae_pose *pose1,
                              const nsdae_meeting *met)
{
  const placed polygon = {s0, pose0}, other = {s1, pose1};
  nsdae_flat f = {.far = 0};
  double x1[3], n[3], end[3], height;
  place at;
  int edge = touched(polygon, other, nsdae_solid_corner(s1, corner), met, x1, &at);
  f.far = edge == FAR;
  if (f.far) return f;
  if (edge != NONE) {
    nsdae_turn(pose0->R, edge_normal(s0, edge), n);
    height = at.height;
  } else {
    nsdae_turn(pose0->R, nsdae_solid_corner(s0, near_end(s0, at)), end);
    for (int i = 0; i < 2; i++) n[i] = x1[i] - pose0->r[i] - end[i];
    height = sqrt(n[0] * n[0] + n[1] * n[1]);
    n[0] = height > 0 ? n[0] / height : 1;
    n[1] = height > 0 ? n[1] / height : 0;
  }
  f.gap = height - s0->radius - s1->radius;
  for (int i = 0; i < 2; i++) {
    f.normal[i] = n[i];
    f.at[0][i] = x1[i] - (height - s0->radius) * n[i];
    f.at[1][i] = x1[i] - s1->radius * n[i];
  }
  return f;
}
