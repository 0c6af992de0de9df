/* The signed distance of pairs with a curved solid. Of solids that are apart two points, one in
 * each, as far apart as a plane between them: the support maps here prove both bounds. Of those
 * that overlap a direction whose bound is no less than that of any of many directions, refined. */
#include "check.h"

#include <nsdae/nsdae.h>
#include <stdlib.h>
#include <time.h>

#include "bodies_impl.h"
#include "support.h"
#include "support/random.h"

static uint64_t seed = 11;

static double uniform(double low, double high)
{
  return random_between(&seed, low, high);
}

enum { CORNERS = 12 };
typedef struct shape {
  nsdae_solid of;
  double point[3 * CORNERS];
} shape;

static void random_shape(int kind, shape *s)
{
  s->of = (nsdae_solid){.shape = kind,
                        .radius = kind == NSDAE_SHAPE_BOX || kind == NSDAE_SHAPE_POLYHEDRON ||
                                          kind == NSDAE_SHAPE_ELLIPSOID
                                      ? 0
                                      : uniform(0.1, 0.5),
                        .length = {uniform(0.2, 1), uniform(0.2, 1), uniform(0.2, 1)}};
  for (int i = 0; i < 3 * CORNERS; i++) s->point[i] = uniform(-0.4, 0.4);
  if (kind != NSDAE_SHAPE_POLYHEDRON) return;
  s->of.points = CORNERS;
  s->of.point = s->point;
}

/* max d . x over the solid in its own frame. */
static double support(const shape *s, const double *d)
{
  const double *l = s->of.length, r = s->of.radius;
  double most = -INFINITY;
  switch (s->of.shape) {
  case NSDAE_SHAPE_BOX:
    return (fabs(d[0]) * l[0] + fabs(d[1]) * l[1] + fabs(d[2]) * l[2]) / 2;
  case NSDAE_SHAPE_CAPSULE:
    return fabs(d[2]) * l[2] / 2 + r * sqrt(nsdae_dot3(d, d));
  case NSDAE_SHAPE_CYLINDER:
    return fabs(d[2]) * l[2] / 2 + r * hypot(d[0], d[1]);
  case NSDAE_SHAPE_CONE:
    return fmax(r * hypot(d[0], d[1]) - d[2] * l[2] / 2, d[2] * l[2] / 2);
  case NSDAE_SHAPE_DISC:
    return r * hypot(d[0], d[1]);
  case NSDAE_SHAPE_ELLIPSOID:
    return hypot(hypot(l[0] * d[0], l[1] * d[1]), l[2] * d[2]) / 2;
  default:
    for (int i = 0; i < CORNERS; i++) most = fmax(most, nsdae_dot3(d, s->point + 3 * i));
    return most;
  }
}

static double apart(const shape s[2], const nsdae_pose pose[2], const double *n)
{
  double d[2][3], back[3] = {-n[0], -n[1], -n[2]}, between = 0;
  nsdae_turn_back(pose[0].R, n, d[0]);
  nsdae_turn_back(pose[1].R, back, d[1]);
  for (int i = 0; i < 3; i++) between += n[i] * (pose[1].r[i] - pose[0].r[i]);
  return between - support(&s[0], d[0]) - support(&s[1], d[1]);
}

/* The best of many directions, then of smaller and smaller steps from the best ones. */
static double search(const shape s[2], const nsdae_pose pose[2])
{
  enum { MANY = 600, KEPT = 6 };
  double best[KEPT] = {0}, at[KEPT][3], most = -INFINITY;
  for (int k = 0; k < KEPT; k++) best[k] = -INFINITY;
  for (int k = 0; k < MANY; k++) {
    double z = 1 - (2 * k + 1.0) / MANY, r = sqrt(1 - z * z), n[3];
    n[0] = r * cos(2.399963229728653 * k);
    n[1] = r * sin(2.399963229728653 * k);
    n[2] = z;
    double a = apart(s, pose, n);
    int worst = 0;
    for (int i = 1; i < KEPT; i++)
      if (best[i] < best[worst]) worst = i;
    if (a <= best[worst]) continue;
    best[worst] = a;
    memcpy(at[worst], n, sizeof n);
  }
  for (int k = 0; k < KEPT; k++) {
    int failed = 0;
    for (double h = 0.2; h > 1e-10;) {
      double n[3];
      for (int i = 0; i < 3; i++) n[i] = at[k][i] + uniform(-h, h);
      nsdae_unit_vector(n, n);
      double a = apart(s, pose, n);
      if (a > best[k]) {
        best[k] = a;
        memcpy(at[k], n, sizeof n);
        failed = 0;
      } else if (++failed == 12) {
        failed = 0;
        h *= 0.6;
      }
    }
    most = fmax(most, best[k]);
  }
  return most;
}

