/* A solid on a mesh. Contacts are corners of the solid on faces, sharp edges and sharp corners of
 * the mesh; sharp corners of the mesh on the solid; sharp edges on edges.
 *
 * A contact at the place a of the surface with the direction d, out of it, counts if d is in the
 * normal cone of the surface there: for every triangle that has a, with the corners x_k,
 *
 *   d . (x_k - a) <= 0,   and n . d >= 0 for one of them
 *
 * So nothing catches at edges that are flat or in a valley, whoever they belong to (S. Goldenthal
 * et al. call it Voronoi filtering; Bullet's btInternalEdgeUtility corrects normals instead).
 *
 * Of a corner beneath the surface the nearest face counts. Where two faces meet in a valley what is
 * behind both is in contact with both: beyond the edge a face reaches on beneath its neighbour.
 *
 * A solid that overlaps a sharp place of the surface is apart from it by at least
 *
 *   s(n) = min_i n . (x_i - a)   for each direction n of the normal cone, corners x_i
 *
 * and the largest s is the least depth: a contact that is deeper is none (separating_axis.h). The
 * directions are the normals of the faces at a and those of pairs of edges.
 *
 * Where the least gap jumps: overlaps of edges deeper than rest, over corners of the mesh; and
 * corners of a solid less than near_valley from a corner in a valley, by no more than that. */
#include <string.h>

#include "mesh.h"
#include "separating_axis.h"
#include "support.h"

/* As in feature.c: how far a direction may be beyond faces and still is between them; and beyond
 * which of an edge it is nearer to another face. */
static const double facing_rounding = 1e-4, behind = 0.70710678118654752;

typedef struct probe {
  const nsdae_mesh *m;
  const nsdae_solid_of *s;
  const nsdae_couple *two;
  nsdae_contact_fn add;
  void *to;
  double reach, slack;
  double x[3 * NSDAE_CORNERS_MAX]; /* corners in space */
  int i;                           /* the corner that is looked at */
  double low[3], high[3];          /* of all corners, with the reach */
} probe;

static void between(const double *from, const double *to, double *d)
{
  for (int j = 0; j < 3; j++) d[j] = to[j] - from[j];
}

static void set(const double *from, double *to)
{
  memcpy(to, from, 3 * sizeof *to);
}

static int emit(const probe *p, int part, long of_mesh, nsdae_closest *c, int turned)
{
  const nsdae_couple *two = p->two;
  const nsdae_couple back = {{two->solid[1], two->solid[0]}, {two->pose[1], two->pose[0]}};
  c->side = c->kind == NSDAE_LINE_LINE ? c->side : 1;
  c->radius[turned] = 0;
  c->radius[1 - turned] = p->s->radius;
  return p->add(p->to, part * nsdae_mesh_parts(p->m) + of_mesh, c, turned ? &back : two);
}

/* ---- places and triangles */

/* The place 0 .. 1 nearest to x along the line from a to b, not bounded; d := x minus its foot. */
static double foot_on(const double *a, const double *b, const double *x, double *d)
{
  double e[3];
  between(a, b, e);
  between(a, x, d);
  double along = nsdae_dot3(e, d) / nsdae_dot3(e, e), at = fmin(fmax(along, 0), 1);
  for (int j = 0; j < 3; j++) d[j] -= at * e[j];
  return along;
}

static double distance_to(const nsdae_mesh *m, int t, const double *x)
{
  double d[3], least = INFINITY;
  int beside = 0;
  for (int k = 0; k < 3; k++) beside |= nsdae_mesh_beyond(m, t, k, x) > 0;
  if (!beside) return fabs(nsdae_mesh_height(m, t, x));
  for (int k = 0; k < 3; k++) {
    foot_on(nsdae_mesh_corner(m, t, k), nsdae_mesh_corner(m, t, k + 1), x, d);
    least = fmin(least, nsdae_dot3(d, d));
  }
  return sqrt(least);
}

/* ---- the normal cone */

typedef struct cone {
  const probe *p;
  const double *a, *d; /* place; direction, a unit vector */
  int out;             /* n . d >= 0 for one triangle */
  double apart;        /* the largest s(n) of their normals n */
} cone;

/* The least n . (x - a) of the corners x. */
static double separation(const probe *p, const double *a, const double *n)
{
  double least = INFINITY, d[3];
  for (int i = 0; i < p->s->points; i++) {
    between(a, p->x + 3 * i, d);
    least = fmin(least, nsdae_dot3(n, d));
  }
  return least;
}

