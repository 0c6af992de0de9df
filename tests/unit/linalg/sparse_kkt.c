/* Sparse saddle-point equations of mechanisms, by fronts: against their residuals, dense
 * LAPACK, the coordinates of the joints of trees, and the rank that a mechanism has. */
#include "check.h"

#include <float.h>
#include <lapacke.h>
#include <nsdae/status.h>
#include <stdlib.h>

#include "allocator.h"
#include "kkt.h"
#include "sparse_schur.h"
#include "support/joint_families.h"

/* Vectors of a whole system. */
typedef struct vectors {
  double *x, *l, *r, *c; /* wanted solution, right-hand side */
  double *v, *lambda;    /* found */
} vectors;

static double *doubles(int count)
{
  double *a = calloc((size_t)count, sizeof *a);
  assert_non_null(a);
  return a;
}

/* A right-hand side that is consistent, whatever the rank. */
static vectors make_vectors(joint_family *f)
{
  int n = f->nv + OTHER, m = f->rows + 1;
  vectors w = {doubles(n), doubles(m), doubles(n), doubles(m), doubles(n), doubles(m)};
  for (int j = OTHER; j < n; j++) w.x[j] = random_number(&f->random);
  for (int i = 1; i < m; i++) w.l[i] = random_number(&f->random);
  family_apply(f, 1, w.x, w.l, w.r, w.c);
  return w;
}

static void release_vectors(vectors *w)
{
  free(w->x), free(w->l), free(w->r), free(w->c), free(w->v), free(w->lambda);
}

static nsdae_kkt_part part_of(const joint_family *f)
{
  return (nsdae_kkt_part){.blocks = &f->blocks,
                          .J = &f->J,
                          .block_count = f->bodies,
                          .row_count = f->rows,
                          .block = f->block,
                          .row = f->row};
}

static int factor(nsdae_sparse_kkt *k, const joint_family *f)
{
  nsdae_kkt_part part = part_of(f);
  int status = nsdae_sparse_kkt_analyse(k, &part);
  return status < 0 ? status : nsdae_sparse_kkt_factor(k, f->M);
}

static int solve(nsdae_sparse_kkt *k, const joint_family *f, vectors *w)
{
  memcpy(w->lambda, w->c, (size_t)(f->rows + 1) * sizeof *w->c);
  return nsdae_sparse_kkt_solve(k, w->r, w->v, w->lambda);
}

static double largest(const double *a, int n)
{
  double most = 0;
  for (int i = 0; i < n; i++) most = fmax(most, isfinite(a[i]) ? fabs(a[i]) : INFINITY);
  return most;
}

/* Largest sum of the sizes of a row of the whole matrix. */
static double norm_of(const joint_family *f)
{
  int n = f->nv + OTHER, m = f->rows + 1;
  double most = 0, *sum = doubles(n + m);
  for (int i = 0; i < 6 * f->nv; i++) sum[OTHER + i / 36 * 6 + i % 6] += fabs(f->M[4 + i]);
  for (int i = 1; i < m; i++)
    for (int p = f->J.first[i]; p < f->J.first[i + 1]; p++)
      for (int j = 0; j < 6; j++) {
        double value = fabs(f->J.value[f->J.at[p] + (size_t)j]);
        sum[f->blocks.first[f->J.block[p]] + j] += value;
        sum[n + i] += value;
      }
  most = largest(sum, n + m);
  free(sum);
  return most;
}

/* ||r|| / (||K|| ||x|| + ||b||) */
static double backward_error(const joint_family *f, const vectors *w)
{
  int n = f->nv + OTHER, m = f->rows + 1;
  double *r = doubles(n), *c = doubles(m);
  memcpy(r, w->r, (size_t)n * sizeof *r);
  memcpy(c, w->c, (size_t)m * sizeof *c);
  family_apply(f, -1, w->v, w->lambda, r, c);
  c[0] = 0; /* not of the part */
  double left = fmax(largest(r, n), largest(c, m));
  double x = fmax(largest(w->v, n), largest(w->lambda, m));
  double b = fmax(largest(w->r, n), largest(w->c, m));
  free(r), free(c);
  return left / (norm_of(f) * x + b);
}

/* Error of x, relative in the norm of M. */
static double error_of_motion(const joint_family *f, const vectors *w)
{
  int n = f->nv + OTHER;
  double *d = doubles(n), wrong, all;
  for (int j = OTHER; j < n; j++) d[j] = w->v[j] - w->x[j];
  wrong = nsdae_blocks_square(&f->blocks, f->M, d);
  all = nsdae_blocks_square(&f->blocks, f->M, w->x);
  free(d);
  return sqrt(wrong / all);
}

