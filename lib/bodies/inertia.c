/* Mass, centre and inertia tensor of solids of uniform density.
 *
 *   J = int (x.x 1 - x x^T) dm about the centre of mass
 *   J + m (d.d 1 - d d^T) about a point at d from it
 *
 * Volume integrals of polygons and polyhedra are sums over their boundary, by the divergence
 * theorem (B. Mirtich, Fast and accurate computation of polyhedral mass properties, J. Graphics
 * Tools 1, 1996): over triangles (tetrahedra) of each edge (triangle a, b, c of a face) and a point
 * 0, with the signed volume V and s the sum of the corners
 *
 *   tetrahedron:  V = a . (b x c) / 6,  int x = V s / 4
 *                 int x x^T = V (s s^T + a a^T + b b^T + c c^T) / 20
 *   triangle:     V = a x b / 2,  int x = V s / 3
 *                 int x x^T = V (s s^T + a a^T + b b^T) / 12 */
#include <math.h>
#include <string.h>

#include "errors.h"
#include "hull.h"
#include "mesh.h"
#include "narrow_phase.h"

/* Mass, centre, and int x x^T dm about 0 or the centre. */
typedef struct moments {
  double mass, centre[3], second[9];
} moments;

/* Adds one triangle or tetrahedron of the volume with a corner at 0 and the others given. */
static void add_simplex(moments *m, double volume, const double *const *corner, int corners)
{
  double sum[3] = {0, 0, 0};
  int first = corners + 1, second = (corners + 1) * (corners + 2);
  for (int k = 0; k < corners; k++)
    for (int j = 0; j < 3; j++) sum[j] += corner[k][j];
  m->mass += volume;
  for (int i = 0; i < 3; i++) {
    m->centre[i] += volume * sum[i] / first;
    for (int j = 0; j < 3; j++) {
      double square = sum[i] * sum[j];
      for (int k = 0; k < corners; k++) square += corner[k][i] * corner[k][j];
      m->second[3 * i + j] += volume * square / second;
    }
  }
}

/* second about d, from that about the centre, or back with sign -1. */
static void shift(moments *m, const double *d, double sign)
{
  for (int i = 0; i < 9; i++) m->second[i] += sign * m->mass * d[i / 3] * d[i % 3];
}

/* Corners from o, so that no offset costs digits. */
static void finish(moments *m, const double *o, double density)
{
  for (int i = 0; i < 3; i++) m->centre[i] /= m->mass;
  shift(m, m->centre, -1);
  for (int i = 0; i < 3; i++) m->centre[i] += o[i];
  m->mass *= density;
  for (int i = 0; i < 9; i++) m->second[i] *= density;
}

static void add_polygon(moments *m, const nsdae_solid *s)
{
  const double o[3] = {s->point[0], s->point[1], 0};
  for (int i = 1; i + 1 < s->points; i++) {
    const double *p = s->point + 2 * i;
    const double a[3] = {p[0] - o[0], p[1] - o[1], 0}, b[3] = {p[2] - o[0], p[3] - o[1], 0};
    const double *const corner[2] = {a, b};
    add_simplex(m, (a[0] * b[1] - a[1] * b[0]) / 2, corner, 2);
  }
}

static void add_hull(moments *m, const nsdae_hull *h)
{
  const double *o = h->corner;
  for (int f = 0; f < h->faces; f++)
    for (int i = h->first[f] + 1; i + 1 < h->first[f + 1]; i++) {
      const int of[3] = {h->ring[h->first[f]], h->ring[i], h->ring[i + 1]};
      double x[3][3], cross[3];
      for (int j = 0; j < 9; j++) x[j / 3][j % 3] = h->corner[3 * of[j / 3] + j % 3] - o[j % 3];
      const double *const corner[3] = {x[0], x[1], x[2]};
      nsdae_cross3(x[1], x[2], cross);
      add_simplex(m, nsdae_dot3(x[0], cross) / 6, corner, 3);
    }
}