static int look_at(void *to, int t)
{
  cone *c = to;
  const nsdae_mesh *m = c->p->m;
  double e[3];
  if (distance_to(m, t, c->a) > m->flat) return 0;
  for (int k = 0; k < 3; k++) {
    between(c->a, nsdae_mesh_corner(m, t, k), e);
    if (nsdae_dot3(c->d, e) > facing_rounding * sqrt(nsdae_dot3(e, e)) + m->rounding) return 1;
  }
  c->out |= nsdae_dot3(m->normal + 3L * t, c->d) >= -facing_rounding;
  c->apart = fmax(c->apart, separation(c->p, c->a, m->normal + 3L * t));
  return 0;
}

/* Whether the direction d is in the normal cone at a; *apart: of the normals there. */
static int in_normal_cone(const probe *p, const double *a, const double *d, double *apart)
{
  cone c = {.p = p, .a = a, .d = d, .apart = -INFINITY};
  int no = nsdae_mesh_about(p->m, a, p->m->flat, look_at, &c);
  if (apart) *apart = c.apart;
  return !no && c.out;
}

/* ---- a corner of the solid on a face */

/* How near a valley a face still reaches on, in parts of the thickness: depths of contacts at rest,
 * 5e-5, are within 0.01 of 0.1. */
static const double near_valley = 0.01;

/* Whether x, beyond side k of a triangle, is behind the valley there: beneath the neighbour and
 * beyond its side as well, or as near the valley as depths at rest. 2: beside the edge itself. */
static int is_behind_valley(const nsdae_mesh *m, int t, int k, double beyond, const double *x)
{
  double near = near_valley * m->thickness, d[3];
  int other = m->beside[t][k], over = beyond <= near;
  if (!(m->mark[t] & NSDAE_VALLEY << k) || beyond > m->thickness) return 0;
  if (nsdae_mesh_height(m, other, x) > m->rounding) return 0;
  double along = foot_on(nsdae_mesh_corner(m, t, k), nsdae_mesh_corner(m, t, k + 1), x, d);
  for (int l = 0; l < 3; l++) {
    double past = nsdae_mesh_beyond(m, other, l, x);
    if (m->beside[other][l] == t && along >= 0 && along <= 1 && past >= -near) return 2;
    over &= past <= near;
  }
  return over;
}

/* Whether x is over a triangle; 2: it is beyond a side where the face reaches on. */
static int covers(const nsdae_mesh *m, int t, const double *x)
{
  int over = 1;
  for (int k = 0; k < 3; k++) {
    double beyond = nsdae_mesh_beyond(m, t, k, x);
    if (beyond <= m->rounding) continue;
    int behind_it = is_behind_valley(m, t, k, beyond, x);
    if (behind_it == 2) return 2;
    over = behind_it ? 2 * (over > 0) : 0;
  }
  return over;
}

typedef struct search {
  const nsdae_mesh *m;
  const double *x;
  double depth;
  int t, over;
} search;

/* Of the triangles of a face that cover x one counts: over it before beyond a side, in order. */
static int covers_before(void *to, int t)
{
  const search *s = to;
  if (t == s->t || s->m->face[t] != s->m->face[s->t]) return 0;
  int over = covers(s->m, t, s->x);
  return over > 0 && (over < s->over || (over == s->over && t < s->t));
}

static int is_nearer(void *to, int t)
{
  const search *s = to;
  const nsdae_mesh *m = s->m;
  return m->face[t] != m->face[s->t] && m->piece[m->corner[t][0]] == m->piece[m->corner[s->t][0]] &&
         distance_to(m, t, s->x) < s->depth - m->rounding;
}

/* c: the kind of the contact, and half axes of a smooth shape. */
static int corner_on_face(const probe *p, int t, nsdae_closest c)
{
  const nsdae_mesh *m = p->m;
  const double *x = p->x + 3 * p->i;
  int face = m->face[t];
  double height = nsdae_mesh_height(m, face, x);
  if (height - p->s->radius > p->reach || height < -m->thickness) return 0;
  int over = covers(m, t, x);
  search s = {m, x, -height, t, over};
  double within = over == 1 ? fabs(height) + m->rounding : fmax(m->thickness, fabs(height));
  if (!over || nsdae_mesh_about(m, x, within, covers_before, &s)) return 0;
  if (over == 1 && height < 0 && nsdae_mesh_about(m, x, -height, is_nearer, &s)) return 0;
  set(nsdae_mesh_corner(m, face, 0), c.x[0]);
  set(m->normal + 3L * face, c.u[0]);
  set(nsdae_solid_corner(p->s, p->i), c.x[1]);
  return emit(p, p->i, face, &c, 0);
}

