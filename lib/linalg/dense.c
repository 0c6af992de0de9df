#include "dense.h"

#include <cblas.h>
#include <float.h>
#include <lapacke.h>
#include <math.h>
#include <stddef.h>
#include <string.h>

#include "vector.h"

/* A body in the plane or in space: loops of known length vanish, and with them most of the
 * instructions. */
enum { BODY = 3, SPACE = 6 };

#define AT(A, lda, i, j) (A)[(size_t)(j) * (size_t)(lda) + (size_t)(i)]

/* Left-looking Cholesky by columns (Golub and Van Loan, Matrix Computations, Alg. 4.2.1). */
static inline int cholesky_small(int n, double *A, size_t lda)
{
  double *column = A;
  for (int j = 0; j < n; j++, column += lda) {
    double pivot = column[j];
    const double *row = A + j;
    for (int k = 0; k < j; k++, row += lda) pivot -= *row * *row;
    if (!(pivot > n * DBL_EPSILON * column[j])) return j + 1; /* NaN and infinity, too */
    double root = sqrt(pivot);
    column[j] = root;
    for (int i = j + 1; i < n; i++) {
      double sum = column[i];
      const double *a = A + i, *c = A + j;
      for (int k = 0; k < j; k++, a += lda, c += lda) sum -= *a * *c;
      column[i] = sum / root;
    }
  }
  return 0;
}

int nsdae_la_cholesky(int n, double *A, int lda)
{
  if (n == BODY && lda == BODY) return cholesky_small(BODY, A, BODY);
  if (n == SPACE && lda == SPACE) return cholesky_small(SPACE, A, SPACE);
  if (n < NSDAE_SMALL) return cholesky_small(n, A, (size_t)lda);
  int info = LAPACKE_dpotrf_work(LAPACK_COL_MAJOR, 'L', n, A, lda);
  /* The diagonal of A is gone after the factorisation, but row i of L holds its root as a norm. */
  for (int i = 0; i < n && info == 0; i++) {
    double norm = cblas_dnrm2(i + 1, A + i, lda), root = AT(A, lda, i, i);
    if (!(root * root > n * DBL_EPSILON * norm * norm)) info = i + 1; /* NaN and infinity, too */
  }
  return info;
}

static inline void solve_lower_small(int n, const double *L, size_t ldl, double *b)
{
  for (int i = 0; i < n; i++) {
    double sum = b[i];
    const double *row = L + i;
    for (int k = 0; k < i; k++, row += ldl) sum -= *row * b[k];
    b[i] = sum / *row;
  }
}

static inline void solve_lower_transposed_small(int n, const double *L, size_t ldl, double *b)
{
  for (int i = n - 1; i >= 0; i--) {
    const double *column = L + (size_t)i * ldl;
    double sum = b[i];
    for (int k = i + 1; k < n; k++) sum -= column[k] * b[k];
    b[i] = sum / column[i];
  }
}

void nsdae_la_solve_lower(int n, int nrhs, const double *L, int ldl, double *B, int ldb)
{
  if (n >= NSDAE_SMALL) {
    cblas_dtrsm(CblasColMajor, CblasLeft, CblasLower, CblasNoTrans, CblasNonUnit, n, nrhs, 1.0, L,
                ldl, B, ldb);
    return;
  }
  for (int j = 0; j < nrhs; j++, B += ldb)
    if (n == BODY && ldl == BODY)
      solve_lower_small(BODY, L, BODY, B);
    else if (n == SPACE && ldl == SPACE)
      solve_lower_small(SPACE, L, SPACE, B);
    else
      solve_lower_small(n, L, (size_t)ldl, B);
}

void nsdae_la_solve_lower_transposed(int n, int nrhs, const double *L, int ldl, double *B, int ldb)
{
  if (n >= NSDAE_SMALL) {
    cblas_dtrsm(CblasColMajor, CblasLeft, CblasLower, CblasTrans, CblasNonUnit, n, nrhs, 1.0, L,
                ldl, B, ldb);
    return;
  }
  for (int j = 0; j < nrhs; j++, B += ldb)
    if (n == BODY && ldl == BODY)
      solve_lower_transposed_small(BODY, L, BODY, B);
    else if (n == SPACE && ldl == SPACE)
      solve_lower_transposed_small(SPACE, L, SPACE, B);
    else
      solve_lower_transposed_small(n, L, (size_t)ldl, B);
}

void nsdae_la_solve_cholesky(int n, const double *L, double *b)
{
  nsdae_la_solve_lower(n, 1, L, n, b, n);
  nsdae_la_solve_lower_transposed(n, 1, L, n, b, n);
}

static inline void swap_rows(int n, double *A, int lda, int i, int k)
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
static inline void subtract(int n, double factor, const double *restrict a, double *restrict b)
{
  for (int i = 0; i < n; i++) b[i] -= factor * a[i];
}

