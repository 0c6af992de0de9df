/* What setters refuse is not overlooked: the first refusal is remembered, a system is constant
 * while it has simulations, and names are kept. */
#include "check.h"

#include <nsdae/nsdae.h>

#include "planar.h"
#include "system_impl.h"

static nsdae_system *ball(int nt)
{
  const nsdae_dims dims = {.nq = PLANAR_NQ, .nv = PLANAR_NV, .k = PLANAR_K, .nt = nt};
  nsdae_system *s = NULL;
  assert_int_equal(nsdae_system_create(&dims, &s, NULL), NSDAE_OK);
  nsdae_system_set_kinematics(s, planar_kinematics);
  nsdae_system_set_mass(s, planar_mass);
  nsdae_system_set_force(s, planar_force);
  nsdae_system_set_gap(s, planar_gap);
  if (nt > 0) nsdae_system_set_gap_tangent(s, planar_tangent);
  for (int i = 0; nt > 0 && i < PLANAR_K; i++) nsdae_system_set_contact(s, i, 0, 0, 0);
  return s;
}

/* The simulation is not made, for the reason that the setter had. */
static void not_made(const nsdae_system *s, int status, const char *argument, const char *where)
{
  nsdae_sim *sim = NULL;
  nsdae_error error;
  assert_int_equal(nsdae_sim_create(s, NULL, &sim, &error), status);
  assert_null(sim);
  assert_int_equal(error.status, status);
  assert_string_equal(error.argument, argument);
  assert_string_equal(error.where, where);
  assert_non_null(strstr(error.text, "was refused"));
  assert_non_null(strstr(error.text, argument));
}

static void made(const nsdae_system *s)
{
  nsdae_sim *sim = NULL;
  nsdae_error error;
  assert_int_equal(nsdae_sim_create(s, NULL, &sim, &error), NSDAE_OK);
  nsdae_sim_destroy(&sim);
}

static void test_first_refusal(void **state)
{
  (void)state;
  const double q[PLANAR_NQ] = {0, 0, 1, 0}, v[PLANAR_NV] = {0};
  nsdae_system *s = ball(0);
  made(s);
  assert_int_equal(nsdae_system_set_contact(s, 0, 0, 1.5, 0), NSDAE_E_ARGUMENT);
  assert_int_equal(nsdae_system_set_contact(s, 0, 0, 0.5, 0), NSDAE_OK); /* what came after */
  assert_int_equal(nsdae_system_set_contact(s, PLANAR_K, 0, 0, 0), NSDAE_E_ARGUMENT);
  not_made(s, NSDAE_E_ARGUMENT, "e_n", "nsdae_system_set_contact");
  assert_int_equal(nsdae_system_check(s, 0, q, v, 1e-5, NULL), NSDAE_E_ARGUMENT);
  nsdae_system_clear_error(s);
  assert_int_equal(nsdae_system_error(s)->status, NSDAE_OK);
  made(s);
  nsdae_system_destroy(&s);
}

/* Every setter that can refuse, each in a system of its own. */
static void test_every_refusal(void **state)
{
  (void)state;
  for (int i = 0; i < 10; i++) {
    nsdae_system *s = ball(0);
    const char *argument = "i", *where = "nsdae_system_set_contact";
    if (i == 0) nsdae_system_set_contact(s, PLANAR_K, 0.3, 0, 0);
    if (i == 1) nsdae_system_set_contact(s, 0, 0.3, 0, 0), argument = "mu"; /* nt = 0 */
    if (i == 2) nsdae_system_set_contact(s, 0, 0, 0, 1.1), argument = "e_t";
    if (i == 3) nsdae_system_set_mass(s, NULL), argument = "mass", where = "nsdae_system_set_mass";
    if (i == 4)
      nsdae_system_set_constraint(s, planar_constraint), argument = "constraint",
                                                         where = "nsdae_system_set_constraint";
    if (i == 5)
      nsdae_system_set_frictional_joint(s, 0, 0, 0), argument = "j",
                                                     where = "nsdae_system_set_frictional_joint";
    if (i == 8)
      nsdae_system_set_size(s, NSDAE_NAME_CONTACT, 0, NAN), argument = "size",
                                                            where = "nsdae_system_set_size";
    if (i == 9)
      nsdae_system_set_size(s, NSDAE_NAME_FRICTIONAL_JOINT, 0, 1), where = "nsdae_system_set_size";
    if (i == 6)
      nsdae_system_set_name(s, NSDAE_NAME_FRICTIONAL_JOINT, 0, "x", ""),
          where = "nsdae_system_set_name";
    if (i == 7)
      nsdae_system_set_name(s, NSDAE_NAME_COORDINATE, 0, "", ""), argument = "name",
                                                                  where = "nsdae_system_set_name";
    not_made(s, NSDAE_E_ARGUMENT, argument, where);
    nsdae_system_clear_error(s);
    made(s);
    nsdae_system_destroy(&s);
  }
}

