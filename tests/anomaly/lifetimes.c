/* Handles destroyed in each order: a system keeps the kit's model, a simulation keeps the system.
 * The run has the bits of one that keeps all handles, and nothing stays allocated. Address
 * sanitizers find reads of freed memory. */
#include "check.h"

#include <nsdae/nsdae.h>

#include "allocator.h"

enum { BODIES = 3, STEPS = 60, VALUES = 2 * 13 * BODIES };

static int drive(double t, double f[3], void *user)
{
  (void)user;
  f[0] = 1 + 0.1 * t, f[1] = 0.1, f[2] = 0;
  return 0;
}

/* A ball that falls on a floor, a pendulum with a spring, a motor and a limit, a driven body;
 * contacts by list or fixed, sensors. */
static nsdae_bodies *model(int listed)
{
  nsdae_bodies *b;
  const double gravity[3] = {0, 0, -9.81};
  const nsdae_solid floor = {.shape = NSDAE_SHAPE_PLANE},
                    ball = {.shape = NSDAE_SHAPE_SPHERE, .radius = 0.1};
  assert_int_equal(nsdae_bodies_create(3, &b, NULL), NSDAE_OK);
  nsdae_bodies_set_gravity(b, gravity);
  nsdae_bodies_add_solid(b, NSDAE_GROUND, &floor);
  for (int i = 0; i < BODIES; i++) {
    nsdae_bodies_add(b, &(nsdae_rigid_body){.mass = 1,
                                            .inertia = {0.1, 0.1, 0.1},
                                            .position = {2.0 * i, 0, i == 0 ? 0.3 : 2},
                                            .quaternion = {1, 0, 0, 0},
                                            .velocity = {0.2 * (i == 0), 0, -0.1 * (i == 2)}});
    if (i == 0) nsdae_bodies_add_solid(b, i, &ball);
  }
  if (listed) nsdae_bodies_set_pair(b, 0, 0, 0.3, 0.5, 0);
  if (!listed) nsdae_bodies_add_contact(b, 0, 1, 0.3, 0.5, 0);
  int hinge = nsdae_bodies_add_joint(b, &(nsdae_joint){.kind = NSDAE_JOINT_REVOLUTE,
                                                       .body = {NSDAE_GROUND, 1},
                                                       .point = {1.5, 0, 2},
                                                       .axis = {0, 1, 0}});
  nsdae_bodies_add_limit(b, &(nsdae_limit){.joint = hinge, .low = -2, .high = 0.3});
  nsdae_bodies_add_motor(
      b, &(nsdae_motor){.joint = hinge, .kind = NSDAE_MOTOR_SPEED, .target = 0.2, .limit = 1});
  nsdae_bodies_add_spring(
      b, &(nsdae_spring){
             .body = {0, 1}, .end = {2, 0, 2}, .point = {0, 0, 0.3}, .stiffness = 2, .rest = 2});
  nsdae_bodies_add_joint(b, &(nsdae_joint){.kind = NSDAE_JOINT_DISTANCE,
                                           .body = {NSDAE_GROUND, 2},
                                           .point = {4, 0, 3},
                                           .end = {4, 0, 2},
                                           .drive = drive});
  nsdae_bodies_add_sensor(b, &(nsdae_sensor){.kind = NSDAE_SENSOR_CONTACT_FORCE, .body = 0});
  return b;
}

/* Which handles are destroyed before the run. */
enum { KEEP_ALL, BODIES_AT_ONCE, BODIES_AFTER_SIM, SYSTEM_TOO, ORDERS };

static void run(int order, int listed, int method, double bits[STEPS][VALUES])
{
  nsdae_bodies *b = model(listed);
  nsdae_system *system;
  nsdae_sim *sim;
  nsdae_sim_options o;
  nsdae_dims d;
  double q[7 * BODIES], v[6 * BODIES];
  int status = nsdae_bodies_system(b, &system);
  if (status != NSDAE_OK) print_error("%s\n", nsdae_bodies_error(b)->text);
  assert_int_equal(status, NSDAE_OK);
  nsdae_bodies_get_dims(b, &d);
  nsdae_bodies_get_start(b, q, v);
  if (order == BODIES_AT_ONCE) nsdae_bodies_destroy(&b);
  nsdae_sim_options_default(&o);
  o.method = method;
  o.dt = 0.01;
  assert_int_equal(nsdae_sim_create(system, &o, &sim, NULL), NSDAE_OK);
  if (order >= BODIES_AFTER_SIM) nsdae_bodies_destroy(&b);
  if (order == SYSTEM_TOO) nsdae_system_destroy(&system);
  if (order != KEEP_ALL) { /* the handle is gone: no call changes the model */
    assert_null(b);
    assert_int_equal(nsdae_bodies_set_gravity(b, q), NSDAE_E_ARGUMENT);
    assert_int_equal(nsdae_bodies_add(b, &(nsdae_rigid_body){.mass = 1}), NSDAE_E_ARGUMENT);
  }
  status = nsdae_sim_init(sim, 0, q, v);
  if (status < 0) print_error("%s\n", nsdae_sim_error(sim)->text);
  assert_true(status >= 0);
  for (int i = 0; i < STEPS; i++) {
    nsdae_record r;
    status = nsdae_sim_step(sim);
    if (status < 0) print_error("%s\n", nsdae_sim_error(sim)->text);
    assert_true(status >= 0);
    nsdae_sim_get_record(sim, &r);
    memcpy(bits[i], r.q, (size_t)d.nq * sizeof *r.q);
    memcpy(bits[i] + d.nq, r.v, (size_t)d.nv * sizeof *r.v);
    assert_int_equal(nsdae_sim_get_sensor(sim, 0, bits[i] + d.nq + d.nv), NSDAE_OK);
  }
  nsdae_sim_destroy(&sim);
  nsdae_system_destroy(&system);
  nsdae_bodies_destroy(&b);
}

