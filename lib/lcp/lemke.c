/* The dictionary of the augmented problem y = A x + d z0 + b,
 *
 *   basic_i = q_i + sum_j D_ij nonbasic_j,
 *
 * is kept condensed: n x (n + 1) coefficients and q. Variables are numbered y_i: i, x_i: n + i,
 * z0: 2 n. Ties are broken as if b_i were b_i + eps^(i+1): the coefficient of eps^(k+1) in the
 * constant of row i is -D_ij where y_k is the j-th nonbasic variable and 1 where y_k is basic_i. */
#include <float.h>
#include <math.h>
#include <nsdae/kernels.h>
#include <stddef.h>

#include "finite.h"

typedef struct dictionary {
  int n;
  double *D, *q;         /* n x (n + 1), n */
  int *basic, *nonbasic; /* n, n + 1 */
} dictionary;

static double *column_of(const dictionary *t, int j)
{
  return t->D + (size_t)j * (size_t)t->n;
}

static void fill(dictionary *t, const double *a, int lda, const double *b, const double *d)
{
  int n = t->n;
  for (int j = 0; j < n; j++) {
    double *column = column_of(t, j);
    for (int i = 0; i < n; i++) column[i] = a[(size_t)j * (size_t)lda + (size_t)i];
    t->nonbasic[j] = n + j;
    t->basic[j] = j;
    t->q[j] = b[j];
    column_of(t, n)[j] = d ? d[j] : 1;
  }
  t->nonbasic[n] = 2 * n;
}

/* Exchanges basic[r] and nonbasic[e]. */
static void pivot(dictionary *t, int r, int e)
{
  int n = t->n, leaving = t->basic[r];
  double *entering = column_of(t, e), by = entering[r], step = -t->q[r] / by;
  for (int j = 0; j <= n; j++) {
    double *column = column_of(t, j), factor = -column[r] / by;
    if (j == e || factor == 0) continue;
    for (int i = 0; i < n; i++) column[i] += factor * entering[i];
    column[r] = factor;
  }
  for (int i = 0; i < n; i++) t->q[i] += step * entering[i];
  t->q[r] = step;
  for (int i = 0; i < n; i++) entering[i] /= by;
  entering[r] = 1 / by;
  t->basic[r] = t->nonbasic[e];
  t->nonbasic[e] = leaving;
}

/* Coefficient of eps^(k+1) in the constant of row i; position: where y_k is nonbasic, or -1. */
static double perturbation(const dictionary *t, int i, int k, int position)
{
  if (position >= 0) return -column_of(t, position)[i];
  return t->basic[i] == k ? 1 : 0;
}

static int position_of(const dictionary *t, int variable)
{
  for (int j = 0; j <= t->n; j++)
    if (t->nonbasic[j] == variable) return j;
  return -1;
}

/* Whether row i comes before row r in the lexicographic ratio test of column e. */
static int before(const dictionary *t, int i, int r, const double *entering)
{
  for (int k = 0; k < t->n; k++) {
    int position = position_of(t, k);
    double one = perturbation(t, i, k, position) / -entering[i];
    double other = perturbation(t, r, k, position) / -entering[r];
    double rounding = 8 * DBL_EPSILON * (fabs(one) + fabs(other));
    if (fabs(one - other) > rounding) return one < other;
  }
  return 0;
}

/* Row that blocks the entering column: smallest q_i / -D_ie, ties by the perturbation; z0 leaves
 * wherever it is among them. -1: none, a ray. */
static int blocking_row(const dictionary *t, int e)
{
  const double *entering = column_of(t, e);
  double largest = 0, smallest = INFINITY, rounding;
  int n = t->n, best = -1;
  for (int i = 0; i < n; i++) largest = fmax(largest, fabs(entering[i]));
  double least = 64 * DBL_EPSILON * largest;
  for (int i = 0; i < n; i++)
    if (entering[i] < -least) smallest = fmin(smallest, fmax(t->q[i], 0) / -entering[i]);
  for (int i = 0; i < n; i++) {
    if (!(entering[i] < -least)) continue;
    double ratio = fmax(t->q[i], 0) / -entering[i];
    rounding = 1e-13 * smallest + DBL_MIN;
    if (ratio > smallest + rounding) continue;
    if (t->basic[i] == 2 * n) return i;
    if (best < 0 || before(t, i, best, entering)) best = i;
  }
  return best;
}

/* Row of the first pivot: the most negative q_i / d_i; the last of a tie has the least eps. */
static int first_row(const dictionary *t)
{
  const double *d = column_of(t, t->n);
  int worst = -1;
  for (int i = 0; i < t->n; i++)
    if (t->q[i] < 0 && (worst < 0 || t->q[i] / d[i] <= t->q[worst] / d[worst])) worst = i;
  return worst;
}

static int complement(int variable, int n)
{
  return variable < n ? variable + n : variable - n;
}

static int pivot_to_the_end(dictionary *t, int max_pivots, int *pivots)
{
  int n = t->n, row = first_row(t), e = n;
  *pivots = 0;
  while (row >= 0) {
    if (*pivots == max_pivots) return 2;
    int leaving = t->basic[row];
    pivot(t, row, e);
    ++*pivots;
    if (leaving == 2 * n) return 0;
    e = position_of(t, complement(leaving, n));
    row = blocking_row(t, e);
    if (row < 0) return 1;
  }
  return 0;
}

static void read_solution(const dictionary *t, double *x, int *basis)
{
  int n = t->n;
  for (int i = 0; i < n; i++) {
    x[i] = 0;
    basis[i] = 0;
  }
  for (int i = 0; i < n; i++) {
    int variable = t->basic[i] - n;
    if (variable < 0 || variable == n) continue;
    x[variable] = fmax(t->q[i], 0);
    basis[variable] = 1;
  }
}

static int check(int n, const double *a, int lda, const double *b, const double *d, int max_pivots,
                 const double *x, const int *basis, const int *pivots, const double *work,
                 int lwork, const int *iwork)
{
  if (n < 0 || n > 32000) return -1;
  if (!work) return -10;
  if (lwork == -1) return 0;
  if (lda < 1 || lda < n) return -3;
  if (!nsdae_lcp_finite(n, n, a, lda)) return -2;
  if (!nsdae_lcp_finite(n, 1, b, n)) return -4;
  for (int i = 0; d && i < n; i++)
    if (!(d[i] > 0) || isinf(d[i])) return -5;
  if (max_pivots < 0) return -6;
  if (!x && n > 0) return -7;
  if (!basis && n > 0) return -8;
  if (!pivots) return -9;
  if (lwork < n * (n + 2)) return -11;
  return iwork ? 0 : -12;
}

int nsdae_dlemke(int n, const double *a, int lda, const double *b, const double *d, int max_pivots,
                 double *x, int *basis, int *pivots, double *work, int lwork, int *iwork)
{
  int info = check(n, a, lda, b, d, max_pivots, x, basis, pivots, work, lwork, iwork);
  if (info != 0) return info;
  if (lwork == -1) {
    work[0] = (double)n * (n + 2);
    return 0;
  }
  dictionary t = {.n = n,
                  .D = work,
                  .q = work + (size_t)n * ((size_t)n + 1),
                  .basic = iwork,
                  .nonbasic = iwork + n};
  fill(&t, a, lda, b, d);
  info = pivot_to_the_end(&t, max_pivots, pivots);
  read_solution(&t, x, basis);
  if (info == 0 && !nsdae_lcp_finite(n, 1, t.q, n)) return 3;
  return info;
}
