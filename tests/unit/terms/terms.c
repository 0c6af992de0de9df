/* The terms at one point: each evaluated once, what depends on v again after a new v, failures by
 * name. */
#include "terms.h"
#include "check.h"

#include "planar_counted.h"
#include "support/random.h"

typedef struct fixture {
  counted user;
  nsdae_system *system;
  nsdae_differences differences;
  nsdae_terms terms;
  nsdae_error error;
  nsdae_evals evals;
  nsdae_arena arena;
} fixture;

static void layout(void *object, nsdae_arena *arena)
{
  fixture *f = object;
  nsdae_differences_layout(&f->differences, arena);
  nsdae_terms_layout(&f->terms, arena);
}

static double t0, q0[PLANAR_NQ], v0[PLANAR_NV];

static void begin(fixture *f, int derivatives)
{
  memset(f, 0, sizeof *f);
  f->user.fail = -1;
  f->system = counted_system(&f->user, derivatives);
  f->differences.system = f->system;
  f->terms.system = f->system;
  f->terms.differences = &f->differences;
  f->terms.error = &f->error;
  f->terms.evals = &f->evals;
  assert_int_equal(nsdae_arena_build(&f->arena, layout, f), NSDAE_OK);
  planar_point(4, &t0, q0, v0);
  nsdae_terms_at(&f->terms, t0, q0, v0);
}

static void end(fixture *f)
{
  nsdae_arena_release(&f->arena);
  nsdae_system_destroy(&f->system);
}

enum { ALL = 4095 };

static void test_once_per_point(void **state)
{
  (void)state;
  fixture f;
  begin(&f, 1);
  for (int i = 0; i < 3; i++) assert_int_equal(nsdae_terms_need(&f.terms, ALL), NSDAE_OK);
  for (int c = 0; c < COUNTED; c++)
    assert_int_equal(f.user.calls[c], c == COUNTED_KINEMATICS ? 0 : 1);
  assert_int_equal(f.evals.mass, 1);
  assert_int_equal(f.evals.force, 1);
  assert_int_equal(f.evals.jacobian, 1);
  nsdae_terms_at(&f.terms, t0, q0, v0); /* the same numbers, but a new point */
  assert_int_equal(nsdae_terms_need(&f.terms, ALL), NSDAE_OK);
  for (int c = 0; c < COUNTED; c++)
    assert_int_equal(f.user.calls[c], c == COUNTED_KINEMATICS ? 0 : 2);
  end(&f);
}

/* Only what is asked for; constraint_bias serves phi_t and omega in one call. */
static void test_only_what_is_needed(void **state)
{
  (void)state;
  const struct {
    unsigned which;
    int callback;
  } of[] = {{NSDAE_TERM_MASS, COUNTED_MASS},
            {NSDAE_TERM_FORCE, COUNTED_FORCE},
            {NSDAE_TERM_PHI, COUNTED_CONSTRAINT},
            {NSDAE_TERM_JACOBIAN, COUNTED_JACOBIAN},
            {NSDAE_TERM_PHI_T | NSDAE_TERM_OMEGA, COUNTED_BIAS},
            {NSDAE_TERM_GAP, COUNTED_GAP},
            {NSDAE_TERM_NORMAL, COUNTED_NORMAL},
            {NSDAE_TERM_TANGENT, COUNTED_TANGENT},
            {NSDAE_TERM_BIAS, COUNTED_CONTACT_BIAS},
            {NSDAE_TERM_POTENTIAL, COUNTED_POTENTIAL},
            {NSDAE_TERM_SLIDE, COUNTED_SLIDE}};
  for (size_t i = 0; i < sizeof of / sizeof *of; i++) {
    fixture f;
    begin(&f, 1);
    assert_int_equal(nsdae_terms_need(&f.terms, of[i].which), NSDAE_OK);
    for (int c = 0; c < COUNTED; c++) assert_int_equal(f.user.calls[c], c == of[i].callback);
    assert_true((f.terms.have & of[i].which) == of[i].which);
    end(&f);
  }
}

