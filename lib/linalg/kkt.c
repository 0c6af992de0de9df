#include "kkt.h"

#include <float.h>
#include <math.h>
#include <nsdae/status.h>
#include <string.h>

#include "blas.h"
#include "dense.h"
#include "vector.h"

/* ---- dense kkt */

/* Block size that LAPACK's QR gets workspace for. */
enum { BLOCK = 32 };

/* Cholesky of S sees sines down to about 1e-6 (S squares them); what is near is decided by QR. */
static const double TRUSTED = 1e-5;

/* Of S, added to the diagonal of S in a basis: a sine is damped below 3e-6. There the rows of the
 * basis become dependent for a moment, as a mechanism at its change point, and their rates are
 * off by the error of an integrator, which a division by the sine would magnify. */
static const double DAMPING = 1e-11;

/* Factors of the last factorisation: of all rows, L of S = L L^T; of pivoted QR, R_11 in S; of the
 * rows of a basis, see solve_fixed. */
enum { FULL, BY_RANK, FIXED };

static void dense_kkt_layout(nsdae_kkt *kkt, nsdae_arena *arena)
{
  nsdae_dense_kkt *d = &kkt->dense;
  nsdae_kkt_pivoted *p = &d->pivoted;
  long n = kkt->n, m = kkt->m, rank = n < m ? n : m;
  d->lwork = (int)(3 * m + 1 + (m + 1) * BLOCK);
  d->L = NSDAE_ARENA_DOUBLES(arena, n * n);
  d->work = NSDAE_ARENA_DOUBLES(arena, m + d->lwork);
  nsdae_arena_doubles(arena, n * m, (double **[]){&d->Y, &p->Q, NULL});
  nsdae_arena_doubles(arena, m * rank, (double **[]){&d->S, &p->Z, NULL});
  p->T = NSDAE_ARENA_DOUBLES(arena, m * (kkt->typical > 0 ? rank : m));
  nsdae_arena_doubles(arena, m, (double **[]){&p->tau, &p->norm, NULL});
  nsdae_arena_ints(arena, m, (int **[]){&p->column, &p->held, &p->order, NULL});
}

/* ---- L, Y */

/* The roots of a diagonal M are in the first column of L. Returns 0, or the pivot that failed; -1
 * if M is not diagonal. */
static int factor_diagonal(const nsdae_blocks *blocks, const double *M, double *root)
{
  for (int b = 0; b < blocks->count; b++, root += nsdae_blocks_size(blocks, b - 1)) {
    size_t size = (size_t)nsdae_blocks_size(blocks, b);
    const double *block = M + blocks->square[b];
    if (!nsdae_la_is_diagonal((int)size, block, (int)size)) return -1;
    for (size_t i = 0; i < size; i++, block += size + 1) {
      if (!(*block > 0 && *block <= DBL_MAX)) return blocks->first[b] + (int)i + 1;
      root[i] = sqrt(*block);
    }
  }
  return 0;
}

static int factor_mass(nsdae_kkt *kkt, const double *M, const nsdae_coupling *C)
{
  const nsdae_blocks *blocks = kkt->blocks;
  nsdae_dense_kkt *d = &kkt->dense;
  size_t n = (size_t)kkt->n;
  int pivot = C ? -1 : factor_diagonal(blocks, M, d->L);
  d->diagonal = pivot >= 0;
  if (d->diagonal) return pivot;
  if (blocks->count > 1) memset(d->L, 0, n * n * sizeof *M);
  for (int b = 0; b < blocks->count; b++) {
    size_t size = (size_t)nsdae_blocks_size(blocks, b), at = (size_t)blocks->first[b];
    for (size_t j = 0; j < size; j++)
      memcpy(d->L + (at + j) * n + at, M + blocks->square[b] + j * size, size * sizeof *M);
  }
  const double *value = C ? C->value : NULL;
  for (int k = 0; C && k < C->count; k++) { /* below the diagonal */
    int i = C->pair[2 * k], j = C->pair[2 * k + 1], rows = nsdae_blocks_size(blocks, i);
    double *to = d->L + (size_t)blocks->first[j] * n + blocks->first[i];
    for (int c = 0; c < nsdae_blocks_size(blocks, j); c++, value += rows, to += n)
      memcpy(to, value, (size_t)rows * sizeof *to);
  }
  return nsdae_la_cholesky(kkt->n, d->L, kkt->n);
}

