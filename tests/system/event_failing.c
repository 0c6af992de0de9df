/* Callbacks that fail under the event-driven method: every one, in its 1st, 2nd, 3rd .. call,
 * wherever in a step, an instant or the integrator that is. The status says so with the callback's
 * name, the state is the one before, and the same simulation runs again as if nothing had been. */
#include "check.h"

#include "bead.h"

static nsdae_sim *make(nsdae_system *system)
{
  nsdae_sim_options options;
  nsdae_sim *sim;
  nsdae_sim_options_default(&options);
  options.method = NSDAE_METHOD_EVENT;
  options.dt = 0.02;
  options.rtol = 1e-6;
  options.atol = 1e-8;
  assert_int_equal(nsdae_sim_create(system, &options, &sim, NULL), NSDAE_OK);
  return sim;
}

/* From the start; the fault counts from here. */
static int run(nsdae_sim *sim, bead *b, double t_end)
{
  double q0[3], v0[3];
  memset(b->calls, 0, sizeof b->calls);
  bead_start(b, q0, v0);
  int status = nsdae_sim_init(sim, 0, q0, v0);
  return status < 0 ? status : nsdae_sim_run(sim, t_end);
}

static void expect_finite(const nsdae_sim *sim)
{
  nsdae_record record;
  if (nsdae_sim_get_record(sim, &record) < 0) return; /* failed in init */
  assert_true(isfinite(record.time));
  for (int i = 0; i < 3; i++) assert_true(isfinite(record.q[i]) && isfinite(record.v[i]));
}

/* A fault that comes once. < 0 is fatal; > 0 and a NaN may be stepped around by the integrator. */
static void fail_at(nsdae_sim *sim, bead *b, int term, int at, int fault)
{
  b->term = term;
  b->at = at;
  b->code = fault == 0 ? -3 : fault == 1 ? 2 : 0;
  b->value = fault == 2 ? NAN : INFINITY;
  int status = run(sim, b, 0.7), expected = b->code ? NSDAE_E_CALLBACK : NSDAE_E_NONFINITE;
  const nsdae_error *error = nsdae_sim_error(sim);
  expect_finite(sim);
  if (status == NSDAE_OK) {
    assert_true(b->code >= 0 || b->calls[term] <= at);
    return;
  }
  assert_int_equal(status, expected);
  assert_int_equal(error->status, status);
  assert_string_equal(error->argument, bead_names[term]);
  assert_true(isfinite(error->time) && error->time >= 0 && error->time < 0.8);
  if (b->code) assert_int_equal(error->code, b->code);
}

/* A mass that depends on t alone, as kind says, and moves on without force. */
typedef enum kind { GROWS, BEGINS_TO_GROW, GROWS_AND_JUMPS, JUMPS, KINDS } kind;

static double mass_at(kind of, double t)
{
  if (t > 0.503 && (of == GROWS_AND_JUMPS || of == JUMPS)) return 3;
  if (of == JUMPS) return 1;
  return of == BEGINS_TO_GROW ? 1 + pow(fmax(0, t - 0.3), 3) : 1 + t;
}

static int mass_of(double t, const double *q, double *M, int ldm, void *user)
{
  (void)q;
  (void)ldm;
  M[0] = mass_at(*(const kind *)user, t);
  return 0;
}

static int no_force(double t, const double *q, const double *v, double *F, void *user)
{
  (void)t;
  (void)q;
  (void)v;
  (void)user;
  F[0] = 0;
  return 0;
}

/* T = M v^2 / 2 grows with M by M' v^2 / 2, which is seen; where M jumps T has changed by nothing
 * that the equations of motion know, and the run ends there, the state being that of before. */
static void test_energy(void **state)
{
  const nsdae_dims dims = {.nq = 1};
  const double q0 = 0, v0 = 2;
  nsdae_record r;
  (void)state;
  for (kind of = 0; of < KINDS; of++) {
    int jumps = of >= GROWS_AND_JUMPS;
    nsdae_system *system;
    assert_int_equal(nsdae_system_create(&dims, &system, NULL), NSDAE_OK);
    nsdae_system_set_user(system, &of);
    nsdae_system_set_mass(system, mass_of);
    nsdae_system_set_force(system, no_force);
    nsdae_sim *sim = make(system);
    assert_int_equal(nsdae_sim_init(sim, 0, &q0, &v0), NSDAE_OK);
    assert_int_equal(nsdae_sim_run(sim, 1), jumps ? NSDAE_E_CONVERGENCE : NSDAE_OK);
    nsdae_sim_get_record(sim, &r);
    assert_near(r.time, jumps ? 0.5 : 1, 1e-12);
    assert_near(r.kinetic, mass_at(of, r.time) * v0 * v0 / 2, 1e-12);
    if (jumps) assert_string_equal(nsdae_sim_error(sim)->argument, "rtol");
    nsdae_sim_destroy(&sim);
    nsdae_system_destroy(&system);
  }
}

static void test_every_call(void **state)
{
  (void)state;
  bead b;
  nsdae_record record;
  nsdae_stats stats;
  double q[3];
  bead_default(&b);
  nsdae_system *system = bead_system(&b);
  nsdae_sim *sim = make(system);
  assert_int_equal(run(sim, &b, 0.7), NSDAE_OK);
  nsdae_sim_get_record(sim, &record);
  nsdae_sim_get_stats(sim, &stats);
  assert_true(stats.events > 1); /* instants are among what fails */
  memcpy(q, record.q, sizeof q);
  int calls[BEAD_TERMS], failed = 0;
  memcpy(calls, b.calls, sizeof calls);
  for (int term = 0; term < BEAD_TERMS; term++) {
    assert_true(calls[term] > 1);
    for (int fault = 0; fault < 4; fault++) {
      /* the first forty one by one, then some sixty over the run */
      for (int at = 0; at < calls[term]; at += at < 40 ? 1 : 1 + calls[term] / 61) {
        fail_at(sim, &b, term, at, fault);
        failed++;
      }
      b.term = -1;
      assert_int_equal(run(sim, &b, 0.7), NSDAE_OK);
      nsdae_sim_get_record(sim, &record);
      assert_memory_equal(record.q, q, sizeof q);
    }
  }
  print_message("%d faults\n", failed);
  nsdae_sim_destroy(&sim);
  nsdae_system_destroy(&system);
}

/* After a failure in the middle the run goes on from the state before it, without a new start. */
static void test_going_on(void **state)
{
  (void)state;
  bead b;
  nsdae_record record;
  double q[3];
  bead_default(&b);
  nsdae_system *system = bead_system(&b);
  nsdae_sim *sim = make(system);
  assert_int_equal(run(sim, &b, 0.7), NSDAE_OK);
  nsdae_sim_get_record(sim, &record);
  memcpy(q, record.q, sizeof q);
  int calls = b.calls[BEAD_FORCE];
  for (int part = 1; part < 8; part++) {
    b.term = BEAD_FORCE;
    b.at = part * calls / 8;
    b.code = -1;
    assert_int_equal(run(sim, &b, 0.7), NSDAE_E_CALLBACK);
    assert_int_equal(nsdae_sim_run(sim, 0.7), NSDAE_OK);
    nsdae_sim_get_record(sim, &record);
    assert_true(record.time == 0.7);
    /* another sequence of steps: the errors of two runs at rtol 1e-6 */
    for (int i = 0; i < 3; i++) assert_near(record.q[i], q[i], 1e-3);
  }
  nsdae_sim_destroy(&sim);
  nsdae_system_destroy(&system);
}

int main(void)
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(test_energy),
      cmocka_unit_test(test_every_call),
      cmocka_unit_test(test_going_on),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
