/* nsdae_system_check of each callback alone: writes beyond its arrays, entries that it never sets,
 * values that are none, and directions that friction cannot act along. */
#include "check.h"

#include "planar.h"

/* What is wrong: entry `at` of output `term` is written (or not). */
typedef struct spoiled {
  const char *term;
  long at;
  double value;
  int skip; /* that entry is not written */
} spoiled;

static void spoil(const void *user, const char *term, double *a)
{
  const spoiled *s = user;
  if (s->term && strcmp(s->term, term) == 0 && !s->skip) a[s->at] = s->value;
}

static int skips(const void *user, const char *term, long at)
{
  const spoiled *s = user;
  return s->term && strcmp(s->term, term) == 0 && s->skip && s->at == at;
}

/* Two discs of radius 0.5 in space with a floor and a wall: q = v = (x, y, z). */
static int mass(double t, const double *q, double *M, int ldm, void *user)
{
  (void)t, (void)q;
  assert_int_equal(ldm, 3);
  M[0] = M[ldm + 1] = M[2 * ldm + 2] = 2;
  spoil(user, "mass", M);
  return 0;
}

static int force(double t, const double *q, const double *v, double *F, void *user)
{
  (void)t, (void)q, (void)v;
  F[2] = -9.81;
  spoil(user, "force", F);
  return 0;
}

static int constraint(double t, const double *q, double *phi, void *user)
{
  (void)t;
  if (!skips(user, "constraint", 0)) phi[0] = q[0] - q[1];
  spoil(user, "constraint", phi);
  return 0;
}

static int jacobian(double t, const double *q, double *J, int ldj, void *user)
{
  (void)t, (void)q;
  assert_int_equal(ldj, 1);
  J[0] = 1;
  J[ldj] = -1;
  spoil(user, "constraint_jacobian", J);
  return 0;
}

static int bias(double t, const double *q, const double *v, double *phi_t, double *omega,
                void *user)
{
  (void)t, (void)q, (void)v;
  spoil(user, "constraint_bias", phi_t);
  spoil(user, "constraint_bias omega", omega);
  return 0;
}

static int gap(double t, const double *q, double *g, void *user)
{
  (void)t;
  if (!skips(user, "gap", 0)) g[0] = q[2];
  if (!skips(user, "gap", 1)) g[1] = q[0];
  spoil(user, "gap", g);
  return 0;
}

static int gap_normal(double t, const double *q, double *W, int ldw, void *user)
{
  (void)t, (void)q;
  assert_int_equal(ldw, 3);
  W[2] = W[ldw] = 1;
  spoil(user, "gap_normal", W);
  return 0;
}

static int gap_tangent(double t, const double *q, double *W, int ldw, void *user)
{
  (void)t, (void)q;
  if (!skips(user, "gap_tangent", 0)) W[0] = 1;
  W[ldw + 1] = W[2 * ldw + 1] = W[3 * ldw + 2] = 1;
  spoil(user, "gap_tangent", W);
  return 0;
}

static int contact_bias(double t, const double *q, double *w_n, double *w_t, void *user)
{
  (void)t, (void)q;
  spoil(user, "contact_bias", w_n);
  spoil(user, "contact_bias w_t", w_t);
  return 0;
}

static int potential(double t, const double *q, double *energy, void *user)
{
  (void)t;
  if (!skips(user, "potential", 0)) energy[0] = 2 * 9.81 * q[2];
  spoil(user, "potential", energy);
  return 0;
}

static int kinematics(double t, const double *q, const double *v, double *qdot, void *user)
{
  (void)t, (void)q;
  for (int i = 0; i < 3; i++)
    if (!skips(user, "kinematics", i)) qdot[i] = v[i];
  spoil(user, "kinematics", qdot);
  return 0;
}