/* B [n x nrhs] := L^-1 B, or L^-T B. */
static void solve_root(const nsdae_kkt *kkt, int transposed, int nrhs, double *restrict B, int ldb)
{
  const double *restrict L = kkt->dense.L;
  int n = kkt->n;
  if (!kkt->dense.diagonal && transposed)
    nsdae_la_solve_lower_transposed(n, nrhs, L, n, B, ldb);
  else if (!kkt->dense.diagonal)
    nsdae_la_solve_lower(n, nrhs, L, n, B, ldb);
  else
    for (; nrhs > 0; nrhs--, B += ldb)
      for (int i = 0; i < n; i++) B[i] /= L[i];
}

/* Y := L^-1 J^T */
static void transform_rows(const nsdae_kkt *kkt, const nsdae_rows *J, double *Y)
{
  size_t n = (size_t)kkt->n;
  memset(Y, 0, n * (size_t)kkt->m * sizeof *Y); /* a row may have no part in an island */
  for (int i = 0; i < kkt->m; i++)
    nsdae_rows_gather(kkt->blocks, J, i, kkt->blocks->first, Y + (size_t)i * n, 1);
  solve_root(kkt, 0, kkt->m, Y, kkt->n);
}

/* ---- S */

/* Pivoted QR of Y with its columns at unit length, those that are held before all others; returns
 * the number of sines above tol, without those that are spare. */
static int pivoted_rank(nsdae_kkt *kkt, int hold, double tol)
{
  nsdae_kkt_pivoted *p = &kkt->dense.pivoted;
  int n = kkt->n, m = kkt->m, all = n < m ? n : m, rank = 0;
  int most = m - kkt->spare < all ? m - kkt->spare : all;
  memcpy(p->Q, kkt->dense.Y, (size_t)n * (size_t)m * sizeof *p->Q);
  for (int j = 0; j < m; j++) {
    double *column = p->Q + (size_t)j * (size_t)n;
    p->column[j] = hold ? p->held[j] : 0;
    double longest = nsdae_largest(n, column), root = 0;
    for (int i = 0; i < n && longest > 0; i++)
      column[i] /= longest; /* its squares do not underflow */
    if (longest > 0) root = sqrt(nsdae_dot(n, column, column));
    p->norm[j] = longest * root;
    for (int i = 0; i < n && longest > 0; i++) column[i] /= root;
  }
  NSDAE_ALONE(LAPACKE_dgeqp3_work(LAPACK_COL_MAJOR, n, m, p->Q, n, p->column, p->tau,
                                  kkt->dense.work, kkt->dense.lwork));
  kkt->left = 0;
  kkt->kept = 1;
  for (; rank < most; rank++) {
    double sine = fabs(p->Q[(size_t)rank * (size_t)n + (size_t)rank]);
    if (!(sine > tol)) {
      kkt->left = sine;
      break;
    }
    kkt->kept = fmin(kkt->kept, sine);
  }
  if (rank == most && most < all) kkt->left = fabs(p->Q[(size_t)rank * (size_t)n + (size_t)rank]);
  return rank;
}

/* The factors of the first r columns of the pivoted QR: Z [m x r] of (R N)^T, long rows first, and
 * S := R_11. Householder's QR is stable row by row when long rows come first (Powell and Reid,
 * 1969). The order holds columns of R; by insertion: m is small, and the order seldom changes. */
