/* Joints by what they mean, read off the poses by formulas of this file: what each keeps, and that
 * the rest moves; and driven ones, of each kind that has one motion, between two bodies that move
 * in space themselves, follow f(t) to the integrator's tolerance. */
#include "check.h"

#include <nsdae/nsdae.h>

#include "support/random.h"

enum { NQ_MAX = 14, NV_MAX = 12 };

static const double amplitude = 0.2, rate = 3, ratio = -1.5;

/* 1 - cos: from rest, so that the start keeps the constraints. user: f(0). */
static int drive(double t, double f[3], void *user)
{
  f[0] = *(double *)user + amplitude * (1 - cos(rate * t));
  f[1] = amplitude * rate * sin(rate * t);
  f[2] = amplitude * rate * rate * cos(rate * t);
  return 0;
}

/* R s of a body with coordinates q, by Rodrigues' formula of its quaternion. */
static void turned(int d, const double *q, const double *s, double *x)
{
  if (d == 2) {
    x[0] = cos(q[2]) * s[0] - sin(q[2]) * s[1];
    x[1] = sin(q[2]) * s[0] + cos(q[2]) * s[1];
    x[2] = 0;
    return;
  }
  const double *p = q + 3;
  double u[3], length = p[0] * p[0] + p[1] * p[1] + p[2] * p[2] + p[3] * p[3];
  for (int i = 0; i < 3; i++) {
    int j = (i + 1) % 3, k = (i + 2) % 3;
    u[i] = p[1 + j] * s[k] - p[1 + k] * s[j];
  }
  for (int i = 0; i < 3; i++) {
    int j = (i + 1) % 3, k = (i + 2) % 3;
    x[i] = s[i] + 2 * (p[0] * u[i] + p[1 + j] * u[k] - p[1 + k] * u[j]) / length;
  }
}

/* The way between the bodies' centres along an axis of body 0; both are at the origin at first but
 * for DISTANCE. */
static double way(int d, const double *q, const double *axis)
{
  double a[3], sum = 0;
  turned(d, q, axis, a);
  const double *other = q + (d == 2 ? 3 : 7);
  for (int i = 0; i < d; i++) sum += a[i] * (other[i] - q[i]);
  return sum;
}

/* The angle of body 1's x axis against that of body 0, about z of body 0. */
static double angle_about_z(const double *q)
{
  const double x[3] = {1, 0, 0}, y[3] = {0, 1, 0};
  double x0[3], y0[3], x1[3], along = 0, across = 0;
  turned(3, q, x, x0);
  turned(3, q, y, y0);
  turned(3, q + 7, x, x1);
  for (int i = 0; i < 3; i++) {
    along += x1[i] * x0[i];
    across += x1[i] * y0[i];
  }
  return atan2(across, along);
}

static double motion(int d, int kind, const double *q)
{
  const double x[3] = {1, 0, 0}, z[3] = {0, 0, 1};
  double square = 0;
  switch (kind) {
  case NSDAE_JOINT_REVOLUTE:
    return d == 2 ? q[5] - q[2] : angle_about_z(q);
  case NSDAE_JOINT_UNIVERSAL:
    return angle_about_z(q);
  case NSDAE_JOINT_DISTANCE:
    for (int i = 0; i < d; i++) square += pow(q[(d == 2 ? 3 : 7) + i] - q[i], 2);
    return sqrt(square);
  case NSDAE_JOINT_GEAR:
    return q[5] - ratio * q[2];
  default:
    return way(d, q, d == 2 ? x : z);
  }
}

