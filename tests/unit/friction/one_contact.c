/* The root for a contact that slides, from any guess: blocks of any shape in their own frame, also
 * nearly singular ones; r is on its cone and slides against its velocity. */
#include "check.h"

#include "one_contact.h"

#include "../linalg/random_matrices.h"

static random_state draws = {37};

static double power(double low, double high)
{
  return exp(low + (high - low) * (1 + random_number(&draws)) / 2);
}

/* Whether D, in its frame, is positive definite by a share of its normal entry. */
static int definite(const double *D, double share)
{
  return D[0] - D[1] * D[1] / D[4] - D[2] * D[2] / D[8] > share * D[0];
}

/* |r_T| = mu r_N, u_N = 0 and u_T = -slip r_T; each next to the sizes that it is the sum of. */
static void check_law(const double *D, const double *q, double mu, double slip, const double *r)
{
  double size = mu * r[0];
  assert_true(r[0] > 0 && slip > 0);
  assert_near(hypot(r[1], r[2]) / size, 1, 1e-12);
  for (int j = 0; j < 3; j++) {
    double u = q[j], sizes = fabs(q[j]);
    for (int k = 0; k < 3; k++) {
      u += D[3 * j + k] * r[k];
      sizes += fabs(D[3 * j + k] * r[k]);
    }
    if (j > 0) u += slip * r[j], sizes += fabs(slip * r[j]);
    assert_at_most(fabs(u), 1e-9 * sizes);
  }
}

/* Guesses that a secant alone does not come back from. */
static void test_far_guesses(void **state)
{
  (void)state;
  const double D[9] = {1, 0, 0, 0, 1e-9, 0, 0, 0, 1}, q[3] = {-1e-4, 1, 0};
  const double guesses[] = {0, 5e-324, 1e-300, 1e-20, 1e-12, 1e-9, 1, 1e9, 1e100, 1e300};
  for (size_t i = 0; i < sizeof guesses / sizeof *guesses; i++) {
    double slip = guesses[i], r[3];
    nsdae_fc_solve_contact(D, q, 1e-3, 1e-15, &slip, r);
    check_law(D, q, 1e-3, slip, r);
    assert_near(slip / 1e7, 1, 1e-9);
  }
}

static void test_bent_block(void **state)
{
  (void)state;
  const double D[9] = {1, 4.44811e-5, 5.11998e-4, 4.44811e-5, 2.0391e-9,
                       0, 5.11998e-4, 0,          0.0666048};
  const double q[3] = {-2.58001e-6, 0.507221, -2.16223e-6};
  double slip = 5.7889e-11, r[3];
  nsdae_fc_solve_contact(D, q, 2.01601e-3, 1e-15, &slip, r);
  check_law(D, q, 2.01601e-3, slip, r);
}

static void test_any(void **state)
{
  int slides = 0;
  (void)state;
  for (int k = 0; k < 100000; k++) {
    double s1 = power(-20, 0), s2 = power(-20, 0), bend = power(-10, 0), mu = power(-7, 1);
    double D[9] = {1, 0, 0, 0, s1, 0, 0, 0, s2}, q[3], r[3], slip;
    D[1] = D[3] = bend * sqrt(s1) * random_number(&draws);
    D[2] = D[6] = bend * sqrt(s2) * random_number(&draws);
    if (!definite(D, 1e-3)) continue;
    q[0] = -power(-10, 0);
    q[1] = power(-10, 2) * random_number(&draws);
    q[2] = power(-10, 2) * random_number(&draws);
    slip = k % 3 == 0 ? 0 : power(-40, 40);
    nsdae_fc_solve_contact(D, q, mu, 1e-15, &slip, r);
    if (slip == 0 || r[0] == 0) continue; /* it sticks */
    check_law(D, q, mu, slip, r);
    slides++;
  }
  assert_true(slides > 10000);
}

int main(void)
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(test_far_guesses),
      cmocka_unit_test(test_bent_block),
      cmocka_unit_test(test_any),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
