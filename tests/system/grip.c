/* A cube of weight m g between two fingers that press with the constant force F = k m g / (2 mu),
 * k > 1, from rest. Rest is a solution: each of four corners of a pad has the normal force F / 4
 * and the friction m g / 8, which is mu / k of it. Coulomb's law has others, as the contacts are
 * hyperstatic: all force at two corners, about which the cube swings. With k < 1 it falls:
 * m z'' = 2 mu F - m g. */
#include "check.h"

#include <nsdae/nsdae.h>

static const double m = 0.2, g = 9.81, mu = 0.6;

static void box(nsdae_bodies *b, double mass, const double *length, double x, int material,
                int *body)
{
  nsdae_rigid_body of = {.mass = mass, .position = {x}};
  nsdae_solid solid = {.shape = NSDAE_SHAPE_BOX, .material = material};
  for (int i = 0; i < 3; i++) {
    double across = length[(i + 1) % 3] * length[(i + 1) % 3],
           other = length[(i + 2) % 3] * length[(i + 2) % 3];
    of.inertia[i] = mass * (across + other) / 12;
    solid.length[i] = length[i];
  }
  *body = nsdae_bodies_add(b, &of);
  assert_true(nsdae_bodies_add_solid(b, *body, &solid) >= 0);
}

/* Where the cube is after 0.3 s: its way, and twice its quaternion's vector. */
static void grip(double k, int method, double dt, double *way, double *turn)
{
  const double side[3] = {0.04, 0.04, 0.04}, pad[3] = {0.01, 0.02, 0.06}, down[3] = {0, 0, -g};
  nsdae_bodies *b;
  nsdae_system *system;
  nsdae_sim *sim;
  nsdae_record r;
  int cube, finger;
  assert_int_equal(nsdae_bodies_create(3, &b, NULL), NSDAE_OK);
  nsdae_bodies_set_gravity(b, down);
  box(b, m, side, 0, 0, &cube);
  for (int s = -1; s <= 1; s += 2) {
    box(b, 0.05, pad, s * (side[0] + pad[0]) / 2, 1, &finger);
    int joint = nsdae_bodies_add_joint(b, &(nsdae_joint){.kind = NSDAE_JOINT_PRISMATIC,
                                                         .body = {NSDAE_GROUND, finger},
                                                         .axis = {-s, 0, 0}});
    assert_true(nsdae_bodies_add_motor(b, &(nsdae_motor){.joint = joint,
                                                         .kind = NSDAE_MOTOR_FORCE,
                                                         .limit = INFINITY,
                                                         .target = k * m * g / (2 * mu)}) >= 0);
  }
  assert_true(nsdae_bodies_set_pair(b, 0, 1, mu, 0, 0) >= 0);
  assert_true(nsdae_bodies_system(b, &system) >= 0);
  nsdae_sim_options o;
  nsdae_sim_options_default(&o);
  o.method = method;
  o.dt = dt;
  double q[21], v[18];
  nsdae_bodies_get_start(b, q, v);
  assert_int_equal(nsdae_sim_create(system, &o, &sim, NULL), NSDAE_OK);
  assert_int_equal(nsdae_sim_init(sim, 0, q, v), NSDAE_OK);
  int status = nsdae_sim_run(sim, 0.3);
  if (status < 0) print_error("k %g method %d: %s\n", k, method, nsdae_sim_error(sim)->text);
  assert_true(status >= 0);
  nsdae_sim_get_record(sim, &r);
  *way = *turn = 0;
  for (int i = 0; i < 3; i++) {
    *way = fmax(*way, fabs(r.q[i]));
    *turn = fmax(*turn, 2 * fabs(r.q[4 + i]));
  }
  nsdae_sim_destroy(&sim);
  nsdae_system_destroy(&system);
  nsdae_bodies_destroy(&b);
}

static void test_grip(void **state)
{
  const int methods[] = {NSDAE_METHOD_IMPLICIT, NSDAE_METHOD_MOREAU, NSDAE_METHOD_EVENT};
  const double dt[] = {2e-3, 2e-3, 1e-2}, more[] = {1.02, 1.1, 1.3, 1.5, 2, 3};
  double way, turn;
  (void)state;
  for (int i = 0; i<6; i += test_share()> 1 ? 2 : 1)
    for (int j = 0; j < 3; j++) {
      grip(more[i], methods[j], dt[j], &way, &turn);
      /* the residuals of 0.3 s: a velocity of 1e-8 at most */
      assert_near(way, 0, 1e-8);
      assert_near(turn, 0, 1e-7);
    }
}

/* No rest is preferred where there is none: the fall of 0.3 s is below that of a free body, and not
 * below that under all friction. */
static void test_too_weak(void **state)
{
  double way, turn, t = 0.3, k = 0.8;
  (void)state;
  grip(k, NSDAE_METHOD_IMPLICIT, 2e-3, &way, &turn);
  assert_at_most(way, g * t * t / 2);
  assert_true(way > 0.99 * (1 - k) * g * t * t / 2);
}

int main(void)
{
  const struct CMUnitTest tests[] = {cmocka_unit_test(test_grip), cmocka_unit_test(test_too_weak)};
  return cmocka_run_group_tests(tests, NULL, NULL);
}
