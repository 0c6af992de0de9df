/* Meshes: gaps against brute force over all triangles, without the tree: a solid that is apart from
 * a surface has the least distance of all pairs of a corner and a triangle and of two edges
 * (C. Ericson, Real-Time Collision Detection, 2005, 5.1). And rounding alone is deeper: a ball that
 * overlaps has the same least gap. */
#include "check.h"

#include <nsdae/nsdae.h>
#include <stdlib.h>

#include "allocator.h"
#include "bodies_impl.h"
#include "mesh.h"
#include "support.h"
#include "support/random.h"

static uint64_t seed = 11;

static void subtract(const double *a, const double *b, double *c)
{
  for (int j = 0; j < 3; j++) c[j] = a[j] - b[j];
}

/* Distance of p from a triangle: from its plane within it, else from a side. */
static double point_triangle(const double *p, const double *const x[3])
{
  double u[3], v[3], n[3], d[3], side[3], least = INFINITY;
  int inside = 1;
  subtract(x[1], x[0], u);
  subtract(x[2], x[0], v);
  nsdae_cross3(u, v, n);
  for (int i = 0; i < 3; i++) {
    subtract(x[(i + 1) % 3], x[i], u);
    subtract(p, x[i], d);
    nsdae_cross3(n, u, side);
    inside &= nsdae_dot3(side, d) >= 0;
    double t = fmin(fmax(nsdae_dot3(u, d) / nsdae_dot3(u, u), 0), 1);
    for (int j = 0; j < 3; j++) d[j] -= t * u[j];
    least = fmin(least, sqrt(nsdae_dot3(d, d)));
  }
  subtract(p, x[0], d);
  return inside ? fabs(nsdae_dot3(n, d)) / sqrt(nsdae_dot3(n, n)) : least;
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
  return s < 0 || s > 1 || t < 0 || t > 1 ? INFINITY : fabs(nsdae_dot3(w, n)) / sqrt(square);
}

/* The least distance of the cores; 0: an edge of one pierces a triangle of the other. */
static double brute(const nsdae_mesh *m, const nsdae_solid_of *s, const nsdae_pose *pose)
{
  double x[64][3], least = INFINITY;
  for (int i = 0; i < s->points; i++) nsdae_pose_put(pose, nsdae_solid_corner(s, i), x[i]);
  for (int t = 0; t < m->triangles; t++) {
    const double *const y[3] = {nsdae_mesh_corner(m, t, 0), nsdae_mesh_corner(m, t, 1),
                                nsdae_mesh_corner(m, t, 2)};
    for (int i = 0; i < s->points; i++) least = fmin(least, point_triangle(x[i], y));
    for (int f = 0; s->hull && f < s->hull->faces; f++)
      for (int i = s->hull->first[f] + 1; i + 1 < s->hull->first[f + 1]; i++) {
        const double *const z[3] = {x[s->hull->ring[s->hull->first[f]]], x[s->hull->ring[i]],
                                    x[s->hull->ring[i + 1]]};
        for (int k = 0; k < 3; k++) least = fmin(least, point_triangle(y[k], z));
      }
    for (int e = 0; s->hull && e < s->hull->edges; e++) {
      const double *a = x[s->hull->edge[e][0]], *b = x[s->hull->edge[e][1]];
      for (int k = 0; k < 3; k++) {
        least = fmin(least, segment_segment(a, b, y[k], y[(k + 1) % 3]));
        if (s->hull->faces == 0) { /* of a capsule: corners and its line */
          double d[3], u[3];
          subtract(b, a, u);
          subtract(y[k], a, d);
          double at = fmin(fmax(nsdae_dot3(u, d) / nsdae_dot3(u, u), 0), 1);
          for (int j = 0; j < 3; j++) d[j] -= at * u[j];
          least = fmin(least, sqrt(nsdae_dot3(d, d)));
        }
      }
    }
  }
  return least;
}

