/* The dense kernels against LAPACK and BLAS, on both sides of the size where they change over. */
#include "check.h"

#include <cblas.h>
#include <float.h>
#include <lapacke.h>
#include <stdlib.h>

#include "dense.h"
#include "support/random.h"

enum { N = 48, LD = N + 3, RHS = 5 };

/* Two backward stable solutions of one problem differ by at most a few n eps cond(A) (Higham,
 * Accuracy and Stability, section 10.1); the matrices here have cond(A) < 1e3. */
static double tolerance(int n)
{
  return 1e3 * (n + 1) * DBL_EPSILON;
}

static void copy(int rows, int columns, const double *A, double *B)
{
  for (int j = 0; j < columns; j++) memcpy(B + j * LD, A + j * LD, (size_t)rows * sizeof *A);
}

static void expect_near(int rows, int columns, const double *A, const double *B, double tol)
{
  for (int j = 0; j < columns; j++)
    for (int i = 0; i < rows; i++)
      assert_near(A[j * LD + i], B[j * LD + i], tol * (1 + fabs(B[j * LD + i])));
}

/* B^T B / n + 1, symmetric positive definite. */
static void random_spd(random_state *r, int n, double *A)
{
  static double B[N * LD];
  random_matrix(r, n, n, B, LD);
  for (int i = 0; i < n; i++)
    for (int j = 0; j < n; j++) {
      double sum = i == j;
      for (int k = 0; k < n; k++) sum += B[i * LD + k] * B[j * LD + k] / n;
      A[j * LD + i] = sum;
    }
}

static void test_cholesky(void **state)
{
  (void)state;
  random_state r = {1};
  static double A[N * LD], ours[N * LD], theirs[N * LD];
  for (int n = 1; n <= N; n++) {
    random_spd(&r, n, A);
    copy(n, n, A, ours);
    copy(n, n, A, theirs);
    assert_int_equal(nsdae_la_cholesky(n, ours, LD), 0);
    assert_int_equal(LAPACKE_dpotrf(LAPACK_COL_MAJOR, 'L', n, theirs, LD), 0);
    /* dpotrf leaves the upper triangle as it is, and so must ours */
    expect_near(n, n, ours, theirs, tolerance(n));
  }
}

/* The first pivot that fails is the first leading minor that is not positive: set entry p to the
 * value that makes it so. */
static void test_not_positive_definite(void **state)
{
  (void)state;
  random_state r = {2};
  static double A[N * LD], B[N * LD];
  for (int n = 1; n <= N; n++)
    for (int p = 0; p < n; p++) {
      random_spd(&r, n, A);
      A[p * LD + p] = -1e-3; /* negative, whatever is before it */
      copy(n, n, A, B);
      assert_int_equal(nsdae_la_cholesky(n, B, LD), p + 1);
      random_spd(&r, n, A);
      for (int i = 0; i < n; i++) A[p * LD + i] = A[i * LD + p] = 0;
      assert_int_equal(nsdae_la_cholesky(n, A, LD), p + 1); /* a body without mass */
    }
}

/* Row p + 1 repeats row p: singular in exact arithmetic, rounding in ours. */
static void test_singular(void **state)
{
  (void)state;
  random_state r = {3};
  static double A[N * LD];
  for (int n = 2; n <= N; n++)
    for (int p = 0; p + 1 < n; p++) {
      random_spd(&r, n, A);
      for (int i = 0; i < n; i++) A[i * LD + p + 1] = A[i * LD + p];
      for (int i = 0; i < n; i++) A[(p + 1) * LD + i] = A[p * LD + i];
      assert_int_equal(nsdae_la_cholesky(n, A, LD), p + 2);
    }
}

static void test_nan(void **state)
{
  (void)state;
  const double bad[] = {NAN, INFINITY, -INFINITY};
  random_state r = {4};
  static double A[N * LD];
  for (int b = 0; b < 3; b++)
    for (int n = 1; n < N / 2; n += n < 12 ? 1 : 4)
      for (int j = 0; j < n; j++)
        for (int i = j; i < n; i++) {
          random_spd(&r, n, A);
          A[j * LD + i] = bad[b];
          int info = nsdae_la_cholesky(n, A, LD);
          /* row i of the factor is the first that it can spoil */
          if (info < 1 || info > n) fail_msg("n = %d, entry (%d, %d): %d", n, i, j, info);
        }
}