static void factor_by_rank(nsdae_kkt *kkt, int r)
{
  nsdae_dense_kkt *d = &kkt->dense;
  nsdae_kkt_pivoted *p = &d->pivoted;
  int n = kkt->n, m = kkt->m;
  kkt->rank = r;
  kkt->dependent = r < m ? p->column[r] - 1 : -1;
  d->form = BY_RANK;
  if (r == 0) return;
  for (int i = 0; i < m; i++) {
    int at = i;
    double length = p->norm[p->column[i] - 1];
    for (; at > 0 && p->norm[p->column[p->order[at - 1]] - 1] < length; at--)
      p->order[at] = p->order[at - 1];
    p->order[at] = i;
  }
  size_t rows = (size_t)m;
  for (size_t i = 0; i < (size_t)r; i++)
    for (size_t row = 0; row < rows; row++) {
      size_t j = (size_t)p->order[row];
      double entry = j >= i ? p->Q[j * (size_t)n + i] : 0;
      p->Z[i * rows + row] = entry * p->norm[p->column[j] - 1];
      if (j < (size_t)r) d->S[j * rows + i] = entry;
    }
  NSDAE_ALONE(LAPACKE_dorgqr_work(LAPACK_COL_MAJOR, n, r, r, p->Q, n, p->tau, d->work, d->lwork);
              LAPACKE_dgeqrf_work(LAPACK_COL_MAJOR, m, r, p->Z, m, p->tau, d->work, d->lwork);
              memcpy(p->T, p->Z, (size_t)m * (size_t)r * sizeof *p->T);
              LAPACKE_dorgqr_work(LAPACK_COL_MAJOR, m, r, r, p->Z, m, p->tau, d->work, d->lwork));
}

/* S := Y^T Y of r columns, damped and factored; 0 if it has no factor, else the smallest sine of
 * the angle between a column of Y and the span of those before it: what Cholesky of S leaves of its
 * diagonal entry, since row j of the factor has the norm of column j. */
static double factor_schur(nsdae_kkt *kkt, int r, double damping)
{
  nsdae_dense_kkt *d = &kkt->dense;
  size_t m = (size_t)r;
  double smallest = 1;
  nsdae_la_multiply_transposed(kkt->n, r, r, 1, d->Y, kkt->n, d->Y, kkt->n, 0, d->S, r);
  for (size_t i = 0; i < m && damping > 0; i++) d->S[i * (m + 1)] *= 1 + damping;
  if (nsdae_la_cholesky(r, d->S, r) != 0) return 0;
  for (size_t j = 0; j < m; j++) {
    double sum = 0, pivot = d->S[j * m + j];
    for (size_t k = 0; k <= j; k++) sum += d->S[k * m + j] * d->S[k * m + j];
    double square = sum > 0 ? pivot * pivot / sum : 0;
    if (square < smallest) smallest = square;
  }
  return sqrt(smallest);
}

/* M, and the rank of all rows. */
static int begin(nsdae_kkt *kkt, const double *M, const nsdae_coupling *C)
{
  kkt->pivot = factor_mass(kkt, M, C);
  kkt->rank = kkt->m;
  kkt->kept = 1;
  kkt->left = 0;
  kkt->dependent = -1;
  kkt->dense.form = FULL;
  return kkt->pivot ? NSDAE_E_MASS : NSDAE_OK;
}

static int dense_kkt_factor(nsdae_kkt *kkt, const double *M, const nsdae_rows *J)
{
  int status = begin(kkt, M, NULL);
  if (status < 0 || kkt->m == 0) return status;
  transform_rows(kkt, J, kkt->dense.Y);
  kkt->kept = kkt->m <= kkt->n && kkt->spare == 0 ? factor_schur(kkt, kkt->m, 0) : 0;
  if (kkt->kept >= TRUSTED && kkt->kept >= kkt->rank_tol) return NSDAE_OK;
  /* Those held that the factorisation before found independent, as long as they are. */
  nsdae_kkt_pivoted *p = &kkt->dense.pivoted;
  int hold = kkt->spare > 0, rank = pivoted_rank(kkt, hold, kkt->rank_tol);
  if (hold && rank < kkt->m - kkt->spare) rank = pivoted_rank(kkt, 0, kkt->rank_tol);
  memset(p->held, 0, (size_t)kkt->m * sizeof *p->held);
  for (int i = 0; i < rank; i++) p->held[p->column[i] - 1] = 1;
  factor_by_rank(kkt, rank);
  return NSDAE_OK;
}

