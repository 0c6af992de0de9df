/* Every public function with what is missing or outside its range: the documented status. */
#include "check.h"

#include <time.h>

#include "bead.h"

static bead the_bead;

static nsdae_system *make_system(void)
{
  bead_default(&the_bead);
  nsdae_system *system = bead_system(&the_bead);
  assert_non_null(system);
  return system;
}

static void refused(const nsdae_system *system, const nsdae_sim_options *options, int status,
                    const char *argument)
{
  nsdae_error error;
  nsdae_sim *sim = (nsdae_sim *)&error; /* to be set to NULL */
  assert_int_equal(nsdae_sim_create(system, options, &sim, &error), status);
  assert_null(sim);
  assert_int_equal(error.status, status);
  assert_string_equal(error.argument, argument);
  assert_true(*error.text && !strchr(error.text, '\n'));
  assert_int_equal(nsdae_sim_create(system, options, &sim, NULL), status);
}

static void test_create(void **state)
{
  (void)state;
  nsdae_system *system = make_system(), *empty;
  const nsdae_dims dims = {.nq = 1};
  nsdae_error error;
  nsdae_sim *sim;
  assert_int_equal(nsdae_sim_create(NULL, NULL, &sim, &error), NSDAE_E_ARGUMENT);
  assert_string_equal(error.argument, "system");
  assert_int_equal(nsdae_sim_create(system, NULL, NULL, &error), NSDAE_E_ARGUMENT);
  assert_string_equal(error.argument, "sim");
  assert_int_equal(nsdae_sim_create(NULL, NULL, NULL, NULL), NSDAE_E_ARGUMENT);
  assert_int_equal(nsdae_system_create(&dims, &empty, NULL), NSDAE_OK);
  refused(empty, NULL, NSDAE_E_STATE, "force"); /* one of the two that are missing */
  assert_int_equal(nsdae_sim_create(system, NULL, &sim, &error), NSDAE_OK);
  assert_int_equal(error.status, NSDAE_OK);
  nsdae_sim_destroy(&sim);
  assert_null(sim);
  nsdae_sim_destroy(&sim);
  nsdae_sim_destroy(NULL);
  nsdae_system_destroy(&empty);
  nsdae_system_destroy(&system);
}

static void test_options_not_initialised(void **state)
{
  (void)state;
  const int bytes[] = {0, 0x5a, 0xff};
  nsdae_system *system = make_system();
  for (int i = 0; i < 3; i++) {
    nsdae_sim_options options;
    memset(&options, bytes[i], sizeof options);
    refused(system, &options, NSDAE_E_ARGUMENT, "options");
  }
  nsdae_system_destroy(&system);
}

static void store(const nsdae_param *param, nsdae_sim_options *options, double value)
{
  void *at = (char *)options + param->offset;
  if (param->type == NSDAE_PARAM_REAL)
    *(double *)at = value;
  else
    *(int *)at = (int)value;
}

/* Every option of the table just outside each end of its range, and NaN. */
static void test_options_outside(void **state)
{
  (void)state;
  const nsdae_params *table = nsdae_sim_options_table();
  nsdae_system *system = make_system();
  assert_true(table->n > 5);
  for (int i = 0; i < table->n; i++) {
    const nsdae_param *param = &table->entry[i];
    if (param->type == NSDAE_PARAM_TEXT) continue;
    double bad[4] = {NAN, INFINITY, param->min, param->max};
    int first = 0;
    if (param->type == NSDAE_PARAM_REAL) {
      if (!(param->open & NSDAE_OPEN_MIN)) bad[2] = nextafter(param->min, -INFINITY);
      if (!(param->open & NSDAE_OPEN_MAX)) bad[3] = nextafter(param->max, INFINITY);
    } else {
      first = 2;
      bad[2] = param->min - 1;
      bad[3] = param->max + 1;
    }
    for (int j = first; j < 4; j++) {
      nsdae_sim_options options;
      nsdae_sim_options_default(&options);
      if (isinf(bad[j]) && bad[j] == param->initial) continue; /* no bound */
      store(param, &options, bad[j]);
      refused(system, &options, NSDAE_E_ARGUMENT, param->key);
    }
  }
  nsdae_system_destroy(&system);
}

