/* Names of bodies, solids and materials: in messages and shapes; what is refused. */
#include "check.h"

#include <nsdae/nsdae.h>

static nsdae_bodies *begin(void)
{
  nsdae_bodies *b;
  assert_int_equal(nsdae_bodies_create(2, &b, NULL), NSDAE_OK);
  for (int i = 0; i < 2; i++) {
    nsdae_bodies_add(b,
                     &(nsdae_rigid_body){.mass = 1, .inertia = {0, 0, 1}, .position = {3. * i, 1}});
    nsdae_bodies_add_solid(b, i, &(nsdae_solid){.shape = NSDAE_SHAPE_DISC, .radius = 1});
  }
  return b;
}

static void test_shown(void **state)
{
  static const char *const names[] = {"crank disc 0", "tip", "spring 0"};
  static const char *const colours[] = {"#c23B22", "#000001"};
  nsdae_bodies *b = begin();
  nsdae_system *system;
  int n;
  (void)state;
  assert_int_equal(nsdae_bodies_set_name(b, NSDAE_NAMED_BODY, 0, "crank"), NSDAE_OK);
  assert_int_equal(nsdae_bodies_set_name(b, NSDAE_NAMED_SOLID, 1, "tip"), NSDAE_OK);
  for (int i = 0; i < 2; i++) /* of a body is that of its solids, unless they have one */
    assert_int_equal(nsdae_bodies_set_colour(b, NSDAE_NAMED_BODY, i, colours[0]), NSDAE_OK);
  assert_int_equal(nsdae_bodies_set_colour(b, NSDAE_NAMED_SOLID, 1, colours[1]), NSDAE_OK);
  nsdae_bodies_add_spring(b, &(nsdae_spring){.body = {0, 1}, .end = {1}, .stiffness = 1});
  nsdae_bodies_add_contact(b, 0, 1, 0, 0, 0);
  assert_int_equal(nsdae_bodies_system(b, &system), NSDAE_OK);
  const nsdae_body *shapes = nsdae_system_get_bodies(system, &n);
  assert_int_equal(n, 3);
  for (int i = 0; i < n; i++) assert_string_equal(shapes[i].name, names[i]);
  for (int i = 0; i < 2; i++) assert_string_equal(shapes[i].colour, colours[i]);
  assert_null(shapes[2].colour);
  /* ---- two centres at one place */
  nsdae_sim *sim;
  assert_int_equal(nsdae_sim_create(system, NULL, &sim, NULL), NSDAE_OK);
  const double q[6] = {0}, v[6] = {0};
  assert_int_equal(nsdae_sim_init(sim, 0, q, v), NSDAE_E_ARGUMENT);
  assert_non_null(
      strstr(nsdae_sim_error(sim)->text, "disc 0 of body 0 \"crank\", disc 1 \"tip\" of body 1"));
  nsdae_sim_destroy(&sim);
  nsdae_system_destroy(&system);
  nsdae_bodies_destroy(&b);
}

/* A likely mistake names the body; nothing is noted of an inertia that the solids can have. */
static void test_in_warnings(void **state)
{
  (void)state;
  for (int heavy = 0; heavy < 2; heavy++) {
    nsdae_bodies *b;
    nsdae_system *system;
    const double J = heavy ? 101 * 101 * 0.01 : 99 * 99 * 0.01; /* m (100 r)^2 of r = 0.1 m */
    assert_int_equal(nsdae_bodies_create(2, &b, NULL), NSDAE_OK);
    nsdae_bodies_add(b, &(nsdae_rigid_body){.mass = 1, .inertia = {0, 0, J}});
    nsdae_bodies_set_name(b, NSDAE_NAMED_BODY, 0, "crank");
    nsdae_bodies_add_solid(b, 0, &(nsdae_solid){.shape = NSDAE_SHAPE_DISC, .radius = 0.1});
    assert_int_equal(nsdae_bodies_system(b, &system), NSDAE_WARN_MODEL);
    assert_non_null(strstr(nsdae_bodies_error(b)->text,
                           heavy ? "body 0 \"crank\": the inertia 102.01 kg m^2 of the mass 1 kg "
                                   "has a radius of gyration of 10.1 m"
                                 : "body 0 \"crank\" has solids and nothing to touch"));
    nsdae_system_destroy(&system);
    nsdae_bodies_destroy(&b);
  }
}