/* One member. */
static void expect_solved(int kind, int bodies, int revolute, double spread, uint64_t seed)
{
  joint_family f;
  family_make(&f, kind, bodies, revolute, spread, seed);
  vectors w = make_vectors(&f);
  nsdae_sparse_kkt k = {.rank_tol = 1e-8};
  assert_int_equal(factor(&k, &f), NSDAE_OK);
  assert_int_equal(k.rank.count, f.rank);
  assert_true(k.rank.kept > 1e-6 && k.rank.kept <= 1 && k.rank.left < 1e-8);
  assert_int_equal(solve(&k, &f, &w), NSDAE_OK);
  assert_true(backward_error(&f, &w) <= 1e-12);
  assert_true(error_of_motion(&f, &w) <= 1e-12);
  nsdae_sparse_kkt_release(&k);
  release_vectors(&w);
  family_release(&f);
}

static void test_families(void **state)
{
  (void)state;
  const int sizes[] = {10, 100, 1000};
  const double spreads[] = {0, 3}; /* mass ratios of 1 and 1e6 */
  for (int s = 0; s < 3; s++)
    for (int i = 0; i < 2; i++)
      for (int revolute = 0; revolute < 2; revolute++) {
        expect_solved(CHAIN, sizes[s], revolute, spreads[i], (uint64_t)s);
        expect_solved(TREE, sizes[s], revolute, spreads[i], (uint64_t)s);
      }
  for (int wide = 3; wide < 33; wide = 3 * wide)
    for (int i = 0; i < 2; i++) expect_solved(NET, wide * wide, 0, spreads[i], (uint64_t)wide);
}

/* Closed loops, whose redundant rows are counted: masses of ratio 1e6 leave pivots of redundant
 * rows that are as large as those of others. */
static void test_loops(void **state)
{
  (void)state;
  const double spreads[] = {0, 3};
  const int rings[] = {10, 100, 300, 500}, ladders[] = {3, 99, 300};
  for (int i = 0; i < 2; i++)
    for (uint64_t seed = 0; seed < 4; seed++) {
      for (int s = 0; s < 4; s++) expect_solved(RING, rings[s], 1, spreads[i], seed);
      for (int s = 0; s < 3; s++) expect_solved(LADDER, ladders[s], 1, spreads[i], seed);
    }
  expect_solved(RING, 1000, 1, 0, 1);
  expect_solved(LADDER, 999, 1, 0, 1);
}

/* Equations that contradict each other by 3e-6. With rank_tol = 1e-6 that is within what redundant
 * rows may miss, 1e-6 of the size of the row times that of x; with 1e-8 it is not. */
static void test_contradiction(void **state)
{
  (void)state;
  const double rank_tols[] = {1e-6, 1e-8};
  const int statuses[] = {NSDAE_OK, NSDAE_E_CONVERGENCE};
  for (int i = 0; i < 2; i++) {
    joint_family f;
    family_make(&f, RING, 12, 1, 0, 3);
    vectors w = make_vectors(&f);
    nsdae_sparse_kkt k = {.rank_tol = rank_tols[i]};
    assert_int_equal(factor(&k, &f), NSDAE_OK);
    assert_int_equal(k.rank.count, f.rank);
    for (int row = 1; row <= f.rows; row++) w.c[row] += 3e-6 * random_number(&f.random);
    assert_int_equal(solve(&k, &f, &w), statuses[i]);
    nsdae_sparse_kkt_release(&k);
    release_vectors(&w);
    family_release(&f);
  }
}

/* [M J^T; J 0] of the part, [nv + rows] squared, and its right-hand side. */
static int whole(const joint_family *f, const vectors *w, double *K, double *b)
{
  int n = f->nv, all = n + f->rows;
  for (int i = 0; i < 36 * f->bodies; i++) {
    int at = i / 36 * 6;
    K[(at + i % 36 / 6) * all + at + i % 6] = f->M[OTHER * OTHER + i];
  }
  for (int i = 1; i <= f->rows; i++)
    for (int p = f->J.first[i]; p < f->J.first[i + 1]; p++)
      for (int j = 0; j < 6; j++) {
        int at = f->blocks.first[f->J.block[p]] - OTHER + j;
        K[at * all + n + i - 1] = K[(n + i - 1) * all + at] = f->J.value[f->J.at[p] + (size_t)j];
      }
  memcpy(b, w->r + OTHER, (size_t)n * sizeof *b);
  memcpy(b + n, w->c + 1, (size_t)f->rows * sizeof *b);
  return all;
}

/* x and l against the least-norm solution of the whole matrix, as LAPACK's divide and conquer finds
 * it. */
