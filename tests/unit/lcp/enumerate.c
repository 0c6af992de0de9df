/* Enumeration: numbers of solutions that theory gives, and proofs that there is none. */
#include "problems.h"

enum { LARGEST = 20 };

static int enumerate(const problem *p, int *set, double *x, double *residual)
{
  double work[LARGEST * (LARGEST + 2)];
  int iwork[3 * LARGEST];
  return nsdae_dlcpenum(p->n, p->A, p->n, p->b, tight, set, x, residual, work,
                        LARGEST * (LARGEST + 2), iwork);
}

/* Number of active sets that give a solution; each is one. */
static int count(const problem *p, int end)
{
  int solutions = 0, info = 0;
  for (int set = 0; set < 1 << p->n; set++) {
    double x[LARGEST], y[LARGEST], work[LARGEST], residual, fresh;
    info = enumerate(p, &set, x, &residual);
    assert_int_equal(info == 0, residual <= tight);
    if (info != 0) continue;
    nsdae_dlcpres(p->n, p->A, p->n, p->b, x, y, &fresh, work);
    assert_true(fresh == residual);
    solutions++;
  }
  if (info != 0) assert_int_equal(info, end);
  return solutions;
}

/* A = -I, b = 1: x_i is 0 or 1, each for itself. */
static void test_all_sets(void **state)
{
  (void)state;
  for (int n = 1; n <= 12; n++) {
    problem p = {.n = n};
    for (int i = 0; i < n; i++) p.A[i * n + i] = -(p.b[i] = 1);
    assert_int_equal(count(&p, 1), 1 << n);
    p.b[n / 2] = -1; /* -x_i - 1 >= 0: none */
    assert_int_equal(count(&p, 1), 0);
  }
}

/* x = (1, 0), (0, 1) and (1/3, 1/3). */
static void test_by_hand(void **state)
{
  (void)state;
  const problem p = {.n = 2, .A = {1, 2, 2, 1}, .b = {-1, -1}};
  const double xs[3][2] = {{1, 0}, {0, 1}, {1.0 / 3, 1.0 / 3}};
  for (int set = 0; set < 3;) {
    double x[2], residual;
    assert_int_equal(enumerate(&p, &set, x, &residual), 0);
    for (int i = 0; i < 2; i++) assert_near(x[i], xs[set - 1][i], 1e-15);
    set++;
  }
  assert_int_equal(count(&p, 1), 3);
}

/* Samelson, Thrall and Wesler (1958): a P-matrix has one solution for every b. */
static void test_p_matrices(void **state)
{
  (void)state;
  random_state r = {3};
  for (int k = 0; k < 60; k++) {
    problem p;
    int set = 0, n = random_int(&r, 1, 9);
    double x[LARGEST], residual;
    make_dominant(&r, n, &p);
    for (int i = 0; i < n; i++) p.b[i] = random_number(&r);
    assert_int_equal(count(&p, 1), 1);
    choose_solution(&r, &p);
    assert_int_equal(enumerate(&p, &set, x, &residual), 0);
    expect_solution(&p, x, residual);
  }
}

/* Entries at random: what Lemke solves has a solution, and where there is none it finds none. */
static void test_lemke(void **state)
{
  (void)state;
  random_state r = {4};
  int solved = 0, none = 0;
  for (int k = 0; k < 2000; k++) {
    problem p = {.n = random_int(&r, 1, 6)};
    double x[LARGEST], residual, work[64];
    int set = 0, basis[8], pivots, iwork[16];
    random_matrix(&r, p.n, p.n, p.A, p.n);
    random_matrix(&r, p.n, 1, p.b, p.n);
    int info = enumerate(&p, &set, x, &residual);
    assert_true(info == 0 || info == 1);
    int lemke = nsdae_dlemke(p.n, p.A, p.n, p.b, NULL, 1000, x, basis, &pivots, work, 64, iwork);
    if (lemke == 0) assert_int_equal(info, 0);
    solved += info == 0;
    none += info == 1;
  }
  assert_true(solved > 500 && none > 500); /* both were seen */
}

/* A_FF singular for F = {1}, {2} and {1, 2}, and yet x = (1, 0) is a solution: no proof. */
static void test_singular(void **state)
{
  (void)state;
  const problem p = {.n = 2, .A = {0, 1, 0, 0}, .b = {0, -1}};
  assert_int_equal(count(&p, 2), 0);
  /* dependent rows, of which one is enough */
  const problem repeated = {.n = 2, .A = {1, 1, 1, 1}, .b = {-1, -1}};
  assert_int_equal(count(&repeated, 2), 2);
}

static void test_largest(void **state)
{
  (void)state;
  problem p = {.n = LARGEST};
  double x[LARGEST], residual;
  int set = 0;
  for (int i = 0; i < LARGEST; i++) {
    p.A[i * LARGEST + i] = 1;
    p.b[i] = i % 2 ? -1 : 1;
  }
  assert_int_equal(enumerate(&p, &set, x, &residual), 0);
  assert_int_equal(set, 0xaaaaa);
  for (int i = 0; i < LARGEST; i++) assert_true(x[i] == i % 2);
}

int main(void)
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(test_all_sets),   cmocka_unit_test(test_by_hand),
      cmocka_unit_test(test_p_matrices), cmocka_unit_test(test_lemke),
      cmocka_unit_test(test_singular),   cmocka_unit_test(test_largest),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
