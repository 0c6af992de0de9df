/* Which starts are taken, what puts one right, and that what touches starts closed. */
#include "check.h"

#include "rods.h"
#include "support/random.h"

static nsdae_sim *make(nsdae_system *system, int method, double start_tol)
{
  nsdae_sim_options options;
  nsdae_sim *sim = NULL;
  nsdae_sim_options_default(&options);
  options.method = method;
  if (start_tol > 0) options.start_tol = start_tol;
  assert_int_equal(nsdae_sim_create(system, &options, &sim, NULL), NSDAE_OK);
  return sim;
}

static void refused(nsdae_sim *sim, const double *q, const double *v, const char *argument,
                    const char *named, int index)
{
  assert_int_equal(nsdae_sim_init(sim, 0, q, v), NSDAE_E_ARGUMENT);
  const nsdae_error *error = nsdae_sim_error(sim);
  assert_string_equal(error->argument, argument);
  assert_int_equal(error->index, index);
  assert_non_null(strstr(error->text, named));
  assert_non_null(strstr(error->text, "nsdae_sim_project"));
  assert_int_equal(nsdae_sim_step(sim), NSDAE_E_STATE); /* nothing was started */
}

/* Each row just inside its bound and just outside: 1e-6 (1 + |row| max |q|), by hand. */
static void test_bounds(void **state)
{
  (void)state;
  const double theta = 0.7, tol = 1e-6;
  rod r = {.wall = 0};
  nsdae_system *system = rod_system(&r);
  nsdae_sim *sim = make(system, NSDAE_METHOD_IMPLICIT, 0);
  double q[3], v[3], row[2] = {1 + cos(theta) / 2, 1 + sin(theta) / 2};
  for (int i = 0; i < 2; i++)
    for (int sign = -1; sign <= 1; sign += 2) {
      rod_start(theta, 2, q, v);
      double bound = tol * (1 + row[i] * theta), at = q[i];
      q[i] = at + sign * 0.99 * bound;
      assert_int_equal(nsdae_sim_init(sim, 0, q, v), NSDAE_OK);
      q[i] = at + sign * 1.01 * bound;
      refused(sim, q, v, "q0", i ? "constraint 1 \"pivot_y\"" : "constraint 0 \"pivot_x\"", i);
      rod_start(theta, 2, q, v);
      bound = tol * (1 + row[i] * 2);
      at = v[i];
      v[i] = at + sign * 0.99 * bound;
      assert_int_equal(nsdae_sim_init(sim, 0, q, v), NSDAE_OK);
      v[i] = at + sign * 1.01 * bound;
      refused(sim, q, v, "v0", i ? "constraint 1 \"pivot_y\"" : "constraint 0 \"pivot_x\"", i);
    }
  nsdae_sim_destroy(&sim);
  sim = make(system, NSDAE_METHOD_EVENT, 0);
  for (int j = 0; j < 2; j++) {
    double overlap = tol * (1 + theta * cos(theta)) * (j ? 1.01 : 0.99);
    rod_start(theta, 0, q, v);
    r.wall = sin(theta) + overlap;
    if (j == 0) assert_int_equal(nsdae_sim_init(sim, 0, q, v), NSDAE_OK);
    if (j == 1) refused(sim, q, v, "q0", "contact 0 \"stop\" overlaps by", 0);
  }
  nsdae_sim_destroy(&sim);
  nsdae_system_destroy(&system);
}

/* With start_tol 1e300 all is taken; penalty's contacts may overlap. */
static void test_taken(void **state)
{
  (void)state;
  rod r = {.wall = 0.1};
  nsdae_system *system = rod_system(&r);
  double q[3], v[3];
  rod_start(0, 0, q, v);
  nsdae_sim *sim = make(system, NSDAE_METHOD_MOREAU, 1e300);
  assert_int_equal(nsdae_sim_init(sim, 0, q, v), NSDAE_OK);
  q[0] += 1;
  assert_int_equal(nsdae_sim_init(sim, 0, q, v), NSDAE_OK);
  nsdae_sim_destroy(&sim);
  nsdae_sim_options options;
  nsdae_sim_options_default(&options);
  options.method = NSDAE_METHOD_PENALTY;
  if (nsdae_sim_create(system, &options, &sim, NULL) == NSDAE_OK) {
    q[0] -= 1;
    assert_int_equal(nsdae_sim_init(sim, 0, q, v), NSDAE_OK);
    nsdae_sim_destroy(&sim);
  }
  nsdae_system_destroy(&system);
}