static void expect_as_lapack(int kind, int bodies, int revolute)
{
  joint_family f;
  family_make(&f, kind, bodies, revolute, 0, 7 + (uint64_t)kind);
  vectors w = make_vectors(&f);
  int all = f.nv + f.rows;
  double *K = doubles(all * all), *b = doubles(all), *sigma = doubles(all);
  lapack_int rank;
  whole(&f, &w, K, b);
  assert_int_equal(
      LAPACKE_dgelsd(LAPACK_COL_MAJOR, all, all, 1, K, all, b, all, sigma, 1e-11, &rank), 0);
  assert_int_equal(rank, f.nv + f.rank);
  nsdae_sparse_kkt k = {.rank_tol = 1e-8};
  assert_int_equal(factor(&k, &f), NSDAE_OK);
  assert_int_equal(solve(&k, &f, &w), NSDAE_OK);
  double size = 1 + largest(b, all);
  for (int j = 0; j < f.nv; j++) assert_near(w.v[OTHER + j], b[j], 1e-10 * size);
  for (int j = 0; j < f.rows; j++) assert_near(w.lambda[1 + j], b[f.nv + j], 1e-9 * size);
  nsdae_sparse_kkt_release(&k);
  free(K), free(b), free(sigma);
  release_vectors(&w);
  family_release(&f);
}

static void test_against_dgelsd(void **state)
{
  (void)state;
  for (int revolute = 0; revolute < 2; revolute++) {
    expect_as_lapack(CHAIN, 20, revolute);
    expect_as_lapack(TREE, 15, revolute);
  }
  expect_as_lapack(NET, 16, 0);
  expect_as_lapack(LADDER, 3, 1);
  expect_as_lapack(LADDER, 15, 1);
  expect_as_lapack(RING, 12, 1);
}

/* Velocities of a tree of spherical joints from the angular velocities of its bodies: column 3 b +
 * e of N [nv x 3 bodies]. */
static void tree_motions(const joint_family *f, double *N)
{
  for (int b = 0; b < f->bodies; b++)
    for (int e = 0; e < 3; e++) {
      double *column = N + (size_t)(3 * b + e) * (size_t)f->nv;
      column[6 * b + 3 + e] = 1;
      for (int i = b; i < f->bodies; i++) { /* parents have smaller numbers */
        const double *arm = f->arm + 6 * i, *w = column + 6 * i + 3;
        const double *up = f->parent[i] < 0 ? NULL : column + 6 * f->parent[i];
        for (int j = 0; j < 3; j++) {
          int k = (j + 1) % 3, l = (j + 2) % 3;
          column[6 * i + j] = -(w[k] * arm[l] - w[l] * arm[k]);
          if (up) column[6 * i + j] += up[j] + up[3 + k] * arm[3 + l] - up[3 + l] * arm[3 + k];
        }
      }
    }
}

/* With c = 0 in the coordinates of the joints: x = N y, N^T M N y = N^T r. */
static void test_minimal_coordinates(void **state)
{
  (void)state;
  for (int kind = CHAIN; kind <= TREE; kind++) {
    joint_family f;
    family_make(&f, kind, 60, 0, 1, 5);
    vectors w = make_vectors(&f);
    int n = f.nv, free_ones = 3 * f.bodies;
    double *N = doubles(n * free_ones), *A = doubles(free_ones * free_ones),
           *y = doubles(free_ones);
    double *MN = doubles(n + OTHER), *column = doubles(n + OTHER), *none = doubles(f.rows + 1);
    double *unused = doubles(f.rows + 1);
    tree_motions(&f, N);
    for (int c = 0; c < free_ones; c++) {
      memset(MN, 0, (size_t)(n + OTHER) * sizeof *MN);
      memcpy(column + OTHER, N + c * n, (size_t)n * sizeof *column);
      family_apply(&f, 1, column, none, MN, unused);
      for (int a = 0; a < free_ones; a++)
        for (int j = 0; j < n; j++) A[c * free_ones + a] += N[a * n + j] * MN[OTHER + j];
      for (int j = 0; j < n; j++) y[c] += N[c * n + j] * w.r[OTHER + j];
    }
    assert_true(largest(unused, f.rows + 1) < 1e-12 * f.bodies); /* J N = 0 */
    assert_int_equal(LAPACKE_dposv(LAPACK_COL_MAJOR, 'L', free_ones, 1, A, free_ones, y, free_ones),
                     0);
    memset(w.c, 0, (size_t)(f.rows + 1) * sizeof *w.c);
    nsdae_sparse_kkt k = {.rank_tol = 1e-8};
    assert_int_equal(factor(&k, &f), NSDAE_OK);
    assert_int_equal(solve(&k, &f, &w), NSDAE_OK);
    double size = largest(w.v, n + OTHER);
    for (int j = 0; j < n; j++) {
      double x = 0;
      for (int a = 0; a < free_ones; a++) x += N[a * n + j] * y[a];
      assert_near(w.v[OTHER + j], x, 1e-9 * size); /* N^T M N has the condition of the chain */
    }
    nsdae_sparse_kkt_release(&k);
    free(N), free(A), free(y), free(MN), free(column), free(none), free(unused);
    release_vectors(&w);
    family_release(&f);
  }
}

