/* Polyhedra: the hull of points, its inertia, and gaps against brute force. Two convex cores that
 * are apart have the least distance of all pairs of a corner and a triangle and of two edges
 * (C. Ericson, Real-Time Collision Detection, 2005, 5.1); two that overlap the least depth along
 * the normals of all faces and the products of all edges, none left out. The least gap over the
 * contacts of a pair is that, less the roundings. */
#include "check.h"

#include <nsdae/nsdae.h>
#include <stdlib.h>

#include "allocator.h"
#include "bodies_impl.h"
#include "support/feature_touch.h"
#include "support/random.h"

enum { POINTS_MAX = 40 };

static uint64_t seed = 5;

static double uniform(double low, double high)
{
  return random_between(&seed, low, high);
}

/* ---- brute force */

/* A convex core in space: corners, edges and triangles. */
typedef struct core {
  int corners, edges, triangles;
  double corner[POINTS_MAX][3];
  int edge[3 * POINTS_MAX][2], triangle[2 * POINTS_MAX][3];
} core;

static core core_of(const nsdae_solid_of *s, const nsdae_pose *pose)
{
  core c = {.corners = s->points};
  assert_true(s->points <= POINTS_MAX);
  for (int i = 0; i < s->points; i++) nsdae_pose_put(pose, s->point + 3 * i, c.corner[i]);
  if (!s->hull) return c;
  for (int e = 0; e < s->hull->edges; e++, c.edges++)
    for (int j = 0; j < 2; j++) c.edge[e][j] = s->hull->edge[e][j];
  for (int f = 0; f < s->hull->faces; f++)
    for (int i = s->hull->first[f] + 1; i + 1 < s->hull->first[f + 1]; i++) {
      const int of[3] = {s->hull->ring[s->hull->first[f]], s->hull->ring[i], s->hull->ring[i + 1]};
      memcpy(c.triangle[c.triangles++], of, sizeof of);
    }
  return c;
}

static void subtract(const double *a, const double *b, double *c)
{
  for (int j = 0; j < 3; j++) c[j] = a[j] - b[j];
}

/* Distance of p from the segment a b. */
static double point_segment(const double *p, const double *a, const double *b)
{
  double e[3], d[3], square = 0;
  subtract(b, a, e);
  subtract(p, a, d);
  double t = fmin(fmax(nsdae_dot3(e, d) / nsdae_dot3(e, e), 0), 1);
  for (int j = 0; j < 3; j++) square += pow(d[j] - t * e[j], 2);
  return sqrt(square);
}

/* From the plane if the foot is inside, else INFINITY: its edges have the distance then. */
static double point_triangle(const double *p, const double *a, const double *b, const double *c)
{
  const double *x[3] = {a, b, c};
  double u[3], v[3], n[3], d[3], side[3];
  subtract(b, a, u);
  subtract(c, a, v);
  nsdae_cross3(u, v, n);
  for (int i = 0; i < 3; i++) {
    subtract(x[(i + 1) % 3], x[i], u);
    subtract(p, x[i], d);
    nsdae_cross3(n, u, side);
    if (nsdae_dot3(side, d) < 0) return INFINITY;
  }
  return fabs(nsdae_dot3(n, d)) / sqrt(nsdae_dot3(n, n));
}

/* Of the lines if both feet are inside, else INFINITY. */
static double segment_segment(const double *a, const double *b, const double *c, const double *d)
{
  double u[3], v[3], w[3], n[3], x[3];
  subtract(b, a, u);
  subtract(d, c, v);
  subtract(c, a, w);
  nsdae_cross3(u, v, n);
  double square = nsdae_dot3(n, n);
  if (square == 0) return INFINITY;
  nsdae_cross3(w, v, x);
  double s = nsdae_dot3(x, n) / square;
  nsdae_cross3(w, u, x);
  double t = nsdae_dot3(x, n) / square;
  if (s < 0 || s > 1 || t < 0 || t > 1) return INFINITY;
  return fabs(nsdae_dot3(w, n)) / sqrt(square);
}

