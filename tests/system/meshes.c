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
  surface floor;
  nsdae_solid plane = {.shape = NSDAE_SHAPE_PLANE};
  nsdae_sim_options o;
  nsdae_record r, flat;
  nsdae_rigid_body body = body_of(solid);
  double most = 0;
  nsdae_sim_options_default(&o);
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
  for (int i = 0; i < 600; i++) {
    step(&mesh, &r);
    step(&same, &flat);
    assert_int_equal(r.contacts.count, flat.contacts.count);
    for (int j = 0; j < 7; j++) most = fmax(most, fabs(r.q[j] - flat.q[j]));
    for (int j = 0; j < 6; j++) most = fmax(most, fabs(r.v[j] - flat.v[j]));
  }
  print_message("%s, method %d: x = %.3f, differs from that on a plane by %.1e\n", name, method,
                r.q[0], most);
  assert_true(most < 1e-12);
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
  static const double height[] = {0.05, 0.07, 0.05};
  (void)state;
  for (size_t i = 0; i < sizeof methods / sizeof *methods; i++)
    for (int j = 0; j < 3; j++)
      slide(&solids[j], height[j], methods[i], (const char *[]){"box", "ball", "capsule"}[j]);
}

int main(void)
{
  const struct CMUnitTest tests[] = {cmocka_unit_test(test_flat)};
  return cmocka_run_group_tests(tests, NULL, NULL);
}
