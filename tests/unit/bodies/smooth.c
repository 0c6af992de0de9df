/* Cylinders, cones, ellipsoids and discs in space against planes, spheres and points.
 *
 * The signed distance of a point y from a convex body with the support function h is
 *
 *   max over unit vectors n of  n . y - h(n)
 *
 * inside as outside (R. T. Rockafellar, Convex analysis, 1970, section 13): no direction may give
 * more than the gap, and that of the contact gives it. A body of revolution has the support of the
 * corners of its profile. Masses and moments against sums over cells. */
#include "check.h"

#include <nsdae/nsdae.h>
#include <stdlib.h>

#include "bodies_impl.h"
#include "support/feature_touch.h"
#include "support/random.h"

static uint64_t seed = 5;

static double uniform(double low, double high)
{
  return random_between(&seed, low, high);
}

static const int smooth[4] = {NSDAE_SHAPE_CYLINDER, NSDAE_SHAPE_CONE, NSDAE_SHAPE_ELLIPSOID,
                              NSDAE_SHAPE_DISC};

/* Sizes from 0.02 to 1, some of them equal. */
static nsdae_solid random_solid(int shape)
{
  nsdae_solid s = {.shape = shape, .material = 1};
  int equal = random_below(&seed, 4);
  for (int i = 0; i < 3; i++) s.length[i] = i && equal < i ? s.length[0] : pow(50, uniform(-1, 0));
  if (shape != NSDAE_SHAPE_ELLIPSOID && shape != NSDAE_SHAPE_POINT && shape != NSDAE_SHAPE_BOX)
    s.radius = s.length[1] / 2;
  if (random_below(&seed, 2)) return s;
  for (int i = 0; i < 3; i++) s.position[i] = uniform(-0.3, 0.3);
  for (int i = 0; i < 4; i++) s.quaternion[i] = uniform(-1, 1);
  return s;
}

/* h(n), n in the frame of the solid. */
static double support(const nsdae_solid *s, const double *n)
{
  const double *l = s->length;
  double across = s->radius * hypot(n[0], n[1]), half = l[2] / 2, square = 0;
  if (s->shape == NSDAE_SHAPE_CYLINDER) return across + half * fabs(n[2]);
  if (s->shape == NSDAE_SHAPE_CONE) return fmax(across - half * n[2], half * n[2]);
  if (s->shape == NSDAE_SHAPE_DISC) return across;
  for (int i = 0; i < 3; i++) square += pow(l[i] / 2 * n[i], 2);
  return sqrt(square);
}

typedef struct couple {
  nsdae_bodies *b;
  nsdae_system *system;
  nsdae_solid solid[2];
} couple;

/* A smooth solid and another, each of a body, in any order. */
static void make_couple(couple *c, int shape, int other)
{
  int turned = random_below(&seed, 2);
  assert_int_equal(nsdae_bodies_create(3, &c->b, NULL), NSDAE_OK);
  c->solid[0] = random_solid(shape);
  c->solid[1] = random_solid(other);
  for (int i = 0; i < 2; i++) {
    nsdae_bodies_add(c->b, &(nsdae_rigid_body){.mass = 1, .inertia = {1, 1, 1}});
    nsdae_bodies_add_solid(c->b, i, &c->solid[turned ? 1 - i : i]);
  }
  assert_int_equal(nsdae_bodies_add_contact(c->b, 0, 1, 0.3, 0, 0), 0);
  assert_true(nsdae_bodies_system(c->b, &c->system) >= 0);
}

static void end_couple(couple *c)
{
  nsdae_system_destroy(&c->system);
  nsdae_bodies_destroy(&c->b);
}

/* The least gap over the contacts, the contact that has it, and the smooth solid's frame. */
static double least_gap(const couple *c, const double *q, nsdae_touch *touch, double *x, double *R)
{
  const nsdae_solid_of *s = c->b->solid.at;
  double least = INFINITY;
  nsdae_pose pose[2];
  for (int i = 0; i < 2; i++) {
    pose[i] = nsdae_pose_of(3, q + 7 * i, NULL);
    if (!nsdae_solid_is_smooth(&s[i])) continue;
    nsdae_pose_put(&pose[i], s[i].origin, x);
    for (int j = 0; j < 3; j++) nsdae_turn(pose[i].R, s[i].R + 3 * j, R + 3 * j);
  }
  for (int i = 0; i < c->b->feature.count; i++) {
    const nsdae_feature *f = nsdae_feature_at(c->b, i);
    const nsdae_pose of[2] = {pose[f->solid[0]], pose[f->solid[1]]};
    nsdae_touch now;
    if (!feature_touch(s, f, of, &now) || !(now.gap.x < least)) continue;
    least = now.gap.x;
    *touch = now;
  }
  return least;
}