/* Of a curved solid: the least distance from a triangle by their support maps (convex_pairs.c). */
static double brute_smooth(const nsdae_mesh *m, const nsdae_couple *two)
{
  double least = INFINITY, x[9];
  for (int t = 0; t < m->triangles; t++) {
    nsdae_solid_of triangle = {.points = 3, .point = x, .size = 1};
    const nsdae_couple pair = {{&triangle, two->solid[1]}, {two->pose[0], two->pose[1]}};
    nsdae_still at;
    for (int k = 0; k < 9; k++) x[k] = nsdae_mesh_corner(m, t, k / 3)[k % 3];
    memcpy(triangle.origin, x, sizeof triangle.origin);
    for (int j = 0; j < 9; j++) triangle.R[j] = j % 4 == 0;
    if (nsdae_signed_distance(&pair, least, &at)) least = fmin(least, at.gap);
  }
  return least;
}

/* ---- a terrain, a block with a step, rough and flat places */

enum { SIDE = 8 };

static nsdae_solid terrain(double *height)
{
  for (int i = 0; i < SIDE * SIDE; i++) {
    int flat = random_below(&seed, 3) == 0;
    height[i] = flat ? 0 : random_between(&seed, -0.15, 0.15);
  }
  return (nsdae_solid){.shape = NSDAE_SHAPE_HEIGHT_FIELD,
                       .point = height,
                       .grid = {SIDE, SIDE},
                       .length = {1.6, 1.6, 0.3}};
}

typedef struct least {
  double gap;
  int count;
  long last[512];
} least;

static int keep_least(void *to, long number, const nsdae_closest *closest, const nsdae_couple *two)
{
  least *l = to;
  const nsdae_still still = nsdae_closest_still(closest, two);
  const nsdae_touch touch = nsdae_closest_touch(closest, two);
  l->gap = fmin(l->gap, still.gap);
  assert_true(fabs(touch.gap.x - still.gap) < 1e-15);
  assert_true(fabs(nsdae_dot3(still.normal, still.normal) - 1) < 1e-12);
  for (int i = 0; i < l->count; i++) assert_true(l->last[i] != number);
  assert_true(l->count < 512);
  l->last[l->count++] = number;
  return 0;
}

static void compare(const nsdae_solid *solid, int poses, const char *name)
{
  double height[SIDE * SIDE], worst = 0;
  int apart = 0, contacts = 0, smooth = 0;
  for (int surface = 0; surface < 10; surface++) {
    nsdae_bodies *b;
    assert_int_equal(nsdae_bodies_create(3, &b, NULL), NSDAE_OK);
    const nsdae_solid ground = terrain(height);
    const nsdae_rigid_body body = {.mass = 1, .inertia = {1, 1, 1}};
    assert_int_equal(nsdae_bodies_add_solid(b, NSDAE_GROUND, &ground), 0);
    nsdae_bodies_add(b, &body);
    assert_int_equal(nsdae_bodies_add_solid(b, 0, solid), 1);
    const nsdae_solid_of *s = b->solid.at;
    const nsdae_pose still = nsdae_pose_ground();
    for (int i = 0; i < poses / 10; i += test_share()) {
      double q[7];
      for (int j = 0; j < 7; j++) q[j] = random_between(&seed, -1, 1) * (j < 2 ? 0.7 : 1);
      if (i % 3 == 0) q[3] = 1, q[4] = q[5] = q[6] = 0; /* upright: edges along those of the grid */
      q[2] = random_between(&seed, 0, 0.4);
      const nsdae_pose pose = nsdae_pose_of(3, q, NULL);
      const nsdae_couple two = {{&s[0], &s[1]}, {&still, &pose}};
      double corner[3], below = INFINITY, out = 0;
      smooth = nsdae_solid_is_smooth(&s[1]);
      for (int c = 0; c < s[1].points; c++) {
        nsdae_pose_put(&pose, nsdae_solid_corner(&s[1], c), corner);
        below = fmin(below, corner[2]);
        out = fmax(out, fmax(fabs(corner[0]), fabs(corner[1])));
      }
      if (smooth) {
        const double down[3] = {-pose.R[2], -pose.R[5], -pose.R[8]};
        double lowest[3];
        nsdae_support(&s[1], down, lowest);
        nsdae_pose_put(&pose, lowest, corner);
        below = corner[2];
        out += s[1].size;
      }
      double exact = smooth ? brute_smooth(s[0].mesh, &two) : brute(s[0].mesh, &s[1], &pose);
      double tol = smooth ? 1e-9 : 1e-12; /* see test_apart of convex_pairs.c */
      least l = {.gap = INFINITY};
      nsdae_mesh_contacts(&two, exact - s[1].radius + 1e-6, keep_least, &l);
      contacts += l.count;
      if (below < 0.151 || out + exact > 0.8) continue; /* apart, and far from the border */
      apart++;
      double error = fabs(l.gap - (exact - s[1].radius));
      if (!(error < tol))
        print_message("%s: %d contacts, gap %.12g, exact %.12g\n", name, l.count, l.gap,
                      exact - s[1].radius);
      worst = fmax(worst, error / tol);
    }
    nsdae_bodies_destroy(&b);
  }
  print_message("%s: %d poses apart, %d contacts, largest error of the gap %.1e of the bound\n",
                name, apart, contacts, worst);
  assert_true(worst < 1);
  assert_true(apart > share_of(poses) / (smooth ? 12 : 10));
}

