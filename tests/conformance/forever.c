/* What is wrong from some time on, and for good: a callback that fails in every call, recoverably
 * or not, constraints that lose their rank, a mass that vanishes. No step is small enough to come
 * past it: every method says so, names it, keeps the state before, and gives up after a bounded
 * number of calls, whether the ball is in the air then, at its floor or inside a contact that
 * penalty resolves. */
#include "check.h"

#include <nsdae/nsdae.h>

#include "support/random.h"

enum wrong { FORCE, GAP, NORMAL, CONSTRAINT, JACOBIAN, KINEMATICS, MASS, CALLBACKS };
enum { RANK = CALLBACKS, WEIGHTLESS, WRONGS };
static const char *const names[WRONGS] = {
    "force",      "gap",  "gap_normal", "constraint", "constraint_jacobian",
    "kinematics", "mass", "rank",       "weightless"};

/* A ball above its floor in a field that grows with its height, and a coordinate that is held. */
typedef struct model {
  int wrong, code;
  double from; /* wrong at t > from */
  long calls;
} model;

/* Far beyond what the runs here take: who comes there would go on for ever. */
enum { ENDLESS = 2000000, MANY = 200000 };

static int is_wrong(const model *m, int wrong, double t)
{
  return m->wrong == wrong && t > m->from;
}

static int code(model *m, int wrong, double t)
{
  if (++m->calls > ENDLESS) return -1;
  return is_wrong(m, wrong, t) ? m->code : 0;
}

static int mass(double t, const double *q, double *M, int ldm, void *user)
{
  (void)q;
  M[0] = is_wrong(user, WEIGHTLESS, t) ? 0 : 1;
  M[ldm + 1] = 1;
  return code(user, MASS, t);
}

static int force(double t, const double *q, const double *v, double *F, void *user)
{
  (void)v;
  F[0] = -9.81 - 10 * q[0];
  F[1] = 1;
  return code(user, FORCE, t);
}

static int gap(double t, const double *q, double *g, void *user)
{
  g[0] = q[0];
  return code(user, GAP, t);
}

static int normal(double t, const double *q, double *W, int ldw, void *user)
{
  (void)q;
  (void)ldw;
  W[0] = 1;
  return code(user, NORMAL, t);
}

static int constraint(double t, const double *q, double *phi, void *user)
{
  phi[0] = q[1];
  return code(user, CONSTRAINT, t);
}

static int jacobian(double t, const double *q, double *J, int ldj, void *user)
{
  (void)q;
  J[ldj] = is_wrong(user, RANK, t) ? 0 : 1;
  return code(user, JACOBIAN, t);
}

static int kinematics(double t, const double *q, const double *v, double *qdot, void *user)
{
  (void)q;
  qdot[0] = v[0];
  qdot[1] = v[1];
  return code(user, KINEMATICS, t);
}

/* Nothing moves by itself; given, as differences in time look ahead. */
static int constraint_bias(double t, const double *q, const double *v, double *phi_t, double *omega,
                           void *user)
{
  (void)t;
  (void)q;
  (void)v;
  (void)user;
  phi_t[0] = omega[0] = 0;
  return 0;
}

static int contact_bias(double t, const double *q, double *w_n, double *w_t, void *user)
{
  (void)t;
  (void)q;
  (void)w_t;
  (void)user;
  w_n[0] = 0;
  return 0;
}

static int contact_acceleration(double t, const double *q, const double *v, double *omega_n,
                                double *omega_t, double *omega_s, void *user)
{
  (void)v;
  (void)omega_s;
  return contact_bias(t, q, omega_n, omega_t, user);
}

static nsdae_system *make(model *m)
{
  const nsdae_dims dims = {.nq = 2, .m = 1, .k = 1};
  nsdae_system *system;
  assert_int_equal(nsdae_system_create(&dims, &system, NULL), NSDAE_OK);
  nsdae_system_set_user(system, m);
  nsdae_system_set_mass(system, mass);
  nsdae_system_set_force(system, force);
  nsdae_system_set_gap(system, gap);
  nsdae_system_set_gap_normal(system, normal);
  nsdae_system_set_constraint(system, constraint);
  nsdae_system_set_constraint_jacobian(system, jacobian);
  nsdae_system_set_constraint_bias(system, constraint_bias);
  nsdae_system_set_contact_bias(system, contact_bias);
  nsdae_system_set_contact_acceleration(system, contact_acceleration);
  nsdae_system_set_kinematics(system, kinematics);
  nsdae_system_set_contact(system, 0, 0, 0.5, 0);
  return system;
}

