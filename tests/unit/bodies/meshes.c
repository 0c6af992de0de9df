/* Meshes: gaps against brute force over all triangles, without the tree: a solid that is apart from
 * a surface has the least distance of all pairs of a corner and a triangle and of two edges
 * (C. Ericson, Real-Time Collision Detection, 2005, 5.1). And rounding alone is deeper: a ball that
 * overlaps has the same least gap. */
#include "check.h"

#include <nsdae/nsdae.h>
#include <stdlib.h>

#include "bodies_impl.h"
#include "mesh.h"
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
  int apart = 0, contacts = 0;
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
    for (int i = 0; i < poses / 10; i++) {
      double q[7];
      for (int j = 0; j < 7; j++) q[j] = random_between(&seed, -1, 1) * (j < 2 ? 0.7 : 1);
      if (i % 3 == 0) q[3] = 1, q[4] = q[5] = q[6] = 0; /* upright: edges along those of the grid */
      q[2] = random_between(&seed, 0, 0.4);
      const nsdae_pose pose = nsdae_pose_of(3, q, NULL);
      double corner[3], below = INFINITY, out = 0;
      for (int c = 0; c < s[1].points; c++) {
        nsdae_pose_put(&pose, nsdae_solid_corner(&s[1], c), corner);
        below = fmin(below, corner[2]);
        out = fmax(out, fmax(fabs(corner[0]), fabs(corner[1])));
      }
      double exact = brute(s[0].mesh, &s[1], &pose);
      least l = {.gap = INFINITY};
      const nsdae_couple two = {{&s[0], &s[1]}, {&still, &pose}};
      nsdae_mesh_contacts(&two, exact - s[1].radius + 1e-6, keep_least, &l);
      contacts += l.count;
      if (below < 0.151 || out + exact > 0.8) continue; /* apart, and far from the border */
      apart++;
      double error = fabs(l.gap - (exact - s[1].radius));
      if (!(error < 1e-12))
        print_message("%s: %d contacts, gap %.12g, exact %.12g\n", name, l.count, l.gap,
                      exact - s[1].radius);
      worst = fmax(worst, error);
    }
    nsdae_bodies_destroy(&b);
  }
  print_message("%s: %d poses apart, %d contacts, largest error of the gap %.1e\n", name, apart,
                contacts, worst);
  assert_true(worst < 1e-12);
  assert_true(apart > poses / 10);
}

static void test_gaps(void **state)
{
  static const double tetrahedron[12] = {0.1, 0.1,  0.1, 0.1,  -0.1, -0.1,
                                         -0.1, 0.1, -0.1, -0.1, -0.1, 0.1};
  (void)state;
  compare(&(nsdae_solid){.shape = NSDAE_SHAPE_SPHERE, .radius = 0.3}, 100000, "sphere");
  compare(&(nsdae_solid){.shape = NSDAE_SHAPE_POINT}, 50000, "point");
  compare(&(nsdae_solid){.shape = NSDAE_SHAPE_CAPSULE, .radius = 0.05, .length = {0, 0, 0.3}}, 10000,
          "capsule");
  compare(&(nsdae_solid){.shape = NSDAE_SHAPE_BOX, .length = {0.3, 0.2, 0.1}}, 5000, "box");
  compare(&(nsdae_solid){.shape = NSDAE_SHAPE_POLYHEDRON, .points = 4, .point = tetrahedron}, 5000,
          "tetrahedron");
}

int main(void)
{
  const struct CMUnitTest tests[] = {cmocka_unit_test(test_gaps)};
  return cmocka_run_group_tests(tests, NULL, NULL);
}
