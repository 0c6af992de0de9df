/* What no integrator can do: a singular mass, a constraint that cannot be satisfied, a rank that
 * changes, a force that fails, is not finite or unbounded, too many steps. By event and penalty
 * with every integrator: the status, the names and the time of the failure; the state of the step
 * before; and the same failure in a second run of the same simulation.
 *
 * A point of unit mass at q = [x, y]. The fault begins at t = 1/2. */
#include "check.h"

#include <nsdae/nsdae.h>

typedef enum fault {
  MASS_AT_START,  /* M = diag(1, 0) */
  MASS_LATER,     /* M = diag(1, 1/2 - t): not positive from then on */
  CANNOT_CLOSE,   /* a rod of length 1 about the origin, and x = 2 t: no solution for t > 1/2 */
  RANK_CHANGES,   /* y = 0 and (1 - a) y + a (x - t) = 0: a(t) falls to 0 */
  CALLBACK_FAILS, /* force returns -3 */
  NOT_FINITE,     /* force is NaN */
  UNBOUNDED,      /* x'' = x'^2, x' = 2 at the start: x' = 1 / (1/2 - t) */
  TOO_MANY_STEPS, /* more than inner_steps_max in one dt */
  FAULTS
} fault;

typedef struct expected {
  const char *name;
  int status, also;           /* one of these */
  const char *text, *or_text; /* one of these is in the text, or the velocity "y" */
  double begin, end;          /* of the time */
} expected;

/* A callback is called at most one dt after the fault begins. The rank is lost where a(t) is 1e-8,
 * the default rank_tol: 1e-3 before t = 1/2; the rod is parallel to the drive at y = 1e-8, later.
 */
static const expected expectations[FAULTS] = {
    [MASS_AT_START] = {"mass at start", NSDAE_E_MASS, NSDAE_E_MASS, "\"y\"", "\"y\"", 0, 0},
    [MASS_LATER] = {"mass later", NSDAE_E_MASS, NSDAE_E_MASS, "\"y\"", "\"y\"", 0.5, 0.61},
    [CANNOT_CLOSE] = {"cannot close", NSDAE_E_CONVERGENCE, NSDAE_E_RANK, "\"rod\"", "\"drive\"",
                      0.4, 0.51},
    [RANK_CHANGES] = {"rank changes", NSDAE_E_RANK, NSDAE_E_RANK, "\"guide\"", "\"drive\"", 0.49,
                      0.51},
    [CALLBACK_FAILS] = {"callback fails", NSDAE_E_CALLBACK, NSDAE_E_CALLBACK, "force", "force", 0.5,
                        0.61},
    [NOT_FINITE] = {"not finite", NSDAE_E_NONFINITE, NSDAE_E_NONFINITE, "force", "force", 0.5,
                    0.61},
    [UNBOUNDED] = {"unbounded", NSDAE_E_CONVERGENCE, NSDAE_E_NONFINITE, "integrator", "force", 0.4,
                   0.51},
    [TOO_MANY_STEPS] = {"too many steps", NSDAE_E_CONVERGENCE, NSDAE_E_CONVERGENCE,
                        "inner_steps_max", "inner_steps_max", 0, 0.11},
};

static int mass(double t, const double *q, double *M, int ldm, void *user)
{
  const fault f = *(const fault *)user;
  (void)q;
  M[0] = 1;
  M[ldm + 1] = f == MASS_AT_START ? 0 : f == MASS_LATER ? 0.5 - t : 1;
  return 0;
}

static int force(double t, const double *q, const double *v, double *F, void *user)
{
  const fault f = *(const fault *)user;
  (void)q;
  if (f == CALLBACK_FAILS && t > 0.5) return -3;
  if (f == NOT_FINITE && t > 0.5) F[0] = NAN;
  if (f == UNBOUNDED) F[0] = v[0] * v[0];
  return 0;
}

/* a(t): 1, then 0 from t = 1/2 on, with two continuous derivatives. */
static void fade(double t, double a[3])
{
  double s = fmax(0, 1 - 2 * t);
  a[0] = s * s * s;
  a[1] = -6 * s * s;
  a[2] = 24 * s;
}