static void test_materials(void **state)
{
  nsdae_bodies *b = begin();
  nsdae_system *system;
  char name[16]; /* m00 */
  (void)state;
  for (int twice = 0; twice < 2; twice++)
    for (int i = 0; i < NSDAE_MATERIALS; i++) {
      snprintf(name, sizeof name, "m%02d", i);
      assert_int_equal(nsdae_bodies_material(b, name), NSDAE_MATERIALS - 1 - i);
    }
  assert_int_equal(nsdae_bodies_system(b, &system), NSDAE_WARN_MODEL);
  assert_non_null(strstr(nsdae_bodies_error(b)->text, "material 'm00' has no solid"));
  nsdae_system_destroy(&system);
  nsdae_bodies_destroy(&b);
  b = begin();
  for (int i = 0; i < NSDAE_MATERIALS; i++) {
    snprintf(name, sizeof name, "m%02d", i);
    nsdae_bodies_material(b, name);
  }
  assert_int_equal(nsdae_bodies_material(b, "more"), NSDAE_E_ARGUMENT);
  nsdae_bodies_destroy(&b);
}

static void test_refused(void **state)
{
  static const struct {
    int kind, i;
    const char *name;
    int status;
  } wrong[] = {{7, 0, "a", NSDAE_E_ARGUMENT},
               {NSDAE_NAMED_BODY, 2, "a", NSDAE_E_ARGUMENT},
               {NSDAE_NAMED_SOLID, -1, "a", NSDAE_E_ARGUMENT},
               {NSDAE_NAMED_BODY, 1, "", NSDAE_E_ARGUMENT},
               {NSDAE_NAMED_BODY, 1, "disc 1", NSDAE_E_ARGUMENT},
               {NSDAE_NAMED_BODY, 1, "123456789012345678901234", NSDAE_E_ARGUMENT},
               {NSDAE_NAMED_SOLID, 1, "crank", NSDAE_E_ARGUMENT},
               {NSDAE_NAMED_BODY, 0, "other", NSDAE_E_STATE},
               {NSDAE_NAMED_BODY, 1, NULL, NSDAE_E_ARGUMENT}};
  (void)state;
  for (size_t i = 0; i < sizeof wrong / sizeof *wrong; i++) {
    nsdae_bodies *b = begin();
    assert_int_equal(nsdae_bodies_set_name(b, NSDAE_NAMED_BODY, 0, "crank"), NSDAE_OK);
    assert_int_equal(nsdae_bodies_set_name(b, wrong[i].kind, wrong[i].i, wrong[i].name),
                     wrong[i].status);
    assert_int_equal(nsdae_bodies_error(b)->status, wrong[i].status);
    nsdae_bodies_destroy(&b);
  }
}

static void test_colours_refused(void **state)
{
  static const char *const wrong[] = {"red", "", "#12345", "#1234567", "#12345g", NULL};
  (void)state;
  for (int i = 0; i < 6; i++) {
    nsdae_bodies *b = begin();
    assert_int_equal(nsdae_bodies_set_colour(b, NSDAE_NAMED_SOLID, 1, wrong[i]), NSDAE_E_ARGUMENT);
    nsdae_bodies_destroy(&b);
  }
  nsdae_bodies *b = begin();
  assert_int_equal(nsdae_bodies_set_colour(b, NSDAE_NAMED_BODY, 1, "#123456"), NSDAE_OK);
  assert_int_equal(nsdae_bodies_set_colour(b, NSDAE_NAMED_BODY, 1, "#123456"), NSDAE_E_STATE);
  nsdae_bodies_destroy(&b);
}

int main(void)
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(test_shown), cmocka_unit_test(test_in_warnings),
      cmocka_unit_test(test_materials), cmocka_unit_test(test_refused),
      cmocka_unit_test(test_colours_refused)};
  return cmocka_run_group_tests(tests, NULL, NULL);
}
