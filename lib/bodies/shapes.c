/* Solids: their shapes as corners in the body's frame, their inertia, and the features of two. */
#include <limits.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "errors.h"
#include "bodies_impl.h"
#include "mesh.h"
#include "support.h"

/* Solids in the plane, in space; their corners (a polygon has its own number), and what is above 0:
 * the radius, bit i of lengths for length[i]. */
static const struct {
  const char *name;
  int planar, spatial, corners, rounded, lengths;
} kinds[] = {
    [NSDAE_SHAPE_POINT] = {"point", 1, 1, 1, 0, 0},
    [NSDAE_SHAPE_DISC] = {"disc", 1, 1, 1, 1, 0}, /* in space four, as each end of a cylinder */
    [NSDAE_SHAPE_SEGMENT] = {"segment", 1, 0, 2, 0, 1},
    [NSDAE_SHAPE_POLYGON] = {"polygon", 1, 0, 0, 0, 0},
    [NSDAE_SHAPE_PATH] = {"path", 0, 0, 0, 0, 0},
    [NSDAE_SHAPE_SPHERE] = {"sphere", 0, 1, 1, 1, 0},
    [NSDAE_SHAPE_CAPSULE] = {"capsule", 0, 1, 2, 1, 1 << 2},
    [NSDAE_SHAPE_BOX] = {"box", 0, 1, 8, 0, 7},
    [NSDAE_SHAPE_PLANE] = {"plane", 1, 1, 0, 0, 0},
    [NSDAE_SHAPE_POLYHEDRON] = {"polyhedron", 0, 1, 0, 0, 0},
    [NSDAE_SHAPE_CYLINDER] = {"cylinder", 0, 1, 8, 1, 1 << 2},
    [NSDAE_SHAPE_CONE] = {"cone", 0, 1, 5, 1, 1 << 2},
    [NSDAE_SHAPE_ELLIPSOID] = {"ellipsoid", 0, 1, 1, 0, 7},
    [NSDAE_SHAPE_MESH] = {"mesh", 0, 1, 0, 0, 1 << 2},
    [NSDAE_SHAPE_HEIGHT_FIELD] = {"height field", 0, 1, 0, 0, 7},
};

const char *nsdae_solid_name(int shape)
{
  return kinds[shape].name;
}

/* ---- checks of a solid */

/* What is wrong with a polygon's corners, into the record. */
static int check_polygon(const nsdae_solid *s, nsdae_error *error)
{
  const char *where = "nsdae_solid";
  if (s->points < 3 || !s->point)
    return nsdae_error_set(error, NSDAE_E_ARGUMENT, where, "points",
                           "points = %d of a polygon is less than 3, or point is NULL", s->points);
  for (int i = 0; i < 2 * s->points; i++)
    if (!isfinite(s->point[i]))
      return nsdae_error_set(error, NSDAE_E_NONFINITE, where, "point",
                             "corner %d of the polygon is at %g, which is not a finite number",
                             i / 2, s->point[i]);
  for (int i = 0; i < s->points; i++) {
    int middle = (i + 1) % s->points;
    const double *a = s->point + 2 * i, *b = s->point + 2 * middle;
    const double *c = s->point + 2 * ((i + 2) % s->points);
    if (!((b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]) > 0))
      return nsdae_error_set(
          error, NSDAE_E_ARGUMENT, where, "point",
          "corner %d of the polygon is no left turn: the polygon must be convex, "
          "its corners in anticlockwise order",
          middle);
  }
  /* How often the edges of a polygon that turns left at every corner go around: as often as their
   * direction comes from below (or from straight left) to above. A star of five goes twice. */
  int turns = 0, before = 0;
  for (int i = 0; i <= s->points; i++) {
    const double *a = s->point + 2 * (i % s->points), *b = s->point + 2 * ((i + 1) % s->points);
    int above = b[1] - a[1] > 0 || (b[1] - a[1] == 0 && b[0] - a[0] > 0);
    turns += i > 0 && above && !before;
    before = above;
  }
  if (turns == 1) return NSDAE_OK;
  return nsdae_error_set(error, NSDAE_E_ARGUMENT, where, "point",
                         "the corners of the polygon wind around it %d times: they must wind once",
                         turns);
}