/* With one or two directions mu and e_t are taken. */
static void test_directions(void **state)
{
  (void)state;
  for (int nt = 0; nt <= 2; nt++) {
    nsdae_system *s = ball(nt);
    int expected = nt > 0 ? NSDAE_OK : NSDAE_E_ARGUMENT;
    assert_int_equal(nsdae_system_set_contact(s, 1, 0.3, 0.5, 0), expected);
    if (nt == 0) assert_non_null(strstr(nsdae_system_error(s)->text, "nt = 1"));
    nsdae_system_destroy(&s);
  }
}

static void frozen(nsdae_system *s, int status, int simulations)
{
  char count[32];
  snprintf(count, sizeof count, "(%d now)", simulations);
  assert_int_equal(status, NSDAE_E_STATE);
  assert_int_equal(nsdae_system_error(s)->status, NSDAE_E_STATE);
  assert_non_null(strstr(nsdae_system_error(s)->text, count));
}

static void test_frozen(void **state)
{
  (void)state;
  nsdae_system *s = ball(1);
  nsdae_sim *sim[3];
  for (int i = 0; i < 3; i++) assert_int_equal(nsdae_sim_create(s, NULL, &sim[i], NULL), NSDAE_OK);
  assert_ptr_equal(nsdae_sim_get_system(sim[1]), s);
  for (int left = 3; left > 0; left--) {
    assert_int_equal(nsdae_system_simulations(s), left);
    frozen(s, nsdae_system_set_contact(s, 0, 0.3, 0.5, 0), left);
    frozen(s, nsdae_system_set_force(s, planar_force), left);
    frozen(s, nsdae_system_set_user(s, NULL), left);
    frozen(s, nsdae_system_set_name(s, NSDAE_NAME_CONTACT, 0, "floor", "m"), left);
    frozen(s, nsdae_system_set_size(s, NSDAE_NAME_CONTACT, 0, 1), left);
    assert_string_equal(nsdae_system_get_name(s, NSDAE_NAME_CONTACT, 0), "");
    nsdae_sim_destroy(&sim[left - 1]);
  }
  not_made(s, NSDAE_E_STATE, "system", "nsdae_system_set_contact");
  nsdae_system_clear_error(s);
  assert_int_equal(nsdae_system_set_contact(s, 0, 0.3, 0.5, 0), NSDAE_OK);
  made(s);
  nsdae_system_destroy(&s);
}

static int frictional_joint_tangent(double t, const double *q, double *W, int ldw, double *w_s,
                                    void *user)
{
  (void)t, (void)q, (void)W, (void)ldw, (void)w_s, (void)user;
  return 0;
}

/* Every setter, of a system that has all sizes. */
static void test_all_frozen(void **state)
{
  (void)state;
  const nsdae_dims dims = {
      .nq = PLANAR_NQ, .nv = PLANAR_NV, .m = PLANAR_M, .k = PLANAR_K, .nt = 1, .f = 1};
  nsdae_system *s;
  nsdae_sim *sim;
  assert_int_equal(nsdae_system_create(&dims, &s, NULL), NSDAE_OK);
  for (int round = 0; round < 2; round++) { /* open, then not */
    int wanted = round ? NSDAE_E_STATE : NSDAE_OK;
    assert_int_equal(nsdae_system_set_kinematics(s, planar_kinematics), wanted);
    assert_int_equal(nsdae_system_set_mass(s, planar_mass), wanted);
    assert_int_equal(nsdae_system_set_force(s, planar_force), wanted);
    assert_int_equal(nsdae_system_set_force_damping(s, planar_damping), wanted);
    assert_int_equal(nsdae_system_set_force_stiffness(s, planar_stiffness), wanted);
    assert_int_equal(nsdae_system_set_constraint(s, planar_constraint), wanted);
    assert_int_equal(nsdae_system_set_constraint_jacobian(s, planar_jacobian), wanted);
    assert_int_equal(nsdae_system_set_constraint_bias(s, planar_bias), wanted);
    assert_int_equal(nsdae_system_set_gap(s, planar_gap), wanted);
    assert_int_equal(nsdae_system_set_gap_normal(s, planar_normal), wanted);
    assert_int_equal(nsdae_system_set_gap_tangent(s, planar_tangent), wanted);
    assert_int_equal(nsdae_system_set_contact_bias(s, planar_contact_bias), wanted);
    assert_int_equal(nsdae_system_set_contact_acceleration(s, planar_acceleration), wanted);
    assert_int_equal(nsdae_system_set_frictional_joint_tangent(s, frictional_joint_tangent),
                     wanted);
    assert_int_equal(nsdae_system_set_frictional_joint(s, 0, 1, 0.1), wanted);
    assert_int_equal(nsdae_system_set_potential(s, planar_potential), wanted);
    assert_int_equal(nsdae_system_set_contact(s, 0, 0, 0, 0), wanted);
    assert_int_equal(nsdae_system_set_contact(s, 1, 0.1, 0.5, 0), wanted);
    if (round == 0) assert_int_equal(nsdae_sim_create(s, NULL, &sim, NULL), NSDAE_OK);
  }
  nsdae_sim_destroy(&sim);
  nsdae_system_destroy(&s);
}

