/* No allocation in a run by anyone, BLAS, LAPACK and SUNDIALS included: malloc and its family, and
 * mmap, are replaced for the whole process. And every one of the library's own that is lost in the
 * making of a simulation survived, with nothing left behind by anyone: those alone are made to
 * fail, by --wrap, because SUNDIALS does not survive its own (SUNContext_Create of 6.4.1 follows a
 * null pointer where its logger finds no memory). The model is large enough for every LAPACK path,
 * and for the rank-revealing one its constraints are redundant. BLAS has one thread: others would
 * map their memory whenever they start. */
#define _GNU_SOURCE /* strdup */
#include "check.h"

#include <stdlib.h>

#include <nsdae/nsdae.h>

#include "allocator.h"
#include "process_allocator.h"

#if !NSDAE_PROCESS_ALLOCATOR
int main(void)
{
  return 77; /* skipped: the sanitizer has malloc, or there is no other way to it */
}
#else

/* A stack of N plates that are tied together in two halves; the lower one falls on a floor. */
enum { N = 24, TIES = N - 2, AGAIN = 2, K = 2 };

static int mass(double t, const double *q, double *M, int ldm, void *user)
{
  (void)t;
  (void)q;
  (void)user;
  for (int i = 0; i < N; i++) M[i * ldm + i] = 2;
  for (int i = 0; i + 1 < N; i++) M[i * ldm + i + 1] = M[(i + 1) * ldm + i] = 0.5;
  return 0;
}

static int force(double t, const double *q, const double *v, double *F, void *user)
{
  (void)t;
  (void)q;
  (void)v;
  (void)user;
  for (int i = 0; i < N; i++) F[i] = -20;
  return 0;
}

/* Tie i holds plates i and i + 1 together, but the halves are not tied to each other. */
static int plate_of(int tie)
{
  return tie < TIES / 2 ? tie : tie + 1;
}

static int dims_m(const void *user)
{
  return TIES + *(const int *)user;
}

static int constraint(double t, const double *q, double *phi, void *user)
{
  (void)t;
  for (int i = 0; i < dims_m(user); i++) {
    int plate = plate_of(i % TIES);
    phi[i] = q[plate + 1] - q[plate];
  }
  return 0;
}

static int jacobian(double t, const double *q, double *J, int ldj, void *user)
{
  (void)t;
  (void)q;
  for (int i = 0; i < dims_m(user); i++) {
    int plate = plate_of(i % TIES);
    J[(plate + 1) * ldj + i] = 1;
    J[plate * ldj + i] = -1;
  }
  return 0;
}

static int gap(double t, const double *q, double *g, void *user)
{
  (void)t;
  (void)user;
  g[0] = q[0];
  g[1] = q[N - 1] - q[0];
  return 0;
}

/* redundant: ties that stand twice; it must outlive the system */
static nsdae_system *make_system(int *redundant)
{
  const nsdae_dims dims = {.nq = N, .m = TIES + *redundant, .k = K};
  nsdae_system *system;
  assert_int_equal(nsdae_system_create(&dims, &system, NULL), NSDAE_OK);
  nsdae_system_set_user(system, redundant);
  nsdae_system_set_mass(system, mass);
  nsdae_system_set_force(system, force);
  nsdae_system_set_constraint(system, constraint);
  nsdae_system_set_constraint_jacobian(system, jacobian);
  nsdae_system_set_gap(system, gap);
  nsdae_system_set_contact(system, 0, 0, 0.5, 0);
  nsdae_system_set_contact(system, 1, 0, 0.5, 0);
  return system;
}

static nsdae_sim_options options_of(int method)
{
  nsdae_sim_options options;
  nsdae_sim_options_default(&options);
  options.method = method;
  options.redundant = NSDAE_REDUNDANT_LEAST_NORM;
  options.dt = 0.01;
  return options;
}

static void run(int method, int redundant)
{
  nsdae_system *system = make_system(&redundant);
  nsdae_sim_options options = options_of(method);
  nsdae_sim *sim;
  nsdae_stats stats;
  double q0[N], v0[N] = {0};
  process_allocator_reset(-1);
  allocator_reset(-1);
  int status = nsdae_sim_create(system, &options, &sim, NULL);
  long by_all = the_process.calls, by_us = the_allocator.calls;
  if (status == NSDAE_E_UNSUPPORTED) {
    nsdae_system_destroy(&system);
    return;
  }
  assert_int_equal(status, NSDAE_OK);
  assert_true(by_us > 0);
  if (method == NSDAE_METHOD_PENALTY || method == NSDAE_METHOD_EVENT)
    assert_true(by_all > by_us); /* SUNDIALS */
  for (int i = 0; i < N; i++) q0[i] = i < N / 2 ? 0.2 : 0.5;
  assert_int_equal(nsdae_sim_init(sim, 0, q0, v0), NSDAE_OK);
  process_allocator_reset(-1);
  status = nsdae_sim_run(sim, 1);
  long counted = the_process.calls; /* before cmocka has a chance to */
  /* the law of penalty does not give the e_N */
  assert_int_equal(status, method == NSDAE_METHOD_PENALTY ? NSDAE_WARN_RESTITUTION : NSDAE_OK);
  assert_int_equal(counted, 0);
  nsdae_sim_get_stats(sim, &stats);
  assert_true(stats.impacts >= 2);
  assert_int_equal(stats.rank, TIES);
  nsdae_sim_destroy(&sim);
  nsdae_system_destroy(&system);
}

/* What a shared library allocates is counted: here the C library itself. */
static void test_all_are_counted(void **state)
{
  (void)state;
  process_allocator_reset(-1);
  char *volatile copy = strdup("a block");
  long counted = the_process.calls, held = the_process.live;
  free(copy);
  long left = the_process.live;
  assert_int_equal(counted, 1);
  assert_int_equal(held, 1);
  assert_int_equal(left, 0);
}

static void test_none_in_a_run(void **state)
{
  (void)state;
  for (int method = 0; nsdae_method_name(method); method++)
    for (int redundant = 0; redundant <= AGAIN; redundant += AGAIN) run(method, redundant);
}

static void test_every_lost_one(void **state)
{
  (void)state;
  int redundant = 0;
  nsdae_system *system = make_system(&redundant);
  for (int method = 0; nsdae_method_name(method); method++) {
    nsdae_sim_options options = options_of(method);
    int status = NSDAE_E_MEMORY;
    for (long i = 0; status == NSDAE_E_MEMORY; i++) {
      nsdae_sim *sim = NULL;
      nsdae_error error;
      process_allocator_reset(-1);
      allocator_reset(i);
      status = nsdae_sim_create(system, &options, &sim, &error);
      allocator_reset(-1);
      if (status == NSDAE_E_MEMORY) assert_null(sim);
      nsdae_sim_destroy(&sim);
      long left = the_process.live;
      if (left != 0) fail_msg("%s, call %ld: %ld left", nsdae_method_name(method), i, left);
      assert_true(i < 1000);
    }
    assert_true(status == NSDAE_OK || status == NSDAE_E_UNSUPPORTED);
  }
  nsdae_system_destroy(&system);
}

int main(void)
{
  const struct CMUnitTest tests[] = {cmocka_unit_test(test_all_are_counted),
                                     cmocka_unit_test(test_none_in_a_run),
                                     cmocka_unit_test(test_every_lost_one)};
  return cmocka_run_group_tests(tests, NULL, NULL);
}

#endif
