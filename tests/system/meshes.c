/* Meshes and height fields that stand still, by time stepping: a flat floor of triangles is a plane
 * to rounding, nothing catches at its edges; solids rest on stairs and in valleys. */
#include "check.h"

#include <stdlib.h>
#include <string.h>

#include <nsdae/nsdae.h>

#include "random.h"

static const double gravity = 9.81;

/* ---- surfaces */

enum { SIDE = 12 };

typedef struct surface {
  double point[3 * (SIDE + 1) * (SIDE + 1)];
  int triangle[6 * SIDE * SIDE];
  nsdae_solid solid;
} surface;

/* A grid over x, y = -half .. half whose inner points are moved at random in the plane, with
 * heights by f or 0. */
static void make_surface(surface *s, double half, double move, double (*f)(double, double))
{
  uint64_t seed = 3;
  int t = 0;
  for (int i = 0; i <= SIDE; i++)
    for (int j = 0; j <= SIDE; j++) {
      double *x = s->point + 3 * (i * (SIDE + 1) + j), width = 2 * half / SIDE;
      int inner = i > 0 && j > 0 && i < SIDE && j < SIDE;
      x[0] = -half + width * (i + (inner ? move * random_between(&seed, -1, 1) : 0));
      x[1] = -half + width * (j + (inner ? move * random_between(&seed, -1, 1) : 0));
      x[2] = f ? f(x[0], x[1]) : 0;
      if (i == SIDE || j == SIDE) continue;
      int a = i * (SIDE + 1) + j, b = a + SIDE + 1, odd = (i + j) % 2;
      const int two[6] = {a, b, odd ? b + 1 : a + 1, odd ? a : b, b + 1, a + 1};
      memcpy(s->triangle + 3 * t, two, sizeof two);
      t += 2;
    }
  s->solid = (nsdae_solid){.shape = NSDAE_SHAPE_MESH,
                           .points = (SIDE + 1) * (SIDE + 1),
                           .point = s->point,
                           .triangles = t,
                           .triangle = s->triangle,
                           .length = {0, 0, 0.1}};
}

/* ---- one body */

typedef struct scene {
  nsdae_bodies *b;
  nsdae_system *system;
  nsdae_sim *sim;
} scene;

static scene start(const nsdae_solid *ground, int grounds, const nsdae_solid *solid,
                   const nsdae_rigid_body *body, double mu, const nsdae_sim_options *o)
{
  scene s;
  nsdae_error error;
  double q[7], v[6];
  assert_int_equal(nsdae_bodies_create(3, &s.b, NULL), NSDAE_OK);
  nsdae_bodies_set_gravity(s.b, (double[3]){0, 0, -gravity});
  nsdae_bodies_set_pair(s.b, 0, 1, mu, 0, 0);
  for (int i = 0; i < grounds; i++) nsdae_bodies_add_solid(s.b, NSDAE_GROUND, &ground[i]);
  nsdae_bodies_add_solid(s.b, nsdae_bodies_add(s.b, body), solid);
  if (nsdae_bodies_system(s.b, &s.system) < 0) fail_msg("%s", nsdae_bodies_error(s.b)->text);
  nsdae_bodies_get_start(s.b, q, v);
  if (nsdae_sim_create(s.system, o, &s.sim, &error) < 0) fail_msg("%s", error.text);
  if (nsdae_sim_init(s.sim, 0, q, v) < 0) fail_msg("%s", nsdae_sim_error(s.sim)->text);
  return s;
}

static void step(scene *s, nsdae_record *r)
{
  if (nsdae_sim_step(s->sim) < 0) fail_msg("%s", nsdae_sim_error(s->sim)->text);
  nsdae_sim_get_record(s->sim, r);
}

static void end(scene *s)
{
  nsdae_sim_destroy(&s->sim);
  nsdae_system_destroy(&s->system);
  nsdae_bodies_destroy(&s->b);
}

static nsdae_rigid_body body_of(const nsdae_solid *solid)
{
  const double density = 700;
  nsdae_rigid_body body = {.mass = 0};
  nsdae_solid own = *solid;
  assert_int_equal(nsdae_body_from_solids(1, &own, &density, &body, NULL), NSDAE_OK);
  return body;
}