/* Table and struct agree: the defaults are in their ranges and are read back from their texts. */
static void test_options_table(void **state)
{
  (void)state;
  const nsdae_params *table = nsdae_sim_options_table();
  nsdae_sim_options options, again;
  nsdae_error error;
  nsdae_sim_options_default(&options);
  assert_int_equal(nsdae_params_check(table, &options, &error), NSDAE_OK);
  memset(&again, 0, sizeof again);
  for (int i = 0; i < table->n; i++) {
    char text[64], other[64];
    const nsdae_param *param = &table->entry[i];
    assert_true(*param->key && *param->help && !strchr(param->help, '\n'));
    for (int j = 0; j < i; j++) assert_string_not_equal(param->key, table->entry[j].key);
    nsdae_params_format(param, &options, text, sizeof text);
    assert_int_equal(nsdae_sim_options_set(&again, param->key, text, &error), NSDAE_OK);
    nsdae_params_format(param, &again, other, sizeof other);
    assert_string_equal(text, other);
  }
  assert_int_equal(nsdae_sim_options_set(&options, "dtt", "1", &error), NSDAE_E_OPTION);
  assert_non_null(strstr(error.text, "'dt'"));
  assert_int_equal(nsdae_sim_options_set(&options, "method", "morea", &error), NSDAE_E_OPTION);
  assert_non_null(strstr(error.text, "'moreau'"));
  assert_int_equal(nsdae_sim_options_set(&options, "dt", "-1", &error), NSDAE_E_ARGUMENT);
  assert_int_equal(nsdae_sim_options_set(&options, "dt", "0", &error), NSDAE_E_ARGUMENT);
  assert_int_equal(nsdae_sim_options_set(&options, "dt", "nan", &error), NSDAE_E_ARGUMENT);
  assert_int_equal(nsdae_sim_options_set(&options, NULL, "1", &error), NSDAE_E_ARGUMENT);
  assert_int_equal(nsdae_sim_options_set(&options, "dt", NULL, &error), NSDAE_E_ARGUMENT);
}

/* The choices of the option are the names of the methods. */
static void test_methods(void **state)
{
  (void)state;
  const nsdae_param *param = nsdae_params_find(nsdae_sim_options_table(), "method");
  int count = 0;
  for (; param->choices[count]; count++) {
    assert_string_equal(nsdae_method_name(count), param->choices[count]);
    assert_true(strlen(nsdae_method_summary(count)) > 10);
  }
  assert_int_equal(param->max, count - 1);
  assert_null(nsdae_method_name(count));
  assert_null(nsdae_method_name(-1));
  assert_null(nsdae_method_name(2147483647));
  assert_null(nsdae_method_summary(count));
}

static int see(const nsdae_record *record, nsdae_error *error, void *user)
{
  (void)record;
  (void)error;
  (void)user;
  return 0;
}

static void test_null_sim(void **state)
{
  (void)state;
  const double zero[3] = {0};
  nsdae_record record;
  nsdae_stats stats;
  nsdae_dims dims;
  nsdae_sim_options options;
  assert_int_equal(nsdae_sim_init(NULL, 0, zero, zero), NSDAE_E_ARGUMENT);
  assert_int_equal(nsdae_sim_observe(NULL, see, NULL), NSDAE_E_ARGUMENT);
  assert_int_equal(nsdae_sim_unobserve(NULL, see, NULL), NSDAE_E_ARGUMENT);
  assert_int_equal(nsdae_sim_step(NULL), NSDAE_E_ARGUMENT);
  assert_int_equal(nsdae_sim_run(NULL, 1), NSDAE_E_ARGUMENT);
  assert_int_equal(nsdae_sim_get_record(NULL, &record), NSDAE_E_ARGUMENT);
  assert_int_equal(nsdae_sim_get_stats(NULL, &stats), NSDAE_E_ARGUMENT);
  assert_int_equal(nsdae_sim_get_dims(NULL, &dims), NSDAE_E_ARGUMENT);
  assert_int_equal(nsdae_sim_get_options(NULL, &options), NSDAE_E_ARGUMENT);
  assert_int_equal(nsdae_sim_has_potential(NULL), 0);
  assert_int_equal(nsdae_sim_error(NULL)->status, NSDAE_E_ARGUMENT);
  assert_non_null(strstr(nsdae_sim_error(NULL)->text, "nsdae_sim_create"));
  assert_null(nsdae_sim_get_system(NULL));
}

