/* A corner against a convex polygon, or against a rounded segment, which is one of two corners.
 * Outside, the nearest edge or corner counts. Of solids that overlap each corner touches the edge
 * that separates the two best: of blocks that lie flush the common one, though at their corners
 * another is as near. None is deeper than the overlap, which is the best separation by an edge of
 * either (see separating_axis.h: the axis of least depth). The corner that is the lowest there lies
 * over that edge, and touches though it came out on the other side, as of two that cross as swords.
 *
 *   separation by an edge with the outer normal n at x:  s = min_i n . (p_i - x), p_i the other's
 *   corners; two convex polygons overlap where no edge of either has s > 0 */
#include "narrow_phase.h"

/* What rounding and drift explain, at most, and how far beside an edge what overlaps is still over
 * it, at most, in parts of the edge's length. A gap jumps where these end: so neither is more than
 * some depths of the overlap (or widths of what is between the solids), nor less than rounding. */
static const double drift = 1e-6, beside = 1e-4, depths = 10, rounding = 1e-9;

/* Outer unit normal of the edge from corner i, in the body's frame. */
static const double *edge_normal(const nsdae_solid_of *s, int i)
{
  return s->edge + 4 * i;
}

/* How a polygon sees a point p of the other's frame: turned and moved, x = (c, s) p + r. */
typedef struct view {
  double c, s, r[2];
} view;

/* ---- separation along the normals */

/* Height of the other solid's points p above the point x along n, both of the polygon's frame:
 * above[0] p_x + above[1] p_y + above[2]. */
static void heights(const view *w, const double *n, const double *x, double *above)
{
  above[0] = n[0] * w->c + n[1] * w->s;
  above[1] = n[1] * w->c - n[0] * w->s;
  above[2] = n[0] * (w->r[0] - x[0]) + n[1] * (w->r[1] - x[1]);
}

/* That of its lowest corner. */
static double lowest(const nsdae_solid_of *s, const double *above)
{
  double least = INFINITY;
  for (int i = 0; i < s->points; i++) {
    double height = nsdae_height_above(above, nsdae_solid_corner(s, i));
    if (height < least) least = height;
  }
  return least;
}

/* Beyond the ends of a line, along it: where two lie in one line its edges separate nothing. */
static double separate_ends(const nsdae_solid_of *line, const nsdae_solid_of *other, const view *w)
{
  double most = -INFINITY;
  for (int e = 0; e < 2; e++) {
    double above[3];
    const double *n = edge_normal(line, e);
    const double along[2] = {-n[1], n[0]}; /* from corner e to the other */
    heights(w, along, nsdae_solid_corner(line, 1 - e), above);
    most = nsdae_more_of(most, lowest(other, above));
  }
  return most;
}

/* ---- edges */

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

/* Which can separate: a segment without rounding is a side. */
static int has_edges(const nsdae_solid_of *s)
{
  return s->shape == NSDAE_SHAPE_POLYGON ||
         (s->shape == NSDAE_SHAPE_SEGMENT && s->points > 1 && s->radius > 0);
}

void nsdae_find_separations(nsdae_meeting *met)
{
  const nsdae_couple *two = &met->two;
  double enough = met->enough;
  for (int i = 0; i < 2; i++) met->by[i].value = met->by[i].ends = -INFINITY;
  for (int i = 0; i < 2 && !met->far; i++) {
    nsdae_separation *best = &met->by[i];
    const nsdae_solid_of *solid = two->solid[i], *other = two->solid[1 - i];
    if (!has_edges(solid)) continue;
    const nsdae_pose *here = two->pose[i], *there = two->pose[1 - i];
    const double *R = here->R, *Q = there->R;
    const double x = there->r[0] - here->r[0], y = there->r[1] - here->r[1];
    const view w = {R[0] * Q[0] + R[1] * Q[1],
                    R[0] * Q[1] - R[1] * Q[0],
                    {R[0] * x + R[1] * y, R[3] * x + R[4] * y}};
    /* the largest s of the edges of a polygon; of one that is enough no larger one is looked for */
    for (int e = 0; e < solid->points && best->value <= enough; e++) {
      double above[3];
      heights(&w, edge_normal(solid, e), nsdae_solid_corner(solid, e), above);
      double s = lowest(other, above);
      if (s <= best->value) continue;
      best->value = s;
      best->edge = e;
      for (int l = 0; l < 3; l++) best->above[l] = above[l];
    }
    if (solid->points == 2) best->ends = separate_ends(solid, other, &w);
    met->far = best->value > enough;
  }
}

