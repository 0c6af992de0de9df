#include "dense.h"

#include <cblas.h>
#include <float.h>
#include <lapacke.h>
#include <math.h>
#include <stddef.h>

#define AT(A, lda, i, j) (A)[(size_t)(j) * (size_t)(lda) + (size_t)(i)]

/* Left-looking Cholesky by columns (Golub and Van Loan, Matrix Computations, Alg. 4.2.1). */
static int cholesky_small(int n, double *A, int lda)
{
  for (int j = 0; j < n; j++) {
    double diagonal = AT(A, lda, j, j), pivot = diagonal;
    for (int k = 0; k < j; k++) pivot -= AT(A, lda, j, k) * AT(A, lda, j, k);
    if (!(pivot > n * DBL_EPSILON * diagonal)) return j + 1; /* NaN and infinity, too */
    double root = sqrt(pivot);
    AT(A, lda, j, j) = root;
    for (int i = j + 1; i < n; i++) {
      double sum = AT(A, lda, i, j);
      for (int k = 0; k < j; k++) sum -= AT(A, lda, i, k) * AT(A, lda, j, k);
      AT(A, lda, i, j) = sum / root;
    }
  }
  return 0;
}

/* The diagonal of A is gone after the factorisation, but row i of L holds its root as a norm. */
static int first_rounded_pivot(int n, const double *L, int ldl)
{
  for (int i = 0; i < n; i++) {
    double norm = cblas_dnrm2(i + 1, L + i, ldl), root = AT(L, ldl, i, i);
    if (!(root * root > n * DBL_EPSILON * norm * norm)) return i + 1; /* NaN and infinity, too */
  }
  return 0;
}

int nsdae_la_cholesky(int n, double *A, int lda)
{
  if (n < NSDAE_SMALL) return cholesky_small(n, A, lda);
  int info = LAPACKE_dpotrf_work(LAPACK_COL_MAJOR, 'L', n, A, lda);
  return info ? info : first_rounded_pivot(n, A, lda);
}

void nsdae_la_solve_lower(int n, int nrhs, const double *L, int ldl, double *B, int ldb)
{
  if (n >= NSDAE_SMALL) {
    cblas_dtrsm(CblasColMajor, CblasLeft, CblasLower, CblasNoTrans, CblasNonUnit, n, nrhs, 1.0, L,
                ldl, B, ldb);
    return;
  }
  for (int j = 0; j < nrhs; j++)
    for (int i = 0; i < n; i++) {
      double sum = AT(B, ldb, i, j);
      for (int k = 0; k < i; k++) sum -= AT(L, ldl, i, k) * AT(B, ldb, k, j);
      AT(B, ldb, i, j) = sum / AT(L, ldl, i, i);
    }
}

void nsdae_la_solve_lower_transposed(int n, int nrhs, const double *L, int ldl, double *B, int ldb)
{
  if (n >= NSDAE_SMALL) {
    cblas_dtrsm(CblasColMajor, CblasLeft, CblasLower, CblasTrans, CblasNonUnit, n, nrhs, 1.0, L,
                ldl, B, ldb);
    return;
  }
  for (int j = 0; j < nrhs; j++)
    for (int i = n - 1; i >= 0; i--) {
      double sum = AT(B, ldb, i, j);
      for (int k = i + 1; k < n; k++) sum -= AT(L, ldl, k, i) * AT(B, ldb, k, j);
      AT(B, ldb, i, j) = sum / AT(L, ldl, i, i);
    }
}

static void swap_rows(int n, double *A, int lda, int i, int k)
{
  for (int j = 0; j < n; j++) {
    double held = AT(A, lda, i, j);
    AT(A, lda, i, j) = AT(A, lda, k, j);
    AT(A, lda, k, j) = held;
  }
}

/* Elimination with row exchanges beats the call for longer: 1 us against 1.8 at 20 rows, as much at
 * some 45. */
enum { SMALL_LU = 40 };

/* b [n] := b - factor a. */
static void subtract(int n, double factor, const double *restrict a, double *restrict b)
{
  for (int i = 0; i < n; i++) b[i] -= factor * a[i];
}