/* ---- flat */

static void slide(const nsdae_solid *solid, double height, int method, const char *name)
{
  enum { STEPS = 600 };
  surface floor;
  nsdae_solid plane = {.shape = NSDAE_SHAPE_PLANE};
  nsdae_sim_options o;
  nsdae_record r, flat;
  nsdae_rigid_body body = body_of(solid);
  double most = 0;
  nsdae_sim_options_default(&o);
  o.start_tol = 1; /* some begin deep in the ground */
  o.contact_tol = 1e-10;
  o.method = method;
  o.dt = 1e-3;
  body.position[0] = -0.7;
  body.position[1] = -0.6;
  body.position[2] = height;
  body.velocity[0] = 1.5;
  body.velocity[1] = 1.1;
  make_surface(&floor, 1, 0.3, NULL);
  scene mesh = start(&floor.solid, 1, solid, &body, 0.1, &o);
  scene same = start(&plane, 1, solid, &body, 0.1, &o);
  for (int i = 0; i < STEPS; i++) {
    step(&mesh, &r);
    step(&same, &flat);
    assert_int_equal(r.contacts.count, flat.contacts.count);
    for (int j = 0; j < 7; j++) most = fmax(most, fabs(r.q[j] - flat.q[j]));
    for (int j = 0; j < 6; j++) most = fmax(most, fabs(r.v[j] - flat.v[j]));
  }
  print_message("%s, method %d: x = %.3f, differs from that on a plane by %.1e\n", name, method,
                r.q[0], most);
  /* of a curved one rounding differs, so each of the steps may by the tolerance */
  assert_true(most < (solid->shape >= NSDAE_SHAPE_CYLINDER ? STEPS * o.contact_tol : 1e-12));
  assert_true(r.q[0] > -0.3);
  end(&mesh);
  end(&same);
}

static void test_flat(void **state)
{
  static const int methods[] = {NSDAE_METHOD_MOREAU, NSDAE_METHOD_IMPLICIT,
                                NSDAE_METHOD_IMPLICIT_PRINTED, NSDAE_METHOD_PENALTY,
                                NSDAE_METHOD_EVENT};
  static const nsdae_solid solids[] = {
      {.shape = NSDAE_SHAPE_BOX, .length = {0.2, 0.15, 0.1}, .material = 1},
      {.shape = NSDAE_SHAPE_SPHERE, .radius = 0.07, .material = 1},
      {.shape = NSDAE_SHAPE_CAPSULE,
       .radius = 0.05,
       .length = {0, 0, 0.2},
       .quaternion = {1, 1, 0, 0},
       .material = 1}};
  static const nsdae_solid curved[] = {
      {.shape = NSDAE_SHAPE_CYLINDER, .radius = 0.06, .length = {0, 0, 0.1}, .material = 1},
      {.shape = NSDAE_SHAPE_CONE, .radius = 0.06, .length = {0, 0, 0.12}, .material = 1},
      {.shape = NSDAE_SHAPE_ELLIPSOID, .length = {0.2, 0.15, 0.1}, .material = 1},
      {.shape = NSDAE_SHAPE_DISC, .radius = 0.1, .quaternion = {1, 1, 0, 0}, .material = 1}};
  static const double height[] = {0.05, 0.07, 0.05, 0.05, 0.03, 0.05, 0.1};
  (void)state;
  for (int i = 0; i < 5; i++)
    for (int j = 0; j < (methods[i] <= NSDAE_METHOD_MOREAU ? 7 : 3); j++) {
      /* the quick form: a curved one by one method, another by every other one */
      if (test_share() > 1 && (j > 2 ? j % 3 != i : (i + j) % 2)) continue;
      slide(
          j < 3 ? &solids[j] : &curved[j - 3], height[j], methods[i],
          (const char *[]){"box", "ball", "capsule", "cylinder", "cone", "ellipsoid", "wheel"}[j]);
    }
}

/* ---- rest and roll */

static double ridges(double x, double y)
{
  return 0.02 * sin(9 * x) * cos(7 * y) + 0.2 * (x * x + y * y);
}