static void test_values(void **state)
{
  (void)state;
  fixture f;
  double M[9] = {0}, F[3] = {0}, phi[2], J[6] = {0}, phi_t[2], omega[2], gap[2], W[6] = {0};
  double T[6] = {0}, w_n[2] = {0}, w_t[2] = {0};
  begin(&f, 1);
  assert_int_equal(nsdae_terms_need(&f.terms, ALL), NSDAE_OK);
  planar_mass(t0, q0, M, 3, NULL);
  planar_force(t0, q0, v0, F, NULL);
  planar_constraint(t0, q0, phi, NULL);
  planar_jacobian(t0, q0, J, 2, NULL);
  planar_bias(t0, q0, v0, phi_t, omega, NULL);
  planar_gap(t0, q0, gap, NULL);
  planar_normal(t0, q0, W, 3, NULL);
  planar_tangent(t0, q0, T, 3, NULL);
  planar_contact_bias(t0, q0, w_n, w_t, NULL);
  assert_memory_equal(f.terms.M, M, sizeof M);
  assert_memory_equal(f.terms.F, F, sizeof F);
  assert_memory_equal(f.terms.constraint.phi, phi, sizeof phi);
  assert_memory_equal(f.terms.by.jacobian.value, J, sizeof J);
  assert_memory_equal(f.terms.constraint.phi_t, phi_t, sizeof phi_t);
  assert_memory_equal(f.terms.constraint.omega, omega, sizeof omega);
  assert_memory_equal(f.terms.gap, gap, sizeof gap);
  assert_memory_equal(f.terms.by.normal.value, W, sizeof W);
  assert_memory_equal(f.terms.by.tangent.value, T, sizeof T);
  assert_memory_equal(f.terms.w_N, w_n, sizeof w_n);
  assert_memory_equal(f.terms.w_T, w_t, sizeof w_t);
  assert_true(f.terms.potential == 9.81 * q0[1]);
  end(&f);
}

/* What the callbacks leave out is zero, also where the point before had something else. */
static void test_zeroed(void **state)
{
  (void)state;
  fixture f;
  begin(&f, 1);
  assert_int_equal(nsdae_terms_need(&f.terms, ALL), NSDAE_OK);
  double *arrays[] = {f.terms.M, f.terms.F, f.terms.by.tangent.value, f.terms.w_T,
                      f.terms.by.frictional_joint.value};
  const size_t counts[] = {9, 3, 6, 2, 3};
  double before[5][9];
  for (int i = 0; i < 5; i++) {
    memcpy(before[i], arrays[i], counts[i] * sizeof(double));
    for (size_t j = 0; j < counts[i]; j++) arrays[i][j] = 77;
  }
  nsdae_terms_at(&f.terms, t0, q0, v0);
  assert_int_equal(nsdae_terms_need(&f.terms, ALL), NSDAE_OK);
  for (int i = 0; i < 5; i++) assert_memory_equal(arrays[i], before[i], counts[i] * sizeof(double));
  end(&f);
}

static void test_new_velocity(void **state)
{
  (void)state;
  fixture f;
  double v[PLANAR_NV] = {1, 2, 3}, phi_t[2], omega[2];
  begin(&f, 1);
  assert_int_equal(nsdae_terms_need(&f.terms, ALL), NSDAE_OK);
  nsdae_terms_set_velocity(&f.terms, v);
  assert_int_equal(nsdae_terms_need(&f.terms, ALL), NSDAE_OK);
  for (int c = 0; c < COUNTED; c++) {
    int again = c == COUNTED_FORCE || c == COUNTED_BIAS; /* omega comes with phi_t */
    assert_int_equal(f.user.calls[c], c == COUNTED_KINEMATICS ? 0 : 1 + again);
  }
  planar_bias(t0, q0, v, phi_t, omega, NULL);
  assert_memory_equal(f.terms.constraint.omega, omega, sizeof omega);
  assert_memory_equal(f.terms.v, v, sizeof v);
  end(&f);
}