/* Gauss elimination (Golub and Van Loan, Alg. 3.4.1). */
static int lu_small(int n, double *A, int lda, int *pivot)
{
  double *column = A;
  for (int k = 0; k < n; k++, column += lda) {
    int p = k;
    for (int i = k + 1; i < n; i++)
      if (fabs(column[i]) > fabs(column[p])) p = i;
    pivot[k] = p + 1;
    if (!(fabs(column[p]) > 0)) return k + 1;
    if (p != k) swap_rows(n, A, lda, p, k);
    for (int i = k + 1; i < n; i++) column[i] /= column[k];
    double *other = column + lda;
    for (int j = k + 1; j < n; j++, other += lda)
      if (other[k] != 0) subtract(n - k - 1, other[k], column + k + 1, other + k + 1);
  }
  return 0;
}

int nsdae_la_lu(int n, double *A, int lda, int *pivot)
{
  if (n < SMALL_LU) return lu_small(n, A, lda, pivot);
  return LAPACKE_dgetrf_work(LAPACK_COL_MAJOR, n, n, A, lda, pivot);
}

void nsdae_la_lu_solve(int n, const double *A, int lda, const int *pivot, double *b)
{
  if (n >= SMALL_LU) {
    LAPACKE_dgetrs_work(LAPACK_COL_MAJOR, 'N', n, 1, A, lda, pivot, b, n);
    return;
  }
  for (int k = 0; k < n; k++) {
    double held = b[k];
    b[k] = b[pivot[k] - 1];
    b[pivot[k] - 1] = held;
  }
  for (int k = 0; k < n; k++) subtract(n - k - 1, b[k], &AT(A, lda, k + 1, k), b + k + 1);
  for (int k = n - 1; k >= 0; k--) {
    b[k] /= AT(A, lda, k, k);
    subtract(k, b[k], &AT(A, lda, 0, k), b);
  }
}

void nsdae_la_multiply_transposed(int n, int p, int r, const double *A, int lda, const double *B,
                                  int ldb, double beta, double *C, int ldc)
{
  if (p == 0 || r == 0) return;
  if (n >= NSDAE_SMALL && r == 1) {
    cblas_dgemv(CblasColMajor, CblasTrans, n, p, 1.0, A, lda, B, 1, beta, C, 1);
    return;
  }
  if (n >= NSDAE_SMALL) {
    cblas_dgemm(CblasColMajor, CblasTrans, CblasNoTrans, p, r, n, 1.0, A, lda, B, ldb, beta, C,
                ldc);
    return;
  }
  for (int j = 0; j < r; j++)
    for (int i = 0; i < p; i++) {
      double sum = 0;
      for (int k = 0; k < n; k++) sum += AT(A, lda, k, i) * AT(B, ldb, k, j);
      AT(C, ldc, i, j) = beta == 0 ? sum : sum + beta * AT(C, ldc, i, j);
    }
}

void nsdae_la_subtract_product(int n, int p, int r, const double *A, int lda, const double *B,
                               int ldb, double *C, int ldc)
{
  if (p == 0 || r == 0) return;
  if (n >= NSDAE_SMALL) {
    cblas_dgemm(CblasColMajor, CblasNoTrans, CblasNoTrans, n, r, p, -1.0, A, lda, B, ldb, 1.0, C,
                ldc);
    return;
  }
  for (int j = 0; j < r; j++)
    for (int k = 0; k < p; k++)
      for (int i = 0; i < n; i++) AT(C, ldc, i, j) -= AT(A, lda, i, k) * AT(B, ldb, k, j);
}

void nsdae_la_add_product(int n, int p, const double *A, int lda, const double *x, double *y)
{
  if (n >= NSDAE_SMALL) {
    cblas_dgemv(CblasColMajor, CblasNoTrans, n, p, 1.0, A, lda, x, 1, 1.0, y, 1);
    return;
  }
  for (int k = 0; k < p; k++)
    for (int i = 0; i < n; i++) y[i] += AT(A, lda, i, k) * x[k];
}

void nsdae_la_add_outer(int n, int r, int p, const double *A, int lda, const double *B, int ldb,
                        double *C, int ldc)
{
  if (p == 0 || r == 0) return;
  if (n >= NSDAE_SMALL) {
    cblas_dgemm(CblasColMajor, CblasNoTrans, CblasTrans, n, r, p, 1.0, A, lda, B, ldb, 1.0, C, ldc);
    return;
  }
  for (int j = 0; j < r; j++)
    for (int k = 0; k < p; k++)
      for (int i = 0; i < n; i++) AT(C, ldc, i, j) += AT(A, lda, i, k) * AT(B, ldb, j, k);
}
