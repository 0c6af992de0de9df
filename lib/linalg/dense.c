#include "dense.h"

#include <float.h>
#include <math.h>
#include <stddef.h>
#include <string.h>

#include "blas.h"
#include "vector.h"

/* A body in the plane or in space: loops of known length vanish, and with them most of the
 * instructions. */
enum { BODY = 3, SPACE = 6 };

#define AT(A, lda, i, j) (A)[(size_t)(j) * (size_t)(lda) + (size_t)(i)]

/* b [n] -= factor a. */
static inline void subtract(int n, double factor, const double *restrict a, double *restrict b)
{
  for (int i = 0; i < n; i++) b[i] -= factor * a[i];
}

/* b [n] -= f_0 a_0 + .. + f_3 a_3 of columns that are lda apart: b is read, rounded and written
 * once. */
static inline void subtract_four(int n, const double f[4], const double *restrict a, size_t lda,
                                 double *restrict b)
{
  const double f0 = f[0], f1 = f[1], f2 = f[2], f3 = f[3];
  const double *restrict a1 = a + lda, *restrict a2 = a1 + lda, *restrict a3 = a2 + lda;
  for (int i = 0; i < n; i++) b[i] -= (f0 * a[i] + f1 * a1[i]) + (f2 * a2[i] + f3 * a3[i]);
}

/* b [n] -= A [n x p] f, f_k = factor[k stride]. */
static inline void subtract_product(int n, int p, const double *A, size_t lda, double scale,
                                    const double *factor, size_t stride, double *b)
{
  int k = 0;
  for (; k + 4 <= p; k += 4, A += 4 * lda, factor += 4 * stride)
    subtract_four(n,
                  (double[]){scale * factor[0], scale * factor[stride], scale * factor[2 * stride],
                             scale * factor[3 * stride]},
                  A, lda, b);
  for (; k < p; k++, A += lda, factor += stride) subtract(n, scale * *factor, A, b);
}

/* Left-looking Cholesky by columns (Golub and Van Loan, Matrix Computations, Alg. 4.2.1). A pivot
 * must be above least of its diagonal entry. */