/* ---- combinations of rows */

static int dense_kkt_factor_in(nsdae_kkt *kkt, const double *A, const nsdae_coupling *coupling,
                               const nsdae_rows *J, const double *basis, int rank)
{
  nsdae_dense_kkt *d = &kkt->dense;
  nsdae_kkt_pivoted *p = &d->pivoted;
  int n = kkt->n, m = kkt->m, status = begin(kkt, A, coupling);
  size_t rows = (size_t)m;
  kkt->rank = basis ? rank : m;
  d->form = basis ? FIXED : FULL;
  if (status < 0 || kkt->rank == 0) return status;
  if (kkt->rank > n) return NSDAE_E_CONVERGENCE;
  transform_rows(kkt, J, basis ? p->Q : d->Y);
  if (basis) {
    /* Z [m x r] of B = Z Z^T by Cholesky with pivoting: B = Z Z^T Z Z^T for a projector, so that
     * Z^T Z = 1. */
    int found = 0;
    memcpy(p->T, basis, rows * rows * sizeof *basis);
    NSDAE_ALONE(
        LAPACKE_dpstrf_work(LAPACK_COL_MAJOR, 'L', m, p->T, m, p->column, &found, -1, d->work));
    if (found < rank) return NSDAE_E_CONVERGENCE;
    memset(p->Z, 0, rows * (size_t)rank * sizeof *p->Z);
    for (size_t j = 0; j < (size_t)rank; j++)
      for (size_t i = j; i < rows; i++)
        p->Z[j * rows + (size_t)p->column[i] - 1] = p->T[j * rows + i];
    memset(d->Y, 0, (size_t)n * (size_t)rank * sizeof *d->Y);
    nsdae_la_add_products(n, rank, m, 1, p->Q, n, p->Z, m, d->Y, n);
  }
  kkt->kept = factor_schur(kkt, kkt->rank, basis ? DAMPING : 0);
  if (basis) return kkt->kept > 0 ? NSDAE_OK : NSDAE_E_CONVERGENCE;
  if (kkt->kept >= TRUSTED) return NSDAE_OK;
  kkt->spare = 0;
  if (pivoted_rank(kkt, 0, 0) < m) return NSDAE_E_CONVERGENCE;
  factor_by_rank(kkt, m);
  return NSDAE_OK;
}

/* ---- solutions */

/* z [n] -= Q w and g [m] := l, g holds c and becomes Y^T z - c. */
static void solve_by_rank(const nsdae_kkt *kkt, double *z, double *g)
{
  const nsdae_dense_kkt *d = &kkt->dense;
  const nsdae_kkt_pivoted *p = &d->pivoted;
  int n = kkt->n, m = kkt->m, r = kkt->rank;
  double *w = d->work, *l = d->work + m;
  nsdae_la_multiply_transposed(n, m, 1, 1, d->Y, n, z, n, -1, g, m);
  for (int i = 0; i < r; i++) w[i] = g[p->column[i] - 1] / p->norm[p->column[i] - 1];
  memset(g, 0, (size_t)m * sizeof *g);
  if (r == 0) return;
  nsdae_la_solve_upper_transposed(r, d->S, m, w);
  nsdae_la_add_product(n, r, -1, p->Q, n, w, z);
  nsdae_la_solve_upper_transposed(r, p->T, m, w);
  memset(l, 0, (size_t)m * sizeof *l);
  nsdae_la_add_product(m, r, 1, p->Z, m, w, l);
  for (int row = 0; row < m; row++) g[p->column[p->order[row]] - 1] = l[row];
}

