/* D = -dF/dv and K = -(dF/dq) H of the kit: random mechanisms of springs, dampers, torsions, loads
 * and spinning bodies against central differences of F, at states that no joint allows. */
#include "check.h"

#include <nsdae/nsdae.h>

#include "support/random.h"

enum { SEEDS = 60, STATES = 4, BODIES_MOST = 5 };

static int load(double t, const double x[3], const double u[3], double force[3], double torque[3],
                void *user)
{
  (void)user;
  force[0] = -x[0] * x[0] * x[0] + u[1] * sin(t + u[0]);
  force[1] = x[0] * u[1] - 3 * u[0];
  force[2] = cos(x[1]) * u[2];
  torque[0] = x[1] * u[2];
  torque[1] = u[0] * u[1];
  torque[2] = sin(x[0]) + u[0] * u[0];
  return 0;
}

static void numbers(random_state *r, double scale, double *x, int count)
{
  for (int i = 0; i < count; i++) x[i] = scale * random_number(r);
}

static void two_bodies(random_state *r, int bodies, int body[2])
{
  body[0] = random_int(r, -1, bodies - 1); /* NSDAE_GROUND is -1 */
  do body[1] = random_int(r, -1, bodies - 1);
  while (body[1] == body[0]);
}

/* with: 1 springs, 2 torsions, 4 loads */
static nsdae_bodies *draw(random_state *r, int dimension, int with)
{
  nsdae_bodies *b;
  assert_int_equal(nsdae_bodies_create(dimension, &b, NULL), NSDAE_OK);
  int bodies = random_int(r, 1, BODIES_MOST), plane = dimension == 2;
  const double gravity[3] = {0.3, -9.81, 0};
  nsdae_bodies_set_gravity(b, gravity);
  nsdae_bodies_set_pair(b, 0, 0, 0.3, 0, 0);
  for (int i = 0; i < bodies; i++) {
    nsdae_rigid_body body = {.mass = 2 + random_number(r)};
    for (int j = 0; j < 3; j++) body.inertia[j] = 3 + random_number(r) / 2;
    numbers(r, 2, body.position, plane ? 2 : 3);
    body.angle = plane ? random_number(r) : 0;
    numbers(r, plane ? 0 : 1, body.quaternion, 4);
    assert_true(nsdae_bodies_add(b, &body) >= 0);
  }
  for (int i = 0; i < 4; i++) {
    nsdae_spring spring = {.stiffness = 60 + 50 * random_number(r), .rest = 1};
    nsdae_torsion torsion = {.stiffness = 60 + 50 * random_number(r), .rest = random_number(r)};
    double point[3] = {0};
    spring.damping = torsion.damping = i > 0 ? 5 + 5 * random_number(r) : 0;
    if (i == 1) spring.stiffness = torsion.stiffness = 0;
    two_bodies(r, bodies, spring.body), two_bodies(r, bodies, torsion.body);
    numbers(r, 2, spring.point, dimension), numbers(r, 2, spring.end, dimension);
    spring.end[0] += 8; /* no spring is so short that differences have its curvature 1 / l^2 */
    numbers(r, 2, point, dimension), numbers(r, plane ? 0 : 1, torsion.axis, 3);
    if (with & 1) assert_true(nsdae_bodies_add_spring(b, &spring) >= 0);
    if (with & 2) assert_true(nsdae_bodies_add_torsion(b, &torsion) >= 0);
    if (with & 4)
      assert_true(nsdae_bodies_add_load(b, random_int(r, 0, bodies - 1), point, load, NULL) >= 0);
  }
  return b;
}

/* Values of F up to 1e3 with derivatives of the same size: central differences have
 * eps F / eps^(1/3) and eps^(2/3) F''', some 1e-8 of 1 + |entry|. */
static void test_formulas(void **state)
{
  (void)state;
  for (int seed = 0; seed < SEEDS; seed++)
    for (int dimension = 2; dimension <= 3; dimension++)
      for (int with = 0; with < 8; with++) {
        random_state r = {(uint64_t)(seed * 16 + dimension * 8 + with)};
        nsdae_bodies *b = draw(&r, dimension, with);
        nsdae_system *s;
        nsdae_dims dims;
        nsdae_check worst;
        double q[7 * BODIES_MOST], v[6 * BODIES_MOST];
        assert_true(nsdae_bodies_system(b, &s) >= 0);
        nsdae_system_get_dims(s, &dims);
        for (int i = 0; i < STATES; i++) {
          assert_int_equal(nsdae_bodies_get_start(b, q, v), NSDAE_OK);
          /* off the joints, but no axis is along the hand of its torsion, where the angle jumps */
          for (int j = 0; j < dims.nq; j++) q[j] += random_number(&r) / 8;
          numbers(&r, 3, v, dims.nv);
          if (nsdae_system_check(s, 0.3, q, v, 1e-7, &worst) < 0)
            print_error("seed %d, dimension %d, with %d: %s\n", seed, dimension, with,
                        nsdae_system_error(s)->text);
          assert_at_most(worst.error, 1e-7);
        }
        nsdae_system_destroy(&s);
        nsdae_bodies_destroy(&b);
      }
}

/* The code of a load comes out as that of the callback. */
static int fails(double t, const double x[3], const double u[3], double force[3], double torque[3],
                 void *user)
{
  int *calls = user;
  (void)t, (void)x, (void)u, (void)force, (void)torque;
  return --*calls < 0 ? 5 : 0;
}

static void test_load_fails(void **state)
{
  (void)state;
  random_state r = {1};
  int calls = 1 << 30;
  nsdae_bodies *b = draw(&r, 3, 7);
  const double centre[3] = {0};
  nsdae_system *s;
  double q[7 * BODIES_MOST], v[6 * BODIES_MOST];
  nsdae_bodies_add_load(b, 0, centre, fails, &calls);
  assert_true(nsdae_bodies_system(b, &s) >= 0);
  nsdae_bodies_get_start(b, q, v);
  assert_int_equal(nsdae_system_check(s, 0, q, v, 1e-5, NULL), NSDAE_OK);
  long all = (1L << 30) - calls;
  assert_true(all > 26);
  for (long at = 0; at < all; at += 1 + at / 7) {
    calls = (int)at;
    assert_int_equal(nsdae_system_check(s, 0, q, v, 1e-5, NULL), NSDAE_E_CALLBACK);
    assert_int_equal(nsdae_system_error(s)->code, 5);
  }
  nsdae_system_destroy(&s);
  nsdae_bodies_destroy(&b);
}

int main(void)
{
  const struct CMUnitTest tests[] = {cmocka_unit_test(test_formulas),
                                     cmocka_unit_test(test_load_fails)};
  return cmocka_run_group_tests(tests, NULL, NULL);
}