/* What a corner touches beside an edge: NONE: the edge's end that is near; FAR: another feature
 * stands for it, since it is deeper than the two overlap. */
enum { NONE = -1, FAR = -2 };

/* ---- which edge a corner touches */

/* most: the separation of the solids; part: drift or beside. */
static double slack_of(double part, place on, double most)
{
  return fmin(part * on.length, fmax(rounding * on.length, depths * fabs(most)));
}

static double separation(const nsdae_meeting *met)
{
  return nsdae_more_of(met->by[0].value, met->by[1].value);
}

static int is_above(place at)
{
  return at.along >= 0 && at.along <= at.length;
}

/* In an overlap a corner on the edge that separates best touches it, where none is deeper. */
static int unless_deeper(const nsdae_meeting *met, place on)
{
  double most = separation(met);
  return on.height < most - slack_of(drift, on, most) ? FAR : on.edge;
}

/* The edge that a corner at x of a solid with edges touches, and its place on it; NONE and its
 * place on the nearest edge's line; FAR. Where the solids are apart and the corner is above the
 * edge that separates best, none is nearer: a convex polygon lies behind that edge's line. Where
 * they overlap it touches that edge if it lies over it or inside. */
static int touched_by_corner(const nsdae_meeting *met, int base, const double *x, place *at)
{
  const nsdae_solid_of *s = met->two.solid[base];
  place on = *at = place_on(s, met->by[base].edge, x);
  double most = separation(met), slack = slack_of(drift, on, most);
  int overlap = nsdae_more_of(most, met->by[base].ends) <= drift * on.length;
  int over = fabs(on.along - on.length / 2) <= on.length / 2 + slack_of(beside, on, most);
  if (overlap && over) return unless_deeper(met, on);
  if (!overlap && on.height >= 0 && is_above(on)) return on.edge;
  *at = find_place(s, x);
  int inside = at->height <= slack && s->points > 2; /* a line has no inside */
  if (!overlap || !inside) return is_above(*at) ? at->edge : NONE;
  *at = on;
  return unless_deeper(met, on);
}

/* Where the corner at p of the other's frame is on the polygon; and what it touches. */
static int touched(const nsdae_meeting *met, int base, const double *p, place *at)
{
  const nsdae_couple *two = &met->two;
  const nsdae_pose *polygon = two->pose[base], *other = two->pose[1 - base];
  const double *R = polygon->R;
  double x1[3];
  nsdae_pose_put(other, p, x1);
  const double from[2] = {x1[0] - polygon->r[0], x1[1] - polygon->r[1]};
  const double x[2] = {R[0] * from[0] + R[1] * from[1], R[3] * from[0] + R[4] * from[1]};
  if (two->solid[1 - base]->points > 1) return touched_by_corner(met, base, x, at);
  *at = find_place(two->solid[base], x); /* of a point, or the centre of what is round */
  return at->height <= 0 || is_above(*at) ? at->edge : NONE;
}

/* ---- interface */

int nsdae_polygon_closest(const nsdae_meeting *met, int base, int corner, nsdae_closest *c)
{
  const nsdae_solid_of *s = met->two.solid[base], *other = met->two.solid[1 - base];
  const double *p = nsdae_solid_corner(other, corner);
  place at;
  if (other->points > 1 && nsdae_height_above(met->by[base].above, p) > met->enough) return 0;
  int edge = touched(met, base, p, &at);
  if (edge == FAR) return 0;
  c->kind = edge == NONE ? NSDAE_POINT_POINT : NSDAE_PLANE_POINT;
  int corner0 = edge == NONE ? (at.edge + (at.along > 0)) % s->points : edge; /* the near end */
  for (int i = 0; i < 3; i++) {
    c->x[0][i] = nsdae_solid_corner(s, corner0)[i];
    if (edge == NONE) continue; /* the edge's line, r_0 above it */
    c->u[0][i] = edge_normal(s, edge)[i];
    c->x[0][i] += s->radius * c->u[0][i];
  }
  return 1;
}
