/* What is said of a contact, or of a row, has its name: coefficients refused in a simulation and
 * for a law, a state of other coefficients, a row that is refused, masses of blocks. (Faults of
 * callbacks are in faults.c, mistakes in the description in ../mistakes.) */
#include "check.h"

#include <nsdae/nsdae.h>

/* Two balls on a line, each a block, joined by a row. user: its mass. */
static int mass_blocks(double t, const double *q, double *M, void *user)
{
  (void)t, (void)q;
  M[0] = 1;
  M[1] = *(const double *)user;
  return 0;
}

static int force(double t, const double *q, const double *v, double *F, void *user)
{
  (void)t, (void)q, (void)v, (void)user;
  F[0] = F[1] = -9.81;
  return 0;
}

static int distance(double t, const double *q, double *phi, void *user)
{
  (void)t, (void)user;
  phi[0] = q[1] - q[0] - 1;
  return 0;
}

static int rows_twice(double t, const double *q, nsdae_row_list *rows, void *user)
{
  const double one = 1;
  (void)t, (void)q, (void)user;
  nsdae_row_add(rows, 0, 0, &one);
  return nsdae_row_add(rows, 0, 0, &one) < 0 ? -1 : 0;
}

static int rows(double t, const double *q, nsdae_row_list *list, void *user)
{
  const double one = 1, less = -1;
  (void)t, (void)q, (void)user;
  nsdae_row_add(list, 0, 0, &less);
  nsdae_row_add(list, 0, 1, &one);
  return 0;
}

static void expect(const nsdae_error *error, int status, const char *name)
{
  assert_int_equal(error->status, status);
  if (!strstr(error->text, name)) fail_msg("%s: not in '%s'", name, error->text);
}

static void test_blocks(void **state)
{
  (void)state;
  for (int twice = 0; twice < 2; twice++) {
    const nsdae_dims dims = {.nq = 2, .m = 1};
    const int one[] = {1, 1};
    const double q0[] = {0, 1}, v0[] = {0, 0};
    double second = twice ? 1 : -1;
    nsdae_sim_options options;
    nsdae_system *s;
    nsdae_sim *sim;
    nsdae_system_create(&dims, &s, NULL);
    nsdae_system_set_blocks(s, 2, one, one);
    nsdae_system_set_user(s, &second);
    nsdae_system_set_mass_blocks(s, mass_blocks);
    nsdae_system_set_force(s, force);
    nsdae_system_set_constraint(s, distance);
    nsdae_system_set_constraint_rows(s, twice ? rows_twice : rows);
    nsdae_system_set_name(s, NSDAE_NAME_COORDINATE, 1, "upper", "m");
    nsdae_system_set_name(s, NSDAE_NAME_CONSTRAINT, 0, "rope", "m");
    nsdae_sim_options_default(&options);
    options.start_check = 0;
    assert_int_equal(nsdae_sim_create(s, &options, &sim, NULL), NSDAE_OK);
    int status = nsdae_sim_init(sim, 0, q0, v0);
    if (status >= 0) status = nsdae_sim_step(sim);
    assert_true(status < 0);
    expect(nsdae_sim_error(sim), status, twice ? "constraint 0 \"rope\"" : "velocity 1 \"upper\"");
    nsdae_sim_destroy(&sim);
    nsdae_system_destroy(&s);
  }
}

static int mass(double t, const double *q, double *M, int ldm, void *user)
{
  (void)t, (void)q, (void)ldm, (void)user;
  M[0] = 1;
  return 0;
}

static int weight(double t, const double *q, const double *v, double *F, void *user)
{
  (void)t, (void)q, (void)v, (void)user;
  F[0] = -9.81;
  return 0;
}

static int height(double t, const double *q, double *g, void *user)
{
  (void)t, (void)user;
  g[0] = q[0] + 1;
  g[1] = q[0];
  return 0;
}

static nsdae_system *ball(void)
{
  const nsdae_dims dims = {.nq = 1, .k = 2};
  nsdae_system *s;
  nsdae_system_create(&dims, &s, NULL);
  nsdae_system_set_mass(s, mass);
  nsdae_system_set_force(s, weight);
  nsdae_system_set_gap(s, height);
  nsdae_system_set_contact(s, 0, 0, 0.5, 0);
  nsdae_system_set_name(s, NSDAE_NAME_CONTACT, 1, "floor", "m");
  return s;
}

static void test_coefficients(void **state)
{
  (void)state;
  static const char name[] = "contact 1 \"floor\"";
  const double q0 = 1, v0 = 0;
  nsdae_sim_options options;
  nsdae_system *s = ball();
  nsdae_sim *sim = NULL, *other = NULL;
  nsdae_error error;
  nsdae_sim_options_default(&options);
  options.method = NSDAE_METHOD_PENALTY;
  options.penalty_law = NSDAE_PENALTY_FLORES;
  expect((nsdae_sim_create(s, &options, &sim, &error), &error), NSDAE_E_ARGUMENT, name);
  nsdae_sim_options_default(&options);
  assert_int_equal(nsdae_sim_create(s, &options, &sim, NULL), NSDAE_OK);
  assert_int_equal(nsdae_sim_create(s, &options, &other, NULL), NSDAE_OK);
  assert_int_equal(nsdae_sim_set_contact(sim, 1, 0, 1.5, 0), NSDAE_E_ARGUMENT);
  expect(nsdae_sim_error(sim), NSDAE_E_ARGUMENT, name);
  /* a state of other coefficients */
  assert_int_equal(nsdae_sim_set_contact(sim, 1, 0, 0.25, 0), NSDAE_OK);
  assert_int_equal(nsdae_sim_init(sim, 0, &q0, &v0), NSDAE_OK);
  assert_int_equal(nsdae_sim_init(other, 0, &q0, &v0), NSDAE_OK);
  size_t size = 0;
  static char block[100000];
  assert_int_equal(nsdae_sim_state_size(sim, &size), NSDAE_OK);
  assert_true(size < sizeof block);
  assert_int_equal(nsdae_sim_get_state(sim, block, size), NSDAE_OK);
  assert_int_equal(nsdae_sim_set_state(other, block, size), NSDAE_E_ARGUMENT);
  expect(nsdae_sim_error(other), NSDAE_E_ARGUMENT, name);
  nsdae_sim_destroy(&sim);
  nsdae_sim_destroy(&other);
  nsdae_system_destroy(&s);
}

int main(void)
{
  const struct CMUnitTest tests[] = {cmocka_unit_test(test_blocks),
                                     cmocka_unit_test(test_coefficients)};
  return cmocka_run_group_tests(tests, NULL, NULL);
}