static void test_null_arguments(void **state)
{
  (void)state;
  const double bad[] = {NAN, INFINITY, -INFINITY};
  nsdae_system *system = make_system();
  nsdae_sim *sim;
  nsdae_record record;
  double q0[3], v0[3];
  bead_start(&the_bead, q0, v0);
  assert_int_equal(nsdae_sim_create(system, NULL, &sim, NULL), NSDAE_OK);
  assert_int_equal(nsdae_sim_get_record(sim, &record), NSDAE_E_STATE);
  assert_int_equal(nsdae_sim_step(sim), NSDAE_E_STATE);
  assert_int_equal(nsdae_sim_run(sim, 1), NSDAE_E_STATE);
  assert_int_equal(nsdae_sim_init(sim, 0, NULL, v0), NSDAE_E_ARGUMENT);
  assert_string_equal(nsdae_sim_error(sim)->argument, "q0");
  assert_int_equal(nsdae_sim_init(sim, 0, q0, NULL), NSDAE_E_ARGUMENT);
  assert_string_equal(nsdae_sim_error(sim)->argument, "v0");
  for (int i = 0; i < 3; i++) {
    assert_int_equal(nsdae_sim_init(sim, bad[i], q0, v0), NSDAE_E_NONFINITE);
    assert_string_equal(nsdae_sim_error(sim)->argument, "t0");
    for (int j = 0; j < 3; j++) {
      double kept = v0[j];
      v0[j] = bad[i];
      assert_int_equal(nsdae_sim_init(sim, 0, q0, v0), NSDAE_E_NONFINITE);
      assert_string_equal(nsdae_sim_error(sim)->argument, "v0");
      assert_int_equal(nsdae_sim_error(sim)->index, j);
      v0[j] = kept;
    }
    assert_int_equal(nsdae_sim_run(sim, bad[i]), NSDAE_E_ARGUMENT);
  }
  assert_int_equal(nsdae_sim_init(sim, 0, q0, v0), NSDAE_OK);
  assert_int_equal(nsdae_sim_error(sim)->status, NSDAE_OK);
  assert_int_equal(nsdae_sim_observe(sim, NULL, NULL), NSDAE_E_ARGUMENT);
  assert_int_equal(nsdae_sim_unobserve(sim, NULL, NULL), NSDAE_OK); /* not found is no error */
  assert_int_equal(nsdae_sim_get_record(sim, NULL), NSDAE_E_ARGUMENT);
  assert_int_equal(nsdae_sim_get_stats(sim, NULL), NSDAE_E_ARGUMENT);
  assert_int_equal(nsdae_sim_get_dims(sim, NULL), NSDAE_E_ARGUMENT);
  assert_int_equal(nsdae_sim_get_options(sim, NULL), NSDAE_E_ARGUMENT);
  assert_int_equal(nsdae_sim_run(sim, 0), NSDAE_OK); /* to where it is */
  assert_int_equal(nsdae_sim_run(sim, -1), NSDAE_E_ARGUMENT);
  nsdae_sim_destroy(&sim);
  nsdae_system_destroy(&system);
}