static double value(const nsdae_jet3 *x, const double *n)
{
  return x->at[0].x * n[0] + x->at[1].x * n[1] + x->at[2].x * n[2];
}

/* n . y - h(n) for the point y from the centre of the solid. */
static double bound_of(const couple *c, const double *R, const double *n, const double *y)
{
  double own[3];
  nsdae_turn_back(R, n, own);
  return nsdae_dot3(n, y) - support(&c->solid[0], own);
}

/* Axes, any directions, and near the normal n. */
static void direction(int i, const double *R, const double *n, double *d)
{
  double far = i % 4 == 0 ? 10 : pow(10, -i % 4);
  if (i < 6) {
    for (int j = 0; j < 3; j++) d[j] = (i % 2 ? -1 : 1) * R[3 * (i / 2) + j];
    return;
  }
  for (int j = 0; j < 3; j++) d[j] = n[j] + far * uniform(-1, 1);
  double length = sqrt(nsdae_dot3(d, d));
  for (int j = 0; j < 3; j++) d[j] /= length;
}

/* One pose. y is the point of the other, rounded by its radius, or of a plane that of the contact.
 */
static void compare(const couple *c, const double *q)
{
  const nsdae_solid_of *s = c->b->solid.at;
  const nsdae_solid *other = &c->solid[1];
  nsdae_touch touch = {.gap = {0, 0, 0}};
  double x[3] = {0}, R[9] = {0}, n[3], y[3], tol = 1e-13;
  double gap = least_gap(c, q, &touch, x, R);
  int plane = other->shape == NSDAE_SHAPE_PLANE;
  /* n is from the base: from the plane, or from the smooth solid */
  for (int i = 0; i < 3; i++) n[i] = touch.normal.at[i].x;
  assert_near(nsdae_dot3(n, n), 1, tol);
  for (int i = 0; i < 3; i++)
    assert_near(touch.at[1].at[i].x - touch.at[0].at[i].x, gap * n[i], tol);
  for (int i = 0; i < 3; i++)
    y[i] = plane ? touch.at[0].at[i].x - x[i] : touch.at[1].at[i].x + other->radius * n[i] - x[i];
  if (plane) {
    int of = s[1].shape == NSDAE_SHAPE_PLANE;
    nsdae_pose pose = nsdae_pose_of(3, q + 7 * of, NULL);
    double up[3], origin[3];
    nsdae_turn(pose.R, s[of].R + 6, up);
    nsdae_pose_put(&pose, s[of].origin, origin);
    for (int i = 0; i < 3; i++) assert_near(n[i], up[i], tol);
    assert_near(value(&touch.at[0], up), nsdae_dot3(origin, up), tol);
    for (int i = 0; i < 3; i++) n[i] = -n[i];
    /* of a rim that is flat up to a sine of 1e-10 any point is taken */
    nsdae_turn_back(R, n, up);
    if (hypot(up[0], up[1]) < 1e-10) tol += 2e-10 * c->solid[0].radius;
    assert_near(bound_of(c, R, n, y), gap, tol);
    return;
  }
  assert_near(bound_of(c, R, n, y), gap + other->radius, tol);
  for (int i = 0; i < 26; i++) {
    double d[3];
    direction(i, R, n, d);
    if (bound_of(c, R, d, y) > gap + other->radius + tol)
      fail_msg("a %s and a %s: gap %.17g, but %.17g along (%g, %g, %g)",
               nsdae_solid_name(c->solid[0].shape), nsdae_solid_name(other->shape), gap,
               bound_of(c, R, d, y) - other->radius, d[0], d[1], d[2]);
  }
}

/* Anywhere near; one time in four the frames are parallel, or at a quarter turn to each other, and
 * one is on an axis, a plane of symmetry or at the centre of the other, up to 1e-16 .. 1 or not. */
static void random_pose(double *q)
{
  int parallel = random_below(&seed, 4) == 0, zero = random_below(&seed, 8);
  for (int i = 0; i < 14; i++) q[i] = i % 7 < 3 ? uniform(-0.7, 0.7) : uniform(-1, 1);
  if (!parallel) return;
  for (int i = 0; i < 14; i++)
    if (i % 7 > 2) q[i] = i % 7 == 3 || (zero % 2 && i == 11);
  for (int i = 0; i < 3; i++) q[i] = zero >> i & 1 ? q[7 + i] : q[i];
  double off = random_below(&seed, 2) ? pow(10, uniform(-16, 0)) : 0;
  for (int i = 0; i < 14; i++) q[i] += off * uniform(-1, 1);
}