static nsdae_system *friction(int contacts, int slides)
{
  const nsdae_dims dims = {
      .nq = PLANAR_NQ, .nv = PLANAR_NV, .m = PLANAR_M, .k = PLANAR_K, .nt = 1, .f = 1};
  nsdae_system *s = NULL;
  assert_int_equal(nsdae_system_create(&dims, &s, NULL), NSDAE_OK);
  nsdae_system_set_kinematics(s, planar_kinematics);
  nsdae_system_set_mass(s, planar_mass);
  nsdae_system_set_force(s, planar_force);
  nsdae_system_set_constraint(s, planar_constraint);
  nsdae_system_set_gap(s, planar_gap);
  nsdae_system_set_gap_tangent(s, planar_tangent);
  nsdae_system_set_frictional_joint_tangent(s, frictional_joint_tangent);
  for (int i = 0; i < contacts; i++) nsdae_system_set_contact(s, i, 0, 0, 0);
  for (int j = 0; j < slides; j++) nsdae_system_set_frictional_joint(s, j, 0, 0);
  return s;
}

/* Directions of friction without a coefficient, if only zero, are a call forgotten; the check of
 * derivatives goes without it, and where nothing rubs there is nothing to be told. */
static void test_untold(void **state)
{
  (void)state;
  const double q[PLANAR_NQ] = {0, 0.5, 1, 0}, v[PLANAR_NV] = {0.3, 0.2, 0.1};
  for (int contacts = 0; contacts <= PLANAR_K; contacts++)
    for (int slides = 0; slides <= 1; slides++) {
      nsdae_system *s = friction(contacts, slides);
      nsdae_sim *sim = NULL;
      nsdae_error error;
      int all = contacts == PLANAR_K && slides == 1;
      assert_int_equal(nsdae_sim_create(s, NULL, &sim, &error), all ? NSDAE_OK : NSDAE_E_STATE);
      assert_int_equal(nsdae_system_check(s, 0, q, v, 1e-5, NULL), NSDAE_OK);
      if (!all) {
        assert_string_equal(error.argument, contacts < PLANAR_K ? "contact" : "frictional_joint");
        assert_int_equal(error.index, contacts < PLANAR_K ? contacts : 0);
      }
      nsdae_sim_destroy(&sim);
      nsdae_system_destroy(&s);
    }
  nsdae_system *s = ball(0); /* no directions: coefficients are zero unless set */
  made(s);
  nsdae_system_destroy(&s);
}

/* What was refused a simulation holds no system. */
static void test_failed_creation_holds_nothing(void **state)
{
  (void)state;
  nsdae_sim_options options = {0};
  nsdae_system *s = ball(1);
  nsdae_sim *sim = NULL;
  assert_int_equal(nsdae_sim_create(s, &options, &sim, NULL), NSDAE_E_ARGUMENT);
  assert_int_equal(nsdae_system_simulations(s), 0);
  nsdae_system_destroy(&s);
}

