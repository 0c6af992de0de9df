#include "kkt.h"

#include <cblas.h>
#include <float.h>
#include <lapacke.h>
#include <math.h>
#include <stddef.h>
#include <string.h>

#include <nsdae/status.h>

#include "dense.h"
#include "vector.h"

/* Block size that LAPACK's QR gets workspace for. */
enum { BLOCK = 32 };

static int smaller(int a, int b)
{
  return a < b ? a : b;
}

void nsdae_kkt_layout(nsdae_kkt *kkt, nsdae_arena *arena)
{
  int n = kkt->n, m = kkt->m;
  kkt->lwork = 3 * m + 1 + (m + 1) * BLOCK;
  kkt->L = NSDAE_ARENA_DOUBLES(arena, (long)n * n);
  kkt->Y = NSDAE_ARENA_DOUBLES(arena, (long)n * m);
  kkt->S = NSDAE_ARENA_DOUBLES(arena, (long)m * m);
  kkt->pivoted.Q = NSDAE_ARENA_DOUBLES(arena, (long)n * m);
  kkt->pivoted.Z = NSDAE_ARENA_DOUBLES(arena, (long)m * m);
  kkt->pivoted.T = NSDAE_ARENA_DOUBLES(arena, (long)m * m);
  kkt->pivoted.tau = NSDAE_ARENA_DOUBLES(arena, m);
  kkt->pivoted.norm = NSDAE_ARENA_DOUBLES(arena, m);
  kkt->work = NSDAE_ARENA_DOUBLES(arena, m + kkt->lwork);
  kkt->pivoted.column = NSDAE_ARENA_INTS(arena, m);
  kkt->pivoted.held = NSDAE_ARENA_INTS(arena, m);
  kkt->pivoted.order = NSDAE_ARENA_INTS(arena, m);
}

/* The roots of a diagonal M stand in the first column of L. Returns 0, or the pivot that failed. */
static int factor_mass(nsdae_kkt *kkt, const double *M, int ldm)
{
  int n = kkt->n;
  kkt->diagonal = nsdae_la_is_diagonal(n, M, ldm);
  if (!kkt->diagonal) {
    for (int j = 0; j < n && ldm != n; j++)
      memcpy(kkt->L + (size_t)j * (size_t)n, M + (size_t)j * (size_t)ldm, (size_t)n * sizeof *M);
    if (ldm == n) memcpy(kkt->L, M, (size_t)n * (size_t)n * sizeof *M);
    return nsdae_la_cholesky(n, kkt->L, n);
  }
  for (int i = 0; i < n; i++) {
    double entry = M[(size_t)i * (size_t)(ldm + 1)];
    if (!(entry > 0 && entry <= DBL_MAX)) return i + 1;
    kkt->L[i] = sqrt(entry);
  }
  return 0;
}

static void divide(int n, int nrhs, const double *restrict root, double *restrict B, int ldb)
{
  for (; nrhs > 0; nrhs--, B += ldb)
    for (int i = 0; i < n; i++) B[i] /= root[i];
}

/* B [n x nrhs] := L^-1 B. */
static void solve_root(const nsdae_kkt *kkt, int nrhs, double *B, int ldb)
{
  if (kkt->diagonal)
    divide(kkt->n, nrhs, kkt->L, B, ldb);
  else
    nsdae_la_solve_lower(kkt->n, nrhs, kkt->L, kkt->n, B, ldb);
}

/* B [n x nrhs] := L^-T B. */
static void solve_root_transposed(const nsdae_kkt *kkt, int nrhs, double *B, int ldb)
{
  if (kkt->diagonal)
    divide(kkt->n, nrhs, kkt->L, B, ldb);
  else
    nsdae_la_solve_lower_transposed(kkt->n, nrhs, kkt->L, kkt->n, B, ldb);
}

static void transpose(int m, int n, const double *J, int ldj, double *Y)
{
  for (size_t i = 0; i < (size_t)m; i++)
    for (size_t j = 0; j < (size_t)n; j++) Y[i * (size_t)n + j] = J[j * (size_t)ldj + i];
}

