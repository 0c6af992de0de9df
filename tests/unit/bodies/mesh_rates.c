/* Contacts of solids with a mesh along motions: their rates against differences where nothing sharp
 * is near, and the least gap on paths across edges and corners. */
#include "check.h"

#include <nsdae/nsdae.h>
#include <stdlib.h>

#include "bodies_impl.h"
#include "mesh.h"
#include "support/random.h"

static uint64_t seed = 21;

static double uniform(double low, double high)
{
  return random_between(&seed, low, high);
}

static void subtract(const double *a, const double *b, double *c)
{
  for (int j = 0; j < 3; j++) c[j] = a[j] - b[j];
}

/* ---- a bowl of cells of 2/3 m with peaks, and a solid above it */

enum { LINE = 13, SHAPES = 4, MOST = 8 }; /* MOST: corners */

static const double tetrahedron[12] = {0.5,  0.5, 0.5,  0.4,  -0.5, -0.4,
                                       -0.5, 0.5, -0.5, -0.5, -0.4, 0.3};
static const nsdae_solid shapes[SHAPES] = {
    {.shape = NSDAE_SHAPE_SPHERE, .radius = 0.3, .material = 1},
    {.shape = NSDAE_SHAPE_CAPSULE, .radius = 0.2, .length = {0, 0, 0.8}, .material = 1},
    {.shape = NSDAE_SHAPE_BOX, .length = {1, 0.8, 0.5}, .material = 1},
    {.shape = NSDAE_SHAPE_POLYHEDRON, .points = 4, .point = tetrahedron, .material = 1}};

typedef struct scene {
  nsdae_bodies *b;
  nsdae_system *system;
  const nsdae_solid_of *mesh, *solid;
  nsdae_pose still, pose;
  nsdae_couple two;
} scene;

static void make_scene(scene *s, const nsdae_solid *solid)
{
  double height[LINE * LINE];
  for (int i = 0; i < LINE * LINE; i++) {
    double x = 2.0 / 3 * (i % LINE - 6.0), y = 2.0 / 3 * ((double)i / LINE - 6);
    height[i] = 0.05 * (x * x + y * y) + uniform(-0.1, 0.1);
    if (random_below(&seed, 6) == 0) height[i] += 0.5; /* a peak */
  }
  const nsdae_solid ground = {.shape = NSDAE_SHAPE_HEIGHT_FIELD,
                              .point = height,
                              .grid = {LINE, LINE},
                              .length = {8, 8, 0.2}};
  assert_int_equal(nsdae_bodies_create(3, &s->b, NULL), NSDAE_OK);
  nsdae_bodies_add(s->b, &(nsdae_rigid_body){.mass = 1, .inertia = {1, 1, 1}});
  nsdae_bodies_add_solid(s->b, NSDAE_GROUND, &ground);
  nsdae_bodies_add_solid(s->b, 0, solid);
  nsdae_bodies_set_pair(s->b, 0, 1, 0.3, 0, 0);
  if (nsdae_bodies_system(s->b, &s->system) < 0) fail_msg("%s", nsdae_bodies_error(s->b)->text);
  s->mesh = nsdae_solid_at(s->b, 0);
  s->solid = nsdae_solid_at(s->b, 1);
  s->still = nsdae_pose_ground();
  s->two = (nsdae_couple){{s->mesh, s->solid}, {&s->still, &s->pose}};
}

static void place(scene *s, const double *q)
{
  s->pose = nsdae_pose_of(3, q, NULL);
}

static void end_scene(scene *s)
{
  nsdae_system_destroy(&s->system);
  nsdae_bodies_destroy(&s->b);
}

static void random_pose(double *q)
{
  double square = 0;
  for (int i = 0; i < 2; i++) q[i] = uniform(-2, 2);
  q[2] = 0.05 * (q[0] * q[0] + q[1] * q[1]) + uniform(0, 1);
  for (int i = 3; i < 7; i++) q[i] = uniform(-1, 1);
  for (int i = 3; i < 7; i++) square += q[i] * q[i];
  for (int i = 3; i < 7; i++) q[i] /= sqrt(square);
}

/* ---- sharpness
 *
 * Directions of friction turn over at a normal with n_z = 0.95. Other contacts are as sharp as the
 * distance l of a corner from an edge or a corner of the other, or the sine of two edges.
 * Differences of the step s = 5e-4 are off by s^4 / 30 of the fifth derivative. That is 5! / l^5 at
 * the speed 1, so they are off by 2e-8 at l = 0.1. And the part of a solid that is the nearest to a
 * corner of the mesh must not change. */
static const double near = 1; /* farther than the reach of the check and the radius */
static const double sharp = 0.1;

static double from_segment(const double *x, const double *a, const double *b)
{
  double e[3], d[3];
  subtract(b, a, e);
  subtract(x, a, d);
  double along = fmin(fmax(nsdae_dot3(e, d) / nsdae_dot3(e, e), 0), 1);
  for (int j = 0; j < 3; j++) d[j] -= along * e[j];
  return sqrt(nsdae_dot3(d, d));
}