/* A surface, if it is closed: across each side of a triangle is another one, which runs along it in
 * the opposite direction. */
static int add_mesh(moments *m, const nsdae_solid *s, nsdae_error *error)
{
  const double same[9] = {1, 0, 0, 0, 1, 0, 0, 0, 1}, zero[3] = {0, 0, 0};
  const char *where = "nsdae_solid";
  nsdae_surface surface;
  const nsdae_mesh *mesh = NULL;
  int status = nsdae_surface_of(s, &surface, error);
  if (status == NSDAE_OK)
    status = nsdae_mesh_create(&surface, s->length[2], same, zero, &mesh, error);
  for (int i = 0; status == NSDAE_OK && i < 3 * mesh->triangles; i++)
    if (mesh->beside[i / 3][i % 3] < 0)
      status = nsdae_error_set(error, NSDAE_E_ARGUMENT, where, "triangle",
                               "side %d of triangle %d (points %d and %d) is no side of one other "
                               "triangle in the opposite direction: a body is a closed surface",
                               i % 3, i / 3, mesh->corner[i / 3][i % 3],
                               mesh->corner[i / 3][(i + 1) % 3]);
  for (int t = 0; status == NSDAE_OK && t < mesh->triangles; t++) {
    double x[3][3], cross[3];
    for (int j = 0; j < 9; j++)
      x[j / 3][j % 3] = nsdae_mesh_corner(mesh, t, j / 3)[j % 3] - s->point[j % 3];
    const double *const corner[3] = {x[0], x[1], x[2]};
    nsdae_cross3(x[1], x[2], cross);
    add_simplex(m, nsdae_dot3(x[0], cross) / 6, corner, 3);
  }
  if (status == NSDAE_OK && !(m->mass > 0))
    status = nsdae_error_set(error, NSDAE_E_ARGUMENT, where, "triangle",
                             "the volume of the mesh is %g: triangles must be anticlockwise seen "
                             "from outside",
                             m->mass);
  nsdae_mesh_release(mesh);
  nsdae_surface_release(&surface);
  return status;
}

/* A cylinder of radius r and height l along z; half balls at its ends, whose centroids are 3/8 r
 * beyond them; a ball is two of them. int x_i^2 dm = (J_j + J_k - J_i) / 2 */
static void round_moments(double r, double l, double density, moments *m)
{
  double cylinder = density * nsdae_pi * r * r * l, ball = density * 4 * nsdae_pi * r * r * r / 3;
  m->mass = cylinder + ball;
  m->second[0] = m->second[4] = cylinder * r * r / 4 + ball * r * r / 5;
  m->second[8] = cylinder * l * l / 12 + ball * (r * r / 5 + l * l / 4 + 3 * l * r / 8);
}

/* Of shapes with three planes of symmetry, and of a cone, whose centroid is a quarter of its height
 * above the base: volume V (of a disc its area), and int x_i^2 / V about the origin of its frame.
 */
static void symmetric_moments(const nsdae_solid *s, moments *m)
{
  const double *l = s->length, square = s->radius * s->radius, disc = nsdae_pi * square;
  double part[3] = {square / 4, square / 4, 0};
  m->mass = disc;
  if (s->shape == NSDAE_SHAPE_CYLINDER) {
    m->mass = disc * l[2];
    part[2] = l[2] * l[2] / 12;
  } else if (s->shape == NSDAE_SHAPE_CONE) {
    m->mass = disc * l[2] / 3;
    m->centre[2] = -m->mass * l[2] / 4;
    part[0] = part[1] = 3 * square / 20;
    part[2] = l[2] * l[2] / 10;
  } else if (s->shape != NSDAE_SHAPE_DISC) {
    int box = s->shape == NSDAE_SHAPE_BOX;
    m->mass = (box ? 1 : nsdae_pi / 6) * l[0] * l[1] * l[2];
    for (int i = 0; i < 3; i++) part[i] = l[i] * l[i] / (box ? 12 : 20);
  }
  for (int i = 0; i < 3; i++) m->second[4 * i] = m->mass * part[i];
}

