/* Lists of contacts and of rows of Phi_q that callbacks fill wrongly, each mistake in turn: by
 * nsdae_system_check, by the start and by a step it is the same status, with the argument named,
 * the first of several told, and the state of before. */
#include "check.h"

#include <nsdae/nsdae.h>

enum { NV = 8, WIDE = 7 };

enum mistake {
  NONE,
  ROW_BELOW,
  ROW_BEYOND,
  ROWS_DESCEND,
  ROW_BLOCK_BELOW,
  ROW_BLOCK_BEYOND,
  ROW_NULL,
  ROW_NAN,
  ROW_TWICE,
  ROWS_TWO_MISTAKES,
  ROWS_OF_NONE,
  ROWS_FAIL,
  CONTACT_BLOCK_BELOW,
  CONTACT_BLOCK_BEYOND,
  CONTACT_ITSELF,
  CONTACT_NOT_WIDE,
  CONTACT_MU_NAN,
  CONTACT_MU_INFINITE,
  CONTACT_E_N,
  CONTACT_E_T,
  CONTACT_GAP,
  CONTACT_NONE,
  CONTACT_TWO_MISTAKES,
  CONTACTS_FAIL
};

/* A point mass over the ground, and seven more velocities, two of which are held. */
typedef struct model {
  enum mistake what;
  int begin, calls; /* right until so many calls of the list that is wrong */
  int more;         /* grows with each call */
} model;

static int mass_blocks(double t, const double *q, double *M, void *user)
{
  (void)t, (void)q, (void)user;
  M[0] = 1;
  for (int i = 0; i < WIDE; i++) M[1 + 8 * i] = 2;
  return 0;
}

static int force(double t, const double *q, const double *v, double *f, void *user)
{
  (void)t, (void)q, (void)v, (void)user;
  f[0] = -9.81;
  return 0;
}

static int constraint(double t, const double *q, double *phi, void *user)
{
  (void)t, (void)user;
  phi[0] = q[1];
  phi[1] = q[2];
  return 0;
}

static enum mistake now(model *p, enum mistake first, enum mistake last)
{
  if (p->what < first || p->what > last) return NONE;
  return p->calls++ < p->begin ? NONE : p->what;
}

static int rows(double t, const double *q, nsdae_row_list *list, void *user)
{
  static const double one[WIDE] = {1}, two[WIDE] = {0, 1}, zero[1] = {0}, bad[1] = {NAN};
  enum mistake what = now(user, ROW_BELOW, ROWS_FAIL);
  (void)t, (void)q;
  if (what == ROWS_FAIL) return -3;
  if (what == ROW_BELOW) nsdae_row_add(list, -1, 0, zero);
  if (what == ROW_BLOCK_BELOW) nsdae_row_add(list, 0, -1, zero);
  if (what == ROW_BLOCK_BEYOND) nsdae_row_add(list, 0, 2, zero);
  if (what == ROW_NULL || what == ROWS_TWO_MISTAKES) nsdae_row_add(list, 0, 0, NULL);
  if (what == ROW_NAN || what == ROWS_TWO_MISTAKES) nsdae_row_add(list, 0, 0, bad);
  if (what == ROWS_OF_NONE) assert_int_equal(nsdae_row_add(NULL, 0, 0, zero), NSDAE_E_ARGUMENT);
  if (what == ROWS_DESCEND) nsdae_row_add(list, 1, 1, two);
  nsdae_row_add(list, 0, 1, one);
  if (what == ROW_TWICE) nsdae_row_add(list, 0, 1, two);
  nsdae_row_add(list, 1, 1, two);
  if (what == ROW_BEYOND) nsdae_row_add(list, 2, 1, two);
  return 0;
}

