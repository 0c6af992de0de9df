/* The paper's three systems, written with the kit, against those written by hand: with event at
 * rtol 1e-12, and step by step with moreau where both have the same coordinates. */
#include "check.h"

#include <float.h>

#include "clearance_hinge.h"
#include "crank_slider.h"
#include "pendulum.h"

enum { NQ_MAX = 9 };

typedef struct outcome {
  double q[NQ_MAX], v[NQ_MAX];
  long impacts;
} outcome;

static outcome run(nsdae_system *system, const double *q0, const double *v0, int method, double dt,
                   double t_end)
{
  outcome out = {.impacts = 0};
  nsdae_sim *sim;
  nsdae_sim_options options;
  nsdae_record record;
  nsdae_stats stats;
  nsdae_dims dims;
  nsdae_error error;
  nsdae_sim_options_default(&options);
  options.method = method;
  options.dt = dt;
  options.rtol = 1e-12;
  options.atol = 1e-14;
  int status = nsdae_sim_create(system, &options, &sim, &error);
  if (status < 0) print_error("%s\n", error.text);
  assert_int_equal(status, NSDAE_OK);
  assert_int_equal(nsdae_sim_init(sim, 0, q0, v0), NSDAE_OK);
  status = nsdae_sim_run(sim, t_end);
  if (status < 0) print_error("%s\n", nsdae_sim_error(sim)->text);
  assert_true(status >= 0);
  nsdae_sim_get_record(sim, &record);
  nsdae_sim_get_stats(sim, &stats);
  nsdae_sim_get_dims(sim, &dims);
  memcpy(out.q, record.q, (size_t)dims.nq * sizeof *out.q);
  memcpy(out.v, record.v, (size_t)dims.nv * sizeof *out.v);
  out.impacts = stats.impacts;
  nsdae_sim_destroy(&sim);
  return out;
}

/* What the model written by hand does. */
static outcome by_hand(const driver_model *model, int method, double dt, double t_end)
{
  nsdae_system *system;
  double q0[NQ_MAX] = {0}, v0[NQ_MAX] = {0};
  assert_int_equal(model->build(model->base, &system, NULL), NSDAE_OK);
  model->start(model->base, q0, v0);
  outcome out = run(system, q0, v0, method, dt, t_end);
  nsdae_system_destroy(&system);
  return out;
}

static outcome by_kit(nsdae_bodies *bodies, int method, double dt, double t_end)
{
  nsdae_system *system;
  double q0[NQ_MAX], v0[NQ_MAX];
  int status = nsdae_bodies_system(bodies, &system);
  if (status < 0) print_error("%s\n", nsdae_bodies_error(bodies)->text);
  assert_int_equal(status, NSDAE_OK);
  nsdae_bodies_get_start(bodies, q0, v0);
  outcome out = run(system, q0, v0, method, dt, t_end);
  nsdae_system_destroy(&system);
  nsdae_bodies_destroy(&bodies);
  return out;
}

static nsdae_bodies *world(double g)
{
  nsdae_bodies *b;
  const double gravity[3] = {0, -g, 0};
  assert_int_equal(nsdae_bodies_create(2, &b, NULL), NSDAE_OK);
  nsdae_bodies_set_gravity(b, gravity);
  return b;
}

/* A uniform rod of length L, from the point (x, y) down at theta from the vertical. */
static int add_rod(nsdae_bodies *b, double m, double L, double x, double y, double theta)
{
  return nsdae_bodies_add(
      b, &(nsdae_rigid_body){.mass = m,
                             .inertia = {0, 0, m * L * L / 12},
                             .position = {x + L / 2 * sin(theta), y - L / 2 * cos(theta)},
                             .angle = theta});
}

static nsdae_bodies *kit_pendulum(const pendulum *p)
{
  nsdae_bodies *b = world(p->g);
  int rod = add_rod(b, p->m, p->L, 0, 0, p->theta_0);
  nsdae_bodies_add_joint(b,
                         &(nsdae_joint){.kind = NSDAE_JOINT_REVOLUTE, .body = {NSDAE_GROUND, rod}});
  int wall = nsdae_bodies_add_solid(
      b, NSDAE_GROUND, &(nsdae_solid){.shape = NSDAE_SHAPE_PLANE, .angle = -acos(-1) / 2});
  int tip = nsdae_bodies_add_solid(
      b, rod, &(nsdae_solid){.shape = NSDAE_SHAPE_POINT, .position = {0, -p->L / 2}});
  nsdae_bodies_add_contact(b, wall, tip, 0, p->e_N, 0);
  return b;
}

