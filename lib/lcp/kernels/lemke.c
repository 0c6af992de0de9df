/* Variables are numbered y_i: i, x_i: n + i, z0: 2 n. One of each pair x_k, y_k is nonbasic.
 * The exception is the pair that drives: one has just left, the other enters.
 *
 * Ties are broken as if b_i were b_i + eps^(i+1): the coefficient of eps^(k+1) in the constant of
 * row i is -C_ij where y_k is the j-th nonbasic variable and 1 where y_k is basic_i. */

#include <float.h>
#include <math.h>
#include <nsdae/kernels.h>

#include "dictionary.h"
#include "finite.h"

/* From BLOCKED rows on, pivots are put off, BLOCK at a time (measured). */
enum { BLOCKED = 30, BLOCK = 24 };

/* What is taken for rounding: relative to max |b| in z0 and a y_i, to the largest step so far in an
 * x_i; in z0 at the end of a ray; in an entry relative to the largest of its column; in
 * perturbations relative to themselves. */
static const double slack = 64 * DBL_EPSILON, last_slack = 1e-12, least_pivot = 1e-13,
                    same_perturbation = 1e-12;

typedef struct method {
  nsdae_dictionary t;
  int n, row_of_z0;
  int *basic; /* n: the variable of each row */
  int *place; /* n: column of the nonbasic one of x_k, y_k: j where y_k, ~j where x_k */
  int *is_x;  /* n: whether basic_i is an x_k */
  double slack_y, slack_x; /* what is as good as zero in a y_k or z0, in an x_k */
  double *bound;           /* n: of the ratio test */
} method;

static double slack_of(const method *m, int i)
{
  return m->is_x[i] ? m->slack_x : m->slack_y;
}

/* ---- lexicographic order */

/* Coefficient of eps^(k+1) in the constant of row i. */
static double perturbation(const method *m, int i, int k)
{
  if (m->place[k] >= 0) return -nsdae_dictionary_entry(&m->t, i, m->place[k]);
  return m->basic[i] == k ? 1 : 0;
}

/* Whether row i comes before row r in the lexicographic ratio test of column c. Coefficients are of
 * the order of one in the unit of their row; the rest of two equal ones is not compared. */
static int before(const method *m, int i, int r, const double *c)
{
  double unit_i = 1 / -c[i], unit_r = 1 / -c[r];
  double least =
      same_perturbation * (slack_of(m, i) * unit_i + slack_of(m, r) * unit_r) / m->slack_y;
  for (int k = 0; k < m->n; k++) {
    double one = perturbation(m, i, k) * unit_i, other = perturbation(m, r, k) * unit_r;
    double same = same_perturbation * (fabs(one) + fabs(other)) + least;
    if (fabs(one - other) > same) return one < other;
  }
  return 0;
}

static double smaller(double a, double b)
{
  return a < b ? a : b;
}

/* min c_i; four at a time, for the latency of a comparison. */
static double smallest_of(int n, const double *c)
{
  double least[4] = {INFINITY, INFINITY, INFINITY, INFINITY};
  int i = 0;
  for (; i + 4 <= n; i += 4)
    for (int k = 0; k < 4; k++) least[k] = smaller(c[i + k], least[k]);
  for (; i < n; i++) least[0] = smaller(c[i], least[0]);
  return smaller(smaller(least[0], least[1]), smaller(least[2], least[3]));
}

/* ---- ratio test */

/* Row that blocks the entering column. All whose basic_i is zero, or below, at the smallest bound
 * (Harris, Math. Program. 5, 1973) tie, and the perturbation chooses; z0 leaves wherever it is
 * among them. -1: none, a ray. */
static int blocking_row(const method *m, const double *c)
{
  int n = m->n, best = -1, z0 = m->row_of_z0;
  double least = least_pivot * nsdae_largest(n, c), smallest;
  /* bound_i: where basic_i falls below -slack as the entering variable grows. */
  const double *restrict q = m->t.q, slack_y = m->slack_y, more = m->slack_x - slack_y;
  const int *restrict is_x = m->is_x;
  double *restrict bound = m->bound;
  for (int i = 0; i < m->n; i++) {
    double constant = (q[i] > 0 ? q[i] : 0) + (slack_y + more * is_x[i]);
    double over = -c[i] > least ? constant : INFINITY, by = -c[i] > least ? -c[i] : 1;
    bound[i] = over / by;
  }
  smallest = smallest_of(n, m->bound);
  if (-c[z0] > least && m->t.q[z0] - m->slack_y <= smallest * -c[z0]) return z0;
  for (int i = 0; i < n; i++)
    if (-c[i] > least && m->t.q[i] <= smallest * -c[i] && (best < 0 || before(m, i, best, c)))
      best = i;
  return best;
}

/* ---- pivots */