/* Squared sine of the angle between column j of Y and the span of those before it, the smallest
 * over j: what Cholesky of S leaves of each diagonal entry, since row j of its factor has the
 * norm of column j. */
static double smallest_sine(size_t m, const double *factor)
{
  double smallest = 1;
  for (size_t j = 0; j < m; j++) {
    double sum = 0, pivot = factor[j * m + j];
    for (size_t k = 0; k <= j; k++) sum += factor[k * m + j] * factor[k * m + j];
    smallest = fmin(smallest, pivot * pivot / sum);
  }
  return smallest;
}

/* Pivoted QR of Y with its columns at unit length, those that are held before all others; returns
 * the rank. */
static int pivoted_rank(nsdae_kkt *kkt, int hold)
{
  int n = kkt->n, m = kkt->m, most = smaller(n, m), rank = 0;
  memcpy(kkt->pivoted.Q, kkt->Y, (size_t)n * (size_t)m * sizeof *kkt->pivoted.Q);
  for (int j = 0; j < m; j++) {
    double *column = kkt->pivoted.Q + (size_t)j * (size_t)n;
    kkt->pivoted.column[j] = hold ? kkt->pivoted.held[j] : 0;
    kkt->pivoted.norm[j] = cblas_dnrm2(n, column, 1);
    if (kkt->pivoted.norm[j] > 0) cblas_dscal(n, 1 / kkt->pivoted.norm[j], column, 1);
  }
  LAPACKE_dgeqp3_work(LAPACK_COL_MAJOR, n, m, kkt->pivoted.Q, n, kkt->pivoted.column,
                      kkt->pivoted.tau, kkt->work, kkt->lwork);
  kkt->left = 0;
  kkt->kept = 1;
  for (; rank < most; rank++) {
    double sine = fabs(kkt->pivoted.Q[(size_t)rank * (size_t)n + (size_t)rank]);
    if (!(sine > kkt->rank_tol)) {
      kkt->left = sine;
      break;
    }
    kkt->kept = fmin(kkt->kept, sine);
  }
  return rank;
}

/* The same with those held that the factorisation before found independent, as long as they are. */
static int find_rank(nsdae_kkt *kkt)
{
  int rank = pivoted_rank(kkt, kkt->hold), held = 0;
  for (int j = 0; j < kkt->m && kkt->hold; j++) held += kkt->pivoted.held[j];
  if (rank < held) rank = pivoted_rank(kkt, 0);
  memset(kkt->pivoted.held, 0, (size_t)kkt->m * sizeof *kkt->pivoted.held);
  for (int i = 0; i < rank; i++) kkt->pivoted.held[kkt->pivoted.column[i] - 1] = 1;
  return rank;
}

/* By insertion: m is small, and the order seldom changes. Householder's QR is stable row by row
 * when long rows come first (Powell and Reid, 1969). The order holds columns of R. */
static void sort_by_length(nsdae_kkt *kkt)
{
  for (int i = 0; i < kkt->m; i++) {
    int at = i;
    double length = kkt->pivoted.norm[kkt->pivoted.column[i] - 1];
    for (;
         at > 0 && kkt->pivoted.norm[kkt->pivoted.column[kkt->pivoted.order[at - 1]] - 1] < length;
         at--)
      kkt->pivoted.order[at] = kkt->pivoted.order[at - 1];
    kkt->pivoted.order[at] = i;
  }
}

/* Z [m x r] := (R N)^T, long rows first; S := R_11. */
static void independent_rows(nsdae_kkt *kkt, int r)
{
  size_t n = (size_t)kkt->n, m = (size_t)kkt->m;
  sort_by_length(kkt);
  for (size_t i = 0; i < (size_t)r; i++)
    for (size_t row = 0; row < m; row++) {
      size_t j = (size_t)kkt->pivoted.order[row];
      double entry = j >= i ? kkt->pivoted.Q[j * n + i] : 0;
      kkt->pivoted.Z[i * m + row] = entry * kkt->pivoted.norm[kkt->pivoted.column[j] - 1];
      if (j < (size_t)r) kkt->S[j * m + i] = entry;
    }
}