static int find_moments(const nsdae_solid *s, double density, moments *m, nsdae_error *error)
{
  const double zero[3] = {0, 0, 0};
  const nsdae_hull *hull = NULL;
  int status = nsdae_solid_check(s, error);
  if (status == NSDAE_OK && s->shape == NSDAE_SHAPE_POLYHEDRON)
    status = nsdae_hull_create(s->points, s->point, &hull, error);
  if (status < 0) return status;
  *m = (moments){.mass = 0};
  if (s->shape == NSDAE_SHAPE_MESH) {
    if ((status = add_mesh(m, s, error)) < 0) return status;
    finish(m, s->point, density);
  } else if (s->shape == NSDAE_SHAPE_POLYGON) {
    add_polygon(m, s);
    finish(m, (const double[]){s->point[0], s->point[1], 0}, density);
  } else if (hull) {
    add_hull(m, hull);
    finish(m, hull->corner, density);
  } else if (s->shape == NSDAE_SHAPE_SPHERE || s->shape == NSDAE_SHAPE_CAPSULE) {
    round_moments(s->radius, s->shape == NSDAE_SHAPE_CAPSULE ? s->length[2] : 0, density, m);
  } else {
    symmetric_moments(s, m);
    finish(m, zero, density);
  }
  nsdae_hull_release(hull);
  return NSDAE_OK;
}

/* The tensor J of second moments about one point: its diagonal, and entries (0, 1), (0, 2), (1, 2).
 */
static void tensor_of(const double *second, double inertia[3], double product[3])
{
  for (int i = 0; i < 3; i++) inertia[i] = second[4 * ((i + 1) % 3)] + second[4 * ((i + 2) % 3)];
  product[0] = -second[1];
  product[1] = -second[2];
  product[2] = -second[5];
}

/* Bits 1: a solid in the plane, 2: in space. A disc is both. */
static int dimensions_of(const nsdae_solid *s)
{
  return s->shape == NSDAE_SHAPE_DISC ? 3 : s->shape == NSDAE_SHAPE_POLYGON ? 1 : 2;
}

static int check_shape(const nsdae_solid *s, double density, const char *where, nsdae_error *error)
{
  if (!(isfinite(density) && density > 0))
    return nsdae_error_set(error, NSDAE_E_ARGUMENT, where, "density",
                           "density = %g is not a number above 0", density);
  switch (s->shape) {
  case NSDAE_SHAPE_DISC:
  case NSDAE_SHAPE_POLYGON:
  case NSDAE_SHAPE_SPHERE:
  case NSDAE_SHAPE_CAPSULE:
  case NSDAE_SHAPE_BOX:
  case NSDAE_SHAPE_POLYHEDRON:
  case NSDAE_SHAPE_CYLINDER:
  case NSDAE_SHAPE_MESH:
  case NSDAE_SHAPE_CONE:
  case NSDAE_SHAPE_ELLIPSOID:
    if (!s->hollow) return NSDAE_OK;
  }
  return nsdae_error_set(error, NSDAE_E_ARGUMENT, where, "shape",
                         "shape = %d has no mass by density (disc, polygon, sphere, capsule, box, "
                         "polyhedron, cylinder, cone, ellipsoid, closed mesh have)",
                         s->shape);
}

/* ---- a body of several solids */

/* The rotation of a frame: by the angle, unless the quaternion turns it. */
static void frame_of(double angle, const double *quaternion, double *R)
{
  double p[4];
  memcpy(p, quaternion, sizeof p);
  nsdae_unit_quaternion(p);
  if (p[1] == 0 && p[2] == 0 && p[3] == 0)
    nsdae_rotation_planar(angle, R);
  else
    nsdae_rotation_spatial(p, R);
}

