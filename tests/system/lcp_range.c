/* Seeded problems at all magnitudes: A by 10^-300 .. 10^300, b by 10^-320 .. 10^300. Doubles below
 * 1e-308 lie 2^-1074 apart and keep fewer digits the smaller they are: a problem whose solution can
 * be written is solved to that and to the solver's tolerance wherever the same digits are with
 * exponents about zero, and none is said to be that is not. */
#include "check.h"

#include <nsdae/nsdae.h>

#include "lcp_families.h"

enum { LARGEST = 24, ROUNDS = 10000 };

static const int family[] = {FAMILY_DEFINITE,  FAMILY_SEMIDEFINITE, FAMILY_FRICTIONLESS,
                             FAMILY_PLANAR_3,  FAMILY_PLANAR_4,     FAMILY_PYRAMID_4,
                             FAMILY_DEGENERATE};
enum { COUNT = sizeof family / sizeof *family };

/* Half the distance of doubles below DBL_MIN, and what is left of an A x + b by a solver with a
 * tolerance of 1e-10 in rows and columns of its own scale, relative to the largest term. */
static const long double half = 0x1p-1075L, accuracy = 1e-9L;

/* What x_i changes most. */
static long double reach(int n, const double *column)
{
  long double most = 0;
  for (int i = 0; i < n; i++) most = fmaxl(most, fabsl((long double)column[i]));
  return most;
}

/* min(x, y) = 0 but for what x is rounded by, in a wider range of numbers. */
static void check_solution(int n, const double *A, const double *b, const double *x)
{
  long double y[LARGEST], least[LARGEST], size = 0;
  for (int i = 0; i < n; i++) {
    long double terms = fabsl((long double)b[i]);
    y[i] = b[i];
    least[i] = 0;
    for (int j = 0; j < n; j++) {
      long double a = A[j * n + i], term = a * x[j];
      y[i] += term;
      terms += fabsl(term);
      least[i] += fabsl(a) * half;
    }
    size = fmaxl(size, terms);
  }
  for (int i = 0; i < n; i++) {
    long double slack = accuracy * size + 1.001L * least[i];
    assert_true(x[i] >= 0 && y[i] >= -slack);
    assert_true(fminl(x[i] * reach(n, A + i * n), y[i]) <= slack);
  }
}

/* value * 10^power, once rounded. */
static double shifted(double value, int power)
{
  return (double)(value * powl(10, power));
}

static double largest(int n, const double *a)
{
  double most = 0;
  for (int i = 0; i < n; i++) most = fmax(most, fabs(a[i]));
  return most;
}

/* The stage that solved it, or none. */
static int solve(int n, const double *A, const double *b, double *x)
{
  double y[LARGEST];
  nsdae_lcp_info info;
  const nsdae_lcp_problem problem = {.n = n, .A = A, .lda = n, .b = b};
  for (int i = 0; i < n; i++) x[i] = 0;
  int status = nsdae_lcp_solve(&problem, NULL, x, y, &info);
  assert_true(status == NSDAE_OK || status == NSDAE_E_LCP || status == NSDAE_E_INFEASIBLE);
  return status == NSDAE_OK ? info.stage : NSDAE_LCP_NONE;
}

/* The same numbers but for their exponents, the largest about one. */
static void bring_to_one(int n, double *a)
{
  double most = largest(n, a);
  for (int i = 0; i < n && most > 0; i++) a[i] = ldexp(a[i], -ilogb(most));
}

/* Solves the problem with A by 10^of_A and b by 10^of_b, and the same with exponents about zero:
 * returns whether that was solved and this was not. What was rounded away below 1e-308 leaves most
 * singular problems without solution; the stages behind Lemke's method find for some of them a long
 * vector that A takes to nothing, with a norm that knows no other scale than one. */
static int differs(const lcp_sample *s, int of_A, int of_b)
{
  static double A[LARGEST * LARGEST], b[LARGEST], x[LARGEST];
  for (int i = 0; i < s->n * s->n; i++) A[i] = shifted(s->A[i], of_A);
  for (int i = 0; i < s->n; i++) b[i] = shifted(s->b[i], of_b);
  int solved = solve(s->n, A, b, x);
  if (solved) check_solution(s->n, A, b, x);
  bring_to_one(s->n * s->n, A);
  bring_to_one(s->n, b);
  return !solved && solve(s->n, A, b, x) == NSDAE_LCP_LEMKE;
}

/* Whether all of A and b is a number, and x can be written as one. */
static int in_range(const lcp_sample *s, int of_A, int of_b)
{
  double a = log10(largest(s->n * s->n, s->A)), b = log10(largest(s->n, s->b) + 1e-30);
  double x = log10(largest(s->n, s->x) + 1e-30);
  return a + of_A < 300 && b + of_b < 300 && x + of_b - of_A < 300 && x + of_b - of_A > -323;
}

static void test_magnitudes(void **state)
{
  (void)state;
  lcp_sample s = lcp_sample_create(LARGEST, 5);
  int count = 0, small = 0, rounds = ROUNDS / test_share();
  for (int k = 0; k < rounds; k++) {
    int which = family[lcp_sample_pick(&s, COUNT)];
    int least = lcp_family_least(which);
    lcp_sample_draw(&s, which, least + lcp_sample_pick(&s, LARGEST - least + 1));
    int of_A = lcp_sample_pick(&s, 3) ? lcp_sample_pick(&s, 9) - 4 : lcp_sample_pick(&s, 601) - 300;
    int of_b =
        lcp_sample_pick(&s, 2) ? -lcp_sample_pick(&s, 21) - 300 : lcp_sample_pick(&s, 621) - 320;
    if (!in_range(&s, of_A, of_b)) continue;
    if (differs(&s, of_A, of_b))
      fail_msg("problem %d (%s, n = %d): A 1e%d, b 1e%d is not solved", k, lcp_family_name(which),
               s.n, of_A, of_b);
    count++;
    small += of_b < -307;
  }
  lcp_sample_release(&s);
  assert_true(count > rounds / 4 && small > rounds / 8);
}

/* One row, as where a velocity has decayed: x = -b / a to the last double, for every b below. */
static void test_every_denormal(void **state)
{
  (void)state;
  for (double b = 0x1p-1074; b < 0x1p-1015; b *= 1.25) {
    if (b * 1.25 == b) b *= 2;
    for (double a = 0.61; a < 4; a *= 1.7) {
      double x = 0, y;
      const double minus = -b;
      const nsdae_lcp_problem problem = {.n = 1, .A = &a, .lda = 1, .b = &minus};
      assert_int_equal(nsdae_lcp_solve(&problem, NULL, &x, &y, NULL), NSDAE_OK);
      assert_true(fabsl((long double)x - (long double)b / a) <= half + 1e-15L * x);
    }
  }
}

int main(void)
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(test_magnitudes),
      cmocka_unit_test(test_every_denormal),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
