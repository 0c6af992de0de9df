/* Two boxes face on face, at random and in line: by quarter turns, edges above edges, corners on
 * corners, all of it up to rounding or a little more. The contacts against an independent method:
 * the polygon in which the faces meet, by clipping the one at the edges of the other (I. E.
 * Sutherland, G. W. Hodgman, Comm. ACM 17, 1974). They span it, none lies beside it, each has the
 * height of one face above the other, and there are few. */
#include "check.h"

#include <nsdae/nsdae.h>

#include "bodies_impl.h"
#include "narrow_phase.h"
#include "separating_axis.h"
#include "support/random.h"

enum { POSES = 40000, POINTS_MAX = 16, DIRECTIONS = 32 };

static uint64_t seed = 21;

static double uniform(double low, double high)
{
  return random_between(&seed, low, high);
}

static int below(int n)
{
  return random_below(&seed, n);
}

typedef struct polygon {
  int count;
  double at[POINTS_MAX][2];
} polygon;

/* What is left of p behind the line  x_axis side <= half */
static void clip(polygon *p, int axis, double side, double half)
{
  polygon left = {.count = 0};
  for (int i = 0; i < p->count; i++) {
    const double *a = p->at[i], *b = p->at[(i + 1) % p->count];
    double ha = half - side * a[axis], hb = half - side * b[axis];
    if (ha >= 0) memcpy(left.at[left.count++], a, sizeof left.at[0]);
    if ((ha >= 0) == (hb >= 0)) continue;
    for (int j = 0; j < 2; j++) left.at[left.count][j] = a[j] + ha / (ha - hb) * (b[j] - a[j]);
    left.count++;
  }
  *p = left;
}

static double support(const polygon *p, const double *d)
{
  double most = -INFINITY;
  for (int i = 0; i < p->count; i++) most = fmax(most, d[0] * p->at[i][0] + d[1] * p->at[i][1]);
  return most;
}

/* Box 1 on the face +z of box 0: in its frame shifted, turned about z, and that much above it. */
typedef struct scene {
  nsdae_bodies *b;
  double edge[2][3], shift[2], turn, height;
  nsdae_pose pose[2];
} scene;

static void draw(scene *s)
{
  const nsdae_rigid_body body = {.mass = 1, .inertia = {1, 1, 1}};
  static const double small[4] = {0, 1e-12, 1e-9, 1e-5};
  assert_int_equal(nsdae_bodies_create(3, &s->b, NULL), NSDAE_OK);
  for (int i = 0; i < 2; i++) {
    nsdae_solid box = {.shape = NSDAE_SHAPE_BOX};
    for (int j = 0; j < 3; j++)
      box.length[j] = s->edge[i][j] = below(3) ? 0.5 * (1 + below(3)) : uniform(0.4, 1.5);
    nsdae_bodies_add(s->b, &body);
    nsdae_bodies_add_solid(s->b, i, &box);
  }
  s->turn = below(3) ? below(4) * acos(0) : uniform(-3, 3);
  s->turn += small[below(4)] * uniform(-1, 1);
  s->height = (below(2) ? 1e-3 : 1e-8) * uniform(-1, 1);
  for (int j = 0; j < 2; j++) {
    s->shift[j] = below(3) ? 0.25 * (below(7) - 3) : uniform(-0.8, 0.8);
    if (below(3) == 0) s->shift[j] += small[below(4)] * uniform(-1, 1);
  }
}

/* Both in space, box 0 at random. */
static void place(scene *s)
{
  double q[7], at[3] = {s->shift[0], s->shift[1], 0};
  for (int i = 0; i < 7; i++) q[i] = uniform(-1, 1);
  s->pose[0] = s->pose[1] = nsdae_pose_of(3, q, NULL);
  at[2] = s->edge[0][2] / 2 + s->height + s->edge[1][2] / 2;
  nsdae_pose_put(&s->pose[0], at, s->pose[1].r);
  const double c = cos(s->turn), sine = sin(s->turn), *R = s->pose[0].R;
  for (int j = 0; j < 3; j++) {
    s->pose[1].R[j] = c * R[j] + sine * R[3 + j];
    s->pose[1].R[3 + j] = c * R[3 + j] - sine * R[j];
  }
}

