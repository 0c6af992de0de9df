/* Systems by blocks with fixed contacts: each step is that of the dense system with the same
 * values, by every method and projection. No step allocates, and wrong callbacks are refused by
 * name. */
#include "check.h"

#include <stdlib.h>

#include "allocator.h"
#include "random.h"
#include "twin.h"

static const double DT = 2e-3, RTOL = 1e-10;

static const int methods[] = {NSDAE_METHOD_IMPLICIT, NSDAE_METHOD_IMPLICIT_PRINTED,
                              NSDAE_METHOD_MOREAU, NSDAE_METHOD_PENALTY, NSDAE_METHOD_EVENT};

enum { METHODS = sizeof methods / sizeof *methods };

static const int projections[] = {NSDAE_PROJECTION_NONE, NSDAE_PROJECTION_CONSTRAINTS,
                                  NSDAE_PROJECTION_CONTACTS, NSDAE_PROJECTION_DEPTHS};

/* Small ones are dense inside, as both are; the last four are sparse. */
static const twin_kind kinds[] = {
    {.blocks = 1, .largest = 3, .k = 2, .nt = 1, .friction = 0.3},
    {.blocks = 4, .largest = 3, .joined = 1, .k = 4, .nt = 1, .friction = 0.4, .restitution = 0.8},
    {.blocks = 5, .largest = 7, .joined = 1, .k = 5, .nt = 2, .friction = 0.2},
    {.blocks = 4, .largest = 3, .joined = 1, .k = 2, .nt = 1, .friction = 0.2, .f = 2},
    {.blocks = 3, .largest = 3, .joined = 1},
    {.blocks = 40, .largest = 3, .joined = 1, .k = 6, .nt = 1, .friction = 0.2, .restitution = 0.5},
    {.blocks = 30, .largest = 7, .joined = 1, .k = 3, .nt = 2, .friction = 0.2, .f = 1},
    {.blocks = 40, .largest = 3, .k = 5, .restitution = 1},
    {.blocks = 40, .largest = 3, .joined = 1}};

enum { KINDS = sizeof kinds / sizeof *kinds, STEPS = 20 };

static nsdae_sim *make(nsdae_system *system, int method, int projection)
{
  nsdae_sim_options options;
  nsdae_sim *sim = NULL;
  nsdae_error error;
  assert_non_null(system);
  nsdae_sim_options_default(&options);
  options.method = method;
  options.projection = projection;
  options.dt = DT;
  options.rtol = RTOL;
  options.atol = 1e-2 * RTOL;
  options.rank_tol = 1e-12;
  options.start_tol = 1; /* steps without projection drift */
  int status = nsdae_sim_create(system, &options, &sim, &error);
  if (status == NSDAE_E_UNSUPPORTED) return NULL; /* no SUNDIALS */
  if (status < 0) fail_msg("%s", error.text);
  return sim;
}

/* Rows have entries of order 1 and masses 0.1 to 10: 1e-11 are some 1e4 roundings of positions,
 * velocities and h times the forces, which are sums over 160 velocities. The multiplier is an
 * impulse by h. penalty, event: steps of the integrator are chosen by errors of rtol, and differ.
 */
static void compare(const twin *t, int method, const nsdae_record *a, const nsdae_record *b)
{
  int adaptive = method == NSDAE_METHOD_PENALTY || method == NSDAE_METHOD_EVENT;
  const double tol = adaptive ? 100 * RTOL : 1e-11;
  for (int j = 0; j < t->nv; j++) {
    double size = 1 + fabs(a->q[j]) + fabs(a->v[j]);
    assert_near(b->q[j], a->q[j], tol * size);
    assert_near(b->v[j], a->v[j], 10 * tol * size);
  }
  for (int i = 0; i < t->m; i++)
    assert_near(b->multiplier[i], a->multiplier[i], tol / DT * (100 + fabs(a->multiplier[i])));
}