/* The part of a solid that is nearest to a place of its frame, by brute force: corners, edges,
 * faces; within it the face that is the least deep. */
static int nearest_part(const nsdae_solid_of *s, const double *own, double *distance)
{
  const nsdae_hull *hull = s->hull;
  double most = -INFINITY, least = INFINITY, d[3], e[3], out[3];
  int part = 0;
  for (int f = 0; f < hull->faces; f++) {
    const double *n = s->edge + 4 * f;
    double height = nsdae_dot3(n, own) - n[3];
    int over = height > 0;
    if (height > most) most = height, part = s->points + hull->edges + f;
    for (int i = hull->first[f]; i < hull->first[f + 1]; i++) {
      int last = i + 1 == hull->first[f + 1];
      const double *a = s->point + 3 * hull->ring[i];
      subtract(s->point + 3 * hull->ring[last ? hull->first[f] : i + 1], a, e);
      subtract(own, a, d);
      nsdae_cross3(e, n, out);
      over &= nsdae_dot3(out, d) <= 0;
    }
    if (over) return *distance = height, s->points + hull->edges + f;
  }
  if (hull->faces > 0 && most <= 0) return *distance = most, part;
  for (int i = 0; i < s->points; i++) {
    subtract(own, s->point + 3 * i, d);
    double length = sqrt(nsdae_dot3(d, d));
    if (length < least) least = length, part = i;
  }
  for (int i = 0; i < hull->edges; i++) {
    double length =
        from_segment(own, s->point + 3 * hull->edge[i][0], s->point + 3 * hull->edge[i][1]);
    if (length < least * (1 - 1e-9)) least = length, part = s->points + i;
  }
  return *distance = least, part;
}

static int is_sharp_corner(const nsdae_solid_of *s, const double *own)
{
  double distance, unused, x[3];
  int part = nearest_part(s, own, &distance), sharp_part = part < s->points + s->hull->edges;
  if (distance > near) return 0;
  if (sharp_part && distance < sharp) return 1;
  for (int i = 0; i < 8; i++) {
    for (int j = 0; j < 3; j++) x[j] = own[j] + (i >> j & 1 ? 0.01 : -0.01);
    if (nearest_part(s, x, &unused) != part) return 1;
  }
  return 0;
}

/* Of two segments that cross, seen along their common normal, within the reach. */
static int is_sharp_crossing(const double *a, const double *b, const double *c, const double *d)
{
  double u[3], v[3], w[3], n[3], x[3];
  subtract(b, a, u);
  subtract(d, c, v);
  subtract(c, a, w);
  nsdae_cross3(u, v, n);
  double square = nsdae_dot3(n, n);
  if (square > 0.04 * nsdae_dot3(u, u) * nsdae_dot3(v, v)) return 0;
  nsdae_cross3(w, v, x);
  double s = nsdae_dot3(x, n) / square;
  nsdae_cross3(w, u, x);
  double t = nsdae_dot3(x, n) / square;
  return square == 0 || (s > -0.1 && s < 1.1 && t > -0.1 && t < 1.1 &&
                         fabs(nsdae_dot3(w, n)) < near * sqrt(square));
}

/* Contacts by what touches, and whether the directions of one turn over. */
enum { FACE, SHARP, ON_SOLID, EDGES, KINDS };
typedef struct tally {
  int kinds[KINDS], over;
} tally;

static int count(void *to, long number, const nsdae_closest *c, const nsdae_couple *two)
{
  tally *t = to;
  (void)number;
  t->kinds[two->solid[1]->mesh            ? ON_SOLID
           : c->kind == NSDAE_PLANE_POINT ? FACE
           : c->kind == NSDAE_LINE_LINE   ? EDGES
                                          : SHARP]++;
  t->over |= fabs(fabs(nsdae_closest_still(c, two).normal[2]) - 0.95) < 0.02;
  return 0;
}

static int is_sharp_edge(const scene *s, const double *a, const double *b)
{
  const nsdae_solid_of *solid = s->solid;
  double x[MOST][3], d[3], own[3];
  for (int i = 0; i < solid->points; i++) {
    nsdae_pose_put(&s->pose, nsdae_solid_corner(solid, i), x[i]);
    if (from_segment(x[i], a, b) < sharp) return 1;
  }
  if (!solid->hull) return 0;
  subtract(a, s->pose.r, d);
  nsdae_turn_back(s->pose.R, d, own);
  if (is_sharp_corner(solid, own)) return 1;
  for (int e = 0; e < solid->hull->edges; e++)
    if (is_sharp_crossing(a, b, x[solid->hull->edge[e][0]], x[solid->hull->edge[e][1]])) return 1;
  return 0;
}

