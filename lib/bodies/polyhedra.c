/* Two convex solids of which one is a polyhedron, the other a polyhedron, a box or a capsule's
 * segment. Their Minkowski difference has faces of three kinds: those of the one, those of the
 * other, and one for each pair of edges whose arcs on the Gauss map cross (D. Gregorius, The
 * separating axis test between convex polyhedra, GDC 2013):
 *
 *   edge between faces with the normals A, B:  normals n with  n . e = 0,  n . t_A, n . t_B <= 0
 *   where t is in the face, at right angles to the edge and away from it
 *
 * The largest separation along them is minus the least depth of an overlap: features are chosen by
 * it as those of boxes are (feature.c, separating_axis.h). Cost of a pair: faces x corners, and
 * edges x edges if no face separates it. */
#include <string.h>

#include "narrow_phase.h"
#include "separating_axis.h"

/* How far n may be beyond the faces of an edge and still is between them: corners are in the plane
 * of a face up to 1e-9, and it is 1e-5 wide at least (hull.c). */
static const double facing_rounding = 1e-4;

static const double *plane_of(const nsdae_solid_of *s, int face)
{
  return s->edge + 4 * face;
}

static int faces_of(const nsdae_solid_of *s)
{
  return s->hull->faces;
}

/* ---- separations */

/* Each in the frame of the other's body. */
static void relate(const nsdae_couple *two, nsdae_polyhedra *o)
{
  for (int s = 0; s < 2; s++) {
    const nsdae_pose *here = two->pose[s], *there = two->pose[1 - s];
    double d[3];
    for (int i = 0; i < 3; i++) d[i] = there->r[i] - here->r[i];
    nsdae_turn_back(here->R, d, o->way[s]);
    for (int j = 0; j < 3; j++) nsdae_turn_back(here->R, there->R + 3 * j, o->turn[s] + 3 * j);
  }
}

/* Height of the other's point p over a face of solid s:  above . p + above[3] */
static void heights(const nsdae_polyhedra *o, int s, const double *plane, double above[4])
{
  nsdae_turn_back(o->turn[s], plane, above);
  above[3] = nsdae_dot3(plane, o->way[s]) - plane[3];
}

/* The least and the largest n . x of the corners x. */
static void extent(const nsdae_solid_of *s, const double *n, double *least, double *most)
{
  *least = INFINITY;
  *most = -INFINITY;
  for (int i = 0; i < s->points; i++) {
    double x = nsdae_dot3(n, nsdae_solid_corner(s, i));
    if (x < *least) *least = x;
    if (x > *most) *most = x;
  }
}

static void separate_faces(nsdae_meeting *met, int s)
{
  nsdae_polyhedra *o = &met->hulls;
  o->face[s] = -INFINITY;
  o->best[s] = 0;
  for (int f = 0; f < faces_of(met->two.solid[s]); f++) {
    double above[4], least, most;
    heights(o, s, plane_of(met->two.solid[s], f), above);
    extent(met->two.solid[1 - s], above, &least, &most);
    if (least + above[3] <= o->face[s]) continue;
    o->face[s] = least + above[3];
    o->best[s] = f;
    if (o->face[s] > met->enough) return;
  }
}

/* An edge e from x, and the normals of its faces. */
typedef struct placed_edge {
  double x[3], e[3], face[2][3];
  int faces;
} placed_edge;

/* Edge i of solid s in the frame of the body of solid 1. */
static void place_edge(const nsdae_meeting *met, int s, int i, placed_edge *p)
{
  const nsdae_solid_of *solid = met->two.solid[s];
  const nsdae_polyhedra *o = &met->hulls;
  const int *edge = solid->hull->edge[i];
  const double *from = nsdae_solid_corner(solid, edge[0]), *to = nsdae_solid_corner(solid, edge[1]);
  double e[3];
  p->faces = edge[2] < 0 ? 0 : 2;
  for (int j = 0; j < 3; j++) e[j] = to[j] - from[j];
  if (s == 0) {
    nsdae_turn(o->turn[1], e, p->e);
    nsdae_turn(o->turn[1], from, p->x);
    for (int j = 0; j < 3; j++) p->x[j] += o->way[1][j];
  } else {
    memcpy(p->e, e, sizeof e);
    memcpy(p->x, from, sizeof e);
  }
  for (int f = 0; f < p->faces; f++) {
    const double *n = plane_of(solid, edge[2 + f]);
    if (s == 0)
      nsdae_turn(o->turn[1], n, p->face[f]);
    else
      memcpy(p->face[f], n, sizeof e);
  }
}

/* The side of an edge that n is on: above 0 outside. */
static double outside(const placed_edge *p, const double *n)
{
  return nsdae_dot3(n, p->face[0]) + nsdae_dot3(n, p->face[1]);
}