/* The same where the derivatives are filled by differences: phi_t does not depend on v. */
static void test_new_velocity_by_differences(void **state)
{
  (void)state;
  fixture f;
  double v[PLANAR_NV] = {1, 2, 3}, phi_t[2], omega[2];
  begin(&f, 0);
  assert_int_equal(nsdae_terms_need(&f.terms, ALL), NSDAE_OK);
  int calls = f.user.calls[COUNTED_CONSTRAINT];
  nsdae_terms_set_velocity(&f.terms, v);
  assert_int_equal(nsdae_terms_need(&f.terms, ALL), NSDAE_OK);
  assert_int_equal(f.user.calls[COUNTED_CONSTRAINT], calls + 5); /* five points */
  planar_bias(t0, q0, v, phi_t, omega, NULL);
  /* as in the test of the differences */
  for (int i = 0; i < 2; i++)
    assert_near(f.terms.constraint.omega[i], omega[i], 1e-9 * (1 + fabs(omega[i])));
  end(&f);
}

static void expect_failure(fixture *f, int status, int callback)
{
  assert_int_equal(nsdae_terms_need(&f->terms, ALL), status);
  assert_int_equal(f->error.status, status);
  assert_string_equal(f->error.argument, counted_names[callback]);
  assert_non_null(strstr(f->error.text, counted_names[callback]));
  assert_true(f->error.time == t0);
}

static void test_codes(void **state)
{
  (void)state;
  const int codes[] = {-1, 1, -77, 12345};
  for (int derivatives = 0; derivatives < 2; derivatives++)
    for (int c = 0; c < COUNTED; c++)
      for (int i = 0; i < 4; i++) {
        fixture f;
        begin(&f, derivatives);
        if (!counted_is_used(c, derivatives)) {
          end(&f);
          continue;
        }
        f.user.fail = c;
        f.user.code = codes[i];
        expect_failure(&f, NSDAE_E_CALLBACK, c);
        assert_int_equal(f.error.code, codes[i]);
        assert_non_null(strstr(f.error.text, codes[i] > 0 ? "recoverable" : "fatal"));
        f.user.fail = -1; /* the term that failed is not there: it is asked for again */
        assert_int_equal(nsdae_terms_need(&f.terms, ALL), NSDAE_OK);
        end(&f);
      }
}

static void test_not_finite(void **state)
{
  (void)state;
  const double values[] = {NAN, INFINITY, -INFINITY};
  for (int c = 0; c < COUNTED; c++)
    for (int entry = 0; entry < counted_entries[c]; entry++)
      for (int i = 0; i < 3; i++) {
        fixture f;
        begin(&f, 1);
        if (!counted_is_used(c, 1)) {
          end(&f);
          continue;
        }
        f.user.fail = c;
        f.user.entry = entry;
        f.user.value = values[i];
        expect_failure(&f, NSDAE_E_NONFINITE, c);
        assert_int_equal(f.error.index, entry);
        char where[32];
        snprintf(where, sizeof where, "entry (%d, %d)", entry % counted_rows[c],
                 entry / counted_rows[c]);
        assert_non_null(strstr(f.error.text, where));
        f.user.fail = -1;
        assert_int_equal(nsdae_terms_need(&f.terms, ALL), NSDAE_OK);
        end(&f);
      }
}

