/* Problems whose solution is known, for the tests of the kernels. */
#ifndef NSDAE_TESTS_PROBLEMS_H
#define NSDAE_TESTS_PROBLEMS_H

#include "check.h"

#include <nsdae/kernels.h>

#include "support/random.h"

enum { MOST = 64 };

/* Entries and solutions of order one; n roundings of a well conditioned problem. */
static const double tight = 1e-11;

typedef struct problem {
  int n;
  double A[MOST * MOST], b[MOST], x[MOST]; /* x: the solution */
} problem;

/* A = B B^T / n + I, positive definite with a condition below some ten; with twist also a skew
 * part, which leaves x^T A x and with it the P-property. */
static inline void make_definite(random_state *r, int n, double twist, problem *p)
{
  double B[MOST * MOST];
  p->n = n;
  random_matrix(r, n, n, B, n);
  for (int j = 0; j < n; j++)
    for (int i = 0; i < n; i++) {
      double sum = i == j;
      for (int k = 0; k < n; k++) sum += B[k * n + i] * B[k * n + j] / n;
      p->A[j * n + i] = sum + twist * (B[j * n + i] - B[i * n + j]) / n;
    }
}

/* Strictly diagonally dominant by rows with a positive diagonal, signs at random: a P-matrix that
 * is in general not positive definite. */
static inline void make_dominant(random_state *r, int n, problem *p)
{
  p->n = n;
  random_matrix(r, n, n, p->A, n);
  for (int i = 0; i < n; i++) {
    double sum = 0.1;
    for (int j = 0; j < n; j++) sum += i == j ? 0 : fabs(p->A[j * n + i]);
    p->A[i * n + i] = sum;
  }
}

/* b = y - A x of a chosen x >= 0, y >= 0, x'y = 0; one in ten pairs is zero in both. */
static inline void choose_solution(random_state *r, problem *p)
{
  int n = p->n;
  for (int i = 0; i < n; i++) {
    int kind = random_int(r, 0, 9);
    double size = 0.1 + fabs(random_number(r));
    p->x[i] = kind < 5 && kind > 0 ? size : 0;
    p->b[i] = kind >= 5 ? size : 0;
  }
  for (int j = 0; j < n; j++)
    for (int i = 0; i < n; i++) p->b[i] -= p->A[j * n + i] * p->x[j];
}

static inline void expect_solution(const problem *p, const double *x, double residual)
{
  double y[MOST], work[MOST], fresh;
  assert_int_equal(nsdae_dlcpres(p->n, p->A, p->n, p->b, x, y, &fresh, work), 0);
  assert_true(fresh == residual);
  assert_at_most(fresh, tight);
  for (int i = 0; i < p->n; i++) {
    assert_true(x[i] >= 0);
    assert_near(x[i], p->x[i], 100 * tight);
  }
}

/* Lemke's solution of the same problem. */
static inline void expect_lemke(const problem *p, const double *x)
{
  double other[MOST], work[MOST * (MOST + 2)];
  int basis[MOST], pivots, iwork[2 * MOST + 1];
  assert_int_equal(nsdae_dlemke(p->n, p->A, p->n, p->b, NULL, 100 * p->n, other, basis, &pivots,
                                work, MOST * (MOST + 2), iwork),
                   0);
  for (int i = 0; i < p->n; i++) assert_near(x[i], other[i], 100 * tight);
}

#endif
