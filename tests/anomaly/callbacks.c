/* Callbacks that fail or return NaN, matrices that are singular: a status and a clear record, the
 * state is the one before, and the simulation can be started anew. */
#include "check.h"

#include "bead.h"

enum { METHODS = 3 }; /* those with a fixed step */

/* Penalty needs SUNDIALS. */
static int is_built(int method)
{
  bead b;
  nsdae_sim_options options;
  nsdae_sim *sim;
  bead_default(&b);
  nsdae_system *system = bead_system(&b);
  nsdae_sim_options_default(&options);
  options.method = method;
  int status = nsdae_sim_create(system, &options, &sim, NULL);
  nsdae_sim_destroy(&sim);
  nsdae_system_destroy(&system);
  return status != NSDAE_E_UNSUPPORTED;
}

static nsdae_sim *make_sim(nsdae_system *system, int method, int redundant)
{
  nsdae_sim_options options;
  nsdae_sim *sim;
  nsdae_sim_options_default(&options);
  options.method = method;
  options.redundant = redundant;
  options.dt = 0.01;
  assert_int_equal(nsdae_sim_create(system, &options, &sim, NULL), NSDAE_OK);
  return sim;
}

static int start(nsdae_sim *sim, const bead *b)
{
  double q0[3], v0[3];
  bead_start(b, q0, v0);
  return nsdae_sim_init(sim, 0, q0, v0);
}

static void expect_unchanged(const nsdae_record *before, const double *q, const double *v,
                             const nsdae_sim *sim)
{
  nsdae_record after;
  assert_int_equal(nsdae_sim_get_record(sim, &after), NSDAE_OK);
  assert_true(after.step == before->step && after.time == before->time);
  assert_memory_equal(after.q, q, 3 * sizeof *q);
  assert_memory_equal(after.v, v, 3 * sizeof *v);
}

/* Runs until the fault; then checks state and record, and runs again without it. */
static void fail_in_a_run(bead *b, int method, int status)
{
  nsdae_system *system = bead_system(b);
  nsdae_sim *sim = make_sim(system, method, NSDAE_REDUNDANT_ERROR);
  nsdae_record record;
  double q[3], v[3];
  int result = NSDAE_OK, steps = 0;
  assert_int_equal(start(sim, b), NSDAE_OK);
  while (result >= 0 && steps++ < 2000) {
    nsdae_sim_get_record(sim, &record);
    memcpy(q, record.q, sizeof q);
    memcpy(v, record.v, sizeof v);
    result = nsdae_sim_step(sim);
  }
  const nsdae_error *error = nsdae_sim_error(sim);
  if (method >= NSDAE_METHOD_PENALTY && b->code > 0 &&
      result >= 0) { /* smaller steps got around it */
    nsdae_sim_destroy(&sim);
    nsdae_system_destroy(&system);
    return;
  }
  assert_int_equal(result, status);
  assert_int_equal(error->status, status);
  assert_string_equal(error->argument, bead_names[b->term]);
  assert_non_null(strstr(error->text, bead_names[b->term]));
  assert_null(strchr(error->text, '\n'));
  assert_true(isfinite(error->time));
  if (status == NSDAE_E_CALLBACK) assert_int_equal(error->code, b->code);
  expect_unchanged(&record, q, v, sim);
  b->term = -1;
  assert_int_equal(start(sim, b), NSDAE_OK);
  /* the law of penalty does not give e_N = 0 */
  assert_int_equal(nsdae_sim_run(sim, 0.5),
                   method == NSDAE_METHOD_PENALTY ? NSDAE_WARN_RESTITUTION : NSDAE_OK);
  nsdae_sim_destroy(&sim);
  nsdae_system_destroy(&system);
}

static void test_failing_callback(void **state)
{
  (void)state;
  for (int method = 0; nsdae_method_name(method) && is_built(method); method++)
    for (int term = 0; term < BEAD_TERMS; term++)
      for (int code = -1; code <= 1; code += 2) {
        bead b;
        bead_default(&b);
        b.term = term;
        b.at = 37;
        b.code = code;
        fail_in_a_run(&b, method, NSDAE_E_CALLBACK);
      }
}

static void test_nan(void **state)
{
  (void)state;
  for (int method = 0; nsdae_method_name(method) && is_built(method); method++)
    for (int term = 0; term < BEAD_TERMS; term++) {
      bead b;
      bead_default(&b);
      b.term = term;
      b.at = 20;
      b.value = term % 2 ? NAN : INFINITY;
      fail_in_a_run(&b, method, NSDAE_E_NONFINITE);
    }
}

static int late_mass(double t, const double *q, double *M, int ldm, void *user)
{
  (void)t;
  (void)q;
  (void)ldm;
  (void)user;
  M[0] = 1;
  return 0;
}

static int late_force(double t, const double *q, const double *v, double *F, void *user)
{
  (void)q;
  (void)v;
  long *calls = user;
  F[0] = -9.81;
  if (++*calls > 1000000) return -1; /* it would go on for ever */
  return t > 0.3;
}

