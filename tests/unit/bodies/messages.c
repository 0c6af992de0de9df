/* Mistakes and steps that are too long name their cause: the stiffest spring with w dt and the dt
 * that it needs, a model in which nothing moves, a constraint without a gradient. */
#include "check.h"

#include <nsdae/nsdae.h>

#include "support/hung_bodies.h"

static const int stepping[] = {NSDAE_METHOD_IMPLICIT, NSDAE_METHOD_MOREAU};

typedef struct outcome {
  int status, index;
  char text[256];
} outcome;

static outcome run_steps(nsdae_bodies *b, int method, double dt, int steps)
{
  nsdae_system *system;
  nsdae_sim *sim;
  nsdae_sim_options o;
  double q[NQ_MAX], v[NV_MAX];
  outcome is = {0};
  if (nsdae_bodies_system(b, &system) != NSDAE_OK) fail_msg("%s", nsdae_bodies_error(b)->text);
  nsdae_bodies_get_start(b, q, v);
  nsdae_sim_options_default(&o);
  o.method = method;
  o.dt = dt;
  assert_int_equal(nsdae_sim_create(system, &o, &sim, NULL), NSDAE_OK);
  is.status = nsdae_sim_init(sim, 0, q, v);
  for (int i = 0; i < steps && is.status == NSDAE_OK; i++) is.status = nsdae_sim_step(sim);
  is.index = nsdae_sim_error(sim)->index;
  snprintf(is.text, sizeof is.text, "%s", nsdae_sim_error(sim)->text);
  nsdae_sim_destroy(&sim);
  nsdae_system_destroy(&system);
  nsdae_bodies_destroy(&b);
  return is;
}

/* A mass on two springs, of which the second has w h = turn, or a damper of c h / m = brake. */
static nsdae_bodies *sprung(int d, double h, double turn, double brake)
{
  const double mass = 0.7;
  nsdae_bodies *b = create(d, 0, d == 2 ? -9.81 : 0, d == 3 ? -9.81 : 0);
  nsdae_rigid_body body = {.mass = mass, .inertia = {0.01, 0.01, 0.01}};
  if (d == 2) body.inertia[0] = body.inertia[1] = 0;
  assert_int_equal(nsdae_bodies_add(b, &body), 0);
  for (int i = 0; i < 2; i++) {
    nsdae_spring s = {.body = {NSDAE_GROUND, 0}, .rest = 1};
    s.point[i == 0 ? 0 : d - 1] = 1; /* its end is the centre */
    s.stiffness = i == 0 ? 1 : mass * turn * turn / (h * h);
    s.damping = i == 0 ? 0 : mass * brake / h;
    assert_int_equal(nsdae_bodies_add_spring(b, &s), i);
  }
  return b;
}

static void test_stiff_spring(void **state)
{
  const double h = 4e-3;
  (void)state;
  for (int d = 2; d <= 3; d++)
    for (int m = 0; m < 2; m++) {
      outcome is = run_steps(sprung(d, h, 3.2, 0), stepping[m], h, 100);
      assert_true(is.status != NSDAE_OK && is.index == 1);
      assert_non_null(strstr(is.text, "spring 1 of body 0 and the ground has w dt = 3.2, above 2: "
                                      "make dt smaller than 0.0025, or use method = event"));
      is = run_steps(sprung(d, h, 0.1, 5), stepping[m], h, 100);
      assert_true(is.status != NSDAE_OK && is.index == 1);
      assert_non_null(strstr(is.text, "has c dt / m = 5, above 2: make dt smaller than 0.0016"));
      /* half of the dt that is named is stable, and nothing names the spring */
      is = run_steps(sprung(d, h, 3.2, 0), stepping[m], h / 3.2, 100);
      assert_null(strstr(is.text, "w dt"));
      assert_true(is.status >= 0);
    }
  outcome is = run_steps(sprung(2, h, 3.2, 0), NSDAE_METHOD_EVENT, h, 100);
  assert_int_equal(is.status, NSDAE_OK);
}