/* Each step from the same state; how many contacts were closed in all. */
static int step_both(twin *t, int method, nsdae_sim *const sim[2])
{
  nsdae_record r[2];
  double q[TWIN_V], v[TWIN_V];
  int closed = 0;
  memcpy(q, t->q0, sizeof q), memcpy(v, t->v0, sizeof v);
  for (int n = 0; n < STEPS; n++) {
    int status[2];
    for (int i = 0; i < 2; i++) {
      if (nsdae_sim_init(sim[i], n * DT, q, v) < 0) fail_msg("%s", nsdae_sim_error(sim[i])->text);
      status[i] = nsdae_sim_step(sim[i]);
      nsdae_sim_get_record(sim[i], &r[i]);
    }
    assert_int_equal(status[0] < 0, status[1] < 0);
    if (status[0] < 0) break;
    compare(t, method, &r[0], &r[1]);
    for (int i = 0; i < t->k; i++) closed += r[0].normal_impulse[i] > 0;
    memcpy(q, r[0].q, (size_t)t->nv * sizeof *q), memcpy(v, r[0].v, (size_t)t->nv * sizeof *v);
  }
  return closed;
}

static int expect_same(twin *t, int method, int projection, int constraints)
{
  nsdae_system *systems[] = {twin_dense(t), twin_numbered(t, constraints)};
  nsdae_sim *sims[2];
  int closed = 0;
  for (int i = 0; i < 2; i++) sims[i] = make(systems[i], method, projection);
  if (sims[0]) closed = step_both(t, method, sims);
  for (int i = 0; i < 2; i++) {
    nsdae_sim_destroy(&sims[i]);
    nsdae_system_destroy(&systems[i]);
  }
  return closed;
}

/* A start that both project alike. */
static void draw(twin *t, uint64_t seed, int kind)
{
  double q[2][TWIN_V], v[2][TWIN_V];
  twin_draw(t, seed, &kinds[kind]);
  for (int i = 0; i < 2; i++) {
    nsdae_system *s = i ? twin_numbered(t, TWIN_BY_ROWS) : twin_dense(t);
    nsdae_sim *sim = make(s, NSDAE_METHOD_MOREAU, NSDAE_PROJECTION_NONE);
    memcpy(q[i], t->q0, sizeof t->q0), memcpy(v[i], t->v0, sizeof t->v0);
    if (nsdae_sim_project(sim, 0, q[i], v[i]) < 0) fail_msg("%s", nsdae_sim_error(sim)->text);
    nsdae_sim_destroy(&sim);
    nsdae_system_destroy(&s);
  }
  for (int j = 0; j < t->nv; j++) {
    assert_near(q[1][j], q[0][j], 1e-11);
    assert_near(v[1][j], v[0][j], 1e-11);
  }
  memcpy(t->q0, q[0], sizeof t->q0), memcpy(t->v0, v[0], sizeof t->v0);
}

static void test_methods(void **state)
{
  static twin t;
  const int seeds = share_of(3);
  int closed = 0;
  (void)state;
  for (int kind = 0; kind < KINDS; kind++)
    for (int seed = 0; seed < seeds; seed++)
      for (int i = 0; i < METHODS; i++) {
        draw(&t, 500 + 100 * (uint64_t)kind + (uint64_t)seed, kind);
        closed += expect_same(&t, methods[i], NSDAE_PROJECTION_NONE, TWIN_BY_ROWS);
      }
  print_message("%d contacts in a step\n", closed);
  assert_true(closed > 33 * seeds);
}

static void test_projections(void **state)
{
  static twin t;
  (void)state;
  for (int kind = 0; kind < KINDS; kind++)
    for (int seed = 0; seed < share_of(2); seed++)
      for (int i = 0; i < 3; i++)
        for (int p = 1; p < 4; p++) {
          draw(&t, 600 + 100 * (uint64_t)kind + (uint64_t)seed, kind);
          expect_same(&t, methods[i], projections[p], TWIN_BY_ROWS);
        }
}

