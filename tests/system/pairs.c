/* Solids that touch cylinders, by time stepping: what stands or lies stays, mixed piles come to
 * rest, and the methods that refuse them. */
#include "check.h"

#include <stdlib.h>
#include <string.h>

#include <nsdae/nsdae.h>

#include "allocator.h"
#include "random.h"
#include "run_bodies.h"
#include "walls.h"

static const double gravity = 9.81, density = 700;

static nsdae_solid solid(int shape, double radius, double x, double y, double z)
{
  return (nsdae_solid){.shape = shape, .radius = radius, .length = {x, y, z}, .material = 1};
}

static int put(nsdae_bodies *b, const nsdae_solid *s, const double *at, const double *turn)
{
  nsdae_rigid_body body = {.mass = 0};
  memcpy(body.position, at, 3 * sizeof *at);
  memcpy(body.quaternion, turn, 4 * sizeof *turn);
  nsdae_solid own = *s;
  assert_int_equal(nsdae_body_from_solids(1, &own, &density, &body, NULL), NSDAE_OK);
  int i = nsdae_bodies_add(b, &body);
  if (nsdae_bodies_add_solid(b, i, &own) < 0) fail_msg("%s", nsdae_bodies_error(b)->text);
  return i;
}

static nsdae_sim *begin(nsdae_bodies *b, int method, double dt, nsdae_system **system)
{
  nsdae_sim_options o;
  nsdae_sim_options_default(&o);
  o.start_tol = 1; /* some begin deep in each other */
  o.method = method;
  o.dt = dt;
  o.contact_tol = 1e-8;
  o.projection = NSDAE_PROJECTION_SLOP;
  return start(b, &o, system);
}

/* Runs for a time; the energy is never above its first. The last quarter: depth and gain. */
static void settle(nsdae_bodies *b, int method, double dt, int steps, const char *what, double most)
{
  nsdae_system *system;
  nsdae_record r;
  nsdae_sim *sim = begin(b, method, dt, &system);
  nsdae_sim_get_record(sim, &r);
  double first = r.kinetic + r.potential, energy = first, depth = 0, gain = -INFINITY;
  int contacts = 0;
  for (int i = 0; i < steps; i++) {
    if (nsdae_sim_step(sim) < 0) fail_msg("%s: %s", what, nsdae_sim_error(sim)->text);
    nsdae_sim_get_record(sim, &r);
    double now = r.kinetic + r.potential - r.projection_energy;
    if (now > first + 1e-12 * fabs(first) + 1e-15)
      fail_msg("%s: energy grows by %g J at %g", what, now - first, r.time);
    if (i > 3 * steps / 4) {
      gain = fmax(gain, now - energy);
      depth = fmax(depth, r.penetration);
    }
    energy = now;
    contacts = r.contacts.count;
  }
  print_message(
      "%s, method %d: %d contacts, kinetic energy %.1e J, depth %.1e m, gain %.1e J of %.2g J\n",
      what, method, contacts, r.kinetic, depth, gain, first);
  if (!(r.kinetic < most)) fail_msg("%s moves: %g J", what, r.kinetic);
  assert_true(depth < 5e-5);
  end(b, system, sim);
}

static const int methods[] = {NSDAE_METHOD_MOREAU, NSDAE_METHOD_IMPLICIT};