static const int smooth_shapes[] = {NSDAE_SHAPE_CYLINDER, NSDAE_SHAPE_CONE, NSDAE_SHAPE_ELLIPSOID,
                                    NSDAE_SHAPE_DISC};

static void test_gaps(void **state)
{
  static const double tetrahedron[12] = {0.1,  0.1, 0.1,  0.1,  -0.1, -0.1,
                                         -0.1, 0.1, -0.1, -0.1, -0.1, 0.1};
  const int many = getenv("NSDAE_LONG") ? 50 : 1; /* at least 1e5 of each */
  (void)state;
  compare(&(nsdae_solid){.shape = NSDAE_SHAPE_SPHERE, .radius = 0.3}, 100000, "sphere");
  compare(&(nsdae_solid){.shape = NSDAE_SHAPE_POINT}, 50000, "point");
  compare(&(nsdae_solid){.shape = NSDAE_SHAPE_CAPSULE, .radius = 0.05, .length = {0, 0, 0.3}},
          10000 * many, "capsule");
  compare(&(nsdae_solid){.shape = NSDAE_SHAPE_BOX, .length = {0.3, 0.2, 0.1}}, 5000 * many, "box");
  compare(&(nsdae_solid){.shape = NSDAE_SHAPE_POLYHEDRON, .points = 4, .point = tetrahedron},
          5000 * many, "tetrahedron");
  for (int k = 0; k < 4; k++) {
    nsdae_solid s = {.shape = smooth_shapes[k], .length = {0.3, 0.2, 0.15}};
    if (s.shape != NSDAE_SHAPE_ELLIPSOID) s.radius = 0.12;
    compare(&s, 2000 * many, nsdae_solid_name(s.shape));
  }
}

/* ---- inertia of closed surfaces */

static const double cube_point[24] = {0, 0, 0, 2, 0, 0, 0, 1, 0, 2, 1, 0,
                                      0, 0, 3, 2, 0, 3, 0, 1, 3, 2, 1, 3};
static const int cube_triangle[36] = {0, 2, 1, 1, 2, 3, 4, 5, 6, 5, 7, 6, 0, 1, 4, 1, 5, 4,
                                      2, 6, 3, 3, 6, 7, 0, 4, 2, 2, 4, 6, 1, 3, 5, 3, 7, 5};