/* The second outputs of the callbacks that have two. */
static void test_not_finite_second_output(void **state)
{
  (void)state;
  const int callbacks[] = {COUNTED_BIAS, COUNTED_CONTACT_BIAS, COUNTED_SLIDE};
  const int entries[] = {2, 2, 1};
  for (int c = 0; c < 3; c++)
    for (int entry = 0; entry < entries[c]; entry++) {
      fixture f;
      begin(&f, 1);
      f.user.fail = callbacks[c];
      f.user.second = 1;
      f.user.entry = entry;
      f.user.value = NAN;
      expect_failure(&f, NSDAE_E_NONFINITE, callbacks[c]);
      assert_int_equal(f.error.index, entry);
      end(&f);
    }
}

static void test_terms_that_are_not(void **state)
{
  (void)state;
  fixture f;
  const nsdae_dims dims = {.nq = PLANAR_NQ, .nv = PLANAR_NV};
  memset(&f, 0, sizeof f);
  f.user.fail = -1;
  assert_int_equal(nsdae_system_create(&dims, &f.system, NULL), NSDAE_OK);
  nsdae_system_set_mass(f.system, planar_mass);
  nsdae_system_set_force(f.system, planar_force);
  f.differences.system = f.terms.system = f.system;
  f.terms.differences = &f.differences;
  f.terms.error = &f.error;
  f.terms.evals = &f.evals;
  assert_int_equal(nsdae_arena_build(&f.arena, layout, &f), NSDAE_OK);
  planar_point(4, &t0, q0, v0);
  nsdae_terms_at(&f.terms, t0, q0, v0);
  assert_int_equal(nsdae_terms_need(&f.terms, ALL), NSDAE_OK);
  assert_true(f.terms.potential == 0);
  end(&f);
}

/* ---- rows of arrays over several blocks */

enum { BLOCKS = 4, PARTED = 8, ROWS = 5 };
static const int block_size[BLOCKS] = {1, 3, 2, 2};

/* Entries of the rows that the callbacks write, those that they leave, and what they return. */
static struct parted {
  double entry[ROWS * PARTED];
  int written[ROWS * PARTED], code;
} parted;

static int parted_rows(double t, const double *q, double *W, int ldw, void *user)
{
  (void)t, (void)q, (void)user;
  for (int i = 0; i < ROWS * PARTED; i++)
    if (parted.written[i]) W[i / PARTED * ldw + i % PARTED] = parted.entry[i];
  return parted.code;
}

static int parted_jacobian(double t, const double *q, double *J, int ldj, void *user)
{
  (void)t, (void)q, (void)user;
  for (int i = 0; i < ldj * PARTED; i++)
    if (parted.written[i]) J[i % PARTED * ldj + i / PARTED] = parted.entry[i];
  return parted.code;
}

static int no_gap(double t, const double *q, double *g, void *user)
{
  (void)t, (void)q, (void)g, (void)user;
  return 0;
}

static int unit_blocks(double t, const double *q, double *M, void *user)
{
  (void)t, (void)q, (void)user;
  for (int b = 0; b < BLOCKS; M += block_size[b] * block_size[b], b++)
    for (int j = 0; j < block_size[b]; j++) M[j * (block_size[b] + 1)] = 1;
  return 0;
}

/* Mostly the rows of before, with other entries; zeros of both signs are none. */
static void next_rows(random_state *r)
{
  int anew = random_bits(r) % 3 == 0;
  parted.code = random_bits(r) % 8 == 0 ? -1 : 0;
  for (int i = 0; i < ROWS * PARTED; i++) {
    if (anew) parted.written[i] = random_bits(r) % 4 == 0;
    parted.entry[i] = (double)(random_bits(r) % 1000) + 1;
    if (anew && random_bits(r) % 4 == 0) parted.entry[i] = random_bits(r) % 2 ? -0.0 : 0;
  }
}

