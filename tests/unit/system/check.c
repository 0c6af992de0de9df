/* nsdae_system_check: right derivatives pass, and each one that is wrong is named. */
#include "check.h"

#include <nsdae/nsdae.h>

#include "planar.h"

enum { POINTS = 40 };

/* The comment of nsdae_system_check: good to 1e-7 for values of order one (here up to 10), and the
 * bound that it calls fair. */
static const double good_to = 1e-6, tol = 1e-5;

static void test_right(void **state)
{
  (void)state;
  nsdae_system *system = planar_system(NULL);
  for (int i = 0; i < POINTS; i++) {
    double t, q[PLANAR_NQ], v[PLANAR_NV];
    nsdae_check worst;
    planar_point(i, &t, q, v);
    assert_int_equal(nsdae_system_check(system, t, q, v, tol, &worst), NSDAE_OK);
    assert_at_most(worst.error, good_to);
    assert_int_equal(nsdae_system_check(system, t, q, v, tol, NULL), NSDAE_OK);
    assert_int_equal(nsdae_system_error(system)->status, NSDAE_OK);
  }
  nsdae_system_destroy(&system);
}

/* Entry `entry` of a term [rows x columns] is off by a little or is NaN: it is the one named. */
static void wrong_entry(const char *term, int rows, int entry, double amount)
{
  planar wrong = {.term = term, .entry = entry, .amount = amount};
  nsdae_system *system = planar_system(&wrong);
  const nsdae_error *error = nsdae_system_error(system);
  double t, q[PLANAR_NQ], v[PLANAR_NV];
  nsdae_check worst;
  planar_point(3, &t, q, v);
  assert_int_equal(nsdae_system_check(system, t, q, v, tol, &worst), NSDAE_E_DERIVATIVE);
  assert_string_equal(worst.term, term);
  assert_int_equal(worst.row, entry % rows);
  assert_int_equal(worst.column, entry / rows);
  if (isfinite(amount)) assert_near(worst.given - worst.difference, amount, good_to * 10);
  assert_true(worst.error > tol);
  assert_int_equal(error->status, NSDAE_E_DERIVATIVE);
  assert_non_null(strstr(error->text, term));
  char where[32];
  snprintf(where, sizeof where, "entry (%d, %d)", worst.row, worst.column);
  assert_non_null(strstr(error->text, where));
  nsdae_system_destroy(&system);
}

static void test_each_wrong_entry(void **state)
{
  (void)state;
  const struct {
    const char *term;
    int rows, entries;
  } terms[] = {
      {"constraint_jacobian", PLANAR_M, PLANAR_M * PLANAR_NV},
      {"constraint_bias phi_t", PLANAR_M, PLANAR_M},
      {"constraint_bias omega", PLANAR_M, PLANAR_M},
      {"gap_normal", PLANAR_NV, PLANAR_NV * PLANAR_K},
      {"contact_bias w_n", PLANAR_K, PLANAR_K},
      {"contact_acceleration", PLANAR_K, PLANAR_K},
      {"force_damping", PLANAR_NV, PLANAR_NV * PLANAR_NV},
      {"force_stiffness", PLANAR_NV, PLANAR_NV * PLANAR_NV},
  };
  const double amounts[] = {1e-2, -1, NAN, INFINITY};
  for (size_t i = 0; i < sizeof terms / sizeof *terms; i++)
    for (int entry = 0; entry < terms[i].entries; entry++)
      for (int a = 0; a < 4; a++) wrong_entry(terms[i].term, terms[i].rows, entry, amounts[a]);
}

/* Either of the two entries that differ is the wrong one. */
static void test_mass_not_symmetric(void **state)
{
  (void)state;
  for (int entry = 0; entry < PLANAR_NV * PLANAR_NV; entry++) {
    planar wrong = {.term = "mass", .entry = entry, .amount = 1e-2};
    nsdae_system *system = planar_system(&wrong);
    int row = entry % PLANAR_NV, column = entry / PLANAR_NV;
    double t, q[PLANAR_NQ], v[PLANAR_NV];
    nsdae_check worst;
    planar_point(3, &t, q, v);
    int status = nsdae_system_check(system, t, q, v, tol, &worst);
    assert_int_equal(status, row == column ? NSDAE_OK : NSDAE_E_DERIVATIVE);
    if (status < 0) {
      assert_string_equal(worst.term, "mass");
      assert_true((worst.row == row && worst.column == column) ||
                  (worst.row == column && worst.column == row));
    }
    wrong.amount = NAN;
    assert_int_equal(nsdae_system_check(system, t, q, v, tol, NULL), NSDAE_E_DERIVATIVE);
    nsdae_system_destroy(&system);
  }
}

