/* The maps of one item: derivatives against differences, roots where the law holds, and the
 * smoothed one on its way to the other. */
#include "check.h"

#include "cone.h"
#include "natural_map.h"
#include "../linalg/random_matrices.h"

typedef void map(int kind, double mu, double e, const double *r, const double *u, double *F,
                 double *B, double *A);

static void sharp(int kind, double mu, double e, const double *r, const double *u, double *F,
                  double *B, double *A)
{
  (void)e;
  nsdae_fc_natural_map(kind, mu, r, NULL, u, F, B, A);
}

static random_state state_of_draws = {11};

static double draw(void)
{
  return random_number(&state_of_draws);
}

/* Central differences of F in r and u; second derivatives of the maps are below 1 / e, and away
 * from its kinks (a step from them almost surely) those of the sharp one below 100. */
static void check_derivatives(map *f, int kind, double mu, double e)
{
  const double h = 1e-6;
  double r[3], u[3], F[3], B[9], A[9], high[3], low[3], none[9], skip[9];
  for (int j = 0; j < 3; j++) {
    r[j] = draw();
    u[j] = draw();
  }
  f(kind, mu, e, r, u, F, B, A);
  for (int j = 0; j < 6; j++) {
    double *x = j < 3 ? r + j : u + (j - 3), held = *x;
    const double *expected = j < 3 ? B + j : A + (j - 3);
    *x = held + h;
    f(kind, mu, e, r, u, high, none, skip);
    *x = held - h;
    f(kind, mu, e, r, u, low, none, skip);
    *x = held;
    for (int i = 0; i < 3; i++) assert_near((high[i] - low[i]) / (2 * h), expected[3 * i], 1e-4);
  }
}

static void test_derivatives(void **state)
{
  (void)state;
  const double mu[] = {0.05, 0.5, 1, 3};
  for (int k = 0; k < 400; k++)
    for (int kind = NSDAE_FC_CONE; kind <= NSDAE_FC_BILATERAL; kind++) {
      check_derivatives(sharp, kind, mu[k % 4], 0);
      check_derivatives(nsdae_fc_smooth_map, kind, mu[k % 4], 0.1);
    }
}

/* Open, stick and slide are roots; |F| of the smoothed map there is of the size of e. */
static void test_roots(void **state)
{
  (void)state;
  const double points[4][6] = {
      {0, 0, 0, 1, 2, 3}, {2, 0.3, -0.4, 0, 0, 0}, {2, -0.6, 0.8, 0, 3, -4}, {0, 0, 0, 0, 0, 0}};
  double F[3], B[9], A[9];
  for (int k = 0; k < 4; k++) {
    nsdae_fc_natural_map(NSDAE_FC_CONE, 0.5, points[k], NULL, points[k] + 3, F, B, A);
    for (int i = 0; i < 3; i++) assert_near(F[i], 0, 1e-15);
    nsdae_fc_smooth_map(NSDAE_FC_CONE, 0.5, 1e-9, points[k], points[k] + 3, F, B, A);
    for (int i = 0; i < 3; i++) assert_near(F[i], 0, 5e-9);
  }
}

/* The natural map of the certificate is the same one. */
static void test_natural(void **state)
{
  (void)state;
  double r[3], u[3], F[3], B[9], A[9];
  for (int k = 0; k < 1000; k++) {
    int kind = k % 3;
    for (int j = 0; j < 3; j++) {
      r[j] = kind == NSDAE_FC_CONE || j == 0 ? draw() : 0;
      u[j] = draw();
    }
    nsdae_fc_natural_map(kind, 0.7, r, NULL, u, F, B, A);
    double most = fmax(fabs(F[0]), fmax(fabs(F[1]), fabs(F[2])));
    assert_near(nsdae_fc_natural(kind, 0.7, r, NULL, u), most, 1e-15);
  }
}

int main(void)
{
  const struct CMUnitTest tests[] = {cmocka_unit_test(test_derivatives),
                                     cmocka_unit_test(test_roots), cmocka_unit_test(test_natural)};
  return cmocka_run_group_tests(tests, NULL, NULL);
}