static int check_polyhedron(const nsdae_solid *s, nsdae_error *error)
{
  const char *where = "nsdae_solid";
  if (s->points < 4 || !s->point)
    return nsdae_error_set(error, NSDAE_E_ARGUMENT, where, "points",
                           "points = %d of a polyhedron is less than 4, or point is NULL",
                           s->points);
  for (long i = 0; i < 3L * s->points; i++)
    if (!isfinite(s->point[i]))
      return nsdae_error_set(error, NSDAE_E_NONFINITE, where, "point",
                             "point %ld of the polyhedron is at %g, which is not a finite number",
                             i / 3, s->point[i]);
  return NSDAE_OK;
}

/* What is wrong with a solid's own numbers, into the record. */
int nsdae_solid_check(const nsdae_solid *s, nsdae_error *error)
{
  const char *where = "nsdae_solid", *name = kinds[s->shape].name;
  int rounded = kinds[s->shape].rounded;
  if (!(isfinite(s->radius) && s->radius >= 0) || (rounded && s->radius == 0))
    return nsdae_error_set(error, NSDAE_E_ARGUMENT, where, "radius",
                           "radius = %g of a %s is not a number %s 0", s->radius, name,
                           rounded ? "above" : "of at least");
  if ((s->shape == NSDAE_SHAPE_POLYHEDRON || s->shape == NSDAE_SHAPE_ELLIPSOID) && s->radius != 0)
    return nsdae_error_set(error, NSDAE_E_ARGUMENT, where, "radius", "radius = %g of %s is not 0",
                           s->radius,
                           s->shape == NSDAE_SHAPE_POLYHEDRON ? "a polyhedron" : "an ellipsoid");
  for (int i = 0; i < 3; i++)
    if (kinds[s->shape].lengths >> i & 1 && !(isfinite(s->length[i]) && s->length[i] > 0))
      return nsdae_error_set(error, NSDAE_E_ARGUMENT, where, "length",
                             "length[%d] = %g of a %s is not a number above 0", i, s->length[i],
                             name);
  if (s->radius != 0 && (s->shape == NSDAE_SHAPE_MESH || s->shape == NSDAE_SHAPE_HEIGHT_FIELD))
    return nsdae_error_set(error, NSDAE_E_ARGUMENT, where, "radius", "radius = %g of a %s is not 0",
                           s->radius, name);
  return s->shape == NSDAE_SHAPE_POLYGON      ? check_polygon(s, error)
         : s->shape == NSDAE_SHAPE_POLYHEDRON ? check_polyhedron(s, error)
                                              : NSDAE_OK;
}

/* ---- a solid in its body */

/* Corner i of a smooth shape, in its frame: see feature.c. The points of a disc that are fixed to
 * it bear it if it lies flat. */
static void on_disc(const nsdae_solid *s, int i, double *x)
{
  double angle = 2 * nsdae_pi * (i % 4) / 3, r = i % 4 ? s->radius : 0;
  x[0] = r * cos(angle);
  x[1] = r * sin(angle);
  if (s->shape != NSDAE_SHAPE_DISC && s->shape != NSDAE_SHAPE_ELLIPSOID)
    x[2] = (i < 4 ? -0.5 : 0.5) * s->length[2];
}