/* Recoverable, but no step is small enough to recover: integrators with error control must give up
 * before they halve their step for ever. */
static void test_no_step_is_small_enough(void **state)
{
  (void)state;
  const nsdae_dims dims = {.nq = 1};
  const double q0 = 1, v0 = 0;
  for (int method = 0; nsdae_method_name(method) && is_built(method); method++) {
    nsdae_system *system;
    nsdae_record record;
    long calls = 0;
    assert_int_equal(nsdae_system_create(&dims, &system, NULL), NSDAE_OK);
    nsdae_system_set_user(system, &calls);
    nsdae_system_set_mass(system, late_mass);
    nsdae_system_set_force(system, late_force);
    nsdae_sim *sim = make_sim(system, method, NSDAE_REDUNDANT_ERROR);
    assert_int_equal(nsdae_sim_init(sim, 0, &q0, &v0), NSDAE_OK);
    assert_int_equal(nsdae_sim_run(sim, 1), NSDAE_E_CALLBACK);
    assert_int_equal(nsdae_sim_error(sim)->code, 1);
    assert_int_equal(nsdae_sim_get_record(sim, &record), NSDAE_OK);
    assert_near(record.time, 0.3, 0.0101);
    assert_true(calls < 100000);
    nsdae_sim_destroy(&sim);
    nsdae_system_destroy(&system);
  }
}

/* Every term is evaluated at the start, so what is wrong shows there. */
static void test_failing_start(void **state)
{
  (void)state;
  for (int term = 0; term < BEAD_TERMS; term++) {
    bead b;
    bead_default(&b);
    nsdae_system *system = bead_system(&b);
    nsdae_sim *sim = make_sim(system, NSDAE_METHOD_IMPLICIT, NSDAE_REDUNDANT_ERROR);
    b.term = term;
    b.code = -7;
    assert_int_equal(start(sim, &b), NSDAE_E_CALLBACK);
    assert_int_equal(nsdae_sim_error(sim)->code, -7);
    assert_string_equal(nsdae_sim_error(sim)->argument, bead_names[term]);
    assert_int_equal(nsdae_sim_step(sim), NSDAE_E_STATE);
    nsdae_sim_destroy(&sim);
    nsdae_system_destroy(&system);
  }
}

static void test_mass_not_positive_definite(void **state)
{
  (void)state;
  const double scale[] = {-1, 0};
  for (int i = 0; i < 2; i++) {
    bead b;
    bead_default(&b);
    b.mass_scale = scale[i];
    nsdae_system *system = bead_system(&b);
    nsdae_sim *sim = make_sim(system, NSDAE_METHOD_IMPLICIT, NSDAE_REDUNDANT_ERROR);
    assert_int_equal(start(sim, &b), NSDAE_E_MASS);
    assert_non_null(strstr(nsdae_sim_error(sim)->text, "positive definite"));
    assert_non_null(strstr(nsdae_sim_error(sim)->text, "pivot 1 of 3"));
    nsdae_sim_destroy(&sim);
    nsdae_system_destroy(&system);
  }
}

/* A constraint that stands twice: refused with its rank, or run with least-norm reactions, which
 * then give the same motion as the constraint alone. */
static void test_rank(void **state)
{
  (void)state;
  bead twice, once;
  bead_default(&once);
  bead_default(&twice);
  twice.repeated = 1;
  nsdae_system *system = bead_system(&twice), *plain = bead_system(&once);
  nsdae_sim *sim = make_sim(system, NSDAE_METHOD_IMPLICIT, NSDAE_REDUNDANT_ERROR);
  assert_int_equal(start(sim, &twice), NSDAE_E_RANK);
  assert_non_null(strstr(nsdae_sim_error(sim)->text, "rank 1 of 2"));
  nsdae_sim_destroy(&sim);
  for (int method = 0; method < METHODS; method++) {
    nsdae_record two, one;
    nsdae_stats stats;
    sim = make_sim(system, method, NSDAE_REDUNDANT_LEAST_NORM);
    nsdae_sim *alone = make_sim(plain, method, NSDAE_REDUNDANT_ERROR);
    assert_int_equal(start(sim, &twice), NSDAE_OK);
    assert_int_equal(start(alone, &once), NSDAE_OK);
    assert_int_equal(nsdae_sim_run(sim, 0.3), NSDAE_OK);
    assert_int_equal(nsdae_sim_run(alone, 0.3), NSDAE_OK);
    nsdae_sim_get_record(sim, &two);
    nsdae_sim_get_record(alone, &one);
    nsdae_sim_get_stats(sim, &stats);
    assert_int_equal(stats.rank, 1);
    /* rounding of thirty smooth steps */
    for (int i = 0; i < 3; i++) assert_near(two.q[i], one.q[i], 1e-12);
    /* least norm: Phi_2 = 2 Phi_1 shares the force as 1 : 2, and l1 + 2 l2 is the plain force */
    assert_near(two.multiplier[1], 2 * two.multiplier[0], 1e-9 * (1 + fabs(one.multiplier[0])));
    assert_near(two.multiplier[0] + 2 * two.multiplier[1], one.multiplier[0],
                1e-9 * (1 + fabs(one.multiplier[0])));
    nsdae_sim_destroy(&sim);
    nsdae_sim_destroy(&alone);
  }
  nsdae_system_destroy(&system);
  nsdae_system_destroy(&plain);
}