/* Random starts of the rod, up to 0.3 off and inside the stop: put right they satisfy all to
 * rounding, have changed about as little as they were off, and v by the least: M (v - v0) =
 * -Phi_q^T l.
 */
static void test_put_right(void **state)
{
  (void)state;
  rod r = {.wall = 0};
  nsdae_system *system = rod_system(&r);
  nsdae_sim *sim = make(system, NSDAE_METHOD_IMPLICIT, 2e-14);
  uint64_t seed = 12345;
  for (int i = 0; i < 200; i++) {
    double q[3], v[3], q1[3], v1[3], off = 0, changed = 0;
    rod_start(0.5 * sin(i), 3 * cos(2 * i), q, v);
    for (int j = 0; j < 3; j++) {
      q[j] += 0.6 * (random_uniform(&seed) - 0.5);
      v[j] += 2 * (random_uniform(&seed) - 0.5);
    }
    memcpy(q1, q, sizeof q);
    memcpy(v1, v, sizeof v);
    assert_int_equal(nsdae_sim_project(sim, 0, q1, v1), NSDAE_OK);
    double c = cos(q1[2]), s = sin(q1[2]);
    assert_near(q1[0], s / 2, 8e-15); /* 16 eps (1 + |row| |q|), the rounding that ends it */
    assert_near(q1[1], -c / 2, 8e-15);
    assert_true(s >= -8e-15);
    assert_near(v1[0], c / 2 * v1[2], 1e-14);
    assert_near(v1[1], s / 2 * v1[2], 1e-14);
    /* along the free direction (c/2, s/2, 1) nothing was changed */
    assert_near(c / 2 * (v1[0] - v[0]) + s / 2 * (v1[1] - v[1]) + (v1[2] - v[2]) / 12, 0, 1e-13);
    off = fabs(q[0] - sin(q[2]) / 2) + fabs(q[1] + cos(q[2]) / 2) + fmax(0, -sin(q[2]));
    for (int j = 0; j < 3; j++) changed = fmax(changed, fabs(q1[j] - q[j]));
    assert_at_most(changed, 3 * off + 1e-15);
    assert_int_equal(nsdae_sim_init(sim, 0, q1, v1), NSDAE_OK);
    /* what is right is left alone, to rounding */
    memcpy(q, q1, sizeof q);
    assert_int_equal(nsdae_sim_project(sim, 0, q, v1), NSDAE_OK);
    for (int j = 0; j < 3; j++) assert_near(q[j], q1[j], 8e-15);
  }
  nsdae_sim_destroy(&sim);
  nsdae_system_destroy(&system);
}

/* ---- a disc of radius 1 among walls: q = (x, y), gaps of lines n.q - d */

enum { WALLS = 4 };

typedef struct walls {
  double n[WALLS][2], d[WALLS];
} walls;

static int mass(double t, const double *q, double *M, int ldm, void *user)
{
  (void)t, (void)q, (void)user;
  M[0] = 1;
  M[ldm + 1] = 4;
  return 0;
}

static int force(double t, const double *q, const double *v, double *F, void *user)
{
  (void)t, (void)q, (void)v, (void)user;
  F[1] = -9.81 * 4;
  return 0;
}

static int gap(double t, const double *q, double *g, void *user)
{
  const walls *w = user;
  (void)t;
  for (int i = 0; i < WALLS; i++) g[i] = w->n[i][0] * q[0] + w->n[i][1] * q[1] - w->d[i];
  return 0;
}