static void place_solid(const nsdae_bodies *b, const nsdae_solid *s, nsdae_solid_of *made)
{
  memcpy(made->turn, s->quaternion, sizeof made->turn);
  nsdae_unit_quaternion(made->turn);
  if (b->dimension == 2) {
    made->turn[0] = s->angle;
    nsdae_rotation_planar(s->angle, made->R);
  } else {
    nsdae_rotation_spatial(made->turn, made->R);
  }
  double middle[3] = {0, 0, 0}; /* of a polyhedron, in its frame */
  for (int i = 0; i < 3 * made->points && s->shape == NSDAE_SHAPE_POLYHEDRON; i++)
    middle[i % 3] += made->hull->corner[i] / made->points;
  nsdae_turn(made->R, middle, made->origin);
  for (int j = 0; j < 3; j++) made->origin[j] += s->position[j];
  made->size = 0;
  for (int i = 0; i < made->points; i++) {
    double x[3] = {0, 0, 0}, d[3], *corner = made->point + 3 * i, side = i ? 0.5 : -0.5;
    /* in the frame of the shape */
    if (s->shape == NSDAE_SHAPE_SEGMENT) x[0] = side * s->length[0];
    if (s->shape == NSDAE_SHAPE_CAPSULE) x[2] = side * s->length[2];
    if (s->shape == NSDAE_SHAPE_POLYGON) memcpy(x, s->point + 2 * i, 2 * sizeof *x);
    for (int j = 0; j < 3 && s->shape == NSDAE_SHAPE_BOX; j++)
      x[j] = (i >> j & 1 ? 0.5 : -0.5) * s->length[j];
    for (int j = 0; j < 3 && s->shape == NSDAE_SHAPE_POLYHEDRON; j++)
      x[j] = made->hull->corner[3 * i + j] - middle[j];
    if (nsdae_solid_is_smooth(made)) on_disc(s, i, x);
    nsdae_turn(made->R, x, corner);
    for (int j = 0; j < 3; j++) {
      corner[j] += made->origin[j];
      d[j] = corner[j] - made->origin[j];
    }
    made->size = fmax(made->size, sqrt(nsdae_dot3(d, d)));
  }
  made->size += made->radius;
  if (made->mesh) nsdae_mesh_extent(made->mesh, made->origin, &made->size);
  for (int j = 0; j < 3; j++) made->half[j] = s->length[j] / 2;
  if (nsdae_solid_is_smooth(made)) {
    double *half = made->half;
    if (s->shape != NSDAE_SHAPE_ELLIPSOID) half[0] = half[1] = s->radius;
    if (s->shape == NSDAE_SHAPE_DISC) half[2] = 0;
    made->size = s->shape == NSDAE_SHAPE_ELLIPSOID ? fmax(fmax(half[0], half[1]), half[2])
                                                   : hypot(half[0], half[2]);
  }
  if (s->shape != NSDAE_SHAPE_PLANE || b->dimension == 3) return;
  for (int j = 0; j < 3; j++) made->R[6 + j] = made->R[3 + j]; /* the normal, as in space */
}

/* Outer unit normals, anticlockwise corners being given, and lengths. */
static void measure_edges(nsdae_solid_of *s)
{
  for (int i = 0; i < s->points; i++) {
    const double *p = s->point + 3 * i, *next = s->point + 3 * ((i + 1) % s->points);
    double x = next[0] - p[0], y = next[1] - p[1], length = sqrt(x * x + y * y);
    const double edge[4] = {y / length, -x / length, 0, length};
    memcpy(s->edge + 4 * i, edge, sizeof edge);
  }
}

/* Of faces the outer unit normals n, and the largest n . x of their corners. */
static void measure_faces(nsdae_solid_of *s)
{
  const nsdae_hull *h = s->hull;
  for (int f = 0; f < h->faces; f++) {
    double *plane = s->edge + 4 * f;
    nsdae_hull_normal(h, s->point, f, plane);
    plane[3] = -INFINITY;
    for (int i = h->first[f]; i < h->first[f + 1]; i++)
      plane[3] = fmax(plane[3], nsdae_dot3(plane, s->point + 3 * h->ring[i]));
  }
}

static int check_material(nsdae_bodies *b, const char *what, int index, int material)
{
  if (material >= 0 && material < NSDAE_MATERIALS) return NSDAE_OK;
  return nsdae_bodies_refuse(b, NSDAE_E_ARGUMENT, what, "material", index,
                             "material = %d is outside its range: it must be 0 .. %d", material,
                             NSDAE_MATERIALS - 1);
}

/* Bits 0 .. 30 of groups are numbers of at least 0. */
static int check_groups(nsdae_bodies *b, int index, const nsdae_solid *s)
{
  int group = s->group < 0;
  if (!group && s->exclude >= -1) return NSDAE_OK;
  return nsdae_bodies_refuse(
      b, NSDAE_E_ARGUMENT, "solid", group ? "group" : "exclude", index,
      group ? "group = %d is outside its range: it must be 0 .. 2^31 - 1 (bits 0 .. 30)"
            : "exclude = %d is outside its range: it must be -1 .. 2^31 - 1 (-1, or bits 0 .. 30)",
      group ? s->group : s->exclude);
}