/* ---- a corner of the solid on a sharp edge or corner */

/* Where d is from the place a of the surface to the corner. */
static int corner_on_sharp(const probe *p, const double *a, double *d, long of_mesh,
                           nsdae_closest *c)
{
  double length = sqrt(nsdae_dot3(d, d));
  if (length - p->s->radius > p->reach || length <= p->m->rounding) return 0;
  for (int j = 0; j < 3; j++) d[j] /= length;
  if (!in_normal_cone(p, a, d, NULL)) return 0;
  set(nsdae_solid_corner(p->s, p->i), c->x[1]);
  return emit(p, p->i, of_mesh, c, 0);
}

static int corner_on_triangle(void *to, int t)
{
  const probe *p = to;
  const nsdae_mesh *m = p->m;
  const double *x = p->x + 3 * p->i;
  int status = corner_on_face(p, t, (nsdae_closest){.kind = NSDAE_PLANE_POINT});
  for (int k = 0; k < 3 && status >= 0; k++) {
    const double *a = nsdae_mesh_corner(m, t, k), *b = nsdae_mesh_corner(m, t, k + 1);
    double d[3], foot[3];
    if (m->mark[t] & NSDAE_SHARP_CORNER << k) {
      nsdae_closest c = {.kind = NSDAE_POINT_POINT};
      set(a, c.x[0]);
      between(a, x, d);
      status = corner_on_sharp(p, a, d, 4L * m->triangles + m->corner[t][k], &c);
    }
    if (status < 0 || !(m->mark[t] & NSDAE_SHARP_SIDE << k)) continue;
    double along = foot_on(a, b, x, d);
    if (!(along >= 0 && along <= 1)) continue;
    nsdae_closest c = {.kind = NSDAE_LINE_POINT};
    set(a, c.x[0]);
    between(a, b, c.u[0]);
    nsdae_unit_vector(c.u[0], c.u[0]);
    for (int j = 0; j < 3; j++) foot[j] = x[j] - d[j];
    status = corner_on_sharp(p, foot, d, m->triangles + 3L * t + k, &c);
  }
  return status < 0 ? status : 0;
}

/* ---- a sharp corner of the mesh on the solid */

/* On the line of a capsule, or from outside on a polyhedron: the direction from the corner v to it.
 * 0: a corner of the solid is nearest. */
static int nearest_part(const probe *p, const double *own, nsdae_closest *c, double *d)
{
  const nsdae_solid_of *s = p->s;
  const nsdae_pose *pose = p->two->pose[1];
  double foot[3];
  c->kind = NSDAE_LINE_POINT;
  if (s->hull->faces == 0) {
    double along = foot_on(nsdae_solid_corner(s, 0), nsdae_solid_corner(s, 1), own, foot);
    if (!(along > 0 && along < 1)) return 0;
    set(nsdae_solid_corner(s, 0), c->x[0]);
    set(s->R + 6, c->u[0]);
  } else {
    nsdae_meeting met = {.two = *p->two, .polyhedra = 0};
    nsdae_polyhedron_closest(&met, 1, own, c);
    if (c->kind == NSDAE_POINT_POINT) return 0;
    between(c->x[0], own, foot);
    double along = nsdae_dot3(foot, c->u[0]);
    for (int j = 0; j < 3; j++)
      foot[j] = c->kind == NSDAE_PLANE_POINT ? along * c->u[0][j] : foot[j] - along * c->u[0][j];
  }
  for (int j = 0; j < 3; j++) foot[j] = -foot[j];
  nsdae_turn(pose->R, foot, d);
  return 1;
}

/* Within a polyhedron: the least deep of its faces whose normal is in the cone; where three meet
 * the two others are as near up to rounding. */
