#include "narrow_phase.h"

#include <float.h>
#include <string.h>

#include "separating_axis.h"

/* ---- a corner on a rod */

/* Where a point x of the frame of one body is in the other body's frame, and in its solid's. */
static void place_in(const nsdae_couple *two, const double *x, double *own, double *place)
{
  const nsdae_solid_of *s = two->solid[0];
  double at[3];
  nsdae_pose_put(two->pose[1], x, at);
  for (int i = 0; i < 3; i++) at[i] -= two->pose[0]->r[i];
  nsdae_turn_back(two->pose[0]->R, at, own);
  for (int i = 0; i < 3; i++) at[i] = own[i] - s->origin[i];
  nsdae_turn_back(s->R, at, place);
}

static void set(const double *from, double *to)
{
  memcpy(to, from, 3 * sizeof *to);
}

/* A segment or capsule: its ends, or between them its line; a segment without rounding is solid on
 * one side. */
static void corner_on_rod(const nsdae_solid_of *s, const double *place, nsdae_closest *c)
{
  int axis = s->shape == NSDAE_SHAPE_SEGMENT ? 0 : 2, beyond = fabs(place[axis]) > s->half[axis];
  int one_side = s->shape == NSDAE_SHAPE_SEGMENT && s->radius == 0;
  c->kind = beyond ? NSDAE_POINT_POINT : one_side ? NSDAE_PLANE_POINT : NSDAE_LINE_POINT;
  set(nsdae_solid_corner(s, beyond && place[axis] > 0), c->x[0]);
  if (!beyond) set(s->R + 3 * (one_side ? 1 : axis), c->u[0]);
}

/* ---- smooth shapes
 *
 * Each is the convex hull of ellipsoids of half axes along those of its frame: an ellipsoid of
 * itself, a disc of one without height, a cylinder of its caps, a cone of its base and a point. The
 * foremost point of each may touch a plane; these are their corners, kept as centres. Behind that
 * of a disc are three points fixed to it, for one that lies flat: see on_disc in shapes.c. */
enum { OF_DISC = 4 };

/* x := the centre of the end on side 1 or -1 of the axis. */
static void end_of(const nsdae_solid_of *s, double side, double *x)
{
  for (int i = 0; i < 3; i++) x[i] = s->origin[i] + side * s->half[2] * s->R[6 + i];
}

static void half_axes(const nsdae_solid_of *s, double *half)
{
  set(s->half, half);
  if (s->shape != NSDAE_SHAPE_ELLIPSOID) half[2] = 0;
}

int nsdae_smooth_on_plane(const nsdae_couple *two, int corner, nsdae_closest *c)
{
  const nsdae_solid_of *s = two->solid[1];
  double n[3], a[3], tilt[3];
  if (corner % OF_DISC > 0) {
    nsdae_turn(two->pose[0]->R, c->u[0], n);
    nsdae_turn(two->pose[1]->R, s->R + 6, a);
    nsdae_cross3(n, a, tilt);
    return nsdae_dot3(tilt, tilt) < NSDAE_TILT * NSDAE_TILT;
  }
  if (s->shape == NSDAE_SHAPE_CONE && corner == OF_DISC) return 1; /* the apex */
  c->kind = NSDAE_PLANE_ELLIPSOID;
  half_axes(s, c->half);
  return 1;
}

/* The part of a cylinder, cone or disc that is the nearest to a place, or within the least deep. In
 * the half plane of the place and the axis they are bounded by an edge from the rim of the base at
 * (r, -h) upwards along (u, v), and the base. Of a disc both sides are a base. */
