/* Contact laws as rows: the identities in the comment of law.h. */
#include "law.h"
#include "check.h"

#include <nsdae/sim.h>

enum { LD = NSDAE_LAW_ROWS + 3 };

/* A few roundings of values of order one. */
static const double rounding = 1e-14;

static double edge[2 * NSDAE_POLYGON_MAX];

/* y = E_P^T xi + N x, impulses = E_Q x. */
static void apply(const nsdae_law *law, const double *x, const double *xi, double *y,
                  double *impulse)
{
  static double N[LD * LD];
  memset(N, 0, sizeof N);
  nsdae_law_add_coupling(law, N, LD);
  nsdae_law_velocity(law, xi, y);
  for (int i = 0; i < law->rows; i++) {
    for (int j = 0; j < law->rows; j++) y[i] += N[j * LD + i] * x[j];
  }
  nsdae_law_impulse(law, x, impulse);
  for (int j = 0; j < LD; j++) /* nothing outside the block */
    for (int i = 0; i < LD; i++)
      if (i >= law->rows || j >= law->rows) assert_true(N[j * LD + i] == 0);
}

static void test_kinds(void **state)
{
  (void)state;
  assert_int_equal(nsdae_law_make(0, 0.5, 8, edge).kind, NSDAE_FRICTIONLESS);
  assert_int_equal(nsdae_law_make(1, 0, 8, edge).kind, NSDAE_FRICTIONLESS);
  assert_int_equal(nsdae_law_make(2, 0, 8, edge).kind, NSDAE_FRICTIONLESS);
  assert_int_equal(nsdae_law_make(1, 0.5, 8, edge).kind, NSDAE_PLANAR);
  assert_int_equal(nsdae_law_make(2, 0.5, 8, edge).kind, NSDAE_POLYGON);
  nsdae_law law = nsdae_law_make(0, 0, 8, edge);
  assert_true(law.rows == 1 && law.columns == 1);
  law = nsdae_law_make(1, 0.5, 8, edge);
  assert_true(law.rows == 3 && law.columns == 2 && law.mu == 0.5);
  for (int p = 3; p <= NSDAE_POLYGON_MAX; p++) {
    law = nsdae_law_make(2, 0.5, p, edge);
    assert_true(law.rows == p + 2 && law.columns == 3 && law.mu == 0.5);
  }
}

static void test_frictionless(void **state)
{
  (void)state;
  const nsdae_law law = nsdae_law_make(0, 0, 8, edge);
  double x = 3, xi = -2, y, impulse;
  apply(&law, &x, &xi, &y, &impulse);
  assert_true(y == -2 && impulse == 3);
}

static void test_planar(void **state)
{
  (void)state;
  const double mu = 0.3;
  const nsdae_law law = nsdae_law_make(1, mu, 8, edge);
  for (int i = 0; i < 50; i++) {
    double normal = 1 + sin(i), tangential = mu * normal * sin(3.0 * i); /* in the cone */
    double xi[2] = {cos(2.0 * i), 2 * cos(5.0 * i)}, xi_L = fmax(0, -xi[1]);
    double x[3] = {normal, tangential + mu * normal, xi_L}, y[3], impulse[2];
    apply(&law, x, xi, y, impulse);
    assert_near(impulse[0], normal, 0);
    assert_near(impulse[1], tangential, rounding);
    assert_near(y[0], xi[0], 0);
    assert_near(y[1], fmax(0, xi[1]), rounding);           /* xi_R */
    assert_near(y[2], mu * normal - tangential, rounding); /* Lambda_L */
    assert_true(x[1] >= -rounding && y[2] >= -rounding);   /* in the cone: both there */
  }
}

static void test_polygon(void **state)
{
  (void)state;
  const double mu = 0.3;
  for (int p = 3; p <= NSDAE_POLYGON_MAX; p++) {
    nsdae_law_edges(p, edge);
    const nsdae_law law = nsdae_law_make(2, mu, p, edge);
    double x[NSDAE_LAW_ROWS], y[NSDAE_LAW_ROWS], impulse[3], sum = 0, sums[2] = {0};
    const double xi[3] = {0.7, -0.4, 0.9};
    for (int j = 0; j < p + 2; j++) x[j] = 1 + 0.5 * sin(j + p);
    apply(&law, x, xi, y, impulse);
    for (int j = 0; j < p; j++) {
      const double *d = edge + 2 * j, *next = edge + 2 * ((j + 1) % p);
      assert_near(hypot(d[0], d[1]), 1, rounding);
      assert_near(d[0] * next[0] + d[1] * next[1], cos(2 * acos(-1) / p), rounding);
      assert_near(y[1 + j], x[p + 1] + d[0] * xi[1] + d[1] * xi[2], rounding);
      impulse[1] -= d[0] * x[1 + j];
      impulse[2] -= d[1] * x[1 + j];
      sum += x[1 + j];
      sums[0] += d[0];
      sums[1] += d[1];
    }
    assert_near(y[0], xi[0], 0);
    assert_near(y[p + 1], mu * x[0] - sum, p * rounding);
    assert_near(impulse[0], x[0], 0);
    assert_near(impulse[1], 0, p * rounding);
    assert_near(impulse[2], 0, p * rounding);
    assert_near(hypot(sums[0], sums[1]), 0, p * rounding); /* all around */
  }
}

int main(void)
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(test_kinds),
      cmocka_unit_test(test_frictionless),
      cmocka_unit_test(test_planar),
      cmocka_unit_test(test_polygon),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