static int contacts(double t, const double *q, const double *v, double reach,
                    nsdae_contact_list *list, void *user)
{
  static const double along[2 * WIDE] = {0, 0, -1}; /* that of friction: none */
  enum mistake what = now(user, CONTACT_BLOCK_BELOW, CONTACTS_FAIL);
  nsdae_contact c = {.id = 4, .block = {0, -1}, .gap = q[0], .mu = 0.3, .e_n = 0.5};
  nsdae_contact joint = {.id = 9, .block = {0, 1}, .gap = 2 + q[0] - q[3]};
  (void)t, (void)v, (void)reach;
  if (what == CONTACTS_FAIL) return 2;
  c.direction[0][0][0] = joint.direction[0][0][0] = 1;
  joint.wide[1] = along;
  if (what == CONTACT_BLOCK_BELOW) c.block[1] = -2;
  if (what == CONTACT_BLOCK_BEYOND) c.block[1] = 2;
  if (what == CONTACT_ITSELF) c.block[1] = 0;
  if (what == CONTACT_NOT_WIDE) joint.wide[1] = NULL;
  if (what == CONTACT_MU_NAN || what == CONTACT_TWO_MISTAKES) c.mu = NAN;
  if (what == CONTACT_MU_INFINITE) c.mu = INFINITY;
  if (what == CONTACT_E_N) c.e_n = -0.5;
  if (what == CONTACT_E_T) c.e_t = 1.5;
  if (what == CONTACT_GAP || what == CONTACT_TWO_MISTAKES) joint.gap = INFINITY;
  if (what == CONTACT_NONE) {
    assert_int_equal(nsdae_contact_add(list, NULL), NSDAE_E_ARGUMENT);
    assert_int_equal(nsdae_contact_add(NULL, &c), NSDAE_E_ARGUMENT);
  }
  nsdae_contact_add(list, &c);
  nsdae_contact_add(list, &joint);
  return 0;
}

static nsdae_system *make(model *p)
{
  const nsdae_dims dims = {.nq = NV, .m = 2, .nt = 1};
  const int size[] = {1, WIDE};
  nsdae_system *s;
  assert_int_equal(nsdae_system_create(&dims, &s, NULL), NSDAE_OK);
  assert_int_equal(nsdae_system_set_blocks(s, 2, size, size), NSDAE_OK);
  nsdae_system_set_user(s, p);
  nsdae_system_set_mass_blocks(s, mass_blocks);
  nsdae_system_set_force(s, force);
  nsdae_system_set_constraint(s, constraint);
  nsdae_system_set_constraint_rows(s, rows);
  nsdae_system_set_contacts(s, contacts);
  return s;
}

static const double q0[NV] = {0.1, 0, 0, 1}, v0[NV] = {0, 0, 0, 1};

typedef struct wanted {
  enum mistake what;
  int status;
  const char *argument;
} wanted;

static const wanted all[] = {{ROW_BELOW, NSDAE_E_ARGUMENT, "row"},
                             {ROW_BEYOND, NSDAE_E_ARGUMENT, "row"},
                             {ROWS_DESCEND, NSDAE_E_ARGUMENT, "row"},
                             {ROW_BLOCK_BELOW, NSDAE_E_ARGUMENT, "block"},
                             {ROW_BLOCK_BEYOND, NSDAE_E_ARGUMENT, "block"},
                             {ROW_NULL, NSDAE_E_ARGUMENT, "value"},
                             {ROW_NAN, NSDAE_E_NONFINITE, "value"},
                             {ROW_TWICE, NSDAE_E_ARGUMENT, "block"},
                             {ROWS_TWO_MISTAKES, NSDAE_E_ARGUMENT, "value"},
                             {ROWS_OF_NONE, NSDAE_OK, ""},
                             {ROWS_FAIL, NSDAE_E_CALLBACK, "constraint_rows"},
                             {CONTACT_BLOCK_BELOW, NSDAE_E_ARGUMENT, "block"},
                             {CONTACT_BLOCK_BEYOND, NSDAE_E_ARGUMENT, "block"},
                             {CONTACT_ITSELF, NSDAE_E_ARGUMENT, "block"},
                             {CONTACT_NOT_WIDE, NSDAE_E_ARGUMENT, "wide"},
                             {CONTACT_MU_NAN, NSDAE_E_ARGUMENT, "mu"},
                             {CONTACT_MU_INFINITE, NSDAE_E_ARGUMENT, "mu"},
                             {CONTACT_E_N, NSDAE_E_ARGUMENT, "e_n"},
                             {CONTACT_E_T, NSDAE_E_ARGUMENT, "e_t"},
                             {CONTACT_GAP, NSDAE_E_NONFINITE, "gap"},
                             {CONTACT_NONE, NSDAE_OK, ""},
                             {CONTACT_TWO_MISTAKES, NSDAE_E_ARGUMENT, "mu"},
                             {CONTACTS_FAIL, NSDAE_E_CALLBACK, "contacts"}};
