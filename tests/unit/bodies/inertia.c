/* Inertia tensors. A body whose axes are not principal moves as the same body with principal axes.
 * Masses at points have a tensor that is taken; beyond it no body has it. */
#include "check.h"

#include <nsdae/nsdae.h>

static uint64_t seed = 7;

static double uniform(double low, double high)
{
  seed = seed * 6364136223846793005u + 1442695040888963407u;
  return low + (high - low) * (double)(seed >> 11) / 9007199254740992.0;
}

/* ---- two descriptions of one body */

/* c := a b, quaternions. */
static void multiply(const double *a, const double *b, double *c)
{
  c[0] = a[0] * b[0] - a[1] * b[1] - a[2] * b[2] - a[3] * b[3];
  c[1] = a[0] * b[1] + a[1] * b[0] + a[2] * b[3] - a[3] * b[2];
  c[2] = a[0] * b[2] - a[1] * b[3] + a[2] * b[0] + a[3] * b[1];
  c[3] = a[0] * b[3] + a[1] * b[2] - a[2] * b[1] + a[3] * b[0];
}

/* Row-major R of a unit quaternion. */
static void matrix(const double *p, double R[3][3])
{
  double w = p[0], x = p[1], y = p[2], z = p[3];
  const double of[3][3] = {{1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)},
                           {2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)},
                           {2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)}};
  for (int i = 0; i < 9; i++) R[i / 3][i % 3] = of[i / 3][i % 3];
}

/* Hung at a point off its centre, spinning, with gravity. turn: of the body's axes in the principal
 * ones; x [4]: its centre and the energy at the end. */
static void swing(const double turn[4], int method, double dt, double x[4])
{
  const double principal[3] = {0.5, 0.8, 1.1}, half[4] = {0.5, 0.5, -0.5, 0.5};
  const double spin[3] = {0.7, -1.1, 0.4}, pin[3] = {0.3, -0.2, 0.4};
  double R[3][3], P[3][3], q[7], v[6], arm[3];
  nsdae_rigid_body body = {.mass = 2};
  nsdae_bodies *b;
  nsdae_system *system;
  nsdae_sim *sim;
  nsdae_record r;
  nsdae_sim_options options;
  /* ---- T = R^T J R, omega = R^T spin; in space omega = P spin, velocity = -omega x arm */
  matrix(turn, R);
  matrix(half, P);
  for (int i = 0; i < 3; i++)
    for (int k = 0; k < 3; k++) {
      body.inertia[i] += R[k][i] * principal[k] * R[k][i];
      body.spin[i] += R[k][i] * spin[k];
      body.product[0] += i == 0 ? R[k][0] * principal[k] * R[k][1] : 0;
      body.product[1] += i == 0 ? R[k][0] * principal[k] * R[k][2] : 0;
      body.product[2] += i == 0 ? R[k][1] * principal[k] * R[k][2] : 0;
    }
  multiply(half, turn, body.quaternion);
  for (int i = 0; i < 3; i++) arm[i] = P[i][0] * spin[0] + P[i][1] * spin[1] + P[i][2] * spin[2];
  body.velocity[0] = -(arm[1] * pin[2] - arm[2] * pin[1]);
  body.velocity[1] = -(arm[2] * pin[0] - arm[0] * pin[2]);
  body.velocity[2] = -(arm[0] * pin[1] - arm[1] * pin[0]);
  assert_int_equal(nsdae_bodies_create(3, &b, NULL), NSDAE_OK);
  nsdae_bodies_set_gravity(b, (const double[]){0, 0, -9.81});
  nsdae_bodies_add(b, &body);
  nsdae_bodies_add_joint(b, &(nsdae_joint){.kind = NSDAE_JOINT_SPHERICAL,
                                           .body = {NSDAE_GROUND, 0},
                                           .point = {pin[0], pin[1], pin[2]}});
  assert_true(nsdae_bodies_system(b, &system) >= 0);
  nsdae_bodies_get_start(b, q, v);
  nsdae_sim_options_default(&options);
  options.method = method;
  options.dt = dt;
  options.rtol = 1e-11, options.atol = 1e-13;
  int status = nsdae_sim_create(system, &options, &sim, NULL);
  if (status == NSDAE_OK) {
    assert_true(nsdae_sim_init(sim, 0, q, v) >= 0);
    assert_true(nsdae_sim_run(sim, 1) >= 0);
    nsdae_sim_get_record(sim, &r);
    for (int i = 0; i < 3; i++) x[i] = r.q[i];
    x[3] = r.certificate.energy;
    nsdae_sim_destroy(&sim);
  } else
    assert_int_equal(status, NSDAE_E_UNSUPPORTED); /* event needs SUNDIALS */
  nsdae_system_destroy(&system);
  nsdae_bodies_destroy(&b);
}

