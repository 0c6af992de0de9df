/* Making a description: sizes, setters, coefficients, what is missing. */
#include "check.h"

#include "planar.h"
#include "system_impl.h"

static void refused_dims(nsdae_dims dims, const char *name)
{
  nsdae_error error;
  nsdae_system *system = (nsdae_system *)&error; /* to be set to NULL */
  assert_int_equal(nsdae_system_create(&dims, &system, &error), NSDAE_E_ARGUMENT);
  assert_null(system);
  assert_int_equal(error.status, NSDAE_E_ARGUMENT);
  assert_string_equal(error.argument, name);
  assert_non_null(strstr(error.text, name));
  assert_int_equal(nsdae_system_create(&dims, &system, NULL), NSDAE_E_ARGUMENT);
}

static void test_sizes_outside(void **state)
{
  (void)state;
  const int huge = 2147483647;
  refused_dims((nsdae_dims){.nq = 0}, "nq");
  refused_dims((nsdae_dims){.nq = -1}, "nq");
  refused_dims((nsdae_dims){.nq = huge}, "nq");
  refused_dims((nsdae_dims){.nq = 3, .nv = 4}, "nv");
  refused_dims((nsdae_dims){.nq = 3, .nv = -1}, "nv");
  refused_dims((nsdae_dims){.nq = 3, .m = -1}, "m");
  refused_dims((nsdae_dims){.nq = 3, .m = huge}, "m");
  refused_dims((nsdae_dims){.nq = 3, .k = -1}, "k");
  refused_dims((nsdae_dims){.nq = 3, .k = huge}, "k");
  refused_dims((nsdae_dims){.nq = 3, .nt = -1}, "nt");
  refused_dims((nsdae_dims){.nq = 3, .nt = 3}, "nt");
  refused_dims((nsdae_dims){.nq = 3, .f = huge}, "f");
  refused_dims((nsdae_dims){.nq = 3, .f = -1}, "f");
}

static void test_sizes_inside(void **state)
{
  (void)state;
  const nsdae_dims good[] = {{.nq = 1},
                             {.nq = 4, .nv = 3},
                             {.nq = 3, .nv = 3, .m = 7, .f = 7},
                             {.nq = 3, .k = 100, .nt = 2},
                             {.nq = 3, .nt = 2}};
  for (size_t i = 0; i < sizeof good / sizeof *good; i++) {
    nsdae_system *system;
    nsdae_dims dims;
    assert_int_equal(nsdae_system_create(&good[i], &system, NULL), NSDAE_OK);
    assert_int_equal(nsdae_system_get_dims(system, &dims), NSDAE_OK);
    assert_int_equal(dims.nv, good[i].nv ? good[i].nv : good[i].nq);
    assert_int_equal(dims.k, good[i].k);
    assert_int_equal(nsdae_system_error(system)->status, NSDAE_OK);
    nsdae_system_destroy(&system);
    assert_null(system);
    nsdae_system_destroy(&system); /* of NULL */
  }
  nsdae_system_destroy(NULL);
}

static void test_create_null(void **state)
{
  (void)state;
  const nsdae_dims dims = {.nq = 1};
  nsdae_system *system;
  nsdae_error error;
  assert_int_equal(nsdae_system_create(NULL, &system, &error), NSDAE_E_ARGUMENT);
  assert_string_equal(error.argument, "dims");
  assert_int_equal(nsdae_system_create(&dims, NULL, &error), NSDAE_E_ARGUMENT);
  assert_string_equal(error.argument, "system");
  assert_int_equal(nsdae_system_create(NULL, NULL, NULL), NSDAE_E_ARGUMENT);
}

static int frictional_joint(double t, const double *q, double *W, int ldw, double *w, void *user)
{
  (void)t;
  (void)q;
  (void)ldw;
  (void)user;
  W[0] = w[0] = 1;
  return 0;
}