/* Masses of very different size, scaled as S A S: as positive definite as A. */
static void test_scaled(void **state)
{
  (void)state;
  random_state r = {5};
  static double A[N * LD];
  for (int n = 1; n <= N; n++) {
    random_spd(&r, n, A);
    for (int i = 0; i < n; i++)
      for (int j = 0; j < n; j++) A[j * LD + i] *= pow(10, 6 * ((i % 3) - 1) + 6 * ((j % 3) - 1));
    assert_int_equal(nsdae_la_cholesky(n, A, LD), 0);
  }
}

static void test_triangular(void **state)
{
  (void)state;
  random_state r = {6};
  static double L[N * LD], B[RHS * LD], ours[RHS * LD], theirs[RHS * LD];
  for (int n = 1; n <= N; n++) {
    random_spd(&r, n, L);
    assert_int_equal(nsdae_la_cholesky(n, L, LD), 0);
    for (int i = 0; i < n; i++)
      for (int j = i + 1; j < n; j++) L[j * LD + i] = NAN; /* not to be read */
    for (int nrhs = 0; nrhs <= RHS; nrhs++) {
      random_matrix(&r, n, RHS, B, LD);
      copy(n, RHS, B, ours);
      copy(n, RHS, B, theirs);
      nsdae_la_solve_lower(n, nrhs, L, LD, ours, LD);
      cblas_dtrsm(CblasColMajor, CblasLeft, CblasLower, CblasNoTrans, CblasNonUnit, n, nrhs, 1, L,
                  LD, theirs, LD);
      expect_near(n, RHS, ours, theirs, tolerance(n));
      nsdae_la_solve_lower_transposed(n, nrhs, L, LD, ours, LD);
      cblas_dtrsm(CblasColMajor, CblasLeft, CblasLower, CblasTrans, CblasNonUnit, n, nrhs, 1, L, LD,
                  theirs, LD);
      expect_near(n, RHS, ours, theirs, tolerance(n));
    }
  }
}

static void test_lu(void **state)
{
  (void)state;
  random_state r = {7};
  static double A[N * LD], ours[N * LD], theirs[N * LD];
  double b[N], x[N];
  int pivot[N], pivots[N];
  for (int n = 1; n <= N; n++) {
    random_matrix(&r, n, n, A, LD);
    for (int i = 0; i < n; i++) A[i * LD + (i + 1) % n] += 4; /* dominant, off the diagonal */
    random_matrix(&r, n, 1, b, N);
    memcpy(x, b, sizeof x);
    copy(n, n, A, ours);
    copy(n, n, A, theirs);
    assert_int_equal(nsdae_la_lu(n, ours, LD, pivot), 0);
    assert_int_equal(LAPACKE_dgetrf(LAPACK_COL_MAJOR, n, n, theirs, LD, pivots), 0);
    assert_memory_equal(pivot, pivots, (size_t)n * sizeof *pivot);
    nsdae_la_lu_solve(n, ours, LD, pivot, x);
    LAPACKE_dgetrs(LAPACK_COL_MAJOR, 'N', n, 1, theirs, LD, pivots, b, n);
    for (int i = 0; i < n; i++) assert_near(x[i], b[i], tolerance(n) * (1 + fabs(b[i])));
  }
}

/* Columns that follow each other, which for bodies in the plane have code of their own: the same
 * bits as with room between them, and M^-1 b at once those of its two halves. */
static void test_packed(void **state)
{
  (void)state;
  random_state r = {11};
  static double A[N * LD], apart[N * LD], packed[N * N];
  double b[N], x[N], y[N];
  int pivot[N], pivots[N];
  for (int round = 0; round < 20; round++)
    for (int n = 1; n <= 12; n++) {
      random_spd(&r, n, A);
      if (round == 19) A[(n - 1) * (LD + 1)] = -1; /* no Cholesky factor, the same pivot */
      random_matrix(&r, n, 1, b, N);
      for (int way = 0; way < 2; way++) {
        copy(n, n, A, apart);
        for (int j = 0; j < n; j++) memcpy(packed + j * n, A + j * LD, (size_t)n * sizeof *A);
        memcpy(x, b, sizeof x);
        memcpy(y, b, sizeof y);
        if (way == 0) {
          int failed = nsdae_la_cholesky(n, apart, LD);
          assert_int_equal(failed, round == 19 ? n : 0);
          assert_int_equal(nsdae_la_cholesky(n, packed, n), failed);
          if (failed) continue;
          nsdae_la_solve_lower(n, 1, apart, LD, x, N);
          nsdae_la_solve_lower_transposed(n, 1, apart, LD, x, N);
          nsdae_la_solve_cholesky(n, packed, y);
        } else {
          assert_int_equal(nsdae_la_lu(n, apart, LD, pivot), 0);
          assert_int_equal(nsdae_la_lu(n, packed, n, pivots), 0);
          assert_memory_equal(pivot, pivots, (size_t)n * sizeof *pivot);
          nsdae_la_lu_solve(n, apart, LD, pivot, x);
          nsdae_la_lu_solve(n, packed, n, pivots, y);
        }
        for (int j = 0; j < n; j++)
          assert_memory_equal(packed + j * n, apart + j * LD, (size_t)n * sizeof *packed);
        assert_memory_equal(x, y, (size_t)n * sizeof *x);
      }
    }
}