static polygon meeting_of(const scene *s)
{
  static const double corner[4][2] = {{-0.5, -0.5}, {0.5, -0.5}, {0.5, 0.5}, {-0.5, 0.5}};
  polygon p = {.count = 4};
  double c = cos(s->turn), sine = sin(s->turn);
  for (int i = 0; i < 4; i++) {
    double x = corner[i][0] * s->edge[1][0], y = corner[i][1] * s->edge[1][1];
    p.at[i][0] = s->shift[0] + c * x - sine * y;
    p.at[i][1] = s->shift[1] + sine * x + c * y;
  }
  for (int axis = 0; axis < 2; axis++)
    for (double side = -1; side < 2; side += 2) clip(&p, axis, side, s->edge[0][axis] / 2);
  return p;
}

typedef struct found {
  const scene *s;
  const nsdae_meeting *met;
  polygon points; /* on the face of box 0 */
} found;

static int keep(void *to, const nsdae_feature *f)
{
  found *k = to;
  nsdae_closest closest;
  const nsdae_pose *pose = &k->s->pose[0];
  if (!nsdae_feature_closest(f, k->met, &closest)) return 0;
  const nsdae_couple two = nsdae_feature_couple(f, k->met);
  const nsdae_still still = nsdae_closest_still(&closest, &two);
  if (still.gap > 2e-3) return 0;
  double from[3], own[3], along = fabs(nsdae_dot3(still.normal, pose->R + 6));
  if (along < 1 - 1e-9) { /* a corner or edge beside the face */
    assert_true(still.gap > 0 && still.gap >= k->s->height);
    return 0;
  }
  /* edges that are parallel up to 1e-8 leave eight digits of their normal */
  assert_near(still.gap, k->s->height, f->edges ? 1e-8 : 1e-12);
  for (int i = 0; i < 3; i++) from[i] = still.at[0][i] - pose->r[i];
  nsdae_turn_back(pose->R, from, own);
  assert_true(k->points.count < POINTS_MAX);
  memcpy(k->points.at[k->points.count++], own, sizeof k->points.at[0]);
  return 0;
}

/* 1 where the faces meet in more than a strip. */
static int compare(const scene *s)
{
  const nsdae_solid_of *solid = s->b->solid.at;
  const nsdae_couple two = {{&solid[0], &solid[1]}, {&s->pose[0], &s->pose[1]}};
  polygon p = meeting_of(s);
  nsdae_meeting met;
  found k = {.s = s, .met = &met};
  double size = solid[0].size + solid[1].size, slack = NSDAE_SLACK * size;
  double beside = 2 * NSDAE_BESIDE * size; /* along both axes */
  for (int i = 0; i < DIRECTIONS; i++) {
    const double angle = 2 * acos(-1) * i / DIRECTIONS, d[2] = {cos(angle), sin(angle)};
    const double back[2] = {-d[0], -d[1]};
    if (!(support(&p, d) + support(&p, back) > 0.01)) return 0;
  }
  nsdae_meet(&two, 2e-3, &met);
  assert_false(met.far);
  assert_int_equal(nsdae_pair_features(solid, 0, 1, &met, keep, &k), 0);
  for (int i = 0; i < DIRECTIONS; i++) {
    const double angle = 2 * acos(-1) * i / DIRECTIONS, d[2] = {cos(angle), sin(angle)};
    double expected = support(&p, d), spanned = support(&k.points, d);
    assert_true(spanned >= expected - 2 * slack && spanned <= expected + beside);
  }
  assert_true(k.points.count <= 12); /* at most eight corners of p, four of them of both boxes */
  return 1;
}

static void test_flush(void **state)
{
  int met = 0;
  (void)state;
  for (int i = 0; i < POSES; i++) {
    scene s;
    draw(&s);
    place(&s);
    met += compare(&s);
    nsdae_bodies_destroy(&s.b);
  }
  assert_true(met > POSES / 2);
}

int main(void)
{
  const struct CMUnitTest tests[] = {cmocka_unit_test(test_flush)};
  return cmocka_run_group_tests(tests, NULL, NULL);
}
