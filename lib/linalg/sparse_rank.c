#include <float.h>
#include <math.h>
#include <nsdae/status.h>
#include <string.h>

#include "sparse_schur.h"
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

static int count_dropped(const nsdae_sparse_kkt *k)
{
  int count = 0;
  for (int row = 0; row < k->part.row_count; row++) count += nsdae_sparse_kkt_is_dropped(k, row);
  return count;
}

/* As long as fewer rows are dropped than are spare, the smallest sine that counts is too small. */
int nsdae_sparse_kkt_find_rank(nsdae_sparse_kkt *k)
{
  nsdae_multifrontal_rank *r = &k->schur.rank;
  r->drop = fmax(k->rank_tol * k->rank_tol, ROUNDED);
  k->rank = (nsdae_kkt_rank){.count = k->part.row_count, .dependent = -1, .kept = 1};
  memset(r->forced, 0, (size_t)k->part.row_count * sizeof *r->forced);
  for (int more = 1; more;) {
    do {
      if (nsdae_multifrontal_factor(&k->schur, 1) != 0) return NSDAE_E_NONFINITE;
    } while (mark(k) > 0);
    more = count_dropped(k) < k->spare && k->rank.kept < 1;
    if (more) r->drop = fmax(r->drop, k->rank.kept * k->rank.kept) * (1 + DBL_EPSILON);
  }
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

/* Blocks that are coupled, so that the Schur complement of their rows is
 * dense. The whole matrix is factored,
 *
 *     [ A   J^T                       ]
 *     [ J   -eps diag(J diag(A)^-1 J^T) ]      diag(A): blocks
 *
 * which is quasi-definite for eps > 0: it has factors L S L^T, with signs S by rows, in every order
 * (Vanderbei, SIAM J. Optim. 5 (1995) 100). Rows are eliminated after one of their blocks, so that
 * their pivots are seldom as small as eps. */

/* The regularisation, in parts of what it is added to. Refinement removes it: each round leaves the
 * part eps / sine^2 of the error, with the smallest sine of a row to the others, which is 1e-6 at
 * least (sparse_kkt.h). Rounding is the least that it can be: 50 DBL_EPSILON. */
static const double EPS = 1e-14;

static int size_of(const nsdae_sparse_kkt *k, int block)
{
  return nsdae_blocks_size(&k->at.blocks, block);
}

/* ---- the graph */

static size_t values_of(const nsdae_sparse_kkt *k, const nsdae_coupling *C)
{
  size_t values = 0;
  for (int p = 0; p < C->count; p++)
    values += (size_t)size_of(k, C->pair[2 * p]) * (size_t)size_of(k, C->pair[2 * p + 1]);
  return values;
}

typedef struct layout {
  nsdae_sparse_kkt *k;
  const nsdae_coupling *C;
} layout;

static void lay_out(void *object, nsdae_arena *arena)
{
  const layout *of = object;
  const nsdae_sparse_kkt *k = of->k;
  nsdae_kkt_whole *w = &of->k->whole;
  long nodes = (long)k->at.blocks.count + k->nodes.count, pairs = of->C->count,
       edges = pairs + k->nodes.part[k->nodes.count];
  w->pair = NSDAE_ARENA_INTS(arena, 2 * pairs);
  w->value = NSDAE_ARENA_DOUBLES(arena, values_of(k, of->C));
  w->size = NSDAE_ARENA_INTS(arena, nodes);
  w->edge = NSDAE_ARENA_INTS(arena, 2 * edges);
  w->begin = NSDAE_ARENA_INTS(arena, edges + 1);
  w->left_out = NSDAE_ARENA_INTS(arena, k->part.row_count);
  w->x = NSDAE_ARENA_DOUBLES(arena, k->at.blocks.first[k->at.blocks.count] + k->part.row_count);
}

/* Keeps what was analysed for the same pairs. */
static int analyse_pairs(nsdae_sparse_kkt *k, const nsdae_coupling *C)
{
  nsdae_kkt_whole *w = &k->whole;
  const nsdae_kkt_nodes *n = &k->nodes;
  int blocks = k->at.blocks.count, nodes = blocks + n->count, edges = C->count;
  size_t bytes = 2 * (size_t)C->count * sizeof *C->pair;
  if (w->ready && w->count == C->count && memcmp(w->pair, C->pair, bytes) == 0) return NSDAE_OK;
  w->ready = 0;
  if (nsdae_arena_fit(&w->arena, lay_out, &(layout){k, C}) != NSDAE_OK) return NSDAE_E_MEMORY;
  w->count = C->count;
  memcpy(w->pair, C->pair, bytes);
  for (int b = 0; b < blocks; b++) w->size[b] = size_of(k, b);
  for (int i = 0; i < n->count; i++) w->size[blocks + i] = n->size[i];
  /* Pairs of neighbours: coupled blocks, and each node of rows with the blocks that it touches. */
  memcpy(w->edge, w->pair, bytes);
  for (int i = 0; i < n->count; i++)
    for (int p = n->part[i]; p < n->part[i + 1]; p++, edges++) {
      w->edge[2 * edges] = n->block[p];
      w->edge[2 * edges + 1] = blocks + i;
    }
  for (int e = 0; e <= edges; e++) w->begin[e] = 2 * e;
  const nsdae_joined joined = {edges, w->begin, w->edge};
  w->fronts.negative = blocks;
  int status = nsdae_adjacency_build(&w->graph, &joined, nodes, 0);
  if (status == NSDAE_OK)
    status = nsdae_multifrontal_analyse(&w->fronts, nodes, w->size, w->graph.first, w->graph.index);
  w->ready = status == NSDAE_OK;
  return status;
}

/* ---- the matrix */

/* The block of nodes a and b in the rows of the one that is eliminated last; by_b: those of b. */
static double *block_of(const nsdae_kkt_whole *w, int a, int b, int *by_b)
{
  *by_b = w->fronts.tree.number[b] > w->fronts.tree.number[a];
  return w->fronts.A + nsdae_multifrontal_block(&w->fronts, *by_b ? b : a, *by_b ? a : b);
}

/* Row `row` of a node of rows in its blocks, zeros if it is left out. */
static void put_row(const nsdae_sparse_kkt *k, int node, int row)
{
  const nsdae_kkt_whole *w = &k->whole;
  const nsdae_kkt_nodes *n = &k->nodes;
  int at = row - n->row[node], size = n->size[node], by_rows;
  double own = 0, part = w->left_out[row] ? 0 : 1;
  for (int p = n->part[node]; p < n->part[node + 1]; p++) {
    int columns = size_of(k, n->block[p]);
    const double *J = k->at.J + n->at[p] + at * columns, *Y = k->at.Y + n->at[p] + at * columns;
    double *to = block_of(w, n->block[p], k->at.blocks.count + node, &by_rows);
    for (int j = 0; j < columns; j++) to[by_rows ? j * size + at : at * columns + j] = part * J[j];
    own += nsdae_dot(columns, Y, Y);
  }
  double *diagonal = w->fronts.A + w->fronts.graph.diagonal[k->at.blocks.count + node];
  for (int j = 0; j < size; j++) diagonal[at * size + j] = 0;
  diagonal[at * (size + 1)] = part > 0 && own > 0 ? -EPS * own : -1;
}

int nsdae_sparse_kkt_factor_coupled(nsdae_sparse_kkt *k, const double *A, const nsdae_coupling *C,
                                    const double *keep)
{
  nsdae_kkt_whole *w = &k->whole;
  int rows = k->part.row_count;
  int status = analyse_pairs(k, C);
  if (status == NSDAE_OK) status = nsdae_sparse_kkt_transform_rows(k, A);
  if (status < 0) return status;
  memcpy(w->value, C->value, values_of(k, C) * sizeof *w->value);
  k->coupled = 1;
  k->rank = (nsdae_kkt_rank){.count = rows, .chosen = 1, .dependent = -1, .kept = 1};
  for (int i = 0; i < rows; i++) k->rank.count -= w->left_out[i] = keep && keep[i] == 0;
  const nsdae_blocks *b = &k->at.blocks;
  const double *value = w->value;
  for (int i = 0; i < b->count; i++)
    memcpy(w->fronts.A + w->fronts.graph.diagonal[i], k->at.M + b->square[i],
           (b->square[i + 1] - b->square[i]) * sizeof *value);
  for (int p = 0; p < w->count; p++) {
    int i = w->pair[2 * p], j = w->pair[2 * p + 1], n = size_of(k, i), by_column;
    double *to = block_of(w, i, j, &by_column);
    for (int c = 0; c < size_of(k, j); c++)
      for (int r = 0; r < n; r++) to[by_column ? r * size_of(k, j) + c : c * n + r] = *value++;
  }
  for (int i = 0; i < k->nodes.count; i++)
    for (int row = k->nodes.row[i]; row < k->nodes.row[i + 1]; row++) put_row(k, i, row);
  return nsdae_multifrontal_factor(&w->fronts, 1) == 0 ? NSDAE_OK : NSDAE_E_MASS;
}

/* ---- products and solutions */

void nsdae_sparse_whole_add_product(const nsdae_sparse_kkt *k, const double *x, double *g)
{
  const nsdae_kkt_whole *w = &k->whole;
  const double *value = w->value;
  for (int p = 0; p < w->count; p++) {
    int i = w->pair[2 * p], j = w->pair[2 * p + 1], rows = size_of(k, i), columns = size_of(k, j);
    int row = k->at.blocks.first[i], column = k->at.blocks.first[j];
    for (int c = 0; c < columns; c++, value += rows) {
      nsdae_add(rows, x[column + c], value, g + row);
      g[column + c] += nsdae_dot(rows, value, x + row);
    }
  }
}

void nsdae_sparse_whole_solve(const nsdae_sparse_kkt *k)
{
  const nsdae_kkt_whole *w = &k->whole;
  const nsdae_kkt_values *a = &k->at;
  size_t n = (size_t)a->blocks.first[a->blocks.count], m = (size_t)k->part.row_count;
  memcpy(w->x, a->g, n * sizeof *w->x);
  for (size_t i = 0; i < m; i++) w->x[n + i] = w->left_out[i] ? 0 : a->d[i];
  nsdae_multifrontal_solve(&w->fronts, w->x);
  memcpy(a->z, w->x, n * sizeof *a->z);
  memcpy(a->h, w->x + n, m * sizeof *a->h);
}
