/* Sparse factors: their solutions satisfy the equations to rounding, also when a matrix changes in
 * its pattern, so that the old pivots are lost, or becomes singular and regular again; and a
 * pattern that AMD's order keeps sparse stays so. */
#include "check.h"

#include <float.h>
#include <stdlib.h>

#include "support/random.h"
#include "sparse_lu.h"

enum { N = 60 };

typedef struct owned {
  nsdae_sparse_lu lu;
  nsdae_arena arena;
} owned;

static void layout(void *object, nsdae_arena *arena)
{
  nsdae_sparse_lu_layout(object, arena);
}

static void make(owned *o, int n)
{
  *o = (owned){.lu.n = n};
  assert_int_equal(nsdae_arena_build(&o->arena, layout, &o->lu), 0);
}

/* The backward error of threshold pivoting: eps times the growth of the factors, which a pivot of
 * at least 1e-3 of its column bounds by 1e3 a column and random matrices leave far below. */
static void expect_solves(owned *o, random_state *r, const double *A)
{
  int n = o->lu.n;
  double b[N], x[N], most = 0, size = 0;
  for (int i = 0; i < n; i++) x[i] = b[i] = random_number(r);
  nsdae_sparse_lu_solve(&o->lu, x);
  for (int i = 0; i < n; i++) {
    double off = -b[i], sum = fabs(b[i]);
    for (int j = 0; j < n; j++) {
      off += A[j * n + i] * x[j];
      sum += fabs(A[j * n + i] * x[j]);
    }
    most = fmax(most, fabs(off));
    size = fmax(size, sum);
  }
  assert_at_most(most, 1e4 * n * DBL_EPSILON * size);
}

/* Entries with that chance, and values over some decades; its diagonal is there in half of the rows
 * and a random permutation is: regular with probability 1. */
static void draw(random_state *r, int n, double fill, double *A)
{
  int permutation[N];
  for (int i = 0; i < n; i++) permutation[i] = i;
  for (int i = n - 1; i > 0; i--) {
    int j = random_int(r, 0, i), kept = permutation[i];
    permutation[i] = permutation[j];
    permutation[j] = kept;
  }
  for (int j = 0; j < n; j++)
    for (int i = 0; i < n; i++) {
      int there = fabs(random_number(r)) < fill || permutation[j] == i || (i == j && i % 2);
      A[j * n + i] = there ? random_number(r) * pow(10, 2 * random_number(r)) : 0;
    }
}

static void change_values(random_state *r, int n, double *A)
{
  for (int i = 0; i < n * n; i++)
    if (A[i] != 0) A[i] = random_number(r) * pow(10, 2 * random_number(r));
}

static void test_random(void **state)
{
  (void)state;
  random_state r = {1};
  static double A[N * N];
  owned o;
  for (int run = 0; run < 300; run++) {
    int n = random_int(&r, 1, N);
    draw(&r, n, run % 3 == 0 ? 1.5 / n : run % 3 == 1 ? 0.2 : 1, A);
    make(&o, n);
    for (int again = 0; again < 4; again++) {
      assert_int_equal(nsdae_sparse_lu_factor(&o.lu, A, n), 0);
      expect_solves(&o, &r, A);
      change_values(&r, n, A);
    }
    nsdae_arena_release(&o.arena);
  }
}

/* [0 1; 1 0] has no pivot on its diagonal, then diag(1, 1) none off it; the zero matrix none at
 * all, and what is no number none either. */
static void test_pivots_lost(void **state)
{
  (void)state;
  random_state r = {2};
  const double swap[] = {0, 1, 1, 0}, one[] = {1, 0, 0, 1}, zero[4] = {0};
  const double nothing[] = {1, NAN, 1, 1}, same[] = {1, 1, 1, 1};
  owned o;
  make(&o, 2);
  for (int again = 0; again < 2; again++) {
    assert_int_equal(nsdae_sparse_lu_factor(&o.lu, swap, 2), 0);
    expect_solves(&o, &r, swap);
    assert_int_equal(nsdae_sparse_lu_factor(&o.lu, one, 2), 0);
    expect_solves(&o, &r, one);
    assert_int_equal(nsdae_sparse_lu_factor(&o.lu, zero, 2), 1);
    assert_int_equal(nsdae_sparse_lu_factor(&o.lu, same, 2), 2);
    assert_true(nsdae_sparse_lu_factor(&o.lu, nothing, 2) > 0);
  }
  nsdae_arena_release(&o.arena);
}

/* An arrow: in its own order the factors of [d b'; b D] are full, in AMD's they have the pattern
 * of the matrix. */
static void test_order(void **state)
{
  (void)state;
  random_state r = {3};
  static double A[N * N];
  owned o;
  for (int i = 0; i < N; i++) {
    A[i * N + i] = 4 + random_number(&r);
    if (i > 0) A[i] = A[i * N] = 0.1 * random_number(&r);
  }
  make(&o, N);
  assert_int_equal(nsdae_sparse_lu_factor(&o.lu, A, N), 0);
  expect_solves(&o, &r, A);
  assert_int_equal(o.lu.L.first[N] + o.lu.U.first[N], 3 * N - 2);
  nsdae_arena_release(&o.arena);
}

static void test_size(void **state)
{
  (void)state;
  owned o = {.lu.n = 50000}; /* AMD counts its entries in int */
  assert_true(nsdae_arena_build(&o.arena, layout, &o.lu) < 0);
}

int main(void)
{
  const struct CMUnitTest tests[] = {cmocka_unit_test(test_random),
                                     cmocka_unit_test(test_pivots_lost),
                                     cmocka_unit_test(test_order), cmocka_unit_test(test_size)};
  return cmocka_run_group_tests(tests, NULL, NULL);
}