static nsdae_system *disc(walls *w)
{
  const nsdae_dims dims = {.nq = 2, .k = WALLS};
  nsdae_system *s = NULL;
  nsdae_system_create(&dims, &s, NULL);
  nsdae_system_set_user(s, w);
  nsdae_system_set_mass(s, mass);
  nsdae_system_set_force(s, force);
  nsdae_system_set_gap(s, gap);
  return s;
}

/* Least change in the metric of M (1, 4): beside brute force over which walls touch. Walls that
 * say the same (0 and 1) and one that another's correction frees (2). */
static void test_least_change_among_walls(void **state)
{
  (void)state;
  walls w = {{{0, 1}, {0, 1}, {0.6, 0.8}, {1, 0}}, {0, -0.1, -0.05, -10}};
  nsdae_system *system = disc(&w);
  nsdae_sim *sim = make(system, NSDAE_METHOD_MOREAU, 0);
  for (int i = 0; i < 100; i++) {
    double q0[2] = {0.5 * sin(3 * i), -0.5 * fabs(cos(5 * i))}, q[2] = {q0[0], q0[1]}, v[2] = {0};
    double best = INFINITY;
    assert_int_equal(nsdae_sim_project(sim, 0, q, v), NSDAE_OK);
    for (int a = -1; a < WALLS; a++)
      for (int b = -1; b < WALLS; b++) { /* no wall, one, or the corner of two */
        double p[2] = {q0[0], q0[1]}, inside = 0, g[WALLS];
        if (a >= 0 && b < 0) {
          double l = -(w.n[a][0] * q0[0] + w.n[a][1] * q0[1] - w.d[a]) /
                     (w.n[a][0] * w.n[a][0] + w.n[a][1] * w.n[a][1] / 4);
          p[0] += l * w.n[a][0];
          p[1] += l * w.n[a][1] / 4;
        } else if (a >= 0) {
          double det = w.n[a][0] * w.n[b][1] - w.n[a][1] * w.n[b][0];
          if (fabs(det) < 1e-9) continue;
          p[0] = (w.d[a] * w.n[b][1] - w.d[b] * w.n[a][1]) / det;
          p[1] = (w.d[b] * w.n[a][0] - w.d[a] * w.n[b][0]) / det;
        }
        gap(0, p, g, &w);
        for (int j = 0; j < WALLS; j++) inside = fmax(inside, -g[j]);
        double cost = (p[0] - q0[0]) * (p[0] - q0[0]) + 4 * (p[1] - q0[1]) * (p[1] - q0[1]);
        if (inside < 1e-12) best = fmin(best, cost);
      }
    double g[WALLS];
    gap(0, q, g, &w);
    for (int j = 0; j < WALLS; j++) assert_true(g[j] >= -1e-14);
    assert_near((q[0] - q0[0]) * (q[0] - q0[0]) + 4 * (q[1] - q0[1]) * (q[1] - q0[1]), best, 1e-12);
  }
  nsdae_sim_destroy(&sim);
  nsdae_system_destroy(&system);
}

/* Two walls that leave no room: said, with the wall, and nothing is changed. */
static void test_no_room(void **state)
{
  (void)state;
  walls w = {{{0, 1}, {0, -1}, {1, 0}, {1, 0}}, {0, 0.5, -10, -10}};
  nsdae_system *system = disc(&w);
  nsdae_sim *sim = make(system, NSDAE_METHOD_MOREAU, 0);
  double q[2] = {0.1, 0.2}, v[2] = {0.3, 0.4};
  assert_int_equal(nsdae_sim_project(sim, 0, q, v), NSDAE_E_CONVERGENCE);
  assert_non_null(strstr(nsdae_sim_error(sim)->text, "contact "));
  assert_true(q[0] == 0.1 && q[1] == 0.2 && v[0] == 0.3 && v[1] == 0.4);
  nsdae_sim_destroy(&sim);
  nsdae_system_destroy(&system);
}