static nsdae_solid cube_of(const double *point, const int *triangle)
{
  return (nsdae_solid){.shape = NSDAE_SHAPE_MESH,
                       .points = 8,
                       .point = point,
                       .triangles = 12,
                       .triangle = triangle,
                       .length = {0, 0, 1}};
}

/* A block of 2 x 1 x 3 by its surface, far from 0: J_1 = m (1 + 9) / 12, ... A torus of a fine
 * mesh: V = 2 pi^2 R r^2, J_3 = m (R^2 + 3/4 r^2), with an error of the order of the mesh squared.
 */
static void test_inertia(void **state)
{
  enum { N = 96 };
  const double density = 4, R = 0.5, r = 0.2, far = 100;
  double point[24], error[2];
  nsdae_rigid_body body = {.mass = 0};
  (void)state;
  for (int i = 0; i < 24; i++) point[i] = cube_point[i] + far;
  nsdae_solid s = cube_of(point, cube_triangle);
  assert_int_equal(nsdae_body_from_solids(1, &s, &density, &body, NULL), NSDAE_OK);
  assert_near(body.mass, 24, 1e-12);
  const double exact[3] = {24 * 10 / 12.0, 24 * 13 / 12.0, 24 * 5 / 12.0},
               centre[3] = {1, 0.5, 1.5};
  for (int j = 0; j < 3; j++) {
    assert_near(body.inertia[j], exact[j], 1e-11);
    assert_near(body.product[j], 0, 1e-11);
    assert_near(body.position[j], centre[j] + far, 1e-11);
  }
  for (int fine = 0; fine < 2; fine++) {
    static double x[3 * N * N];
    static int c[6 * N * N];
    int n = fine ? N : N / 2, t = 0;
    for (int i = 0; i < n; i++)
      for (int j = 0; j < n; j++) {
        double a = 2 * nsdae_pi * i / n, b = 2 * nsdae_pi * j / n, from = R + r * cos(b);
        double *p = x + 3 * (i * n + j);
        p[0] = from * cos(a);
        p[1] = from * sin(a);
        p[2] = r * sin(b);
        int i1 = (i + 1) % n * n, j1 = (j + 1) % n;
        const int two[6] = {i * n + j, i1 + j, i1 + j1, i * n + j, i1 + j1, i * n + j1};
        memcpy(c + t, two, sizeof two);
        t += 6;
      }
    nsdae_solid torus = {.shape = NSDAE_SHAPE_MESH,
                         .points = n * n,
                         .point = x,
                         .triangles = t / 3,
                         .triangle = c,
                         .length = {0, 0, 1}};
    double mass, inertia[3];
    assert_int_equal(nsdae_solid_inertia(&torus, density, &mass, inertia, NULL), NSDAE_OK);
    double m = density * 2 * nsdae_pi * nsdae_pi * R * r * r;
    assert_near(mass, m, 0.01 * m);
    error[fine] = fabs(inertia[2] / (m * (R * R + 0.75 * r * r)) - 1);
  }
  print_message("torus: error of J_3 %.2e, %.2e\n", error[0], error[1]);
  assert_true(error[1] < error[0] / 3.9 && error[1] < 5e-3);
}

/* ---- hostile surfaces */

static void refuse(nsdae_solid s, int body, int status, const char *words)
{
  nsdae_bodies *b;
  assert_int_equal(nsdae_bodies_create(3, &b, NULL), NSDAE_OK);
  nsdae_bodies_add(b, &(nsdae_rigid_body){.mass = 1, .inertia = {1, 1, 1}});
  assert_int_equal(nsdae_bodies_add_solid(b, body, &s), status);
  if (!strstr(nsdae_bodies_error(b)->text, words)) fail_msg("%s", nsdae_bodies_error(b)->text);
  nsdae_bodies_destroy(&b);
}