/* The handle goes first: the simulation still has what it needs. */
static void test_destroyed_first(void **state)
{
  (void)state;
  const double q[PLANAR_NQ] = {0, 0.5, 1, 0}, v[PLANAR_NV] = {0};
  nsdae_system *s = ball(1);
  nsdae_sim *sim = NULL;
  assert_int_equal(nsdae_sim_create(s, NULL, &sim, NULL), NSDAE_OK);
  nsdae_system_destroy(&s);
  assert_null(s);
  assert_int_equal(nsdae_sim_init(sim, 0, q, v), NSDAE_OK);
  assert_true(nsdae_sim_run(sim, 0.1) >= 0);
  nsdae_sim_destroy(&sim);
}

static void label(const nsdae_system *s, int kind, int i, const char *name, const char *unit)
{
  assert_string_equal(nsdae_system_get_name(s, kind, i), name);
  assert_string_equal(nsdae_system_get_unit(s, kind, i), unit);
}

static void test_names(void **state)
{
  (void)state;
  const nsdae_dims dims = {.nq = 3, .m = 2, .k = 1, .f = 1};
  char name[NSDAE_NAME_SIZE] = "the name is as long as it may be, to the last ch";
  nsdae_system *s;
  name[NSDAE_NAME_SIZE - 1] = '\0';
  nsdae_system_create(&dims, &s, NULL);
  label(s, NSDAE_NAME_COORDINATE, 0, "", "");
  assert_int_equal(nsdae_system_set_name(s, NSDAE_NAME_COORDINATE, 2, "theta", "rad"), NSDAE_OK);
  assert_int_equal(nsdae_system_set_name(s, NSDAE_NAME_COORDINATE, 1, name, NULL), NSDAE_OK);
  assert_int_equal(nsdae_system_set_name(s, NSDAE_NAME_CONSTRAINT, 1, "slot", "m"), NSDAE_OK);
  assert_int_equal(nsdae_system_set_name(s, NSDAE_NAME_CONTACT, 0, "stop", "m"), NSDAE_OK);
  assert_int_equal(nsdae_system_set_name(s, NSDAE_NAME_FRICTIONAL_JOINT, 0, "slot", "m"), NSDAE_OK);
  label(s, NSDAE_NAME_COORDINATE, 0, "", "");
  label(s, NSDAE_NAME_COORDINATE, 1, name, "");
  label(s, NSDAE_NAME_COORDINATE, 2, "theta", "rad");
  label(s, NSDAE_NAME_CONSTRAINT, 1, "slot", "m");
  label(s, NSDAE_NAME_CONTACT, 0, "stop", "m");
  label(s, NSDAE_NAME_FRICTIONAL_JOINT, 0, "slot", "m");
  label(s, NSDAE_NAME_VELOCITY, 1, name, ""); /* rates of the coordinates */
  label(s, NSDAE_NAME_VELOCITY, 2, "theta", "rad/s");
  assert_int_equal(nsdae_system_set_name(s, NSDAE_NAME_VELOCITY, 2, "omega", "1/s"), NSDAE_OK);
  label(s, NSDAE_NAME_VELOCITY, 2, "omega", "1/s");
  nsdae_system_set_kinematics(s, planar_kinematics);
  label(s, NSDAE_NAME_VELOCITY, 1, "", ""); /* no longer */
  label(s, NSDAE_NAME_VELOCITY, 2, "omega", "1/s");
  label(s, NSDAE_NAME_COORDINATE, 3, "", "");
  label(s, NSDAE_NAME_COORDINATE, -1, "", "");
  label(s, 99, 0, "", "");
  label(NULL, NSDAE_NAME_COORDINATE, 0, "", "");
  nsdae_system_destroy(&s);
}

static void test_names_refused(void **state)
{
  (void)state;
  const struct {
    int kind, i;
    const char *name, *unit, *argument;
  } bad[] = {
      {NSDAE_NAME_COORDINATE, PLANAR_NQ, "x", "m", "i"},
      {NSDAE_NAME_VELOCITY, PLANAR_NV, "x", "m", "i"},
      {NSDAE_NAME_CONTACT, -1, "x", "m", "i"},
      {NSDAE_NAME_CONSTRAINT, 0, "x", "m", "i"}, /* there are none */
      {-1, 0, "x", "m", "kind"},
      {NSDAE_NAME_SENSOR, 0, "x", "m", "i"}, /* nor these */
      {NSDAE_NAME_SENSOR + 1, 0, "x", "m", "kind"},
      {NSDAE_NAME_CONTACT, 0, NULL, "m", "name"},
      {NSDAE_NAME_CONTACT, 0, "", "m", "name"},
      {NSDAE_NAME_CONTACT, 0, "a\nb", "m", "name"},
      {NSDAE_NAME_CONTACT, 0, "of forty-eight bytes, which is one more than it may", "m", "name"},
      {NSDAE_NAME_CONTACT, 0, "x", "m\x7f", "unit"},
      {NSDAE_NAME_CONTACT, 0, "x", "a unit that has no end in it", "unit"},
  };
  nsdae_system *s = ball(1);
  for (size_t i = 0; i < sizeof bad / sizeof *bad; i++) {
    assert_int_equal(nsdae_system_set_name(s, bad[i].kind, bad[i].i, bad[i].name, bad[i].unit),
                     NSDAE_E_ARGUMENT);
    assert_string_equal(nsdae_system_error(s)->argument, bad[i].argument);
    assert_null(strchr(nsdae_system_error(s)->text, '\n'));
  }
  assert_int_equal(nsdae_system_set_name(NULL, 0, 0, "x", ""), NSDAE_E_ARGUMENT);
  nsdae_system_destroy(&s);
}