static double distance_of(const core *one, const core *two)
{
  double least = INFINITY;
  for (int way = 0; way < 2; way++) {
    const core *a = way ? two : one, *b = way ? one : two;
    for (int i = 0; i < a->corners; i++) {
      const double *p = a->corner[i];
      if (b->corners == 1) {
        double d[3];
        subtract(p, b->corner[0], d);
        least = fmin(least, sqrt(nsdae_dot3(d, d)));
      }
      for (int e = 0; e < b->edges; e++)
        least = fmin(least, point_segment(p, b->corner[b->edge[e][0]], b->corner[b->edge[e][1]]));
      for (int t = 0; t < b->triangles; t++) {
        const int *of = b->triangle[t];
        double d = point_triangle(p, b->corner[of[0]], b->corner[of[1]], b->corner[of[2]]);
        least = fmin(least, d);
      }
    }
  }
  for (int e = 0; e < one->edges; e++)
    for (int f = 0; f < two->edges; f++)
      least =
          fmin(least, segment_segment(one->corner[one->edge[e][0]], one->corner[one->edge[e][1]],
                                      two->corner[two->edge[f][0]], two->corner[two->edge[f][1]]));
  return least;
}

/* How far they are apart along n, of any sign and length. */
static double apart_along(const core *one, const core *two, const double *n)
{
  double length = sqrt(nsdae_dot3(n, n)), low[2] = {INFINITY, INFINITY}, high[2];
  const core *c[2] = {one, two};
  high[0] = high[1] = -INFINITY;
  if (length < 1e-9) return -INFINITY;
  for (int s = 0; s < 2; s++)
    for (int i = 0; i < c[s]->corners; i++) {
      double x = nsdae_dot3(n, c[s]->corner[i]) / length;
      low[s] = fmin(low[s], x);
      high[s] = fmax(high[s], x);
    }
  return fmax(low[1] - high[0], low[0] - high[1]);
}

static double separation_of(const core *one, const core *two)
{
  const core *c[2] = {one, two};
  double most = -INFINITY, u[3], v[3], n[3];
  for (int s = 0; s < 2; s++)
    for (int t = 0; t < c[s]->triangles; t++) {
      const int *of = c[s]->triangle[t];
      subtract(c[s]->corner[of[1]], c[s]->corner[of[0]], u);
      subtract(c[s]->corner[of[2]], c[s]->corner[of[0]], v);
      nsdae_cross3(u, v, n);
      most = fmax(most, apart_along(one, two, n));
    }
  for (int e = 0; e < one->edges; e++)
    for (int f = 0; f < two->edges; f++) {
      subtract(one->corner[one->edge[e][1]], one->corner[one->edge[e][0]], u);
      subtract(two->corner[two->edge[f][1]], two->corner[two->edge[f][0]], v);
      nsdae_cross3(u, v, n);
      most = fmax(most, apart_along(one, two, n));
    }
  return most;
}

/* ---- solids */

static const double octahedron[18] = {1, 0, 0, -1, 0, 0, 0, 1, 0, 0, -1, 0, 0, 0, 1, 0, 0, -1};
static const double tetrahedron[12] = {1, 1, 1, 1, -1, -1, -1, 1, -1, -1, -1, 1};

/* kind 0: points anywhere; 1: on a sphere; 2: of a lattice, many in one plane; 3, 4: regular. */
static nsdae_solid random_polyhedron(double *point, int kind)
{
  int count = 6 + random_below(&seed, 15);
  for (int i = 0; i < count; i++) {
    double *x = point + 3 * i, length;
    do
      for (int j = 0; j < 3; j++) x[j] = uniform(-1, 1);
    while ((length = sqrt(nsdae_dot3(x, x))) < 0.1);
    for (int j = 0; j < 3; j++)
      x[j] = kind == 1 ? x[j] / length : kind == 2 ? round(1.4 * x[j]) : x[j];
  }
  if (kind == 3) memcpy(point, octahedron, sizeof octahedron), count = 6;
  if (kind == 4) memcpy(point, tetrahedron, sizeof tetrahedron), count = 4;
  nsdae_solid s = {.shape = NSDAE_SHAPE_POLYHEDRON, .points = count, .point = point};
  for (int j = 0; j < 3 * count; j++) point[j] *= 0.6;
  for (int j = 0; j < 3; j++) s.position[j] = uniform(-0.3, 0.3);
  for (int j = 0; j < 4; j++) s.quaternion[j] = uniform(-1, 1);
  return s;
}