/* After the first pivot, which has x_row enter. */
static int pivot_to_the_end(method *m, int row, int max_pivots, int *pivots)
{
  int n = m->n, e = row, entering = n + row;
  m->row_of_z0 = row;
  m->basic[row] = 2 * n;
  m->place[row] = n;
  for (*pivots = 1;; ++*pivots) {
    const double *c = nsdae_dictionary_column(&m->t, e);
    int r = blocking_row(m, c), leaving, k, left = e;
    if (r < 0) return m->t.q[row] > last_slack / slack * m->slack_y; /* with z0 = 0: solved */
    if (*pivots == max_pivots) return 2;
    leaving = m->basic[r];
    /* The variable entering takes row r. */
    double size = slack * fabs(m->t.q[r] / c[r]);
    m->is_x[r] = entering >= m->n;
    if (m->is_x[r]) m->slack_x = nsdae_larger(m->slack_x, size);
    m->basic[r] = entering;
    if (leaving == 2 * n) {
      nsdae_dictionary_move(&m->t, r, c);
      ++*pivots;
      return 0;
    }
    nsdae_dictionary_pivot(&m->t, r, e, c);
    k = leaving < n ? leaving : leaving - n;
    e = m->place[k] >= 0 ? m->place[k] : ~m->place[k];
    m->place[k] = leaving < n ? left : ~left;
    entering = leaving < n ? leaving + n : leaving - n;
  }
}

static int read_solution(const method *m, double *x, int *basis)
{
  int finite = 1;
  for (int i = 0; i < m->n; i++) x[i] = basis[i] = 0;
  for (int i = 0; i < m->n; i++) {
    int variable = m->basic[i] - m->n;
    finite &= isfinite(m->t.q[i]) != 0;
    if (variable < 0 || variable == m->n) continue;
    x[variable] = m->t.q[i] > 0 ? m->t.q[i] : 0;
    basis[variable] = 1;
  }
  return finite;
}

/* ---- interfaces */

int nsdae_lemke_block(int n)
{
  return n < BLOCKED ? 0 : BLOCK;
}

int nsdae_lemke(int n, int block, const double *a, int lda, const double *b, const double *d,
                int max_pivots, double *x, int *basis, int *pivots, double *work, int *iwork)
{
  int row = -1, info = 2;
  double least = 0;
  method m;
  /* Row of the first pivot: the most negative b_i / d_i; the last of a tie has the least eps. */
  for (int i = 0; i < n; i++) {
    double ratio = d ? b[i] / d[i] : b[i];
    if (!(b[i] < 0) || ratio > least) continue;
    row = i;
    least = ratio;
  }
  if (row < 0) {
    /* b >= 0: x = 0. */
    if (!nsdae_lcp_finite(n, n, a, lda)) return -2;
    for (int i = 0; i < n; i++) x[i] = basis[i] = 0;
    *pivots = 0;
    return 0;
  }
  if (nsdae_dictionary_start(&m.t, n, block, a, lda, b, d, row, work) != 0) return -2;
  /* x and basis, until they have what they are for, hold the bounds and is_x. */
  m.n = n;
  m.basic = iwork;
  m.place = iwork + n;
  m.is_x = basis;
  m.bound = x;
  m.slack_y = slack * nsdae_largest(n, b);
  m.slack_x = 0;
  for (int i = 0; i < n; i++) {
    m.basic[i] = i;
    m.place[i] = ~i;
    m.is_x[i] = 0;
  }
  *pivots = 0;
  if (max_pivots > 0) info = pivot_to_the_end(&m, row, max_pivots, pivots);
  return read_solution(&m, x, basis) ? info : 3;
}

int nsdae_dlemke(int n, const double *a, int lda, const double *b, const double *d, int max_pivots,
                 double *x, int *basis, int *pivots, double *work, int lwork, int *iwork)
{
  if (n < 0 || n > 32000) return -1;
  int block = nsdae_lemke_block(n), best = nsdae_dictionary_size(n, block);
  if (!work) return -10;
  if (lwork == -1) {
    work[0] = best;
    return 0;
  }
  if (!a && n > 0) return -2;
  if (lda < 1 || lda < n) return -3;
  if (!nsdae_lcp_finite(n, 1, b, n)) return -4;
  for (int i = 0; d && i < n; i++)
    if (!(d[i] > 0 && d[i] < INFINITY)) return -5;
  if (max_pivots < 0) return -6;
  if (!x && n > 0) return -7;
  if (!basis && n > 0) return -8;
  if (!pivots) return -9;
  if (lwork < nsdae_dictionary_size(n, 0)) return -11;
  if (!iwork) return -12;
  return nsdae_lemke(n, lwork < best ? 0 : block, a, lda, b, d, max_pivots, x, basis, pivots, work,
                     iwork);
}