/* ---- the one interface */

static void lay_out_kkt(void *object, nsdae_arena *arena)
{
  nsdae_kkt_layout(object, arena);
}

static void begin_kkt(nsdae_kkt *kkt, nsdae_arena *arena, const nsdae_blocks *blocks, int m)
{
  *kkt = (nsdae_kkt){.n = blocks->first[blocks->count], .m = m, .blocks = blocks, .rank_tol = 1e-8};
  assert_int_equal(nsdae_arena_build(arena, lay_out_kkt, kkt), NSDAE_OK);
}

/* The family and its other block, dense: one block and rows of all its velocities. */
typedef struct dense_family {
  int ends[2];
  size_t squares[2];
  nsdae_blocks blocks;
  nsdae_rows J;
  double *M;
} dense_family;

static void make_dense(const joint_family *f, dense_family *d)
{
  int n = f->nv + OTHER, m = f->rows + 1;
  *d = (dense_family){.ends = {0, n}, .squares = {0, (size_t)(n * n)}};
  d->blocks = (nsdae_blocks){1, d->ends, d->squares};
  d->M = doubles(n * n);
  d->J = (nsdae_rows){m, f->J.first, NULL, NULL, (size_t)m, doubles(m * n)};
  d->J.first = calloc((size_t)m + 1, sizeof *d->J.first);
  d->J.block = calloc((size_t)m, sizeof *d->J.block);
  d->J.at = calloc((size_t)m, sizeof *d->J.at);
  for (int b = 0; b < f->blocks.count; b++)
    for (int i = 0, size = nsdae_blocks_size(&f->blocks, b); i < size * size; i++)
      d->M[(f->blocks.first[b] + i / size) * n + f->blocks.first[b] + i % size] =
          f->M[f->blocks.square[b] + (size_t)i];
  for (int i = 0; i < m; i++) {
    d->J.first[i + 1] = i + 1;
    d->J.at[i] = (size_t)i;
    nsdae_rows_gather(&f->blocks, &f->J, i, f->blocks.first, d->J.value + i, (size_t)m);
  }
}

static void release_dense(dense_family *d)
{
  free(d->M), free(d->J.first), free(d->J.block), free(d->J.at), free(d->J.value);
}

/* Several right-hand sides and masses alone by one kkt. */
static void solve_both(nsdae_kkt *kkt, const vectors *w, double *X, double *L, double *z)
{
  size_t n = (size_t)kkt->n, m = (size_t)kkt->m;
  for (size_t k = 0; k < 2; k++) {
    for (size_t i = 0; i < n; i++) X[k * n + i] = w->r[i] / (double)(k + 1);
    for (size_t i = 0; i < m; i++) L[k * m + i] = w->c[i] / (double)(k + 1);
  }
  assert_int_equal(nsdae_kkt_solve(kkt, 2, X, kkt->n, L, kkt->m), NSDAE_OK);
  memcpy(z, w->r, n * sizeof *z);
  nsdae_kkt_solve_mass(kkt, z);
}

/* By blocks, which is sparse if large, and as one block: solutions, the rank, its basis and the
 * factorisation in that. */
