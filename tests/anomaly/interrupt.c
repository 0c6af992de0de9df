/* A run that is interrupted: before any step, and inside a long one; the step is dropped, the state
 * is the one before it, and the run goes on from there as if nothing had been. And what takes too
 * many steps inside ends with a status. */
#include "check.h"

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
                                     cmocka_unit_test(test_too_many_steps)};
  return cmocka_run_group_tests(tests, NULL, NULL);
}