static void refuse_inertia(const int *triangle, const char *words)
{
  const double density = 1;
  nsdae_solid s = cube_of(cube_point, triangle);
  nsdae_rigid_body body = {.mass = 0};
  nsdae_error error;
  assert_int_equal(nsdae_body_from_solids(1, &s, &density, &body, &error), NSDAE_E_ARGUMENT);
  if (!strstr(error.text, words)) fail_msg("%s", error.text);
}

static void test_refused(void **state)
{
  double point[24], height[4] = {0, 0, 0, NAN};
  int triangle[36];
  (void)state;
  memcpy(point, cube_point, sizeof point);
  memcpy(triangle, cube_triangle, sizeof triangle);
  const nsdae_solid good = cube_of(point, triangle);
  refuse(good, 0, NSDAE_E_ARGUMENT, "a mesh of body 0: give it to the ground");
  point[7] = NAN;
  refuse(good, NSDAE_GROUND, NSDAE_E_NONFINITE, "point 2 of the mesh is at nan");
  point[7] = 1e200; /* squares overflow */
  refuse(good, NSDAE_GROUND, NSDAE_E_ARGUMENT, "coordinates whose squares overflow");
  point[7] = 1;
  triangle[4] = 8;
  refuse(good, NSDAE_GROUND, NSDAE_E_ARGUMENT, "corner 1 of triangle 1 is point 8: there are 8");
  triangle[4] = -1;
  refuse(good, NSDAE_GROUND, NSDAE_E_ARGUMENT, "corner 1 of triangle 1 is point -1");
  triangle[4] = 1;
  refuse(good, NSDAE_GROUND, NSDAE_E_ARGUMENT, "triangle 1 (points 1, 1, 3) has no area");
  triangle[4] = 2;
  nsdae_solid s = good;
  s.length[2] = 0;
  refuse(s, NSDAE_GROUND, NSDAE_E_ARGUMENT, "length[2] = 0 of a mesh is not a number above 0");
  s = good;
  s.radius = 0.1;
  refuse(s, NSDAE_GROUND, NSDAE_E_ARGUMENT, "radius = 0.1 of a mesh is not 0");
  s = good;
  s.triangles = 0;
  refuse(s, NSDAE_GROUND, NSDAE_E_ARGUMENT, "0 triangles");
  s = good;
  s.points = INT32_MAX;
  refuse(s, NSDAE_GROUND, NSDAE_E_ARGUMENT, "a mesh of 2147483647 points");
  s = (nsdae_solid){
      .shape = NSDAE_SHAPE_HEIGHT_FIELD, .point = height, .grid = {2, 2}, .length = {1, 1, 1}};
  refuse(s, NSDAE_GROUND, NSDAE_E_NONFINITE, "is at nan");
  s.grid[0] = 1;
  refuse(s, NSDAE_GROUND, NSDAE_E_ARGUMENT, "grid = 1 x 2");
  s.grid[0] = s.grid[1] = INT32_MAX;
  refuse(s, NSDAE_GROUND, NSDAE_E_ARGUMENT, "grid = 2147483647 x 2147483647");
  s.grid[0] = s.grid[1] = 10000; /* heights are not read before their number is checked */
  refuse(s, NSDAE_GROUND, NSDAE_E_ARGUMENT, "grid = 10000 x 10000 of a height field");
  triangle[35] = 4; /* a hole, and a side of three */
  refuse_inertia(triangle, "is no side of one other triangle in the opposite direction");
  for (int i = 0; i < 36; i++) triangle[i] = cube_triangle[35 - i];
  refuse_inertia(triangle, "the volume of the mesh is -6");
}

/* Triangles at random with common points, of which many meet in one edge: contacts are finite, and
 * each has its number once (keep_least). */