static void expect_one_interface(int kind, int bodies, int revolute)
{
  joint_family f;
  dense_family d;
  nsdae_kkt one, many;
  nsdae_arena arena[2];
  family_make(&f, kind, bodies, revolute, 0, 11);
  f.M[0] = f.M[3] = f.J.value[0] = 1; /* the block that is not of the mechanism */
  f.rank++;
  make_dense(&f, &d);
  vectors w = make_vectors(&f);
  int n = f.nv + OTHER, m = f.rows + 1;
  w.r[0] = 1, w.r[1] = 2;
  begin_kkt(&one, &arena[0], &d.blocks, m);
  begin_kkt(&many, &arena[1], &f.blocks, m);
  assert_false(one.is_sparse);
  double *X[2] = {doubles(2 * n), doubles(2 * n)}, *L[2] = {doubles(2 * m), doubles(2 * m)};
  double *z[2] = {doubles(n), doubles(n)}, *basis = doubles((int)nsdae_kkt_basis_size(&many));
  assert_int_equal(nsdae_kkt_factor(&one, d.M, &d.J), NSDAE_OK);
  assert_int_equal(nsdae_kkt_factor(&many, f.M, &f.J), NSDAE_OK);
  assert_int_equal(one.rank, f.rank);
  assert_int_equal(many.rank, f.rank);
  nsdae_kkt_basis(&many, basis);
  assert_near(nsdae_kkt_common(&many, basis), f.rank, 1e-9);
  for (int fixed = 0; fixed < 2; fixed++) {
    if (fixed)
      assert_int_equal(nsdae_kkt_factor_coupled(&many, f.M, NULL, &f.J, basis, f.rank), NSDAE_OK);
    solve_both(&one, &w, X[0], L[0], z[0]);
    solve_both(&many, &w, X[1], L[1], z[1]);
    if (!many.is_sparse && !fixed) { /* the same numbers */
      assert_memory_equal(X[0], X[1], 2 * (size_t)n * sizeof **X);
      assert_memory_equal(L[0], L[1], 2 * (size_t)m * sizeof **L);
    }
    for (int i = 0; i < 2 * n; i++) assert_near(X[1][i], X[0][i], 1e-11 * largest(X[0], n));
    for (int i = 0; i < 2 * m; i++) assert_near(L[1][i], L[0][i], 1e-9 * largest(L[0], m));
    for (int i = 0; i < n; i++) assert_near(z[1][i], z[0][i], 1e-12 * largest(z[0], n));
  }
  for (int i = 0; i < m; i++) L[0][i] = random_number(&f.random);
  memcpy(L[1], L[0], (size_t)m * sizeof **L);
  assert_int_equal(nsdae_kkt_least_norm(&one, &d.J, L[0], z[0]), NSDAE_OK);
  assert_int_equal(nsdae_kkt_least_norm(&many, &f.J, L[1], z[0]), NSDAE_OK);
  for (int i = 0; i < m; i++) assert_near(L[1][i], L[0][i], 1e-9 * largest(L[0], m));
  f.M[f.blocks.square[1] + 7] = -1;
  assert_int_equal(nsdae_kkt_factor(&many, f.M, &f.J), NSDAE_E_MASS);
  assert_int_equal(many.pivot, OTHER + 2);
  for (int k = 0; k < 2; k++) {
    free(X[k]), free(L[k]), free(z[k]);
    nsdae_arena_release(&arena[k]);
  }
  nsdae_kkt_release(&many);
  free(basis);
  release_vectors(&w);
  release_dense(&d);
  family_release(&f);
}

static void test_one_interface(void **state)
{
  (void)state;
  for (int revolute = 0; revolute < 2; revolute++)
    for (int kind = CHAIN; kind <= TREE; kind++)
      for (int bodies = 1; bodies < 40; bodies += 1 + bodies / 3)
        expect_one_interface(kind, bodies, revolute);
  expect_one_interface(NET, 9, 0);
  for (int bodies = 3; bodies <= 30; bodies += 9) expect_one_interface(LADDER, bodies, 1);
  for (int bodies = 4; bodies <= 24; bodies += 5) expect_one_interface(RING, bodies, 1);
}

/* ---- couplings */

/* Dampers along random directions w between the bodies of each joint: A = M + scale sum w w^T, in
 * f->M and in blocks below. */
typedef struct coupled_family {
  int count, *pair;
  double *value;
} coupled_family;

static void add_damper(joint_family *f, coupled_family *c, int a, int b, double scale)
{
  double w[12];
  for (int i = 0; i < 12; i++) w[i] = sqrt(scale) * random_number(&f->random);
  for (int s = 0; s < 2; s++) {
    double *M = f->M + f->blocks.square[(s ? b : a) + 1];
    for (int i = 0; i < 36; i++) M[i] += w[6 * s + i / 6] * w[6 * s + i % 6];
  }
  c->pair[2 * c->count] = a;
  c->pair[2 * c->count + 1] = b;
  for (int i = 0; i < 36; i++) c->value[36 * c->count + i] = w[i % 6] * w[6 + i / 6];
  c->count++;
}

static coupled_family couple(joint_family *f, double scale)
{
  coupled_family c = {0, calloc(2 * (size_t)f->rows, sizeof(int)), doubles(36 * f->rows)};
  for (int i = 1; i <= f->rows; i++) {
    int first = f->J.first[i], a = f->J.block[first] - 1, b, known = 0;
    if (f->J.first[i + 1] - first < 2) continue;
    b = f->J.block[first + 1] - 1;
    if (a < b) {
      int t = a;
      a = b, b = t;
    }
    for (int k = 0; k < c.count; k++) known |= c.pair[2 * k] == a && c.pair[2 * k + 1] == b;
    if (!known) add_damper(f, &c, a, b, scale);
  }
  return c;
}