static void point_on_turned(const nsdae_solid_of *s, const double *place, nsdae_closest *c)
{
  int cone = s->shape == NSDAE_SHAPE_CONE, top = !cone && place[2] >= 0;
  double side = top ? 1 : -1, r = s->half[0], height = 2 * s->half[2], inwards = cone ? -r : 0;
  double beside = hypot(place[0], place[1]) - r, beyond = side * place[2] - s->half[2];
  double length = height > 0 ? hypot(inwards, height) : 1, u = inwards / length,
         v = height / length;
  double up = place[2] + s->half[2], along = beside * u + up * v, apart = beside * v - up * u;
  int below = beside <= 0 && (beyond > 0 || height == 0);
  int within = beyond <= 0 && height > 0 && apart <= beyond;
  set(s->R + 6, c->u[0]);
  if (below || within) {
    c->kind = NSDAE_PLANE_POINT;
    for (int i = 0; i < 3; i++) c->u[0][i] *= side;
    end_of(s, side, c->x[0]);
  } else if (height == 0 || beyond > 0 || (cone && along < 0)) {
    c->kind = NSDAE_ELLIPSOID_POINT;
    half_axes(s, c->half);
    end_of(s, side, c->x[0]);
  } else if (cone && along > length) {
    end_of(s, 1, c->x[0]);
    c->kind = NSDAE_POINT_POINT;
  } else {
    c->kind = NSDAE_SIDE_POINT;
    set((const double[]){r, -inwards, height}, c->half);
    end_of(s, -1, c->x[0]);
  }
}

void nsdae_point_on_smooth(const nsdae_couple *two, const double *x, nsdae_closest *c)
{
  const nsdae_solid_of *s = two->solid[0];
  double own[3], place[3];
  place_in(two, x, own, place);
  if (s->shape != NSDAE_SHAPE_ELLIPSOID) {
    point_on_turned(s, place, c);
    return;
  }
  c->kind = NSDAE_ELLIPSOID_POINT;
  half_axes(s, c->half);
  set(s->origin, c->x[0]);
}

/* ---- a corner on a box */

/* The face of a box across an axis, on its side 1 or -1. */
static void on_face(const nsdae_solid_of *s, int axis, double side, nsdae_closest *c)
{
  c->kind = NSDAE_PLANE_POINT;
  set(nsdae_solid_corner(s, side > 0 ? 7 : 0), c->x[0]);
  for (int i = 0; i < 3; i++) c->u[0][i] = side * s->R[3 * axis + i];
}

/* One coordinate beyond its half edge is a face, two an edge, three a corner; none is inside, where
 * the nearest face counts. */
static void nearest_on_box(const nsdae_solid_of *s, const double *place, nsdae_closest *c)
{
  int beyond = 0, deepest = 0, within = 0, corner = 0;
  for (int i = 0; i < 3; i++) {
    int out = fabs(place[i]) > s->half[i];
    beyond += out;
    corner |= (place[i] >= 0) << i;
    if (!out) within = i;
    if (fabs(place[i]) - s->half[i] > fabs(place[deepest]) - s->half[deepest]) deepest = i;
  }
  if (beyond <= 1) {
    on_face(s, deepest, place[deepest] < 0 ? -1 : 1, c);
    return;
  }
  c->kind = beyond == 2 ? NSDAE_LINE_POINT : NSDAE_POINT_POINT;
  set(nsdae_solid_corner(s, corner), c->x[0]);
  if (beyond == 2) set(s->R + 3 * within, c->u[0]);
}

/* Whether a place is beside the face across an axis by no more than slack. */
static int is_over(const nsdae_solid_of *s, const double *place, int axis, double slack)
{
  for (int i = 0; i < 3; i++)
    if (i != axis && fabs(place[i]) > s->half[i] + slack) return 0;
  return 1;
}

/* Whether the face that is the least deep can be another than the nearest one to a corner: it is
 * within the box, or came out on the side that is away from its solid, whose middle is given. */
static int may_be_over(const nsdae_solid_of *s, const double *place, const double *middle,
                       double beside)
{
  int out = 0, axis = 0;
  for (int i = 0; i < 3; i++) {
    if (fabs(place[i]) <= s->half[i] + beside) continue;
    axis = i;
    out++;
  }
  if (out != 1) return out == 0;
  /* in the middle rounding says which side that is */
  return fabs(middle[axis]) <= beside || place[axis] * middle[axis] < 0;
}

/* Corners of what overlaps a box touch the face that is the least deep in it, not each the face
 * that is nearest to it: blocks that lie flush keep the common face, though at their corners others
 * are as near. None is deeper than the overlap. */
static int corner_on_box(const nsdae_meeting *met, int base, const double *place, nsdae_closest *c)
{
  const nsdae_solid_of *s = met->two.solid[base];
  const nsdae_separating_axis *o = &met->axis;
  int axis = 0, over = 0;
  if (met->two.solid[1 - base]->points > 1 && o->most <= o->slack) {
    axis = o->axis[base];
    over = o->face[base] >= o->most - o->slack && /* or no corner in the box is deeper than edges */
           may_be_over(s, place, o->way[base], o->beside) && is_over(s, place, axis, o->beside);
  }
  if (over && o->side[base] * place[axis] - s->half[axis] < o->most - o->slack) return 0;
  if (over)
    on_face(s, axis, o->side[base], c);
  else
    nearest_on_box(s, place, c);
  return 1;
}