/* Phi_q as a dense matrix, and by differences. */
static void test_constraints(void **state)
{
  static twin t;
  (void)state;
  for (int kind = 0; kind < KINDS; kind++)
    for (uint64_t seed = 0; seed < 2; seed++) {
      draw(&t, 700 + 100 * (uint64_t)kind + seed, kind);
      expect_same(&t, NSDAE_METHOD_MOREAU, NSDAE_PROJECTION_CONSTRAINTS, TWIN_BY_MATRIX);
      nsdae_system *s = twin_numbered(&t, TWIN_BY_DIFFERENCES);
      assert_int_equal(strstr(nsdae_system_differences(s), "constraint_jacobian") != NULL, t.m > 0);
      nsdae_sim *sim = make(s, NSDAE_METHOD_MOREAU, NSDAE_PROJECTION_NONE);
      assert_true(nsdae_sim_init(sim, 0, t.q0, t.v0) >= 0);
      assert_true(nsdae_sim_step(sim) >= 0);
      nsdae_sim_destroy(&sim);
      nsdae_system_destroy(&s);
    }
}

/* ---- what can go wrong */

static int spoiled_normal(double t, const double *q, double *W, int ldw, void *user)
{
  (void)t, (void)q, (void)user;
  W[0] = W[ldw + 2] = NAN;
  return 0;
}

static int failing_rows(double t, const double *q, nsdae_row_list *rows, void *user)
{
  (void)t, (void)q, (void)rows, (void)user;
  return -7;
}

static int no_masses(double t, const double *q, double *M, void *user)
{
  (void)t, (void)q, (void)user;
  M[0] = 1;
  return 0;
}

static void expect_status(twin *t, nsdae_system *s, int method, int status, const char *argument)
{
  nsdae_sim *sim = make(s, method, NSDAE_PROJECTION_NONE);
  if (sim) {
    assert_int_equal(nsdae_sim_init(sim, 0, t->q0, t->v0), status);
    assert_string_equal(nsdae_sim_error(sim)->argument, argument);
  }
  nsdae_sim_destroy(&sim);
  nsdae_system_destroy(&s);
}

static void test_faults(void **state)
{
  static twin t;
  (void)state;
  for (int kind = 1; kind < 7; kind += 5)
    for (int i = 0; i < METHODS; i++) {
      draw(&t, 900, kind);
      nsdae_system *s = twin_numbered(&t, TWIN_BY_ROWS);
      nsdae_system_set_gap_normal(s, spoiled_normal);
      expect_status(&t, s, methods[i], NSDAE_E_NONFINITE, "gap_normal");
      s = twin_numbered(&t, TWIN_BY_ROWS);
      nsdae_system_set_constraint_rows(s, failing_rows);
      expect_status(&t, s, methods[i], NSDAE_E_CALLBACK, "constraint_rows");
      s = twin_numbered(&t, TWIN_BY_ROWS);
      nsdae_system_set_mass_blocks(s, no_masses);
      expect_status(&t, s, methods[i], NSDAE_E_MASS, "mass_blocks");
    }
}

/* ---- rows of frictional joints that are wrong */

enum joint_mistake {
  JOINT_BEYOND,
  JOINT_BLOCK,
  JOINT_NAN,
  JOINT_TWICE,
  JOINT_W_NAN,
  JOINT_FAILS,
  JOINT_MISTAKES
};

static int joint_mistake; /* of the callback below */

static int wrong_joint_rows(double t, const double *q, nsdae_row_list *rows, double *w_s,
                            void *user)
{
  static const double value[TWIN_WIDE] = {1, 1, 1, 1, 1, 1, 1}, bad[TWIN_WIDE] = {NAN};
  (void)t, (void)q, (void)user;
  nsdae_row_add(rows, 0, 0, value);
  if (joint_mistake == JOINT_TWICE) nsdae_row_add(rows, 0, 0, value);
  nsdae_row_add(rows, 1, joint_mistake == JOINT_BLOCK ? TWIN_BLOCKS : 1, value);
  if (joint_mistake == JOINT_NAN) nsdae_row_add(rows, 1, 2, bad);
  if (joint_mistake == JOINT_BEYOND) nsdae_row_add(rows, 2, 1, value);
  if (joint_mistake == JOINT_W_NAN) w_s[1] = NAN;
  return joint_mistake == JOINT_FAILS ? 5 : 0;
}