static int constraint(double t, const double *q, double *phi, void *user)
{
  double a[3];
  fade(t, a);
  if (*(const fault *)user == CANNOT_CLOSE) {
    phi[0] = q[0] * q[0] + q[1] * q[1] - 1;
    phi[1] = q[0] - 2 * t;
  } else {
    phi[0] = q[1];
    phi[1] = (1 - a[0]) * q[1] + a[0] * (q[0] - 2 * t);
  }
  return 0;
}

static int constraint_jacobian(double t, const double *q, double *J, int ldj, void *user)
{
  double a[3];
  fade(t, a);
  if (*(const fault *)user == CANNOT_CLOSE) {
    J[0] = 2 * q[0];
    J[ldj] = 2 * q[1];
    J[1] = 1;
  } else {
    J[ldj] = 1;
    J[1] = a[0];
    J[ldj + 1] = 1 - a[0];
  }
  return 0;
}

static int constraint_bias(double t, const double *q, const double *v, double *phi_t, double *omega,
                           void *user)
{
  double a[3];
  fade(t, a);
  if (*(const fault *)user == CANNOT_CLOSE) {
    phi_t[1] = -2;
    omega[0] = 2 * (v[0] * v[0] + v[1] * v[1]);
  } else {
    phi_t[1] = a[1] * (q[0] - 2 * t - q[1]) - 2 * a[0];
    omega[1] = 2 * a[1] * (v[0] - 2 - v[1]) + a[2] * (q[0] - 2 * t - q[1]);
  }
  return 0;
}

static int constrained(fault f)
{
  return f == CANNOT_CLOSE || f == RANK_CHANGES;
}

static nsdae_system *make(fault *f)
{
  nsdae_system *system;
  const nsdae_dims dims = {.nq = 2, .m = constrained(*f) ? 2 : 0};
  assert_int_equal(nsdae_system_create(&dims, &system, NULL), NSDAE_OK);
  nsdae_system_set_user(system, f);
  nsdae_system_set_mass(system, mass);
  nsdae_system_set_force(system, force);
  nsdae_system_set_name(system, NSDAE_NAME_VELOCITY, 0, "x", "m/s");
  nsdae_system_set_name(system, NSDAE_NAME_VELOCITY, 1, "y", "m/s");
  if (!constrained(*f)) return system;
  nsdae_system_set_constraint(system, constraint);
  nsdae_system_set_constraint_jacobian(system, constraint_jacobian);
  nsdae_system_set_constraint_bias(system, constraint_bias);
  nsdae_system_set_name(system, NSDAE_NAME_CONSTRAINT, 0, *f == CANNOT_CLOSE ? "rod" : "guide",
                        "m");
  nsdae_system_set_name(system, NSDAE_NAME_CONSTRAINT, 1, "drive", "m");
  return system;
}

static int run(nsdae_sim *sim, fault f, nsdae_error *error)
{
  const double q0[] = {0, f == CANNOT_CLOSE ? 1 : 0}, v0[] = {2, 0};
  nsdae_record record;
  int status = nsdae_sim_init(sim, 0, q0, v0);
  if (status == NSDAE_OK) status = nsdae_sim_run(sim, 1);
  *error = *nsdae_sim_error(sim);
  if (status < 0 && nsdae_sim_get_record(sim, &record) == NSDAE_OK) {
    assert_true(record.time <= fmax(error->time, 0) + 1e-9);
    for (int i = 0; i < 2; i++) assert_true(isfinite(record.q[i]) && isfinite(record.v[i]));
  }
  return status;
}