static void test_same_motion(void **state)
{
  static const struct {
    int method;
    double dt, bound;
  } runs[] = {{NSDAE_METHOD_EVENT, 0.01, 1e-8}, {NSDAE_METHOD_IMPLICIT, 0.002, 1e-8}};
  (void)state;
  for (int m = 0; m < 2; m++) {
    double expected[4] = {0}, x[4] = {0};
    swing((const double[]){1, 0, 0, 0}, runs[m].method, runs[m].dt, expected);
    for (int i = 0; i < 5; i++) {
      double turn[4], length = 0;
      for (int j = 0; j < 4; j++) length = hypot(length, turn[j] = uniform(-1, 1));
      for (int j = 0; j < 4; j++) turn[j] /= length;
      swing(turn, runs[m].method, runs[m].dt, x);
      for (int j = 0; j < 4; j++) assert_near(x[j], expected[j], runs[m].bound);
    }
  }
}

/* ---- what is taken */

static int add(double T[3][3])
{
  nsdae_bodies *b;
  assert_int_equal(nsdae_bodies_create(3, &b, NULL), NSDAE_OK);
  int status = nsdae_bodies_add(b, &(nsdae_rigid_body){.mass = 1,
                                                       .inertia = {T[0][0], T[1][1], T[2][2]},
                                                       .product = {T[0][1], T[0][2], T[1][2]}});
  nsdae_bodies_destroy(&b);
  return status;
}

/* Five masses in space, or in a plane through 0: the largest moment is the sum of the others. What
 * is added along an axis u, c u u^T, is beyond it if c is above 2 int (r . u)^2 dm. */
static void test_masses(void **state)
{
  (void)state;
  for (int number = 0; number < 200; number++) {
    double T[3][3] = {{0}}, n[3], across = 0, length = 0;
    int flat = number % 2;
    for (int j = 0; j < 3; j++) length = hypot(length, n[j] = uniform(-1, 1));
    for (int i = 0; i < 5; i++) {
      double r[3], m = uniform(0.1, 1), along = 0;
      for (int j = 0; j < 3; j++) along += (r[j] = uniform(-1, 1)) * n[j] / length;
      for (int j = 0; j < 3 && flat; j++) r[j] -= along * n[j] / length;
      if (!flat) across += m * along * along;
      for (int j = 0; j < 9; j++)
        T[j / 3][j % 3] +=
            m * ((j % 4 == 0) * (r[0] * r[0] + r[1] * r[1] + r[2] * r[2]) - r[j / 3] * r[j % 3]);
    }
    assert_int_equal(add(T), 0);
    double most = 2 * across + 0.01;
    for (int j = 0; j < 9; j++) T[j / 3][j % 3] += most * n[j / 3] * n[j % 3] / (length * length);
    assert_int_equal(add(T), NSDAE_E_ARGUMENT);
  }
  assert_int_equal(add((double[3][3]){{1, 2, 0}, {2, 1, 0}, {0, 0, 1}}), NSDAE_E_ARGUMENT);
  assert_int_equal(add((double[3][3]){{1, NAN, 0}, {0, 1, 0}, {0, 0, 1}}), NSDAE_E_NONFINITE);
}

int main(void)
{
  const struct CMUnitTest tests[] = {cmocka_unit_test(test_same_motion),
                                     cmocka_unit_test(test_masses)};
  return cmocka_run_group_tests(tests, NULL, NULL);
}