/* Each by the start and by nsdae_system_check, which name joint and argument. */
static void test_joint_rows(void **state)
{
  static const struct {
    int status, index;
    const char *argument, *text;
  } wanted[JOINT_MISTAKES] = {
      [JOINT_BEYOND] = {NSDAE_E_ARGUMENT, 2, "row", "row 2 of W_S^T: rows are 0 .. f-1"},
      [JOINT_BLOCK] = {NSDAE_E_ARGUMENT, 1, "block", "frictional joint 1"},
      [JOINT_NAN] = {NSDAE_E_NONFINITE, 1, "value", "frictional joint 1"},
      [JOINT_TWICE] = {NSDAE_E_ARGUMENT, 0, "block", "a block occurs twice"},
      [JOINT_W_NAN] = {NSDAE_E_NONFINITE, 1, "joint_friction_rows", "frictional joint 1"},
      [JOINT_FAILS] = {NSDAE_E_CALLBACK, -1, "joint_friction_rows", "returned 5"}};
  static twin t;
  (void)state;
  draw(&t, 930, 3);
  for (joint_mistake = 0; joint_mistake < JOINT_MISTAKES; joint_mistake++)
    for (int i = 0; i <= METHODS; i++) {
      nsdae_system *s = twin_numbered(&t, TWIN_BY_ROWS);
      nsdae_sim *sim = NULL;
      nsdae_system_set_joint_friction_rows(s, wrong_joint_rows);
      if (i < METHODS) sim = make(s, methods[i], NSDAE_PROJECTION_NONE);
      if (sim || i == METHODS) {
        int status = sim ? nsdae_sim_init(sim, 0, t.q0, t.v0)
                         : nsdae_system_check(s, 0, t.q0, t.v0, 1e-6, NULL);
        const nsdae_error *error = sim ? nsdae_sim_error(sim) : nsdae_system_error(s);
        if (status != wanted[joint_mistake].status ||
            strcmp(error->argument, wanted[joint_mistake].argument) != 0 ||
            error->index != wanted[joint_mistake].index ||
            !strstr(error->text, wanted[joint_mistake].text))
          fail_msg("%d, index %d: %s", status, error->index, error->text);
      }
      nsdae_sim_destroy(&sim);
      nsdae_system_destroy(&s);
    }
}

static int no_force(double t, const double *q, const double *v, double *F, void *user)
{
  (void)t, (void)q, (void)v, (void)F, (void)user;
  return 0;
}

static int first_coordinate(double t, const double *q, double *phi, void *user)
{
  (void)t, (void)user;
  phi[0] = q[0];
  return 0;
}

static void not_made(nsdae_system *s, const char *argument)
{
  nsdae_sim *sim;
  nsdae_error error;
  assert_int_equal(nsdae_sim_create(s, NULL, &sim, &error), NSDAE_E_STATE);
  assert_string_equal(error.argument, argument);
  nsdae_system_destroy(&s);
}

/* Callbacks of frictional joints that are missing, given twice or out of place. */
static void test_joint_callbacks(void **state)
{
  static twin t;
  static const int one = 1;
  (void)state;
  draw(&t, 930, 3);
  nsdae_system *s = twin_numbered(&t, TWIN_BY_MATRIX);
  nsdae_system_set_joint_friction_rows(s, wrong_joint_rows);
  not_made(s, "frictional_joint_tangent");
  s = twin_dense(&t);
  nsdae_system_set_joint_friction_rows(s, wrong_joint_rows);
  not_made(s, "joint_friction_rows");
  assert_int_equal(nsdae_system_create(&(nsdae_dims){.nq = 1, .m = 1, .f = 1}, &s, NULL), NSDAE_OK);
  nsdae_system_set_blocks(s, 1, &one, &one);
  nsdae_system_set_mass_blocks(s, no_masses);
  nsdae_system_set_force(s, no_force);
  nsdae_system_set_constraint(s, first_coordinate);
  nsdae_system_set_frictional_joint(s, 0, 0, 0.5);
  not_made(s, "joint_friction_rows");
  draw(&t, 931, 2);
  s = twin_numbered(&t, TWIN_BY_ROWS);
  assert_int_equal(nsdae_system_set_joint_friction_rows(s, wrong_joint_rows), NSDAE_E_ARGUMENT);
  assert_non_null(strstr(nsdae_system_error(s)->text, "f = 0"));
  assert_int_equal(nsdae_system_set_joint_friction_rows(NULL, wrong_joint_rows), NSDAE_E_ARGUMENT);
  nsdae_system_destroy(&s);
}

