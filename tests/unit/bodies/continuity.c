/* Gaps through degenerate poses: edges and faces parallel, corner on corner, corner on edge, edge
 * on edge, apart and overlapping. The distance of two bodies, and the least depth of their overlap,
 * changes by no more than the farthest that a point of one moves against the other; so does the
 * least gap over a pair's contacts, on a path through each such pose. */
#include "check.h"

#include <nsdae/nsdae.h>
#include <stdlib.h>

#include "narrow_phase.h"
#include "bodies_impl.h"
#include "support/feature_touch.h"
#include "support/random.h"

static uint64_t seed = 11;

static double uniform(double low, double high)
{
  return random_between(&seed, low, high);
}

static int below(int n)
{
  return (int)uniform(0, n);
}

static const double corners[8] = {-0.5, -0.4, 0.6, -0.4, 0.6, 0.5, -0.5, 0.3};

/* A wedge, an octahedron and a tetrahedron, of right angles and of others. */
static const double polyhedra[3][18] = {
    {-0.5, -0.5, 0, 0.5, -0.5, 0, -0.5, 0.5, 0, 0.5, 0.5, 0, -0.5, 0, 0.5, 0.5, 0, 0.5},
    {0.5, 0, 0, -0.5, 0, 0, 0, 0.5, 0, 0, -0.5, 0, 0, 0, 0.5, 0, 0, -0.5},
    {0.5, 0.5, 0.5, 0.5, -0.5, -0.5, -0.5, 0.5, -0.5, -0.5, -0.5, 0.5}};

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
  if (shape == NSDAE_SHAPE_POINT || shape == NSDAE_SHAPE_POLYGON || shape == NSDAE_SHAPE_BOX ||
      shape == NSDAE_SHAPE_ELLIPSOID)
    s.radius = 0;
  if (shape != NSDAE_SHAPE_POLYHEDRON) return s;
  int which = below(3);
  s.radius = 0;
  s.points = which == 2 ? 4 : 6;
  s.point = polyhedra[which];
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
  assert_true(nsdae_bodies_system(c.bodies, &system) >= 0);
  nsdae_system_destroy(&system);
  return c;
}

/* The values without rates are those of the contact to the last bit. What asks for gaps of at most
 * this one finds it too. */
static void expect_found(const nsdae_solid_of *s, const nsdae_feature *f, const nsdae_pose *pose,
                         const nsdae_touch *touch)
{
  nsdae_meeting met;
  nsdae_closest closest;
  feature_meet(s, f, pose, touch->gap.x, &met);
  assert_false(met.far);
  assert_true(nsdae_feature_closest(f, &met, &closest));
  const nsdae_couple two = nsdae_feature_couple(f, &met);
  const nsdae_still still = nsdae_closest_still(&closest, &two);
  assert_true(still.gap == touch->gap.x);
  for (int j = 0; j < 3; j++) {
    assert_true(still.normal[j] == touch->normal.at[j].x);
    for (int i = 0; i < 2; i++) assert_true(still.at[i][j] == touch->at[i].at[j].x);
  }
}

static double least_gap(const couple *c, const double *q)
{
  const nsdae_solid_of *s = c->bodies->solid.at;
  double least = INFINITY;
  for (int i = 0; i < c->bodies->feature.count; i++) {
    const nsdae_feature *f = (const nsdae_feature *)c->bodies->feature.at + i;
    nsdae_pose pose[2];
    nsdae_touch touch;
    for (int j = 0; j < 2; j++) pose[j] = nsdae_bodies_pose(c->bodies, f->solid[j], q, NULL);
    if (!feature_touch(s, f, pose, &touch)) continue;
    expect_found(s, f, pose, &touch);
    least = fmin(least, touch.gap.x);
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
  if (below(4) == 0) q[c->nq + below(c->d)] = 0; /* in the middle: two sides are as near */
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
    for (int j = 0; j < 2; j++) arm += s[j].shape == NSDAE_SHAPE_PLANE ? 0 : s[j].size;
    double apart = 0;
    for (int j = 0; j < c->d; j++) apart += pow(q[c->nq + j] - q[j], 2);
    bound += sqrt(linear) + omega * (arm + sqrt(apart));
  }
  return bound;
}

/* Solids that are apart by less than a millionth of their sizes count as flush, so that blocks
 * which drift by rounding keep lying so: the gap changes there by that, 2e-6 m here, over the
 * cosine between the normal of an edge and the direction of a corner, of which none here is below
 * 1/2. */
static const double drift = 5e-6;