/* Two solids of these kinds, of bodies in random poses. */
static nsdae_bodies *couple(const int kind[2], shape s[2], nsdae_pose pose[2], double spread)
{
  nsdae_bodies *b;
  assert_int_equal(nsdae_bodies_create(3, &b, NULL), NSDAE_OK);
  for (int i = 0; i < 2; i++) {
    double q[7];
    random_shape(kind[i], &s[i]);
    assert_int_equal(nsdae_bodies_add(b, &(nsdae_rigid_body){.mass = 1, .inertia = {1, 1, 1}}), i);
    if (nsdae_bodies_add_solid(b, i, &s[i].of) < 0) fail_msg("%s", nsdae_bodies_error(b)->text);
    for (int j = 0; j < 7; j++) q[j] = uniform(-1, 1) * (j < 3 ? spread : 1);
    pose[i] = nsdae_pose_of(3, q, NULL);
  }
  return b;
}

static const int kinds_of[][2] = {{NSDAE_SHAPE_CYLINDER, NSDAE_SHAPE_BOX},
                                  {NSDAE_SHAPE_CAPSULE, NSDAE_SHAPE_CYLINDER},
                                  {NSDAE_SHAPE_CYLINDER, NSDAE_SHAPE_POLYHEDRON},
                                  {NSDAE_SHAPE_CYLINDER, NSDAE_SHAPE_CYLINDER},
                                  {NSDAE_SHAPE_CONE, NSDAE_SHAPE_BOX},
                                  {NSDAE_SHAPE_ELLIPSOID, NSDAE_SHAPE_CONE},
                                  {NSDAE_SHAPE_CAPSULE, NSDAE_SHAPE_ELLIPSOID},
                                  {NSDAE_SHAPE_CYLINDER, NSDAE_SHAPE_DISC},
                                  {NSDAE_SHAPE_CONE, NSDAE_SHAPE_CAPSULE},
                                  {NSDAE_SHAPE_CYLINDER, NSDAE_SHAPE_CONE},
                                  {NSDAE_SHAPE_ELLIPSOID, NSDAE_SHAPE_ELLIPSOID}};
enum { KINDS = sizeof kinds_of / sizeof *kinds_of };

static void new_pose(nsdae_pose *pose, double spread)
{
  double q[7];
  for (int j = 0; j < 7; j++) q[j] = uniform(-1, 1) * (j < 3 ? spread : 1);
  *pose = nsdae_pose_of(3, q, NULL);
}