static void test_names_differ(void **state)
{
  (void)state;
  nsdae_system *s = ball(1);
  nsdae_sim *sim = NULL;
  nsdae_error error;
  nsdae_system_set_name(s, NSDAE_NAME_COORDINATE, 0, "x", "m");
  nsdae_system_set_name(s, NSDAE_NAME_CONTACT, 0, "x", "m"); /* of another kind */
  made(s);
  nsdae_system_set_name(s, NSDAE_NAME_COORDINATE, 3, "x", "m");
  assert_int_equal(nsdae_sim_create(s, NULL, &sim, &error), NSDAE_E_ARGUMENT);
  assert_non_null(strstr(error.text, "coordinate 0 and coordinate 3"));
  nsdae_system_set_name(s, NSDAE_NAME_COORDINATE, 3, "y", "m");
  made(s);
  nsdae_system_destroy(&s);
}

/* M of three velocities whose entry (i, j) is off; amount relative to sqrt(M_ii M_jj). */
typedef struct spoiled {
  int i, j;
  double amount, scale[3];
} spoiled;

static int mass(double t, const double *q, double *M, int ldm, void *user)
{
  const spoiled *wrong = user;
  (void)t, (void)q;
  for (int j = 0; j < 3; j++)
    for (int i = 0; i < 3; i++)
      M[j * ldm + i] = (i == j ? 1 : 0.3) * wrong->scale[i] * wrong->scale[j];
  M[wrong->j * ldm + wrong->i] += wrong->amount * wrong->scale[wrong->i] * wrong->scale[wrong->j];
  return 0;
}

static int no_force(double t, const double *q, const double *v, double *F, void *user)
{
  (void)t, (void)q, (void)v, (void)F, (void)user;
  return 0;
}

static int start(nsdae_system *s, nsdae_error *error)
{
  const double q[3] = {0}, v[3] = {0};
  nsdae_sim *sim = NULL;
  assert_int_equal(nsdae_sim_create(s, NULL, &sim, NULL), NSDAE_OK);
  int status = nsdae_sim_init(sim, 0, q, v);
  *error = *nsdae_sim_error(sim);
  nsdae_sim_destroy(&sim);
  return status;
}

/* Each entry off the diagonal in turn, with units that are twelve orders apart: what exceeds the
 * rounding of a long sum is refused and named, what does not is taken. */
static void test_both_triangles(void **state)
{
  (void)state;
  const nsdae_dims dims = {.nq = 3};
  const double amounts[] = {-0.3, 0.1, -1e-11, 1e-13, NAN};
  spoiled wrong = {.scale = {1, 1e-6, 1e6}};
  nsdae_system *s;
  nsdae_system_create(&dims, &s, NULL);
  nsdae_system_set_user(s, &wrong);
  nsdae_system_set_mass(s, mass);
  nsdae_system_set_force(s, no_force);
  nsdae_system_set_name(s, NSDAE_NAME_COORDINATE, 2, "theta", "rad");
  for (int entry = 0; entry < 9; entry++)
    for (int a = 0; a < 5; a++) {
      char text[64];
      nsdae_error error;
      wrong.i = entry % 3;
      wrong.j = entry / 3;
      wrong.amount = amounts[a];
      int status = start(s, &error);
      if (a == 4) assert_int_equal(status, NSDAE_E_NONFINITE);
      if (a == 4 || wrong.i == wrong.j) continue;
      assert_int_equal(status, a < 3 ? NSDAE_E_MASS : NSDAE_OK);
      if (status == NSDAE_OK) continue;
      int row = wrong.i > wrong.j ? wrong.i : wrong.j, column = wrong.i + wrong.j - row;
      snprintf(text, sizeof text, "M(%d, %d) = ", row, column);
      assert_non_null(strstr(error.text, text));
      assert_non_null(strstr(error.text, "both triangles"));
      if (row == 2) assert_non_null(strstr(error.text, "\"theta\""));
      assert_int_equal(error.index, column * 3 + row);
    }
  nsdae_system_destroy(&s);
}