static int deepest_face(const probe *p, const double *v, const double *own, nsdae_closest *c)
{
  const nsdae_solid_of *s = p->s;
  double before = INFINITY, d[3], apart;
  int last = -1;
  for (int tries = 0; tries < 3; tries++) {
    double height = -INFINITY;
    int best = -1;
    for (int f = 0; f < s->hull->faces; f++) {
      double h = nsdae_dot3(s->edge + 4 * f, own) - s->edge[4 * f + 3];
      if (h > before || (h == before && f <= last) || h <= height) continue;
      height = h;
      best = f;
    }
    if (best < 0 || height < -p->m->thickness) return 0;
    const double *plane = s->edge + 4 * best;
    nsdae_turn(p->two->pose[1]->R, plane, d);
    for (int j = 0; j < 3; j++) d[j] = -d[j];
    before = height;
    last = best;
    if (!in_normal_cone(p, v, d, &apart)) continue;
    if (height < apart - p->slack) return 0;
    c->kind = NSDAE_PLANE_POINT;
    for (int j = 0; j < 3; j++) {
      c->u[0][j] = plane[j];
      c->x[0][j] = plane[3] * plane[j];
    }
    return 1;
  }
  return 0;
}

static int mesh_corner(const probe *p, int t, int k)
{
  const nsdae_mesh *m = p->m;
  const nsdae_solid_of *s = p->s;
  const nsdae_pose *pose = p->two->pose[1];
  const double *v = nsdae_mesh_corner(m, t, k);
  double d[3], own[3], inside = -INFINITY;
  for (int j = 0; j < 3; j++)
    if (!(v[j] >= p->low[j] && v[j] <= p->high[j])) return 0;
  between(pose->r, v, d);
  nsdae_turn_back(pose->R, d, own);
  for (int f = 0; f < s->hull->faces; f++)
    inside = fmax(inside, nsdae_dot3(s->edge + 4 * f, own) - s->edge[4 * f + 3]);
  nsdae_closest c = {.kind = NSDAE_PLANE_POINT};
  if (s->hull->faces == 0 || inside > 0) {
    if (!nearest_part(p, own, &c, d)) return 0;
    double length = sqrt(nsdae_dot3(d, d));
    if (length - s->radius > p->reach || !nsdae_unit_vector(d, d)) return 0;
    if (!in_normal_cone(p, v, d, NULL)) return 0;
  } else if (!deepest_face(p, v, own, &c)) {
    return 0;
  }
  set(v, c.x[1]);
  return emit(p, s->points + s->hull->edges, 4L * m->triangles + m->corner[t][k], &c, 1);
}

/* ---- a sharp edge of the mesh on the edges of the solid */

/* Lines through x_i along e_i, from mesh to solid. */
typedef struct crossing {
  double x[2][3], e[2][3], n[3], a[3]; /* n: unit normal out of the mesh; a: place on the mesh */
  double gap, apart;                   /* of the lines; s(n) */
  double side;                         /* n along side e_0 x e_1 */
} crossing;

/* 0: they do not cross, or are nearer to parallel than 1e-8 (separating_axis.c). out: a direction
 * out of the mesh. See polyhedra.c for the places. */
static int cross(const probe *p, int l, const double *out, crossing *c)
{
  const int *edge = p->s->hull->edge[l];
  double m[3], d[3], side[3];
  set(p->x + 3 * edge[0], c->x[1]);
  between(c->x[1], p->x + 3 * edge[1], c->e[1]);
  nsdae_cross3(c->e[0], c->e[1], m);
  between(c->x[0], c->x[1], d);
  double square = nsdae_dot3(m, m), along[2];
  if (!(square > 1e-16 * nsdae_dot3(c->e[0], c->e[0]) * nsdae_dot3(c->e[1], c->e[1]))) return 0;
  for (int s = 0; s < 2; s++) {
    nsdae_cross3(d, c->e[1 - s], side);
    along[s] = nsdae_dot3(m, side) / square;
    /* within rounding of its end the corner of the solid touches a face, in the same place */
    double end = s ? p->m->rounding / sqrt(nsdae_dot3(c->e[1], c->e[1])) : 0;
    if (!(along[s] >= end && along[s] <= 1 - end)) return 0;
  }
  c->side = nsdae_dot3(m, out) < 0 ? -1 : 1;
  for (int j = 0; j < 3; j++) {
    c->n[j] = c->side * m[j] / sqrt(square);
    c->a[j] = c->x[0][j] + along[0] * c->e[0][j];
  }
  c->gap = nsdae_dot3(c->n, d);
  return c->gap - p->s->radius <= p->reach && c->gap >= -p->m->thickness;
}

/* Whether the edge of the solid faces the surface along n, up to 45 degrees. */
static int faces_it(const probe *p, const crossing *c)
{
  for (int i = 0; i < p->s->points; i++) {
    double d[3], along;
    between(c->a, p->x + 3 * i, d);
    along = nsdae_dot3(c->n, d) - c->gap;
    for (int j = 0; j < 3; j++) d[j] -= c->gap * c->n[j];
    if (-along > behind * sqrt(nsdae_dot3(d, d)) + p->slack) return 0;
  }
  return 1;
}