/* z and c to x and l of the rows Z^T J: S w = Y^T z - Z^T c, z -= Y w, l = Z w. The equations are
 * linear: a second round, of their residual, takes the damping out of w. */
static void solve_fixed(const nsdae_kkt *kkt, double *z, double *c)
{
  const nsdae_dense_kkt *d = &kkt->dense;
  const double *Z = d->pivoted.Z;
  int n = kkt->n, m = kkt->m, r = kkt->rank;
  double *w = d->work, *sum = d->work + m;
  memset(sum, 0, (size_t)r * sizeof *sum);
  for (int round = 0; r > 0 && round < 2; round++) {
    nsdae_la_multiply_transposed(m, r, 1, -1, Z, m, c, m, 0, w, r);
    nsdae_la_multiply_transposed(n, r, 1, 1, d->Y, n, z, n, 1, w, r);
    nsdae_la_solve_cholesky(r, d->S, w);
    nsdae_la_add_product(n, r, -1, d->Y, n, w, z);
    nsdae_add(r, 1, w, sum);
  }
  memset(c, 0, (size_t)m * sizeof *c);
  nsdae_la_add_product(m, r, 1, Z, m, sum, c);
}

static void dense_kkt_solve_mass(const nsdae_kkt *kkt, double *r)
{
  const double *L = kkt->dense.L;
  if (!kkt->dense.diagonal) {
    nsdae_la_solve_cholesky(kkt->n, L, r);
    return;
  }
  for (int i = 0; i < kkt->n; i++) r[i] = r[i] / L[i] / L[i];
}

/* Of few velocities, in plain loops: z, c to z - Y l, l. */
static void solve_small(const nsdae_kkt *kkt, double *z, double *c)
{
  int n = kkt->n, m = kkt->m;
  const double *column = kkt->dense.Y;
  for (int i = 0; i < m; i++, column += n) c[i] = nsdae_dot(n, column, z) - c[i];
  nsdae_la_solve_cholesky(m, kkt->dense.S, c);
  column = kkt->dense.Y;
  for (int i = 0; i < m; i++, column += n) nsdae_add(n, -c[i], column, z);
}

static void dense_kkt_solve(const nsdae_kkt *kkt, int nrhs, double *R, int ldr, double *C, int ldc)
{
  const nsdae_dense_kkt *d = &kkt->dense;
  int n = kkt->n, m = kkt->m, at_once = d->form == FULL && n >= NSDAE_SMALL;
  if (m == 0 && nrhs == 1) { /* most steps of bodies without joints */
    dense_kkt_solve_mass(kkt, R);
    return;
  }
  solve_root(kkt, 0, nrhs, R, ldr);
  if (m > 0 && at_once) {
    nsdae_la_multiply_transposed(n, m, nrhs, 1, d->Y, n, R, ldr, -1, C, ldc);
    nsdae_la_solve_lower(m, nrhs, d->S, m, C, ldc);
    nsdae_la_solve_lower_transposed(m, nrhs, d->S, m, C, ldc);
    nsdae_la_add_products(n, nrhs, m, -1, d->Y, n, C, ldc, R, ldr);
  }
  for (int j = 0; j < nrhs && m > 0 && !at_once; j++) {
    double *z = R + (size_t)j * (size_t)ldr, *c = C + (size_t)j * (size_t)ldc;
    if (d->form == FIXED)
      solve_fixed(kkt, z, c);
    else if (d->form == BY_RANK)
      solve_by_rank(kkt, z, c);
    else
      solve_small(kkt, z, c);
  }
  solve_root(kkt, 1, nrhs, R, ldr);
}

/* ---- the basis */

/* The constraint that row a of Z is of. */
static size_t constraint_of(const nsdae_kkt_pivoted *p, size_t a)
{
  return (size_t)p->column[p->order[a]] - 1;
}

