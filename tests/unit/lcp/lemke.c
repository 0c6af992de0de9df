/* Lemke's method: by hand, on Murty's worst case, in ties, at its three ends, and with its pivots
 * put off against at once. */
#include "check.h"

#include <stdlib.h>

#include <nsdae/kernels.h>

#include "../../bench/bench_lcp_families.h"
#include "dictionary.h"

enum { MOST = 300 };

/* One problem with all that the kernel works in. */
typedef struct call {
  int n, lda, max_pivots, lwork, pivots;
  double *A, *b, *d, *x, *y, *work;
  int *basis, *iwork;
} call;

static double A_[MOST * MOST], b_[MOST], d_[MOST], x_[MOST], y_[MOST];
static double work_[MOST * (MOST + 2) + 65 * (2 * MOST + 2)];
static int basis_[MOST], iwork_[2 * MOST + 1];
static random_state r;

static call call_of(int n)
{
  call c = {.n = n, .lda = n > 0 ? n : 1, .max_pivots = 100 * n + 100, .lwork = n * (n + 2)};
  c.A = A_, c.b = b_, c.x = x_, c.y = y_, c.work = work_, c.basis = basis_, c.iwork = iwork_;
  return c;
}

static int lemke(call *c)
{
  return nsdae_dlemke(c->n, c->A, c->lda, c->b, c->d, c->max_pivots, c->x, c->basis, &c->pivots,
                      c->work, c->lwork, c->iwork);
}

static int lemke_in_blocks(call *c, int block)
{
  assert_true((size_t)nsdae_dictionary_size(c->n, block) <= sizeof work_ / sizeof *work_);
  return nsdae_lemke(c->n, block, c->A, c->lda, c->b, c->d, c->max_pivots, c->x, c->basis,
                     &c->pivots, c->work, c->iwork);
}

static double residual_of(const call *c)
{
  double residual;
  assert_int_equal(nsdae_dlcpres(c->n, c->A, c->lda, c->b, c->x, c->y, &residual, c->work), 0);
  return residual;
}

/* Sets A (written by rows) and b. */
static call given(int n, const double *by_row, const double *b)
{
  call c = call_of(n);
  for (int i = 0; i < n; i++)
    for (int j = 0; j < n; j++) c.A[j * n + i] = by_row[i * n + j];
  memcpy(c.b, b, (size_t)n * sizeof *b);
  return c;
}

/* x, and a basis that is where x is positive; rounding of problems with entries of order one. */
static void expect(call *c, const double *x)
{
  assert_int_equal(lemke(c), 0);
  for (int i = 0; i < c->n; i++) {
    assert_near(c->x[i], x[i], 1e-15 * (1 + fabs(x[i])));
    assert_int_equal(c->basis[i], x[i] > 0);
  }
}

static void test_by_hand(void **state)
{
  (void)state;
  call c = given(1, (double[]){2}, (double[]){-4});
  expect(&c, (double[]){2});
  assert_int_equal(c.pivots, 2);
  c = given(2, (double[]){2, 1, 1, 2}, (double[]){-5, -6});
  expect(&c, (double[]){4.0 / 3, 7.0 / 3});
  c = given(2, (double[]){2, 1, 1, 2}, (double[]){-5, 6}); /* y = (0, 8.5) */
  expect(&c, (double[]){2.5, 0});
  c = given(2, (double[]){2, 1, 1, 2}, (double[]){5, 0});
  expect(&c, (double[]){0, 0});
  assert_int_equal(c.pivots, 0);
  c = given(2, (double[]){0, -1, 1, 0}, (double[]){1, -1}); /* skew: y = (1 - x_2, x_1 - 1) */
  expect(&c, (double[]){1, 1});
}

static void test_nothing(void **state)
{
  (void)state;
  call c = call_of(0);
  c.pivots = 7;
  assert_int_equal(lemke(&c), 0);
  assert_int_equal(c.pivots, 0);
}

/* Ones on the diagonal, twos below, b_i = -(2^n + ... + 2^(n-i+1)): 2^n pivots (Murty, Math.
 * Program. Study 7, 1978, 61), all in whole numbers. x = (2^n, 0, .., 0). */