/* ---- an edge on an edge */

/* The axis along which edge i of a box or capsule runs, and the middle of the edge. */
static int edge_of(const nsdae_solid_of *s, int i, double *middle)
{
  int box = s->shape == NSDAE_SHAPE_BOX, axis = box ? i / 4 : 2;
  int p = (axis + 1) % 3, q = (axis + 2) % 3;
  middle[axis] = 0;
  middle[p] = box ? (i % 2 ? s->half[p] : -s->half[p]) : 0;
  middle[q] = box ? (i / 2 % 2 ? s->half[q] : -s->half[q]) : 0;
  return axis;
}

/* Of the edges of a box along an axis, or of a capsule, and a direction n in the solid's frame:
 * whether n is between the normals of the two faces of each edge, up to its rounding; how far each
 * lies behind the foremost corner, INFINITY if n is more than 45 degrees beyond its faces, which is
 * nearer to another face. A capsule's line is round. */
typedef struct facing {
  int count, between[4];
  double behind[4];
} facing;

static facing face_along(const nsdae_solid_of *s, int axis, const double *n, double rounding)
{
  facing f = {.count = s->shape == NSDAE_SHAPE_BOX ? 4 : 1};
  f.between[0] = 1;
  for (int i = 0; i < f.count && f.count == 4; i++) { /* see edge_of for the sides */
    f.between[i] = 1;
    for (int j = 0; j < 2; j++) {
      int across = (axis + 1 + j) % 3;
      double along = (i >> j & 1) ? n[across] : -n[across];
      if (along < 0) f.behind[i] -= 2 * s->half[across] * along;
      f.between[i] &= along >= -rounding;
      if (along < -sqrt(0.5)) f.behind[i] = INFINITY;
    }
  }
  return f;
}

/* Edges along axis i of solid 0 and j of solid 1 that face each other along the unit vector n at
 * right angles to both, from 0 to 1: n is between the faces of both; or they are behind the nearest
 * features, and a small turn of the bodies brings them there, as corners over a face: they are
 * apart, or n is an axis of no more than twice the least depth. Solids that do not overlap touch
 * with n between the faces alone. */
static void add_facing(nsdae_meeting *met, int i, int j)
{
  const nsdae_separating_axis *o = &met->axis;
  const double *w = o->cosine + 3 * j, scale = o->scale[3 * i + j];
  double n[3], back[3];
  n[i] = 0;
  n[(i + 1) % 3] = -scale * w[(i + 2) % 3];
  n[(i + 2) % 3] = scale * w[(i + 1) % 3];
  for (int l = 0; l < 3; l++) back[l] = -nsdae_dot3(n, o->cosine + 3 * l);
  /* of the cosines: of two rotated axes by quaternions and three products, over the sine |m| */
  double rounding = 16 * DBL_EPSILON * fabs(scale);
  const facing first = face_along(met->two.solid[0], i, n, rounding);
  const facing second = face_along(met->two.solid[1], j, back, rounding);
  int shallow = o->edges[3 * i + j] >= 2 * o->most - o->slack;
  int from[2] = {first.count == 4 ? 4 * i : 0, second.count == 4 ? 4 * j : 0};
  for (int k = 0; k < first.count; k++)
    for (int l = 0; l < second.count; l++) {
      double apart = o->edges[3 * i + j] + first.behind[k] + second.behind[l];
      if ((first.between[k] && second.between[l]) ||
          ((apart > 0 || shallow) && apart <= met->enough && apart < INFINITY))
        met->edges[from[0] + k] |= 1u << (from[1] + l);
    }
}

/* Corners of the other solid that may be within enough of a box: none that is beyond a face by
 * more. If the two overlap it may be beside a face all the same, or beyond it away from its solid:
 * see may_be_over. */
