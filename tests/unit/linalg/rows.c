/* Blocks, rows by blocks and the sparse saddle-point equations against dense arithmetic on random
 * partitions. */
#include "check.h"

#include <nsdae/status.h>
#include <stdlib.h>

#include "rows.h"
#include "dense.h"
#include "kkt.h"
#include "support/random.h"
#include "sparse_kkt.h"

enum { BLOCKS = 12, MOST = 7, N = BLOCKS * MOST, ROWS = 14, PARTS = 3 };

typedef struct sample {
  random_state random;
  int n;
  int first[BLOCKS + 1], begin[ROWS + 1], block[ROWS * PARTS];
  size_t square[BLOCKS + 1], at[ROWS * PARTS];
  double M[N * MOST], value[ROWS * PARTS * MOST];
  double dense_M[N * N], dense_J[ROWS * N];
  nsdae_blocks blocks;
  nsdae_rows rows;
} sample;

static sample s; /* large */

static void draw_blocks(void)
{
  s.blocks = (nsdae_blocks){random_int(&s.random, 1, BLOCKS), s.first, s.square};
  s.first[0] = 0;
  s.square[0] = 0;
  memset(s.dense_M, 0, sizeof s.dense_M);
  for (int b = 0; b < s.blocks.count; b++) {
    int n = random_int(&s.random, 1, MOST);
    s.first[b + 1] = s.first[b] + n;
    s.square[b + 1] = s.square[b] + (size_t)(n * n);
  }
  s.n = s.first[s.blocks.count];
  for (int b = 0; b < s.blocks.count; b++) {
    int n = nsdae_blocks_size(&s.blocks, b), at = s.first[b], diagonal = b % 2;
    double *M = s.M + s.square[b];
    for (int j = 0; j < n; j++)
      for (int i = 0; i <= j; i++) {
        double entry = i == j ? 2 + random_number(&s.random) : 0.1 * random_number(&s.random);
        if (diagonal && i != j) entry = 0;
        M[j * n + i] = M[i * n + j] = entry;
        s.dense_M[(at + j) * s.n + at + i] = s.dense_M[(at + i) * s.n + at + j] = entry;
      }
  }
}

/* Each row touches one to three blocks, with a stride as dense arrays have it. */
static void draw_rows(int count)
{
  int parts = 0;
  size_t end = 0;
  memset(s.dense_J, 0, sizeof s.dense_J);
  s.begin[0] = 0;
  for (int i = 0; i < count; i++) {
    int touched = random_int(&s.random, 1, PARTS), from = random_int(&s.random, 0, BLOCKS);
    for (int p = 0; p < touched && p < s.blocks.count; p++) {
      int b = (from + p) % s.blocks.count;
      s.block[parts] = b;
      s.at[parts++] = end;
      for (int j = 0; j < nsdae_blocks_size(&s.blocks, b); j++) {
        s.value[end] = random_number(&s.random);
        s.dense_J[(s.first[b] + j) * count + i] = s.value[end++];
      }
    }
    s.begin[i + 1] = parts;
  }
  s.rows = (nsdae_rows){count, s.begin, s.block, s.at, 1, s.value};
}

static void random_vector(double *x, int n)
{
  for (int i = 0; i < n; i++) x[i] = random_number(&s.random);
}

/* M less zero, of two halves of x; M less itself. */
static void expect_change(const double *x, double square)
{
  static const double nothing[N * N];
  double half[N];
  for (int i = 0; i < s.n; i++) half[i] = x[i] / 2;
  assert_near(nsdae_blocks_change(&s.blocks, s.M, nothing, half, half), square, 1e-12);
  assert_near(nsdae_blocks_change(&s.blocks, s.M, s.M, half, x), 0, 0);
}

static void test_products(void **state)
{
  (void)state;
  for (int round = 0; round < 200; round++) {
    double x[N], y[N] = {0}, expected[N] = {0}, l[ROWS], J[ROWS];
    draw_blocks();
    draw_rows(random_int(&s.random, 0, ROWS));
    int n = s.n, m = s.rows.count;
    random_vector(x, n);
    random_vector(l, m);
    nsdae_blocks_add_product(&s.blocks, s.M, x, y);
    double square = 0;
    for (int i = 0; i < n; i++) {
      for (int j = 0; j < n; j++) expected[i] += s.dense_M[j * n + i] * x[j];
      assert_near(y[i], expected[i], 1e-13);
      square += x[i] * expected[i];
    }
    assert_near(nsdae_blocks_square(&s.blocks, s.M, x), square, 1e-12);
    expect_change(x, square);
    for (int i = 0; i < m; i++) J[i] = nsdae_rows_dot(&s.blocks, &s.rows, i, x);
    for (int i = 0; i < m; i++) {
      double sum = 0, largest = 0, total = 0;
      for (int j = 0; j < n; j++) {
        sum += s.dense_J[j * m + i] * x[j];
        largest = fmax(largest, fabs(s.dense_J[j * m + i]));
        total += fabs(s.dense_J[j * m + i]);
      }
      assert_near(J[i], sum, 1e-13);
      assert_near(nsdae_rows_largest(&s.blocks, &s.rows, i), largest, 0);
      assert_near(nsdae_rows_sum(&s.blocks, &s.rows, i), total, 1e-13);
    }
    memcpy(expected, y, sizeof y);
    for (int i = 0; i < m; i++) nsdae_rows_add(&s.blocks, &s.rows, i, -0.5 * l[i], y);
    for (int j = 0; j < n; j++) {
      for (int i = 0; i < m; i++) expected[j] -= 0.5 * s.dense_J[j * m + i] * l[i];
      assert_near(y[j], expected[j], 1e-13);
    }
  }
}