/* g += scale (A - its diagonal blocks) x: vectors of the whole system. */
static void apply_coupling(const coupled_family *c, double scale, const double *x, double *g)
{
  for (int k = 0; k < 36 * c->count; k++) {
    int i = OTHER + 6 * c->pair[k / 36 * 2] + k % 6;
    int j = OTHER + 6 * c->pair[k / 36 * 2 + 1] + k % 36 / 6;
    g[i] += scale * c->value[k] * x[j];
    g[j] += scale * c->value[k] * x[i];
  }
}

/* The rows that a factorisation without couplings finds independent. */
static void find_basis(nsdae_sparse_kkt *k, const joint_family *f, double *keep)
{
  assert_int_equal(factor(k, f), NSDAE_OK);
  assert_int_equal(k->rank.count, f->rank);
  nsdae_sparse_kkt_kept(k, keep);
}

static void expect_coupled(int kind, int bodies, int revolute, double spread, double scale)
{
  joint_family f;
  family_make(&f, kind, bodies, revolute, spread, 3);
  double *keep = doubles(f.rows), ratio = pow(10, spread);
  double condition = (ratio + 6 * scale) / (0.006 / ratio); /* of A: the least inertia is 0.006 */
  nsdae_sparse_kkt k = {.rank_tol = 1e-8};
  find_basis(&k, &f, keep);
  coupled_family c = couple(&f, scale);
  const nsdae_coupling coupling = {c.count, c.pair, c.value};
  vectors w = make_vectors(&f); /* with M as it is now */
  apply_coupling(&c, 1, w.x, w.r);
  for (int again = 0; again < 2; again++)
    assert_int_equal(nsdae_sparse_kkt_factor_coupled(&k, f.M, &coupling, keep), NSDAE_OK);
  assert_int_equal(k.rank.count, f.rank);
  assert_int_equal(solve(&k, &f, &w), NSDAE_OK);
  double error = error_of_motion(&f, &w);
  apply_coupling(&c, -1, w.v, w.r);
  double backward = backward_error(&f, &w);
  assert_true(backward <= 1e-12);
  assert_true(error <= 10 * DBL_EPSILON * condition);
  for (int i = 0; i < f.rows; i++)
    if (keep[i] == 0) assert_true(w.lambda[i + 1] == 0);
  f.M[f.blocks.square[1]] -= 1e3 * (1 + scale); /* not positive definite */
  assert_int_equal(nsdae_sparse_kkt_factor_coupled(&k, f.M, &coupling, keep), NSDAE_E_MASS);
  nsdae_sparse_kkt_release(&k);
  release_vectors(&w);
  free(c.pair), free(c.value);
  free(keep);
  family_release(&f);
}

/* The same of one block, with the couplings in M. */
static void expect_coupled_as_dense(int kind, int bodies, int revolute)
{
  joint_family f;
  dense_family d;
  nsdae_kkt one, many;
  nsdae_arena arena[2];
  family_make(&f, kind, bodies, revolute, 0, 5);
  f.M[0] = f.M[3] = f.J.value[0] = 1;
  coupled_family c = couple(&f, 10);
  for (int k = 0; k < 2 * c.count; k++) c.pair[k]++; /* in the numbers of the system */
  make_dense(&f, &d);
  vectors w = make_vectors(&f);
  int n = f.nv + OTHER, m = f.rows + 1;
  for (int k = 0; k < 36 * c.count; k++) {
    int i = OTHER + 6 * (c.pair[k / 36 * 2] - 1) + k % 6;
    int j = OTHER + 6 * (c.pair[k / 36 * 2 + 1] - 1) + k % 36 / 6;
    d.M[i * n + j] = d.M[j * n + i] = c.value[k];
  }
  const nsdae_coupling coupling = {c.count, c.pair, c.value};
  begin_kkt(&one, &arena[0], &d.blocks, m);
  begin_kkt(&many, &arena[1], &f.blocks, m);
  double *X[2] = {doubles(2 * n), doubles(2 * n)}, *L[2] = {doubles(2 * m), doubles(2 * m)};
  assert_int_equal(nsdae_kkt_factor(&one, d.M, &d.J), NSDAE_OK);
  assert_int_equal(nsdae_kkt_factor_coupled(&many, f.M, &coupling, &f.J, NULL, m), NSDAE_OK);
  assert_int_equal(many.rank, m);
  for (size_t i = 0; i < (size_t)m; i++) L[0][i] = L[1][i] = w.c[i];
  for (size_t i = 0; i < (size_t)n; i++) X[0][i] = X[1][i] = w.r[i];
  assert_int_equal(nsdae_kkt_solve(&one, 1, X[0], n, L[0], m), NSDAE_OK);
  assert_int_equal(nsdae_kkt_solve(&many, 1, X[1], n, L[1], m), NSDAE_OK);
  for (int i = 0; i < n; i++) assert_near(X[1][i], X[0][i], 1e-10 * largest(X[0], n));
  for (int i = 0; i < m; i++) assert_near(L[1][i], L[0][i], 1e-8 * largest(L[0], m));
  for (int k = 0; k < 2; k++) {
    free(X[k]), free(L[k]);
    nsdae_arena_release(&arena[k]);
  }
  nsdae_kkt_release(&many);
  free(c.pair), free(c.value);
  release_vectors(&w);
  release_dense(&d);
  family_release(&f);
}