static void test_lu_singular(void **state)
{
  (void)state;
  random_state r = {8};
  static double A[N * LD];
  int pivot[N];
  for (int n = 1; n <= N; n++)
    for (int p = 0; p < n; p++) {
      random_matrix(&r, n, n, A, LD);
      for (int i = 0; i < n; i++) A[p * LD + i] = 0; /* exact zeros stay exact */
      assert_int_equal(nsdae_la_lu(n, A, LD, pivot), p + 1);
    }
}

/* Sizes on both sides of every change from loops to BLAS: products of 32^3, with a vector of 32^2.
 */
static const int sizes[] = {1, 2, 3, 4, 5, 9, 31, 32, 33, N};
enum { SIZES = sizeof sizes / sizeof *sizes };

static void test_products(void **state)
{
  (void)state;
  random_state r = {9};
  static double A[N * LD], B[N * LD], C[N * LD], ours[N * LD], theirs[N * LD];
  const double betas[] = {0, 1, -1, 0.5};
  for (int at = 0; at < SIZES * SIZES * SIZES; at++) {
    int n = sizes[at % SIZES], p = sizes[at / SIZES % SIZES], q = sizes[at / SIZES / SIZES];
    double alpha = betas[1 + at % 3];
    random_matrix(&r, N, N, A, LD);
    random_matrix(&r, N, N, B, LD);
    random_matrix(&r, N, N, C, LD);
    for (int b = 0; b < 4; b++) {
      copy(N, N, C, ours);
      copy(N, N, C, theirs);
      nsdae_la_multiply_transposed(n, p, q, alpha, A, LD, B, LD, betas[b], ours, LD);
      cblas_dgemm(CblasColMajor, CblasTrans, CblasNoTrans, p, q, n, alpha, A, LD, B, LD, betas[b],
                  theirs, LD);
      expect_near(N, N, ours, theirs, tolerance(n));
    }
    copy(N, N, C, ours);
    copy(N, N, C, theirs);
    nsdae_la_add_outer(n, q, p, A, LD, B, LD, ours, LD);
    nsdae_la_add_products(n, q, p, alpha, A, LD, B, LD, ours, LD);
    for (int j = 0; j < q; j++)
      for (int i = 0; i < n; i++)
        for (int k = 0; k < p; k++)
          theirs[j * LD + i] += A[k * LD + i] * (B[k * LD + j] + alpha * B[j * LD + k]);
    expect_near(N, N, ours, theirs, tolerance(p));
    copy(N, N, C, ours);
    nsdae_la_add_product(n, p, alpha, A, LD, B, ours);
    for (int i = 0; i < n; i++) {
      double sum = C[i];
      for (int k = 0; k < p; k++) sum += alpha * A[k * LD + i] * B[k];
      assert_near(ours[i], sum, tolerance(p) * (1 + fabs(sum)));
    }
    for (int i = n; i < N * LD; i++) assert_true(ours[i] == C[i] || i % LD >= N);
  }
}

/* A front of p + r rows against the factor of the whole matrix: its first p columns are those of
 * the factor, what is left is the Schur complement, whose factor is the rest. */