static int is_surface(const nsdae_solid *s)
{
  return s->shape == NSDAE_SHAPE_MESH || s->shape == NSDAE_SHAPE_HEIGHT_FIELD;
}

/* The mesh of a mesh or height field in the frame of its body. */
static int add_surface(nsdae_bodies *b, int body, const nsdae_solid *s, int index,
                       const nsdae_mesh **mesh)
{
  nsdae_solid_of frame = {.points = 0};
  nsdae_surface surface;
  nsdae_error why;
  int status = NSDAE_OK;
  if (body != NSDAE_GROUND && s->exclude != -1)
    return nsdae_bodies_refuse(b, NSDAE_E_ARGUMENT, "solid", "body", index,
                               "a %s of body %d: give it to the ground (%d), or set exclude = -1 "
                               "if it is for pictures alone",
                               kinds[s->shape].name, body, NSDAE_GROUND);
  place_solid(b, s, &frame);
  status = nsdae_surface_of(s, &surface, &why);
  if (status == NSDAE_OK)
    status = nsdae_mesh_create(&surface, s->length[2], frame.R, frame.origin, mesh, &why);
  nsdae_surface_release(&surface);
  return status < 0 ? nsdae_bodies_refuse(b, status, "solid", why.argument, index, "%s", why.text)
                    : NSDAE_OK;
}

int nsdae_bodies_add_solid(nsdae_bodies *b, int body, const nsdae_solid *s)
{
  int status = nsdae_bodies_open(b, s, "solid");
  if (status < 0) return status;
  int index = b->solid.count;
  int known = s->shape >= 0 && s->shape < (int)(sizeof kinds / sizeof *kinds);
  if (!known || !(b->dimension == 2 ? kinds[s->shape].planar : kinds[s->shape].spatial))
    return nsdae_bodies_refuse(b, NSDAE_E_ARGUMENT, "solid", "shape", index,
                               "shape = %d (%s) is no solid in %d dimensions", s->shape,
                               known ? kinds[s->shape].name : "unknown", b->dimension);
  if (body < NSDAE_GROUND || body >= b->body.count)
    return nsdae_bodies_refuse(b, NSDAE_E_ARGUMENT, "solid", "body", index,
                               "body = %d is not a body: there are %d, from 0, and the ground (%d)",
                               body, b->body.count, NSDAE_GROUND);
  status = check_material(b, "solid", index, s->material);
  if (status == NSDAE_OK) status = check_groups(b, index, s);
  if (status == NSDAE_OK && s->hollow && s->shape == NSDAE_SHAPE_DISC && b->dimension == 3)
    status = nsdae_bodies_refuse(b, NSDAE_E_ARGUMENT, "solid", "hollow", index,
                                 "hollow = %d: a disc in space has no hole", s->hollow);
  nsdae_error why;
  if (status == NSDAE_OK && (status = nsdae_solid_check(s, &why)) < 0)
    return nsdae_bodies_refuse(b, status, "solid", why.argument, index, "%s", why.text);
  if (status == NSDAE_OK)
    status = nsdae_bodies_check_vector(b, "solid", "position", index, s->position, 1);
  if (status == NSDAE_OK)
    status = nsdae_bodies_check_turn(b, "solid", index, s->angle, s->quaternion);
  if (status < 0) return status;
  const nsdae_hull *hull = s->shape == NSDAE_SHAPE_BOX       ? &nsdae_box_hull
                           : s->shape == NSDAE_SHAPE_CAPSULE ? &nsdae_capsule_hull
                                                             : NULL;
  if (s->shape == NSDAE_SHAPE_POLYHEDRON &&
      (status = nsdae_hull_create(s->points, s->point, &hull, &why)) < 0)
    return nsdae_bodies_refuse(b, status, "solid", why.argument, index, "%s", why.text);
  int points = hull                                                ? hull->corners
               : s->shape == NSDAE_SHAPE_POLYGON                   ? s->points
               : s->shape == NSDAE_SHAPE_DISC && b->dimension == 3 ? 4
                                                                   : kinds[s->shape].corners;
  int faces = hull ? hull->faces : points; /* of a polygon its edges */
  const nsdae_mesh *mesh = NULL;
  if (is_surface(s) && (status = add_surface(b, body, s, index, &mesh)) < 0) return status;
  size_t numbers = 3 * (size_t)points + 4 * (size_t)faces;
  double *corners = calloc(numbers + 1, sizeof *corners);
  nsdae_solid_of *made = corners ? nsdae_list_add(b, &b->solid, sizeof *made) : NULL;
  if (!made) {
    free(corners);
    nsdae_hull_release(hull);
    nsdae_mesh_release(mesh);
    return nsdae_error_memory(&b->error, "nsdae_bodies");
  }
  *made = (nsdae_solid_of){.body = body,
                           .shape = s->shape,
                           .hollow = s->shape == NSDAE_SHAPE_DISC && s->hollow,
                           .points = points,
                           /* INT_MIN: exclude = -1 has a bit in common */
                           .filter = {s->material, s->group | INT_MIN, s->exclude},
                           .radius = s->radius,
                           .point = corners,
                           .edge = corners + 3 * points,
                           .hull = hull,
                           .mesh = mesh};
  if (nsdae_solid_is_smooth(made)) made->radius = 0;
  place_solid(b, s, made);
  if (b->dimension == 2 && points > 1) measure_edges(made);
  if (hull) measure_faces(made);
  made->width = nsdae_solid_width(made);
  return index;
}