static void test_orders(void **state)
{
  (void)state;
  static double bits[2][STEPS][VALUES];
  const int methods[] = {NSDAE_METHOD_IMPLICIT, NSDAE_METHOD_MOREAU, NSDAE_METHOD_EVENT,
                         NSDAE_METHOD_PENALTY};
  for (int listed = 0; listed < 2; listed++)
    for (size_t m = 0; m < sizeof methods / sizeof *methods; m++) {
      allocator_reset(-1);
      run(KEEP_ALL, listed, methods[m], bits[0]);
      for (int order = BODIES_AT_ONCE; order < ORDERS; order++) {
        run(order, listed, methods[m], bits[1]);
        assert_memory_equal(bits[0], bits[1], sizeof bits[0]);
      }
      assert_int_equal(the_allocator.live, 0);
    }
}

/* Free fall from z = 1 in one second, exact by moreau: z = 1 - g/2. */
static void test_fall(void **state)
{
  (void)state;
  nsdae_bodies *b;
  nsdae_system *system;
  nsdae_sim *sim;
  nsdae_record r;
  double q[7], v[6];
  assert_int_equal(nsdae_bodies_create(3, &b, NULL), NSDAE_OK);
  nsdae_bodies_set_gravity(b, (double[]){0, 0, -9.81});
  nsdae_bodies_add(b, &(nsdae_rigid_body){.mass = 1, .inertia = {1, 1, 1}, .position = {0, 0, 1}});
  assert_int_equal(nsdae_bodies_system(b, &system), NSDAE_OK);
  nsdae_bodies_get_start(b, q, v);
  nsdae_bodies_destroy(&b);
  assert_int_equal(nsdae_sim_create(system, NULL, &sim, NULL), NSDAE_OK);
  nsdae_system_destroy(&system);
  assert_int_equal(nsdae_sim_init(sim, 0, q, v), NSDAE_OK);
  assert_int_equal(nsdae_sim_run(sim, 1), NSDAE_OK);
  nsdae_sim_get_record(sim, &r);
  assert_near(r.q[2], -3.905, 1e-11); /* rounding of 1000 steps */
  nsdae_sim_destroy(&sim);
}

/* Several systems and simulations; those that were never made; a system that is refused. */
static void test_counts(void **state)
{
  (void)state;
  nsdae_bodies *b;
  nsdae_system *system;
  nsdae_sim *sim[3];
  allocator_reset(-1);
  b = model(1);
  assert_int_equal(nsdae_bodies_system(b, &system), NSDAE_OK);
  for (int i = 0; i < 3; i++)
    assert_int_equal(nsdae_sim_create(system, NULL, &sim[i], NULL), NSDAE_OK);
  nsdae_system_destroy(&system);
  nsdae_bodies_destroy(&b);
  nsdae_bodies_destroy(&b);
  nsdae_bodies_destroy(NULL);
  for (int i = 2; i >= 0; i--) {
    assert_true(the_allocator.live > 0);
    nsdae_sim_destroy(&sim[i]);
  }
  assert_int_equal(the_allocator.live, 0);
  b = model(0);
  nsdae_bodies_add(b, &(nsdae_rigid_body){.mass = -1});
  assert_int_equal(nsdae_bodies_system(b, &system), NSDAE_E_ARGUMENT);
  assert_null(system);
  nsdae_bodies_destroy(&b);
  assert_int_equal(the_allocator.live, 0);
}

int main(void)
{
  const struct CMUnitTest tests[] = {cmocka_unit_test(test_orders), cmocka_unit_test(test_fall),
                                     cmocka_unit_test(test_counts)};
  return cmocka_run_group_tests(tests, NULL, NULL);
}