/* Of no system each says so. */
static void test_no_system(void **state)
{
  nsdae_body body = {.name = "none"};
  (void)state;
  assert_int_equal(nsdae_system_set_user(NULL, NULL), NSDAE_E_ARGUMENT);
  assert_int_equal(nsdae_system_set_mass(NULL, NULL), NSDAE_E_ARGUMENT);
  assert_int_equal(nsdae_system_set_force(NULL, NULL), NSDAE_E_ARGUMENT);
  assert_int_equal(nsdae_system_set_constraint(NULL, NULL), NSDAE_E_ARGUMENT);
  assert_int_equal(nsdae_system_set_constraint_jacobian(NULL, NULL), NSDAE_E_ARGUMENT);
  assert_int_equal(nsdae_system_set_constraint_bias(NULL, NULL), NSDAE_E_ARGUMENT);
  assert_int_equal(nsdae_system_set_gap(NULL, NULL), NSDAE_E_ARGUMENT);
  assert_int_equal(nsdae_system_set_gap_normal(NULL, NULL), NSDAE_E_ARGUMENT);
  assert_int_equal(nsdae_system_set_gap_tangent(NULL, NULL), NSDAE_E_ARGUMENT);
  assert_int_equal(nsdae_system_set_contact_bias(NULL, NULL), NSDAE_E_ARGUMENT);
  assert_int_equal(nsdae_system_set_contact_acceleration(NULL, NULL), NSDAE_E_ARGUMENT);
  assert_int_equal(nsdae_system_set_frictional_joint_tangent(NULL, NULL), NSDAE_E_ARGUMENT);
  assert_int_equal(nsdae_system_set_kinematics(NULL, NULL), NSDAE_E_ARGUMENT);
  assert_int_equal(nsdae_system_set_potential(NULL, NULL), NSDAE_E_ARGUMENT);
  assert_int_equal(nsdae_system_set_contact(NULL, 0, 0, 0, 0), NSDAE_E_ARGUMENT);
  assert_int_equal(nsdae_system_set_frictional_joint(NULL, 0, 0, 0), NSDAE_E_ARGUMENT);
  assert_int_equal(nsdae_system_set_name(NULL, 0, 0, "a", "m"), NSDAE_E_ARGUMENT);
  assert_int_equal(nsdae_system_add_body(NULL, &body), NSDAE_E_ARGUMENT);
}

/* What has no name, no kind, or nobody to be told leaves the text as it is. */
static void test_nothing_to_name(void **state)
{
  (void)state;
  const nsdae_dims dims = {.nq = 1, .nv = 1, .k = 1};
  nsdae_system *system;
  nsdae_error error = {.text = "as it was"};
  assert_int_equal(nsdae_system_create(&dims, &system, NULL), NSDAE_OK);
  assert_int_equal(nsdae_system_count(system, -1), 0);
  assert_int_equal(nsdae_system_count(system, NSDAE_NAME_KINDS), 0);
  nsdae_system_name_item(system, NSDAE_NAME_CONTACT, 0, NULL);
  nsdae_system_name_entry(system, "gap", 1, 0, 0, NULL);
  nsdae_system_name_entry(system, "no callback", 1, 0, 0, &error);
  nsdae_system_name_entry(system, "gap", 77, 0, 0, &error);
  assert_string_equal(error.text, "as it was");
  nsdae_system_destroy(&system);
}

int main(void)
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(test_no_system),       cmocka_unit_test(test_first_refusal),
      cmocka_unit_test(test_every_refusal),   cmocka_unit_test(test_directions),
      cmocka_unit_test(test_frozen),          cmocka_unit_test(test_all_frozen),
      cmocka_unit_test(test_untold),          cmocka_unit_test(test_failed_creation_holds_nothing),
      cmocka_unit_test(test_destroyed_first), cmocka_unit_test(test_names),
      cmocka_unit_test(test_names_refused),   cmocka_unit_test(test_names_differ),
      cmocka_unit_test(test_nothing_to_name), cmocka_unit_test(test_both_triangles),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