static void follow(int d, int kind, int method, double dt, double tol)
{
  double from = kind == NSDAE_JOINT_DISTANCE ? 0.5 : 0, q0[NQ_MAX], v0[NV_MAX];
  nsdae_bodies *b;
  nsdae_system *system;
  nsdae_sim *sim;
  nsdae_record r;
  nsdae_sim_options options;
  assert_int_equal(nsdae_bodies_create(d, &b, NULL), NSDAE_OK);
  nsdae_bodies_set_gravity(b, (const double[]){0.3, -1, 0});
  for (int i = 0; i < 2; i++)
    nsdae_bodies_add(
        b, &(nsdae_rigid_body){.mass = 1 + i,
                               .inertia = {0.8, 0.9, 0.6 + i},
                               .position = {i * from},
                               .spin = {0, 0, kind == NSDAE_JOINT_GEAR && i ? ratio * 0.4 : 0.4}});
  nsdae_bodies_add_joint(b, &(nsdae_joint){.kind = kind,
                                           .body = {0, 1},
                                           .end = {from},
                                           .axis = {d == 2, 0, d == 3},
                                           .cross = {d == 3},
                                           .ratio = ratio,
                                           .drive = drive,
                                           .user = &from});
  int status = nsdae_bodies_system(b, &system);
  if (status < 0) print_error("%s\n", nsdae_bodies_error(b)->text);
  assert_true(status >= 0);
  nsdae_bodies_get_start(b, q0, v0);
  nsdae_sim_options_default(&options);
  options.method = method;
  options.dt = dt;
  options.rtol = 1e-10;
  options.atol = 1e-12;
  status = nsdae_sim_create(system, &options, &sim, NULL);
  if (status != NSDAE_E_UNSUPPORTED) { /* event needs SUNDIALS */
    double f[3];
    int nq = d == 2 ? 3 : 7;
    assert_int_equal(status, NSDAE_OK);
    assert_int_equal(nsdae_sim_init(sim, 0, q0, v0), NSDAE_OK);
    status = nsdae_sim_run(sim, 1);
    if (status < 0) print_error("%s\n", nsdae_sim_error(sim)->text);
    assert_true(status >= 0);
    nsdae_sim_get_record(sim, &r);
    drive(r.time, f, &from);
    assert_near(motion(d, kind, r.q), f[0], tol);
    /* the common centre falls freely: the drive works between the bodies alone */
    assert_near((r.q[1] + 2 * r.q[nq + 1]) / 3, -0.5 * r.time * r.time, tol);
    nsdae_sim_destroy(&sim);
  }
  nsdae_system_destroy(&system);
  nsdae_bodies_destroy(&b);
}

static const struct {
  int d, kind;
} cases[] = {{2, NSDAE_JOINT_REVOLUTE},  {2, NSDAE_JOINT_PRISMATIC}, {2, NSDAE_JOINT_DISTANCE},
             {2, NSDAE_JOINT_SLOT},      {2, NSDAE_JOINT_GEAR},      {3, NSDAE_JOINT_REVOLUTE},
             {3, NSDAE_JOINT_PRISMATIC}, {3, NSDAE_JOINT_DISTANCE},  {3, NSDAE_JOINT_CYLINDRICAL},
             {3, NSDAE_JOINT_UNIVERSAL}, {3, NSDAE_JOINT_SCREW}};

static void test_follow(void **state)
{
  (void)state;
  for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
    follow(cases[i].d, cases[i].kind, NSDAE_METHOD_EVENT, 0.05, 1e-8);
    follow(cases[i].d, cases[i].kind, NSDAE_METHOD_IMPLICIT, 1e-3, 1e-6); /* (rate dt)^2 / 9 */
  }
}

/* ---- what each keeps */

static uint64_t seed = 3;

static double uniform(double low, double high)
{
  return random_between(&seed, low, high);
}

static void draw(int d, double size, double *x)
{
  for (int i = 0; i < 3; i++) x[i] = i < d ? uniform(-size, size) : 0;
}