static unsigned near_corners(const nsdae_meeting *met, int base)
{
  const nsdae_solid_of *s = met->two.solid[base], *other = met->two.solid[1 - base];
  const nsdae_separating_axis *o = &met->axis;
  int across = base ? 3 : 1, along = base ? 1 : 3;
  int overlap = o->most <= o->slack;
  double half[3], part[3][3], most = overlap ? fmax(met->enough, o->beside) : met->enough;
  unsigned mask = 0;
  nsdae_half_edges(other, half);
  for (int i = 0; i < 3; i++)
    for (int j = 0; j < 3; j++) part[i][j] = half[j] * o->cosine[i * across + j * along];
  for (int k = 0; k < other->points; k++) {
    int bits = other->points == 8 ? k : k << 2, beyond = 0; /* of a capsule's ends: along z */
    for (int i = 0; i < 3; i++) {
      double way = o->way[base][i], place = way;
      for (int j = 0; j < 3; j++) place += bits >> j & 1 ? part[i][j] : -part[i][j];
      int away = overlap && (place * way < 0 || fabs(way) <= o->beside);
      beyond |= fabs(place) - s->half[i] > most && !away;
    }
    if (!beyond) mask |= 1u << k;
  }
  return mask;
}

static void find_candidates(nsdae_meeting *met)
{
  const nsdae_solid_of *const *s = met->two.solid;
  const nsdae_separating_axis *o = &met->axis;
  for (int i = 0; i < 2; i++)
    if (s[i]->shape == NSDAE_SHAPE_BOX) met->corners[i] = near_corners(met, i);
  for (int i = 0; i < NSDAE_EDGES_MAX; i++) met->edges[i] = 0;
  for (int i = s[0]->shape == NSDAE_SHAPE_BOX ? 0 : 2; i < 3; i++)
    for (int j = s[1]->shape == NSDAE_SHAPE_BOX ? 0 : 2; j < 3; j++)
      if (o->scale[3 * i + j] != 0) add_facing(met, i, j);
}

/* Of solids that overlap only the edges of the axis of least depth touch; see separating_axis.h.
 * Lines along a face are as deep as the face up to rounding, and do. Where these cross within the
 * slack of an end, that corner touches in the same place. With m = e_i x w and
 * d = x_1 - x_0 from middle to middle in the frame of solid 0, b = -(d_p w_p + d_q w_q) / m^2,
 * a = d_i + b w_i are the places of the nearest points: see narrow_phase.c. */
static int edge_on_edge(const nsdae_feature *f, const nsdae_meeting *met, nsdae_closest *c)
{
  const nsdae_solid_of *const *s = met->two.solid;
  const nsdae_separating_axis *o = &met->axis;
  double from[2][3], d[3];
  int axis[2];
  for (int i = 0; i < 2; i++) axis[i] = edge_of(s[i], f->part[i], from[i]);
  nsdae_turn(o->cosine, from[1], d);
  for (int j = 0; j < 3; j++) d[j] += o->way[0][j] - from[0][j];
  const double *w = o->cosine + 3 * axis[1], scale = o->scale[3 * axis[0] + axis[1]];
  int p = (axis[0] + 1) % 3, q = (axis[0] + 2) % 3;
  double b = -(d[p] * w[p] + d[q] * w[q]) * (scale * scale);
  double a = d[axis[0]] + b * w[axis[0]], apart = scale * (w[p] * d[q] - w[q] * d[p]);
  double end = o->most <= o->slack ? o->slack : 0;
  if (fabs(a) > s[0]->half[axis[0]] - end || fabs(b) > s[1]->half[axis[1]] - end) return 0;
  if (apart < 0 && apart < o->most - o->slack) return 0;
  c->kind = NSDAE_LINE_LINE;
  c->side = scale < 0 ? -1 : 1;
  for (int i = 0; i < 2; i++) {
    nsdae_turn(s[i]->R, from[i], c->x[i]);
    for (int j = 0; j < 3; j++) c->x[i][j] += s[i]->origin[j];
    set(s[i]->R + 3 * axis[i], c->u[i]);
  }
  return 1;
}

/* ---- interface */