static void test_blocks_solve(void **state)
{
  (void)state;
  for (int round = 0; round < 200; round++) {
    double x[N], y[N] = {0}, L[MOST * MOST];
    draw_blocks();
    random_vector(x, s.n);
    nsdae_blocks_add_product(&s.blocks, s.M, x, y);
    for (int b = 0; b < s.blocks.count; b++) {
      nsdae_block_factor factor = {.L = L};
      assert_int_equal(nsdae_blocks_factor(&s.blocks, b, s.M, &factor), 0);
      nsdae_blocks_solve(&factor, y + s.first[b]);
    }
    for (int j = 0; j < s.n; j++) assert_near(y[j], x[j], 1e-13);
    double *bad = s.M + s.square[s.blocks.count - 1];
    nsdae_block_factor factor = {.L = L};
    *bad = -1;
    assert_int_equal(nsdae_blocks_factor(&s.blocks, s.blocks.count - 1, s.M, &factor), 1);
    *bad = NAN;
    assert_int_equal(nsdae_blocks_factor(&s.blocks, s.blocks.count - 1, s.M, &factor), 1);
  }
}

static void layout(void *object, nsdae_arena *arena)
{
  nsdae_kkt_layout(object, arena);
}

/* x and l of the whole against the dense factorisation, which also knows redundant rows. */
static void test_sparse_kkt(void **state)
{
  (void)state;
  nsdae_sparse_kkt sparse = {.rank_tol = 1e-8};
  int solved = 0;
  for (int round = 0; round < 300; round++) {
    double r[N], v[N], l[ROWS], x[N], k[ROWS];
    int all_blocks[BLOCKS], all_rows[ROWS];
    draw_blocks();
    draw_rows(random_int(&s.random, 1, 5));
    if (s.n < 2 * s.rows.count) continue;
    nsdae_kkt kkt = {.n = s.n, .m = s.rows.count, .blocks = &s.blocks, .rank_tol = 1e-8};
    nsdae_arena arena;
    assert_int_equal(nsdae_arena_build(&arena, layout, &kkt), NSDAE_OK);
    random_vector(r, s.n);
    random_vector(l, s.rows.count);
    memcpy(x, r, sizeof x);
    memcpy(k, l, sizeof k);
    assert_int_equal(nsdae_kkt_factor(&kkt, s.M, &s.rows), NSDAE_OK);
    assert_int_equal(nsdae_kkt_solve(&kkt, 1, x, s.n, k, s.rows.count), NSDAE_OK);
    for (int b = 0; b < s.blocks.count; b++) all_blocks[b] = b;
    for (int i = 0; i < s.rows.count; i++) all_rows[i] = i;
    if (kkt.rank == s.rows.count) {
      const nsdae_kkt_part part = {&s.blocks,    &s.rows,    s.blocks.count,
                                   s.rows.count, all_blocks, all_rows};
      assert_int_equal(nsdae_sparse_kkt_analyse(&sparse, &part), NSDAE_OK);
      assert_int_equal(nsdae_sparse_kkt_factor(&sparse, s.M), NSDAE_OK);
      assert_int_equal(sparse.rank.count, s.rows.count);
      assert_int_equal(nsdae_sparse_kkt_solve(&sparse, r, v, l), NSDAE_OK);
      double size = 1;
      for (int i = 0; i < s.rows.count; i++) size = fmax(size, fabs(k[i]));
      for (int j = 0; j < s.n; j++) assert_near(v[j], x[j], 1e-11 * size);
      for (int i = 0; i < s.rows.count; i++) assert_near(l[i], k[i], 1e-10 * size * size);
      solved++;
      *(solved % 2 ? r : l) = NAN; /* in the forces, in the constraints */
      assert_int_equal(nsdae_sparse_kkt_solve(&sparse, r, v, l), NSDAE_E_CONVERGENCE);
    }
    nsdae_arena_release(&arena);
  }
  nsdae_sparse_kkt_release(&sparse);
  assert_true(solved > 150);
}

int main(void)
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(test_products),
      cmocka_unit_test(test_blocks_solve),
      cmocka_unit_test(test_sparse_kkt),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