static double dot(const double *a, const double *b)
{
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

/* x in space, in the frame of a body with coordinates q: by its axes. */
static void own(int d, const double *q, const double *x, double *s)
{
  for (int i = 0; i < 3; i++) {
    double axis[3] = {i == 0, i == 1, i == 2}, there[3];
    turned(d, q, axis, there);
    s[i] = d == 2 && i == 2 ? x[2] : dot(x, there);
  }
}

enum {
  POINT = 1, /* the joint's points on both bodies are one */
  LINE = 2,  /* that of body 1 is on the axis of body 0 */
  AXIS = 4,  /* the axis is one of both */
  TURN = 8,  /* they do not turn against each other */
  LENGTH = 16,
  RATIO = 32,
  SQUARE = 64 /* axis of body 0 and cross of body 1 are at right angles */
};

static const struct {
  int d, kind, keeps, rows;
} meaning[] = {{2, NSDAE_JOINT_REVOLUTE, POINT, 2},
               {2, NSDAE_JOINT_PRISMATIC, LINE | TURN, 2},
               {2, NSDAE_JOINT_WELD, POINT | TURN, 3},
               {2, NSDAE_JOINT_DISTANCE, LENGTH, 1},
               {2, NSDAE_JOINT_SLOT, LINE, 1},
               {2, NSDAE_JOINT_GEAR, RATIO, 1},
               {3, NSDAE_JOINT_SPHERICAL, POINT, 3},
               {3, NSDAE_JOINT_REVOLUTE, POINT | AXIS, 5},
               {3, NSDAE_JOINT_PRISMATIC, LINE | TURN, 5},
               {3, NSDAE_JOINT_CYLINDRICAL, LINE | AXIS, 4},
               {3, NSDAE_JOINT_SCREW, LINE | AXIS, 5},
               {3, NSDAE_JOINT_UNIVERSAL, POINT | SQUARE, 4},
               {3, NSDAE_JOINT_WELD, POINT | TURN, 6},
               {3, NSDAE_JOINT_DISTANCE, LENGTH, 1}};

/* A joint as it was said, in the frames of its bodies. */
typedef struct told {
  int d;
  double point[2][3], end[3], axis[2][3], cross[3], frame[2][3][3], length, turn;
} told;

static void tell(told *t, int d, const nsdae_joint *j, const double *q)
{
  t->d = d;
  for (int i = 0; i < 2; i++) {
    const double *at = q + (d == 2 ? 3 : 7) * i;
    double from[3] = {0, 0, 0}, to[3] = {0, 0, 0};
    for (int k = 0; k < d; k++) {
      from[k] = j->point[k] - at[k];
      to[k] = j->end[k] - at[k];
    }
    own(d, at, from, t->point[i]);
    own(d, at, j->axis, t->axis[i]);
    own(d, at, to, t->end);
    own(d, at, j->cross, t->cross);
    for (int k = 0; k < 3; k++) own(d, at, (double[]){k == 0, k == 1, k == 2}, t->frame[i][k]);
  }
  t->length = sqrt(pow(j->end[0] - j->point[0], 2) + pow(j->end[1] - j->point[1], 2) +
                   pow(j->end[2] - j->point[2], 2));
  t->turn = d == 2 ? q[5] - ratio * q[2] : 0;
}

/* How far each of what a joint can keep is from being kept: LENGTH of body 0's point and body 1's
 * end, TURN as the angle between what was parallel. */
static void measure(const told *t, const double *q, double off[7])
{
  const double *at[2] = {q, q + (t->d == 2 ? 3 : 7)};
  double x[2][3], a[2][3], b[3], end[3], c[3], way[3] = {0, 0, 0}, far[3] = {0, 0, 0};
  for (int i = 0; i < 2; i++) {
    turned(t->d, at[i], t->point[i], x[i]);
    turned(t->d, at[i], t->axis[i], a[i]);
  }
  turned(t->d, at[1], t->end, end);
  turned(t->d, at[1], t->cross, c);
  for (int k = 0; k < t->d; k++) {
    way[k] = x[1][k] + at[1][k] - x[0][k] - at[0][k];
    far[k] = end[k] + at[1][k] - x[0][k] - at[0][k];
  }
  double size = sqrt(dot(a[0], a[0])) + 1e-300, along = dot(way, a[0]) / size;
  off[0] = sqrt(dot(way, way));
  off[1] = sqrt(fabs(dot(way, way) - along * along));
  off[2] = 0;
  for (int k = 0; k < 3; k++) off[2] = fmax(off[2], fabs(a[1][k] - a[0][k]) / size);
  off[3] = 0;
  for (int k = 0; k < t->d; k++) { /* e_k of space at the start, as it rides on each body */
    turned(t->d, at[0], t->frame[0][k], a[0]);
    turned(t->d, at[1], t->frame[1][k], b);
    for (int l = 0; l < 3; l++) off[3] = fmax(off[3], fabs(b[l] - a[0][l]));
  }
  off[4] = fabs(sqrt(dot(far, far)) - t->length);
  off[5] = t->d == 2 ? fabs(q[5] - ratio * q[2] - t->turn) : 0;
  turned(t->d, at[0], t->axis[0], a[0]);
  off[6] = fabs(dot(a[0], c)) / size;
}

/* Two bodies anywhere, thrown and turning as the joint lets them, under gravity and a spring. */
static void keeps(int d, int kind, int flags, int rows)
{
  nsdae_bodies *b;
  nsdae_system *system;
  nsdae_sim *sim;
  nsdae_record r;
  nsdae_dims dims;
  nsdae_sim_options options;
  told t = {.d = d};
  double q0[NQ_MAX], v0[NV_MAX], off[7];
  nsdae_joint j = {.kind = kind, .body = {0, 1}, .ratio = ratio};
  draw(d, 0.5, j.point);
  draw(d, 0.5, j.end);
  draw(d, 1, j.axis);
  j.end[0] += 1;
  if (d == 3) { /* axis x (1, 2, 3) */
    const double other[3] = {1, 2, 3};
    for (int i = 0; i < 3; i++)
      j.cross[i] =
          j.axis[(i + 1) % 3] * other[(i + 2) % 3] - j.axis[(i + 2) % 3] * other[(i + 1) % 3];
  }
  assert_int_equal(nsdae_bodies_create(d, &b, NULL), NSDAE_OK);
  nsdae_bodies_set_gravity(b, (const double[]){0.3, -2, 0});
  for (int i = 0; i < 2; i++) {
    nsdae_rigid_body body = {
        .mass = 1 + i, .inertia = {0.8, 0.9, 0.6 + i}, .angle = uniform(-3, 3)};
    draw(d, 1, body.position);
    draw(d, 1, body.velocity);
    for (int k = 0; k < 4; k++) body.quaternion[k] = uniform(-1, 1);
    if (d == 2) memset(body.quaternion, 0, sizeof body.quaternion);
    if (d == 3) body.angle = 0;
    for (int k = d == 2 ? 2 : 0; k < 3; k++) body.spin[k] = uniform(-2, 2);
    nsdae_bodies_add(b, &body);
  }
  nsdae_bodies_add_spring(b, &(nsdae_spring){.body = {0, 1}, .end = {3, 1}, .stiffness = 5});
  assert_int_equal(nsdae_bodies_add_joint(b, &j), 0);
  nsdae_bodies_get_dims(b, &dims);
  assert_int_equal(dims.m, rows);
  assert_true(nsdae_bodies_system(b, &system) >= 0);
  nsdae_bodies_get_start(b, q0, v0);
  tell(&t, d, &j, q0);
  nsdae_sim_options_default(&options);
  options.dt = 1e-3;
  assert_int_equal(nsdae_sim_create(system, &options, &sim, NULL), NSDAE_OK);
  assert_int_equal(nsdae_sim_project(sim, 0, q0, v0), NSDAE_OK);
  assert_int_equal(nsdae_sim_init(sim, 0, q0, v0), NSDAE_OK);
  assert_true(nsdae_sim_run(sim, 0.5) >= 0);
  nsdae_sim_get_record(sim, &r);
  measure(&t, r.q, off);
  /* of what it keeps the drift of the scheme is seen, some 10 dt^2; all else has moved. A common
   * point is on the line, too, and with the same turn the axis is one. */
  int kept = flags | (flags & POINT ? LINE : 0) | (flags & TURN ? AXIS | SQUARE : 0);
  for (int i = 0; i < 7; i++) {
    int none = (i == 5 && d == 3) || (i == 6 && kind != NSDAE_JOINT_UNIVERSAL);
    if (none || (kept >> i & 1 && !(flags >> i & 1))) continue;
    if (i == 4 && flags & POINT) continue; /* both ends are of body 1 then */
    if (flags >> i & 1 ? off[i] > 5e-5 : off[i] < 1e-3)
      fail_msg("joint %d in %d dimensions, quality %d: off by %g", kind, d, i, off[i]);
  }
  nsdae_sim_destroy(&sim);
  nsdae_system_destroy(&system);
  nsdae_bodies_destroy(&b);
}

static void test_meaning(void **state)
{
  (void)state;
  for (int again = 0; again < 5; again += test_share())
    for (size_t i = 0; i < sizeof meaning / sizeof *meaning; i++)
      keeps(meaning[i].d, meaning[i].kind, meaning[i].keeps, meaning[i].rows);
}

/* A driven hand carries a box by friction. Each projection moves the hand alone, by the error of
 * the step: the box is shifted by O(dt^2) in all. */
static double shifted(int method, int projection, double dt)
{
  nsdae_system *system;
  nsdae_sim *sim;
  nsdae_sim_options options;
  nsdae_record r;
  nsdae_bodies *b;
  double q[14], v[12];
  assert_int_equal(nsdae_bodies_create(3, &b, NULL), NSDAE_OK);
  nsdae_bodies_set_gravity(b, (const double[]){0, 0, -9.81});
  double zero = 0;
  for (int i = 0; i < 2; i++)
    nsdae_bodies_add(
        b, &(nsdae_rigid_body){.mass = 1 + i, .inertia = {1, 1, 1}, .position = {0, 0, 0.2 * i}});
  nsdae_bodies_add_joint(b, &(nsdae_joint){.kind = NSDAE_JOINT_PRISMATIC,
                                           .body = {NSDAE_GROUND, 0},
                                           .axis = {1},
                                           .drive = drive,
                                           .user = &zero});
  const nsdae_solid box = {.shape = NSDAE_SHAPE_BOX, .length = {0.2, 0.2, 0.2}};
  int hand = nsdae_bodies_add_solid(b, 0, &box), carried = nsdae_bodies_add_solid(b, 1, &box);
  nsdae_bodies_add_contact(b, hand, carried, 2, 0, 0);
  if (nsdae_bodies_system(b, &system) < 0) fail_msg("%s", nsdae_bodies_error(b)->text);
  nsdae_bodies_get_start(b, q, v);
  nsdae_sim_options_default(&options);
  options.method = method;
  options.projection = projection;
  options.dt = dt;
  assert_int_equal(nsdae_sim_create(system, &options, &sim, NULL), NSDAE_OK);
  assert_true(nsdae_sim_init(sim, 0, q, v) >= 0);
  assert_true(nsdae_sim_run(sim, 1) >= 0);
  nsdae_sim_get_record(sim, &r);
  double off = fabs(r.q[7] - r.q[0]);
  nsdae_sim_destroy(&sim);
  nsdae_system_destroy(&system);
  nsdae_bodies_destroy(&b);
  return off;
}

static void test_carried(void **state)
{
  (void)state;
  for (int i = 0; i < 2; i++)
    for (int projection = 0; projection <= NSDAE_PROJECTION_SLOP; projection++) {
      int method = i ? NSDAE_METHOD_MOREAU : NSDAE_METHOD_IMPLICIT;
      double coarse = shifted(method, projection, 4e-3), fine = shifted(method, projection, 2e-3);
      assert_at_most(coarse, 1e-5);
      assert_at_most(fine, coarse / 3.5 + 1e-12); /* of second order: a quarter */
    }
}

int main(void)
{
  const struct CMUnitTest tests[] = {cmocka_unit_test(test_follow), cmocka_unit_test(test_meaning),
                                     cmocka_unit_test(test_carried)};
  return cmocka_run_group_tests(tests, NULL, NULL);
}