static void factor_by_rank(nsdae_kkt *kkt)
{
  int n = kkt->n, m = kkt->m, r = find_rank(kkt);
  kkt->rank = r;
  kkt->factored_by_rank = 1;
  if (r == 0) return;
  independent_rows(kkt, r);
  LAPACKE_dorgqr_work(LAPACK_COL_MAJOR, n, r, r, kkt->pivoted.Q, n, kkt->pivoted.tau, kkt->work,
                      kkt->lwork);
  LAPACKE_dgeqrf_work(LAPACK_COL_MAJOR, m, r, kkt->pivoted.Z, m, kkt->pivoted.tau, kkt->work,
                      kkt->lwork);
  memcpy(kkt->pivoted.T, kkt->pivoted.Z, (size_t)m * (size_t)r * sizeof *kkt->pivoted.T);
  LAPACKE_dorgqr_work(LAPACK_COL_MAJOR, m, r, r, kkt->pivoted.Z, m, kkt->pivoted.tau, kkt->work,
                      kkt->lwork);
}

int nsdae_kkt_factor(nsdae_kkt *kkt, const double *M, int ldm, const double *J, int ldj)
{
  /* Cholesky of S sees sines down to about 1e-6 (S squares them); what is near is decided by QR */
  const double trusted = 1e-5;
  int n = kkt->n, m = kkt->m;
  kkt->pivot = factor_mass(kkt, M, ldm);
  if (kkt->pivot) return NSDAE_E_MASS;
  kkt->rank = m;
  kkt->kept = 1;
  kkt->left = 0;
  kkt->factored_by_rank = 0;
  if (m == 0) return NSDAE_OK;
  transpose(m, n, J, ldj, kkt->Y);
  solve_root(kkt, m, kkt->Y, n);
  nsdae_la_multiply_transposed(n, m, m, kkt->Y, n, kkt->Y, n, 0, kkt->S, m);
  double least = fmax(trusted, kkt->rank_tol);
  if (nsdae_la_cholesky(m, kkt->S, m) == 0)
    kkt->kept = sqrt(smallest_sine((size_t)m, kkt->S));
  else
    kkt->kept = 0;
  if (kkt->kept < least) factor_by_rank(kkt);
  return NSDAE_OK;
}

/* z [n] -= Q w and g [m] := l, of g = Y^T z - c. */
static void solve_by_rank(const nsdae_kkt *kkt, double *z, double *g)
{
  int n = kkt->n, m = kkt->m, r = kkt->rank;
  double *w = kkt->work, *l = kkt->work + m;
  for (int i = 0; i < r; i++)
    w[i] = g[kkt->pivoted.column[i] - 1] / kkt->pivoted.norm[kkt->pivoted.column[i] - 1];
  memset(g, 0, (size_t)m * sizeof *g);
  if (r == 0) return;
  cblas_dtrsv(CblasColMajor, CblasUpper, CblasTrans, CblasNonUnit, r, kkt->S, m, w, 1);
  cblas_dgemv(CblasColMajor, CblasNoTrans, n, r, -1.0, kkt->pivoted.Q, n, w, 1, 1.0, z, 1);
  cblas_dtrsv(CblasColMajor, CblasUpper, CblasTrans, CblasNonUnit, r, kkt->pivoted.T, m, w, 1);
  cblas_dgemv(CblasColMajor, CblasNoTrans, m, r, 1.0, kkt->pivoted.Z, m, w, 1, 0.0, l, 1);
  for (int row = 0; row < m; row++) g[kkt->pivoted.column[kkt->pivoted.order[row]] - 1] = l[row];
}