static const int others[3] = {NSDAE_SHAPE_PLANE, NSDAE_SHAPE_SPHERE, NSDAE_SHAPE_POINT};

static void test_gaps(void **state)
{
  (void)state;
  for (int i = 0; i < 4; i++)
    for (int j = 0; j < (smooth[i] == NSDAE_SHAPE_DISC ? 2 : 3); j++)
      for (int k = 0; k < 100; k += test_share()) { /* 1e5 poses of each pair */
        couple c;
        double q[14];
        make_couple(&c, smooth[i], others[j]);
        for (int pose = 0; pose < 1000; pose++) {
          random_pose(q);
          compare(&c, q);
        }
        end_couple(&c);
      }
}

/* How near the pose is to one where the gap has no derivatives, or too large ones for differences:
 * of a plane the tilt; of a place its distance from the planes between the parts of the surface,
 * that of a rim from it, and of what is in an ellipsoid that of the nearest centre of curvature. At
 * a normal with n_z = 0.95 the tangents turn over. */
static double sharpness(const couple *c, const double *q)
{
  const nsdae_solid *s = &c->solid[0];
  const double *l = s->length;
  nsdae_touch touch = {.gap = {0, 0, 0}};
  double x[3] = {0}, R[9] = {0}, y[3], n[3], place[3], depth = -least_gap(c, q, &touch, x, R);
  int plane = c->solid[1].shape == NSDAE_SHAPE_PLANE, disc = s->shape == NSDAE_SHAPE_DISC;
  for (int i = 0; i < 3; i++) n[i] = touch.normal.at[i].x;
  for (int i = 0; i < 3; i++) y[i] = touch.at[1].at[i].x + c->solid[1].radius * n[i] - x[i];
  nsdae_turn_back(R, plane ? n : y, place);
  double across = hypot(place[0], place[1]);
  if (fabs(fabs(n[2]) - 0.95) < 0.02) return 0;
  if (s->shape == NSDAE_SHAPE_ELLIPSOID) {
    double least = fmin(fmin(l[0], l[1]), l[2]), most = fmax(fmax(l[0], l[1]), l[2]);
    /* half of it, as the curvature changes in so small a distance too */
    return plane ? least : (least * least / (2 * most) - (depth - c->solid[1].radius)) / 2;
  }
  if (plane) return fmin(across, fabs(across - 0.1)); /* points of the rim come and go */
  double h = disc ? 0 : l[2] / 2, r = s->radius, i = s->shape == NSDAE_SHAPE_CONE ? r : 0;
  double side = hypot(2 * h, i), u = disc ? 0 : -i / side, v = disc ? 1 : 2 * h / side;
  double beside = across - r, up = place[2] + h, along = beside * u + up * v;
  double apart = beside * v - up * u, beyond = fabs(place[2]) - h, least = fmin(across, INFINITY);
  if (i > 0) beyond = -up;
  const double planes[] = {beside,       beyond,         along,
                           along - side, apart - beyond, hypot(beside, beyond)};
  for (int k = 0; k < 6; k++) least = fmin(least, fabs(planes[k]));
  return least;
}

/* By differences, where the gap is smooth within 0.1 m. */
static void test_derivatives(void **state)
{
  int checked = 0;
  (void)state;
  for (int k = 0; k < 4000; k += test_share()) {
    int shape = smooth[k % 4], other = others[k / 4 % (shape == NSDAE_SHAPE_DISC ? 2 : 3)];
    couple c;
    nsdae_check worst;
    double q[14], v[12];
    make_couple(&c, shape, other);
    random_pose(q);
    for (int i = 0; i < 12; i++) v[i] = uniform(-1, 1);
    if (sharpness(&c, q) > 0.1) {
      checked++;
      if (nsdae_system_check(c.system, 0, q, v, 1e-7, &worst) < 0)
        fail_msg("pose %d, a %s: %s", k, nsdae_solid_name(shape),
                 nsdae_system_error(c.system)->text);
    }
    end_couple(&c);
  }
  assert_true(checked > share_of(400));
}

/* ---- inertia */