/* Of full rank, the projector to all. */
static void dense_kkt_basis(const nsdae_kkt *kkt, double *B)
{
  size_t m = (size_t)kkt->m;
  const nsdae_kkt_pivoted *p = &kkt->dense.pivoted;
  memset(B, 0, m * m * sizeof *B);
  for (size_t a = 0; a < m && kkt->dense.form == FULL; a++) B[a * (m + 1)] = 1;
  for (size_t a = 0; a < m && kkt->dense.form == BY_RANK; a++)
    for (size_t b = 0; b < m; b++) {
      double *entry = B + constraint_of(p, b) * m + constraint_of(p, a);
      for (size_t l = 0; l < (size_t)kkt->rank; l++) *entry += p->Z[l * m + a] * p->Z[l * m + b];
    }
}

static double dense_kkt_common(const nsdae_kkt *kkt, const double *B)
{
  size_t m = (size_t)kkt->m;
  const nsdae_kkt_pivoted *p = &kkt->dense.pivoted;
  double common = 0;
  for (size_t a = 0; a < m && kkt->dense.form == FULL; a++) common += B[a * (m + 1)];
  for (size_t l = 0; l < (size_t)kkt->rank && kkt->dense.form == BY_RANK; l++)
    for (size_t a = 0; a < m; a++)
      for (size_t b = 0; b < m; b++)
        common +=
            p->Z[l * m + a] * B[constraint_of(p, b) * m + constraint_of(p, a)] * p->Z[l * m + b];
  return common;
}

/* Velocities and rows of several blocks from which the sparse method is used. A factorisation and a
 * solution take the same time by both at 40 to 50 of chains and trees, of spherical and revolute
 * joints, and at 80 of ladders; at 80 further solutions still take half the time by the dense one.
 */
enum { SPARSE_FROM = 80 };

static int prefers_sparse(const nsdae_kkt *kkt)
{
  int rows = kkt->typical > 0 ? kkt->typical - 1 : kkt->m;
  return kkt->blocks->count > 1 && kkt->n + rows >= SPARSE_FROM;
}

static void lay_out_sparse(nsdae_kkt *kkt, int rows, nsdae_arena *arena)
{
  int most = rows > kkt->blocks->count ? rows : kkt->blocks->count;
  kkt->each = NSDAE_ARENA_INTS(arena, most);
  for (int i = 0; kkt->each && i < most; i++) kkt->each[i] = i;
}

void nsdae_kkt_layout(nsdae_kkt *kkt, nsdae_arena *arena)
{
  kkt->is_sparse = prefers_sparse(kkt);
  if (kkt->is_sparse)
    lay_out_sparse(kkt, kkt->m, arena);
  else
    dense_kkt_layout(kkt, arena);
}

void nsdae_kkt_layout_most(nsdae_kkt *kkt, int rows, nsdae_arena *arena)
{
  int n = kkt->n, m = kkt->m;
  if (prefers_sparse(kkt)) {
    lay_out_sparse(kkt, rows, arena);
    if (n > SPARSE_FROM) kkt->n = SPARSE_FROM;
    if (m > SPARSE_FROM) kkt->m = SPARSE_FROM;
  }
  dense_kkt_layout(kkt, arena);
  kkt->n = n;
  kkt->m = m;
}

void nsdae_kkt_turn_to(nsdae_kkt *kkt, const nsdae_blocks *blocks, int n, int m)
{
  kkt->blocks = blocks;
  kkt->n = n;
  kkt->m = m;
  kkt->is_sparse = kkt->each && n + m >= SPARSE_FROM;
}

void nsdae_kkt_release(nsdae_kkt *kkt)
{
  nsdae_sparse_kkt_release(&kkt->sparse);
}

/* ---- the sparse method, of all blocks and rows */

static nsdae_kkt_part whole(const nsdae_kkt *kkt, const nsdae_rows *J)
{
  return (nsdae_kkt_part){kkt->blocks, J, kkt->blocks->count, kkt->m, kkt->each, kkt->each};
}

int nsdae_kkt_reserve(nsdae_kkt *kkt, const nsdae_rows *J)
{
  const nsdae_kkt_part all = whole(kkt, J);
  return kkt->is_sparse ? nsdae_sparse_kkt_analyse(&kkt->sparse, &all) : NSDAE_OK;
}