/* Every setter, with whether a system of these sizes has such a term. */
static void setters(const nsdae_dims *dims, int has_constraints, int has_gaps, int has_tangents,
                    int has_slides)
{
  nsdae_system *s;
  assert_int_equal(nsdae_system_create(dims, &s, NULL), NSDAE_OK);
#define SET(name, callback, has)                                                             \
  assert_int_equal(nsdae_system_set_##name(NULL, callback), NSDAE_E_ARGUMENT);               \
  assert_int_equal(nsdae_system_set_##name(s, NULL), NSDAE_E_ARGUMENT);                      \
  assert_string_equal(nsdae_system_error(s)->argument, #name);                               \
  assert_int_equal(nsdae_system_set_##name(s, callback), has ? NSDAE_OK : NSDAE_E_ARGUMENT); \
  assert_string_equal(nsdae_system_error(s)->argument, has ? "" : #name)
  SET(mass, planar_mass, 1);
  SET(force, planar_force, 1);
  SET(constraint, planar_constraint, has_constraints);
  SET(constraint_jacobian, planar_jacobian, has_constraints);
  SET(constraint_bias, planar_bias, has_constraints);
  SET(gap, planar_gap, has_gaps);
  SET(gap_normal, planar_normal, has_gaps);
  SET(gap_tangent, planar_tangent, has_tangents);
  SET(contact_bias, planar_contact_bias, has_gaps);
  SET(frictional_joint_tangent, frictional_joint, has_slides);
  SET(kinematics, planar_kinematics, 1);
  SET(potential, planar_potential, 1);
#undef SET
  nsdae_system_destroy(&s);
}

static void test_setters(void **state)
{
  (void)state;
  setters(&(nsdae_dims){.nq = 4}, 0, 0, 0, 0);
  setters(&(nsdae_dims){.nq = 4, .nt = 2}, 0, 0, 0, 0);
  setters(&(nsdae_dims){.nq = 4, .m = 2}, 1, 0, 0, 0);
  setters(&(nsdae_dims){.nq = 4, .m = 2, .f = 1}, 1, 0, 0, 1);
  setters(&(nsdae_dims){.nq = 4, .k = 1}, 0, 1, 0, 0);
  setters(&(nsdae_dims){.nq = 4, .k = 1, .nt = 1}, 0, 1, 1, 0);
  setters(&(nsdae_dims){.nq = 4, .m = 2, .k = 1, .nt = 2, .f = 2}, 1, 1, 1, 1);
}

static void contact(nsdae_system *s, int i, double mu, double e_n, double e_t, const char *wrong)
{
  int status = nsdae_system_set_contact(s, i, mu, e_n, e_t);
  assert_int_equal(status, wrong ? NSDAE_E_ARGUMENT : NSDAE_OK);
  assert_string_equal(nsdae_system_error(s)->argument, wrong ? wrong : "");
}

static void test_coefficients(void **state)
{
  (void)state;
  const nsdae_dims dims = {.nq = 2, .k = 2, .nt = 1};
  nsdae_system *s;
  nsdae_system_create(&dims, &s, NULL);
  contact(s, 0, 0, 0, 0, NULL);
  contact(s, 1, 100, 1, 1, NULL);
  contact(s, -1, 0, 0, 0, "i");
  contact(s, 2, 0, 0, 0, "i");
  contact(s, 0, -1e-300, 0, 0, "mu");
  contact(s, 0, NAN, 0, 0, "mu");
  contact(s, 0, INFINITY, 0, 0, "mu");
  contact(s, 0, 0, -0.1, 0, "e_n");
  contact(s, 0, 0, 1.0000001, 0, "e_n");
  contact(s, 0, 0, NAN, 0, "e_n");
  contact(s, 0, 0, 0, -0.1, "e_t");
  contact(s, 0, 0, 0, 1.1, "e_t");
  contact(s, 0, 0, 0, NAN, "e_t");
  assert_int_equal(nsdae_system_set_contact(NULL, 0, 0, 0, 0), NSDAE_E_ARGUMENT);
  /* what was refused changed nothing */
  assert_true(s->contact[0].mu == 0 && s->contact[0].e_n == 0 && s->contact[0].e_t == 0);
  assert_true(s->contact[1].mu == 100 && s->contact[1].e_n == 1 && s->contact[1].e_t == 1);
  nsdae_system_destroy(&s);
}

static void slides(nsdae_system *s, int j, int constraint, double mu, const char *wrong)
{
  int status = nsdae_system_set_frictional_joint(s, j, constraint, mu);
  assert_int_equal(status, wrong ? NSDAE_E_ARGUMENT : NSDAE_OK);
  assert_string_equal(nsdae_system_error(s)->argument, wrong ? wrong : "");
}

static void test_slides(void **state)
{
  (void)state;
  const nsdae_dims dims = {.nq = 3, .m = 2, .f = 1};
  nsdae_system *s;
  nsdae_system_create(&dims, &s, NULL);
  slides(s, 0, 1, 0.3, NULL);
  slides(s, 1, 0, 0.3, "j");
  slides(s, -1, 0, 0.3, "j");
  slides(s, 0, 2, 0.3, "constraint");
  slides(s, 0, -1, 0.3, "constraint");
  slides(s, 0, 0, -0.1, "mu");
  slides(s, 0, 0, NAN, "mu");
  slides(s, 0, 0, INFINITY, "mu");
  assert_int_equal(nsdae_system_set_frictional_joint(NULL, 0, 0, 0), NSDAE_E_ARGUMENT);
  assert_true(s->frictional_joint[0].constraint == 1 && s->frictional_joint[0].mu == 0.3);
  nsdae_system_destroy(&s);
}

/* An index that can never be right is refused in words that make sense. */
static void test_no_contacts_at_all(void **state)
{
  (void)state;
  const nsdae_dims dims = {.nq = 1};
  nsdae_system *s;
  nsdae_system_create(&dims, &s, NULL);
  contact(s, 0, 0, 0, 0, "i");
  assert_null(strstr(nsdae_system_error(s)->text, "0 .. -1"));
  nsdae_system_destroy(&s);
}

static void missing(const nsdae_system *s, const char *callback)
{
  nsdae_error error = {.status = NSDAE_OK};
  int status = nsdae_system_complete(s, &error);
  assert_int_equal(status, callback ? NSDAE_E_STATE : NSDAE_OK);
  if (callback) assert_string_equal(error.argument, callback);
  if (callback) assert_non_null(strstr(error.text, callback));
}

static void test_missing_callbacks(void **state)
{
  (void)state;
  const nsdae_dims dims = {.nq = 4, .nv = 3, .m = 1, .k = 1, .nt = 1, .f = 1};
  nsdae_system *s;
  nsdae_system_create(&dims, &s, NULL);
  nsdae_system_set_contact(s, 0, 0.1, 0, 0);
  nsdae_system_set_frictional_joint(s, 0, 0, 0.1);
  s->call.mass = planar_mass;
  s->call.force = planar_force;
  s->call.constraint = planar_constraint;
  s->call.gap = planar_gap;
  s->call.gap_tangent = planar_tangent;
  s->call.frictional_joint_tangent = frictional_joint;
  s->call.kinematics = planar_kinematics;
  missing(s, NULL);
#define WITHOUT(name)                 \
  do {                                \
    struct nsdae_system without = *s; \
    without.call.name = NULL;         \
    missing(&without, #name);         \
  } while (0)
  WITHOUT(mass);
  WITHOUT(force);
  WITHOUT(constraint);
  WITHOUT(gap);
  WITHOUT(gap_tangent);
  WITHOUT(frictional_joint_tangent);
  WITHOUT(kinematics);
#undef WITHOUT
  /* without friction no directions are needed for it */
  nsdae_system_set_contact(s, 0, 0, 0, 0);
  nsdae_system_set_frictional_joint(s, 0, 0, 0);
  s->call.gap_tangent = NULL;
  s->call.frictional_joint_tangent = NULL;
  missing(s, NULL);
  nsdae_system_destroy(&s);
}

static void test_differences_text(void **state)
{
  (void)state;
  const nsdae_dims dims = {.nq = 4, .nv = 3, .m = 2, .k = 2};
  nsdae_system *s;
  assert_string_equal(nsdae_system_differences(NULL), "");
  nsdae_system_create(&dims, &s, NULL);
  assert_string_equal(nsdae_system_differences(s),
                      "constraint_jacobian constraint_bias gap_normal contact_bias "
                      "contact_acceleration");
  nsdae_system_set_constraint_jacobian(s, planar_jacobian);
  nsdae_system_set_contact_bias(s, planar_contact_bias);
  assert_string_equal(nsdae_system_differences(s),
                      "constraint_bias gap_normal contact_acceleration");
  nsdae_system_set_constraint_bias(s, planar_bias);
  nsdae_system_set_gap_normal(s, planar_normal);
  assert_string_equal(nsdae_system_differences(s), "contact_acceleration");
  nsdae_system_set_contact_acceleration(s, planar_acceleration);
  assert_string_equal(nsdae_system_differences(s), "");
  nsdae_system_destroy(&s);
  nsdae_system_create(&(nsdae_dims){.nq = 1}, &s, NULL);
  assert_string_equal(nsdae_system_differences(s), "");
  nsdae_system_destroy(&s);
}

static void test_null_handles(void **state)
{
  (void)state;
  nsdae_dims dims;
  nsdae_system *s;
  nsdae_system_create(&(nsdae_dims){.nq = 1}, &s, NULL);
  assert_int_equal(nsdae_system_set_user(NULL, s), NSDAE_E_ARGUMENT);
  assert_int_equal(nsdae_system_set_user(s, NULL), NSDAE_OK);
  assert_int_equal(nsdae_system_get_dims(NULL, &dims), NSDAE_E_ARGUMENT);
  assert_int_equal(nsdae_system_get_dims(s, NULL), NSDAE_E_ARGUMENT);
  assert_int_equal(nsdae_system_error(NULL)->status, NSDAE_E_ARGUMENT);
  assert_non_null(strstr(nsdae_system_error(NULL)->text, "nsdae_system_create"));
  assert_int_equal(nsdae_system_simulations(NULL), 0);
  nsdae_system_clear_error(NULL);
  nsdae_system_destroy(&s);
}

int main(void)
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(test_sizes_outside),      cmocka_unit_test(test_sizes_inside),
      cmocka_unit_test(test_create_null),        cmocka_unit_test(test_setters),
      cmocka_unit_test(test_coefficients),       cmocka_unit_test(test_slides),
      cmocka_unit_test(test_no_contacts_at_all), cmocka_unit_test(test_missing_callbacks),
      cmocka_unit_test(test_differences_text),   cmocka_unit_test(test_null_handles),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