static nsdae_solid random_solid(int shape, double *point)
{
  nsdae_solid s = {.shape = shape};
  if (shape == NSDAE_SHAPE_POLYHEDRON) return random_polyhedron(point, random_below(&seed, 5));
  if (shape == NSDAE_SHAPE_SPHERE || shape == NSDAE_SHAPE_CAPSULE) s.radius = uniform(0.1, 0.4);
  for (int i = 0; i < 3; i++) s.length[i] = uniform(0.3, 1.5);
  return s;
}

static double least_gap(const nsdae_bodies *b, const nsdae_pose pose[2], int *contacts)
{
  double least = INFINITY;
  *contacts = 0;
  for (int i = 0; i < b->feature.count; i++) {
    const nsdae_feature *f = nsdae_feature_at(b, i);
    const nsdae_pose of[2] = {pose[f->solid[0]], pose[f->solid[1]]};
    nsdae_touch touch;
    if (!feature_touch(b->solid.at, f, of, &touch)) continue;
    least = fmin(least, touch.gap.x);
    *contacts += touch.gap.x < 1e-3;
  }
  return least;
}

/* ---- gaps */

static int apart, overlap;
static double off[2]; /* the largest errors of gaps: apart, overlapping */

static void compare(int shape, int poses)
{
  double point[2][3 * POINTS_MAX];
  const nsdae_rigid_body body = {.mass = 1, .inertia = {1, 1, 1}};
  nsdae_bodies *b;
  assert_int_equal(nsdae_bodies_create(3, &b, NULL), NSDAE_OK);
  const nsdae_solid one = random_solid(NSDAE_SHAPE_POLYHEDRON, point[0]);
  const nsdae_solid other = random_solid(shape, point[1]);
  int turned = random_below(&seed, 2);
  for (int i = 0; i < 2; i++) {
    nsdae_bodies_add(b, &body);
    nsdae_bodies_add_solid(b, i, i == turned ? &one : &other);
  }
  int first = nsdae_bodies_add_contact(b, 0, 1, 0, 0, 0);
  if (nsdae_bodies_error(b)->status < 0) { /* points of the lattice in one plane */
    assert_non_null(strstr(nsdae_bodies_error(b)->text, "plane"));
    poses = 0;
  } else {
    assert_int_equal(first, 0);
  }
  for (int k = 0; k < poses; k++) {
    const nsdae_solid_of *s = b->solid.at;
    double q[7], radius = s[0].radius + s[1].radius, size = s[0].size + s[1].size;
    nsdae_pose pose[2];
    core c[2];
    int contacts;
    for (int i = 0; i < 2; i++) {
      for (int j = 0; j < 7; j++) q[j] = uniform(-0.8, 0.8);
      pose[i] = nsdae_pose_of(3, q, NULL);
      c[i] = core_of(&s[i], &pose[i]);
    }
    double most = separation_of(&c[0], &c[1]), least = least_gap(b, pose, &contacts);
    double expected = (most > 0 ? distance_of(&c[0], &c[1]) : most) - radius;
    double tol = most > 1e-6 * size ? 1e-9 : 3e-6 * size;
    apart += most > 0;
    overlap += most < 0;
    if (!(fabs(least - expected) <= tol))
      print_error("shape %d pose %d: %g instead of %g\n", shape, k, least, expected);
    assert_near(least, expected, tol);
    off[most <= 0] = fmax(off[most <= 0], fabs(least - expected));
  }
  nsdae_bodies_destroy(&b);
}

static void test_gaps(void **state)
{
  const int shapes[] = {NSDAE_SHAPE_POLYHEDRON, NSDAE_SHAPE_BOX, NSDAE_SHAPE_CAPSULE,
                        NSDAE_SHAPE_SPHERE, NSDAE_SHAPE_POINT};
  const int pairs[] = {60, 60, 200, 400, 400}, poses = getenv("NSDAE_LONG") ? 2000 : 30;
  (void)state;
  for (int i = 0; i < 5; i++) {
    apart = overlap = 0;
    off[0] = off[1] = 0;
    for (int j = 0; j < pairs[i]; j += test_share()) compare(shapes[i], poses);
    print_message("polyhedron and %s: %d poses apart, gap off by %.1e m; %d overlap, by %.1e m\n",
                  nsdae_solid_name(shapes[i]), apart, off[0], overlap, off[1]);
    assert_true(apart > share_of(pairs[i]) && overlap > share_of(pairs[i]));
  }
}

/* ---- hulls */