/* In the first pass *best becomes the largest s(n); in the second contacts are those of it. */
static int mesh_edge(const probe *p, int t, int k)
{
  const nsdae_mesh *m = p->m;
  const double *a = nsdae_mesh_corner(m, t, k), *b = nsdae_mesh_corner(m, t, k + 1);
  double out[3], best = -INFINITY, apart;
  int other = m->beside[t][k], status = 0;
  for (int j = 0; j < 3; j++) {
    if (fmin(a[j], b[j]) > p->high[j] || fmax(a[j], b[j]) < p->low[j]) return 0;
    out[j] = m->normal[3L * t + j] + (other < 0 ? 0 : m->normal[3L * other + j]);
  }
  for (int pass = 0; pass < 2 && status >= 0; pass++)
    for (int l = 0; l < p->s->hull->edges && status >= 0; l++) {
      crossing c;
      set(a, c.x[0]);
      between(a, b, c.e[0]);
      if (!cross(p, l, out, &c) || !faces_it(p, &c) || !in_normal_cone(p, c.a, c.n, &apart))
        continue;
      c.apart = separation(p, c.a, c.n);
      if (pass == 0) best = fmax(best, fmax(apart, c.apart));
      if (pass == 0 || (c.gap < 0 && fmin(c.gap, c.apart / 2) < best - p->slack)) continue;
      nsdae_closest found = {.kind = NSDAE_LINE_LINE, .side = c.side};
      const double *from = nsdae_solid_corner(p->s, p->s->hull->edge[l][0]);
      set(a, found.x[0]);
      nsdae_unit_vector(c.e[0], found.u[0]);
      set(from, found.x[1]);
      between(from, nsdae_solid_corner(p->s, p->s->hull->edge[l][1]), found.u[1]);
      nsdae_unit_vector(found.u[1], found.u[1]);
      status = emit(p, p->s->points + l, m->triangles + 3L * t + k, &found, 0);
    }
  return status;
}

static int sharp_parts(void *to, int t)
{
  const probe *p = to;
  int status = 0;
  for (int k = 0; k < 3 && status >= 0; k++) {
    if (p->m->mark[t] & NSDAE_SHARP_CORNER << k) status = mesh_corner(p, t, k);
    if (status >= 0 && (p->m->mark[t] & NSDAE_SHARP_SIDE << k)) status = mesh_edge(p, t, k);
  }
  return status < 0 ? status : 0;
}

/* ---- smooth shapes
 *
 * Their corners (feature.c) touch a face as they touch its plane, if they are over it; a sharp
 * corner of the mesh touches them as a point does. A sharp edge is a segment: its contacts are
 * those of its manifold, for time stepping, of which the ends are corners. */

static int smooth_on_face(probe *p, int t)
{
  const nsdae_mesh *m = p->m;
  int status = 0;
  for (p->i = 0; p->i < p->s->points && status >= 0; p->i++) {
    nsdae_closest c = {.kind = NSDAE_PLANE_POINT};
    double own[3], d[3];
    set(m->normal + 3L * m->face[t], c.u[0]);
    if (!nsdae_smooth_on_plane(p->two, p->i, &c)) continue;
    set(nsdae_solid_corner(p->s, p->i), own);
    if (c.kind == NSDAE_PLANE_ELLIPSOID) {
      nsdae_turn_back(p->two->pose[1]->R, c.u[0], d);
      for (int j = 0; j < 3; j++) d[j] = -d[j];
      nsdae_round_end(p->s, nsdae_solid_corner(p->s, p->i), d, own);
    }
    nsdae_pose_put(p->two->pose[1], own, p->x + 3 * p->i);
    status = corner_on_face(p, t, c);
  }
  return status;
}

static int corner_on_smooth(const probe *p, int t, int k)
{
  const nsdae_couple back = {{p->two->solid[1], p->two->solid[0]},
                             {p->two->pose[1], p->two->pose[0]}};
  nsdae_closest c = {.side = 1};
  const double *v = nsdae_mesh_corner(p->m, t, k);
  double d[3];
  set(v, c.x[1]);
  nsdae_point_on_smooth(&back, v, &c);
  const nsdae_still still = nsdae_closest_still(&c, &back);
  for (int j = 0; j < 3; j++) d[j] = -still.normal[j];
  if (still.gap > p->reach || still.gap < -p->m->thickness || !in_normal_cone(p, v, d, NULL))
    return 0;
  return emit(p, p->s->points, 4L * p->m->triangles + p->m->corner[t][k], &c, 1);
}

