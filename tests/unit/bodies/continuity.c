/* Gaps through degenerate poses: edges and faces parallel, corner on corner, corner on edge, edge on
 * edge, apart and overlapping. The distance of two bodies, and the least depth of their overlap,
 * changes by no more than the farthest that a point of one moves against the other; so does the least
 * gap over a pair's contacts, on a path through each such pose. */
#include "check.h"

#include <nsdae/nsdae.h>
#include <stdlib.h>

#include "world.h"

static uint64_t seed = 11;

static double uniform(double low, double high)
{
  seed = seed * 6364136223846793005u + 1442695040888963407u;
  return low + (high - low) * (double)(seed >> 11) / 9007199254740992.0;
}

static int below(int n)
{
  return (int)uniform(0, n);
}

static const double corners[8] = {-0.5, -0.4, 0.6, -0.4, 0.6, 0.5, -0.5, 0.3};

typedef struct couple {
  nsdae_bodies *bodies;
  int d, nq;
} couple;

static nsdae_solid solid_of(int shape, int hollow)
{
  nsdae_solid s = {.shape = shape,
                   .radius = hollow ? 3 : 0.25 * (1 + below(2)),
                   .hollow = hollow,
                   .points = 4,
                   .point = corners};
  for (int i = 0; i < 3; i++) s.length[i] = 0.5 * (1 + below(2));
  if (shape == NSDAE_SHAPE_POINT || shape == NSDAE_SHAPE_POLYGON || shape == NSDAE_SHAPE_BOX)
    s.radius = 0;
  return s;
}

static couple make(int d, const nsdae_solid *first, const nsdae_solid *second)
{
  const nsdae_rigid_body body = {.mass = 1, .inertia = {1, 1, 1}};
  couple c = {.d = d, .nq = d == 2 ? 3 : 7};
  nsdae_system *system;
  assert_int_equal(nsdae_bodies_create(d, &c.bodies, NULL), NSDAE_OK);
  for (int i = 0; i < 2; i++) {
    nsdae_bodies_add(c.bodies, &body);
    nsdae_bodies_add_solid(c.bodies, i, i ? second : first);
  }
  nsdae_bodies_add_contact(c.bodies, 0, 1, 0, 0, 0);
  assert_int_equal(nsdae_bodies_system(c.bodies, &system), NSDAE_OK);
  nsdae_system_destroy(&system);
  return c;
}

static double least_gap(const couple *c, const double *q)
{
  const nsdae_solid_of *s = c->bodies->solid.at;
  nsdae_pose pose[2];
  double least = INFINITY;
  for (int i = 0; i < 2; i++) pose[i] = nsdae_bodies_pose(c->bodies, i, q, NULL);
  for (int i = 0; i < c->bodies->feature.count; i++) {
    const nsdae_feature *f = (const nsdae_feature *)c->bodies->feature.at + i;
    const int *of = f->solid;
    nsdae_touch touch =
        nsdae_feature_touch(f, s + of[0], s + of[1], &pose[of[0]], &pose[of[1]]);
    if (!touch.far) least = fmin(least, touch.gap.x);
  }
  return least;
}

/* Turns by a number of quarters about each axis, in the plane about z alone. */
static void turn_quarters(const couple *c, double *q)
{
  const double half = sqrt(0.5);
  if (c->d == 2) {
    q[2] = below(4) * acos(0);
    return;
  }
  double p[4] = {1, 0, 0, 0};
  for (int axis = 0; axis < 3; axis++)
    if (below(2)) { /* p := p (half, half e) */
      double e[4] = {half, 0, 0, 0}, r[4];
      e[1 + axis] = half;
      r[0] = p[0] * e[0] - nsdae_dot3(p + 1, e + 1);
      nsdae_cross3(p + 1, e + 1, r + 1);
      for (int i = 1; i < 4; i++) r[i] += p[0] * e[i] + e[0] * p[i];
      memcpy(p, r, sizeof p);
    }
  memcpy(q + 3, p, sizeof p);
}

/* A place of a solid in space: a corner, the middle between two, or anywhere between them. */
static void place_of(const couple *c, int i, const double *q, double *x)
{
  const nsdae_solid_of *s = (const nsdae_solid_of *)c->bodies->solid.at + i;
  double part = 0.5 * below(3), local[3] = {0};
  if (below(4) == 0) part = uniform(0, 1);
  for (int j = 0; s->points > 0 && j < 3; j++) {
    static int first, second;
    if (j == 0) first = below(s->points), second = below(s->points);
    local[j] = (1 - part) * s->point[3 * first + j] + part * s->point[3 * second + j];
  }
  nsdae_bodies_locate(c->bodies, q, i, local, x);
}

/* Parallel to each other (or, one time in two, one as it may be), a place of the one on a place of
 * the other, or above it along an axis. */