/* The faces of a box as its table has them, and those of its corners. */
static void test_box(void **state)
{
  double corner[24];
  const nsdae_hull *h = &nsdae_box_hull, *made[2];
  nsdae_hull *filled = nsdae_hull_new(8, 6, 24);
  (void)state;
  for (int i = 0; i < 24; i++) corner[i] = (i / 3 >> i % 3 & 1) ? 0.5 : -0.5;
  assert_non_null(filled);
  memcpy(filled->corner, corner, sizeof corner);
  memcpy(filled->first, h->first, 7 * sizeof *h->first);
  memcpy(filled->ring, h->ring, 24 * sizeof *h->ring);
  assert_int_equal(nsdae_hull_close(filled, NULL), NSDAE_OK);
  made[0] = filled;
  assert_int_equal(nsdae_hull_create(8, corner, &made[1], NULL), NSDAE_OK);
  assert_int_equal(made[0]->edges, h->edges);
  assert_int_equal(made[1]->edges, h->edges);
  assert_int_equal(made[1]->faces, h->faces);
  for (int i = 0; i < 12; i++) {
    int found = 0;
    for (int j = 0; j < 12; j++)
      found += memcmp(made[0]->edge[i], h->edge[j], sizeof h->edge[j]) == 0;
    assert_int_equal(found, 1);
  }
  for (int i = 0; i < 2; i++) nsdae_hull_release(made[i]);
}

/* Every point is in the hull, whose corners are among them. */
static void test_hull(void **state)
{
  (void)state;
  for (int k = 0; k < 300; k += test_share()) {
    double point[3 * POINTS_MAX], n[3];
    const nsdae_solid s = random_polyhedron(point, k % 2);
    const nsdae_hull *h;
    assert_int_equal(nsdae_hull_create(s.points, point, &h, NULL), NSDAE_OK);
    for (int i = 0; i < h->corners; i++) {
      int found = 0;
      for (int j = 0; j < s.points; j++)
        found += memcmp(h->corner + 3 * i, point + 3 * j, sizeof n) == 0;
      assert_int_equal(found, 1);
    }
    for (int f = 0; f < h->faces; f++) {
      assert_true(nsdae_hull_normal(h, h->corner, f, n));
      double top = nsdae_dot3(n, h->corner + 3 * h->ring[h->first[f]]);
      for (int i = 0; i < s.points; i++) assert_true(nsdae_dot3(n, point + 3 * i) <= top + 1e-14);
    }
    nsdae_hull_release(h);
  }
}

/* ---- refused */

static int add_points(int points, const double *point, double radius, char text[256])
{
  const nsdae_solid s = {
      .shape = NSDAE_SHAPE_POLYHEDRON, .points = points, .point = point, .radius = radius};
  nsdae_bodies *b;
  assert_int_equal(nsdae_bodies_create(3, &b, NULL), NSDAE_OK);
  int status = nsdae_bodies_add_solid(b, NSDAE_GROUND, &s);
  snprintf(text, 256, "%s", nsdae_bodies_error(b)->text);
  nsdae_bodies_destroy(&b);
  return status;
}

static void expect_refused(int points, const double *point, int status, const char *part)
{
  char text[256];
  assert_int_equal(add_points(points, point, 0, text), status);
  if (!strstr(text, part)) print_error("'%s' without '%s'\n", text, part);
  assert_non_null(strstr(text, part));
}