static void expect(fault f, const char *method, const char *integrator)
{
  const expected *e = &expectations[f];
  nsdae_sim *sim;
  nsdae_sim_options o;
  nsdae_error first, second;
  nsdae_system *system = make(&f);
  nsdae_sim_options_default(&o);
  assert_int_equal(nsdae_sim_options_set(&o, "method", method, NULL), NSDAE_OK);
  assert_int_equal(nsdae_sim_options_set(&o, "integrator", integrator, NULL), NSDAE_OK);
  o.dt = 0.1;
  o.start_check = 0;
  if (f == TOO_MANY_STEPS) o.step_max = 1e-3, o.inner_steps_max = 50;
  int status = nsdae_sim_create(system, &o, &sim, &first);
  nsdae_system_destroy(&system);
  if (status == NSDAE_E_UNSUPPORTED) return;
  assert_int_equal(status, NSDAE_OK);
  status = run(sim, f, &first);
  print_message("%-15s %-8s %-7s %-20s %.3g: %s\n", e->name, method, integrator,
                nsdae_status_name(status), first.time, first.text);
  if (status != e->status && status != e->also)
    fail_msg("%s by %s, %s: %s", e->name, method, integrator, nsdae_status_name(status));
  assert_int_equal(first.status, status);
  if (!strstr(first.text, e->text) && !strstr(first.text, e->or_text) &&
      !strstr(first.text, "velocity 1 \"y\""))
    fail_msg("neither %s nor %s in: %s", e->text, e->or_text, first.text);
  if (strstr(first.text, "smaller penalty_stiffness") && strstr(first.text, "velocity "))
    assert_non_null(strstr(first.text, "; fastest change: velocity "));
  assert_true(e->begin - 1e-6 <= first.time && first.time <= e->end);
  assert_int_equal(run(sim, f, &second), status);
  assert_string_equal(second.text, first.text);
  nsdae_sim_destroy(&sim);
}

static const char *const methods[] = {"event", "penalty"};
static const char *const integrators[] = {"auto", "dopri5", "dop853", "ida"};

/* With redundant = least-norm the run passes the change of the rank, which the statistics show. The
 * point keeps y = 0; x = 2 t while it is driven, and then its velocity 2, as no force acts. */
static void test_least_norm(void **state)
{
  (void)state;
  for (int m = 0; m < 2; m++)
    for (int i = 0; i < 4; i++) {
      fault f = RANK_CHANGES;
      nsdae_sim *sim;
      nsdae_sim_options o;
      nsdae_error error;
      nsdae_record r;
      nsdae_stats stats;
      nsdae_system *system = make(&f);
      nsdae_sim_options_default(&o);
      assert_int_equal(nsdae_sim_options_set(&o, "method", methods[m], NULL), NSDAE_OK);
      assert_int_equal(nsdae_sim_options_set(&o, "integrator", integrators[i], NULL), NSDAE_OK);
      o.redundant = NSDAE_REDUNDANT_LEAST_NORM;
      o.dt = 0.1;
      int status = nsdae_sim_create(system, &o, &sim, &error);
      nsdae_system_destroy(&system);
      if (status == NSDAE_E_UNSUPPORTED) continue;
      status = run(sim, f, &error);
      if (status != NSDAE_OK) fail_msg("%s, %s: %s", methods[m], integrators[i], error.text);
      assert_int_equal(nsdae_sim_get_record(sim, &r), NSDAE_OK);
      assert_int_equal(nsdae_sim_get_stats(sim, &stats), NSDAE_OK);
      print_message("%s, %s: rank %d to %d, x %.3g\n", methods[m], integrators[i], stats.rank,
                    stats.rank_most, r.q[0] - 2);
      assert_int_equal(stats.rank, 1);
      assert_int_equal(stats.rank_most, 2);
      assert_near(r.q[0], 2, 1e-7);
      assert_near(r.q[1], 0, 1e-9);
      nsdae_sim_destroy(&sim);
    }
}

static void test_faults(void **state)
{
  (void)state;
  for (int f = 0; f < FAULTS; f++)
    for (int m = 0; m < 2; m++)
      for (int i = 0; i < 4; i++) expect((fault)f, methods[m], integrators[i]);
}

int main(void)
{
  const struct CMUnitTest tests[] = {cmocka_unit_test(test_faults),
                                     cmocka_unit_test(test_least_norm)};
  return cmocka_run_group_tests(tests, NULL, NULL);
}
