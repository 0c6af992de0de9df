/* Gaps of every pair of shapes in random poses against an independent method: alternating
 * projections between the two convex cores (Cheney and Goldstein, Proc. AMS 10, 1959), which come
 * to their nearest points. The least gap over a pair's contacts is their distance less both
 * roundings; pushed together until they overlap by a little, it is that little. */
#include "check.h"

#include <nsdae/nsdae.h>
#include <stdlib.h>

#include "bodies_impl.h"
#include "support/feature_touch.h"
#include "support/random.h"

enum { PROJECTIONS = 20000 };

static uint64_t seed = 7;

static double uniform(double low, double high)
{
  return random_between(&seed, low, high);
}

static const double corners[10] = {-0.5, -0.4, 0.6, -0.3, 0.7, 0.2, 0.1, 0.6, -0.4, 0.3};

static double clamp(double x, double half)
{
  return fmin(fmax(x, -half), half);
}

/* The nearest point of the polygon of corners: x itself where it is inside of every edge. */
static void project_polygon(double *x)
{
  double best = INFINITY, nearest[2] = {x[0], x[1]};
  int inside = 1;
  for (int i = 0; i < 5; i++) {
    const double *a = corners + 2 * i, *b = corners + 2 * ((i + 1) % 5);
    double u[2] = {b[0] - a[0], b[1] - a[1]}, d[2] = {x[0] - a[0], x[1] - a[1]};
    if (u[0] * d[1] - u[1] * d[0] < 0) inside = 0;
    double s = fmin(fmax((u[0] * d[0] + u[1] * d[1]) / (u[0] * u[0] + u[1] * u[1]), 0), 1);
    double p[2] = {a[0] + s * u[0], a[1] + s * u[1]};
    double square = pow(x[0] - p[0], 2) + pow(x[1] - p[1], 2);
    if (square >= best) continue;
    best = square;
    memcpy(nearest, p, sizeof p);
  }
  if (!inside) memcpy(x, nearest, sizeof nearest);
}

/* x := the nearest point of the core in its own frame. */
static void project_core(const nsdae_solid *s, double *x)
{
  switch (s->shape) {
  case NSDAE_SHAPE_SEGMENT:
    x[0] = clamp(x[0], s->length[0] / 2);
    x[1] = x[2] = 0;
    break;
  case NSDAE_SHAPE_CAPSULE:
    x[2] = clamp(x[2], s->length[2] / 2);
    x[0] = x[1] = 0;
    break;
  case NSDAE_SHAPE_BOX:
    for (int i = 0; i < 3; i++) x[i] = clamp(x[i], s->length[i] / 2);
    break;
  case NSDAE_SHAPE_POLYGON:
    project_polygon(x);
    break;
  default:
    x[0] = x[1] = x[2] = 0;
  }
}

static void project(const nsdae_solid *s, const nsdae_pose *pose, double *x)
{
  double from[3], own[3];
  for (int i = 0; i < 3; i++) from[i] = x[i] - pose->r[i];
  nsdae_turn_back(pose->R, from, own);
  project_core(s, own);
  nsdae_turn(pose->R, own, x);
  for (int i = 0; i < 3; i++) x[i] += pose->r[i];
}

/* d := vector from the core of solid 0 to that of solid 1; returns its length, or -1 where the
 * projections are still moving. */
static double core_distance(const nsdae_solid s[2], const nsdae_pose pose[2], double *d)
{
  double x[2][3], last = INFINITY;
  memcpy(x[0], pose[1].r, sizeof x[0]);
  for (int i = 0; i < PROJECTIONS; i++) {
    project(&s[0], &pose[0], x[0]);
    memcpy(x[1], x[0], sizeof x[1]);
    project(&s[1], &pose[1], x[1]);
    for (int j = 0; j < 3; j++) d[j] = x[1][j] - x[0][j];
    double length = sqrt(nsdae_dot3(d, d));
    memcpy(x[0], x[1], sizeof x[0]);
    if (last - length <= 1e-15) return length;
    last = length;
  }
  return -1;
}

static nsdae_solid random_solid(int shape)
{
  nsdae_solid s = {.shape = shape, .radius = uniform(0.1, 0.4), .points = 5, .point = corners};
  for (int i = 0; i < 3; i++) s.length[i] = uniform(0.3, 1.5);
  if (shape == NSDAE_SHAPE_POINT || shape == NSDAE_SHAPE_POLYGON || shape == NSDAE_SHAPE_BOX)
    s.radius = 0;
  return s;
}