static void test_fronts(void **state)
{
  (void)state;
  random_state r = {12};
  static double A[N * LD], ours[N * LD], theirs[N * LD];
  for (int at = 0; at < SIZES * SIZES; at++) {
    int n = sizes[at / SIZES], p = sizes[at % SIZES], pivot[N], pivots[N];
    if (p > n) continue;
    random_spd(&r, n, A);
    copy(n, n, A, ours);
    copy(n, n, A, theirs);
    assert_int_equal(nsdae_la_cholesky_pivots(p, ours, LD), 0);
    nsdae_la_eliminate_below(p, n - p, -1, ours, LD);
    if (p < n) assert_int_equal(nsdae_la_cholesky_pivots(n - p, ours + p * (LD + 1), LD), 0);
    assert_int_equal(LAPACKE_dpotrf(LAPACK_COL_MAJOR, 'L', n, theirs, LD), 0);
    expect_near(n, n, ours, theirs, tolerance(n));

    /* of a matrix whose pivots are in the last of the first p rows and columns, and in the rest */
    random_matrix(&r, n, n, A, LD);
    for (int i = 0; i < p; i++) A[i * LD + p - 1 - i] += 4.0 * n;
    for (int i = p; i < n; i++) A[i * (LD + 1)] += 4.0 * n;
    copy(n, n, A, ours);
    copy(n, n, A, theirs);
    assert_int_equal(nsdae_la_lu_front(p, n, ours, LD, pivot), 0);
    if (p < n) {
      assert_int_equal(nsdae_la_lu(n - p, ours + p * (LD + 1), LD, pivot + p), 0);
      for (int i = p; i < n; i++) {
        assert_int_equal(pivot[i], i - p + 1);
        pivot[i] += p;
      }
    }
    assert_int_equal(LAPACKE_dgetrf(LAPACK_COL_MAJOR, n, n, theirs, LD, pivots), 0);
    assert_memory_equal(pivot, pivots, (size_t)n * sizeof *pivot);
    expect_near(n, n, ours, theirs, tolerance(n));
  }
}

/* U^-T b of the upper triangle; what is below it is not read. */
static void test_upper_transposed(void **state)
{
  (void)state;
  random_state r = {13};
  static double U[N * LD];
  double b[N], x[N];
  for (int n = 1; n <= N; n++) {
    random_matrix(&r, n, n, U, LD);
    random_matrix(&r, n, 1, b, N);
    for (int i = 0; i < n; i++) U[i * (LD + 1)] = 4.0 * n;
    for (int j = 0; j < n; j++)
      for (int i = j + 1; i < n; i++) U[j * LD + i] = NAN;
    memcpy(x, b, sizeof x);
    nsdae_la_solve_upper_transposed(n, U, LD, x);
    for (int i = 0; i < n; i++) {
      double sum = 0;
      for (int k = 0; k <= i; k++) sum += U[i * LD + k] * x[k];
      assert_near(sum, b[i], tolerance(n));
    }
  }
}

/* beta = 0 sets C, whatever was in it, as in BLAS. */
static void test_product_overwrites(void **state)
{
  (void)state;
  random_state r = {10};
  static double A[2 * LD], C[2 * LD];
  for (int n = 1; n <= N; n++) {
    random_matrix(&r, n, 2, A, LD);
    for (int i = 0; i < 2 * LD; i++) C[i] = NAN;
    nsdae_la_multiply_transposed(n, 2, 2, 1, A, LD, A, LD, 0, C, LD);
    assert_true(C[0] > 0 && isfinite(C[1]) && C[1] == C[LD] && C[LD + 1] > 0);
  }
}

/* Products of nothing leave what they are added to as it is, for small matrices and for large. */
static void test_empty_products(void **state)
{
  (void)state;
  static double A[N * LD], B[N * LD], C[N * LD], before[N * LD];
  random_state r = {9};
  random_matrix(&r, N, N, C, LD);
  copy(N, N, C, before);
  for (int n = 1; n <= N; n++) {
    nsdae_la_multiply_transposed(n, 0, 2, 1, A, LD, B, LD, 1, C, LD);
    nsdae_la_add_outer(n, 2, 0, A, LD, B, LD, C, LD);
  }
  assert_memory_equal(C, before, sizeof C);
}

int main(void)
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(test_cholesky),
      cmocka_unit_test(test_not_positive_definite),
      cmocka_unit_test(test_singular),
      cmocka_unit_test(test_nan),
      cmocka_unit_test(test_scaled),
      cmocka_unit_test(test_triangular),
      cmocka_unit_test(test_lu),
      cmocka_unit_test(test_packed),
      cmocka_unit_test(test_lu_singular),
      cmocka_unit_test(test_products),
      cmocka_unit_test(test_fronts),
      cmocka_unit_test(test_upper_transposed),
      cmocka_unit_test(test_product_overwrites),
      cmocka_unit_test(test_empty_products),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