static void test_soup(void **state)
{
  (void)state;
  for (int round = 0; round < 300; round += test_share()) {
    double point[36];
    int triangle[60], count = 0;
    nsdae_bodies *b;
    for (int i = 0; i < 36; i++) point[i] = random_below(&seed, 4) * 0.1;
    while (count < 20) {
      int *c = triangle + 3 * count;
      double u[3], v[3], n[3];
      for (int j = 0; j < 3; j++) c[j] = random_below(&seed, 12);
      subtract(point + 3 * c[1], point + 3 * c[0], u);
      subtract(point + 3 * c[2], point + 3 * c[0], v);
      nsdae_cross3(u, v, n);
      count += nsdae_dot3(n, n) > 1e-9;
    }
    const nsdae_solid soup = {.shape = NSDAE_SHAPE_MESH,
                              .points = 12,
                              .point = point,
                              .triangles = 20,
                              .triangle = triangle,
                              .length = {0, 0, 0.1}};
    const nsdae_solid box = {.shape = NSDAE_SHAPE_BOX, .length = {0.2, 0.1, 0.1}};
    assert_int_equal(nsdae_bodies_create(3, &b, NULL), NSDAE_OK);
    assert_int_equal(nsdae_bodies_add_solid(b, NSDAE_GROUND, &soup), 0);
    nsdae_bodies_add(b, &(nsdae_rigid_body){.mass = 1, .inertia = {1, 1, 1}});
    assert_int_equal(nsdae_bodies_add_solid(b, 0, &box), 1);
    const nsdae_solid_of *s = b->solid.at;
    const nsdae_pose still = nsdae_pose_ground();
    for (int i = 0; i < 20; i++) {
      double q[7] = {0.1, 0.1, 0.1, 1};
      for (int j = 0; j < 7; j++) q[j] += i % 2 ? random_between(&seed, -0.2, 0.2) : 0;
      const nsdae_pose pose = nsdae_pose_of(3, q, NULL);
      const nsdae_couple two = {{&s[0], &s[1]}, {&still, &pose}};
      least l = {.gap = INFINITY};
      nsdae_mesh_contacts(&two, 0.05, keep_least, &l);
      assert_true(l.gap >= -0.1 - 1e-12);
    }
    nsdae_bodies_destroy(&b);
  }
}

/* Curved shapes but spheres and capsules. One by one pairs are refused; by material they touch, by
 * time stepping alone. */
static void test_refused_pairs(void **state)
{
  double height[4] = {0};
  const nsdae_solid ground[] = {
      cube_of(cube_point, cube_triangle),
      {.shape = NSDAE_SHAPE_HEIGHT_FIELD, .point = height, .grid = {2, 2}, .length = {1, 1, 1}}};
  (void)state;
  for (int k = 0; k < 16; k++) {
    int field = k & 1, named = k >> 1 & 1;
    nsdae_solid curved = {.shape = smooth_shapes[k / 4], .length = {1, 1, 1}};
    nsdae_bodies *b;
    nsdae_system *system = NULL;
    nsdae_sim *sim = NULL;
    nsdae_sim_options o;
    nsdae_error error;
    char names[120];
    if (curved.shape != NSDAE_SHAPE_ELLIPSOID) curved.radius = 0.5;
    assert_int_equal(nsdae_bodies_create(3, &b, NULL), NSDAE_OK);
    nsdae_bodies_add(b, &(nsdae_rigid_body){.mass = 1, .inertia = {1, 1, 1}});
    nsdae_bodies_add_solid(b, NSDAE_GROUND, &ground[field]);
    nsdae_bodies_add_solid(b, 0, &curved);
    if (named) {
      assert_int_equal(nsdae_bodies_add_contact(b, 0, 1, 0.3, 0, 0), NSDAE_E_ARGUMENT);
      assert_non_null(strstr(nsdae_bodies_error(b)->text, "by nsdae_bodies_set_pair alone"));
    } else {
      nsdae_bodies_set_pair(b, 0, 0, 0.3, 0, 0);
      assert_true(nsdae_bodies_system(b, &system) >= 0);
      nsdae_sim_options_default(&o);
      o.method = NSDAE_METHOD_EVENT;
      assert_int_equal(nsdae_sim_create(system, &o, &sim, &error), NSDAE_E_ARGUMENT);
      snprintf(names, sizeof names, "%s and %s have contacts for time stepping alone",
               nsdae_solid_name(curved.shape), field ? "height field" : "mesh");
      if (!strstr(error.text, names)) fail_msg("%s", error.text);
    }
    nsdae_system_destroy(&system);
    nsdae_bodies_destroy(&b);
  }
}