/* A quaternion that is not of length one: refused, and put right along itself. */
static void test_quaternion(void **state)
{
  (void)state;
  nsdae_system *system = body_system();
  nsdae_sim *sim = make(system, NSDAE_METHOD_IMPLICIT, 0);
  double q[7] = {0, 0, 5, 0.5, -0.5, 0.5, 0.5}, v[6] = {1, 2, 3, 4, 5, 6};
  assert_int_equal(nsdae_sim_init(sim, 0, q, v), NSDAE_OK);
  for (int i = 3; i < 7; i++) q[i] *= 1 + 0.9e-6;
  assert_int_equal(nsdae_sim_init(sim, 0, q, v), NSDAE_OK);
  for (int i = 3; i < 7; i++) q[i] *= 2;
  refused(sim, q, v, "q0", "unit length", 3);
  assert_int_equal(nsdae_sim_project(sim, 0, q, v), NSDAE_OK);
  for (int i = 3; i < 7; i++) assert_near(q[i], i == 4 ? -0.5 : 0.5, 2e-16);
  assert_int_equal(nsdae_sim_init(sim, 0, q, v), NSDAE_OK);
  q[3] = 1, q[4] = q[5] = q[6] = 0; /* where half of dq/dt is zero */
  assert_int_equal(nsdae_sim_init(sim, 0, q, v), NSDAE_OK);
  q[3] = 1.001;
  refused(sim, q, v, "q0", "unit length", 3);
  nsdae_sim_destroy(&sim);
  nsdae_system_destroy(&system);
}

/* What the user gives wrongly. */
typedef struct mistake {
  double sign;  /* of the Jacobian */
  double omega; /* the part of it */
} mistake;

/* A bead on the unit circle, K (1 - x^2 - y^2) = 0, so that omega = -2 K |v|^2. */
enum { STEEP = 100 };

static int circle_mass(double t, const double *q, double *M, int ldm, void *user)
{
  (void)t, (void)q, (void)user;
  M[0] = M[ldm + 1] = 1;
  return 0;
}

static int no_force(double t, const double *q, const double *v, double *F, void *user)
{
  (void)t, (void)q, (void)v, (void)F, (void)user;
  return 0;
}

static int circle(double t, const double *q, double *phi, void *user)
{
  (void)t, (void)user;
  phi[0] = STEEP * (1 - q[0] * q[0] - q[1] * q[1]);
  return 0;
}

static int circle_jacobian(double t, const double *q, double *J, int ldj, void *user)
{
  const mistake *wrong = user;
  (void)t;
  for (int i = 0; i < 2; i++) J[i * ldj] = -2 * STEEP * q[i] * wrong->sign;
  return 0;
}

static int circle_bias(double t, const double *q, const double *v, double *phi_t, double *omega,
                       void *user)
{
  const mistake *wrong = user;
  (void)t, (void)q;
  phi_t[0] = 0;
  omega[0] = -2 * STEEP * (v[0] * v[0] + v[1] * v[1]) * (1 + wrong->omega);
  return 0;
}

/* A start looks for gross errors alone, as a Jacobian of the other sign or half the size: an
 * acceleration may be off by 1e-3, whatever its sign. The bound of the sum of both sizes and of the
 * rounding of finer steps is 4e-3 of this one. */
static void test_derivatives(void **state)
{
  (void)state;
  const nsdae_dims dims = {.nq = 2, .m = 1};
  const double q[2] = {0.6, 0.8}, v[2] = {0}, taken[] = {0, 1e-4, -1e-4, 1e-3, -1e-3},
               not_taken[] = {1e-2, -1e-2, -1, -2};
  mistake wrong = {.sign = 1};
  nsdae_system *system;
  assert_int_equal(nsdae_system_create(&dims, &system, NULL), NSDAE_OK);
  nsdae_system_set_user(system, &wrong);
  nsdae_system_set_mass(system, circle_mass);
  nsdae_system_set_force(system, no_force);
  nsdae_system_set_constraint(system, circle);
  nsdae_system_set_constraint_jacobian(system, circle_jacobian);
  nsdae_system_set_constraint_bias(system, circle_bias);
  nsdae_sim *sim = make(system, NSDAE_METHOD_IMPLICIT, 0);
  for (int i = 0; i < 5; i++) {
    wrong.omega = taken[i];
    assert_int_equal(nsdae_sim_init(sim, 0, q, v), NSDAE_OK);
  }
  for (int i = 0; i < 4; i++) {
    wrong.omega = not_taken[i];
    assert_int_equal(nsdae_sim_init(sim, 0, q, v), NSDAE_E_DERIVATIVE);
    assert_string_equal(nsdae_sim_error(sim)->argument, "constraint_bias");
  }
  for (wrong = (mistake){.sign = -1}; wrong.sign < 1; wrong.sign += 1.5) {
    assert_int_equal(nsdae_sim_init(sim, 0, q, v), NSDAE_E_DERIVATIVE);
    assert_string_equal(nsdae_sim_error(sim)->argument, "constraint_jacobian");
  }
  nsdae_sim_destroy(&sim);
  nsdae_system_destroy(&system);
}