static int stop_at_five(const nsdae_record *record, nsdae_error *error, void *user)
{
  (void)error;
  (void)user;
  return record->step == 5;
}

static int fail_at_five(const nsdae_record *record, nsdae_error *error, void *user)
{
  (void)error;
  (void)user;
  return record->step == 5 ? NSDAE_E_IO : 0;
}

static void test_observers(void **state)
{
  (void)state;
  bead b;
  nsdae_record record;
  bead_default(&b);
  nsdae_system *system = bead_system(&b);
  nsdae_sim *sim = make_sim(system, NSDAE_METHOD_MOREAU, NSDAE_REDUNDANT_ERROR);
  assert_int_equal(start(sim, &b), NSDAE_OK);
  nsdae_sim_observe(sim, stop_at_five, NULL);
  assert_int_equal(nsdae_sim_run(sim, 1), NSDAE_STOPPED);
  nsdae_sim_get_record(sim, &record);
  assert_int_equal(record.step, 5);
  /* it goes on from there, on the same grid */
  assert_int_equal(nsdae_sim_unobserve(sim, stop_at_five, NULL), NSDAE_OK);
  assert_int_equal(nsdae_sim_run(sim, 1), NSDAE_OK);
  nsdae_sim_get_record(sim, &record);
  assert_int_equal(record.step, 100);
  assert_true(record.time == 1);
  assert_int_equal(start(sim, &b), NSDAE_OK);
  nsdae_sim_observe(sim, fail_at_five, NULL);
  assert_int_equal(nsdae_sim_run(sim, 1), NSDAE_E_IO);
  assert_string_equal(nsdae_sim_error(sim)->argument, "observer");
  for (int i = 1; i < NSDAE_OBSERVERS_MAX; i++)
    assert_int_equal(nsdae_sim_observe(sim, stop_at_five, NULL), NSDAE_OK);
  assert_int_equal(nsdae_sim_observe(sim, stop_at_five, NULL), NSDAE_E_ARGUMENT);
  nsdae_sim_destroy(&sim);
  nsdae_system_destroy(&system);
}

/* A last step that is shortened ends at t_end; the next run starts a new grid there. */
static void test_times(void **state)
{
  (void)state;
  bead b;
  nsdae_record record;
  bead_default(&b);
  nsdae_system *system = bead_system(&b);
  nsdae_sim *sim = make_sim(system, NSDAE_METHOD_IMPLICIT, NSDAE_REDUNDANT_ERROR);
  assert_int_equal(nsdae_sim_run(sim, 1), NSDAE_E_STATE);
  assert_int_equal(start(sim, &b), NSDAE_OK);
  assert_int_equal(nsdae_sim_run(sim, 0.034), NSDAE_OK);
  nsdae_sim_get_record(sim, &record);
  assert_true(record.time == 0.034 && record.step == 4);
  assert_int_equal(nsdae_sim_step(sim), NSDAE_OK);
  nsdae_sim_get_record(sim, &record);
  assert_near(record.time, 0.044, 1e-15);
  assert_int_equal(nsdae_sim_run(sim, 0.01), NSDAE_E_ARGUMENT);
  assert_string_equal(nsdae_sim_error(sim)->argument, "t_end");
  assert_int_equal(nsdae_sim_run(sim, NAN), NSDAE_E_ARGUMENT);
  double q0[3], v0[3];
  b.speed = b.floor_speed = 0; /* nothing has gone off by then */
  bead_start(&b, q0, v0);
  assert_int_equal(nsdae_sim_init(sim, 1e18, q0, v0), NSDAE_E_ARGUMENT);
  assert_string_equal(nsdae_sim_error(sim)->argument, "dt");
  q0[1] = INFINITY;
  assert_int_equal(nsdae_sim_init(sim, 0, q0, v0), NSDAE_E_NONFINITE);
  assert_string_equal(nsdae_sim_error(sim)->argument, "q0");
  assert_int_equal(nsdae_sim_error(sim)->index, 1);
  nsdae_sim_destroy(&sim);
  nsdae_system_destroy(&system);
}

int main(void)
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(test_failing_callback),
      cmocka_unit_test(test_nan),
      cmocka_unit_test(test_no_step_is_small_enough),
      cmocka_unit_test(test_failing_start),
      cmocka_unit_test(test_mass_not_positive_definite),
      cmocka_unit_test(test_rank),
      cmocka_unit_test(test_observers),
      cmocka_unit_test(test_times),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