/* The duality gap of 1e5 poses of a pair (or its share) that are apart. */
static void test_apart(void **state)
{
  enum { SOLIDS = 100, POSES = 1000 };
  (void)state;
  for (int k = 0; k < KINDS; k++) {
    double worst = 0, off = 0, inside = 0;
    clock_t begin = clock();
    int count = 0;
    for (int i = 0; i < SOLIDS; i += test_share()) {
      shape s[2];
      nsdae_pose pose[2];
      nsdae_bodies *b = couple(kinds_of[k], s, pose, 1);
      const nsdae_couple two = {{nsdae_solid_at(b, 0), nsdae_solid_at(b, 1)}, {&pose[0], &pose[1]}};
      for (int j = 0; j < (test_share() > 1 ? POSES / 4 : POSES); j++) {
        nsdae_still at;
        new_pose(&pose[0], 0.8);
        new_pose(&pose[1], 0.8);
        assert_true(nsdae_signed_distance(&two, INFINITY, &at));
        assert_near(nsdae_dot3(at.normal, at.normal), 1, 1e-13);
        worst = fmax(worst, fabs(at.gap - apart(s, pose, at.normal)));
        if (at.gap < 0) continue;
        double d[3];
        for (int l = 0; l < 3; l++) d[l] = at.at[1][l] - at.at[0][l];
        off = fmax(off, fabs(sqrt(nsdae_dot3(d, d)) - at.gap));
        /* the points are in both: beyond no plane at right angles to random directions */
        for (int l = 0; l < 4; l++) {
          double n[3] = {uniform(-1, 1), uniform(-1, 1), uniform(-1, 1)}, own[3], x[3];
          nsdae_unit_vector(n, n);
          for (int side = 0; side < 2; side++) {
            nsdae_turn_back(pose[side].R, n, own);
            for (int m = 0; m < 3; m++) x[m] = at.at[side][m] - pose[side].r[m];
            inside = fmax(inside, nsdae_dot3(n, x) - support(&s[side], own));
          }
        }
        count++;
      }
      nsdae_bodies_destroy(&b);
    }
    print_message(
        "pair %d: %d apart, bound off by %.1e m, points by %.1e m and outside by %.1e m, %.1f s\n",
        k, count, worst, off, inside, (double)(clock() - begin) / CLOCKS_PER_SEC);
    assert_true(worst < 1e-12);
    /* a direction over 1e-6 m, the least distance without a shift, has the rounding 4e-16 / 1e-6 */
    assert_true(off < 1e-9);
    assert_true(inside < 1e-12);
  }
}

/* In random poses, then moved along the normal until they overlap by a depth: the result is a local
 * maximum, and that of all but a few is the largest. */
static void test_overlap(void **state)
{
  static const double depths[] = {1e-7, 4e-5, 1e-2};
  const int poses = test_share() > 1 ? 75 : 200; /* of 2 % there is something to count */
  (void)state;
  for (int k = 0; k < KINDS; k++) {
    double off = 0;
    int deep = 0, missed = 0;
    for (int i = 0; i < poses; i++) {
      shape s[2];
      nsdae_pose pose[2];
      nsdae_bodies *b = couple(kinds_of[k], s, pose, 0.5);
      const nsdae_couple two = {{nsdae_solid_at(b, 0), nsdae_solid_at(b, 1)}, {&pose[0], &pose[1]}};
      nsdae_still at;
      assert_true(nsdae_signed_distance(&two, INFINITY, &at));
      deep += at.gap < search(s, pose) - 1e-8;
      for (int j = 0; j < 3; j++) {
        for (int l = 0; l < 3; l++) pose[1].r[l] -= (at.gap + depths[j]) * at.normal[l];
        assert_true(nsdae_signed_distance(&two, INFINITY, &at));
        double short_of = search(s, pose) - at.gap;
        missed += short_of > 1e-8;
        if (short_of <= 1e-8) off = fmax(off, short_of);
      }
      nsdae_bodies_destroy(&b);
    }
    print_message("pair %d: depth off by %.1e m; another maximum at %d of %d, of random poses %d\n",
                  k, off, missed, 3 * poses, deep);
    assert_true(missed <= 3 * poses / 50);
    assert_true(deep <= poses / 10);
  }
}

/* ---- rates
 *
 * Of solids that are apart n . (x'_1 - x'_0) is the rate of the gap exactly: with n or with the two
 * points fixed to their bodies there are bounds below and above that touch it (J. M. Danskin, The
 * theory of max-min, 1967). Differences come to it as their step falls, by its square, or slower
 * where a step goes from one part to another. Of an overlap two directions may be as good: there
 * the gap has no rate, and both are found to be so. */