static nsdae_bodies *kit_hinge(const clearance_hinge *p)
{
  nsdae_bodies *b = world(p->g);
  int rod = add_rod(b, p->m, p->l, p->dX, p->dY, p->theta_0);
  int hole = nsdae_bodies_add_solid(
      b, NSDAE_GROUND, &(nsdae_solid){.shape = NSDAE_SHAPE_DISC, .radius = p->R, .hollow = 1});
  int shaft = nsdae_bodies_add_solid(
      b, rod, &(nsdae_solid){.shape = NSDAE_SHAPE_DISC, .radius = p->r, .position = {0, p->l / 2}});
  nsdae_bodies_add_contact(b, hole, shaft, p->mu, p->e_N, p->e_T);
  return b;
}

static int crank_torque(double t, const double x[3], const double v[3], double force[3],
                        double torque[3], void *user)
{
  const crank_slider *p = user;
  (void)x;
  (void)v;
  (void)force;
  torque[2] = p->P0 * sin(p->w * t);
  return 0;
}

static nsdae_bodies *kit_crank_slider(crank_slider *p)
{
  nsdae_bodies *b = world(p->g);
  const double pin[3] = {0, -p->L1, 0}, end[3] = {0, -p->L1 - p->L2, 0};
  int crank = add_rod(b, p->m1, p->L1, 0, 0, 0), rod = add_rod(b, p->m2, p->L2, 0, -p->L1, 0);
  int slider = nsdae_bodies_add(
      b, &(nsdae_rigid_body){.mass = p->m3, .inertia = {0, 0, 1}, .position = {0, end[1]}});
  nsdae_bodies_add_joint(
      b, &(nsdae_joint){.kind = NSDAE_JOINT_REVOLUTE, .body = {NSDAE_GROUND, crank}});
  nsdae_bodies_add_joint(b, &(nsdae_joint){.kind = NSDAE_JOINT_REVOLUTE,
                                           .body = {crank, rod},
                                           .point = {pin[0], pin[1]}});
  nsdae_bodies_add_joint(b, &(nsdae_joint){.kind = NSDAE_JOINT_REVOLUTE,
                                           .body = {rod, slider},
                                           .point = {end[0], end[1]}});
  nsdae_bodies_add_joint(b, &(nsdae_joint){.kind = NSDAE_JOINT_SLOT,
                                           .body = {NSDAE_GROUND, slider},
                                           .point = {end[0], end[1]},
                                           .axis = {0, 1},
                                           .mu = p->mu});
  nsdae_bodies_add_spring(b, &(nsdae_spring){.body = {NSDAE_GROUND, slider},
                                             .point = {end[0], end[1] - 1},
                                             .end = {end[0], end[1]},
                                             .stiffness = p->k,
                                             .rest = 1});
  nsdae_bodies_add_load(b, crank, end, crank_torque, p);
  return b;
}

static void expect_same(const outcome *a, const outcome *b, int n, double tol)
{
  for (int i = 0; i < n; i++) {
    assert_near(a->q[i], b->q[i], tol);
    assert_near(a->v[i], b->v[i], tol * 100); /* velocities here are up to 100 times larger */
  }
  assert_int_equal(a->impacts, b->impacts);
}

static void test_pendulum(void **state)
{
  pendulum *p = pendulum_model.base;
  (void)state;
  nsdae_params_default(pendulum_model.parameters, p);
  /* until the impact: the kit's gap is where the tip is, L sin theta only but for the drift */
  outcome hand = by_hand(&pendulum_model, NSDAE_METHOD_MOREAU, 0.005, 0.45);
  outcome kit = by_kit(kit_pendulum(p), NSDAE_METHOD_MOREAU, 0.005, 0.45);
  expect_same(&hand, &kit, 3, 100 * 16 * DBL_EPSILON); /* rounding of 100 steps */
  hand = by_hand(&pendulum_model, NSDAE_METHOD_EVENT, 0.01, 1);
  kit = by_kit(kit_pendulum(p), NSDAE_METHOD_EVENT, 0.01, 1);
  expect_same(&hand, &kit, 3, 1e-10);
}

static void test_hinge(void **state)
{
  clearance_hinge *p = clearance_hinge_model.base;
  (void)state;
  nsdae_params_default(clearance_hinge_model.parameters, p);
  outcome hand = by_hand(&clearance_hinge_model, NSDAE_METHOD_MOREAU, 0.005, 0.2);
  outcome kit = by_kit(kit_hinge(p), NSDAE_METHOD_MOREAU, 0.005, 0.2);
  /* the normal turns by v dt / (R - r), about 1 in a step, and doubles an error at each impact */
  expect_same(&hand, &kit, 3, 1e-10);
  hand = by_hand(&clearance_hinge_model, NSDAE_METHOD_EVENT, 0.005, 0.2);
  kit = by_kit(kit_hinge(p), NSDAE_METHOD_EVENT, 0.005, 0.2);
  expect_same(&hand, &kit, 3, 1e-10);
}