static void test_murty(void **state)
{
  (void)state;
  for (int n = 1; n <= 10; n++)
    for (int block = 0; block < 8; block += 3) {
      call c = call_of(n);
      for (int i = 0; i < n; i++) {
        for (int j = 0; j < n; j++) c.A[j * n + i] = i == j ? 1 : i > j ? 2 : 0;
        c.b[i] = ldexp(1, n - i) - ldexp(1, n + 1);
      }
      c.max_pivots = 1 << n;
      assert_int_equal(lemke_in_blocks(&c, block), 0);
      assert_int_equal(c.pivots, 1 << n);
      for (int i = 0; i < n; i++) assert_true(c.x[i] == (i == 0 ? ldexp(1, n) : 0));
    }
}

/* Ones on the diagonal, two to the right of it around the corner, b = -1: all rows tie, where other
 * rules may go in circles (Kostreva, Math. Program. 16, 1979, 127). x_i = 1/3. */
static void test_circular(void **state)
{
  (void)state;
  for (int n = 3; n <= 15; n += 2)
    for (int block = 0; block < 8; block += 3) {
      call c = call_of(n);
      for (int i = 0; i < n; i++) {
        for (int j = 0; j < n; j++) c.A[j * n + i] = i == j ? 1 : j == (i + 1) % n ? 2 : 0;
        c.b[i] = -1;
      }
      assert_int_equal(lemke_in_blocks(&c, block), 0);
      for (int i = 0; i < n; i++) assert_near(c.x[i], 1.0 / 3, 1e-13);
    }
}

/* A = B B^T / n + shift, b uniform. */
static call definite(int n, double shift)
{
  static double B[MOST * MOST];
  call c = call_of(n);
  random_matrix(&r, n, n, B, n);
  random_matrix(&r, n, 1, c.b, n);
  for (int j = 0; j < n; j++)
    for (int i = 0; i <= j; i++) {
      double sum = 0;
      for (int k = 0; k < n; k++) sum += B[i * n + k] * B[j * n + k];
      c.A[j * n + i] = c.A[i * n + j] = sum / n + (i == j ? shift : 0);
    }
  return c;
}

/* Every row of J three times, A = J J^T of rank n / 6, b = J v: solvable for every v (x = 0 with
 * J w >= 0 has w = 0), ties in every step. */
static call repeated(int n)
{
  static double J[MOST * MOST], v[MOST];
  int rank = (n + 5) / 6;
  call c = call_of(n);
  random_matrix(&r, n, rank, J, n);
  random_matrix(&r, rank, 1, v, rank);
  for (int i = 0; i < n; i++) {
    c.b[i] = 0;
    for (int k = 0; k < rank; k++) {
      J[k * n + i] = J[k * n + i - i % 3];
      c.b[i] += J[k * n + i] * v[k];
    }
  }
  for (int j = 0; j < n; j++)
    for (int i = 0; i < n; i++) {
      c.A[j * n + i] = 0;
      for (int k = 0; k < rank; k++) c.A[j * n + i] += J[k * n + i] * J[k * n + j];
    }
  return c;
}

/* A P-matrix has one solution, so that a residual below n roundings is all there is to ask. */
static void test_definite(void **state)
{
  (void)state;
  r.seed = 1;
  for (int n = 1; n <= MOST; n += n < 60 ? 1 : 80) {
    call c = definite(n, 0.1);
    assert_int_equal(lemke(&c), 0);
    assert_at_most(residual_of(&c), 1e-12);
    c.lwork = nsdae_dictionary_size(n, nsdae_lemke_block(n));
    assert_int_equal(lemke(&c), 0);
    assert_at_most(residual_of(&c), 1e-12);
  }
}

static void test_repeated_rows(void **state)
{
  (void)state;
  r.seed = 2;
  for (int n = 6; n <= 120; n += 6) {
    call c = repeated(n);
    assert_int_equal(lemke_in_blocks(&c, 0), 0);
    assert_at_most(residual_of(&c), 1e-12);
    assert_int_equal(lemke_in_blocks(&c, 16), 0);
    assert_at_most(residual_of(&c), 1e-12);
  }
}