/* m, in the frame of the body. */
static void place_moments(const nsdae_solid *s, moments *m)
{
  double R[9], half[9], turned[3];
  frame_of(s->angle, s->quaternion, R);
  nsdae_turn(R, m->centre, turned);
  for (int i = 0; i < 3; i++) m->centre[i] = turned[i] + s->position[i];
  for (int i = 0; i < 3; i++) nsdae_turn(R, m->second + 3 * i, half + 3 * i); /* R S, S = S^T */
  for (int i = 0; i < 3; i++) {
    const double row[3] = {half[i], half[3 + i], half[6 + i]};
    nsdae_turn(R, row, m->second + 3 * i);
  }
}

/* The moments of solid i in the frame of the body, the second ones about its centre; of the
 * dimensions those that it has too. */
static int find_placed(int i, const nsdae_solid *s, double density, int *dimensions, moments *m,
                       const char *where, nsdae_error *error)
{
  int status = check_shape(s, density, where, error), before = *dimensions;
  *dimensions &= dimensions_of(s);
  if (status == NSDAE_OK && *dimensions == 0)
    status = nsdae_error_set(error, NSDAE_E_ARGUMENT, where, "shape",
                             "solid %d, a %s, is no solid in %d dimensions as those before it are",
                             i, nsdae_solid_name(s->shape), before == 1 ? 2 : 3);
  if (status == NSDAE_OK) status = find_moments(s, density, m, error);
  if (status < 0) return status;
  place_moments(s, m);
  double all = m->mass; /* finite if each of them is */
  for (int j = 0; j < 3; j++) all += fabs(m->centre[j]);
  for (int j = 0; j < 9; j++) all += fabs(m->second[j]);
  if (isfinite(all) && m->mass > 0) return NSDAE_OK;
  return nsdae_error_set(error, NSDAE_E_NONFINITE, where, "solid",
                         "solid %d has the mass %g, centre (%g, %g, %g): its size, density, "
                         "position and rotation must "
                         "be finite and not too large or small",
                         i, m->mass, m->centre[0], m->centre[1], m->centre[2]);
}

/* Sums about o, the centre of solid 0: no offset costs digits. */
static int find_body(int n, nsdae_solid *solid, const double *density, nsdae_rigid_body *body,
                     const char *where, nsdae_error *error)
{
  moments sum = {.mass = 0}, m;
  double R[9], o[3] = {0, 0, 0}, moved[3];
  int dimensions = 3;
  nsdae_error_clear(error);
  if (n < 1 || !solid || !density || !body)
    return nsdae_error_set(error, NSDAE_E_ARGUMENT, where, "solid",
                           "n = %d is less than 1, or solid, density or body is NULL", n);
  for (int i = 0; i < n; i++) {
    int status = find_placed(i, &solid[i], density[i], &dimensions, &m, where, error);
    if (status < 0) {
      if (error) error->index = i;
      return status;
    }
    if (i == 0) memcpy(o, m.centre, sizeof o);
    for (int j = 0; j < 3; j++) m.centre[j] -= o[j];
    shift(&m, m.centre, 1);
    sum.mass += m.mass;
    for (int j = 0; j < 3; j++) sum.centre[j] += m.mass * m.centre[j];
    for (int j = 0; j < 9; j++) sum.second[j] += m.second[j];
  }
  finish(&sum, o, 1);
  frame_of(body->angle, body->quaternion, R);
  nsdae_turn(R, sum.centre, moved);
  double all = sum.mass;
  for (int j = 0; j < 9; j++)
    all += fabs(sum.second[j]) + fabs(moved[j % 3] + body->position[j % 3]);
  if (!isfinite(all))
    return nsdae_error_set(error, NSDAE_E_NONFINITE, where, "body",
                           "the body has the mass %g at (%g, %g, %g): its position and rotation "
                           "must be finite, no solid too far from another",
                           sum.mass, moved[0] + body->position[0], moved[1] + body->position[1],
                           moved[2] + body->position[2]);
  body->mass = sum.mass;
  tensor_of(sum.second, body->inertia, body->product);
  if (dimensions == 1) memset(body->product, 0, sizeof body->product);
  if (dimensions == 1) body->inertia[0] = body->inertia[1] = 0;
  for (int j = 0; j < 3; j++) body->position[j] += moved[j];
  for (int i = 0; i < n; i++)
    for (int j = 0; j < 3; j++) solid[i].position[j] -= sum.centre[j];
  return NSDAE_OK;
}