static int is_inside(const nsdae_solid *s, const double *x)
{
  const double *l = s->length;
  double across = hypot(x[0], x[1]), square = 0;
  if (s->shape == NSDAE_SHAPE_CYLINDER) return across < s->radius && fabs(x[2]) < l[2] / 2;
  if (s->shape == NSDAE_SHAPE_CONE)
    return x[2] > -l[2] / 2 && across < s->radius * (0.5 - x[2] / l[2]);
  for (int i = 0; i < 3; i++) square += pow(2 * x[i] / l[i], 2);
  return square < 1;
}

/* Sums over the middles of 120^3 cells, to 2e-3 of them: those that the surface cuts count whole or
 * not. The principal moments about the centre of mass are in the frame of the solid. */
static void test_inertia(void **state)
{
  enum { CELLS = 120 };
  (void)state;
  for (int k = 0; k < 3; k++) {
    const double density = 3, tol = 2e-3;
    nsdae_solid s = {.shape = smooth[k], .radius = 0.4, .length = {0.8, 0.8, 0.9}};
    if (s.shape == NSDAE_SHAPE_ELLIPSOID) s.radius = 0, s.length[1] = 0.6;
    nsdae_rigid_body body = {.position = {1, 2, 3}};
    double m = 0, first[3] = {0}, second[3] = {0}, x[3];
    for (int i = 0; i < CELLS * CELLS * CELLS; i++) {
      const int cell[3] = {i % CELLS, i / CELLS % CELLS, i / CELLS / CELLS};
      for (int j = 0; j < 3; j++) x[j] = s.length[j] * ((cell[j] + 0.5) / CELLS - 0.5);
      if (!is_inside(&s, x)) continue;
      m++;
      for (int j = 0; j < 3; j++) first[j] += x[j], second[j] += x[j] * x[j];
    }
    double volume = s.length[0] * s.length[1] * s.length[2] / pow(CELLS, 3);
    assert_int_equal(nsdae_body_from_solids(1, &s, &density, &body, NULL), NSDAE_OK);
    assert_near(body.mass, density * m * volume, tol * body.mass);
    for (int j = 0; j < 3; j++) {
      double centre = first[j] / m;
      assert_near(body.position[j] - j - 1, centre, tol);
      assert_near(s.position[j], -(body.position[j] - j - 1), 1e-15);
      second[j] = density * volume * (second[j] - m * centre * centre);
    }
    for (int j = 0; j < 3; j++) {
      double moment = second[(j + 1) % 3] + second[(j + 2) % 3];
      assert_near(body.inertia[j], moment, 2 * tol * moment);
      assert_near(body.product[j], 0, 1e-16);
    }
  }
  /* a disc of the mass m has m r^2 / 4 about a diameter, also turned and with another solid */
  const double density[2] = {2, 1}, mass = 2 * nsdae_pi * 0.09;
  nsdae_solid coin[2] = {{.shape = NSDAE_SHAPE_DISC, .radius = 0.3, .quaternion = {1, 1}},
                         {.shape = NSDAE_SHAPE_SPHERE, .radius = 1e-4}};
  nsdae_rigid_body body = {.mass = 0};
  assert_int_equal(nsdae_body_from_solids(2, coin, density, &body, NULL), NSDAE_OK);
  const double moment[3] = {mass * 0.0225, mass * 0.045, mass * 0.0225};
  for (int j = 0; j < 3; j++) assert_near(body.inertia[j], moment[j], 1e-10 * mass);
}

/* A disc and a point by hand; by material they have no contacts. */
static void test_refused(void **state)
{
  nsdae_bodies *b;
  const nsdae_solid disc = random_solid(NSDAE_SHAPE_DISC), point = random_solid(NSDAE_SHAPE_POINT);
  (void)state;
  assert_int_equal(nsdae_bodies_create(3, &b, NULL), NSDAE_OK);
  nsdae_bodies_add(b, &(nsdae_rigid_body){.mass = 1, .inertia = {1, 1, 1}});
  nsdae_bodies_add_solid(b, 0, &disc);
  nsdae_bodies_add_solid(b, NSDAE_GROUND, &point);
  assert_int_equal(nsdae_bodies_add_contact(b, 0, 1, 0, 0, 0), NSDAE_E_ARGUMENT);
  assert_non_null(strstr(nsdae_bodies_error(b)->text, "disc and point have no inside"));
  nsdae_bodies_destroy(&b);
}

int main(void)
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(test_gaps), cmocka_unit_test(test_derivatives),
      cmocka_unit_test(test_inertia), cmocka_unit_test(test_refused)};
  return cmocka_run_group_tests(tests, NULL, NULL);
}
