/* Allocation: none after creation, every lost one survived without a leak; and the same run gives
 * the same bytes. */
#include "check.h"

#include "allocator.h"
#include "bead.h"

enum { METHODS = 3, STEPS = 300 };

/* Creates, runs and destroys; returns the first status below zero. */
static int life(bead *b, int method, double *states)
{
  nsdae_sim_options options;
  nsdae_sim *sim = NULL;
  double q0[3], v0[3];
  nsdae_sim_options_default(&options);
  options.method = method;
  options.dt = 0.01;
  bead_start(b, q0, v0);
  nsdae_system *system = bead_system(b);
  if (!system) return NSDAE_E_MEMORY;
  int status = nsdae_sim_create(system, &options, &sim, NULL);
  if (status == NSDAE_OK) status = nsdae_system_check(system, 0.1, q0, v0, 1e-5, NULL);
  if (status == NSDAE_OK) status = nsdae_sim_init(sim, 0, q0, v0);
  for (int i = 0; i < STEPS && status >= 0; i++) {
    nsdae_record r;
    status = nsdae_sim_step(sim);
    if (status < 0) print_message("%s\n", nsdae_sim_error(sim)->text);
    nsdae_sim_get_record(sim, &r);
    if (!states) continue;
    memcpy(states + (size_t)i * 6, r.q, 3 * sizeof *states);
    memcpy(states + (size_t)i * 6 + 3, r.v, 3 * sizeof *states);
  }
  nsdae_sim_destroy(&sim);
  nsdae_system_destroy(&system);
  return status < 0 ? status : NSDAE_OK;
}

static void test_every_lost_allocation(void **state)
{
  (void)state;
  int status = NSDAE_E_MEMORY;
  long tried = 0;
  for (; status < 0; tried++) {
    bead b;
    bead_default(&b);
    allocator_reset(tried);
    status = life(&b, NSDAE_METHOD_IMPLICIT, NULL);
    assert_true(status == NSDAE_OK || status == NSDAE_E_MEMORY);
    assert_int_equal(the_allocator.live, 0);
  }
  /* system 3, simulation 3, check 1: the one that did not fail is the last */
  assert_true(tried > 5);
  allocator_reset(-1);
}

static int count_at_the_end(const nsdae_record *record, nsdae_error *error, void *user)
{
  (void)record;
  (void)error;
  *(long *)user = the_allocator.calls;
  return 0;
}

static void test_none_after_creation(void **state)
{
  (void)state;
  for (int method = 0; method < METHODS; method++) {
    bead b;
    nsdae_sim_options options;
    nsdae_sim *sim;
    nsdae_stats stats;
    double q0[3], v0[3];
    long last = -1;
    bead_default(&b);
    bead_start(&b, q0, v0);
    nsdae_sim_options_default(&options);
    options.method = method;
    nsdae_system *system = bead_system(&b);
    assert_int_equal(nsdae_sim_create(system, &options, &sim, NULL), NSDAE_OK);
    nsdae_sim_observe(sim, count_at_the_end, &last);
    allocator_reset(-1);
    assert_int_equal(nsdae_sim_init(sim, 0, q0, v0), NSDAE_OK);
    assert_int_equal(nsdae_sim_run(sim, 3), NSDAE_OK);
    assert_int_equal(the_allocator.calls, 0);
    assert_int_equal(last, 0);
    nsdae_sim_get_stats(sim, &stats);
    assert_true(stats.impacts > 0 && stats.lcps > 10);
    nsdae_sim_destroy(&sim);
    nsdae_system_destroy(&system);
  }
}

static void test_same_bytes(void **state)
{
  (void)state;
  static double once[STEPS * 6], again[STEPS * 6];
  for (int method = 0; nsdae_method_name(method); method++) {
    bead b;
    bead_default(&b);
    int status = life(&b, method, once);
    if (status == NSDAE_E_UNSUPPORTED) continue;
    assert_int_equal(status, NSDAE_OK);
    assert_int_equal(life(&b, method, again), NSDAE_OK);
    assert_memory_equal(once, again, sizeof once);
  }
}

/* Two simulations of one system, a step of each in turn, are as if alone. */
static void test_one_system_two_simulations(void **state)
{
  (void)state;
  static double alone[STEPS * 6];
  nsdae_sim_options options;
  nsdae_sim *sim[2];
  bead b;
  double q0[3], v0[3];
  bead_default(&b);
  assert_int_equal(life(&b, NSDAE_METHOD_IMPLICIT, alone), NSDAE_OK);
  nsdae_system *system = bead_system(&b);
  bead_start(&b, q0, v0);
  for (int i = 0; i < 2; i++) {
    nsdae_sim_options_default(&options);
    options.dt = 0.01;
    options.method = i == 0 ? NSDAE_METHOD_IMPLICIT : NSDAE_METHOD_MOREAU;
    assert_int_equal(nsdae_sim_create(system, &options, &sim[i], NULL), NSDAE_OK);
    assert_int_equal(nsdae_sim_init(sim[i], 0, q0, v0), NSDAE_OK);
  }
  for (size_t i = 0; i < STEPS; i++) {
    nsdae_record r;
    assert_true(nsdae_sim_step(sim[0]) >= 0 && nsdae_sim_step(sim[1]) >= 0);
    nsdae_sim_get_record(sim[0], &r);
    assert_memory_equal(r.q, alone + i * 6, 3 * sizeof *alone);
    assert_memory_equal(r.v, alone + i * 6 + 3, 3 * sizeof *alone);
  }
  for (int i = 0; i < 2; i++) nsdae_sim_destroy(&sim[i]);
  nsdae_system_destroy(&system);
}

int main(void)
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(test_every_lost_allocation),
      cmocka_unit_test(test_none_after_creation),
      cmocka_unit_test(test_same_bytes),
      cmocka_unit_test(test_one_system_two_simulations),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