/* Gauss elimination (Golub and Van Loan, Alg. 3.4.1). */
static inline int lu_small(int n, double *A, int lda, int *pivot)
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
  if (n == BODY && lda == BODY) return lu_small(BODY, A, BODY, pivot);
  if (n < SMALL_LU) return lu_small(n, A, lda, pivot);
  return LAPACKE_dgetrf_work(LAPACK_COL_MAJOR, n, n, A, lda, pivot);
}

static inline void lu_solve_small(int n, const double *A, int lda, const int *pivot, double *b)
{
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

void nsdae_la_lu_solve(int n, const double *A, int lda, const int *pivot, double *b)
{
  if (n == BODY && lda == BODY)
    lu_solve_small(BODY, A, BODY, pivot, b);
  else if (n < SMALL_LU)
    lu_solve_small(n, A, lda, pivot, b);
  else
    LAPACKE_dgetrs_work(LAPACK_COL_MAJOR, 'N', n, 1, A, lda, pivot, b, n);
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
  for (int j = 0; j < r; j++, B += ldb, C += ldc) {
    const double *column = A;
    for (int i = 0; i < p; i++, column += lda) {
      double sum = nsdae_dot(n, column, B);
      C[i] = beta == 0 ? sum : sum + beta * C[i];
    }
  }
}

void nsdae_la_add_product(int n, int p, const double *A, int lda, const double *x, double *y)
{
  cblas_dgemv(CblasColMajor, CblasNoTrans, n, p, 1.0, A, lda, x, 1, 1.0, y, 1);
}

void nsdae_la_add_outer(int n, int r, int p, const double *A, int lda, const double *B, int ldb,
                        double *C, int ldc)
{
  cblas_dgemm(CblasColMajor, CblasNoTrans, CblasTrans, n, r, p, 1.0, A, lda, B, ldb, 1.0, C, ldc);
}

/* ---- rank revealing */

void nsdae_rank_revealing_layout(nsdae_rank_revealing *d, long n, nsdae_arena *arena)
{
  nsdae_arena_ints(arena, n, (int **[]){&d->taken, &d->dependent, &d->before, &d->seen, NULL});
  nsdae_arena_doubles(arena, n * n, (double **[]){&d->factor, &d->combination, NULL});
}

void nsdae_rank_revealing_start(nsdae_rank_revealing *d, int n, const double *G)
{
  d->n = n;
  d->G = G;
  d->taken_count = d->dependent_count = 0;
  memset(d->seen, 0, (size_t)n * sizeof *d->seen);
}

/* The row of the factor after those taken, and what it leaves of the diagonal entry. */
static double factor_row(nsdae_rank_revealing *d, int column)
{
  const double *G = d->G + (size_t)column * (size_t)d->n;
  double *row = nsdae_rank_revealing_row(d, d->factor, column), rest = G[column];
  for (int j = 0; j < d->taken_count; j++) {
    const double *other = nsdae_rank_revealing_row(d, d->factor, d->taken[j]);
    row[j] = (G[d->taken[j]] - nsdae_dot(j, row, other)) / other[j];
    rest -= row[j] * row[j];
  }
  return rest;
}

static double entry(const nsdae_rank_revealing *d, int column)
{
  return d->G[(size_t)column * (size_t)(d->n + 1)];
}

double nsdae_rank_revealing_rest(nsdae_rank_revealing *d, int column)
{
  return factor_row(d, column) / entry(d, column);
}

int nsdae_rank_revealing_take(nsdae_rank_revealing *d, int column)
{
  double rest = factor_row(d, column);
  d->seen[column] = 1;
  d->before[column] = d->taken_count;
  if (!(rest > d->sine * d->sine * entry(d, column))) {
    d->dependent[d->dependent_count++] = column;
    return 0;
  }
  nsdae_rank_revealing_row(d, d->factor, column)[d->taken_count] = sqrt(rest);
  d->taken[d->taken_count++] = column;
  return 1;
}

/* c by L^T c = row p of the factor. */
void nsdae_rank_revealing_combine(nsdae_rank_revealing *d)
{
  for (int k = 0; k < d->dependent_count; k++) {
    int p = d->dependent[k];
    double *c = nsdae_rank_revealing_row(d, d->combination, p);
    const double *row = nsdae_rank_revealing_row(d, d->factor, p);
    memset(c, 0, (size_t)d->n * sizeof *c);
    for (int l = d->before[p] - 1; l >= 0; l--) {
      double sum = row[l];
      for (int i = l + 1; i < d->before[p]; i++)
        sum -= nsdae_rank_revealing_row(d, d->factor, d->taken[i])[l] * c[d->taken[i]];
      c[d->taken[l]] = sum / nsdae_rank_revealing_row(d, d->factor, d->taken[l])[l];
    }
  }
}
