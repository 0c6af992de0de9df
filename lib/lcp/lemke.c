/* Variables are numbered y_i: i, x_i: n + i, z0: 2 n. Of each pair x_k, y_k one is nonbasic, but
 * for the pair of which the one has just left and the other enters.
 *
 * Ties are broken as if b_i were b_i + eps^(i+1): the coefficient of eps^(k+1) in the constant of
 * row i is -C_ij where y_k is the j-th nonbasic variable and 1 where y_k is basic_i. */
#include "lemke.h"

#include <float.h>
#include <math.h>
#include <nsdae/kernels.h>
#include <stddef.h>

#include "dictionary.h"

/* From BLOCKED rows on, pivots are put off, BLOCK at a time (measured). */
enum { BLOCKED = 60, BLOCK = 32 };

typedef struct method {
  nsdae_dictionary t;
  int n, row_of_z0;
  int *basic; /* n: the variable of each row */
  int *place; /* n: the column of the nonbasic one of x_k, y_k: j where it is y_k, ~j where x_k */
  double *ratio; /* n */
} method;

/* Coefficient of eps^(k+1) in the constant of row i. */
static double perturbation(const method *m, int i, int k)
{
  if (m->place[k] >= 0) return -nsdae_dictionary_entry(&m->t, i, m->place[k]);
  return m->basic[i] == k ? 1 : 0;
}

/* Whether row i comes before row r in the lexicographic ratio test of column c. */
static int before(const method *m, int i, int r, const double *c)
{
  for (int k = 0; k < m->n; k++) {
    double one = perturbation(m, i, k) / -c[i], other = perturbation(m, r, k) / -c[r];
    double rounding = 8 * DBL_EPSILON * (fabs(one) + fabs(other));
    if (fabs(one - other) > rounding) return one < other;
  }
  return 0;
}

/* max |c_i|; four at a time, for the latency of a comparison. */
static double largest_of(int n, const double *c)
{
  double most[4] = {0};
  int i = 0;
  for (; i + 4 <= n; i += 4)
    for (int k = 0; k < 4; k++) most[k] = fabs(c[i + k]) > most[k] ? fabs(c[i + k]) : most[k];
  for (; i < n; i++) most[0] = fmax(most[0], fabs(c[i]));
  return fmax(fmax(most[0], most[1]), fmax(most[2], most[3]));
}

static double smallest_of(int n, const double *c)
{
  double least[4] = {INFINITY, INFINITY, INFINITY, INFINITY};
  int i = 0;
  for (; i + 4 <= n; i += 4)
    for (int k = 0; k < 4; k++) least[k] = c[i + k] < least[k] ? c[i + k] : least[k];
  for (; i < n; i++) least[0] = c[i] < least[0] ? c[i] : least[0];
  return fmin(fmin(least[0], least[1]), fmin(least[2], least[3]));
}

/* ratio_i = q_i / -c_i where c_i < -least, else infinite. */
static void set_ratios(int n, const double *restrict q, const double *restrict c, double least,
                       double *restrict ratio)
{
  for (int i = 0; i < n; i++) {
    double constant = q[i] > 0 ? q[i] : 0;
    double above = -c[i] > least ? constant : INFINITY, below = -c[i] > least ? -c[i] : 1;
    ratio[i] = above / below;
  }
}

/* Row that blocks the entering column: smallest q_i / -c_i, ties by the perturbation; z0 leaves
 * wherever it is among them. -1: none, a ray. */
static int blocking_row(const method *m, const double *c)
{
  int n = m->n, best = -1;
  set_ratios(n, m->t.q, c, 64 * DBL_EPSILON * largest_of(n, c), m->ratio);
  double smallest = smallest_of(n, m->ratio);
  if (!(smallest < INFINITY)) return -1;
  double most = smallest + 1e-13 * smallest + DBL_MIN;
  if (m->ratio[m->row_of_z0] <= most) return m->row_of_z0;
  for (int i = 0; i < n; i++)
    if (m->ratio[i] <= most && (best < 0 || before(m, i, best, c))) best = i;
  return best;
}

/* Row of the first pivot: the most negative b_i / d_i; the last of a tie has the least eps. */
static int first_row(int n, const double *b, const double *d)
{
  int worst = -1;
  double least = 0;
  for (int i = 0; i < n; i++) {
    double ratio = d ? b[i] / d[i] : b[i];
    if (!(b[i] < 0) || ratio > least) continue;
    worst = i;
    least = ratio;
  }
  return worst;
}