/* ---- features of a pair of solids */

/* Whether its corners alone can touch a convex solid: it is a point with a rounding. */
static int is_round(const nsdae_solid_of *s)
{
  return s->points == 1 && !s->hollow && !nsdae_solid_is_smooth(s);
}

/* Whether nothing but corners of others can touch it. */
static int is_base(const nsdae_solid_of *s)
{
  return s->shape == NSDAE_SHAPE_PLANE || s->hollow || s->mesh;
}

/* Where the features of a pair go. */
typedef struct sink {
  nsdae_feature_fn add;
  void *to;
  int status, number;
} sink;

static void add_feature(sink *s, int edges, int solid0, int solid1, int part0, int part1)
{
  const nsdae_feature f = {
      .number = s->number, .edges = edges, .solid = {solid0, solid1}, .part = {part0, part1}};
  s->number++;
  if (s->status >= 0) s->status = s->add(s->to, &f);
}

/* Corners of solid 1 - base of the meeting, in the order of the features. */
static void add_corners(sink *s, const nsdae_solid_of *solids, int base, int other,
                        const nsdae_meeting *met, int of)
{
  for (int i = 0; i < solids[other].points; i++) {
    int all = !met || (i >= 32 && !met->polyhedra);
    unsigned near = all              ? 1
                    : met->polyhedra ? met->hulls.near[1 - of][i / 32] >> i % 32
                                     : met->corners[of] >> i;
    if (near & 1)
      add_feature(s, 0, base, other, 0, i);
    else
      s->number++;
  }
}

/* Edges of two solids, numbered from `first` on, `second` for each edge of the one. */
typedef struct edge_sink {
  sink *sink;
  int first, second, solid[2];
} edge_sink;

static int add_edge_pair(void *to, int k, int l)
{
  const edge_sink *e = to;
  e->sink->number = e->first + k * e->second + l;
  add_feature(e->sink, 1, e->solid[0], e->solid[1], k, l);
  return e->sink->status;
}

static void add_edges(sink *s, const nsdae_solid_of *solids, int i, int j, const nsdae_meeting *met)
{
  edge_sink e = {s, s->number, nsdae_solid_edges(&solids[j]), {i, j}};
  if (met && met->polyhedra) {
    nsdae_polyhedra_each(met, add_edge_pair, &e);
    return;
  }
  for (int k = 0; k < nsdae_solid_edges(&solids[i]); k++)
    for (int l = 0; l < e.second && !(met && met->edges[k] >> l == 0); l++)
      if (!met || (met->edges[k] >> l & 1)) add_edge_pair(&e, k, l);
}