static void test_refused(void **state)
{
  enum { MANY = 1000000 };
  char text[256];
  double *point = malloc(3 * MANY * sizeof *point), x[24];
  (void)state;
  assert_non_null(point);
  expect_refused(3, octahedron, NSDAE_E_ARGUMENT, "points = 3 of a polyhedron is less than 4");
  expect_refused(6, NULL, NSDAE_E_ARGUMENT, "point is NULL");
  expect_refused(4, octahedron, NSDAE_E_ARGUMENT, "lie in a plane");
  memcpy(x, octahedron, sizeof octahedron);
  x[7] = NAN;
  expect_refused(6, x, NSDAE_E_NONFINITE, "point 2 of the polyhedron is at nan");
  for (int i = 0; i < 24; i++) x[i] = 3;
  expect_refused(8, x, NSDAE_E_ARGUMENT, "lie in a plane");
  for (int i = 0; i < 24; i++) x[i] = i;
  expect_refused(8, x, NSDAE_E_ARGUMENT, "lie in a plane");
  for (int i = 0; i < 8; i++) x[3 * i] = i, x[3 * i + 1] = i * i, x[3 * i + 2] = 0.1 * i;
  expect_refused(8, x, NSDAE_E_ARGUMENT, "lie in a plane");
  assert_int_equal(add_points(6, octahedron, 0.1, text), NSDAE_E_ARGUMENT);
  assert_non_null(strstr(text, "radius = 0.1 of a polyhedron is not 0"));
  /* twice each corner; a size and a place far from 1; a needle, and one that is too thin */
  for (int i = 0; i < 24; i++) x[i] = octahedron[i % 12 + (i >= 12 ? 6 : 0)];
  assert_int_equal(add_points(8, x, 0, text), 0);
  for (int i = 0; i < 18; i++) x[i] = 1e-60 * octahedron[i];
  assert_int_equal(add_points(6, x, 0, text), 0);
  for (int i = 0; i < 18; i++) x[i] = 1e6 + octahedron[i];
  assert_int_equal(add_points(6, x, 0, text), 0);
  for (int i = 0; i < 18; i++) x[i] = octahedron[i] * (i % 3 ? 1e-4 : 1);
  assert_int_equal(add_points(6, x, 0, text), 0);
  for (int i = 0; i < 18; i++) x[i] = octahedron[i] * (i % 3 ? 1e-7 : 1);
  expect_refused(6, x, NSDAE_E_ARGUMENT, "below 1e-05");
  /* a million: in a cube, of a lattice, on a sphere */
  for (int i = 0; i < 3 * MANY; i++) point[i] = uniform(-1, 1);
  assert_int_equal(add_points(MANY, point, 0, text), 0);
  for (int i = 0; i < MANY; i++)
    for (int j = 0, k = i; j < 3; j++, k /= 100) point[3 * i + j] = k % 100;
  assert_int_equal(add_points(MANY, point, 0, text), 0);
  int round = getenv("NSDAE_LONG") ? MANY : MANY / 10;
  for (int i = 0; i < round; i++) {
    double z = uniform(-1, 1), angle = uniform(0, 7), r = sqrt(1 - z * z);
    point[3 * i] = r * cos(angle), point[3 * i + 1] = r * sin(angle), point[3 * i + 2] = z;
  }
  expect_refused(round, point, NSDAE_E_ARGUMENT, "more than 1024");
  free(point);
}

/* Each allocation fails in turn: it is reported and nothing is left. */
static void test_memory(void **state)
{
  int status = NSDAE_E_MEMORY;
  (void)state;
  for (long at = 0; status < 0; at++) {
    allocator_reset(at);
    nsdae_bodies *b = NULL;
    const nsdae_solid s = {.shape = NSDAE_SHAPE_POLYHEDRON, .points = 6, .point = octahedron};
    status = nsdae_bodies_create(3, &b, NULL);
    if (status == NSDAE_OK) status = nsdae_bodies_add_solid(b, NSDAE_GROUND, &s);
    if (b) nsdae_bodies_destroy(&b);
    assert_int_equal(the_allocator.live, 0);
    assert_true(status == 0 || status == NSDAE_E_MEMORY);
  }
  allocator_reset(-1);
}

/* ---- inertia */

static void expect_body(const nsdae_rigid_body *body, double mass, const double *inertia,
                        const double *product, const double *position, double tol)
{
  assert_near(body->mass, mass, tol * mass);
  for (int i = 0; i < 3; i++) {
    assert_near(body->inertia[i], inertia[i], tol * inertia[i]);
    assert_near(body->product[i], product[i], tol * inertia[0]);
    assert_near(body->position[i], position[i], tol);
  }
}

/* Of edge a: m = a^3 / (6 sqrt 2), J = m a^2 / 20 and m = sqrt(2) a^3 / 3, J = m a^2 / 10, anywhere
 * and turned. */