static void test_couplings(void **state)
{
  (void)state;
  for (int revolute = 0; revolute < 2; revolute++)
    for (int bodies = 2; bodies < 30; bodies += 1 + bodies / 3) {
      expect_coupled_as_dense(CHAIN, bodies, revolute);
      expect_coupled_as_dense(TREE, bodies, revolute);
    }
  const double spreads[] = {0, 0, 3}, scales[] = {0.1, 1e4, 0.1};
  for (int s = 0; s < 3; s++)
    for (int revolute = 0; revolute < 2; revolute++)
      for (int bodies = 2; bodies <= 200; bodies *= 10) {
        expect_coupled(CHAIN, bodies, revolute, spreads[s], scales[s]);
        expect_coupled(TREE, bodies, revolute, spreads[s], scales[s]);
        expect_coupled(LADDER, 3 * bodies, 1, spreads[s], scales[s]);
        expect_coupled(NET, bodies > 20 ? 100 : 16, 0, spreads[s], scales[s]);
      }
}

/* A ladder with one equation of a redundant row wrong by a part of 1e-3; NaN; a mass that is not
 * positive. */
static void test_refusals(void **state)
{
  (void)state;
  joint_family f;
  family_make(&f, LADDER, 99, 1, 0, 9);
  vectors w = make_vectors(&f);
  nsdae_sparse_kkt k = {.rank_tol = 1e-8};
  assert_int_equal(factor(&k, &f), NSDAE_OK);
  assert_true(k.rank.dependent > 0 && k.rank.dependent <= f.rows);
  w.c[k.rank.dependent] += 1e-3;
  assert_int_equal(solve(&k, &f, &w), NSDAE_E_CONVERGENCE);
  w.c[k.rank.dependent] = NAN;
  assert_int_equal(solve(&k, &f, &w), NSDAE_E_CONVERGENCE);
  w.r[OTHER + 5] = NAN;
  assert_int_equal(solve(&k, &f, &w), NSDAE_E_CONVERGENCE);
  f.J.value[f.J.at[20]] = NAN;
  assert_int_equal(factor(&k, &f), NSDAE_E_NONFINITE);
  f.M[f.blocks.square[17] + 7] = -1;
  assert_int_equal(factor(&k, &f), NSDAE_E_MASS);
  assert_int_equal(k.bad_block, 17);
  assert_int_equal(k.pivot, 2);
  nsdae_sparse_kkt_release(&k);
  release_vectors(&w);
  family_release(&f);
}

/* A further row at a small angle to those of a joint counts by rank_tol; with a sine below 1e-6 it
 * never does. */
static void test_near_dependent(void **state)
{
  (void)state;
  const double sines[] = {1e-3, 1e-5, 1e-9}, tols[] = {1e-2, 1e-4, 1e-8};
  for (int s = 0; s < 3; s++)
    for (int t = 0; t < 3; t++) {
      joint_family f;
      family_make(&f, CHAIN, 50, 0, 0, 13);
      int joint = f.J.first[3 * 20 + 1]; /* body 20 and its parent, as its first row */
      double value[12];
      memcpy(value, f.J.value + f.J.at[joint + 1], 6 * sizeof *value);
      memcpy(value + 6, f.J.value + f.J.at[joint], 6 * sizeof *value);
      value[1] += 2 * sines[s]; /* along the second row of the parent alone: independent */
      family_row(&f, f.J.block[joint + 1] - 1, f.J.block[joint] - 1, value);
      f.row[f.rows++] = f.J.count - 1;
      nsdae_sparse_kkt k = {.rank_tol = tols[t]};
      assert_int_equal(factor(&k, &f), NSDAE_OK);
      int counts = sines[s] > tols[t] && sines[s] > 1e-6;
      assert_int_equal(k.rank.count, f.rows - !counts);
      double sine = counts ? k.rank.kept : k.rank.left; /* of the row, up to its length */
      assert_true(sine > 0.1 * sines[s] && sine < 10 * sines[s]);
      nsdae_sparse_kkt_release(&k);
      family_release(&f);
    }
}