static int edge_on_smooth(const probe *p, int t, int k)
{
  const nsdae_mesh *m = p->m;
  double end[6], way[3], from[3];
  nsdae_solid_of edge = {
      .shape = NSDAE_SHAPE_CAPSULE, .points = 2, .point = end, .hull = &nsdae_capsule_hull};
  set(nsdae_mesh_corner(m, t, k), end);
  set(nsdae_mesh_corner(m, t, k + 1), end + 3);
  between(end, end + 3, way);
  nsdae_unit_vector(way, edge.R + 6);
  nsdae_complete_frame(edge.R + 6, edge.R, edge.R + 3);
  edge.size = edge.half[2] = sqrt(nsdae_dot3(way, way)) / 2;
  for (int j = 0; j < 3; j++) edge.origin[j] = (end[j] + end[3 + j]) / 2;
  nsdae_meeting met = {.two = {{&edge, p->s}, {p->two->pose[0], p->two->pose[1]}}};
  if (!nsdae_find_manifold(&met.two, p->reach, &met.manifold)) return 0;
  int status = 0;
  for (int i = 0; i < met.manifold.count && status >= 0; i++) {
    const nsdae_still *at = &met.manifold.at[i];
    nsdae_closest c;
    double along = foot_on(end, end + 3, at->at[0], from), slack = p->slack / edge.size;
    if (at->gap > p->reach || at->gap < -m->thickness || along < slack || along > 1 - slack)
      continue;
    if (!in_normal_cone(p, at->at[0], at->normal, NULL)) continue;
    nsdae_manifold_closest(&met, met.manifold.number[i], &c);
    status = emit(p, p->s->points + 1 + met.manifold.number[i], m->triangles + 3L * t + k, &c, 0);
  }
  return status;
}

static int smooth_on_triangle(void *to, int t)
{
  probe *p = to;
  int status = smooth_on_face(p, t);
  for (int k = 0; k < 3 && status >= 0; k++) {
    if (p->m->mark[t] & NSDAE_SHARP_CORNER << k) status = corner_on_smooth(p, t, k);
    if (status >= 0 && (p->m->mark[t] & NSDAE_SHARP_SIDE << k)) status = edge_on_smooth(p, t, k);
  }
  return status < 0 ? status : 0;
}

/* The box of its support points, with the reach. */
static int smooth_contacts(probe *p)
{
  const nsdae_pose *pose = p->two->pose[1];
  for (int j = 0; j < 6; j++) {
    double d[3] = {0, 0, 0}, own[3], x[3];
    d[j % 3] = j < 3 ? -1 : 1;
    nsdae_turn_back(pose->R, d, own);
    nsdae_support(p->s, own, x);
    nsdae_pose_put(pose, x, own);
    (j < 3 ? p->low : p->high)[j % 3] = own[j % 3] + d[j % 3] * p->reach;
  }
  return nsdae_mesh_visit(p->m, p->low, p->high, smooth_on_triangle, p);
}

int nsdae_mesh_contacts(const nsdae_couple *two, double reach, nsdae_contact_fn add, void *to)
{
  probe p = {.m = two->solid[0]->mesh,
             .s = two->solid[1],
             .two = two,
             .add = add,
             .to = to,
             .reach = reach};
  double within = reach + p.s->radius;
  int status = 0;
  p.slack = NSDAE_SLACK * p.s->size + p.m->rounding;
  for (int j = 0; j < 3; j++) {
    p.low[j] = INFINITY;
    p.high[j] = -INFINITY;
  }
  for (int i = 0; i < p.s->points; i++) {
    nsdae_pose_put(two->pose[1], nsdae_solid_corner(p.s, i), p.x + 3 * i);
    for (int j = 0; j < 3; j++) {
      p.low[j] = fmin(p.low[j], p.x[3 * i + j] - within);
      p.high[j] = fmax(p.high[j], p.x[3 * i + j] + within);
    }
  }
  if (nsdae_solid_is_smooth(p.s)) return smooth_contacts(&p);
  for (p.i = 0; p.i < p.s->points && status >= 0; p.i++)
    status = nsdae_mesh_about(p.m, p.x + 3 * p.i, within, corner_on_triangle, &p);
  if (p.s->points > 1 && status >= 0)
    status = nsdae_mesh_visit(p.m, p.low, p.high, sharp_parts, &p);
  return status;
}