/* States, times between, laws and failed problems, of what has none or without room for them. */
static void test_state_arguments(void **state)
{
  (void)state;
  nsdae_system *system = make_system();
  nsdae_sim *sim;
  nsdae_lcp_problem lcp;
  nsdae_step_friction friction;
  size_t size;
  double q0[3], v0[3], block[4096];
  bead_start(&the_bead, q0, v0);
  assert_int_equal(nsdae_sim_create(system, NULL, &sim, NULL), NSDAE_OK);
  assert_int_equal(nsdae_sim_state_size(NULL, &size), NSDAE_E_ARGUMENT);
  assert_int_equal(nsdae_sim_state_size(sim, NULL), NSDAE_E_ARGUMENT);
  assert_int_equal(nsdae_sim_get_state(NULL, block, 8), NSDAE_E_ARGUMENT);
  assert_int_equal(nsdae_sim_set_state(NULL, block, 8), NSDAE_E_ARGUMENT);
  assert_int_equal(nsdae_sim_get_state(sim, block, 8), NSDAE_E_STATE);
  assert_int_equal(nsdae_sim_get_friction(NULL, &friction), NSDAE_E_ARGUMENT);
  assert_int_equal(nsdae_sim_get_friction(sim, NULL), NSDAE_E_ARGUMENT);
  assert_int_equal(nsdae_sim_get_friction(sim, &friction), NSDAE_E_STATE);
  assert_int_equal(nsdae_sim_get_failed_lcp(NULL, &lcp), NSDAE_E_ARGUMENT);
  assert_int_equal(nsdae_sim_get_failed_lcp(sim, NULL), NSDAE_E_ARGUMENT);
  assert_int_equal(nsdae_sim_get_failed_lcp(sim, &lcp), NSDAE_E_STATE);
  assert_int_equal(nsdae_sim_interpolate(NULL, 0, q0, v0), NSDAE_E_ARGUMENT);
  assert_int_equal(nsdae_sim_interpolate(sim, 0, NULL, v0), NSDAE_E_ARGUMENT);
  assert_string_equal(nsdae_sim_error(sim)->argument, "q");
  assert_int_equal(nsdae_sim_interpolate(sim, 0, q0, NULL), NSDAE_E_ARGUMENT);
  assert_string_equal(nsdae_sim_error(sim)->argument, "v");
  assert_int_equal(nsdae_sim_interpolate(sim, 0, q0, v0), NSDAE_E_STATE);
  assert_int_equal(nsdae_sim_init(sim, 0, q0, v0), NSDAE_OK);
  assert_int_equal(nsdae_sim_interpolate(sim, 0, q0, v0), NSDAE_E_STATE);
  assert_int_equal(nsdae_sim_state_size(sim, &size), NSDAE_OK);
  assert_true(size <= sizeof block);
  assert_int_equal(nsdae_sim_get_state(sim, NULL, size), NSDAE_E_ARGUMENT);
  assert_string_equal(nsdae_sim_error(sim)->argument, "block");
  assert_int_equal(nsdae_sim_get_state(sim, block, size - 8), NSDAE_E_ARGUMENT);
  assert_string_equal(nsdae_sim_error(sim)->argument, "size");
  assert_int_equal(nsdae_sim_set_state(sim, NULL, size), NSDAE_E_ARGUMENT);
  assert_int_equal(nsdae_sim_get_state(sim, block, size), NSDAE_OK);
  assert_int_equal(nsdae_sim_set_state(sim, block, size), NSDAE_OK);
  nsdae_sim_destroy(&sim);
  nsdae_system_destroy(&system);
}

static int leave(const nsdae_record *record, nsdae_error *error, void *user)
{
  nsdae_sim *sim = user;
  (void)error;
  if (record->step == 3) assert_int_equal(nsdae_sim_unobserve(sim, leave, sim), NSDAE_OK);
  return 0;
}

static int count_steps(const nsdae_record *record, nsdae_error *error, void *user)
{
  long *steps = user;
  (void)error;
  assert_int_equal(record->step, *steps);
  ++*steps;
  return 0;
}

/* One that takes itself out while it is told: those behind it see every record. */
static void test_leaves(void **state)
{
  (void)state;
  nsdae_system *system = make_system();
  nsdae_sim *sim;
  long before = 0, after = 0;
  double q0[3], v0[3];
  bead_start(&the_bead, q0, v0);
  assert_int_equal(nsdae_sim_create(system, NULL, &sim, NULL), NSDAE_OK);
  assert_int_equal(nsdae_sim_observe(sim, count_steps, &before), NSDAE_OK);
  assert_int_equal(nsdae_sim_observe(sim, leave, sim), NSDAE_OK);
  assert_int_equal(nsdae_sim_observe(sim, count_steps, &after), NSDAE_OK);
  assert_int_equal(nsdae_sim_init(sim, 0, q0, v0), NSDAE_OK);
  for (int i = 0; i < 6; i++) assert_true(nsdae_sim_step(sim) >= 0);
  assert_true(before == after && after >= 6);
  nsdae_sim_destroy(&sim);
  nsdae_system_destroy(&system);
}