/* A row of zeros, and one of a length of 1e-200, whose square is zero in double precision: neither
 * counts, and the solution is the wanted one. */
static void test_zero_row(void **state)
{
  (void)state;
  for (int tiny = 0; tiny < 2; tiny++) {
    joint_family f;
    family_make(&f, CHAIN, 40, 0, 0, 21);
    const double value[12] = {0, 1e-200 * tiny};
    family_row(&f, 20, 19, value);
    f.row[f.rows++] = f.J.count - 1;
    vectors w = make_vectors(&f);
    nsdae_sparse_kkt k = {.rank_tol = 1e-8};
    assert_int_equal(factor(&k, &f), NSDAE_OK);
    assert_int_equal(k.rank.count, f.rows - 1);
    assert_int_equal(k.rank.dependent, f.J.count - 1);
    assert_int_equal(solve(&k, &f, &w), NSDAE_OK);
    for (int j = OTHER; j < f.nv + OTHER; j++) assert_near(w.v[j], w.x[j], 1e-9);
    nsdae_sparse_kkt_release(&k);
    release_vectors(&w);
    family_release(&f);
  }
}

/* No allocation after the analysis; one that fails for lack of memory leaks none. */
static void test_memory(void **state)
{
  (void)state;
  joint_family f;
  family_make(&f, LADDER, 99, 1, 0, 21);
  vectors w = make_vectors(&f);
  nsdae_sparse_kkt k = {.rank_tol = 1e-8};
  int status = NSDAE_E_MEMORY;
  for (long lost = 0; status != NSDAE_OK; lost++) {
    allocator_reset(lost);
    status = factor(&k, &f);
    if (status != NSDAE_OK) assert_int_equal(status, NSDAE_E_MEMORY);
    if (status == NSDAE_OK) break;
    nsdae_sparse_kkt_release(&k);
    k = (nsdae_sparse_kkt){.rank_tol = 1e-8};
    assert_int_equal(the_allocator.live, 0);
  }
  for (int round = 0; round < 3; round++) {
    allocator_reset(-1);
    for (int i = 0; i < 36; i++) f.M[f.blocks.square[5] + (size_t)i] *= 2;
    assert_int_equal(factor(&k, &f), NSDAE_OK);
    assert_int_equal(k.rank.count, f.rank);
    assert_int_equal(solve(&k, &f, &w), NSDAE_OK);
    assert_int_equal(the_allocator.calls, 0);
    assert_true(backward_error(&f, &w) <= 1e-12);
  }
  nsdae_sparse_kkt_release(&k);
  release_vectors(&w);
  family_release(&f);
}

/* One struct for mechanisms in turn. */
static void test_patterns_in_turn(void **state)
{
  (void)state;
  const int kinds[] = {CHAIN, RING, TREE, LADDER, CHAIN}, bodies[] = {50, 8, 100, 30, 40};
  nsdae_sparse_kkt k = {.rank_tol = 1e-8};
  for (int i = 0; i < 10; i++) {
    joint_family f;
    family_make(&f, kinds[i % 5], bodies[i % 5], 1, 0, (uint64_t)i);
    vectors w = make_vectors(&f);
    assert_int_equal(factor(&k, &f), NSDAE_OK);
    assert_int_equal(k.rank.count, f.rank);
    assert_int_equal(solve(&k, &f, &w), NSDAE_OK);
    assert_true(error_of_motion(&f, &w) <= 1e-12);
    release_vectors(&w);
    family_release(&f);
  }
  nsdae_sparse_kkt_release(&k);
}

int main(void)
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(test_families),
      cmocka_unit_test(test_loops),
      cmocka_unit_test(test_contradiction),
      cmocka_unit_test(test_against_dgelsd),
      cmocka_unit_test(test_minimal_coordinates),
      cmocka_unit_test(test_one_interface),
      cmocka_unit_test(test_couplings),
      cmocka_unit_test(test_refusals),
      cmocka_unit_test(test_near_dependent),
      cmocka_unit_test(test_zero_row),
      cmocka_unit_test(test_memory),
      cmocka_unit_test(test_patterns_in_turn),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