/* A = J J^T of rank three, b = J v, in small whole numbers, which tie in many ways. */
static call whole_numbers(int n)
{
  enum { rank = 3 };
  double J[MOST * rank], v[rank];
  call c = call_of(n);
  for (int l = 0; l < rank; l++) {
    v[l] = random_int(&r, -2, 2);
    for (int i = 0; i < n; i++) J[l * n + i] = random_int(&r, -1, 1);
  }
  for (int i = 0; i < n; i++) c.b[i] = 0;
  for (int i = 0; i < n * n; i++) c.A[i] = 0;
  for (int l = 0; l < rank; l++)
    for (int i = 0; i < n; i++) {
      c.b[i] += J[l * n + i] * v[l];
      for (int j = 0; j < n; j++) c.A[j * n + i] += J[l * n + i] * J[l * n + j];
    }
  return c;
}

/* Of many solutions the method takes the limit of those of b_i + eps^i, which have no ties; but
 * that z0 leaves as soon as it may, after fewer pivots. */
static void test_perturbation(void **state)
{
  static const double eps[] = {8e-3, 4e-3, 0};
  enum { n = 5, problems = 2000 };
  int compared = 0;
  (void)state;
  r.seed = 9;
  for (int k = 0; k < problems; k++) {
    int basis[3][n], pivots[3];
    call c = whole_numbers(n);
    for (int run = 0; run < 3; run++) {
      double b[n];
      memcpy(b, c.b, sizeof b);
      for (int i = 0; i < n; i++) c.b[i] += pow(eps[run], i + 1);
      assert_int_equal(lemke(&c), 0);
      memcpy(c.b, b, sizeof b);
      memcpy(basis[run], c.basis, sizeof basis[run]);
      pivots[run] = c.pivots;
    }
    if (pivots[2] != pivots[1] || memcmp(basis[0], basis[1], sizeof basis[0]) != 0) continue;
    assert_memory_equal(basis[2], basis[1], sizeof basis[2]);
    compared++;
  }
  assert_true(compared > 0.8 * (double)problems);
}

/* The same in thirds, so that what ties does so to rounding alone. */
static void test_rounded_ties(void **state)
{
  (void)state;
  r.seed = 11;
  for (int k = 0; k < 2000; k++) {
    call c = whole_numbers(random_int(&r, 5, 60));
    for (int i = 0; i < c.n * c.n; i++) c.A[i] /= 3;
    for (int i = 0; i < c.n; i++) c.b[i] /= 7;
    assert_int_equal(lemke_in_blocks(&c, k % 2 ? 0 : 8), 0);
    assert_at_most(residual_of(&c), 1e-12);
  }
}

/* Contacts of rigid bodies, with ties at zero from the start. z0 may end at 1e-12 of max |b|, of
 * which the residual takes no more than a thousandth for a row's size. */
static void test_contacts(void **state)
{
  static const int sizes[] = {3, 9, 30, 99}, problems[] = {5000, 20000, 8000, 200};
  (void)state;
  r.seed = 10;
  for (int family = LCP_FRICTIONLESS; family <= LCP_FRICTION; family++)
    for (int s = 0; s < 4; s++)
      for (int k = 0; k < problems[s]; k++) {
        lcp_case p = lcp_case_create(family, sizes[s], &r);
        call c = call_of(p.n);
        c.A = p.A;
        c.b = p.b;
        assert_int_equal(lemke_in_blocks(&c, k % 2 ? 0 : 8), 0);
        assert_at_most(residual_of(&c), 1e-9);
        lcp_case_destroy(&p);
      }
}

/* The same pivots in blocks of any length; without ties rounding has no say in them. */
static void test_blocks(void **state)
{
  static const int blocks[] = {1, 2, 7, 32, 64};
  static double x[MOST];
  static int basis[MOST];
  (void)state;
  r.seed = 3;
  for (int n = 1; n <= 200; n = 2 * n + 1) {
    call c = definite(n, 0.1);
    assert_int_equal(lemke_in_blocks(&c, 0), 0);
    int pivots = c.pivots;
    memcpy(x, c.x, sizeof x);
    memcpy(basis, c.basis, sizeof basis);
    for (size_t k = 0; k < sizeof blocks / sizeof *blocks; k++) {
      assert_int_equal(lemke_in_blocks(&c, blocks[k]), 0);
      assert_int_equal(c.pivots, pivots);
      assert_memory_equal(c.basis, basis, (size_t)n * sizeof *basis);
      for (int i = 0; i < n; i++) assert_near(c.x[i], x[i], 1e-11); /* condition below 100 */
    }
  }
}

