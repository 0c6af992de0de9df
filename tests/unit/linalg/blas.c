/* Calls of BLAS: none below 32 rows, one thread above, and the number of threads of the program
 * afterwards, whoever calls at the same time. The functions that OpenBLAS sets its threads with are
 * replaced by these. */
#include "check.h"

#include <cblas.h>
#include <pthread.h>
#include <stdatomic.h>

#include "dense.h"
#include "support/random.h"

enum { N = 64, THREADS = 4, OPENMP = 2 };

static atomic_int parallel = 1, threads = 7, asked, changed;

int openblas_get_parallel(void);
int openblas_get_num_threads(void);
void openblas_set_num_threads(int number);
int omp_get_max_threads(void);
void omp_set_num_threads(int number);

int openblas_get_parallel(void)
{
  atomic_fetch_add(&asked, 1);
  return atomic_load(&parallel);
}

int openblas_get_num_threads(void)
{
  return atomic_load(&threads);
}

void openblas_set_num_threads(int number)
{
  atomic_fetch_add(&changed, 1);
  atomic_store(&threads, number);
}

int omp_get_max_threads(void)
{
  return openblas_get_num_threads();
}

void omp_set_num_threads(int number)
{
  openblas_set_num_threads(number);
}

static atomic_int products, several;

/* In place of the product: the number of threads that it would have. */
void cblas_dgemm(CBLAS_LAYOUT order, CBLAS_TRANSPOSE a, CBLAS_TRANSPOSE b, int m, int n, int k,
                 double alpha, const double *A, int lda, const double *B, int ldb, double beta,
                 double *C, int ldc)
{
  (void)order, (void)a, (void)b, (void)m, (void)n, (void)k, (void)alpha, (void)A, (void)lda;
  (void)B, (void)ldb, (void)beta, (void)C, (void)ldc;
  atomic_fetch_add(&products, 1);
  if (openblas_get_num_threads() != 1) atomic_fetch_add(&several, 1);
}

static double A[N * N], B[N * N];

static void multiply(int n)
{
  static _Thread_local double C[N * N];
  nsdae_la_multiply_transposed(n, n, n, 1, A, n, B, n, 0, C, n);
}

/* Every kernel of n rows. */
static void all(int n)
{
  static double x[N], L[N * N], C[N * N];
  int pivot[N];
  const size_t size = (size_t)n * (size_t)n * sizeof *A;
  multiply(n);
  memset(L, 0, size);
  for (int i = 0; i < n; i++) L[i * (n + 1)] = x[i] = 2;
  memcpy(C, L, size);
  assert_int_equal(nsdae_la_cholesky(n, L, n), 0);
  nsdae_la_solve_lower(n, n, L, n, C, n);
  nsdae_la_solve_lower_transposed(n, n, L, n, C, n);
  nsdae_la_solve_cholesky(n, L, x);
  nsdae_la_solve_upper_transposed(n, L, n, x);
  assert_int_equal(nsdae_la_cholesky_pivots(n / 2, C, n), 0);
  nsdae_la_eliminate_below(n / 2, n - n / 2, -1, C, n);
  memcpy(C, A, size);
  assert_int_equal(nsdae_la_lu_front(n / 2, n, C, n, pivot), 0);
  nsdae_la_add_product(n, n, 1, A, n, B, x);
  nsdae_la_add_products(n, n, n, 1, A, n, B, n, C, n);
  nsdae_la_add_outer(n, n, n, A, n, B, n, C, n);
  memcpy(C, A, size);
  assert_int_equal(nsdae_la_lu(n, C, n, pivot), 0);
  nsdae_la_lu_solve(n, C, n, pivot, x);
}

static void test_small(void **state)
{
  (void)state;
  asked = 0;
  for (int n = 2; n < NSDAE_SMALL; n++) all(n);
  assert_int_equal(asked, 0);
  all(N);
  assert_true(asked > 0);
}

static void test_restored(void **state)
{
  (void)state;
  for (parallel = 1; parallel <= OPENMP; parallel++) {
    for (threads = 1; threads < 3; threads++) {
      int before = threads;
      changed = 0;
      multiply(N);
      assert_int_equal(threads, before);
      assert_int_equal(changed, before > 1 ? 2 : 0); /* one thread, and back */
    }
  }
  parallel = 1;
  threads = 7;
}

static void *work(void *none)
{
  for (int i = 0; i < 2000; i++) multiply(N);
  return none;
}

/* Of several threads that call at the same time each has one thread, and the last restores what the
 * first found. */
static void test_together(void **state)
{
  (void)state;
  pthread_t thread[THREADS];
  int before = products;
  for (int i = 0; i < THREADS; i++)
    assert_int_equal(pthread_create(&thread[i], NULL, work, NULL), 0);
  for (int i = 0; i < THREADS; i++) pthread_join(thread[i], NULL);
  assert_int_equal(products, before + THREADS * 2000);
  assert_int_equal(several, 0);
  assert_int_equal(threads, 7);
}

int main(void)
{
#ifndef NSDAE_OPENBLAS
  return 77; /* skipped: a BLAS without threads, or with no way to set them */
#endif
  random_state r = {1};
  random_matrix(&r, N, N, A, N);
  random_matrix(&r, N, N, B, N);
  const struct CMUnitTest tests[] = {cmocka_unit_test(test_small), cmocka_unit_test(test_restored),
                                     cmocka_unit_test(test_together)};
  return cmocka_run_group_tests(tests, NULL, NULL);
}