enum { ALL = sizeof all / sizeof *all };

static void expect(const nsdae_error *error, int status, const wanted *w)
{
  if (status != w->status || strcmp(error->argument, w->argument) != 0)
    fail_msg("mistake %d: status %d, '%s': %s", w->what, status, error->argument, error->text);
  assert_int_equal(error->status, w->status);
  assert_int_equal(w->status<0, strlen(error->text)> 10);
}

static void test_check(void **state)
{
  (void)state;
  for (int i = 0; i < ALL; i++)
    for (int begin = 0; begin < 6; begin++) {
      model p = {.what = all[i].what, .begin = begin};
      nsdae_system *s = make(&p);
      int status = nsdae_system_check(s, 0, q0, v0, 1e-5, NULL), met = p.calls > begin;
      const wanted none = {all[i].what, NSDAE_OK, ""};
      expect(nsdae_system_error(s), status, met ? &all[i] : &none);
      nsdae_system_destroy(&s);
    }
}

/* Wrong in call `begin` and right again: the step is not done, and then it is. */
static void attack(const wanted *w, int method, int begin)
{
  model p = {.what = w->what, .begin = begin};
  nsdae_sim_options options;
  nsdae_sim *sim;
  nsdae_record r;
  nsdae_system *s = make(&p);
  nsdae_sim_options_default(&options);
  options.method = method;
  assert_int_equal(nsdae_sim_create(s, &options, &sim, NULL), NSDAE_OK);
  int status = nsdae_sim_init(sim, 0, q0, v0), steps = 0;
  while (status >= 0 && steps < 10 && (status = nsdae_sim_step(sim)) >= 0) steps++;
  if (p.calls > begin && w->status < 0)
    expect(nsdae_sim_error(sim), status, w);
  else
    assert_true(status >= 0 && steps == 10);
  p.what = NONE;
  if (nsdae_sim_get_record(sim, &r) == NSDAE_OK) {
    assert_int_equal(r.step, steps);
    assert_true(nsdae_sim_step(sim) >= 0);
  }
  nsdae_sim_destroy(&sim);
  nsdae_system_destroy(&s);
}

static void test_steps(void **state)
{
  (void)state;
  const int method[] = {NSDAE_METHOD_IMPLICIT, NSDAE_METHOD_IMPLICIT_PRINTED, NSDAE_METHOD_MOREAU};
  for (int i = 0; i < ALL; i++)
    for (int m = 0; m < 3; m++)
      for (int begin = 0; begin < 12; begin++) attack(&all[i], method[m], begin);
}

/* ---- lists that are longer whenever they are asked for again, and shorter */

static int more_rows(double t, const double *q, nsdae_row_list *list, void *user)
{
  static const double one[WIDE] = {1}, zero[1] = {0};
  model *p = user;
  (void)t, (void)q;
  for (int i = 0; i <= p->more && i < 4; i++) nsdae_row_add(list, i / 2, i % 2, i % 2 ? one : zero);
  p->more++;
  return 0;
}

static int more_contacts(double t, const double *q, const double *v, double reach,
                         nsdae_contact_list *list, void *user)
{
  model *p = user;
  (void)t, (void)v, (void)reach;
  for (int i = 0; i <= p->more; i++) {
    nsdae_contact c = {.id = i, .block = {0, -1}, .gap = q[0]};
    c.direction[0][0][0] = 1;
    nsdae_contact_add(list, &c);
  }
  p->more++;
  return 0;
}

static void test_more_each_time(void **state)
{
  (void)state;
  for (int which = 0; which < 2; which++) {
    model p = {.what = NONE};
    nsdae_system *s = make(&p);
    if (which == 0) nsdae_system_set_constraint_rows(s, more_rows);
    if (which == 1) nsdae_system_set_contacts(s, more_contacts);
    assert_int_equal(nsdae_system_check(s, 0, q0, v0, 1e-5, NULL), NSDAE_E_CALLBACK);
    assert_string_equal(nsdae_system_error(s)->argument, which ? "contacts" : "constraint_rows");
    assert_non_null(strstr(nsdae_system_error(s)->text, "called again"));
    nsdae_system_destroy(&s);
  }
}