/* Two steps of 0.1 down to the side of -x, with their ends: edges, corners, valleys. */
static const double step_point[] = {-0.8, -0.5, 0, 0, -0.5, 0, 0, -0.5, 0.1, 0.8, -0.5, 0.1,
                                    -0.8, 0.5,  0, 0, 0.5,  0, 0, 0.5,  0.1, 0.8, 0.5,  0.1};
static const int step_triangle[] = {0, 1, 5, 0, 5, 4, 1, 2, 6, 1, 6, 5, 2, 3, 7, 2, 7, 6};
static const nsdae_solid stairs = {.shape = NSDAE_SHAPE_MESH,
                                   .points = 8,
                                   .point = step_point,
                                   .triangles = 6,
                                   .triangle = step_triangle,
                                   .length = {0, 0, 0.08}};

/* A body that falls on a surface comes to rest on it: no energy is gained, no contact is deep. */
static void settle(const nsdae_solid *ground, const nsdae_solid *solid, const double *at,
                   const double *turn, int method, const char *name)
{
  nsdae_sim_options o;
  nsdae_record r;
  nsdae_rigid_body body = {.mass = 0};
  double first, depth = 0, deepest = 0;
  nsdae_sim_options_default(&o);
  o.start_tol = 1; /* some begin deep in the ground */
  o.method = method;
  o.dt = 1e-3;
  o.projection = NSDAE_PROJECTION_SLOP;
  memcpy(body.position, at, sizeof body.position);
  memcpy(body.quaternion, turn, sizeof body.quaternion);
  nsdae_solid own = *solid; /* about its centre of mass */
  const double density = 700;
  assert_int_equal(nsdae_body_from_solids(1, &own, &density, &body, NULL), NSDAE_OK);
  scene s = start(ground, 1, &own, &body, 0.6, &o);
  nsdae_sim_get_record(s.sim, &r);
  first = r.kinetic + r.potential;
  for (int i = 0; i < 3000; i++) {
    step(&s, &r);
    deepest = fmax(deepest, r.penetration);
    assert_true(r.kinetic + r.potential - r.projection_energy <= first * (1 + 1e-12) + 1e-12);
    if (i > 2500) depth = fmax(depth, r.penetration);
  }
  print_message(
      "%s, method %d: at (%.3f, %.3f, %.3f), kinetic energy %.1e J, depth %.1e m, at most "
      "%.1e m\n",
      name, method, r.q[0], r.q[1], r.q[2], r.kinetic, depth, deepest);
  assert_true(r.q[2] > -0.01);
  assert_true(r.kinetic < 1e-10);
  assert_true(depth < 6e-5);
  end(&s);
}

static void test_rest(void **state)
{
  static const nsdae_solid box = {
      .shape = NSDAE_SHAPE_BOX, .length = {0.3, 0.2, 0.12}, .material = 1};
  static const nsdae_solid can = {
      .shape = NSDAE_SHAPE_CYLINDER, .radius = 0.08, .length = {0, 0, 0.1}, .material = 1};
  static const nsdae_solid cone = {
      .shape = NSDAE_SHAPE_CONE, .radius = 0.1, .length = {0, 0, 0.15}, .material = 1};
  static const double corner[] = {0, 0, 0, 0.3, 0, 0, 0, 0.2, 0, 0, 0, 0.2, 0.2, 0.1, 0.2};
  static const nsdae_solid wedge = {
      .shape = NSDAE_SHAPE_POLYHEDRON, .points = 5, .point = corner, .material = 1};
  static const double flat[4] = {1}, tilted[4] = {0.9, 0.2, -0.3, 0.15}, lying[4] = {1, 0, 1, 0};
  static const int methods[] = {NSDAE_METHOD_MOREAU, NSDAE_METHOD_IMPLICIT};
  surface bowl;
  (void)state;
  make_surface(&bowl, 1, 0.2, ridges);
  const struct {
    const nsdae_solid *ground, *solid;
    double at[3];
    const double *turn;
    const char *name;
  } scenes[] = {
      {&stairs, &box, {0.05, 0, 0.2}, flat, "box over the edge"},
      {&stairs, &box, {-0.16, 0, 0.1}, flat, "box in the corner"},
      {&stairs, &box, {-0.05, 0, 0.4}, tilted, "box tumbles"},
      {&bowl.solid, &box, {0.1, 0.2, 0.3}, tilted, "box in a rough bowl"},
      {&stairs, &can, {0.03, 0, 0.2}, flat, "cylinder over the edge"},
      {&stairs, &cone, {0.05, 0, 0.4}, tilted, "cone tumbles"},
      {&stairs, &can, {0.02, 0, 0.181}, lying, "cylinder lies across the edge"},
      {&bowl.solid, &wedge, {-0.1, 0, 0.3}, flat, "wedge in a rough bowl"},
  };
  for (int i = 0; i < 8; i++)
    for (int m = 0; m < 2; m++) {
      if (test_share() > 1 && (i + i / 4) % 2 != m) continue; /* each by one method */
      settle(scenes[i].ground, scenes[i].solid, scenes[i].at, scenes[i].turn, methods[m],
             scenes[i].name);
    }
}