/* From -1e-2 to 1e-2 of a direction, ever finer towards the pose itself, down to 1e-15. */
static void follow_path(const couple *c, const double *q)
{
  double w[14], at[14], last = 0, before = 0;
  for (int j = 0; j < 2 * c->nq; j++) w[j] = uniform(-1, 1);
  double bound = 1.1 * speed_bound(c, q, w); /* at q, and it changes by less on the path */
  for (int k = -60; k <= 60; k++) {
    double s = k == 0 ? 0 : (k < 0 ? -1 : 1) * 1e-2 * pow(10, -13. * (60 - abs(k)) / 59);
    for (int j = 0; j < 2 * c->nq; j++) at[j] = q[j] + s * w[j];
    double gap = least_gap(c, at);
    if (k > -60 && !(fabs(gap - last) <= bound * (s - before) + drift)) {
      const nsdae_solid_of *of = c->bodies->solid.at;
      print_error("%s and %s: gap %.17g after %.17g, from %g to %g along the path\n",
                  nsdae_solid_name(of[0].shape), nsdae_solid_name(of[1].shape), gap, last, before,
                  s);
      for (int j = 0; j < 2 * c->nq; j++) print_error("q %.17g, rate %.17g\n", q[j], w[j]);
      for (int j = 0; j < 2; j++)
        print_error("half %g %g %g, radius %g\n", of[j].half[0], of[j].half[1], of[j].half[2],
                    of[j].radius);
      fail_msg("the gap jumps by %g, more than %g", fabs(gap - last), bound * (s - before) + drift);
    }
    last = gap;
    before = s;
  }
}

static void follow_pair(int d, int shape0, int shape1, int hollow0, int hollow1)
{
  int poses = getenv("NSDAE_LONG") ? 20000 : share_of(60);
  for (int k = 0; k < poses; k++) {
    nsdae_solid first = solid_of(shape0, hollow0);
    nsdae_solid second = solid_of(shape1, hollow1);
    double q[14];
    couple c = make(d, &first, &second);
    degenerate_pose(&c, q);
    follow_path(&c, q);
    nsdae_bodies_destroy(&c.bodies);
  }
}

/* Every pair of these kinds, but for the last with itself. */
static void follow_all(int d, const int *shapes, int count, int hollow)
{
  for (int i = 0; i < count; i++)
    for (int j = 0; j < count && i + j < 2 * count - 2; j++)
      follow_pair(d, shapes[i], shapes[j], hollow && i == count - 1, hollow && j == count - 1);
}

static void test_planar(void **state)
{
  const int shapes[] = {NSDAE_SHAPE_POINT, NSDAE_SHAPE_DISC, NSDAE_SHAPE_SEGMENT,
                        NSDAE_SHAPE_POLYGON, NSDAE_SHAPE_PLANE};
  const int hole[] = {NSDAE_SHAPE_POINT, NSDAE_SHAPE_DISC, NSDAE_SHAPE_SEGMENT, NSDAE_SHAPE_POLYGON,
                      NSDAE_SHAPE_DISC};
  (void)state;
  follow_all(2, shapes, 5, 0);
  follow_all(2, hole, 5, 1);
}

/* Edges nearer to parallel than what counts as flush, which meet by a corner: gone from one step of
 * this path to the next. */
static void test_remembered(void **state)
{
  const nsdae_solid box[2] = {{.shape = NSDAE_SHAPE_BOX, .length = {0.5, 1, 1}},
                              {.shape = NSDAE_SHAPE_BOX, .length = {1, 1, 1}}};
  const double half = sqrt(0.5), step[2] = {-4.95354e-06, -2.98247e-06};
  const double q[14] = {0,
                        0,
                        0,
                        half,
                        0.24135277981176784,
                        -0.27519796167983523,
                        half,
                        -1.0167451241539347,
                        -1.0055668435111833,
                        -0.30030862961741894,
                        0,
                        half,
                        0,
                        half};
  const double rate[14] = {0.51944777346465298, 0.21943597607923171,  -0.83676747823144737,
                           0.87211068901177424, 0.26121523000079661,  -0.44329922260296972,
                           0.68087758733334702, 0.44572677732150523,  -0.21719816563936267,
                           -0.5049862836575154, -0.94814615234475652, 0.46302127199668841,
                           0.59548005361388556, -0.30787537440685164};
  double gap[2];
  (void)state;
  couple c = make(3, &box[0], &box[1]);
  for (int i = 0; i < 2; i++) {
    double at[14];
    for (int j = 0; j < 14; j++) at[j] = q[j] + step[i] * rate[j];
    gap[i] = least_gap(&c, at);
  }
  assert_near(gap[1], gap[0], 4e-5); /* the farthest that a point moves from one to the other */
  nsdae_bodies_destroy(&c.bodies);
}