static nsdae_system *make(spoiled *wrong)
{
  const nsdae_dims dims = {.nq = 3, .m = 1, .k = 2, .nt = 2};
  nsdae_system *s = NULL;
  assert_int_equal(nsdae_system_create(&dims, &s, NULL), NSDAE_OK);
  nsdae_system_set_user(s, wrong);
  nsdae_system_set_mass(s, mass);
  nsdae_system_set_force(s, force);
  nsdae_system_set_constraint(s, constraint);
  nsdae_system_set_constraint_jacobian(s, jacobian);
  nsdae_system_set_constraint_bias(s, bias);
  nsdae_system_set_gap(s, gap);
  nsdae_system_set_gap_normal(s, gap_normal);
  nsdae_system_set_gap_tangent(s, gap_tangent);
  nsdae_system_set_contact_bias(s, contact_bias);
  nsdae_system_set_kinematics(s, kinematics);
  nsdae_system_set_potential(s, potential);
  nsdae_system_set_contact(s, 0, 0.3, 0, 0);
  nsdae_system_set_contact(s, 1, 0.3, 0, 0);
  nsdae_system_set_name(s, NSDAE_NAME_CONTACT, 0, "floor", "m");
  nsdae_system_set_name(s, NSDAE_NAME_CONTACT, 1, "wall", "m");
  nsdae_system_set_name(s, NSDAE_NAME_COORDINATE, 2, "height", "m");
  return s;
}

static int check(nsdae_system *s, nsdae_check *worst)
{
  const double q[3] = {0.3, -0.4, 0.7}, v[3] = {1.1, 0.2, -0.9};
  return nsdae_system_check(s, 0.4, q, v, 1e-5, worst);
}

static void test_right(void **state)
{
  (void)state;
  spoiled nothing = {0};
  nsdae_system *s = make(&nothing);
  assert_int_equal(check(s, NULL), NSDAE_OK);
  assert_int_equal(nsdae_system_error(s)->status, NSDAE_OK);
  nsdae_system_destroy(&s);
}

static const struct {
  const char *term, *argument;
  int size;
} arrays[] = {
    {"mass", "mass", 9},
    {"force", "force", 3},
    {"constraint", "constraint", 1},
    {"constraint_jacobian", "constraint_jacobian", 3},
    {"constraint_bias", "constraint_bias", 1},
    {"constraint_bias omega", "constraint_bias", 1},
    {"gap", "gap", 2},
    {"gap_normal", "gap_normal", 6},
    {"gap_tangent", "gap_tangent", 12},
    {"contact_bias", "contact_bias", 2},
    {"contact_bias w_t", "contact_bias", 4},
    {"kinematics", "kinematics", 3},
    {"potential", "potential", 1},
};

/* One entry before, one behind, one column or 60 entries behind: each is seen, and named. */
static void test_beyond(void **state)
{
  (void)state;
  for (size_t i = 0; i < sizeof arrays / sizeof *arrays; i++) {
    const long at[] = {-1, arrays[i].size, arrays[i].size + 3, arrays[i].size + 60, -40};
    const double values[] = {0, 1.5, NAN};
    for (int j = 0; j < 15; j++) {
      spoiled wrong = {.term = arrays[i].term, .at = at[j / 3], .value = values[j % 3]};
      nsdae_system *s = make(&wrong);
      const nsdae_error *error = nsdae_system_error(s);
      char place[32];
      assert_int_equal(check(s, NULL), NSDAE_E_CALLBACK);
      assert_string_equal(error->argument, arrays[i].argument);
      assert_int_equal(error->index, wrong.at);
      snprintf(place, sizeof place, "[%ld]", wrong.at);
      assert_non_null(strstr(error->text, "beyond its array"));
      assert_non_null(strstr(error->text, place));
      nsdae_system_destroy(&s);
    }
  }
}

static void test_not_finite(void **state)
{
  (void)state;
  for (size_t i = 0; i < sizeof arrays / sizeof *arrays; i++)
    for (int entry = 0; entry < 2 * arrays[i].size; entry++) {
      spoiled wrong = {
          .term = arrays[i].term, .at = entry / 2, .value = entry % 2 ? NAN : INFINITY};
      nsdae_system *s = make(&wrong);
      nsdae_check worst;
      int status = check(s, &worst);
      assert_true(status == NSDAE_E_NONFINITE || status == NSDAE_E_DERIVATIVE);
      if (status == NSDAE_E_DERIVATIVE)
        assert_int_equal(strncmp(worst.term, arrays[i].argument, strlen(arrays[i].argument)), 0);
      else
        assert_string_equal(nsdae_system_error(s)->argument, arrays[i].argument);
      if (strcmp(arrays[i].term, "gap") == 0)
        assert_non_null(
            strstr(nsdae_system_error(s)->text, entry / 2 ? "1 \"wall\"" : "0 \"floor\""));
      nsdae_system_destroy(&s);
    }
}