int nsdae_pair_is_turned(const nsdae_solid_of *s0, const nsdae_solid_of *s1)
{
  return !is_base(s0) && (is_base(s1) || (is_round(s0) && !is_round(s1)));
}

/* All that a manifold can have, or those that it has. */
static void add_manifold(sink *s, int solid0, int solid1, int all, const nsdae_manifold *m)
{
  int count = m ? m->count : all;
  for (int i = 0; i < count; i++) {
    s->number = m ? m->number[i] : i;
    add_feature(s, 1, solid0, solid1, 0, 0);
  }
}

int nsdae_pair_features(const nsdae_solid_of *solids, int solid0, int solid1,
                        const nsdae_meeting *met, nsdae_feature_fn add, void *to)
{
  sink s = {.add = add, .to = to};
  int turned = nsdae_pair_is_turned(&solids[solid0], &solids[solid1]);
  int base = turned ? solid1 : solid0, other = turned ? solid0 : solid1;
  int one_way = is_base(&solids[base]) || is_round(&solids[other]);
  if (!nsdae_pair_is_exact(&solids[base], &solids[other])) {
    int all = nsdae_manifold_ids(&solids[base], &solids[other]);
    add_manifold(&s, base, other, all, met ? &met->manifold : NULL);
    return s.status;
  }
  add_corners(&s, solids, base, other, met, 0);
  if (one_way) return s.status;
  add_corners(&s, solids, other, base, met, 1);
  add_edges(&s, solids, base, other, met);
  return s.status;
}

typedef struct closest_sink {
  nsdae_meeting met;
  nsdae_contact_fn add;
  void *to;
} closest_sink;

static int add_closest(void *to, const nsdae_feature *f)
{
  const closest_sink *s = to;
  nsdae_closest closest;
  if (!nsdae_feature_closest(f, &s->met, &closest)) return 0;
  const nsdae_couple two = nsdae_feature_couple(f, &s->met);
  return s->add(s->to, f->number, &closest, &two);
}

int nsdae_pair_contacts(const nsdae_solid_of *solids, int solid0, int solid1,
                        const nsdae_couple *two, double reach, nsdae_contact_fn add, void *to)
{
  closest_sink s = {.add = add, .to = to};
  if (two->solid[0]->mesh) return nsdae_mesh_contacts(two, reach, add, to);
  nsdae_meet(two, reach, &s.met);
  return s.met.far ? 0 : nsdae_pair_features(solids, solid0, solid1, &s.met, add_closest, &s);
}

int nsdae_pair_is_exact(const nsdae_solid_of *s0, const nsdae_solid_of *s1)
{
  const nsdae_solid_of *smooth = nsdae_solid_is_smooth(s0) ? s0 : s1,
                       *other = smooth == s0 ? s1 : s0;
  return !nsdae_solid_is_smooth(smooth) || other->shape == NSDAE_SHAPE_PLANE || is_round(other);
}

/* A disc in space. */
static int is_flat(const nsdae_solid_of *s)
{
  return s->shape == NSDAE_SHAPE_DISC && nsdae_solid_is_smooth(s);
}

int nsdae_pair_has_none(const nsdae_solid_of *s0, const nsdae_solid_of *s1)
{
  const nsdae_solid_of *other = is_flat(s0) ? s1 : s0;
  return (is_flat(s0) || is_flat(s1)) && other->radius == 0 &&
         (is_flat(other) || other->shape == NSDAE_SHAPE_POINT);
}

int nsdae_bodies_refuse_pair(nsdae_bodies *b, const char *what, int index, int solid0, int solid1)
{
  const nsdae_solid_of *s0 = nsdae_solid_at(b, solid0), *s1 = nsdae_solid_at(b, solid1);
  return nsdae_bodies_refuse(
      b, NSDAE_E_ARGUMENT, what, "solid", index,
      "solids %d and %d: %s and %s have no inside and cannot touch: make one a cylinder or a "
      "sphere",
      solid0, solid1, nsdae_solid_name(s0->shape), nsdae_solid_name(s1->shape));
}