/* The unit vector n along e_0 x e_1 out of solid 0. 0: there is none, or it is into solid 1 out of
 * both. Edges nearer to parallel than 1e-8: see separating_axis.c. */
static int normal_of(const placed_edge p[2], double *n)
{
  const double parallel = 1e-16;
  nsdae_cross3(p[0].e, p[1].e, n);
  double square = nsdae_dot3(n, n);
  if (!(square > parallel * nsdae_dot3(p[0].e, p[0].e) * nsdae_dot3(p[1].e, p[1].e))) return 0;
  double out[2] = {p[0].faces ? outside(&p[0], n) : 0, p[1].faces ? -outside(&p[1], n) : 0};
  double scale = (p[0].faces ? out[0] : out[1]) < 0 ? -1 / sqrt(square) : 1 / sqrt(square);
  for (int i = 0; i < 3; i++) n[i] *= scale;
  return !p[0].faces || !p[1].faces || out[0] * out[1] > 0;
}

static double separation(const placed_edge p[2], const double *n)
{
  const double d[3] = {p[1].x[0] - p[0].x[0], p[1].x[1] - p[0].x[1], p[1].x[2] - p[0].x[2]};
  return nsdae_dot3(n, d);
}

/* Pairs whose arcs cross: each lies on both sides of the other's great circle. */
static void separate_edges(nsdae_meeting *met)
{
  const nsdae_solid_of *const *s = met->two.solid;
  double n[3], along[2 * NSDAE_CORNERS_MAX]; /* of an edge of solid 0 and each normal of solid 1 */
  placed_edge p[2];
  for (int k = 0; k < s[0]->hull->edges; k++) {
    place_edge(met, 0, k, &p[0]);
    for (int f = 0; f < faces_of(s[1]); f++) along[f] = nsdae_dot3(plane_of(s[1], f), p[0].e);
    for (int l = 0; l < s[1]->hull->edges; l++) {
      const int *edge = s[1]->hull->edge[l];
      if (edge[2] >= 0 && along[edge[2]] * along[edge[3]] >= 0) continue;
      place_edge(met, 1, l, &p[1]);
      if (p[0].faces && nsdae_dot3(p[0].face[0], p[1].e) * nsdae_dot3(p[0].face[1], p[1].e) >= 0)
        continue;
      if (!normal_of(p, n)) continue;
      met->hulls.most = nsdae_more_of(met->hulls.most, separation(p, n));
      if (met->hulls.most > met->enough) return;
    }
  }
}

/* A corner is no nearer to the other solid than it is above its best face. */
static void find_near(nsdae_meeting *met, int s)
{
  nsdae_polyhedra *o = &met->hulls;
  const nsdae_solid_of *solid = met->two.solid[s], *other = met->two.solid[1 - s];
  int overlap = o->most <= o->slack;
  double above[4] = {0, 0, 0, -INFINITY};
  double most = overlap ? fmax(met->enough, o->beside - o->most) : met->enough;
  if (faces_of(other) > 0) heights(o, 1 - s, plane_of(other, o->best[1 - s]), above);
  memset(o->near[s], 0, (size_t)(solid->points + 31) / 32 * sizeof **o->near);
  for (int i = 0; i < solid->points; i++)
    if (nsdae_dot3(above, nsdae_solid_corner(solid, i)) + above[3] <= most)
      o->near[s][i / 32] |= 1u << i % 32;
}

void nsdae_find_polyhedra(nsdae_meeting *met)
{
  nsdae_polyhedra *o = &met->hulls;
  double size = met->two.solid[0]->size + met->two.solid[1]->size;
  o->slack = NSDAE_SLACK * size;
  o->beside = NSDAE_BESIDE * size;
  relate(&met->two, o);
  for (int s = 0; s < 2 && !met->far; s++) {
    separate_faces(met, s);
    met->far = o->face[s] > met->enough;
  }
  if (met->far) return;
  o->most = nsdae_more_of(o->face[0], o->face[1]);
  if (o->most <= o->slack) separate_edges(met);
  met->far = o->most > met->enough;
  for (int s = 0; s < 2 && !met->far; s++) find_near(met, s);
}

/* ---- features */

static int is_near(const nsdae_meeting *met, int s, int corner)
{
  return (met->hulls.near[s][corner / 32] >> corner % 32 & 1) != 0;
}

static int is_near_edge(const nsdae_meeting *met, int s, int i)
{
  const int *edge = met->two.solid[s]->hull->edge[i];
  return is_near(met, s, edge[0]) || is_near(met, s, edge[1]);
}