/* ---- one id twice in a list */

static int one_twice(double t, const double *q, const double *v, double reach,
                     nsdae_contact_list *list, void *user)
{
  const model *p = user;
  nsdae_contact c = {.id = 7, .block = {0, -1}, .gap = q[0]};
  (void)t, (void)v;
  c.direction[0][0][0] = 1;
  if (c.gap <= reach) nsdae_contact_add(list, &c);
  c.gap += p->more * 1e-3;
  if (c.gap <= reach) nsdae_contact_add(list, &c);
  return 0;
}

static void test_one_twice(void **state)
{
  (void)state;
  const int method[] = {NSDAE_METHOD_IMPLICIT, NSDAE_METHOD_EVENT, NSDAE_METHOD_PENALTY};
  for (int i = 0; i < 9; i++) {
    model p = {.what = NONE, .more = i / 3};
    nsdae_system *s = make(&p);
    nsdae_sim_options options;
    nsdae_sim *sim;
    nsdae_system_set_contacts(s, one_twice);
    nsdae_sim_options_default(&options);
    options.method = method[i % 3];
    assert_int_equal(nsdae_sim_create(s, &options, &sim, NULL), NSDAE_OK);
    int status = nsdae_sim_init(sim, 0, q0, v0);
    if (status == NSDAE_OK) status = nsdae_sim_run(sim, 1);
    assert_int_equal(status, NSDAE_E_ARGUMENT);
    assert_string_equal(nsdae_sim_error(sim)->argument, "id");
    nsdae_sim_destroy(&sim);
    nsdae_system_destroy(&s);
  }
}

/* ---- rows that have more parts later */

enum { POINTS = 6 };

static int point_masses(double t, const double *q, double *M, void *user)
{
  (void)t, (void)q, (void)user;
  for (int i = 0; i < POINTS; i++) M[i] = 1;
  return 0;
}

static int all_fall(double t, const double *q, const double *v, double *f, void *user)
{
  (void)t, (void)q, (void)v, (void)user;
  for (int i = 1; i < POINTS; i++) f[i] = -1;
  return 0;
}

/* The first point is held; the others have zeros in its row as soon as the last one has fallen. */
static int row_of_first(double t, const double *q, nsdae_row_list *list, void *user)
{
  static const double one = 1, zero = 0;
  (void)t, (void)user;
  nsdae_row_add(list, 0, 0, &one);
  for (int b = 1; b < POINTS && q[POINTS - 1] < 0.7; b++) nsdae_row_add(list, 0, b, &zero);
  return 0;
}

static int same_of_joint(double t, const double *q, nsdae_row_list *list, double *w, void *user)
{
  (void)w;
  return row_of_first(t, q, list, user);
}

static int hold_first(double t, const double *q, double *phi, void *user)
{
  (void)t, (void)user;
  phi[0] = q[0];
  return 0;
}

/* The list has no room inside a step of event and penalty: q = 1 - t^2 / 2 all the same. */
static void fall_on(int method, int of_joint)
{
  const nsdae_dims dims = {.nq = POINTS, .nv = POINTS, .m = 1, .f = of_joint};
  const int size[POINTS] = {1, 1, 1, 1, 1, 1};
  double q[POINTS] = {0, 1, 1, 1, 1, 1}, v[POINTS] = {0};
  nsdae_sim_options options;
  nsdae_system *s;
  nsdae_sim *sim;
  nsdae_record r;
  assert_int_equal(nsdae_system_create(&dims, &s, NULL), NSDAE_OK);
  nsdae_system_set_blocks(s, POINTS, size, size);
  nsdae_system_set_mass_blocks(s, point_masses);
  nsdae_system_set_force(s, all_fall);
  nsdae_system_set_constraint(s, hold_first);
  nsdae_system_set_constraint_rows(s, row_of_first);
  if (of_joint) nsdae_system_set_joint_friction_rows(s, same_of_joint);
  if (of_joint) nsdae_system_set_frictional_joint(s, 0, 0, 0.1);
  nsdae_sim_options_default(&options);
  options.method = method;
  options.dt = 0.05;
  assert_int_equal(nsdae_sim_create(s, &options, &sim, NULL), NSDAE_OK);
  int status = nsdae_sim_init(sim, 0, q, v);
  if (status == NSDAE_OK) status = nsdae_sim_run(sim, 1);
  if (status < 0) print_message("%s\n", nsdae_sim_error(sim)->text);
  assert_int_equal(status, NSDAE_OK);
  nsdae_sim_get_record(sim, &r);
  for (int i = 0; i < POINTS; i++) assert_near(r.q[i], i > 0 ? 0.5 : 0, 1e-9);
  nsdae_sim_destroy(&sim);
  nsdae_system_destroy(&s);
}

