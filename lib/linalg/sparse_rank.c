#include "sparse_schur.h"

#include <float.h>
#include <math.h>
#include <string.h>

#include <nsdae/status.h>

#include "vector.h"

/* Least squared sine of an independent row. The pivot of a redundant row, divided by S_ii, is
 * rounding: DBL_EPSILON times the squared norm of its combination of other rows, here 5000. */
static const double ROUNDED = 1e-12;

/* Least pivot, divided by S_ii, that rounding cannot be: the squared norm of a combination is up to
 * 5e8, as in loops of 500 links with masses of ratio 1e6. Smaller ones are measured. */
static const double CERTAIN = 1e-7;

static double sine_of(double part)
{
  return sqrt(fmax(part, 0));
}

static int place(const nsdae_sparse_kkt *k, int row)
{
  int node = k->nodes.of_row[row];
  return nsdae_multifrontal_place(&k->schur, node, row - k->nodes.row[node]);
}

/* S_ii */
static double own(const nsdae_sparse_kkt *k, int row)
{
  int node = k->nodes.of_row[row];
  size_t j = (size_t)(row - k->nodes.row[node]), n = (size_t)k->nodes.size[node];
  return k->schur.A[k->schur.graph.diagonal[node] + j * (n + 1)];
}

int nsdae_sparse_kkt_is_dropped(const nsdae_sparse_kkt *k, int row)
{
  if (k->coupled) return k->whole.left_out[row];
  return k->schur.rank.is_dropped[place(k, row)];
}

/* ---- redundant rows: J^T N = 0 for N = [-S_RR^-1 S_RD; 1], with the rows R that count and those D
 * that were dropped */

/* Np = N p, of p that is zero in R */
static void combine(const nsdae_sparse_kkt *k, const double *p, double *Np)
{
  const nsdae_kkt_values *a = &k->at;
  memset(a->z, 0, (size_t)a->blocks.first[a->blocks.count] * sizeof *a->z);
  nsdae_sparse_kkt_add_transposed(k, a->Y, 1, p, a->z, NULL);
  nsdae_sparse_kkt_times(k, a->Y, a->z, Np);
  nsdae_multifrontal_solve(&k->schur, Np);
  for (int i = 0; i < k->part.row_count; i++) Np[i] = p[i] - Np[i];
}

/* out = N^T u, zero in R */
static void project(const nsdae_sparse_kkt *k, const double *u, double *out)
{
  const nsdae_kkt_values *a = &k->at;
  memcpy(out, u, (size_t)k->part.row_count * sizeof *out);
  nsdae_multifrontal_solve(&k->schur, out);
  memset(a->z, 0, (size_t)a->blocks.first[a->blocks.count] * sizeof *a->z);
  nsdae_sparse_kkt_add_transposed(k, a->Y, 1, out, a->z, NULL);
  nsdae_sparse_kkt_times(k, a->Y, a->z, out);
  for (int row = 0; row < k->part.row_count; row++)
    out[row] = nsdae_sparse_kkt_is_dropped(k, row) ? u[row] - out[row] : 0;
}

/* ---- rank */

/* |Y z| of z = u, with Y z in the vector z. */
static double length(const nsdae_sparse_kkt *k)
{
  const nsdae_kkt_values *a = &k->at;
  int n = a->blocks.first[a->blocks.count];
  memset(a->z, 0, (size_t)n * sizeof *a->z);
  nsdae_sparse_kkt_add_transposed(k, a->Y, 1, a->u, a->z, NULL);
  return sqrt(nsdae_dot(n, a->z, a->z));
}

/* The sine of a row by corrected seminormal equations (Bjorck, Linear Algebra Appl. 88/89 (1987)
 * 31): the least |Y z| with z_row = 1. Y z is formed from Y alone, as S has lost half of its
 * digits. Begins with u_row = 1 and small |Y u|: a column of N for a dropped row, else one of S^-1.
 * Ends when a correction gains less than a tenth. */
static double measure(const nsdae_sparse_kkt *k, int row, int dropped)
{
  const nsdae_kkt_values *a = &k->at;
  size_t m = (size_t)k->part.row_count;
  double square = own(k, row), last = INFINITY;
  if (!(square > 0)) return 0;
  memset(a->p, 0, m * sizeof *a->p);
  a->p[row] = 1;
  if (dropped) {
    combine(k, a->p, a->u);
  } else {
    memcpy(a->u, a->p, m * sizeof *a->u);
    nsdae_multifrontal_solve(&k->schur, a->u);
    double scale = 1 / a->u[row];
    for (size_t i = 0; i < m; i++) a->u[i] *= scale;
  }
  double now = length(k);
  while (now < 0.9 * last) {
    last = now;
    /* u of smaller length, with the same u_row */
    nsdae_sparse_kkt_times(k, a->Y, a->z, a->h);
    a->h[row] = 0;
    nsdae_multifrontal_solve(&k->schur, a->h);
    double fixed = a->h[row];
    for (size_t i = 0; i < m; i++) a->u[i] -= a->h[i] - fixed * a->u[i];
    now = length(k);
  }
  return fmin(now, last) / sqrt(square);
}

/* Whether the combination u of a row has a part in rows that this round has marked: it may be the
 * same, and is measured anew without them. */