/* Of one that is not, its contacts are counted. */
static int is_sharp(scene *s, const double *q, int kinds[KINDS])
{
  const nsdae_mesh *m = s->mesh->mesh;
  tally found = {.over = 0};
  place(s, q);
  nsdae_mesh_contacts(&s->two, 0.3, count, &found);
  for (int i = 0; i < 3 * m->triangles && !found.over; i++)
    found.over = is_sharp_edge(s, nsdae_mesh_corner(m, i / 3, i % 3),
                               nsdae_mesh_corner(m, i / 3, i % 3 + 1));
  for (int i = 0; i < KINDS && !found.over; i++) kinds[i] += found.kinds[i];
  return found.over;
}

/* Of poses that are not sharp. */
static void test_rates(void **state)
{
  enum { SCENES = 30 };
  (void)state;
  for (int k = 0; k < SHAPES; k++) {
    int checked = 0, kinds[KINDS] = {0};
    scene s;
    for (int number = 0; number < SCENES; number++) {
      make_scene(&s, &shapes[k]);
      for (int pose = 0; pose < share_of(100); pose++) {
        double q[7], v[6];
        nsdae_check worst;
        random_pose(q);
        for (int i = 0; i < 6; i++) v[i] = uniform(-0.5, 0.5);
        if (is_sharp(&s, q, kinds)) continue;
        checked++;
        if (nsdae_system_check(s.system, 0, q, v, 1e-7, &worst) < 0)
          fail_msg("scene %d, pose %d of a %s: %s", number, pose, nsdae_solid_name(shapes[k].shape),
                   nsdae_system_error(s.system)->text);
      }
      end_scene(&s);
    }
    print_message(
        "%s: %d poses, of the mesh faces %d, edges and corners %d, corners on the solid %d,"
        " two edges %d\n",
        nsdae_solid_name(shapes[k].shape), checked, kinds[FACE], kinds[SHARP], kinds[ON_SOLID],
        kinds[EDGES]);
    int few = share_of(6) - 1; /* more than these of each kind */
    assert_true(checked > SCENES * share_of(100) / 20);
    assert_true(kinds[FACE] > share_of(100) && kinds[SHARP] > few);
    assert_true(!shapes[k].length[2] || (kinds[ON_SOLID] > few && kinds[EDGES] > few));
  }
}

/* ---- continuity
 *
 * The distance of solids that are apart changes by no more than the farthest that a point of one
 * moves. So does the depth of those that overlap as little as bodies at rest do, 5e-5. */
static int least(void *to, long number, const nsdae_closest *c, const nsdae_couple *two)
{
  double *gap = to;
  (void)number;
  *gap = fmin(*gap, nsdae_closest_still(c, two).gap);
  return 0;
}

static double least_gap(scene *s, const double *q)
{
  double gap = 0.1;
  place(s, q);
  nsdae_mesh_contacts(&s->two, gap, least, &gap);
  return gap;
}

/* From above down to a gap, then along: the number of steps until it is a depth. */
static int follow(scene *s, double gap, double depth)
{
  double q[7], v[7], now, x[MOST][3], y[3], d[3];
  int corners = s->solid->points, steps = 0;
  random_pose(q);
  for (int i = 0; i < 7; i++) v[i] = uniform(-1, 1) * (i < 2 ? 5e-4 : i == 2 ? 5e-5 : 1.5e-4);
  q[2] += 1.5;
  do {
    now = least_gap(s, q);
    q[2] -= now;
  } while (now > 1e-6);
  q[2] += gap;
  for (double before = least_gap(s, q); steps < 300; steps++, before = now) {
    double moved = 0;
    for (int c = 0; c < corners; c++)
      nsdae_pose_put(&s->pose, nsdae_solid_corner(s->solid, c), x[c]);
    for (int j = 0; j < 7; j++) q[j] += v[j];
    now = least_gap(s, q);
    for (int c = 0; c < corners; c++) {
      nsdae_pose_put(&s->pose, nsdae_solid_corner(s->solid, c), y);
      subtract(y, x[c], d);
      moved = fmax(moved, sqrt(nsdae_dot3(d, d)));
    }
    if (before < -depth) break;
    if (!(fabs(now - before) <= moved + 1e-12))
      fail_msg("a %s moves by %g, its gap from %g to %g", nsdae_solid_name(s->solid->shape), moved,
               before, now);
  }
  return steps;
}

static void test_continuity(void **state)
{
  enum { SCENES = 3 };
  static const double gap[] = {0.02, -5e-5}, depth[] = {0, 1e-4};
  (void)state;
  for (int k = 0; k < SHAPES; k++)
    for (int n = 0; n < 2; n++) {
      int steps = 0;
      scene s;
      for (int number = 0; number < SCENES; number++) {
        make_scene(&s, &shapes[k]);
        for (int path = 0; path < share_of(100); path++) steps += follow(&s, gap[n], depth[n]);
        end_scene(&s);
      }
      print_message("%s from a gap of %g: %d steps\n", nsdae_solid_name(shapes[k].shape), gap[n],
                    steps);
      assert_true(steps > 50 * SCENES * share_of(100));
    }
}

int main(void)
{
  const struct CMUnitTest tests[] = {cmocka_unit_test(test_rates),
                                     cmocka_unit_test(test_continuity)};
  return cmocka_run_group_tests(tests, NULL, NULL);
}
