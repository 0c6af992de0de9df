/* What every test needs: cmocka with its includes, and an assertion on doubles that prints all
 * seventeen digits (cmocka 1.1's own compares floats). */
#ifndef NSDAE_TESTS_CHECK_H
#define NSDAE_TESTS_CHECK_H

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

/* |actual - expected| <= tol, with NaN a failure. */
#define assert_near(actual, expected, tol) \
  check_near((actual), (expected), (tol), #actual, __FILE__, __LINE__)

/* actual <= bound, with NaN a failure. */
#define assert_at_most(actual, bound) check_at_most((actual), (bound), #actual, __FILE__, __LINE__)

/* Tests of this program that were skipped. */
static int check_skips;

#undef skip
#define skip() (check_skips++, _skip(__FILE__, __LINE__))

/* Exit code of a group of tests: 77 is CTest's for a skipped test (SKIP_RETURN_CODE). A program
 * with a skipped test ends with it if no test failed. */
static inline int check_exit(int failed)
{
  enum { SKIPPED = 77 };
  return failed != 0 ? 1 : check_skips > 0 ? SKIPPED : 0;
}

#undef cmocka_run_group_tests
#define cmocka_run_group_tests(tests, setup, teardown)                                        \
  check_exit(_cmocka_run_group_tests(#tests, tests, sizeof(tests) / sizeof *(tests), (setup), \
                                     (teardown)))

/* Ends a test for lack of something on this machine or in this build. CI has it all: there it is a
 * failure. */
static inline void untested(const char *lack)
{
  const char *ci = getenv("CI");
  print_message("not tested: %s\n", lack);
  if (ci && strcmp(ci, "true") == 0) fail();
  skip();
}

/* The quick form of a long family takes one in test_share() of its cases, the whole form each of
 * them (NSDAE_TEST_SHARE=1). The default is a prime: it has no period in common with a family that
 * alternates among 2, 3 or 5 kinds. */
static inline int test_share(void)
{
  const char *text = getenv("NSDAE_TEST_SHARE");
  int share = text ? atoi(text) : 7;
  return share > 1 ? share : 1;
}

/* The number of cases, of n that are drawn at random. */
static inline int share_of(int n)
{
  return (n + test_share() - 1) / test_share();
}

static inline void check_near(double actual, double expected, double tol, const char *what,
                              const char *file, int line)
{
  if (fabs(actual - expected) <= tol) return;
  print_error("%s = %.17g, expected %.17g within %.3g (off by %.3g)\n", what, actual, expected, tol,
              fabs(actual - expected));
  _fail(file, line);
}

static inline void check_at_most(double actual, double bound, const char *what, const char *file,
                                 int line)
{
  if (actual <= bound) return;
  print_error("%s = %.17g, expected at most %.17g\n", what, actual, bound);
  _fail(file, line);
}

#endif