int nsdae_body_from_solids(int n, nsdae_solid *solid, const double *density, nsdae_rigid_body *body,
                           nsdae_error *error)
{
  return find_body(n, solid, density, body, "nsdae_body_from_solids", error);
}

int nsdae_solid_inertia(const nsdae_solid *s, double density, double *mass, double inertia[3],
                        nsdae_error *error)
{
  const char *where = "nsdae_solid_inertia";
  nsdae_error_clear(error);
  if (!s || !mass || !inertia)
    return nsdae_error_set(error, NSDAE_E_ARGUMENT, where, "solid",
                           "solid, mass or inertia is NULL");
  nsdae_solid own = *s;
  nsdae_rigid_body body = {.mass = 0};
  own.angle = 0;
  memset(own.position, 0, sizeof own.position);
  memset(own.quaternion, 0, sizeof own.quaternion);
  int status = find_body(1, &own, &density, &body, where, error);
  if (status < 0) return status;
  const double *c = body.position, *J = body.inertia, *P = body.product;
  double size = sqrt((J[0] + J[1] + J[2]) / body.mass), trace = J[0] + J[1] + J[2];
  if (fabs(c[0]) + fabs(c[1]) + fabs(c[2]) > 1e-9 * size ||
      fabs(P[0]) + fabs(P[1]) + fabs(P[2]) > 1e-9 * trace)
    return nsdae_error_set(error, NSDAE_E_ARGUMENT, where, "point",
                           "the centroid of the %s is (%g, %g, %g), products of inertia (%g, %g, "
                           "%g): use nsdae_body_from_solids unless all are 0",
                           nsdae_solid_name(s->shape), c[0], c[1], c[2], P[0], P[1], P[2]);
  *mass = body.mass;
  memcpy(inertia, J, sizeof body.inertia);
  return NSDAE_OK;
}

int nsdae_solid_triangles(const nsdae_solid *s, double *triangle, nsdae_error *error)
{
  const char *where = "nsdae_solid_triangles";
  const nsdae_hull *hull;
  nsdae_error_clear(error);
  if (!s || !triangle ||
      (s->shape != NSDAE_SHAPE_POLYHEDRON && s->shape != NSDAE_SHAPE_MESH &&
       s->shape != NSDAE_SHAPE_HEIGHT_FIELD))
    return nsdae_error_set(error, NSDAE_E_ARGUMENT, where, "solid",
                           "solid or triangle is NULL, or the solid is no polyhedron, mesh or "
                           "height field");
  int status = nsdae_solid_check(s, error);
  if (status == NSDAE_OK && s->shape != NSDAE_SHAPE_POLYHEDRON) {
    nsdae_surface surface;
    status = nsdae_surface_of(s, &surface, error);
    for (long i = 0; status == NSDAE_OK && i < 9L * surface.triangles; i++)
      triangle[i] = surface.point[3L * surface.triangle[i / 3] + i % 3];
    nsdae_surface_release(&surface);
    return status < 0 ? status : surface.triangles;
  }
  if (status == NSDAE_OK) status = nsdae_hull_create(s->points, s->point, &hull, error);
  if (status < 0) return status;
  int count = nsdae_hull_triangles(hull, hull->corner, triangle);
  nsdae_hull_release(hull);
  return count;
}