static void test_longer_rows(void **state)
{
  (void)state;
  for (int of_joint = 0; of_joint < 2; of_joint++) {
    fall_on(NSDAE_METHOD_IMPLICIT, of_joint);
    fall_on(NSDAE_METHOD_PENALTY, of_joint);
    fall_on(NSDAE_METHOD_EVENT, of_joint);
  }
}

/* Of three masses over the ground those below 1 are listed, in descending order every other time:
 * what is listed on one side of the point alone says nothing, and the others are found by id. */
static int some_contacts(double t, const double *q, const double *v, double reach,
                         nsdae_contact_list *list, void *user)
{
  model *p = user;
  (void)t, (void)v, (void)reach;
  p->more++;
  for (int i = 0; i < 3; i++) {
    int k = p->more % 2 ? i : 2 - i;
    nsdae_contact c = {.id = k, .block = {0, -1}, .gap = q[0] + k};
    c.direction[0][0][0] = 1;
    if (k < 2 || q[0] < q0[0]) nsdae_contact_add(list, &c);
  }
  return 0;
}

static void test_some_not_listed(void **state)
{
  (void)state;
  model p = {.what = NONE};
  nsdae_system *s = make(&p);
  nsdae_system_set_contacts(s, some_contacts);
  assert_int_equal(nsdae_system_check(s, 0, q0, v0, 1e-5, NULL), NSDAE_OK);
  nsdae_system_destroy(&s);
}

/* ---- setters of such systems */

static void test_setters(void **state)
{
  (void)state;
  const int size[] = {1, WIDE}, short_q[] = {1, WIDE - 1}, large_q[] = {2, WIDE};
  nsdae_dims dims = {.nq = NV, .k = 1, .f = 1, .m = 1};
  nsdae_sim *sim;
  model p = {.what = NONE};
  nsdae_system *s = make(&p);
  assert_int_equal(nsdae_system_set_blocks(NULL, 2, size, size), NSDAE_E_ARGUMENT);
  assert_int_equal(nsdae_system_set_mass_blocks(NULL, mass_blocks), NSDAE_E_ARGUMENT);
  assert_int_equal(nsdae_system_set_constraint_rows(NULL, rows), NSDAE_E_ARGUMENT);
  assert_int_equal(nsdae_system_set_contacts(NULL, contacts), NSDAE_E_ARGUMENT);
  assert_int_equal(nsdae_system_set_force_damping_blocks(NULL, NULL), NSDAE_E_ARGUMENT);
  assert_int_equal(nsdae_system_set_force_stiffness_blocks(NULL, NULL), NSDAE_E_ARGUMENT);
  assert_int_equal(nsdae_system_get_blocks(NULL), 0);
  assert_int_equal(nsdae_sim_create(s, NULL, &sim, NULL), NSDAE_OK);
  assert_int_equal(nsdae_system_set_blocks(s, 2, size, size), NSDAE_E_STATE);
  assert_int_equal(nsdae_system_set_mass_blocks(s, mass_blocks), NSDAE_E_STATE);
  assert_int_equal(nsdae_system_set_constraint_rows(s, rows), NSDAE_E_STATE);
  assert_int_equal(nsdae_system_set_contacts(s, contacts), NSDAE_E_STATE);
  assert_int_equal(nsdae_system_set_force_damping_blocks(s, NULL), NSDAE_E_ARGUMENT);
  nsdae_system_clear_error(s);
  nsdae_sim_destroy(&sim);
  assert_int_equal(nsdae_system_set_blocks(s, 2, size, NULL), NSDAE_E_ARGUMENT);
  assert_string_equal(nsdae_system_error(s)->argument, "nv");
  assert_int_equal(nsdae_system_set_blocks(s, 2, short_q, size), NSDAE_E_ARGUMENT); /* nv > nq */
  assert_int_equal(nsdae_system_set_blocks(s, 2, large_q, size), NSDAE_E_ARGUMENT); /* the sum */
  assert_string_equal(nsdae_system_error(s)->argument, "nq");
  assert_int_equal(nsdae_system_set_blocks(s, 2, size, short_q), NSDAE_E_ARGUMENT);
  assert_string_equal(nsdae_system_error(s)->argument, "nv");
  nsdae_system_destroy(&s);
  assert_int_equal(nsdae_system_create(&dims, &s, NULL), NSDAE_OK);
  assert_int_equal(nsdae_system_set_blocks(s, 2, size, size), NSDAE_OK);
  assert_int_equal(nsdae_system_set_contacts(s, contacts), NSDAE_E_ARGUMENT);
  assert_string_equal(nsdae_system_error(s)->argument, "k");
  nsdae_system_destroy(&s);
}