int nsdae_polyhedra_near(const nsdae_meeting *met, const nsdae_feature *f)
{
  if (f->edges) return is_near_edge(met, 0, f->part[0]) && is_near_edge(met, 1, f->part[1]);
  return is_near(met, f->number == f->part[1], f->part[1]);
}

/* Whether n is between the faces of an edge; -1: it is beyond one by more than half of their angle,
 * nearer to another face. */
static int is_between(const placed_edge *p, const double *n, double sign)
{
  int between = 1;
  if (p->faces == 0) return 1;
  double length = sqrt(nsdae_dot3(p->e, p->e));
  double half = sqrt(fmax(0, 1 - nsdae_dot3(p->face[0], p->face[1])) / 2);
  for (int f = 0; f < 2; f++) {
    double t[3], rise;
    nsdae_cross3(p->face[f], p->e, t);
    rise = sign * (f ? -1 : 1) * nsdae_dot3(n, t) / length;
    if (rise > fmax(half, facing_rounding)) return -1;
    between &= rise <= facing_rounding;
  }
  return between;
}

/* Edges that face each other, or are behind the nearest features by little, as in feature.c. */
static int do_face(const nsdae_meeting *met, const placed_edge p[2], const double *n, double apart)
{
  const nsdae_polyhedra *o = &met->hulls;
  int first = is_between(&p[0], n, 1), second = is_between(&p[1], n, -1);
  if (first > 0 && second > 0) return 1;
  if (first < 0 || second < 0 || apart > met->enough) return 0;
  if (apart > 0) return 1;
  double own[3], least[2], most[2];
  nsdae_turn(met->hulls.turn[0], n, own);
  extent(met->two.solid[0], own, &least[0], &most[0]);
  extent(met->two.solid[1], n, &least[1], &most[1]);
  double shift = nsdae_dot3(n, o->way[1]); /* of the frame of solid 0 */
  return least[1] - most[0] - shift >= 2 * o->most - o->slack;
}

/* With m = e_0 x e_1, d = x_1 - x_0 the nearest points are at  a = m . (d x e_1) / m^2  along e_0,
 * b = m . (d x e_0) / m^2  along e_1: whether both are in 0 .. 1. */
static int do_cross(const placed_edge p[2], double along[2])
{
  double m[3], d[3], side[3];
  nsdae_cross3(p[0].e, p[1].e, m);
  double square = nsdae_dot3(m, m);
  for (int j = 0; j < 3; j++) d[j] = p[1].x[j] - p[0].x[j];
  for (int s = 0; s < 2; s++) {
    nsdae_cross3(d, p[1 - s].e, side);
    along[s] = nsdae_dot3(m, side);
    if (!(along[s] >= 0 && along[s] <= square)) return 0;
    along[s] /= square;
  }
  return square > 0;
}

int nsdae_polyhedra_each(const nsdae_meeting *met, nsdae_edges_fn visit, void *to)
{
  const nsdae_solid_of *const *s = met->two.solid;
  placed_edge p[2];
  double along[2];
  int status = 0;
  for (int k = 0; k < s[0]->hull->edges && status >= 0; k++) {
    if (!is_near_edge(met, 0, k)) continue;
    place_edge(met, 0, k, &p[0]);
    for (int l = 0; l < s[1]->hull->edges && status >= 0; l++) {
      if (!is_near_edge(met, 1, l)) continue;
      const double *from = nsdae_solid_corner(s[1], s[1]->hull->edge[l][0]);
      const double *end = nsdae_solid_corner(s[1], s[1]->hull->edge[l][1]);
      for (int j = 0; j < 3; j++) {
        p[1].x[j] = from[j];
        p[1].e[j] = end[j] - from[j];
      }
      if (do_cross(p, along)) status = visit(to, k, l);
    }
  }
  return status;
}

int nsdae_polyhedra_edges(const nsdae_meeting *met, const nsdae_feature *f, nsdae_closest *c)
{
  const nsdae_polyhedra *o = &met->hulls;
  placed_edge p[2];
  double n[3], m[3], along[2];
  for (int s = 0; s < 2; s++) place_edge(met, s, f->part[s], &p[s]);
  if (!normal_of(p, n) || !do_cross(p, along)) return 0;
  for (int s = 0; s < 2; s++) {
    /* within the slack of its end the corner touches the other's face, in the same place */
    int touches = o->most <= o->slack && o->face[1 - s] >= o->most - o->slack;
    double end = touches ? o->slack / sqrt(nsdae_dot3(p[s].e, p[s].e)) : 0;
    if (fmin(along[s], 1 - along[s]) < end) return 0;
  }
  double apart = separation(p, n);
  if ((apart < 0 && apart < o->most - o->slack) || !do_face(met, p, n, apart)) return 0;
  nsdae_cross3(p[0].e, p[1].e, m);
  c->kind = NSDAE_LINE_LINE;
  c->side = nsdae_dot3(m, n) < 0 ? -1 : 1;
  for (int s = 0; s < 2; s++) {
    const nsdae_solid_of *solid = met->two.solid[s];
    const int *edge = solid->hull->edge[f->part[s]];
    const double *from = nsdae_solid_corner(solid, edge[0]);
    double e[3];
    for (int j = 0; j < 3; j++) e[j] = nsdae_solid_corner(solid, edge[1])[j] - from[j];
    nsdae_unit_vector(e, c->u[s]);
    for (int j = 0; j < 3; j++) c->x[s][j] = from[j] + e[j] / 2;
  }
  return 1;
}