/* Without gravity, force, drive and velocity: said once, and with any of them not. */
static void test_nothing_moves(void **state)
{
  (void)state;
  for (int d = 2; d <= 3; d++)
    for (int with = 0; with < 4; with++) {
      nsdae_bodies *b = create(d, 0, with == 1 ? -9.81 : 0, 0);
      nsdae_rigid_body body = {.mass = 1, .inertia = {0, 0, 1}};
      if (d == 3) body.inertia[0] = body.inertia[1] = 1;
      if (with == 2) body.velocity[0] = 1e-3;
      nsdae_bodies_add(b, &body);
      if (with == 3)
        nsdae_bodies_add_spring(
            b, &(nsdae_spring){.body = {NSDAE_GROUND, 0}, .point = {1}, .stiffness = 1, .rest = 1});
      if (d == 3 && with == 1) { /* along y in space is another warning */
        nsdae_bodies_destroy(&b);
        continue;
      }
      outcome is = run_steps(b, NSDAE_METHOD_IMPLICIT, 0.01, 2);
      assert_int_equal(is.status, with == 0 ? NSDAE_WARN_MODEL : NSDAE_OK);
      assert_int_equal(strstr(is.text, "nothing moves: gravity is 0") != NULL, with == 0);
    }
}

/* ---- Phi = (q . q - 1)^2, a pendulum that has no gradient */

static int unit_mass(double t, const double *q, double *M, int ldm, void *user)
{
  (void)t, (void)q, (void)user;
  M[0] = M[ldm + 1] = 1;
  return 0;
}

static int weight(double t, const double *q, const double *v, double *F, void *user)
{
  (void)t, (void)q, (void)v, (void)user;
  F[1] = -9.81;
  return 0;
}

static int square(double t, const double *q, double *phi, void *user)
{
  double g = q[0] * q[0] + q[1] * q[1] - 1;
  (void)t;
  phi[0] = *(const int *)user ? g * g : g;
  return 0;
}

static int square_jacobian(double t, const double *q, double *J, int ldj, void *user)
{
  double g = q[0] * q[0] + q[1] * q[1] - 1;
  (void)t;
  for (int j = 0; j < 2; j++) J[j * ldj] = *(const int *)user ? 4 * g * q[j] : 2 * q[j];
  return 0;
}

static void test_no_gradient(void **state)
{
  const nsdae_dims dims = {.nq = 2, .nv = 2, .m = 1};
  const double q[] = {1, 0}, v[] = {0, 0};
  (void)state;
  for (int squared = 0; squared < 2; squared++)
    for (int given = 0; given < 2; given++) {
      nsdae_system *system;
      nsdae_sim *sim;
      nsdae_sim_options o;
      assert_int_equal(nsdae_system_create(&dims, &system, NULL), NSDAE_OK);
      nsdae_system_set_user(system, &squared);
      nsdae_system_set_mass(system, unit_mass);
      nsdae_system_set_force(system, weight);
      nsdae_system_set_constraint(system, square);
      if (given) nsdae_system_set_constraint_jacobian(system, square_jacobian);
      nsdae_sim_options_default(&o);
      assert_int_equal(nsdae_sim_create(system, &o, &sim, NULL), NSDAE_OK);
      int status = nsdae_sim_init(sim, 0, q, v);
      assert_int_equal(status, squared ? NSDAE_E_RANK : NSDAE_OK);
      if (squared) {
        assert_non_null(strstr(nsdae_sim_error(sim)->text, "square of a constraint"));
        assert_int_equal(nsdae_sim_error(sim)->index, 0);
      }
      nsdae_sim_destroy(&sim);
      nsdae_system_destroy(&system);
    }
}

int main(void)
{
  const struct CMUnitTest tests[] = {cmocka_unit_test(test_stiff_spring),
                                     cmocka_unit_test(test_nothing_moves),
                                     cmocka_unit_test(test_no_gradient)};
  return cmocka_run_group_tests(tests, NULL, NULL);
}