static void test_failing_callback(void **state)
{
  (void)state;
  const char *const terms[] = {"mass",       "constraint",    "constraint_jacobian",
                               "gap_normal", "gap",           "kinematics",
                               "force",      "force_damping", "force_stiffness"};
  for (size_t i = 0; i < sizeof terms / sizeof *terms; i++)
    for (int code = -3; code <= 3; code += 6) {
      planar wrong = {.term = terms[i], .code = code};
      nsdae_system *system = planar_system(&wrong);
      double t, q[PLANAR_NQ], v[PLANAR_NV];
      planar_point(3, &t, q, v);
      assert_int_equal(nsdae_system_check(system, t, q, v, tol, NULL), NSDAE_E_CALLBACK);
      const nsdae_error *error = nsdae_system_error(system);
      assert_int_equal(error->code, code);
      assert_string_equal(error->argument, terms[i]);
      assert_true(error->time == t);
      wrong.code = 0;
      assert_int_equal(nsdae_system_check(system, t, q, v, tol, NULL), NSDAE_OK);
      nsdae_system_destroy(&system);
    }
}

static void test_arguments(void **state)
{
  (void)state;
  nsdae_system *system = planar_system(NULL);
  const double bad[] = {0, -1, NAN};
  double t, q[PLANAR_NQ], v[PLANAR_NV];
  planar_point(3, &t, q, v);
  assert_int_equal(nsdae_system_check(NULL, t, q, v, tol, NULL), NSDAE_E_ARGUMENT);
  assert_int_equal(nsdae_system_check(system, t, NULL, v, tol, NULL), NSDAE_E_ARGUMENT);
  assert_string_equal(nsdae_system_error(system)->argument, "q");
  assert_int_equal(nsdae_system_check(system, t, q, NULL, tol, NULL), NSDAE_E_ARGUMENT);
  assert_string_equal(nsdae_system_error(system)->argument, "v");
  for (int i = 0; i < 3; i++) {
    assert_int_equal(nsdae_system_check(system, t, q, v, bad[i], NULL), NSDAE_E_ARGUMENT);
    assert_string_equal(nsdae_system_error(system)->argument, "tol");
  }
  nsdae_system_destroy(&system);
}

/* With nothing but what is needed there is only the mass matrix to check. */
static void test_nothing_given(void **state)
{
  (void)state;
  const nsdae_dims dims = {.nq = PLANAR_NQ, .nv = PLANAR_NV, .m = PLANAR_M, .k = PLANAR_K};
  nsdae_system *system;
  nsdae_check worst;
  double t, q[PLANAR_NQ], v[PLANAR_NV];
  planar_point(3, &t, q, v);
  assert_int_equal(nsdae_system_create(&dims, &system, NULL), NSDAE_OK);
  assert_int_equal(nsdae_system_check(system, t, q, v, tol, &worst), NSDAE_E_STATE);
  nsdae_system_set_kinematics(system, planar_kinematics);
  nsdae_system_set_mass(system, planar_mass);
  nsdae_system_set_force(system, planar_force);
  nsdae_system_set_constraint(system, planar_constraint);
  nsdae_system_set_gap(system, planar_gap);
  assert_int_equal(nsdae_system_check(system, t, q, v, tol, &worst), NSDAE_OK);
  assert_true(worst.error == 0);
  nsdae_system_destroy(&system);
}

/* What only event uses is looked at where event starts, without the check, too. */
static void test_start_of_event(void **state)
{
  (void)state;
  for (int entry = -1; entry < PLANAR_K; entry++)
    for (int method = NSDAE_METHOD_IMPLICIT; method <= NSDAE_METHOD_EVENT; method++) {
      planar wrong = {
          .term = entry < 0 ? NULL : "contact_acceleration", .entry = entry, .amount = 0.5};
      nsdae_system *system = planar_system(&wrong);
      nsdae_sim_options options;
      nsdae_sim *sim = NULL;
      double t, q[PLANAR_NQ], v[PLANAR_NV];
      int seen = entry >= 0 && method == NSDAE_METHOD_EVENT;
      planar_point(3, &t, q, v);
      for (int i = 0; i < PLANAR_K; i++) nsdae_system_set_contact(system, i, 0, 0, 0);
      nsdae_sim_options_default(&options);
      options.method = method;
      options.start_tol = 1e300;
      if (nsdae_sim_create(system, &options, &sim, NULL) == NSDAE_OK) { /* SUNDIALS may be out */
        assert_int_equal(nsdae_sim_init(sim, t, q, v), seen ? NSDAE_E_DERIVATIVE : NSDAE_OK);
        if (seen) assert_string_equal(nsdae_sim_error(sim)->argument, "contact_acceleration");
        if (seen) assert_int_equal(nsdae_sim_error(sim)->index, entry);
      }
      nsdae_sim_destroy(&sim);
      nsdae_system_destroy(&system);
    }
}

int main(void)
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(test_right),
      cmocka_unit_test(test_each_wrong_entry),
      cmocka_unit_test(test_mass_not_symmetric),
      cmocka_unit_test(test_start_of_event),
      cmocka_unit_test(test_failing_callback),
      cmocka_unit_test(test_arguments),
      cmocka_unit_test(test_nothing_given),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