/* Right descriptions pass; one wrong entry is found. */
static void test_check(void **state)
{
  static twin t;
  nsdae_check worst;
  (void)state;
  for (int kind = 1; kind < KINDS; kind++) {
    draw(&t, 950 + (uint64_t)kind, kind);
    for (int constraints = TWIN_BY_ROWS; constraints <= TWIN_BY_MATRIX; constraints++) {
      nsdae_system *s = twin_numbered(&t, constraints);
      if (nsdae_system_check(s, 0, t.q0, t.v0, 1e-6, &worst) < 0)
        fail_msg("%s", nsdae_system_error(s)->text);
      t.wrong_row = constraints == TWIN_BY_ROWS && t.m > 0 ? 1 : -1;
      if (t.wrong_row >= 0) {
        assert_int_equal(nsdae_system_check(s, 0, t.q0, t.v0, 1e-6, &worst), NSDAE_E_DERIVATIVE);
        assert_string_equal(worst.term, "constraint_rows");
        assert_int_equal(worst.column, t.first[1]);
      }
      t.wrong_row = -1;
      nsdae_system_destroy(&s);
    }
  }
}

/* ---- memory */

/* No step allocates, from the first; every lost allocation is survived and leaks nothing. */
static int life(twin *t, int method, int projection)
{
  nsdae_sim_options options;
  nsdae_sim *sim = NULL;
  nsdae_system *system = twin_numbered(t, TWIN_BY_ROWS);
  nsdae_sim_options_default(&options);
  options.method = method;
  options.projection = projection;
  options.dt = DT;
  if (!system) return NSDAE_E_MEMORY;
  int status = nsdae_sim_create(system, &options, &sim, NULL);
  if (status == NSDAE_OK) status = nsdae_sim_init(sim, 0, t->q0, t->v0);
  long before = the_allocator.calls;
  for (int n = 0; n < 20 && status >= 0; n++) status = nsdae_sim_step(sim);
  if (status >= 0) assert_int_equal(the_allocator.calls - before, 0);
  nsdae_sim_destroy(&sim);
  nsdae_system_destroy(&system);
  return status < 0 ? status : NSDAE_OK;
}

/* Closed contacts are projected, with time stepping and by event: a new set of them in a sparse
 * system is a new pattern. */
static void expect_no_allocations(int kind, int method)
{
  static twin t;
  int adaptive = method == NSDAE_METHOD_PENALTY || method == NSDAE_METHOD_EVENT;
  int status = NSDAE_E_MEMORY;
  long tried = 0;
  draw(&t, 800, kind);
  for (; status < 0; tried++) {
    allocator_reset(tried);
    status = life(&t, method, adaptive ? NSDAE_PROJECTION_NONE : NSDAE_PROJECTION_CONTACTS);
    if (status != NSDAE_OK) assert_int_equal(status, NSDAE_E_MEMORY);
    assert_int_equal(the_allocator.live, 0);
  }
  assert_true(tried > 20);
  allocator_reset(-1);
}

static void test_allocations(void **state)
{
  (void)state;
  for (int i = 0; i < METHODS; i++) {
    expect_no_allocations(1, methods[i]);
    for (int kind = 5; kind < KINDS; kind++) expect_no_allocations(kind, methods[i]);
  }
}

int main(void)
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(test_methods),     cmocka_unit_test(test_projections),
      cmocka_unit_test(test_constraints), cmocka_unit_test(test_faults),
      cmocka_unit_test(test_joint_rows),  cmocka_unit_test(test_joint_callbacks),
      cmocka_unit_test(test_check),       cmocka_unit_test(test_allocations)};
  return cmocka_run_group_tests(tests, NULL, NULL);
}