static void test_regular(void **state)
{
  const double zero[3] = {0, 0, 0}, density = 3, edge[2] = {sqrt(8), sqrt(2)};
  (void)state;
  for (int k = 0; k < 2; k++) {
    double a = edge[k], mass = density * a * a * a * (k ? sqrt(2) / 3 : 1 / (6 * sqrt(2)));
    double j = mass * a * a / (k ? 10 : 20), got, moment[3];
    nsdae_solid s = {.shape = NSDAE_SHAPE_POLYHEDRON,
                     .points = k ? 6 : 4,
                     .point = k ? octahedron : tetrahedron,
                     .position = {0.3, -0.7, 2},
                     .quaternion = {0.1, 0.5, -0.3, 0.8}};
    nsdae_rigid_body body = {.position = {1, 2, 3}, .quaternion = {sqrt(0.5), 0, 0, sqrt(0.5)}};
    assert_int_equal(nsdae_solid_inertia(&s, density, &got, moment, NULL), NSDAE_OK);
    assert_near(got, mass, 1e-14 * mass);
    for (int i = 0; i < 3; i++) assert_near(moment[i], j, 1e-14 * j);
    assert_int_equal(nsdae_body_from_solids(1, &s, &density, &body, NULL), NSDAE_OK);
    /* a quarter turn about z: c = (0.3, -0.7, 2) comes to (0.7, 0.3, 2) */
    expect_body(&body, mass, (const double[]){j, j, j}, zero, (const double[]){1.7, 2.3, 5}, 1e-13);
    for (int i = 0; i < 3; i++) assert_near(s.position[i], 0, 1e-14);
  }
}

/* A tetrahedron anywhere by four points of equal weight, which integrate quadratic functions
 * exactly (P. Keast, 1986). */
static void test_quadrature(void **state)
{
  const double in = (5 + 3 * sqrt(5)) / 20, out = (5 - sqrt(5)) / 20, density = 2;
  (void)state;
  for (int k = 0; k < 200; k++) {
    double p[12], at[4][3] = {{0}}, centre[3] = {0}, J[9] = {0}, u[3], v[3], w[3], n[3];
    nsdae_rigid_body body = {.mass = 0};
    for (int i = 0; i < 12; i++) p[i] = uniform(-1, 1);
    nsdae_solid s = {.shape = NSDAE_SHAPE_POLYHEDRON, .points = 4, .point = p};
    subtract(p + 3, p, u);
    subtract(p + 6, p, v);
    subtract(p + 9, p, w);
    nsdae_cross3(u, v, n);
    double mass = density * fabs(nsdae_dot3(n, w)) / 6;
    if (mass < 0.02) continue;
    for (int i = 0; i < 48; i++) at[i / 12][i % 3] += (i / 3 % 4 == i / 12 ? in : out) * p[i % 12];
    for (int i = 0; i < 12; i++) centre[i % 3] += at[i / 3][i % 3] / 4;
    for (int i = 0; i < 4; i++) {
      subtract(at[i], centre, u);
      for (int j = 0; j < 9; j++)
        J[j] += mass / 4 * ((j % 4 == 0) * nsdae_dot3(u, u) - u[j / 3] * u[j % 3]);
    }
    assert_int_equal(nsdae_body_from_solids(1, &s, &density, &body, NULL), NSDAE_OK);
    expect_body(&body, mass, (const double[]){J[0], J[4], J[8]}, (const double[]){J[1], J[2], J[5]},
                centre, 1e-12);
  }
}