static int factor_sparse(nsdae_kkt *kkt, const double *M, const nsdae_coupling *coupling,
                         const nsdae_rows *J, int fixed, const double *basis)
{
  nsdae_sparse_kkt *s = &kkt->sparse;
  const nsdae_kkt_part all = whole(kkt, J);
  s->rank_tol = kkt->rank_tol;
  s->spare = kkt->spare;
  int status = nsdae_sparse_kkt_analyse(s, &all);
  if (status == NSDAE_OK)
    status = coupling && coupling->count > 0
                 ? nsdae_sparse_kkt_factor_coupled(s, M, coupling, basis)
             : fixed ? nsdae_sparse_kkt_factor_in(s, M, basis)
                     : nsdae_sparse_kkt_factor(s, M);
  kkt->pivot = s->pivot > 0 ? kkt->blocks->first[s->bad_block] + s->pivot : 0;
  if (status < 0) return status;
  kkt->rank = s->rank.count;
  kkt->kept = s->rank.kept;
  kkt->left = s->rank.left;
  kkt->dependent = s->rank.dependent;
  return NSDAE_OK;
}

/* ---- either */

int nsdae_kkt_factor(nsdae_kkt *kkt, const double *M, const nsdae_rows *J)
{
  return kkt->is_sparse ? factor_sparse(kkt, M, NULL, J, 0, NULL) : dense_kkt_factor(kkt, M, J);
}

int nsdae_kkt_factor_coupled(nsdae_kkt *kkt, const double *A, const nsdae_coupling *coupling,
                             const nsdae_rows *J, const double *basis, int rank)
{
  return kkt->is_sparse ? factor_sparse(kkt, A, coupling, J, 1, basis)
                        : dense_kkt_factor_in(kkt, A, coupling, J, basis, rank);
}

int nsdae_kkt_solve(const nsdae_kkt *kkt, int nrhs, double *R, int ldr, double *C, int ldc)
{
  int status = NSDAE_OK;
  if (!kkt->is_sparse) {
    dense_kkt_solve(kkt, nrhs, R, ldr, C, ldc);
    return NSDAE_OK;
  }
  for (int j = 0; j < nrhs && status == NSDAE_OK; j++, R += ldr, C += ldc)
    status = nsdae_sparse_kkt_solve(&kkt->sparse, R, R, C);
  return status;
}

void nsdae_kkt_solve_mass(const nsdae_kkt *kkt, double *r)
{
  if (kkt->is_sparse)
    nsdae_sparse_kkt_solve_mass(&kkt->sparse, r);
  else
    dense_kkt_solve_mass(kkt, r);
}

/* J^T l is M x + J^T l' with x = 0: the rest of l' is least. */
int nsdae_kkt_least_norm(const nsdae_kkt *kkt, const nsdae_rows *J, double *l, double *r)
{
  memset(r, 0, (size_t)kkt->n * sizeof *r);
  for (int i = 0; i < kkt->m; i++) nsdae_rows_add(kkt->blocks, J, i, l[i], r);
  memset(l, 0, (size_t)kkt->m * sizeof *l);
  return nsdae_kkt_solve(kkt, 1, r, kkt->n, l, kkt->m);
}

long nsdae_kkt_basis_size(const nsdae_kkt *kkt)
{
  return prefers_sparse(kkt) ? kkt->m : (long)kkt->m * kkt->m;
}

void nsdae_kkt_basis(const nsdae_kkt *kkt, double *basis)
{
  if (kkt->is_sparse)
    nsdae_sparse_kkt_kept(&kkt->sparse, basis);
  else
    dense_kkt_basis(kkt, basis);
}

double nsdae_kkt_common(const nsdae_kkt *kkt, const double *basis)
{
  return kkt->is_sparse ? nsdae_sparse_kkt_common(&kkt->sparse, basis)
                        : dense_kkt_common(kkt, basis);
}