/* The same crank and rod, in absolute coordinates: its angles are the model's. */
static void test_crank_slider(void **state)
{
  crank_slider *p = crank_slider_model.base;
  (void)state;
  nsdae_params_default(crank_slider_model.parameters, p);
  outcome hand = by_hand(&crank_slider_model, NSDAE_METHOD_EVENT, 0.01, 4);
  outcome kit = by_kit(kit_crank_slider(p), NSDAE_METHOD_EVENT, 0.01, 4);
  for (int i = 0; i < 2; i++) {
    assert_near(kit.q[3 * i + 2], hand.q[i], 1e-10);
    assert_near(kit.v[3 * i + 2], hand.v[i], 1e-9);
  }
}

/* K(k) = pi / (2 agm(1, sqrt(1 - k^2))), Gauss's arithmetic-geometric mean. */
static double complete_elliptic(double k)
{
  double a = 1, b = sqrt(1 - k * k);
  while (fabs(a - b) > 4 * DBL_EPSILON) {
    double mean = (a + b) / 2;
    b = sqrt(a * b);
    a = mean;
  }
  return acos(-1) / (a + b);
}

/* Columns: the axes that the unit quaternion p turns those of space into. */
static void rotation(const double *p, double *R)
{
  for (int j = 0; j < 3; j++) {
    double e[3] = {0, 0, 0}, u[3], cross[3];
    e[j] = 1;
    /* e + 2 w (x X e) + 2 x X (x X e) */
    for (int i = 0; i < 3; i++) {
      int k = (i + 1) % 3, l = (i + 2) % 3;
      u[i] = p[1 + k] * e[l] - p[1 + l] * e[k];
    }
    for (int i = 0; i < 3; i++) {
      int k = (i + 1) % 3, l = (i + 2) % 3;
      cross[i] = p[1 + k] * u[l] - p[1 + l] * u[k];
      R[3 * j + i] = e[i] + 2 * p[0] * u[i] + 2 * cross[i];
    }
  }
}

/* A free body of three different moments of inertia: energy and angular momentum stay, and omega
 * comes back after the period of Jacobi's functions (Landau and Lifshitz, Mechanics, section 37):
 * with J_1 < J_2 < J_3, M^2 > 2 E J_2,
 *   T = 4 K(k) sqrt(J_1 J_2 J_3 / ((J_3 - J_2) (M^2 - 2 E J_1))),
 *   k^2 = (J_2 - J_1) (2 E J_3 - M^2) / ((J_3 - J_2) (M^2 - 2 E J_1)) */
static void test_polhode(void **state)
{
  const double J[3] = {1, 2, 3}, w[3] = {0.3, 0.2, 1};
  nsdae_bodies *b;
  nsdae_system *system;
  double q[7], v[6], twice_E = 0, square = 0;
  (void)state;
  assert_int_equal(nsdae_bodies_create(3, &b, NULL), NSDAE_OK);
  nsdae_rigid_body body = {.mass = 1, .velocity = {0.1, 0, 0}};
  for (int i = 0; i < 3; i++) {
    body.inertia[i] = J[i];
    body.spin[i] = w[i];
    twice_E += J[i] * w[i] * w[i];
    square += J[i] * J[i] * w[i] * w[i];
  }
  assert_int_equal(nsdae_bodies_add(b, &body), 0);
  assert_int_equal(nsdae_bodies_system(b, &system), NSDAE_OK);
  nsdae_bodies_get_start(b, q, v);
  double speed = (J[2] - J[1]) * (square - twice_E * J[0]);
  double k = sqrt((J[1] - J[0]) * (twice_E * J[2] - square) / speed);
  double period = 4 * complete_elliptic(k) * sqrt(J[0] * J[1] * J[2] / speed);
  outcome out = run(system, q, v, NSDAE_METHOD_EVENT, period / 50, period);
  for (int i = 0; i < 3; i++) assert_near(out.v[3 + i], w[i], 1e-9);
  /* angular momentum in space: R J omega, as at the start where R = 1 */
  double momentum[3], R[9];
  const double *p = out.q + 3, size = p[0] * p[0] + p[1] * p[1] + p[2] * p[2] + p[3] * p[3];
  assert_near(size, 1, 1e-9);
  rotation(p, R);
  for (int i = 0; i < 3; i++) {
    momentum[i] = 0;
    for (int j = 0; j < 3; j++) momentum[i] += R[3 * j + i] * J[j] * out.v[3 + j];
    assert_near(momentum[i], J[i] * w[i], 1e-9);
  }
  assert_near(out.q[0], 0.1 * period, 1e-9);
  nsdae_system_destroy(&system);
  nsdae_bodies_destroy(&b);
}

int main(void)
{
  const struct CMUnitTest tests[] = {cmocka_unit_test(test_pendulum), cmocka_unit_test(test_hinge),
                                     cmocka_unit_test(test_crank_slider),
                                     cmocka_unit_test(test_polhode)};
  return cmocka_run_group_tests(tests, NULL, NULL);
}