/* A box is two halves of it as hulls, or two boxes; a capsule with a ball in each end twice. */
static void test_several(void **state)
{
  const double density[2] = {4, 4}, zero[3] = {0, 0, 0};
  double mass, inertia[3];
  nsdae_solid whole = {.shape = NSDAE_SHAPE_BOX, .length = {1, 0.6, 0.4}}, part[2];
  (void)state;
  assert_int_equal(nsdae_solid_inertia(&whole, 4, &mass, inertia, NULL), NSDAE_OK);
  for (int k = 0; k < 2; k++) {
    double point[2][24];
    nsdae_rigid_body body = {.mass = 0};
    for (int i = 0; i < 2; i++) {
      part[i] = whole;
      part[i].length[0] = 0.5;
      part[i].position[0] = i ? 0.25 : -0.25;
      for (int j = 0; j < 24; j++)
        point[i][j] = part[i].length[j % 3] * ((j / 3 >> j % 3 & 1) - 0.5);
      if (k == i) /* one of each kind */
        part[i] = (nsdae_solid){.shape = NSDAE_SHAPE_POLYHEDRON,
                                .points = 8,
                                .point = point[i],
                                .position = {part[i].position[0]}};
    }
    assert_int_equal(nsdae_body_from_solids(2, part, density, &body, NULL), NSDAE_OK);
    expect_body(&body, mass, inertia, zero, zero, 1e-14);
  }
  const double triangle[6] = {0, 0, 1, 0, 0, 1};
  nsdae_solid disc[2] = {{.shape = NSDAE_SHAPE_DISC, .radius = 1, .position = {3, 1}},
                         {.shape = NSDAE_SHAPE_DISC, .radius = 1, .position = {5, 1}}};
  nsdae_rigid_body body = {.position = {1, 1}};
  assert_int_equal(nsdae_body_from_solids(2, disc, density, &body, NULL), NSDAE_OK);
  double m = 4 * acos(-1);
  const double at[3] = {5, 2, 0};
  assert_near(body.mass, 2 * m, 1e-13 * m);
  assert_near(body.inertia[2], 2 * (m / 2 + m), 1e-13 * m);
  for (int i = 0; i < 3; i++) assert_near(body.position[i], at[i], 1e-14);
  assert_near(disc[0].position[0], -1, 1e-14);
  nsdae_error error;
  disc[0] = (nsdae_solid){.shape = NSDAE_SHAPE_POLYGON, .points = 3, .point = triangle};
  disc[1] = whole;
  assert_int_equal(nsdae_body_from_solids(2, disc, density, &body, &error), NSDAE_E_ARGUMENT);
  assert_non_null(strstr(error.text, "solid 1, a box, is no solid in 2 dimensions"));
  const double bad[2] = {1, -1};
  assert_int_equal(nsdae_body_from_solids(2, disc, bad, &body, &error), NSDAE_E_ARGUMENT);
  assert_int_equal(error.index, 1);
}

/* The moments about the centre of mass do not depend on the frame: two octahedra and a ball far
 * from its origin, by the offset of the solids or by that of the points. */
static void test_far(void **state)
{
  const double density[3] = {2, 3, 4};
  (void)state;
  for (double far = 1; far < 1e10; far *= 10) {
    double point[18];
    nsdae_rigid_body body[2] = {{.mass = 0}, {.mass = 0}};
    for (int i = 0; i < 18; i++) point[i] = far + octahedron[i];
    for (int k = 0; k < 2; k++) {
      double at = k ? far : 0;
      nsdae_solid s[3] = {{.shape = NSDAE_SHAPE_POLYHEDRON, .points = 6, .point = point},
                          {.shape = NSDAE_SHAPE_POLYHEDRON, .points = 6, .point = octahedron},
                          {.shape = NSDAE_SHAPE_SPHERE, .radius = 1}};
      if (k == 0) s[0].point = octahedron;
      for (int j = 0; j < 3; j++) {
        s[1].position[j] = at + (j == 0);
        s[2].position[j] = at + 2 * (j == 1);
      }
      assert_int_equal(nsdae_body_from_solids(3, s, density, &body[k], NULL), NSDAE_OK);
      for (int j = 0; j < 3; j++) body[k].position[j] -= at;
    }
    double tol = 1e-14 + 1e-15 * far; /* of points rounded to far + 1 */
    expect_body(&body[1], body[0].mass, body[0].inertia, body[0].product, body[0].position,
                20 * tol);
  }
}

static void test_not_finite(void **state)
{
  const double density = 1;
  (void)state;
  for (int k = 0; k < 4; k++) {
    nsdae_error error;
    nsdae_solid s = {.shape = NSDAE_SHAPE_BOX, .length = {1, 1, 1}};
    nsdae_rigid_body body = {.mass = 7};
    *(k == 0   ? &s.position[1]
      : k == 1 ? &s.quaternion[2]
      : k == 2 ? &body.position[0]
               : &body.quaternion[3]) = k % 2 ? INFINITY : NAN;
    assert_int_equal(nsdae_body_from_solids(1, &s, &density, &body, &error), NSDAE_E_NONFINITE);
    assert_non_null(strstr(error.text, k < 2 ? "solid 0" : "the body"));
    assert_true(body.mass == 7);
  }
}

int main(void)
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(test_gaps),       cmocka_unit_test(test_box),
      cmocka_unit_test(test_hull),       cmocka_unit_test(test_refused),
      cmocka_unit_test(test_regular),    cmocka_unit_test(test_quadrature),
      cmocka_unit_test(test_several),    cmocka_unit_test(test_far),
      cmocka_unit_test(test_not_finite), cmocka_unit_test(test_memory)};
  return cmocka_run_group_tests(tests, NULL, NULL);
}
