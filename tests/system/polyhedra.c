/* Polyhedra that move: one that rocks, by event, against the energies of rigid impacts, and piles
 * that come to rest by time stepping, by invariants. */
#include "check.h"

#include <stdlib.h>
#include <string.h>

#include <nsdae/nsdae.h>

#include "random.h"
#include "run_bodies.h"
#include "walls.h"

static const double gravity = 9.81;

static void step(nsdae_sim *sim, nsdae_record *r)
{
  if (nsdae_sim_step(sim) < 0) fail_msg("%s", nsdae_sim_error(sim)->text);
  nsdae_sim_get_record(sim, r);
}

/* ---- a prism that rocks from edge P to edge Q of its base
 *
 * The moment of momentum about Q is the same before and after (G. W. Housner, Bull. Seism. Soc. Am.
 * 53, 1963, for a block), with r from an edge to the centre, and so for the energies of the
 * rotation
 *
 *   omega_2 / omega_1 = (J + m r_P . r_Q) / (J + m r_Q^2)
 *   E_2 / E_1 = (J + m r_P . r_Q)^2 / ((J + m r_P^2) (J + m r_Q^2)) */
static void test_rocks(void **state)
{
  static const double outline[5][2] = {
      {-0.05, 0}, {0.06, 0}, {0.07, 0.2}, {0.02, 0.33}, {-0.03, 0.3}};
  const double density = 500, tilt = 0.08, c = cos(tilt), s = sin(tilt);
  double point[30];
  (void)state;
  for (int i = 0; i < 10; i++) {
    point[3 * i] = outline[i / 2][0];
    point[3 * i + 1] = i % 2 ? 0.1 : -0.1;
    point[3 * i + 2] = outline[i / 2][1];
  }
  nsdae_solid solid = {
      .shape = NSDAE_SHAPE_POLYHEDRON, .points = 10, .point = point, .material = 1};
  nsdae_rigid_body body = {.mass = 0};
  assert_int_equal(nsdae_body_from_solids(1, &solid, &density, &body, NULL), NSDAE_OK);
  const double *G = body.position, p = outline[1][0], q = outline[0][0];
  double m = body.mass, J = body.inertia[1], h = G[2];
  double pp = (G[0] - p) * (G[0] - p) + h * h, qq = (G[0] - q) * (G[0] - q) + h * h;
  double pq = (G[0] - p) * (G[0] - q) + h * h;
  double ratio = (J + m * pq) * (J + m * pq) / ((J + m * pp) * (J + m * qq));
  const double x = G[0] - p;
  body.position[0] = p + c * x + s * h;
  body.position[2] = c * h - s * x;
  body.quaternion[0] = cos(tilt / 2);
  body.quaternion[2] = sin(tilt / 2);
  double before = m * gravity * (body.position[2] - h);
  nsdae_bodies *b = floor_and_walls(10, 0, 0, gravity);
  nsdae_system *system;
  nsdae_record r;
  nsdae_sim_options o;
  nsdae_sim_options_default(&o);
  o.method = NSDAE_METHOD_EVENT;
  o.dt = 0.01;
  o.rtol = 1e-11;
  o.atol = 1e-13;
  nsdae_bodies_add_solid(b, nsdae_bodies_add(b, &body), &solid);
  nsdae_sim *sim = start(b, &o, &system);
  do step(sim, &r);
  while (r.impacts == 0 && r.time < 2);
  step(sim, &r);
  double after = r.kinetic + r.potential - m * gravity * h;
  print_message("rocking: E2 / E1 = %.12f, exact %.12f\n", after / before, ratio);
  assert_near(after / before, ratio, 1e-8);
  end(b, system, sim);
}

/* ---- piles */

static const double golden = 1.6180339887498949;

/* 0: a regular tetrahedron, 1: a dodecahedron, within a ball of that radius. */
static int corners_of(int kind, double radius, double *x)
{
  int count = 0;
  for (int i = 0; i < 8; i++)
    for (int j = 0; j < 3 && (kind == 1 || (i == 0 || i == 3 || i == 5 || i == 6)); j++)
      x[count++] = i >> j & 1 ? 1 : -1;
  for (int i = 0; i < 12 && kind == 1; i++)
    for (int j = 0; j < 3; j++)
      x[count++] = j == i / 4 ? 0
                              : (i >> (j == (i / 4 + 1) % 3) & 1 ? 1 : -1) *
                                    (j == (i / 4 + 1) % 3 ? 1 / golden : golden);
  for (int i = 0; i < count; i++) x[i] *= radius / sqrt(3);
  return count / 3;
}

static void fall(int kind, int method)
{
  enum { SIDE = 2 };
  const int layers = test_share() > 1 ? 2 : 5;
  const double radius = 0.06, density = 700, half = 0.16, dt = 2e-3;
  uint64_t seed = 1;
  double point[60], depth = 0, gain = -INFINITY;
  nsdae_bodies *b = floor_and_walls(0.5, 4, half, gravity);
  nsdae_system *system;
  nsdae_record r;
  nsdae_sim_options o;
  nsdae_sim_options_default(&o);
  o.method = method;
  o.dt = dt;
  o.contact_tol = 1e-8;
  o.projection = NSDAE_PROJECTION_SLOP;
  int points = corners_of(kind, radius, point);
  for (int i = 0; i < SIDE * SIDE * layers; i++) {
    nsdae_solid solid = {
        .shape = NSDAE_SHAPE_POLYHEDRON, .points = points, .point = point, .material = 1};
    nsdae_rigid_body body = {.mass = 0};
    for (int j = 0; j < 3; j++)
      body.position[j] = j == 2 ? 0.1 + 0.13 * (i / 4) : (i >> j & 1 ? 0.08 : -0.08);
    for (int j = 0; j < 4; j++) body.quaternion[j] = random_between(&seed, -1, 1);
    assert_int_equal(nsdae_body_from_solids(1, &solid, &density, &body, NULL), NSDAE_OK);
    nsdae_bodies_add_solid(b, nsdae_bodies_add(b, &body), &solid);
  }
  nsdae_sim *sim = start(b, &o, &system);
  nsdae_sim_get_record(sim, &r);
  double first = r.kinetic + r.potential, energy = first;
  for (int i = 0; i < 1000; i++) {
    step(sim, &r);
    double now = r.kinetic + r.potential - r.projection_energy;
    assert_true(now <= first * (1 + 1e-12));
    if (i > 800) gain = fmax(gain, now - energy);
    if (i > 800) depth = fmax(depth, r.penetration);
    energy = now;
  }
  print_message(
      "%d corners, method %d: kinetic energy %.1e J, depth %.1e m, gain %.1e J of %.2g J\n", points,
      method, r.kinetic, depth, gain, first);
  assert_true(r.kinetic < 1e-12);
  assert_true(depth < 5e-5);
  assert_true(gain < 1e-12 * first);
  end(b, system, sim);
}

/* Without rolling friction a body that hangs on two of its corners swings for ever: none does here.
 */
static void test_piles(void **state)
{
  (void)state;
  for (int kind = 0; kind < 2; kind++) {
    fall(kind, NSDAE_METHOD_MOREAU);
    fall(kind, NSDAE_METHOD_IMPLICIT);
  }
}

int main(void)
{
  const struct CMUnitTest tests[] = {cmocka_unit_test(test_rocks), cmocka_unit_test(test_piles)};
  return cmocka_run_group_tests(tests, NULL, NULL);
}