static void expect_named(const model *m, int method, int status, const nsdae_error *error)
{
  int expected = m->wrong == RANK         ? NSDAE_E_RANK
                 : m->wrong == WEIGHTLESS ? NSDAE_E_MASS
                                          : NSDAE_E_CALLBACK;
  /* event's integrator comes as near as times can be told apart, and the equations there are whole
   */
  if (method == NSDAE_METHOD_EVENT && expected != NSDAE_E_CALLBACK && status != expected)
    expected = NSDAE_E_CONVERGENCE;
  if (status != expected || error->status != expected || !error->text[0])
    fail_msg("%s, %s from %.17g on with %d: status %d: %s", nsdae_method_name(method),
             names[m->wrong], m->from, m->code, status, error->text);
  if (expected != NSDAE_E_CALLBACK) return;
  assert_int_equal(error->code, m->code);
  assert_string_equal(error->argument, names[m->wrong]);
}

/* Fails in the first of the steps that come past the time, twice the same, and keeps the state. */
static void run(int method, model *m)
{
  const double q0[2] = {0.3, 0}, v0[2] = {0, 0};
  nsdae_sim_options options;
  nsdae_record record;
  nsdae_system *system = make(m);
  nsdae_sim *sim;
  nsdae_sim_options_default(&options);
  options.method = method;
  options.dt = 5e-3;
  int status = nsdae_sim_create(system, &options, &sim, NULL);
  if (status == NSDAE_OK) {
    assert_int_equal(nsdae_sim_init(sim, 0, q0, v0), NSDAE_OK);
    for (int again = 0; again < 2; again++) {
      status = nsdae_sim_run(sim, 1);
      if (status >= 0 || m->calls > MANY)
        fail_msg("%s, %s from %.17g on with %d: status %d after %ld calls",
                 nsdae_method_name(method), names[m->wrong], m->from, m->code, status, m->calls);
      expect_named(m, method, status, nsdae_sim_error(sim));
      assert_int_equal(nsdae_sim_get_record(sim, &record), NSDAE_OK);
      /* moreau looks in the middle of a step, event's integrator is up to one ahead; a normal is
       * not asked for in the air */
      if (m->wrong != NORMAL || record.time < m->from)
        if (!(fabs(record.time - m->from) <= 2 * options.dt))
          fail_msg("%s, %s from %.17g on with %d: the state is that of t = %.17g: %s",
                   nsdae_method_name(method), names[m->wrong], m->from, m->code, record.time,
                   nsdae_sim_error(sim)->text);
      assert_true(isfinite(record.q[0]) && isfinite(record.v[0]));
    }
    nsdae_sim_destroy(&sim);
  } else {
    assert_int_equal(status, NSDAE_E_UNSUPPORTED);
  }
  nsdae_system_destroy(&system);
}

/* x'' = -9.81 - 10 x: it is at the floor at acos(0.981 / 1.281) / sqrt(10) = 0.2209 s, and in
 * penalty's contact for some milliseconds: times all over the first half of a second, and many
 * there. */
static void test_forever(void **state)
{
  (void)state;
  uint64_t seed = 18;
  for (int method = 0; nsdae_method_name(method); method++)
    for (int wrong = 0; wrong < WRONGS; wrong++)
      for (int i = 0; i < 16; i++) {
        double at = random_uniform(&seed);
        model m = {.wrong = wrong, .code = i % 4 == 3 ? -3 : 1 + i % 4};
        m.from = i == 0 ? 0.2472 : i < 8 ? 0.215 + 0.03 * at : 0.01 + 0.5 * at;
        run(method, &m);
      }
}

int main(void)
{
  const struct CMUnitTest tests[] = {cmocka_unit_test(test_forever)};
  return cmocka_run_group_tests(tests, NULL, NULL);
}