/* Observers are taken out by function and pointer, both; the others stay. */
static void test_unobserve(void **state)
{
  (void)state;
  nsdae_system *system = make_system();
  nsdae_sim *sim;
  int one, two;
  assert_int_equal(nsdae_sim_create(system, NULL, &sim, NULL), NSDAE_OK);
  for (int i = 0; i < NSDAE_OBSERVERS_MAX; i++)
    assert_int_equal(nsdae_sim_observe(sim, see, i == 1 ? &one : NULL), NSDAE_OK);
  assert_int_equal(nsdae_sim_unobserve(sim, see, &two), NSDAE_OK);
  assert_true(nsdae_sim_observe(sim, see, &two) < 0); /* none went */
  assert_int_equal(nsdae_sim_unobserve(sim, see, &one), NSDAE_OK);
  assert_int_equal(nsdae_sim_observe(sim, see, &two), NSDAE_OK);
  nsdae_sim_destroy(&sim);
  nsdae_system_destroy(&system);
}

static void test_trajectory(void **state)
{
  (void)state;
  const nsdae_trajectory_info info = {.model = "bead"};
  nsdae_system *system = make_system();
  nsdae_trajectory *trajectory = NULL;
  nsdae_sim *sim;
  nsdae_error error;
  double q0[3], v0[3];
  bead_start(&the_bead, q0, v0);
  assert_int_equal(nsdae_sim_create(system, NULL, &sim, NULL), NSDAE_OK);
  int status = nsdae_trajectory_create(NULL, "x.h5", &info, &trajectory, &error);
  if (status != NSDAE_E_UNSUPPORTED) {
    assert_int_equal(status, NSDAE_E_ARGUMENT);
    assert_int_equal(nsdae_trajectory_create(sim, NULL, &info, &trajectory, &error),
                     NSDAE_E_ARGUMENT);
    assert_int_equal(nsdae_trajectory_create(sim, "x.h5", NULL, &trajectory, &error),
                     NSDAE_E_ARGUMENT);
    assert_int_equal(nsdae_trajectory_create(sim, "x.h5", &info, NULL, &error), NSDAE_E_ARGUMENT);
    assert_int_equal(nsdae_trajectory_create(NULL, NULL, NULL, NULL, NULL), NSDAE_E_ARGUMENT);
    assert_int_equal(nsdae_trajectory_create(sim, "/nowhere/at/all/x.h5", &info, &trajectory, NULL),
                     NSDAE_E_IO);
  }
  assert_null(trajectory);
  assert_int_equal(nsdae_trajectory_close(NULL, 0, NULL), NSDAE_OK);
  assert_int_equal(nsdae_trajectory_close(&trajectory, 0, &error), NSDAE_OK);
  /* what was refused left no observer behind */
  assert_int_equal(nsdae_sim_init(sim, 0, q0, v0), NSDAE_OK);
  for (int i = 0; i < NSDAE_OBSERVERS_MAX; i++)
    assert_int_equal(nsdae_sim_observe(sim, see, NULL), NSDAE_OK);
  nsdae_sim_destroy(&sim);
  nsdae_system_destroy(&system);
}

/* A struct that is not there: refused or left alone. */
static void test_null_structs(void **state)
{
  (void)state;
  nsdae_error error;
  assert_int_equal(nsdae_sim_options_set(NULL, "dt", "1", &error), NSDAE_E_ARGUMENT);
  assert_int_equal(nsdae_params_set(NULL, &error, "dt", "1", &error), NSDAE_E_ARGUMENT);
  nsdae_sim_options_default(NULL);
}

static int no_matrix(double t, const double *q, double *M, int ldm, void *user)
{
  (void)t;
  (void)q;
  (void)M;
  (void)ldm;
  (void)user;
  return -1;
}

static int no_vector(double t, const double *q, double *g, void *user)
{
  (void)t;
  (void)q;
  (void)g;
  (void)user;
  return -1;
}

static int no_force(double t, const double *q, const double *v, double *F, void *user)
{
  (void)v;
  return no_vector(t, q, F, user);
}

static int no_slide(double t, const double *q, double *W, int ldw, double *w_s, void *user)
{
  (void)w_s;
  return no_matrix(t, q, W, ldw, user);
}