/* ---- a ball slides down a groove of cycloid form without friction
 *
 * Its centre is on the cycloid x = a (p - sin p), z = -a (1 - cos p) + const; from rest at any p it
 * takes pi sqrt(a / g) to the lowest point (C. Huygens, Horologium oscillatorium, 1673). The ground
 * is a height field below the parallel curve at distance r. At each chord of angle delta to the
 * next the ball loses (v delta)^2 / 2 of its energy: n chords lose O(1 / n). Moreau's scheme is of
 * order 1 in the step: with grid and step halved the error is at most half. */
static double time_of_descent(int cells, double dt)
{
  enum { CELLS_MAX = 1280 };
  const double a = 0.5, r = 0.05, p0 = 1.6, pi = acos(-1), half = a * pi;
  static double height[2 * (CELLS_MAX + 1)];
  for (int i = 0; i <= cells; i++) { /* of the parallel curve, by bisection in the parameter */
    double x = (2.0 * i / cells - 1) * half * 0.9, low = 0, high = 2 * pi;
    for (int k = 0; k < 60; k++) {
      double p = (low + high) / 2, at = a * (p - pi - sin(p)) - r * cos(p / 2);
      *(at < x ? &low : &high) = p;
    }
    height[i] = height[cells + 1 + i] = a * (1 + cos(low)) - r * sin(low / 2);
  }
  const nsdae_solid groove = {.shape = NSDAE_SHAPE_HEIGHT_FIELD,
                              .point = height,
                              .grid = {cells + 1, 2},
                              .length = {1.8 * half, 1, 0.1}};
  const nsdae_solid ball = {.shape = NSDAE_SHAPE_SPHERE, .radius = r, .material = 1};
  nsdae_rigid_body body = body_of(&ball);
  nsdae_sim_options o;
  nsdae_record record;
  nsdae_sim_options_default(&o);
  o.method = NSDAE_METHOD_MOREAU;
  o.dt = dt;
  body.position[0] = a * (p0 - pi - sin(p0));
  body.position[2] = a * (1 + cos(p0));
  scene s = start(&groove, 1, &ball, &body, 0, &o);
  double x = body.position[0], before = x, t = 0;
  while (x < 0 && t < 3) {
    step(&s, &record);
    before = x;
    x = record.q[0];
    t = record.time;
  }
  t -= dt * x / (x - before);
  end(&s);
  return t / (pi * sqrt(a / gravity)) - 1;
}

static void test_cycloid(void **state)
{
  double before = INFINITY;
  (void)state;
  for (int i = 0; i < 4; i++) {
    int cells = 80 << i;
    double dt = 8e-4 / (1 << i), error = time_of_descent(cells, dt);
    print_message("cycloid of %d cells, dt = %g s: time of descent off by %.2e\n", cells, dt,
                  error);
    assert_true(error > 0 && error < before / 2);
    before = error;
  }
  assert_true(before < 3e-4);
}

int main(void)
{
  const struct CMUnitTest tests[] = {cmocka_unit_test(test_flat), cmocka_unit_test(test_rest),
                                     cmocka_unit_test(test_cycloid)};
  return cmocka_run_group_tests(tests, NULL, NULL);
}