/* Nothing is compared with a number of its own: 2^p A, 2^q b have 2^(q-p) x, to the last bit. */
static void test_scale(void **state)
{
  static double x[MOST];
  (void)state;
  r.seed = 4;
  for (int k = 0; k < 20; k++) {
    int n = 6 * random_int(&r, 1, 10), p = random_int(&r, -20, 20), q = random_int(&r, -300, 300);
    call c = k % 2 ? definite(n, 0.1) : repeated(n);
    assert_int_equal(lemke(&c), 0);
    int pivots = c.pivots;
    memcpy(x, c.x, sizeof x);
    for (int i = 0; i < n * n; i++) c.A[i] = ldexp(c.A[i], p);
    for (int i = 0; i < n; i++) c.b[i] = ldexp(c.b[i], q);
    assert_int_equal(lemke(&c), 0);
    assert_int_equal(c.pivots, pivots);
    for (int i = 0; i < n; i++) assert_true(c.x[i] == ldexp(x[i], q - p));
  }
}

/* Other covering vectors end at the same solution. */
static void test_coverings(void **state)
{
  static double x[MOST];
  (void)state;
  r.seed = 5;
  for (int n = 5; n <= 85; n += 40) {
    call c = definite(n, 0.1);
    assert_int_equal(lemke(&c), 0);
    memcpy(x, c.x, sizeof x);
    c.d = d_;
    for (int k = 0; k < 5; k++) {
      for (int i = 0; i < n; i++) d_[i] = 1.1 + random_number(&r);
      assert_int_equal(lemke(&c), 0);
      for (int i = 0; i < n; i++) assert_near(c.x[i], x[i], 1e-11);
    }
  }
}

/* No solution: y = -x - 1; y = -1; y_1 = -x_2 - 1 beside what could be solved. And one with the
 * solution (1, 0) that the ones do not lead to: it is hidden behind a ray. */
static void test_rays(void **state)
{
  (void)state;
  call c = given(1, (double[]){-1}, (double[]){-1});
  assert_int_equal(lemke(&c), 1);
  c = given(1, (double[]){0}, (double[]){-1});
  assert_int_equal(lemke(&c), 1);
  c = given(2, (double[]){0, -1, 1, 1}, (double[]){-1, -2});
  assert_int_equal(lemke(&c), 1);
  r.seed = 6;
  for (int n = 10; n <= 90; n += 40) { /* row 4 says y_4 = -1 - (sum of x) */
    c = definite(n, 0.1);
    for (int j = 0; j < n; j++) c.A[j * n + 4] = -1;
    c.b[4] = -1;
    for (int block = 0; block <= 32; block += 16) assert_int_equal(lemke_in_blocks(&c, block), 1);
  }
}

static void test_max_pivots(void **state)
{
  (void)state;
  r.seed = 7;
  for (int n = 12; n <= 72; n += 60) {
    call c = definite(n, 0.1);
    c.lwork = nsdae_dictionary_size(n, nsdae_lemke_block(n));
    assert_int_equal(lemke(&c), 0);
    int needed = c.pivots;
    for (c.max_pivots = 0; c.max_pivots < needed; c.max_pivots++) {
      assert_int_equal(lemke(&c), 2);
      assert_int_equal(c.pivots, c.max_pivots);
    }
    assert_int_equal(lemke(&c), 0);
  }
}

static void test_overflow(void **state)
{
  (void)state;
  call c = given(1, (double[]){1e-300}, (double[]){-1e300});
  assert_int_equal(lemke(&c), 3);
  c = given(2, (double[]){2e-300, 1e-300, 1e-300, 2e-300}, (double[]){-5e299, -6e299});
  assert_int_equal(lemke(&c), 3);
}

/* Where something is wrong nothing is done. */
static void refused(call *c, int info)
{
  c->pivots = -77;
  x_[0] = y_[0] = -77;
  basis_[0] = -77;
  assert_int_equal(lemke(c), info);
  assert_int_equal(c->pivots, -77);
  assert_int_equal(basis_[0], -77);
  assert_true(x_[0] == -77);
}

static call small(void)
{
  return given(2, (double[]){2, 1, 1, 2}, (double[]){-5, -6});
}

