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

/* Three masses that hang together by their inertia, thrown obliquely on a floor: q = x, y, z of
 * each. The number of contacts with the cone changes from step to step. */
static int masses(double t, const double *q, double *M, int ldm, void *user)
{
  (void)t;
  (void)q;
  (void)user;
  for (int j = 0; j < 9; j++)
    for (int i = 0; i < 9; i++) M[j * ldm + i] = (i == j) + (i % 3 == j % 3 ? 0.1 : 0);
  return 0;
}

static int weight(double t, const double *q, const double *v, double *F, void *user)
{
  (void)t;
  (void)q;
  (void)v;
  (void)user;
  for (int i = 2; i < 9; i += 3) F[i] = -9.81;
  return 0;
}

static int heights(double t, const double *q, double *gap, void *user)
{
  (void)t;
  (void)user;
  for (int i = 0; i < 3; i++) gap[i] = q[3 * i + 2];
  return 0;
}

static int upwards(double t, const double *q, double *W, int ldw, void *user)
{
  (void)t;
  (void)q;
  (void)user;
  for (int i = 0; i < 3; i++) W[i * ldw + 3 * i + 2] = 1;
  return 0;
}

static int sideways(double t, const double *q, double *W, int ldw, void *user)
{
  (void)t;
  (void)q;
  (void)user;
  for (int i = 0; i < 6; i++) W[i * ldw + 3 * (i / 2) + i % 2] = 1;
  return 0;
}

static int create_masses(int method, nsdae_system **system, nsdae_sim **sim)
{
  const nsdae_dims dims = {.nq = 9, .k = 3, .nt = 2};
  nsdae_sim_options options;
  nsdae_sim_options_default(&options);
  options.method = method;
  options.dt = 0.01;
  if (nsdae_system_create(&dims, system, NULL) < 0) return NSDAE_E_MEMORY;
  nsdae_system_set_mass(*system, masses);
  nsdae_system_set_force(*system, weight);
  nsdae_system_set_gap(*system, heights);
  nsdae_system_set_gap_normal(*system, upwards);
  nsdae_system_set_gap_tangent(*system, sideways);
  for (int i = 0; i < 3; i++) nsdae_system_set_contact(*system, i, 0.3, 0.5, 0);
  return nsdae_sim_create(*system, &options, sim, NULL);
}

static void test_cones(void **state)
{
  (void)state;
  const double q0[9] = {[2] = 0.1, [5] = 0.3, [8] = 0.5}, v0[9] = {1, 2, 0, -1, 0.3, 0, 0.2, 0, 0};
  int status = NSDAE_E_MEMORY;
  for (int method = 0; method < METHODS; method++) {
    nsdae_system *system;
    nsdae_sim *sim;
    nsdae_stats stats;
    assert_int_equal(create_masses(method, &system, &sim), NSDAE_OK);
    allocator_reset(-1);
    assert_int_equal(nsdae_sim_init(sim, 0, q0, v0), NSDAE_OK);
    assert_true(nsdae_sim_run(sim, 3) >= 0);
    assert_int_equal(the_allocator.calls, 0);
    nsdae_sim_get_stats(sim, &stats);
    assert_true(stats.impacts > 3 && stats.lcps > 10);
    nsdae_sim_destroy(&sim);
    nsdae_system_destroy(&system);
  }
  for (long tried = 0; status < 0; tried++) {
    nsdae_system *system = NULL;
    nsdae_sim *sim = NULL;
    allocator_reset(tried);
    status = create_masses(0, &system, &sim);
    assert_true(status == NSDAE_OK || status == NSDAE_E_MEMORY);
    nsdae_sim_destroy(&sim);
    nsdae_system_destroy(&system);
    assert_int_equal(the_allocator.live, 0);
  }
  allocator_reset(-1);
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
      cmocka_unit_test(test_cones),
      cmocka_unit_test(test_same_bytes),
      cmocka_unit_test(test_one_system_two_simulations),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