static void test_flush(void **state)
{
  const double upright[4] = {1}, lying[4] = {sqrt(0.5), sqrt(0.5)}, c = 0.05;
  (void)state;
  for (int m = 0; m < 2; m++)
    for (int k = 0; k < 11; k++) {
      if (test_share() > 1 && (k + m) % 2) continue; /* each by one of the methods */
      static const char *const names[] = {
          "cylinder stands on box", "cylinder lies on box", "box on cap",
          "cylinder on cylinder",   "log on two logs",      "box on two logs",
          "capsule on cap",         "log across log",       "box by the rim of a cap",
          "rim of a cap on beams",  "rim of a cap on pipes"};
      const nsdae_solid box = solid(NSDAE_SHAPE_BOX, 0, 0.3, 0.3, 0.1);
      const nsdae_solid can = solid(NSDAE_SHAPE_CYLINDER, c, 0, 0, 0.16);
      const nsdae_solid log = solid(NSDAE_SHAPE_CYLINDER, c, 0, 0, 0.4);
      const nsdae_solid cap = solid(NSDAE_SHAPE_CAPSULE, 0.02, 0, 0, 0.05);
      const nsdae_solid drum = solid(NSDAE_SHAPE_CYLINDER, 0.5, 0, 0, 0.2);
      const nsdae_solid beam = solid(NSDAE_SHAPE_BOX, 0, 0.9, 0.1, 0.1);
      const nsdae_solid pipe = solid(NSDAE_SHAPE_CYLINDER, c, 0, 0, 0.9);
      const nsdae_solid cube = solid(NSDAE_SHAPE_BOX, 0, 0.04, 0.04, 0.04);
      nsdae_bodies *b = floor_and_walls(0.5, 0, 0, gravity);
      switch (k) {
      case 0:
        put(b, &box, (double[]){0, 0, 0.05}, upright);
        put(b, &can, (double[]){0.02, 0, 0.18 + 1e-3}, upright);
        break;
      case 1:
        put(b, &box, (double[]){0, 0, 0.05}, upright);
        put(b, &can, (double[]){0.02, 0, 0.15 + 1e-3}, lying);
        break;
      case 2:
        put(b, &can, (double[]){0, 0, 0.08}, upright);
        put(b, &box, (double[]){0.01, 0, 0.21 + 1e-3}, upright);
        break;
      case 3:
        put(b, &can, (double[]){0, 0, 0.08}, upright);
        put(b, &can, (double[]){0.01, 0, 0.24 + 1e-3}, (double[]){1, 0, 0, 0.2});
        break;
      case 4:
        put(b, &log, (double[]){-0.051, 0, 0.05}, lying);
        put(b, &log, (double[]){0.051, 0.02, 0.05}, lying);
        put(b, &log, (double[]){0, 0.01, 0.05 + 0.088}, lying);
        break;
      case 5:
        put(b, &log, (double[]){-0.08, 0, 0.05}, lying);
        put(b, &log, (double[]){0.08, 0.02, 0.05}, lying);
        put(b, &box, (double[]){0, 0.01, 0.15 + 1e-3}, upright);
        break;
      case 6:
        put(b, &can, (double[]){0, 0, 0.08}, upright);
        put(b, &cap, (double[]){0, 0, 0.18 + 1e-3}, lying);
        break;
      case 7:
        put(b, &log, (double[]){0, 0, 0.05}, lying);
        put(b, &box, (double[]){0.2, 0, 0.05}, upright);
        put(b, &log, (double[]){0.1, 0, 0.151}, (double[]){0.5, 0.5, 0.5, 0.5});
        break;
      case 8: /* beyond the chord of the cap's points that are fixed to it */
        put(b, &drum, (double[]){0, 0, 0.1}, upright);
        put(b, &cube, (double[]){0.31, 0.31, 0.22 + 1e-3}, upright);
        break;
      default: /* across the axes at 0.45 of the radius 0.5, the chord is at 0.354 */
        for (int side = -1; side < 2; side += 2) {
          const double turn[2][4] = {{1 + sqrt(0.5), 0, 0, sqrt(0.5)}, {sqrt(0.5), -0.5, 0.5, 0}};
          const double at[3] = {side * 0.45 * sqrt(0.5), -side * 0.45 * sqrt(0.5), 0.05};
          put(b, k == 9 ? &beam : &pipe, at, turn[k - 9]);
        }
        put(b, &drum, (double[]){0, 0, 0.2 + 1e-3}, upright);
      }
      settle(b, methods[m], 2e-3, 1500, names[k],
             k == 0 || k == 2 || k == 3 || k == 8 ? 1e-12 : 1e-3);
    }
}

/* ---- piles */

static void random_solid(int i, uint64_t *seed, double *point, nsdae_solid *s)
{
  double a[3];
  for (int j = 0; j < 3; j++) a[j] = random_between(seed, 0.05, 0.12);
  *s = i % 4 == 0   ? solid(NSDAE_SHAPE_CYLINDER, a[0] / 2, 0, 0, a[2])
       : i % 4 == 1 ? solid(NSDAE_SHAPE_BOX, 0, a[0], a[1], a[2])
       : i % 4 == 2 ? solid(NSDAE_SHAPE_CYLINDER, a[0], 0, 0, a[2] / 3)
                    : solid(NSDAE_SHAPE_POLYHEDRON, 0, 0, 0, 0);
  s->points = 8;
  s->point = point;
  for (int j = 0; j < 24 && i % 4 == 3; j++)
    point[j] = (j % 3 == 2   ? j > 11
                : j % 3 == 0 ? (j / 3 + 1) / 2 % 2
                             : j / 3 % 4 / 2) *
               a[j % 3] * (j > 11 && j % 3 < 2 ? 0.7 : 1);
}

/* Of the piles of seeds 5 to 12 those of 5, 8, 10 and 12 come to rest by both methods. In each of
 * the others one cylinder or box still rolls or rocks at 1 to 2 cm/s: nothing resists rolling. */
static void test_piles(void **state)
{
  (void)state;
  for (int m = 0; m < 2; m += test_share()) {
    enum { SIDE = 2 };
    const int layers = test_share() > 1 ? 3 : 6;
    uint64_t seed = layers == 3 ? 2 : 10;
    nsdae_bodies *b = floor_and_walls(0.5, 4, 0.16, gravity);
    for (int i = 0; i < SIDE * SIDE * layers; i++) {
      double point[24], at[3], turn[4];
      nsdae_solid s;
      random_solid((i + i / 4) % 4, &seed, point, &s);
      for (int j = 0; j < 3; j++)
        at[j] = j == 2 ? 0.12 + 0.15 * (i / 4) : (i >> j & 1 ? 0.08 : -0.08);
      for (int j = 0; j < 4; j++) turn[j] = random_between(&seed, -1, 1);
      put(b, &s, at, turn);
    }
    settle(b, methods[m], 2e-3, layers > 2 ? 2000 : 1000, "pile", 1e-6);
  }
}