static void degenerate_pose(const couple *c, double *q)
{
  double x[2][3];
  memset(q, 0, 14 * sizeof *q);
  for (int i = 0; i < 2; i++) {
    double *own = q + i * c->nq;
    if (c->d == 3) own[3] = 1;
    turn_quarters(c, own);
  }
  if (below(2) && c->d == 2) q[2] = q[5] += uniform(-1, 1);
  if (below(3) == 0) /* an edge or a corner on it */
    for (int j = 0; j < (c->d == 2 ? 1 : 2); j++) q[(c->d == 2 ? 2 : 4) + j] += uniform(-1, 1);
  for (int i = 0; i < 2; i++) place_of(c, i, q, x[i]);
  for (int j = 0; j < c->d; j++) q[c->nq + j] = x[0][j] - x[1][j];
  q[c->nq + below(c->d)] += below(3) * uniform(-0.2, 0.4);
}

static double speed_bound(const couple *c, const double *q, const double *w)
{
  const nsdae_solid_of *s = c->bodies->solid.at;
  double bound = 0;
  for (int i = 0; i < 2; i++) {
    const double *own = q + i * c->nq, *rate = w + i * c->nq;
    double linear = 0, turn = 0, square = 0;
    for (int j = 0; j < c->d; j++) linear += rate[j] * rate[j];
    for (int j = c->d; j < c->nq; j++) turn += rate[j] * rate[j], square += own[j] * own[j];
    /* |omega| <= 2 |p'| / |p| */
    double omega = c->d == 2 ? sqrt(turn) : 2 * sqrt(turn / square);
    double arm = 0;
    for (int j = 0; j < 2; j++) arm += s[j].shape == NSDAE_SHAPE_PLANE ? 0 : nsdae_solid_size(s + j);
    double apart = 0;
    for (int j = 0; j < c->d; j++) apart += pow(q[c->nq + j] - q[j], 2);
    bound += sqrt(linear) + omega * (arm + sqrt(apart));
  }
  return bound;
}

static double worst_of_pair;

static void follow_path(const couple *c, const double *q)
{
  double w[14], last = 0, s_last = 0, at[14];
  for (int j = 0; j < 2 * c->nq; j++) w[j] = uniform(-1, 1);
  double bound = 1.1 * speed_bound(c, q, w);
  for (int k = -60; k <= 60; k++) { /* -1e-2 .. -1e-15, 0, 1e-15 .. 1e-2 */
    double s = k == 0 ? 0 : (k < 0 ? -1 : 1) * 1e-2 * pow(10, -13. * (60 - abs(k)) / 59);
    for (int j = 0; j < 2 * c->nq; j++) at[j] = q[j] + s * w[j];
    double gap = least_gap(c, at);
    if (k > -60) {
      double excess = fabs(gap - last) - bound * (s - s_last);
      if (excess > worst_of_pair) {
        worst_of_pair = excess;
        if (getenv("NSDAE_VERBOSE")) printf("   k %d s %g gap %.12g %.12g excess %g\n", k, s, last, gap, excess);
      }
    }
    last = gap;
    s_last = s;
  }
}

static void follow_all(int d, const int *shapes, int count, int last_is_base)
{
  int poses = getenv("NSDAE_LONG") ? 20000 : 300;
  for (int i = 0; i < count; i++)
    for (int j = 0; j < count; j++) {
      if (i == j && i == count - 1 && last_is_base) continue;
      worst_of_pair = 0;
      for (int k = 0; k < poses; k++) {
        nsdae_solid first = solid_of(shapes[i], i == count - 1 && last_is_base == 2), second = solid_of(shapes[j], j == count - 1 && last_is_base == 2);
        double q[14];
        couple c = make(d, &first, &second);
        degenerate_pose(&c, q);
        follow_path(&c, q);
        nsdae_bodies_destroy(&c.bodies);
      }
      printf("shapes %d %d%s: worst %g\n", shapes[i], shapes[j], last_is_base == 2 && (i == count - 1 || j == count -1) ? " hole" : "", worst_of_pair);
    }
}

static void test_planar(void **state)
{
  const int shapes[] = {NSDAE_SHAPE_POINT, NSDAE_SHAPE_DISC, NSDAE_SHAPE_SEGMENT,
                        NSDAE_SHAPE_POLYGON, NSDAE_SHAPE_PLANE}, hole[] = {NSDAE_SHAPE_POINT, NSDAE_SHAPE_DISC, NSDAE_SHAPE_SEGMENT,
                        NSDAE_SHAPE_POLYGON, NSDAE_SHAPE_DISC};
  (void)state;
  follow_all(2, shapes, 5, 1);
  follow_all(2, hole, 5, 2);
}

static void test_spatial(void **state)
{
  const int shapes[] = {NSDAE_SHAPE_POINT, NSDAE_SHAPE_SPHERE, NSDAE_SHAPE_CAPSULE,
                        NSDAE_SHAPE_BOX, NSDAE_SHAPE_PLANE};
  (void)state;
  follow_all(3, shapes, 5, 1);
}

int main(void)
{
  const struct CMUnitTest tests[] = {cmocka_unit_test(test_planar), cmocka_unit_test(test_spatial)};
  return cmocka_run_group_tests(tests, NULL, NULL);
}