static inline int cholesky_few(int n, double least, double *A, size_t lda)
{
  double *column = A;
  for (int j = 0; j < n; j++, column += lda) {
    double pivot = column[j];
    const double *row = A + j;
    for (int k = 0; k < j; k++, row += lda) pivot -= *row * *row;
    if (!(pivot > least * column[j])) return j + 1; /* NaN and infinity, too */
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

/* The same sums in the same order, a column at a time. */
static int cholesky_small(int n, double least, double *A, size_t lda)
{
  double *column = A;
  for (int j = 0; j < n; j++, column += lda) {
    double diagonal = column[j];
    subtract_product(n - j, j, A + j, lda, 1, A + j, lda, column + j);
    if (!(column[j] > least * diagonal)) return j + 1;
    column[j] = sqrt(column[j]);
    for (int i = j + 1; i < n; i++) column[i] /= column[j];
  }
  return 0;
}

/* Up to here the loop over few rows takes less. */
enum { FEW = 8 };

int nsdae_la_cholesky(int n, double *A, int lda)
{
  const double least = n * DBL_EPSILON;
  if (n == BODY && lda == BODY) return cholesky_few(BODY, least, A, BODY);
  if (n == SPACE && lda == SPACE) return cholesky_few(SPACE, least, A, SPACE);
  if (n <= FEW) return cholesky_few(n, least, A, (size_t)lda);
  if (n < NSDAE_SMALL) return cholesky_small(n, least, A, (size_t)lda);
  int info;
  NSDAE_ALONE(info = LAPACKE_dpotrf_work(LAPACK_COL_MAJOR, 'L', n, A, lda));
  /* The diagonal of A is gone after the factorisation, but row i of L holds its root as a norm. */
  for (int i = 0; i < n && info == 0; i++) {
    double square = 0, root = AT(A, lda, i, i);
    for (int k = 0; k <= i; k++) square += AT(A, lda, i, k) * AT(A, lda, i, k);
    if (!(root * root > least * square)) info = i + 1; /* NaN and infinity, too */
  }
  return info;
}

int nsdae_la_cholesky_pivots(int n, double *A, int lda)
{
  int info;
  if (n <= FEW) return cholesky_few(n, 0, A, (size_t)lda);
  if (n < NSDAE_SMALL) return cholesky_small(n, 0, A, (size_t)lda);
  NSDAE_ALONE(info = LAPACKE_dpotrf_work(LAPACK_COL_MAJOR, 'L', n, A, lda));
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

/* The same sums in the same order, a column at a time. */
static void solve_lower_columns(int n, const double *L, size_t ldl, double *b)
{
  for (int k = 0; k < n; k++, L += ldl + 1) {
    b[k] /= *L;
    subtract(n - k - 1, b[k], L + 1, b + k + 1);
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
    NSDAE_ALONE(cblas_dtrsm(CblasColMajor, CblasLeft, CblasLower, CblasNoTrans, CblasNonUnit, n,
                            nrhs, 1.0, L, ldl, B, ldb));
    return;
  }
  for (int j = 0; j < nrhs; j++, B += ldb)
    if (n == BODY && ldl == BODY)
      solve_lower_small(BODY, L, BODY, B);
    else if (n == SPACE && ldl == SPACE)
      solve_lower_small(SPACE, L, SPACE, B);
    else if (n <= FEW)
      solve_lower_small(n, L, (size_t)ldl, B);
    else
      solve_lower_columns(n, L, (size_t)ldl, B);
}

void nsdae_la_solve_lower_transposed(int n, int nrhs, const double *L, int ldl, double *B, int ldb)
{
  if (n >= NSDAE_SMALL) {
    NSDAE_ALONE(cblas_dtrsm(CblasColMajor, CblasLeft, CblasLower, CblasTrans, CblasNonUnit, n, nrhs,
                            1.0, L, ldl, B, ldb));
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

/* R [r x p] := R L^-T and S [r x r] := S + sign R R^T, in plain loops. */
static void eliminate_below_small(int p, int r, double sign, const double *L, size_t lda, double *R,
                                  double *S)
{
  for (int j = 0; j < p; j++) {
    double *column = R + (size_t)j * lda;
    subtract_product(r, j, R, lda, 1, L + j, lda, column);
    for (int i = 0; i < r; i++) column[i] /= L[(size_t)j * (lda + 1)];
  }
  for (int j = 0; j < r; j++)
    subtract_product(r - j, p, R + j, lda, -sign, R + j, lda, S + (size_t)j * (lda + 1));
}

void nsdae_la_eliminate_below(int p, int r, double sign, double *L, int lda)
{
  double *R = L + p, *S = R + (size_t)p * (size_t)lda;
  if (p + r < NSDAE_SMALL) {
    eliminate_below_small(p, r, sign, L, (size_t)lda, R, S);
    return;
  }
  NSDAE_ALONE(cblas_dtrsm(CblasColMajor, CblasRight, CblasLower, CblasTrans, CblasNonUnit, r, p, 1,
                          L, lda, R, lda);
              cblas_dsyrk(CblasColMajor, CblasLower, CblasNoTrans, r, p, sign, R, lda, 1, S, lda));
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

/* Gauss elimination of p of n columns, pivots among their rows (Golub and Van Loan, Alg. 3.4.1). */
static inline int lu_small(int p, int n, double *A, int lda, int *pivot)
{
  double *column = A;
  for (int k = 0; k < p; k++, column += lda) {
    int most = k;
    for (int i = k + 1; i < p; i++)
      if (fabs(column[i]) > fabs(column[most])) most = i;
    pivot[k] = most + 1;
    if (!(fabs(column[most]) > 0)) return k + 1;
    if (most != k) swap_rows(n, A, lda, most, k);
    for (int i = k + 1; i < n; i++) column[i] /= column[k];
    double *other = column + lda;
    for (int j = k + 1; j < n; j++, other += lda)
      if (other[k] != 0) subtract(n - k - 1, other[k], column + k + 1, other + k + 1);
  }
  return 0;
}

int nsdae_la_lu(int n, double *A, int lda, int *pivot)
{
  if (n == BODY && lda == BODY) return lu_small(BODY, BODY, A, BODY, pivot);
  return nsdae_la_lu_front(n, n, A, lda, pivot);
}

int nsdae_la_lu_front(int p, int n, double *A, int lda, int *pivot)
{
  int info, r = n - p;
  double *R = A + p, *U = A + (size_t)p * (size_t)lda, *S = U + p;
  if (n < SMALL_LU) return lu_small(p, n, A, lda, pivot);
  NSDAE_ALONE(info = LAPACKE_dgetrf_work(LAPACK_COL_MAJOR, p, p, A, lda, pivot));
  if (info != 0 || r == 0) return info;
  NSDAE_ALONE(cblas_dtrsm(CblasColMajor, CblasRight, CblasUpper, CblasNoTrans, CblasNonUnit, r, p,
                          1, A, lda, R, lda);
              LAPACKE_dlaswp_work(LAPACK_COL_MAJOR, r, U, lda, 1, p, pivot, 1);
              cblas_dtrsm(CblasColMajor, CblasLeft, CblasLower, CblasNoTrans, CblasUnit, p, r, 1, A,
                          lda, U, lda);
              cblas_dgemm(CblasColMajor, CblasNoTrans, CblasNoTrans, r, r, p, -1, R, lda, U, lda, 1,
                          S, lda));
  return 0;
}

static inline void lu_forward_small(int n, const double *A, int lda, const int *pivot, double *b)
{
  for (int k = 0; k < n; k++) {
    double held = b[k];
    b[k] = b[pivot[k] - 1];
    b[pivot[k] - 1] = held;
  }
  for (int k = 0; k < n; k++) subtract(n - k - 1, b[k], &AT(A, lda, k + 1, k), b + k + 1);
}

static inline void lu_backward_small(int n, const double *A, int lda, double *b)
{
  for (int k = n - 1; k >= 0; k--) {
    b[k] /= AT(A, lda, k, k);
    subtract(k, b[k], &AT(A, lda, 0, k), b);
  }
}

void nsdae_la_lu_forward(int n, const double *A, int lda, const int *pivot, double *b)
{
  if (n < SMALL_LU)
    lu_forward_small(n, A, lda, pivot, b);
  else
    NSDAE_ALONE(LAPACKE_dlaswp_work(LAPACK_COL_MAJOR, 1, b, n, 1, n, pivot, 1);
                cblas_dtrsv(CblasColMajor, CblasLower, CblasNoTrans, CblasUnit, n, A, lda, b, 1));
}

void nsdae_la_lu_backward(int n, const double *A, int lda, double *b)
{
  if (n < SMALL_LU)
    lu_backward_small(n, A, lda, b);
  else
    NSDAE_ALONE(
        cblas_dtrsv(CblasColMajor, CblasUpper, CblasNoTrans, CblasNonUnit, n, A, lda, b, 1));
}

void nsdae_la_lu_solve(int n, const double *A, int lda, const int *pivot, double *b)
{
  if (n == BODY && lda == BODY) {
    lu_forward_small(BODY, A, BODY, pivot, b);
    lu_backward_small(BODY, A, BODY, b);
    return;
  }
  nsdae_la_lu_forward(n, A, lda, pivot, b);
  nsdae_la_lu_backward(n, A, lda, b);
}

void nsdae_la_solve_upper_transposed(int n, const double *U, int ldu, double *b)
{
  if (n >= NSDAE_SMALL) {
    NSDAE_ALONE(cblas_dtrsv(CblasColMajor, CblasUpper, CblasTrans, CblasNonUnit, n, U, ldu, b, 1));
    return;
  }
  for (int i = 0; i < n; i++, U += ldu) b[i] = (b[i] - nsdae_dot(i, U, b)) / U[i];
}

/* Products of fewer multiplications than a square one of NSDAE_SMALL rows. */
static inline int is_small(int m, int n, int k)
{
  return (long)m * n * k < (long)NSDAE_SMALL * NSDAE_SMALL * (n == 1 ? 1 : NSDAE_SMALL);
}

/* Four sums side by side, for the latency of an addition. */
static void multiply_transposed_small(int n, int p, int r, double alpha, const double *A,
                                      size_t lda, const double *B, int ldb, double beta, double *C,
                                      int ldc)
{
  for (int j = 0; j < r; j++, B += ldb, C += ldc) {
    const double *column = A;
    int i = 0;
    for (; i + 4 <= p; i += 4, column += 4 * lda) {
      double s0 = 0, s1 = 0, s2 = 0, s3 = 0;
      for (size_t k = 0; k < (size_t)n; k++) {
        s0 += column[k] * B[k];
        s1 += column[lda + k] * B[k];
        s2 += column[2 * lda + k] * B[k];
        s3 += column[3 * lda + k] * B[k];
      }
      const double sum[4] = {s0, s1, s2, s3};
      for (int l = 0; l < 4; l++)
        C[i + l] = beta == 0 ? alpha * sum[l] : alpha * sum[l] + beta * C[i + l];
    }
    for (; i < p; i++, column += lda) {
      double sum = alpha * nsdae_dot(n, column, B);
      C[i] = beta == 0 ? sum : sum + beta * C[i];
    }
  }
}

void nsdae_la_multiply_transposed(int n, int p, int r, double alpha, const double *A, int lda,
                                  const double *B, int ldb, double beta, double *C, int ldc)
{
  if (n <= FEW)
    for (; r > 0; r--, B += ldb, C += ldc) {
      const double *column = A;
      for (int i = 0; i < p; i++, column += lda) {
        double sum = alpha * nsdae_dot(n, column, B);
        C[i] = beta == 0 ? sum : sum + beta * C[i];
      }
    }
  else if (p == 0 || r == 0)
    return;
  else if (is_small(p, r, n))
    multiply_transposed_small(n, p, r, alpha, A, (size_t)lda, B, ldb, beta, C, ldc);
  else if (r == 1)
    NSDAE_ALONE(cblas_dgemv(CblasColMajor, CblasTrans, n, p, alpha, A, lda, B, 1, beta, C, 1));
  else
    NSDAE_ALONE(cblas_dgemm(CblasColMajor, CblasTrans, CblasNoTrans, p, r, n, alpha, A, lda, B, ldb,
                            beta, C, ldc));
}

void nsdae_la_add_product(int n, int p, double alpha, const double *A, int lda, const double *x,
                          double *y)
{
  if (is_small(n, 1, p))
    subtract_product(n, p, A, (size_t)lda, -alpha, x, 1, y);
  else
    NSDAE_ALONE(cblas_dgemv(CblasColMajor, CblasNoTrans, n, p, alpha, A, lda, x, 1, 1.0, y, 1));
}

void nsdae_la_add_products(int n, int r, int p, double alpha, const double *A, int lda,
                           const double *B, int ldb, double *C, int ldc)
{
  if (is_small(n, r, p))
    for (int j = 0; j < r; j++)
      subtract_product(n, p, A, (size_t)lda, -alpha, B + (size_t)j * (size_t)ldb, 1,
                       C + (size_t)j * (size_t)ldc);
  else
    NSDAE_ALONE(cblas_dgemm(CblasColMajor, CblasNoTrans, CblasNoTrans, n, r, p, alpha, A, lda, B,
                            ldb, 1.0, C, ldc));
}

void nsdae_la_add_outer(int n, int r, int p, const double *A, int lda, const double *B, int ldb,
                        double *C, int ldc)
{
  if (is_small(n, r, p))
    for (int j = 0; j < r; j++)
      subtract_product(n, p, A, (size_t)lda, -1, B + j, (size_t)ldb, C + (size_t)j * (size_t)ldc);
  else
    NSDAE_ALONE(cblas_dgemm(CblasColMajor, CblasNoTrans, CblasTrans, n, r, p, 1.0, A, lda, B, ldb,
                            1.0, C, ldc));
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