/* ---- refused */

static void test_refused(void **state)
{
  const int refused[] = {NSDAE_METHOD_EVENT, NSDAE_METHOD_PENALTY};
  (void)state;
  for (int k = 0; k < 4; k++) {
    nsdae_bodies *b = floor_and_walls(0.5, 0, 0, gravity);
    nsdae_system *system;
    nsdae_sim *sim;
    nsdae_error error;
    nsdae_sim_options o;
    const nsdae_solid can = solid(NSDAE_SHAPE_CYLINDER, 0.1, 0, 0, 0.2);
    const nsdae_solid box = solid(NSDAE_SHAPE_BOX, 0, 0.1, 0.1, 0.2);
    nsdae_sim_options_default(&o);
    o.method = refused[k % 2];
    put(b, &can, (double[]){0, 0, 0.1}, (double[]){1, 0, 0, 0});
    put(b, &box, (double[]){0.2, 0, 0.1}, (double[]){1, 0, 0, 0});
    if (k > 1) nsdae_bodies_add_contact(b, 1, 2, 0.3, 0, 0);
    assert_true(nsdae_bodies_system(b, &system) >= 0);
    assert_int_equal(nsdae_sim_create(system, &o, &sim, &error), NSDAE_E_ARGUMENT);
    assert_null(sim);
    assert_string_equal(error.argument, "method");
    assert_non_null(strstr(error.text, "cylinder and box have contacts for time stepping alone"));
    nsdae_system_destroy(&system);
    nsdae_bodies_destroy(&b);
  }
}

/* ---- memory */

/* A can that falls on a box: every allocation is lost once, and no step makes one. */
static int fall(int steps)
{
  nsdae_bodies *b = NULL;
  nsdae_system *system = NULL;
  nsdae_sim *sim = NULL;
  nsdae_sim_options o;
  double q[14], v[12];
  nsdae_sim_options_default(&o);
  const nsdae_solid can = solid(NSDAE_SHAPE_CYLINDER, 0.1, 0, 0, 0.2);
  const nsdae_solid box = solid(NSDAE_SHAPE_BOX, 0, 0.4, 0.4, 0.2);
  int status = nsdae_bodies_create(3, &b, NULL);
  for (int i = 0; i < 2 && status >= 0; i++) {
    const nsdae_rigid_body body = {
        .mass = 1, .inertia = {1, 1, 1}, .position = {0, 0, 0.1 + 0.21 * i}};
    status = nsdae_bodies_add_solid(b, nsdae_bodies_add(b, &body), i ? &can : &box);
  }
  if (status >= 0) status = nsdae_bodies_set_gravity(b, (double[]){0, 0, -gravity});
  if (status >= 0)
    status = nsdae_bodies_add_solid(b, NSDAE_GROUND, &(nsdae_solid){.shape = NSDAE_SHAPE_PLANE});
  if (status >= 0) status = nsdae_bodies_set_pair(b, 1, 1, 0.5, 0, 0);
  if (status >= 0) status = nsdae_bodies_set_pair(b, 0, 1, 0.5, 0, 0);
  if (status >= 0) status = nsdae_bodies_system(b, &system);
  if (status >= 0) status = nsdae_sim_create(system, &o, &sim, NULL);
  if (status >= 0) nsdae_bodies_get_start(b, q, v);
  if (status >= 0) status = nsdae_sim_init(sim, 0, q, v);
  long before = 0;
  for (int i = 0; i < steps && status >= 0; i++) {
    if (i == steps / 2) before = the_allocator.calls; /* by then the list has grown */
    status = nsdae_sim_step(sim);
  }
  if (status >= 0 && steps > 100) assert_int_equal(the_allocator.calls, before);
  end(b, system, sim);
  return status;
}

static void test_memory(void **state)
{
  int status = -1;
  (void)state;
  for (long lost = 0; status < 0 && lost < 2000; lost++) {
    allocator_reset(lost);
    status = fall(60);
    assert_int_equal(the_allocator.live, 0);
    assert_true(status >= 0 || status == NSDAE_E_MEMORY);
  }
  assert_true(status >= 0);
  allocator_reset(-1);
  assert_true(fall(400) >= 0);
}

int main(void)
{
  const struct CMUnitTest tests[] = {cmocka_unit_test(test_flush), cmocka_unit_test(test_piles),
                                     cmocka_unit_test(test_refused), cmocka_unit_test(test_memory)};
  return cmocka_run_group_tests(tests, NULL, NULL);
}