typedef struct couple {
  nsdae_bodies *bodies;
  nsdae_system *system;
  nsdae_solid solid[2];
  int d, nq, k;
} couple;

static void make_couple(couple *c, int d, int shape0, int shape1)
{
  const nsdae_rigid_body body = {.mass = 1, .inertia = {1, 1, 1}};
  c->d = d;
  c->nq = d == 2 ? 3 : 7;
  assert_int_equal(nsdae_bodies_create(d, &c->bodies, NULL), NSDAE_OK);
  for (int i = 0; i < 2; i++) {
    c->solid[i] = random_solid(i ? shape1 : shape0);
    nsdae_bodies_add(c->bodies, &body);
    nsdae_bodies_add_solid(c->bodies, i, &c->solid[i]);
  }
  nsdae_bodies_add_contact(c->bodies, 0, 1, 0, 0, 0);
  assert_true(nsdae_bodies_system(c->bodies, &c->system) >= 0);
  nsdae_dims dims;
  nsdae_bodies_get_dims(c->bodies, &dims);
  c->k = dims.k;
}

/* n: that of the least gap. */
static double least_gap(const couple *c, const double *q, double *n)
{
  double least = INFINITY;
  for (int i = 0; i < c->k; i++) {
    const nsdae_feature *f = (const nsdae_feature *)c->bodies->feature.at + i;
    const nsdae_solid_of *s = c->bodies->solid.at;
    nsdae_pose pose[2];
    for (int j = 0; j < 2; j++)
      pose[j] = nsdae_bodies_pose(c->bodies, s[f->solid[j]].body, q, NULL);
    nsdae_touch touch;
    if (!feature_touch(s, f, pose, &touch) || !(touch.gap.x < least)) continue;
    least = touch.gap.x;
    for (int j = 0; j < 3; j++) n[j] = touch.normal.at[j].x;
  }
  return least;
}

static void random_pose(const couple *c, double *q)
{
  for (int i = 0; i < 2; i++)
    for (int j = 0; j < c->nq; j++)
      q[i * c->nq + j] = j < c->d ? uniform(-1.2, 1.2) : uniform(-1, 1) * (c->d == 2 ? 3 : 1);
  if (c->d == 2) return;
  int upright = uniform(0, 1) < 0.2; /* parallel edges and faces */
  for (int i = 0; i < 2 && upright; i++)
    for (int j = 3; j < 7; j++) q[7 * i + j] = j == 3;
}

/* The largest errors of a pair: of the gap, and the sine between the normal and the way from core
 * to core. */
typedef struct errors {
  double gap, normal;
} errors;

/* One pose; returns 1 where the cores are apart and the distance could be found. */
static int compare(const couple *c, double *q, errors *worst)
{
  /* what the projections leave: they end when a round gains less than 1e-15, and gain linearly; how
   * much deeper than the overlap a contact may be: 1e-6 of both sizes, which are below 1.5 */
  const double found_to = 1e-9, overlap = 1e-4, deeper = 3e-6;
  nsdae_pose pose[2];
  double n[3], normal[3], across[3];
  random_pose(c, q);
  for (int i = 0; i < 2; i++) pose[i] = nsdae_bodies_pose(c->bodies, i, q, NULL);
  double distance = core_distance(c->solid, pose, n), least = least_gap(c, q, normal);
  if (distance < 1e-3) return 0;
  double expected = distance - c->solid[0].radius - c->solid[1].radius;
  if (!(fabs(least - expected) <= found_to * 1e3)) /* say which */
    print_error("shapes %d and %d\n", c->solid[0].shape, c->solid[1].shape);
  assert_near(least, expected, found_to * 1e3);
  worst->gap = fmax(worst->gap, fabs(least - expected));
  nsdae_cross3(normal, n, across);
  double sine = sqrt(nsdae_dot3(across, across)) / distance;
  assert_true(sine < sqrt(2 * found_to / distance)); /* of a way longer by found_to */
  worst->normal = fmax(worst->normal, sine);
  for (int i = 0; i < c->d; i++) q[c->nq + i] -= n[i] / distance * (expected + overlap);
  for (int i = 0; i < 2; i++) pose[i] = nsdae_bodies_pose(c->bodies, i, q, NULL);
  double left = core_distance(c->solid, pose, n), pushed = least_gap(c, q, normal);
  if (c->solid[0].radius + c->solid[1].radius > 0)
    assert_near(pushed, -overlap, found_to * 1e3);
  else if (left > found_to) /* a point went past a sharp corner */
    assert_near(pushed, left, found_to * 1e3);
  else if (left >= 0)
    assert_true(pushed <= found_to && pushed >= -overlap - deeper);
  return 1;
}