static int is_marked(const nsdae_sparse_kkt *k, int row)
{
  const double part = 1e-6; /* squared; a smaller one costs further rounds, a larger one ranks */
  const nsdae_multifrontal_rank *r = &k->schur.rank;
  for (int other = 0; other < k->part.row_count; other++) {
    int at = place(k, other);
    double u = k->at.u[other];
    if (r->forced[at] && !r->is_dropped[at] && u * u * own(k, other) > part * own(k, row)) return 1;
  }
  return 0;
}

/* Marks rows whose small pivot is rounding, to be dropped; returns how many. */
static int mark(nsdae_sparse_kkt *k)
{
  nsdae_multifrontal_rank *r = &k->schur.rank;
  int more = 0;
  k->rank.kept = 1;
  for (int row = 0; row < k->part.row_count; row++) {
    int at = place(k, row), small = r->part[at] < CERTAIN;
    if (r->is_dropped[at]) continue;
    double sine = small ? measure(k, row, 0) : sine_of(r->part[at]);
    if (sine * sine > r->drop) {
      k->rank.kept = fmin(k->rank.kept, sine);
    } else if (!is_marked(k, row)) {
      r->forced[at] = 1;
      more++;
    }
  }
  return more;
}

int nsdae_sparse_kkt_find_rank(nsdae_sparse_kkt *k)
{
  nsdae_multifrontal_rank *r = &k->schur.rank;
  r->drop = fmax(k->rank_tol * k->rank_tol, ROUNDED);
  k->rank = (nsdae_kkt_rank){.count = k->part.row_count, .dependent = -1, .kept = 1};
  memset(r->forced, 0, (size_t)k->part.row_count * sizeof *r->forced);
  do {
    if (nsdae_multifrontal_factor(&k->schur, 1) != 0) return NSDAE_E_NONFINITE;
  } while (mark(k) > 0);
  /* Counts the dropped rows, and measures the sine of the one with the largest pivot. */
  int largest = -1;
  for (int row = 0; row < k->part.row_count; row++) {
    int at = place(k, row);
    if (!r->is_dropped[at]) continue;
    k->rank.count--;
    if (k->rank.dependent < 0) k->rank.dependent = k->part.row[row];
    if (largest < 0 || r->part[at] > r->part[place(k, largest)]) largest = row;
  }
  k->rank.left = largest < 0 ? 0 : measure(k, largest, 1);
  return NSDAE_OK;
}

int nsdae_sparse_kkt_keep_rank(nsdae_sparse_kkt *k, const double *keep)
{
  nsdae_multifrontal_rank *r = &k->schur.rank;
  k->rank = (nsdae_kkt_rank){.count = k->part.row_count, .chosen = 1, .dependent = -1, .kept = 1};
  r->drop = DBL_MIN; /* none that is positive */
  for (int row = 0; row < k->part.row_count; row++)
    r->forced[place(k, row)] = keep && keep[row] == 0;
  if (nsdae_multifrontal_factor(&k->schur, 1) != 0) return NSDAE_E_NONFINITE;
  int lost = 0; /* dropped beside those that the choice leaves out */
  for (int i = 0; i < k->part.row_count; i++) {
    lost += r->is_dropped[i] && !r->forced[i];
    k->rank.count -= r->is_dropped[i];
    if (!r->is_dropped[i]) k->rank.kept = fmin(k->rank.kept, sine_of(r->part[i]));
  }
  return lost > 0 ? NSDAE_E_CONVERGENCE : NSDAE_OK;
}

/* ---- the least norm */

/* l := l - N q of least norm: N^T N q = N^T l by conjugate gradients. N^T N = 1 + W^T W has few
 * distinct eigenvalues: ladders of 10 to 1000 bodies take 13 to 16 iterations. */
void nsdae_sparse_kkt_shorten(const nsdae_sparse_kkt *k)
{
  enum { MOST = 50 };
  const double digits = 1e-10; /* relative error of l */
  const nsdae_kkt_values *a = &k->at;
  int m = k->part.row_count;
  double *rest = a->u, *Np = a->h, *A_p = a->d, *p = a->p;
  project(k, a->l, rest);
  memcpy(p, rest, (size_t)m * sizeof *p);
  double square = nsdae_dot(m, rest, rest), least = digits * digits * nsdae_dot(m, a->l, a->l);
  for (int i = 0; i < MOST && square > least; i++) {
    combine(k, p, Np);
    project(k, Np, A_p);
    double step = square / nsdae_dot(m, p, A_p), was = square;
    nsdae_add(m, -step, Np, a->l);
    nsdae_add(m, -step, A_p, rest);
    square = nsdae_dot(m, rest, rest);
    for (int j = 0; j < m; j++) p[j] = rest[j] + square / was * p[j];
  }
}

/* Whether the equations of the dropped rows agree with the others. A row of sine t may miss its
 * equation by t |S_ii|^1/2 |x|, in the norm of M. */
int nsdae_sparse_kkt_consistent(const nsdae_sparse_kkt *k)
{
  const nsdae_kkt_values *a = &k->at;
  double sine = fmax(fmax(k->rank_tol, k->rank.left), sqrt(DBL_EPSILON));
  double norm = sqrt(nsdae_blocks_square(&a->blocks, a->M, a->x));
  for (int row = 0; row < k->part.row_count; row++)
    if (nsdae_sparse_kkt_is_dropped(k, row) &&
        !(fabs(a->d[row]) <= sine * (sqrt(own(k, row)) * norm + fabs(a->c[row]))))
      return 0;
  return 1;
}