/* What is no state is refused like a start, and an empty handle says so. */
static void test_arguments(void **state)
{
  (void)state;
  nsdae_system *system = body_system();
  nsdae_sim *sim = make(system, NSDAE_METHOD_IMPLICIT, 0);
  double q[7] = {0, 0, 5, 1}, v[6] = {0};
  assert_int_equal(nsdae_sim_project(NULL, 0, q, v), NSDAE_E_ARGUMENT);
  assert_int_equal(nsdae_sim_project(sim, 0, NULL, v), NSDAE_E_ARGUMENT);
  assert_int_equal(nsdae_sim_project(sim, 0, q, NULL), NSDAE_E_ARGUMENT);
  assert_int_equal(nsdae_sim_project(sim, NAN, q, v), NSDAE_E_NONFINITE);
  q[1] = INFINITY;
  assert_int_equal(nsdae_sim_project(sim, 0, q, v), NSDAE_E_NONFINITE);
  assert_int_equal(nsdae_sim_error(sim)->index, 1);
  nsdae_sim_destroy(&sim);
  nsdae_system_destroy(&system);
}

/* A disc that lies on the floor, whose gap is a rounding above zero or below: every method takes it
 * as closed from the first step, so that it does not fall. */
static void test_touching_is_closed(void **state)
{
  (void)state;
  const double rounding[] = {0, 5.6e-17, 1e-17, -5.6e-17, 4e-16};
  for (int method = 0; nsdae_method_name(method); method++)
    for (int i = 0; i < 5; i++) {
      walls w = {{{0, 1}, {1, 0}, {1, 0}, {1, 0}}, {0.3, -10, -10, -10}};
      nsdae_system *system = disc(&w);
      nsdae_sim_options options;
      nsdae_sim *sim = NULL;
      nsdae_stats stats;
      double q[2] = {0, 0.3}, v[2] = {0};
      w.d[0] = 0.3 - rounding[i];
      if (w.d[0] == 0.3 && rounding[i] != 0) q[1] = 0.3 + (rounding[i] > 0 ? 5.6e-17 : -5.6e-17);
      nsdae_sim_options_default(&options);
      options.method = method;
      options.dt = 2e-3;
      if (nsdae_sim_create(system, &options, &sim, NULL) == NSDAE_OK) {
        assert_int_equal(nsdae_sim_init(sim, 0, q, v), NSDAE_OK);
        assert_true(nsdae_sim_run(sim, 0.2) >= 0);
        nsdae_sim_get_stats(sim, &stats);
        /* rigid: rounding; penalty: (m g / K)^(2/3) = 5.4e-5 m */
        assert_at_most(stats.worst_penetration, method == NSDAE_METHOD_PENALTY ? 2e-4 : 1e-13);
        assert_int_equal(stats.impacts, 0);
        nsdae_sim_destroy(&sim);
      }
      nsdae_system_destroy(&system);
    }
}

int main(void)
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(test_bounds),
      cmocka_unit_test(test_taken),
      cmocka_unit_test(test_put_right),
      cmocka_unit_test(test_least_change_among_walls),
      cmocka_unit_test(test_no_room),
      cmocka_unit_test(test_quaternion),
      cmocka_unit_test(test_derivatives),
      cmocka_unit_test(test_arguments),
      cmocka_unit_test(test_touching_is_closed),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