void nsdae_meet(const nsdae_couple *two, double reach, nsdae_meeting *met)
{
  const nsdae_solid_of *const *s = two->solid;
  met->two = *two;
  met->far = 0;
  met->polyhedra = s[0]->points > 1 && s[1]->points > 1 &&
                   (s[0]->shape == NSDAE_SHAPE_POLYHEDRON || s[1]->shape == NSDAE_SHAPE_POLYHEDRON);
  met->curved = !nsdae_pair_is_exact(s[0], s[1]);
  met->corners[0] = met->corners[1] = ~0u;
  met->enough = INFINITY;
  if (met->curved) {
    met->far = !nsdae_find_manifold(two, reach, &met->manifold);
    return;
  }
  if (reach < INFINITY) { /* with what rounding explains */
    double scale = s[0]->size + s[1]->size, at = 0;
    for (int i = 0; i < 3; i++) at += fabs(two->pose[0]->r[i]) + fabs(two->pose[1]->r[i]);
    met->enough = reach + s[0]->radius + s[1]->radius + NSDAE_SLACK * scale + 32 * DBL_EPSILON * at;
  }
  if (s[0]->points < 2 || s[1]->points < 2) return;
  if (met->polyhedra) {
    nsdae_find_polyhedra(met);
    return;
  }
  if (nsdae_solid_edges(s[0]) == 0) {
    nsdae_find_separations(met);
    return;
  }
  met->far = !nsdae_find_separating_axis(two, met->enough, &met->axis);
  if (!met->far) find_candidates(met);
}

/* Which of the two has the face or edge that a corner touches: corners of the second come first. */
static int base_of(const nsdae_feature *f)
{
  return !f->edges && f->number > f->part[1];
}

static int is_candidate(const nsdae_feature *f, const nsdae_meeting *met)
{
  if (met->polyhedra) return nsdae_polyhedra_near(met, f);
  unsigned mask = f->edges ? met->edges[f->part[0]] : met->corners[base_of(f)];
  return f->part[1] >= 32 || (mask >> f->part[1] & 1) != 0;
}

nsdae_couple nsdae_feature_couple(const nsdae_feature *f, const nsdae_meeting *met)
{
  int base = base_of(f);
  const nsdae_couple *two = &met->two;
  return (nsdae_couple){{two->solid[base], two->solid[1 - base]},
                        {two->pose[base], two->pose[1 - base]}};
}

int nsdae_feature_closest(const nsdae_feature *f, const nsdae_meeting *met, nsdae_closest *c)
{
  const nsdae_couple two = nsdae_feature_couple(f, met);
  const nsdae_solid_of *s0 = two.solid[0], *s1 = two.solid[1];
  if (met->curved) return !met->far && nsdae_manifold_closest(met, f->number, c);
  const double *x1 = s1->point + 3 * f->part[1];
  double place[3], own[3];
  c->side = s0->hollow ? -1 : 1;
  for (int i = 0; i < 2; i++) c->radius[i] = two.solid[i]->radius;
  if (!is_candidate(f, met)) return 0;
  if (f->edges) return met->polyhedra ? nsdae_polyhedra_edges(met, f, c) : edge_on_edge(f, met, c);
  set(x1, c->x[1]);
  if (s0->shape == NSDAE_SHAPE_POLYGON ||
      (s0->shape == NSDAE_SHAPE_SEGMENT && s0->radius > 0 && s1->points > 1))
    return nsdae_polygon_closest(met, base_of(f), f->part[1], c);
  int smooth = nsdae_solid_is_smooth(s0);
  if (s0->shape == NSDAE_SHAPE_PLANE || (s0->points == 1 && !smooth)) {
    c->kind = s0->shape == NSDAE_SHAPE_PLANE ? NSDAE_PLANE_POINT : NSDAE_POINT_POINT;
    set(s0->origin, c->x[0]);
    if (c->kind == NSDAE_PLANE_POINT) set(s0->R + 6, c->u[0]);
    return nsdae_solid_is_smooth(s1) ? nsdae_smooth_on_plane(&two, f->part[1], c) : 1;
  }
  if (smooth) {
    nsdae_point_on_smooth(&two, x1, c);
    return 1;
  }
  place_in(&two, x1, own, place);
  if (s0->shape == NSDAE_SHAPE_POLYHEDRON || (s0->shape == NSDAE_SHAPE_BOX && met->polyhedra))
    return nsdae_polyhedron_closest(met, base_of(f), own, c);
  if (s0->shape == NSDAE_SHAPE_BOX) return corner_on_box(met, base_of(f), place, c);
  corner_on_rod(s0, place, c);
  return 1;
}