static void test_never_set(void **state)
{
  (void)state;
  const struct {
    const char *term, *named;
    int size;
  } needed[] = {{"constraint", "constraint 0", 1},
                {"gap", "contact ", 2},
                {"kinematics", "coordinate ", 3},
                {"potential", "energy", 1}};
  for (int i = 0; i < 4; i++)
    for (int entry = 0; entry < needed[i].size; entry++) {
      spoiled wrong = {.term = needed[i].term, .at = entry, .skip = 1};
      nsdae_system *s = make(&wrong);
      assert_int_equal(check(s, NULL), NSDAE_E_CALLBACK);
      assert_string_equal(nsdae_system_error(s)->argument, needed[i].term);
      assert_non_null(strstr(nsdae_system_error(s)->text, "never set"));
      assert_non_null(strstr(nsdae_system_error(s)->text, needed[i].named));
      assert_int_equal(nsdae_system_error(s)->index, entry);
      nsdae_system_destroy(&s);
    }
}

/* A direction that is missing, is the normal, or comes twice. Without friction none is needed. */
static void test_tangents(void **state)
{
  (void)state;
  for (int i = 0; i < 4; i++) {
    spoiled wrong = {.term = "gap_tangent", .skip = i == 0};
    if (i == 1) wrong.at = 2, wrong.value = 0; /* as it was: right */
    if (i == 2) wrong.at = 3 * 3 + 2, wrong.value = 0;
    if (i == 3) wrong.at = 0, wrong.value = -0.0; /* contact 0: (0, 0, 0) */
    nsdae_system *s = make(&wrong);
    nsdae_check worst;
    int status = check(s, &worst);
    assert_int_equal(status, i == 1 ? NSDAE_OK : NSDAE_E_DERIVATIVE);
    if (status < 0) {
      assert_string_equal(worst.term, "gap_tangent");
      assert_int_equal(worst.column, i == 2 ? 3 : 0);
      assert_non_null(strstr(nsdae_system_error(s)->text, i == 2 ? "\"wall\"" : "\"floor\""));
    }
    nsdae_system_set_contact(s, i == 2, 0, 0, 0);
    assert_int_equal(check(s, &worst), NSDAE_OK);
    nsdae_system_destroy(&s);
  }
}

static int normal_as_tangent(double t, const double *q, double *W, int ldw, void *user)
{
  (void)t, (void)q, (void)user;
  W[2] = W[ldw] = -1; /* of contact 0 */
  W[2 * ldw + 1] = W[3 * ldw + 1] = 1;
  return 0;
}

static void test_copied_tangents(void **state)
{
  (void)state;
  spoiled nothing = {0};
  nsdae_system *s = make(&nothing);
  nsdae_system_set_gap_tangent(s, normal_as_tangent);
  assert_int_equal(check(s, NULL), NSDAE_E_DERIVATIVE);
  assert_non_null(strstr(nsdae_system_error(s)->text, "is equal to the normal"));
  nsdae_system_set_contact(s, 0, 0, 0, 0);
  assert_int_equal(check(s, NULL), NSDAE_E_DERIVATIVE);
  assert_non_null(strstr(nsdae_system_error(s)->text, "is equal to the one before it"));
  nsdae_system_destroy(&s);
}

static void test_unseen(void **state)
{
  (void)state;
  spoiled nothing = {0};
  nsdae_system *s = make(&nothing);
  const char *const said[] = {"gap: ", "its sign", "force: ", "mass: ", "sign of all arms", "w_t"};
  for (size_t i = 0; i < sizeof said / sizeof *said; i++)
    assert_non_null(strstr(nsdae_system_unseen(s), said[i]));
  nsdae_system_destroy(&s);
  nsdae_system_create(&(nsdae_dims){.nq = 1}, &s, NULL);
  assert_string_equal(nsdae_system_unseen(s), "");
  assert_string_equal(nsdae_system_unseen(NULL), "");
  nsdae_system_destroy(&s);
}

/* Directions of a body that is free: each of its entries wrong in turn is seen; the rotations,
 * where there are some, and what moves only other bodies, are left alone. user: W_T of the contact,
 * 2 nv. */
typedef struct puck {
  double M[16], W[8], arm;
  int n, nt;
} puck;