static void not_made(nsdae_system *s, const char *argument)
{
  nsdae_sim *sim;
  nsdae_error error;
  assert_int_equal(nsdae_sim_create(s, NULL, &sim, &error), NSDAE_E_STATE);
  assert_string_equal(error.argument, argument);
  nsdae_system_destroy(&s);
}

static int dense(double t, const double *q, double *J, int ldj, void *user)
{
  (void)t, (void)q, (void)user;
  J[ldj] = J[2 * ldj + 1] = 1;
  return 0;
}

static int dense_damping(double t, const double *q, const double *v, double *D, int ldd, void *user)
{
  (void)t, (void)q, (void)v, (void)D, (void)ldd, (void)user;
  return 0;
}

static int no_blocks(double t, const double *q, const double *v, nsdae_block_list *list, void *user)
{
  (void)t, (void)q, (void)v, (void)list, (void)user;
  return 0;
}

/* Callbacks that need blocks, and those that are missing or given twice. */
static void test_misplaced(void **state)
{
  (void)state;
  const nsdae_dims dims = {.nq = NV, .m = 2};
  const int size[] = {1, WIDE};
  nsdae_system *s[5];
  model p = {.what = NONE};
  nsdae_system *by_list = make(&p);
  nsdae_system_set_constraint_jacobian(by_list, dense);
  not_made(by_list, "constraint_jacobian");
  for (int i = 0; i < 2; i++) {
    by_list = make(&p);
    if (i == 0) nsdae_system_set_force_damping(by_list, dense_damping);
    if (i == 1) nsdae_system_set_force_stiffness(by_list, dense_damping);
    not_made(by_list, i ? "force_stiffness" : "force_damping");
  }
  for (int i = 0; i < 5; i++) {
    assert_int_equal(nsdae_system_create(&dims, &s[i], NULL), NSDAE_OK);
    nsdae_system_set_force(s[i], force);
    nsdae_system_set_constraint(s[i], constraint);
  }
  nsdae_system_set_constraint_rows(s[0], rows);
  not_made(s[0], "constraint_rows");
  nsdae_system_set_contacts(s[1], contacts);
  not_made(s[1], "contacts");
  nsdae_system_set_blocks(s[2], 2, size, size);
  not_made(s[2], "mass_blocks");
  nsdae_system_set_force_damping_blocks(s[3], no_blocks);
  not_made(s[3], "force_damping_blocks");
  nsdae_system_set_force_stiffness_blocks(s[4], no_blocks);
  not_made(s[4], "force_stiffness_blocks");
}

int main(void)
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(test_check),          cmocka_unit_test(test_steps),
      cmocka_unit_test(test_more_each_time), cmocka_unit_test(test_some_not_listed),
      cmocka_unit_test(test_setters),        cmocka_unit_test(test_misplaced),
      cmocka_unit_test(test_longer_rows),    cmocka_unit_test(test_one_twice)};
  return cmocka_run_group_tests(tests, NULL, NULL);
}