/* A ball and a box on a height field. */
static int make_and_step(nsdae_bodies **b, nsdae_system **system, nsdae_sim **sim)
{
  static const double height[6] = {0, 0.1, 0, 0, 0, 0.2};
  static const nsdae_solid solid[3] = {
      {.shape = NSDAE_SHAPE_HEIGHT_FIELD, .point = height, .grid = {3, 2}, .length = {1, 1, 0.1}},
      {.shape = NSDAE_SHAPE_SPHERE, .radius = 0.1},
      {.shape = NSDAE_SHAPE_BOX, .length = {0.2, 0.2, 0.2}}};
  double q[14], v[12];
  nsdae_sim_options o;
  nsdae_sim_options_default(&o);
  o.method = NSDAE_METHOD_MOREAU;
  o.dt = 0.01;
  int status = nsdae_bodies_create(3, b, NULL);
  if (status < 0) return status;
  nsdae_bodies_set_gravity(*b, (const double[]){0, 0, -10});
  nsdae_bodies_set_pair(*b, 0, 0, 0.3, 0, 0);
  for (int i = 0; i < 3 && status >= 0; i++) {
    nsdae_rigid_body body = {
        .mass = 1, .inertia = {0.01, 0.01, 0.01}, .position = {i == 1 ? 0.3 : -0.3, 0, 0.25}};
    if (i > 0) nsdae_bodies_add(*b, &body);
    status = nsdae_bodies_add_solid(*b, i == 0 ? NSDAE_GROUND : i - 1, &solid[i]);
  }
  if (status >= 0) status = nsdae_bodies_system(*b, system);
  if (status < 0) return status;
  nsdae_bodies_get_start(*b, q, v);
  status = nsdae_sim_create(*system, &o, sim, NULL);
  if (status >= 0) status = nsdae_sim_init(*sim, 0, q, v);
  for (int i = 0; i < 30 && status >= 0; i++) status = nsdae_sim_step(*sim);
  return status;
}

/* Each allocation fails in turn: it is reported and nothing is left; or a contact problem was
 * solved without. */
static void test_memory(void **state)
{
  long at = 0;
  (void)state;
  for (int met = 1; met; at++) {
    nsdae_bodies *b = NULL;
    nsdae_system *system = NULL;
    nsdae_sim *sim = NULL;
    allocator_reset(at);
    int status = make_and_step(&b, &system, &sim);
    met = the_allocator.calls > at;
    if (met && b && !system) assert_int_equal(nsdae_bodies_error(b)->status, NSDAE_E_MEMORY);
    if (!met) {
      nsdae_record r;
      nsdae_sim_get_record(sim, &r);
      assert_true(r.contacts.count > 2);
    }
    nsdae_sim_destroy(&sim);
    nsdae_system_destroy(&system);
    nsdae_bodies_destroy(&b);
    if (the_allocator.live != 0) fail_msg("allocation %ld: %ld left", at, the_allocator.live);
    if (!(status >= 0 || (met && status == NSDAE_E_MEMORY)))
      fail_msg("allocation %ld: status %d", at, status);
  }
  allocator_reset(-1);
  print_message("%ld allocations\n", at);
  assert_true(at > 40);
}

int main(void)
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(test_gaps),          cmocka_unit_test(test_inertia),
      cmocka_unit_test(test_refused),       cmocka_unit_test(test_soup),
      cmocka_unit_test(test_refused_pairs), cmocka_unit_test(test_memory)};
  return cmocka_run_group_tests(tests, NULL, NULL);
}