static void test_spatial(void **state)
{
  const int shapes[] = {NSDAE_SHAPE_POINT, NSDAE_SHAPE_SPHERE,     NSDAE_SHAPE_CAPSULE,
                        NSDAE_SHAPE_BOX,   NSDAE_SHAPE_POLYHEDRON, NSDAE_SHAPE_PLANE};
  const int smooth[] = {NSDAE_SHAPE_CYLINDER, NSDAE_SHAPE_CONE, NSDAE_SHAPE_ELLIPSOID,
                        NSDAE_SHAPE_DISC};
  const int others[] = {NSDAE_SHAPE_PLANE, NSDAE_SHAPE_SPHERE, NSDAE_SHAPE_POINT};
  (void)state;
  follow_all(3, shapes, 6, 0);
  for (int i = 0; i < 4; i++)
    for (int j = 0; j < (smooth[i] == NSDAE_SHAPE_DISC ? 2 : 3); j++)
      follow_pair(3, smooth[i], others[j], 0, 0);
}

/* ---- forces: a block that falls on another for one step of Moreau's scheme */

static const double g = 10, dt = 1e-2;

/* Velocities after the step. Without friction they are unique, whatever the forces are. */
static void fall(int d, double turn, const double *q, double *v_end)
{
  static const double square[8] = {-0.5, -0.5, 0.5, -0.5, 0.5, 0.5, -0.5, 0.5};
  const nsdae_solid block = {.shape = d == 2 ? NSDAE_SHAPE_POLYGON : NSDAE_SHAPE_BOX,
                             .length = {1, d == 3 && turn > 0 ? 3 : 1, 1},
                             .points = 4,
                             .point = square};
  const double down[3] = {0, d == 2 ? -g : 0, d == 3 ? -g : 0}, v[6] = {0};
  nsdae_bodies *b;
  nsdae_system *system;
  nsdae_sim *sim;
  nsdae_record r;
  nsdae_sim_options options;
  nsdae_sim_options_default(&options);
  options.method = NSDAE_METHOD_MOREAU;
  options.dt = dt;
  options.start_tol = 1e-2; /* it overlaps */
  assert_int_equal(nsdae_bodies_create(d, &b, NULL), NSDAE_OK);
  nsdae_bodies_set_gravity(b, down);
  nsdae_bodies_add(b, &(nsdae_rigid_body){.mass = 1, .inertia = {1, 1, 1}});
  nsdae_bodies_add_solid(b, NSDAE_GROUND, &block);
  nsdae_bodies_add_solid(b, 0, &block);
  nsdae_bodies_add_contact(b, 0, 1, 0, 0, 0);
  assert_true(nsdae_bodies_system(b, &system) >= 0);
  assert_int_equal(nsdae_sim_create(system, &options, &sim, NULL), NSDAE_OK);
  int status = nsdae_sim_init(sim, 0, q, v);
  if (status >= 0) status = nsdae_sim_step(sim);
  if (status < 0)
    print_error("%d: %g %g %g %g, %g: %s\n", d, q[0], q[1], q[2], q[3], turn,
                nsdae_sim_error(sim)->text);
  assert_true(status >= 0);
  nsdae_sim_get_record(sim, &r);
  memcpy(v_end, r.v, (d == 2 ? 3 : 6) * sizeof *v_end);
  nsdae_sim_destroy(&sim);
  nsdae_system_destroy(&system);
  nsdae_bodies_destroy(&b);
}

/* Squarely on the other, shifted by quarters of its edge, up to where it just tips, and crosswise;
 * overlapping by 1e-4, so that all that lies flush is closed also where it is turned by 1e-6. */
static void lay(int d, int number, double *turn, double *q)
{
  memset(q, 0, 7 * sizeof *q);
  *turn = 0;
  q[d - 1] = 1 - 1e-4;
  q[0] = 0.25 * (number % 5 - 2);
  if (d == 2) return;
  q[1] = 0.25 * (number / 5 % 5 - 2);
  *turn = number / 25 % 2;
  q[3] = q[6] = sqrt(0.5); /* a quarter about z: a cross of two long blocks */
}

static void test_forces(void **state)
{
  (void)state;
  for (int d = 2; d <= 3; d++)
    for (int i = 0; i < (d == 2 ? 5 : 50); i++) {
      double turn, q[7], at[7], still[6], moved[6];
      lay(d, i, &turn, q);
      fall(d, turn, q, still);
      for (int j = 0; j < 6; j++) {
        double size = pow(10, -6 - 2 * (j / 2)); /* 1e-6, 1e-8, 1e-10 */
        for (int k = 0; k < (d == 2 ? 3 : 7); k++) at[k] = q[k] + size * uniform(-1, 1);
        fall(d, turn, at, moved);
        for (int k = 0; k < (d == 2 ? 3 : 6); k++)
          assert_near(moved[k], still[k], 20 * size * g * dt);
      }
    }
}

int main(void)
{
  const struct CMUnitTest tests[] = {cmocka_unit_test(test_planar), cmocka_unit_test(test_spatial),
                                     cmocka_unit_test(test_remembered),
                                     cmocka_unit_test(test_forces)};
  return cmocka_run_group_tests(tests, NULL, NULL);
}