/* Both bodies after the time h: x' = v, w in space. */
static void move(const double *q, const double *v, double h, nsdae_pose pose[2])
{
  for (int i = 0; i < 2; i++) {
    const double *w = v + 6 * i + 3, *p = q + 7 * i + 3;
    double at[7], length = sqrt(nsdae_dot3(w, w)), c = cos(h * length / 2), d[3];
    double turn = length > 0 ? sin(h * length / 2) / length : 0;
    nsdae_cross3(w, p + 1, d);
    at[3] = c * p[0] - turn * nsdae_dot3(w, p + 1);
    for (int j = 0; j < 3; j++) {
      at[j] = q[7 * i + j] + h * v[6 * i + j];
      at[4 + j] = c * p[1 + j] + turn * (p[0] * w[j] + d[j]);
    }
    pose[i] = nsdae_pose_of(3, at, NULL);
  }
}

/* The contact of a number after the time h. 0: there is none. */
static int contact_at(const nsdae_solid_of *solid, const double *q, const double *v, double h,
                      int number, nsdae_still *at)
{
  nsdae_pose pose[2];
  nsdae_manifold m;
  move(q, v, h, pose);
  const nsdae_couple two = {{&solid[0], &solid[1]}, {&pose[0], &pose[1]}};
  assert_true(nsdae_find_manifold(&two, INFINITY, &m));
  for (int i = 0; i < m.count; i++)
    if (m.number[i] == number) return *at = m.at[i], 1;
  return 0;
}

static double rate_of(const nsdae_still *at, const double *q, const double *v)
{
  double rate = 0;
  for (int i = 0; i < 2; i++) {
    double arm[3], turned[3];
    for (int j = 0; j < 3; j++) arm[j] = at->at[i][j] - q[7 * i + j];
    nsdae_cross3(v + 6 * i + 3, arm, turned);
    for (int j = 0; j < 3; j++) rate += (i ? 1 : -1) * at->normal[j] * (v[6 * i + j] + turned[j]);
  }
  return rate;
}

/* The largest error of a rate, of points that move by up to 2 m/s: if the cores are apart by g and
 * the two points by delta more than s(n), n is off by an angle of sqrt(2 delta / g) at most. At a
 * maximum of an overlap delta is a tenth of 1e-12 of g, as its search ends. */
static double tolerance(const nsdae_solid_of *solid, int number, const nsdae_still *at)
{
  double round = solid[0].radius + solid[1].radius, g = at->gap + round, square = 0, delta;
  if (number > 0) return 1e-7;
  for (int i = 0; i < 3; i++) square += pow(at->at[1][i] - at->at[0][i] + round * at->normal[i], 2);
  delta = g > 0 ? fabs(sqrt(square) - g) + 4e-15 : 1e-13;
  return 1e-7 + 2 * sqrt(2 * delta / fabs(g));
}

enum { SMOOTH, SHARP, JUMP, ALONE };

static int examine(const shape s[2], const nsdae_solid_of *solid, const double *q, const double *v,
                   int number, const nsdae_still *at)
{
  double rate = rate_of(at, q, v), error = INFINITY, tol = tolerance(solid, number, at);
  double slope[2] = {INFINITY, INFINITY};
  nsdae_still near[2];
  int pairs = 0;
  for (double h = 1e-3; h > 1e-6; h /= 3) {
    if (!contact_at(solid, q, v, -h, number, &near[0])) continue;
    if (!contact_at(solid, q, v, h, number, &near[1])) continue;
    double now = (near[1].gap - near[0].gap) / (2 * h);
    if (pairs < 2) slope[pairs] = now;
    error = fmin(error, fabs(now - rate));
    pairs++;
  }
  if (pairs == 0) return ALONE;
  if (error < tol) return fabs((9 * slope[1] - slope[0]) / 8 - rate) < tol / 4 ? SMOOTH : SHARP;
  nsdae_pose pose[2];
  double best[2], reach = 2 * 3e-6;
  move(q, v, 0, pose);
  for (int i = 0; i < 2; i++) best[i] = apart(s, pose, near[i].normal);
  if (number == 0 && at->gap < 0 && nsdae_dot3(near[0].normal, near[1].normal) < 0.999 &&
      fabs(best[0] - best[1]) < reach)
    return JUMP;
  fail_msg("contact %d of a %s and a %s, gap %g: rate %.12g is off by %.1e", number,
           nsdae_solid_name(s[0].of.shape), nsdae_solid_name(s[1].of.shape), at->gap, rate, error);
  return -1;
}