/* ---- a corner on a polyhedron */

static void on_face(const nsdae_solid_of *s, int face, nsdae_closest *c)
{
  c->kind = NSDAE_PLANE_POINT;
  for (int j = 0; j < 3; j++) {
    c->u[0][j] = plane_of(s, face)[j];
    c->x[0][j] = plane_of(s, face)[3] * plane_of(s, face)[j];
  }
}

/* Whether x is within the prism over a face, or beside it by no more than slack. */
static int is_over(const nsdae_solid_of *s, int face, const double *x, double slack)
{
  const nsdae_hull *h = s->hull;
  const double *n = plane_of(s, face),
               *from = nsdae_solid_corner(s, h->ring[h->first[face + 1] - 1]);
  for (int i = h->first[face]; i < h->first[face + 1]; i++) {
    const double *to = nsdae_solid_corner(s, h->ring[i]);
    double e[3], d[3], out[3];
    for (int j = 0; j < 3; j++) {
      e[j] = to[j] - from[j];
      d[j] = x[j] - from[j];
    }
    nsdae_cross3(e, n, out);
    if (nsdae_dot3(out, d) > slack * sqrt(nsdae_dot3(out, out))) return 0;
    from = to;
  }
  return 1;
}

/* Outside: the nearest edge of those that see x, or an end of it. */
static void on_edge(const nsdae_solid_of *s, const double *x, nsdae_closest *c)
{
  const nsdae_hull *h = s->hull;
  double least = INFINITY;
  for (int i = 0; i < h->edges; i++) {
    const double *from = nsdae_solid_corner(s, h->edge[i][0]);
    const double *to = nsdae_solid_corner(s, h->edge[i][1]);
    const double *a = plane_of(s, h->edge[i][2]), *b = plane_of(s, h->edge[i][3]);
    double e[3], d[3], square = 0;
    if (nsdae_dot3(a, x) <= a[3] && nsdae_dot3(b, x) <= b[3]) continue;
    for (int j = 0; j < 3; j++) {
      e[j] = to[j] - from[j];
      d[j] = x[j] - from[j];
    }
    double along = nsdae_dot3(e, d) / nsdae_dot3(e, e), at = fmin(fmax(along, 0), 1);
    for (int j = 0; j < 3; j++) square += (d[j] - at * e[j]) * (d[j] - at * e[j]);
    if (!(square < least)) continue;
    least = square;
    c->kind = at == along ? NSDAE_LINE_POINT : NSDAE_POINT_POINT;
    memcpy(c->x[0], along > 1 ? to : from, sizeof e);
    nsdae_unit_vector(e, c->u[0]);
  }
}

static void nearest(const nsdae_solid_of *s, const double *x, nsdae_closest *c)
{
  double most = -INFINITY;
  int highest = 0;
  for (int f = 0; f < faces_of(s); f++) {
    double height = nsdae_dot3(plane_of(s, f), x) - plane_of(s, f)[3];
    if (height > 0 && is_over(s, f, x, 0)) {
      on_face(s, f, c);
      return;
    }
    if (height <= most) continue;
    most = height;
    highest = f;
  }
  if (most <= 0)
    on_face(s, highest, c);
  else
    on_edge(s, x, c);
}

/* Of what overlaps a corner over the face of least depth touches it, and is no deeper. */
int nsdae_polyhedron_closest(const nsdae_meeting *met, int base, const double *x, nsdae_closest *c)
{
  const nsdae_solid_of *s = met->two.solid[base];
  const nsdae_polyhedra *o = &met->hulls;
  if (met->polyhedra && o->most <= o->slack && o->face[base] >= o->most - o->slack &&
      is_over(s, o->best[base], x, o->beside)) {
    const double *plane = plane_of(s, o->best[base]);
    if (nsdae_dot3(plane, x) - plane[3] < o->most - o->slack) return 0;
    on_face(s, o->best[base], c);
    return 1;
  }
  nearest(s, x, c);
  return 1;
}