/* R [n x nrhs] holds z on entry and z - Y l on return, C [m x nrhs] Y^T z - c and l. */
static void solve_schur(const nsdae_kkt *kkt, int nrhs, double *R, int ldr, double *C, int ldc)
{
  int n = kkt->n, m = kkt->m;
  if (kkt->factored_by_rank) {
    for (size_t j = 0; j < (size_t)nrhs; j++)
      solve_by_rank(kkt, R + j * (size_t)ldr, C + j * (size_t)ldc);
    return;
  }
  nsdae_la_solve_lower(m, nrhs, kkt->S, m, C, ldc);
  nsdae_la_solve_lower_transposed(m, nrhs, kkt->S, m, C, ldc);
  nsdae_la_subtract_product(n, m, nrhs, kkt->Y, n, C, ldc, R, ldr);
}

void nsdae_kkt_solve_mass(const nsdae_kkt *kkt, double *r)
{
  if (!kkt->diagonal) {
    nsdae_la_solve_cholesky(kkt->n, kkt->L, r);
    return;
  }
  for (int i = 0; i < kkt->n; i++) r[i] = r[i] / kkt->L[i] / kkt->L[i];
}

/* The same of one right-hand side and a few rows, in plain loops: z, c to z - Y l, l. */
static void solve_schur_small(const nsdae_kkt *kkt, double *z, double *c)
{
  int n = kkt->n, m = kkt->m;
  const double *column = kkt->Y;
  for (int i = 0; i < m; i++, column += n) c[i] = nsdae_dot(n, column, z) - c[i];
  nsdae_la_solve_cholesky(m, kkt->S, c);
  column = kkt->Y;
  for (int i = 0; i < m; i++, column += n) nsdae_add(n, -c[i], column, z);
}

void nsdae_kkt_solve(const nsdae_kkt *kkt, int nrhs, double *R, int ldr, double *C, int ldc)
{
  int n = kkt->n, m = kkt->m;
  if (m == 0 && nrhs == 1) { /* most steps of bodies without joints */
    nsdae_kkt_solve_mass(kkt, R);
    return;
  }
  solve_root(kkt, nrhs, R, ldr);
  if (m > 0 && nrhs == 1 && n < NSDAE_SMALL && !kkt->factored_by_rank) {
    solve_schur_small(kkt, R, C);
  } else if (m > 0) {
    nsdae_la_multiply_transposed(n, m, nrhs, kkt->Y, n, R, ldr, -1, C, ldc);
    solve_schur(kkt, nrhs, R, ldr, C, ldc);
  }
  solve_root_transposed(kkt, nrhs, R, ldr);
}

/* J^T l is M x + J^T l' with x = 0: the rest of l' is least. */
void nsdae_kkt_least_norm(const nsdae_kkt *kkt, const double *J, double *l, double *r)
{
  size_t n = (size_t)kkt->n, m = (size_t)kkt->m;
  for (size_t j = 0; j < n; j++) r[j] = nsdae_dot(kkt->m, J + j * m, l);
  memset(l, 0, m * sizeof *l);
  nsdae_kkt_solve(kkt, 1, r, kkt->n, l, kkt->m);
}

/* The constraint that row a of Z is of. */
static size_t constraint_of(const nsdae_kkt *kkt, size_t a)
{
  return (size_t)kkt->pivoted.column[kkt->pivoted.order[a]] - 1;
}

void nsdae_kkt_range(const nsdae_kkt *kkt, double *B)
{
  size_t m = (size_t)kkt->m;
  const double *Z = kkt->pivoted.Z;
  memset(B, 0, m * m * sizeof *B);
  for (size_t a = 0; a < m; a++)
    for (size_t b = 0; b < m; b++) {
      double *entry = B + constraint_of(kkt, b) * m + constraint_of(kkt, a);
      for (size_t l = 0; l < (size_t)kkt->rank; l++) *entry += Z[l * m + a] * Z[l * m + b];
    }
}

double nsdae_kkt_common(const nsdae_kkt *kkt, const double *B)
{
  size_t m = (size_t)kkt->m;
  const double *Z = kkt->pivoted.Z;
  double common = 0;
  for (size_t l = 0; l < (size_t)kkt->rank; l++)
    for (size_t a = 0; a < m; a++)
      for (size_t b = 0; b < m; b++)
        common +=
            Z[l * m + a] * B[constraint_of(kkt, b) * m + constraint_of(kkt, a)] * Z[l * m + b];
  return common;
}