/* After the first pivot, which has x_row enter. */
static int pivot_to_the_end(method *m, int row, int max_pivots, int *pivots)
{
  int n = m->n, e = row, entering = n + row;
  m->row_of_z0 = row;
  m->basic[row] = 2 * n;
  m->place[row] = n;
  for (*pivots = 1;; ++*pivots) {
    const double *c = nsdae_dictionary_column(&m->t, e);
    int r = blocking_row(m, c), leaving;
    if (r < 0) return 1;
    if (*pivots == max_pivots) return 2;
    leaving = m->basic[r];
    m->basic[r] = entering;
    if (leaving == 2 * n) {
      nsdae_dictionary_move(&m->t, r, c);
      ++*pivots;
      return 0;
    }
    nsdae_dictionary_pivot(&m->t, r, e, c);
    int left = e, k = leaving < n ? leaving : leaving - n;
    e = m->place[k] >= 0 ? m->place[k] : ~m->place[k];
    m->place[k] = leaving < n ? left : ~left;
    entering = leaving < n ? leaving + n : leaving - n;
  }
}

static void start(method *m, double *x, int *basis)
{
  for (int i = 0; i < m->n; i++) {
    m->basic[i] = i;
    m->place[i] = ~i;
    x[i] = 0;
    basis[i] = 0;
  }
}

static int read_solution(const method *m, double *x, int *basis)
{
  int finite = 1;
  for (int i = 0; i < m->n; i++) {
    int variable = m->basic[i] - m->n;
    finite &= isfinite(m->t.q[i]) != 0;
    if (variable < 0 || variable == m->n) continue;
    x[variable] = m->t.q[i] > 0 ? m->t.q[i] : 0;
    basis[variable] = 1;
  }
  return finite;
}

int nsdae_lemke_size(int n, int block)
{
  return n + nsdae_dictionary_size(n, block);
}

int nsdae_lemke_block(int n)
{
  return n < BLOCKED ? 0 : BLOCK;
}

int nsdae_lemke_work(int n)
{
  return nsdae_lemke_size(n, nsdae_lemke_block(n));
}

int nsdae_lemke(int n, int block, const double *a, int lda, const double *b, const double *d,
                int max_pivots, double *x, int *basis, int *pivots, double *work, int *iwork)
{
  method m = {.n = n, .basic = iwork, .place = iwork + n, .ratio = work};
  int row = first_row(n, b, d);
  if (nsdae_dictionary_start(&m.t, n, block, a, lda, b, d, row < 0 ? 0 : row, work + n) != 0)
    return -2;
  start(&m, x, basis);
  *pivots = 0;
  if (row < 0) return 0;
  if (max_pivots == 0) return 2;
  int info = pivot_to_the_end(&m, row, max_pivots, pivots);
  return read_solution(&m, x, basis) ? info : 3;
}

static int all_finite(int n, const double *a)
{
  for (int i = 0; i < n; i++)
    if (!isfinite(a[i])) return 0;
  return 1;
}

static int check(int n, const double *a, int lda, const double *b, const double *d, int max_pivots,
                 const double *x, const int *basis, const int *pivots, const double *work,
                 int lwork, const int *iwork)
{
  if (n < 0 || n > 32000) return -1;
  if (!work) return -10;
  if (lwork == -1) return 0;
  if (!a && n > 0) return -2;
  if (lda < 1 || lda < n) return -3;
  if (n > 0 && (!b || !all_finite(n, b))) return -4;
  for (int i = 0; d && i < n; i++)
    if (!(d[i] > 0 && d[i] < INFINITY)) return -5;
  if (max_pivots < 0) return -6;
  if (!x && n > 0) return -7;
  if (!basis && n > 0) return -8;
  if (!pivots) return -9;
  if (lwork < nsdae_lemke_work(n)) return -11;
  return iwork ? 0 : -12;
}

int nsdae_dlemke(int n, const double *a, int lda, const double *b, const double *d, int max_pivots,
                 double *x, int *basis, int *pivots, double *work, int lwork, int *iwork)
{
  int info = check(n, a, lda, b, d, max_pivots, x, basis, pivots, work, lwork, iwork);
  if (info != 0) return info;
  int block = nsdae_lemke_block(n);
  if (lwork == -1) {
    work[0] = nsdae_lemke_work(n);
    return 0;
  }
  if (n == 0) {
    *pivots = 0;
    return 0;
  }
  return nsdae_lemke(n, block, a, lda, b, d, max_pivots, x, basis, pivots, work, iwork);
}