/* Each part is a block in which the row is not zero, in order, and has its entries. */
static void expect_parts(const nsdae_blocks *blocks, const nsdae_rows *rows)
{
  for (int i = 0, part = 0; i < rows->count; i++) {
    assert_int_equal(rows->first[i], part);
    for (int b = 0; b < BLOCKS; b++) {
      int any = 0;
      for (int j = blocks->first[b]; j < blocks->first[b + 1]; j++)
        any |= parted.written[i * PARTED + j] && parted.entry[i * PARTED + j] != 0;
      if (!any) continue;
      assert_int_equal(rows->block[part], b);
      for (int j = blocks->first[b]; j < blocks->first[b + 1]; j++) {
        size_t at = rows->at[part] + (size_t)(j - blocks->first[b]) * rows->stride;
        int is = i * PARTED + j;
        assert_true(rows->value[at] == (parted.written[is] ? parted.entry[is] : 0));
      }
      part++;
    }
    assert_int_equal(rows->first[i + 1], part);
  }
}

static void check_parts(int m)
{
  fixture f;
  const nsdae_dims dims = {.nq = PARTED, .m = m, .k = ROWS};
  const double q[PARTED] = {0};
  random_state r = {(uint64_t)m};
  int failed = 0;
  memset(&f, 0, sizeof f);
  assert_int_equal(nsdae_system_create(&dims, &f.system, NULL), NSDAE_OK);
  nsdae_system_set_blocks(f.system, BLOCKS, block_size, block_size);
  nsdae_system_set_mass_blocks(f.system, unit_blocks);
  nsdae_system_set_constraint(f.system, no_gap);
  nsdae_system_set_constraint_jacobian(f.system, parted_jacobian);
  nsdae_system_set_gap(f.system, no_gap);
  nsdae_system_set_gap_normal(f.system, parted_rows);
  f.differences.system = f.terms.system = f.system;
  f.terms.differences = &f.differences;
  f.terms.error = &f.error;
  f.terms.evals = &f.evals;
  assert_int_equal(nsdae_arena_build(&f.arena, layout, &f), NSDAE_OK);
  for (int point = 0; point < 2000; point++) {
    next_rows(&r);
    for (int i = 0; point % 100 == 50 && i < ROWS * PARTED; i++) { /* no zero beside an infinity */
      parted.written[i] = 1;
      parted.entry[i] = 1;
    }
    int bad = random_below(&r.seed, ROWS * PARTED), hit = point % 10 == 0 && parted.written[bad];
    if (hit) parted.entry[bad] = point % 20 == 0 ? NAN : -INFINITY;
    nsdae_terms_at(&f.terms, 0, q, q);
    int status = nsdae_terms_need(&f.terms, NSDAE_TERM_NORMAL);
    assert_int_equal(status, parted.code ? NSDAE_E_CALLBACK : hit ? NSDAE_E_NONFINITE : NSDAE_OK);
    if (status == NSDAE_E_NONFINITE) assert_int_equal(f.error.index, bad);
    failed += status < 0;
    if (status == NSDAE_OK) expect_parts(&f.system->blocks, &f.terms.by.normal);
    status = nsdae_terms_need(&f.terms, NSDAE_TERM_JACOBIAN);
    if (status == NSDAE_OK) expect_parts(&f.system->blocks, &f.terms.by.jacobian);
    assert_true(parted.code == 0 || status == NSDAE_E_CALLBACK);
  }
  assert_true(failed > 100);
  end(&f);
}

/* Whatever the rows were at the point before, or if that failed. */
static void test_parts(void **state)
{
  (void)state;
  for (int m = 1; m <= ROWS; m++) check_parts(m);
}

int main(void)
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(test_once_per_point),
      cmocka_unit_test(test_only_what_is_needed),
      cmocka_unit_test(test_values),
      cmocka_unit_test(test_zeroed),
      cmocka_unit_test(test_new_velocity),
      cmocka_unit_test(test_new_velocity_by_differences),
      cmocka_unit_test(test_codes),
      cmocka_unit_test(test_not_finite),
      cmocka_unit_test(test_not_finite_second_output),
      cmocka_unit_test(test_terms_that_are_not),
      cmocka_unit_test(test_parts),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