typedef struct pairing {
  nsdae_bodies *bodies;
  double mu, e_n, e_t;
} pairing;

/* ---- contacts */

static int keep_feature(void *to, const nsdae_feature *feature)
{
  const pairing *p = to;
  nsdae_feature *f = nsdae_list_add(p->bodies, &p->bodies->feature, sizeof *f);
  if (!f) return NSDAE_E_MEMORY;
  *f = *feature;
  f->mu = p->mu;
  f->e_n = p->e_n;
  f->e_t = p->e_t;
  return NSDAE_OK;
}

/* mu >= 0, restitutions 0 .. 1 */
static int check_coefficients(nsdae_bodies *b, const char *what, int index, double mu, double e_n,
                              double e_t)
{
  nsdae_bodies_check_least(b, what, "mu", index, mu, 0, 0);
  nsdae_bodies_check_least(b, what, "e_n", index, e_n, 0, 0);
  nsdae_bodies_check_least(b, what, "e_t", index, e_t, 0, 0);
  if (e_n > 1 || e_t > 1)
    nsdae_bodies_refuse(b, NSDAE_E_ARGUMENT, what, e_n > 1 ? "e_n" : "e_t", index,
                        "e_n = %g, e_t = %g: a restitution is at most 1", e_n, e_t);
  return b->error.status;
}

int nsdae_bodies_set_pair(nsdae_bodies *b, int material0, int material1, double mu, double e_n,
                          double e_t)
{
  int status = nsdae_bodies_open(b, b, "bodies");
  if (status < 0) return status;
  int index = b->pair.count;
  status = check_material(b, "pair", index, material0);
  if (status == NSDAE_OK) status = check_material(b, "pair", index, material1);
  if (status == NSDAE_OK) status = check_coefficients(b, "pair", index, mu, e_n, e_t);
  if (status < 0) return status;
  nsdae_bodies_pair *pair = nsdae_list_add(b, &b->pair, sizeof *pair);
  if (!pair) return NSDAE_E_MEMORY;
  *pair = (nsdae_bodies_pair){{material0, material1}, mu, e_n, e_t};
  return NSDAE_OK;
}

int nsdae_bodies_add_contact(nsdae_bodies *b, int solid0, int solid1, double mu, double e_n,
                             double e_t)
{
  int status = nsdae_bodies_open(b, b, "bodies");
  if (status < 0) return status;
  pairing p = {b, mu, e_n, e_t};
  const char *what = "contact";
  int index = b->feature.count, count = b->solid.count;
  if (solid0 < 0 || solid0 >= count || solid1 < 0 || solid1 >= count)
    return nsdae_bodies_refuse(b, NSDAE_E_ARGUMENT, what, "solid", index,
                               "solids %d and %d: there are %d, from 0", solid0, solid1, count);
  const nsdae_solid_of *s0 = nsdae_solid_at(b, solid0), *s1 = nsdae_solid_at(b, solid1);
  if (s0->body == s1->body)
    return nsdae_bodies_refuse(b, NSDAE_E_ARGUMENT, what, "solid", index,
                               "solids %d and %d belong to the same body, %d", solid0, solid1,
                               s0->body);
  if (is_base(s0) && is_base(s1))
    return nsdae_bodies_refuse(b, NSDAE_E_ARGUMENT, what, "solid", index,
                               "solids %d and %d are both without corners", solid0, solid1);
  if (nsdae_pair_has_none(s0, s1)) return nsdae_bodies_refuse_pair(b, what, index, solid0, solid1);
  if (s0->mesh || s1->mesh)
    return nsdae_bodies_refuse(b, NSDAE_E_ARGUMENT, what, "solid", index,
                               "solids %d and %d: a %s has contacts by nsdae_bodies_set_pair alone",
                               solid0, solid1, nsdae_solid_name(s0->mesh ? s0->shape : s1->shape));
  status = check_coefficients(b, what, index, mu, e_n, e_t);
  if (status < 0) return status;
  nsdae_pair_features(b->solid.at, solid0, solid1, NULL, keep_feature, &p);
  return b->error.status < 0 ? b->error.status : index;
}