/* What becomes of a simulation of these sizes; that it was not made is said at once. */
static int create_of_size(const nsdae_dims *d, int method, nsdae_error *error)
{
  nsdae_sim_options options;
  nsdae_system *system;
  nsdae_sim *sim = NULL;
  assert_int_equal(nsdae_system_create(d, &system, NULL), NSDAE_OK);
  nsdae_system_set_mass(system, no_matrix);
  nsdae_system_set_force(system, no_force);
  if (d->m > 0) nsdae_system_set_constraint(system, no_vector);
  if (d->m > 0) nsdae_system_set_constraint_jacobian(system, no_matrix);
  if (d->k > 0) nsdae_system_set_gap(system, no_vector);
  if (d->k > 0) nsdae_system_set_gap_normal(system, no_matrix);
  for (int i = 0; i < d->k; i++) nsdae_system_set_contact(system, i, d->nt > 0 ? 0.3 : 0, 0.5, 0);
  if (d->k > 0 && d->nt > 0) nsdae_system_set_gap_tangent(system, no_matrix);
  if (d->f > 0) nsdae_system_set_frictional_joint_tangent(system, no_slide);
  for (int j = 0; j < d->f; j++) nsdae_system_set_frictional_joint(system, j, j, 0.3);
  nsdae_sim_options_default(&options);
  options.method = method;
  clock_t begin = clock();
  int status = nsdae_sim_create(system, &options, &sim, error);
  assert_true(clock() - begin < CLOCKS_PER_SEC); /* seconds once, to assemble what cannot be */
  assert_true(status < 0 ? sim == NULL : sim != NULL);
  nsdae_sim_destroy(&sim);
  nsdae_system_destroy(&system);
  return status;
}

/* More numbered contacts than an LCP may have rows, by one and by far. */
static void test_too_many_contacts(void **state)
{
  static const int k[] = {20001, 1 << 20};
  nsdae_error error;
  (void)state;
  for (int method = 0; method <= NSDAE_METHOD_EVENT; method++)
    for (int i = 0; i < 2; i++)
      for (int nt = 0; nt <= 1; nt++) {
        const nsdae_dims d = {.nq = 1, .k = k[i], .nt = nt};
        char rows[32];
        int status = create_of_size(&d, method, &error);
        if (status == NSDAE_E_UNSUPPORTED) continue; /* built without SUNDIALS */
        assert_int_equal(status, NSDAE_E_ARGUMENT);
        assert_string_equal(error.argument, "k");
        snprintf(rows, sizeof rows, "k = %d contacts", k[i]);
        assert_non_null(strstr(error.text, rows));
        assert_non_null(strstr(error.text, "20000"));
      }
}

/* Sizes whose products are beyond int, and their squares: nv nv, m nv, k nv, m m. What there is no
 * memory for is said; nothing overflows on the way there (UBSan looks). */
static void test_products_of_sizes(void **state)
{
  static const nsdae_dims sizes[] = {
      {.nq = 1 << 20},
      {.nq = 1 << 20, .m = 1 << 20},
      {.nq = 1 << 20, .k = 5000, .nt = 1},
      {.nq = 1 << 20, .m = 3000, .k = 3000, .nt = 2},
      {.nq = 1 << 20, .m = 1 << 20, .f = 5000},
  };
  nsdae_error error;
  (void)state;
  for (int method = 0; method <= NSDAE_METHOD_EVENT; method++)
    for (size_t i = 0; i < sizeof sizes / sizeof *sizes; i++) {
      int status = create_of_size(&sizes[i], method, &error);
      if (status >= 0 || status == NSDAE_E_UNSUPPORTED) continue; /* terabytes, or no SUNDIALS */
      assert_true(status == NSDAE_E_MEMORY || status == NSDAE_E_ARGUMENT);
      assert_true(strlen(error.text) > 0);
    }
}

int main(void)
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(test_create),
      cmocka_unit_test(test_options_not_initialised),
      cmocka_unit_test(test_options_outside),
      cmocka_unit_test(test_options_table),
      cmocka_unit_test(test_methods),
      cmocka_unit_test(test_null_sim),
      cmocka_unit_test(test_null_arguments),
      cmocka_unit_test(test_state_arguments),
      cmocka_unit_test(test_too_many_contacts),
      cmocka_unit_test(test_products_of_sizes),
      cmocka_unit_test(test_unobserve),
      cmocka_unit_test(test_leaves),
      cmocka_unit_test(test_trajectory),
      cmocka_unit_test(test_null_structs),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
