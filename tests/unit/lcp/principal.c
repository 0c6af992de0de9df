/* Principal pivoting: by hand, Murty's exponential family, P-matrices, and matrices that are none.
 */
#include "problems.h"

static int pivoting(const problem *p, int block, int max_pivots, double *x, int *basis, int *pivots,
                    double *residual)
{
  double work[MOST * (MOST + 2)];
  int iwork[2 * MOST];
  return nsdae_dlcpppm(p->n, p->A, p->n, p->b, tight, block, max_pivots, x, basis, pivots, residual,
                       work, MOST * (MOST + 2), iwork);
}

/* Every basis of a P-matrix that is not symmetric, from every start. */
static void test_by_hand(void **state)
{
  (void)state;
  problem p = {.n = 2, .A = {2, -1, 3, 1}}; /* minors 2, 1, 5 */
  const double bs[4][2] = {{1, 2}, {-4, 3}, {1, -2}, {-8, -1}};
  const double xs[4][2] = {{0, 0}, {2, 0}, {0, 2}, {1, 2}};
  for (int k = 0; k < 32; k++) {
    double x[2], residual;
    int basis[2] = {k >> 2 & 1, k >> 3 & 1}, pivots;
    memcpy(p.b, bs[k % 4], sizeof p.b[0] * 2);
    memcpy(p.x, xs[k % 4], sizeof p.x[0] * 2);
    assert_int_equal(pivoting(&p, k / 16 * 10, 10, x, basis, &pivots, &residual), 0);
    expect_solution(&p, x, residual);
    for (int i = 0; i < 2; i++) assert_int_equal(basis[i], p.x[i] > 0);
    assert_int_equal(pivoting(&p, 10, 0, x, basis, &pivots, &residual), 0);
    assert_int_equal(pivots, 0); /* begun at its own basis */
  }
}

/* Murty, Math. Prog. Study 7 (1978) 138: A is triangular with ones on its diagonal and twos on one
 * side, b = -1; the least-index method takes 2^n - 1 pivots. */
static void murty(int n, problem *p)
{
  p->n = n;
  for (int j = 0; j < n; j++) {
    for (int i = 0; i < n; i++) p->A[j * n + i] = i == j ? 1 : i < j ? 2 : 0;
    p->b[j] = -1;
    p->x[j] = j == n - 1;
  }
}

static void test_exponential(void **state)
{
  (void)state;
  for (int n = 1; n <= 12; n++) {
    problem p;
    double x[MOST], residual;
    int basis[MOST] = {0}, pivots;
    murty(n, &p);
    assert_int_equal(pivoting(&p, 0, 1 << n, x, basis, &pivots, &residual), 0);
    assert_int_equal(pivots, (1 << n) - 1);
    expect_solution(&p, x, residual);
    memset(basis, 0, sizeof basis);
    assert_int_equal(pivoting(&p, 0, (1 << n) - 2, x, basis, &pivots, &residual), 2);
    assert_int_equal(pivots, (1 << n) - 2);
  }
}

static void expect_solved(const problem *p, int block, random_state *r)
{
  double x[MOST], residual;
  int basis[MOST], pivots;
  for (int i = 0; i < p->n; i++) basis[i] = random_int(r, 0, 1);
  assert_int_equal(pivoting(p, block, 1000000, x, basis, &pivots, &residual), 0);
  expect_solution(p, x, residual);
  expect_lemke(p, x);
}

/* Two of three with zeros in x and y alike: ties that must not cycle. */
static void test_p_matrices(void **state)
{
  (void)state;
  random_state r = {2};
  for (int k = 0; k < 300; k++) {
    problem p;
    int n = random_int(&r, 1, MOST);
    if (k % 3 < 2)
      make_definite(&r, n, k % 3 * 2.0, &p);
    else
      make_dominant(&r, n, &p);
    choose_solution(&r, &p);
    expect_solved(&p, 10, &r);
    if (n <= 16) expect_solved(&p, 0, &r);
  }
}

static void test_no_p_matrix(void **state)
{
  (void)state;
  const problem minus = {.n = 1, .A = {-1}, .b = {-1}}, zero = {.n = 1, .A = {0}, .b = {-1}},
                skew = {.n = 2, .A = {0, 1, -1, 0}, .b = {-1, -1}};
  double x[2], residual;
  int basis[2] = {0}, pivots;
  for (int block = 0; block <= 10; block += 10) {
    assert_int_equal(pivoting(&minus, block, 1000, x, basis, &pivots, &residual), 2);
    assert_int_equal(pivots, 1000);
    basis[0] = basis[1] = 0;
    assert_int_equal(pivoting(&zero, block, 1000, x, basis, &pivots, &residual), 1);
    basis[0] = basis[1] = 0;
    assert_true(pivoting(&skew, block, 1000, x, basis, &pivots, &residual) > 0);
    basis[0] = basis[1] = 0;
  }
}

int main(void)
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(test_by_hand),
      cmocka_unit_test(test_exponential),
      cmocka_unit_test(test_p_matrices),
      cmocka_unit_test(test_no_p_matrix),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