/* One time in three nearly flush, one upon the other or beside it. */
static void rates_pose(const shape s[2], int k, double *q)
{
  for (int i = 0; i < 14; i++) q[i] = uniform(-1, 1) * (i % 7 < 3 ? 0.5 : 1);
  if (k % 3 > 0) return;
  double tilt = uniform(-0.04, 0.04), up[3] = {0, 0, 0}, down[3] = {0, 0, 0};
  int axis = k / 6 % 3;
  for (int i = 0; i < 4; i++) {
    q[3 + i] = i == 0;
    q[10 + i] = i == 0 ? 1 : i == 1 + k / 3 % 2 ? tilt : 0;
  }
  up[axis] = 1, down[axis] = -1;
  q[7 + axis] = q[axis] + support(&s[0], up) + support(&s[1], down) + uniform(-0.01, 0.02);
}

static void test_rates(void **state)
{
  enum { POSES = 150 };
  const double deepest = 0.05; /* steps leave less: further in, the search ends before the top */
  const int stride = test_share() > 1 ? 4 : 1; /* of poses, of which every third is nearly flush */
  (void)state;
  for (int k = 0; k < KINDS; k++) {
    int kinds[4] = {0}, checked = 0;
    for (int n = 0; n < POSES; n += stride) {
      shape s[2];
      nsdae_pose pose[2];
      nsdae_manifold m;
      nsdae_system *system;
      nsdae_check worst;
      double q[14], v[12];
      for (int i = 0; i < 12; i++) v[i] = uniform(-1, 1);
      double tol = 0;
      int sharp = n % 3 == 0; /* there contacts come and go, which differences cannot know */
      nsdae_bodies *b = couple(kinds_of[k], s, pose, 1);
      rates_pose(s, n, q);
      move(q, v, 0, pose);
      const nsdae_solid_of *solid = nsdae_solid_at(b, 0);
      const nsdae_couple two = {{&solid[0], &solid[1]}, {&pose[0], &pose[1]}};
      assert_true(nsdae_find_manifold(&two, INFINITY, &m));
      for (int i = 0; i < 12 * m.count; i++) {
        const nsdae_still *at = &m.at[i / 12];
        double along[12] = {0};
        if (at->gap < -deepest) {
          sharp = 1;
          continue;
        }
        along[i % 12] = 1;
        int kind = examine(s, solid, q, along, m.number[i / 12], at);
        kinds[kind]++;
        sharp |= kind > SMOOTH;
        tol = fmax(tol, tolerance(solid, m.number[i / 12], at));
      }
      nsdae_bodies_add_contact(b, 0, 1, 0.3, 0, 0);
      assert_true(nsdae_bodies_system(b, &system) >= 0);
      if (!sharp && ++checked && nsdae_system_check(system, 0, q, v, 2 * tol, &worst) < 0)
        fail_msg("pose %d: %s", n, nsdae_system_error(system)->text);
      nsdae_system_destroy(&system);
      nsdae_bodies_destroy(&b);
    }
    print_message("pair %d: %d contacts with smooth gaps, %d sharp, %d jump, %d alone; %d poses\n",
                  k, kinds[0], kinds[1], kinds[2], kinds[3], checked);
    assert_true(kinds[SMOOTH] > 1000 / stride && checked > POSES / stride / 8);
    assert_true(kinds[ALONE] <= 3); /* in 1e-6 of 1 m, of the 2e4 cases here */
  }
}

int main(void)
{
  const struct CMUnitTest tests[] = {cmocka_unit_test(test_apart), cmocka_unit_test(test_overlap),
                                     cmocka_unit_test(test_rates)};
  return cmocka_run_group_tests(tests, NULL, NULL);
}