#define REFUSED(info, change) \
  do {                        \
    call broken = small();    \
    call *c = &broken;        \
    change;                   \
    refused(c, info);         \
  } while (0)

static void test_arguments(void **state)
{
  (void)state;
  REFUSED(-1, c->n = -1);
  REFUSED(-1, c->n = 40000);
  REFUSED(-2, c->A = NULL);
  REFUSED(-3, c->lda = 1);
  REFUSED(-4, c->b = NULL);
  for (int i = 0; i < 2; i++) d_[i] = 1;
  REFUSED(-5, (c->d = d_, d_[1] = 0));
  REFUSED(-5, (c->d = d_, d_[1] = -1));
  REFUSED(-6, c->max_pivots = -1);
  REFUSED(-7, c->x = NULL);
  REFUSED(-8, c->basis = NULL);
  REFUSED(-10, c->work = NULL);
  REFUSED(-11, c->lwork = 7);
  REFUSED(-11, c->lwork = -2);
  REFUSED(-12, c->iwork = NULL);
  call c = small();
  assert_int_equal(nsdae_dlemke(2, c.A, 2, c.b, NULL, 9, c.x, c.basis, NULL, c.work, 8, c.iwork),
                   -9);
}

/* NaN and infinities in each place, where b asks for work and where it does not. */
static void test_not_finite(void **state)
{
  static const double bad[] = {NAN, INFINITY, -INFINITY};
  (void)state;
  for (int k = 0; k < 3; k++)
    for (int trivial = 0; trivial < 2; trivial++) {
      for (int i = 0; i < 4; i++)
        REFUSED(-2, (c->b[0] += 9 * trivial, c->b[1] += 9 * trivial, c->A[i] = bad[k]));
      for (int i = 0; i < 2; i++) REFUSED(-4, (c->b[!i] += 9 * trivial, c->b[i] = bad[k]));
      for (int i = 0; i < 2; i++) {
        d_[0] = d_[1] = 1;
        REFUSED(-5, (c->d = d_, d_[i] = bad[k]));
      }
    }
}

/* What lwork = -1 asks for is enough, and so is n (n + 2); neither is overrun. */
static void test_workspace(void **state)
{
  double size;
  (void)state;
  r.seed = 8;
  for (int n = 1; n <= 81; n += 10) {
    call c = definite(n, 0.1);
    c.work = &size;
    c.lwork = -1;
    assert_int_equal(lemke(&c), 0);
    assert_true(size >= n * (n + 2));
    for (int least = 0; least < 2; least++) {
      c.lwork = least ? n * (n + 2) : (int)size;
      c.work = malloc((size_t)c.lwork * sizeof *c.work); /* its ends watched by the sanitizers */
      assert_non_null(c.work);
      assert_int_equal(lemke(&c), 0);
      free(c.work);
      c.work = work_;
      assert_at_most(residual_of(&c), 1e-12);
    }
  }
}

/* A in a larger array: only its own part is read. */
static void test_leading_dimension(void **state)
{
  (void)state;
  call c = call_of(2);
  const double wide[] = {2, 1, NAN, 1, 2, NAN};
  memcpy(c.A, wide, sizeof wide);
  c.lda = 3;
  c.b[0] = -5;
  c.b[1] = -6;
  expect(&c, (double[]){4.0 / 3, 7.0 / 3});
}

int main(void)
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(test_by_hand),
      cmocka_unit_test(test_nothing),
      cmocka_unit_test(test_murty),
      cmocka_unit_test(test_circular),
      cmocka_unit_test(test_definite),
      cmocka_unit_test(test_repeated_rows),
      cmocka_unit_test(test_blocks),
      cmocka_unit_test(test_scale),
      cmocka_unit_test(test_coverings),
      cmocka_unit_test(test_rays),
      cmocka_unit_test(test_max_pivots),
      cmocka_unit_test(test_overflow),
      cmocka_unit_test(test_arguments),
      cmocka_unit_test(test_not_finite),
      cmocka_unit_test(test_perturbation),
      cmocka_unit_test(test_contacts),
      cmocka_unit_test(test_rounded_ties),
      cmocka_unit_test(test_workspace),
      cmocka_unit_test(test_leading_dimension),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