static void compare_all(int d, const int *shapes, int count)
{
  int poses = getenv("NSDAE_LONG") ? 100000 : 3200; /* of each pair; 10^5 in all */
  for (int i = 0; i < count; i++)
    for (int j = 0; j < count; j++) {
      enum { SIZES = 16 };
      errors worst = {0, 0};
      int used = 0;
      for (int size = 0; size < SIZES; size++) {
        couple c;
        double q[14];
        make_couple(&c, d, shapes[i], shapes[j]);
        for (int k = 0; k < poses / SIZES; k++) used += compare(&c, q, &worst);
        nsdae_system_destroy(&c.system);
        nsdae_bodies_destroy(&c.bodies);
      }
      print_message("%s and %s: %d poses apart, gap off by %.1e m, normal by %.1e\n",
                    nsdae_solid_name(shapes[i]), nsdae_solid_name(shapes[j]), used, worst.gap,
                    worst.normal);
      assert_true(used > poses / 4);
    }
}

static void test_planar(void **state)
{
  const int shapes[] = {NSDAE_SHAPE_POINT, NSDAE_SHAPE_DISC, NSDAE_SHAPE_SEGMENT,
                        NSDAE_SHAPE_POLYGON};
  (void)state;
  compare_all(2, shapes, 4);
}

static void test_spatial(void **state)
{
  const int shapes[] = {NSDAE_SHAPE_POINT, NSDAE_SHAPE_SPHERE, NSDAE_SHAPE_CAPSULE,
                        NSDAE_SHAPE_BOX};
  (void)state;
  compare_all(3, shapes, 4);
}

/* The normal of a point on the line of a capsule or rounded segment is across that line, and in the
 * plane of a planar one. The depth is that of both roundings. */
static void test_on_line(void **state)
{
  (void)state;
  for (int k = 0; k < 2000; k++) {
    int d = 2 + k % 2, axis = d == 2 ? 0 : 2;
    couple c;
    double q[14];
    make_couple(&c, d, d == 2 ? NSDAE_SHAPE_SEGMENT : NSDAE_SHAPE_CAPSULE,
                k / 2 % 2 ? NSDAE_SHAPE_POINT
                : d == 2  ? NSDAE_SHAPE_DISC
                          : NSDAE_SHAPE_SPHERE);
    random_pose(&c, q);
    const nsdae_pose line = nsdae_bodies_pose(c.bodies, 0, q, NULL);
    double part = uniform(-0.1, 0.1), off = k % 3 ? pow(10, uniform(-17, -12)) : 0;
    for (int j = 0; j < d; j++)
      q[c.nq + j] = q[j] + part * line.R[3 * axis + j] + off * uniform(-1, 1);
    const nsdae_solid_of *s = c.bodies->solid.at;
    const nsdae_pose other = nsdae_bodies_pose(c.bodies, 1, q, NULL);
    const nsdae_feature *f = c.bodies->feature.at;
    nsdae_touch touch;
    assert_true(feature_touch(s, f, (const nsdae_pose[2]){line, other}, &touch));
    const double n[3] = {touch.normal.at[0].x, touch.normal.at[1].x, touch.normal.at[2].x};
    assert_near(nsdae_dot3(n, n), 1, 1e-15);
    /* rounding, divided by the angle between the line and what it leaves of the offset: that is
     * below 1e-6 in 1e-6 of cases */
    assert_near(nsdae_dot3(n, line.R + 3 * axis), 0, 1e-10);
    if (d == 2) assert_true(n[2] == 0);
    assert_near(touch.gap.x, -s[0].radius - s[1].radius, 2 * off + 1e-15);
    nsdae_system_destroy(&c.system);
    nsdae_bodies_destroy(&c.bodies);
  }
}

int main(void)
{
  const struct CMUnitTest tests[] = {cmocka_unit_test(test_planar), cmocka_unit_test(test_spatial),
                                     cmocka_unit_test(test_on_line)};
  return cmocka_run_group_tests(tests, NULL, NULL);
}