static int puck_mass(double t, const double *q, double *M, int ldm, void *user)
{
  const puck *p = user;
  (void)t, (void)q;
  for (int i = 0; i < p->n; i++) M[i * ldm + i] = p->M[i];
  return 0;
}

static int puck_force(double t, const double *q, const double *v, double *F, void *user)
{
  (void)t, (void)q, (void)v, (void)F, (void)user;
  return 0;
}

/* Above a slope, by an arm that turns with the third coordinate. */
static int puck_gap(double t, const double *q, double *g, void *user)
{
  const puck *p = user;
  (void)t;
  g[0] = 0.6 * q[0] + 0.8 * q[1] + p->arm * sin(q[2]);
  return 0;
}

static int puck_tangent(double t, const double *q, double *W, int ldw, void *user)
{
  const puck *p = user;
  (void)t, (void)q;
  for (int j = 0; j < p->nt; j++)
    for (int i = 0; i < p->n; i++) W[j * ldw + i] = p->W[j * p->n + i];
  return 0;
}

static int check_puck(puck *p)
{
  const nsdae_dims dims = {.nq = p->n, .k = 1, .nt = p->nt};
  const double q[4] = {0.3, 0.2, 0.9, -0.4}, v[4] = {1, 2, 3, 4};
  nsdae_system *s = NULL;
  nsdae_system_create(&dims, &s, NULL);
  nsdae_system_set_user(s, p);
  nsdae_system_set_mass(s, puck_mass);
  nsdae_system_set_force(s, puck_force);
  nsdae_system_set_gap(s, puck_gap);
  nsdae_system_set_gap_tangent(s, puck_tangent);
  nsdae_system_set_contact(s, 0, 0.3, 0, 0);
  int status = nsdae_system_check(s, 0, q, v, 1e-5, NULL);
  if (status < 0) assert_string_equal(nsdae_system_error(s)->argument, "gap_tangent");
  nsdae_system_destroy(&s);
  return status;
}

static void test_free_bodies(void **state)
{
  (void)state;
  const puck flat = {{2, 2, 0.7, 5}, {0.8, -0.6, 0.4, 0}, 0.5, 4, 1};
  const puck solid = {{2, 2, 2, 5}, {0.8, -0.6, 0, 0, 0, 0, 1, 0.3}, 0, 4, 2};
  puck p = flat;
  assert_int_equal(check_puck(&p), NSDAE_OK);
  for (int i = 0; i < 4; i++) { /* x and y are seen, the rotation and another body are not */
    p = flat;
    p.W[i] += 0.01;
    assert_int_equal(check_puck(&p), i < 2 ? NSDAE_E_DERIVATIVE : NSDAE_OK);
    p = flat;
    p.W[i] = -p.W[i];
    assert_int_equal(check_puck(&p), i < 2 ? NSDAE_E_DERIVATIVE : NSDAE_OK);
  }
  p = solid;
  assert_int_equal(check_puck(&p), NSDAE_OK);
  for (int i = 0; i < 8; i++) {
    p = solid;
    p.W[i] += 0.01;
    assert_int_equal(check_puck(&p), i % 4 < 3 ? NSDAE_E_DERIVATIVE : NSDAE_OK);
  }
  p = solid; /* two unit vectors in the contact that are not at right angles */
  p.W[4] = 0.8 * 0.6, p.W[5] = -0.6 * 0.6, p.W[6] = 0.8;
  assert_int_equal(check_puck(&p), NSDAE_E_DERIVATIVE);
  /* masses that say nothing: a rotation's is that of the translations, or x and y are of two bodies
   */
  p = flat;
  p.M[2] = 2, p.W[0] = 3;
  assert_int_equal(check_puck(&p), NSDAE_OK);
  p.M[1] = 3;
  assert_int_equal(check_puck(&p), NSDAE_OK);
  /* the arm of a rotation, of length one here by chance */
  p = (puck){{3, 4, 2, 2}, {1, 1, 0.5, 0}, 1, 4, 1};
  assert_int_equal(check_puck(&p), NSDAE_OK);
}

int main(void)
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(test_right),      cmocka_unit_test(test_beyond),
      cmocka_unit_test(test_not_finite), cmocka_unit_test(test_never_set),
      cmocka_unit_test(test_tangents),   cmocka_unit_test(test_copied_tangents),
      cmocka_unit_test(test_unseen),     cmocka_unit_test(test_free_bodies),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
