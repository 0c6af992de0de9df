/* A run that is interrupted: before any step, and inside a long one; the step is dropped, the state
 * is the one before it, and the run goes on from there as if nothing had been. And what takes too
 * many steps inside ends with a status. */
#include "check.h"

#include <limits.h>

#include "bead.h"

/* Interrupts when it was asked so many times. */
typedef struct patience {
  long left, asked;
} patience;

static int ask(void *user)
{
  patience *p = user;
  p->asked++;
  return p->left-- <= 0;
}

static nsdae_sim *make(nsdae_system *system, int method, double dt)
{
  nsdae_sim_options options;
  nsdae_sim *sim = NULL;
  nsdae_sim_options_default(&options);
  options.method = method;
  options.dt = dt;
  int status = nsdae_sim_create(system, &options, &sim, NULL);
  assert_true(status == NSDAE_OK || status == NSDAE_E_UNSUPPORTED);
  return sim;
}

static void start(nsdae_sim *sim, const bead *b)
{
  double q0[3], v0[3];
  bead_start(b, q0, v0);
  assert_int_equal(nsdae_sim_init(sim, 0, q0, v0), NSDAE_OK);
}

static void test_interrupted(void **state)
{
  (void)state;
  for (int method = 0; nsdae_method_name(method); method++) {
    bead b;
    bead_default(&b);
    nsdae_system *system = bead_system(&b);
    nsdae_sim *sim = make(system, method, 0.05), *alone = make(system, method, 0.05);
    patience p = {.left = 7};
    nsdae_record cut, whole;
    if (sim) {
      start(sim, &b);
      start(alone, &b);
      assert_int_equal(nsdae_sim_set_interrupt(sim, ask, &p), NSDAE_OK);
      assert_int_equal(nsdae_sim_run(sim, 0.5), NSDAE_E_INTERRUPTED);
      assert_int_equal(nsdae_sim_error(sim)->status, NSDAE_E_INTERRUPTED);
      assert_int_equal(nsdae_sim_error(sim)->code, 1);
      nsdae_sim_get_record(sim, &cut);
      /* one question a step with a fixed step, more with an integrator */
      if (method < NSDAE_METHOD_PENALTY) assert_int_equal(cut.step, 7);
      if (method == NSDAE_METHOD_PENALTY) assert_true(cut.step < 7);
      assert_int_equal(nsdae_sim_set_interrupt(sim, NULL, NULL), NSDAE_OK);
      assert_true(nsdae_sim_run(sim, 0.5) >= 0);
      assert_true(nsdae_sim_run(alone, 0.5) >= 0);
      nsdae_sim_get_record(sim, &cut);
      nsdae_sim_get_record(alone, &whole);
      assert_true(cut.time == 0.5 && cut.step == whole.step);
      assert_memory_equal(cut.q, whole.q, 3 * sizeof *cut.q);
      assert_memory_equal(cut.v, whole.v, 3 * sizeof *cut.v);
    }
    nsdae_sim_destroy(&sim);
    nsdae_sim_destroy(&alone);
    nsdae_system_destroy(&system);
  }
  assert_int_equal(nsdae_sim_set_interrupt(NULL, ask, NULL), NSDAE_E_ARGUMENT);
}

/* Calls of the force, and the most of them between two questions. */
typedef struct pace {
  long calls, asked_at, most, questions, stop_after;
} pace;

static pace the_pace;

static int slow_force(double t, const double *q, const double *v, double *F, void *user)
{
  (void)t, (void)v, (void)user;
  the_pace.calls++;
  F[0] = -400 * q[0];
  return 0;
}

static int identity(double t, const double *q, double *M, int ldm, void *user)
{
  (void)t, (void)q, (void)ldm, (void)user;
  M[0] = 1;
  return 0;
}

static int over_zero(double t, const double *q, double *g, void *user)
{
  (void)t, (void)user;
  g[0] = q[0] + 0.01;
  return 0;
}

static int asked(void *user)
{
  pace *p = user;
  if (p->calls - p->asked_at > p->most) p->most = p->calls - p->asked_at;
  p->asked_at = p->calls;
  return ++p->questions > p->stop_after;
}

/* An oscillator of 3 Hz that hits a stop, in one step of 20 s: the integrators ask again and again
 * inside it, however slow a callback is, and are gone at once when they hear so; the state is that
 * of before the step, to the last bit, and the run can go on. */
static void test_inside_a_step(void **state)
{
  (void)state;
  const nsdae_dims dims = {.nq = 1, .k = 1};
  const double q0 = 0.1, v0 = -0.3;
  nsdae_system *system;
  assert_int_equal(nsdae_system_create(&dims, &system, NULL), NSDAE_OK);
  nsdae_system_set_mass(system, identity);
  nsdae_system_set_force(system, slow_force);
  nsdae_system_set_gap(system, over_zero);
  nsdae_system_set_contact(system, 0, 0, 0.9, 0);
  for (int method = NSDAE_METHOD_PENALTY; method <= NSDAE_METHOD_EVENT; method++)
    for (long stop_after = 2; stop_after < 200; stop_after += 33) {
      nsdae_sim *sim = make(system, method, 20);
      nsdae_record r;
      if (!sim) continue; /* built without SUNDIALS */
      the_pace = (pace){.stop_after = stop_after};
      assert_int_equal(nsdae_sim_init(sim, 0, &q0, &v0), NSDAE_OK);
      assert_int_equal(nsdae_sim_set_interrupt(sim, asked, &the_pace), NSDAE_OK);
      assert_int_equal(nsdae_sim_step(sim), NSDAE_E_INTERRUPTED);
      assert_int_equal(nsdae_sim_error(sim)->status, NSDAE_E_INTERRUPTED);
      assert_int_equal(the_pace.questions, stop_after + 1); /* once it has heard, none */
      assert_true(the_pace.calls == the_pace.asked_at);     /* and no call of the model */
      assert_true(the_pace.calls > 0 &&
                  the_pace.most <= 100); /* a step of the integrator, a search */
      assert_int_equal(nsdae_sim_get_record(sim, &r), NSDAE_OK);
      assert_true(r.step == 0 && r.time == 0 && r.q[0] == q0 && r.v[0] == v0);
      the_pace.stop_after = LONG_MAX;
      assert_true(nsdae_sim_run(sim, 20) >= 0);
      nsdae_sim_get_record(sim, &r);
      assert_true(r.time == 20);
      nsdae_sim_destroy(&sim);
    }
  nsdae_system_destroy(&system);
}

static void test_too_many_steps(void **state)
{
  (void)state;
  bead b;
  nsdae_sim_options options;
  nsdae_sim *sim;
  bead_default(&b);
  nsdae_system *system = bead_system(&b);
  nsdae_sim_options_default(&options);
  options.method = NSDAE_METHOD_PENALTY;
  options.inner_steps_max = 5;
  options.dt = 1;
  int status = nsdae_sim_create(system, &options, &sim, NULL);
  if (status == NSDAE_OK) {
    start(sim, &b);
    assert_int_equal(nsdae_sim_step(sim), NSDAE_E_CONVERGENCE);
    assert_string_equal(nsdae_sim_error(sim)->argument, "inner_steps_max");
    nsdae_sim_destroy(&sim);
  }
  nsdae_system_destroy(&system);
}

int main(void)
{
  const struct CMUnitTest tests[] = {cmocka_unit_test(test_interrupted),
                                     cmocka_unit_test(test_inside_a_step),
                                     cmocka_unit_test(test_too_many_steps)};
  return cmocka_run_group_tests(tests, NULL, NULL);
}
