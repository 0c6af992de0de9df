#include "multifrontal.h"

#include <math.h>
#include <nsdae/status.h>
#include <string.h>

#include "dense.h"
#include "vector.h"

/* A supernode takes a further column while the zeros that it brings are fewer than this part. */
static const double RELAXED = 0.15;

/* The root of a dropped pivot: an entry of a solution is divided by its square, and is zero then.
 */
static const double DROPPED = 1e100;

static void lay_out_graph(void *object, nsdae_arena *arena)
{
  nsdae_multifrontal *f = object;
  nsdae_supernodes *s = &f->super;
  long n = f->graph.n, entries = s->count; /* here the number of entries of the graph */
  nsdae_arena_ints(arena, n + 1,
                   (int **[]){&f->graph.size, &f->graph.first, &f->place, &s->begin, &s->pivots,
                              &s->rest, &s->children, &f->work.local, &f->work.waiting, NULL});
  nsdae_arena_ints(arena, entries, (int **[]){&f->graph.index, &f->graph.twin, NULL});
  f->graph.at = nsdae_arena_take(arena, entries, sizeof(size_t));
  f->graph.diagonal = nsdae_arena_take(arena, n, sizeof(size_t));
  s->factor = nsdae_arena_take(arena, n + 1, sizeof(size_t));
}

static void lay_out_numbers(void *object, nsdae_arena *arena)
{
  nsdae_multifrontal *f = object;
  f->A = NSDAE_ARENA_DOUBLES(arena, f->values);
  f->F = NSDAE_ARENA_DOUBLES(arena, f->super.factor[f->super.count]);
  f->work.front = NSDAE_ARENA_DOUBLES(arena, f->super.most_front);
  f->work.stack = NSDAE_ARENA_DOUBLES(arena, f->super.most_stack);
  f->work.gather = NSDAE_ARENA_DOUBLES(arena, f->super.most_rest);
  nsdae_arena_doubles(arena, f->order, (double **[]){&f->work.vector, &f->rank.part, NULL});
  nsdae_arena_ints(arena, f->order,
                   (int **[]){&f->work.exchange, &f->rank.forced, &f->rank.is_dropped, NULL});
}

/* Where the blocks of A lie. */
static void place_blocks(nsdae_multifrontal *f)
{
  size_t used = 0;
  f->order = 0;
  for (int k = 0; k < f->graph.n; k++) {
    f->place[k] = f->order;
    f->order += nsdae_multifrontal_size(f, k);
  }
  f->place[f->graph.n] = f->order;
  for (int i = 0; i < f->graph.n; i++) {
    size_t n = (size_t)f->graph.size[i];
    f->graph.diagonal[i] = used;
    used += n * n;
    for (int a = f->graph.first[i]; a < f->graph.first[i + 1]; a++) {
      f->graph.at[a] = used;
      used += n * (size_t)f->graph.size[f->graph.index[a]];
    }
  }
  f->values = used;
  for (int i = 0; i < f->graph.n; i++) f->work.local[i] = f->graph.first[i];
  for (int i = 0; i < f->graph.n; i++) /* lists ascend: those of j meet their twins in order */
    for (int a = f->graph.first[i]; a < f->graph.first[i + 1]; a++)
      f->graph.twin[a] = f->work.local[f->graph.index[a]]++;
}

/* Runs of columns, each the parent of the one before. The last column of a run has the rows of all
 * except the run itself; where an earlier one has fewer, zeros are stored. */
static void find_supernodes(nsdae_multifrontal *f)
{
  const nsdae_symbolic *t = &f->tree;
  int s = 0;
  double stored = 0, zeros = 0;
  for (int k = 0; k < f->graph.n; k++) {
    int open = k > 0 && t->parent[k - 1] == k;
    double columns = open ? k - f->super.begin[s - 1] : 0;
    double more = open ? columns * (t->count[k] + 1 - t->count[k - 1]) : 0;
    if (open && zeros + more <= RELAXED * (stored + columns + t->count[k] + 1)) {
      zeros += more;
      stored += t->count[k] + 1;
      continue;
    }
    f->super.begin[s++] = k;
    zeros = 0;
    stored = t->count[k] + 1;
  }
  f->super.begin[s] = f->graph.n;
  f->super.count = s;
}

/* Rows below supernode s are those of its last column. */
static int last_of(const nsdae_multifrontal *f, int s)
{
  return f->super.begin[s + 1] - 1;
}

static void measure_supernodes(nsdae_multifrontal *f)
{
  const nsdae_symbolic *t = &f->tree;
  int *owner = f->work.local;
  f->super.factor[0] = 0;
  f->super.most_front = 0;
  f->super.most_rest = 0;
  for (int s = 0; s < f->super.count; s++) {
    int last = last_of(f, s);
    f->super.pivots[s] = f->super.rest[s] = f->super.children[s] = 0;
    for (int k = f->super.begin[s]; k <= last; k++) {
      f->super.pivots[s] += nsdae_multifrontal_size(f, k);
      owner[k] = s;
    }
    for (size_t a = t->start[last]; a < t->start[last + 1]; a++)
      f->super.rest[s] += nsdae_multifrontal_size(f, t->row[a]);
    size_t p = (size_t)f->super.pivots[s], r = (size_t)f->super.rest[s];
    f->super.factor[s + 1] = f->super.factor[s] + p * (p + 2 * r);
    if ((p + r) * (p + r) > f->super.most_front) f->super.most_front = (p + r) * (p + r);
    if (f->super.rest[s] > f->super.most_rest) f->super.most_rest = f->super.rest[s];
  }
  for (int s = 0; s < f->super.count; s++) {
    int above = t->parent[last_of(f, s)];
    if (above < f->graph.n) f->super.children[owner[above]]++;
  }
  /* Depth of the stack: a supernode takes what its children left and leaves its own. */
  size_t used = 0;
  int *waiting = f->work.waiting, top = 0;
  f->super.most_stack = 0;
  for (int s = 0; s < f->super.count; s++) {
    size_t rest = (size_t)f->super.rest[s];
    for (int c = 0; c < f->super.children[s]; c++) {
      size_t left = (size_t)f->super.rest[waiting[--top]];
      used -= left * left;
    }
    used += rest * rest;
    if (used > f->super.most_stack) f->super.most_stack = used;
    if (rest > 0) waiting[top++] = s;
  }
}

int nsdae_multifrontal_analyse(nsdae_multifrontal *f, int n, const int *size, const int *first,
                               const int *index)
{
  size_t count = (size_t)n;
  if (f->of_numbers.base && f->graph.n == n &&
      memcmp(f->graph.size, size, count * sizeof *size) == 0 &&
      memcmp(f->graph.first, first, (count + 1) * sizeof *first) == 0 &&
      memcmp(f->graph.index, index, (size_t)first[n] * sizeof *index) == 0)
    return NSDAE_OK;
  f->graph.n = 0; /* no graph is known any more, if memory ends */
  if (nsdae_symbolic_analyse(&f->tree, n, first, index, f->negative) != NSDAE_OK)
    return NSDAE_E_MEMORY;
  f->graph.n = n;
  f->super.count = first[n];
  if (nsdae_arena_fit(&f->of_graph, lay_out_graph, f) == NSDAE_OK) {
    memcpy(f->graph.size, size, count * sizeof *size);
    memcpy(f->graph.first, first, (count + 1) * sizeof *first);
    memcpy(f->graph.index, index, (size_t)first[n] * sizeof *index);
    place_blocks(f);
    find_supernodes(f);
    measure_supernodes(f);
    if (nsdae_arena_fit(&f->of_numbers, lay_out_numbers, f) == NSDAE_OK) return NSDAE_OK;
  }
  f->graph.n = 0;
  return NSDAE_E_MEMORY;
}

size_t nsdae_multifrontal_block(const nsdae_multifrontal *f, int row, int column)
{
  int low = f->graph.first[column], high = f->graph.first[column + 1];
  if (row == column) return f->graph.diagonal[row];
  while (high - low > 1) {
    int middle = (low + high) / 2;
    if (f->graph.index[middle] <= row)
      low = middle;
    else
      high = middle;
  }
  return f->graph.at[low];
}

/* Adds block (i, j) of A to the front, i and j numbers. */
static void add_block(const nsdae_multifrontal *f, double *F, int lda, size_t from, int i, int j)
{
  int rows = nsdae_multifrontal_size(f, i), columns = nsdae_multifrontal_size(f, j);
  const double *block = f->A + from;
  for (int c = 0; c < columns; c++) {
    double *to = F + (size_t)(f->work.local[j] + c) * (size_t)lda + f->work.local[i];
    for (int r = 0; r < rows; r++) to[r] += block[c * rows + r];
  }
}

/* Entries of A in the columns and rows of the supernode: those whose other end is not eliminated.
 * Of a symmetric matrix the columns are enough. */
static void add_entries(const nsdae_multifrontal *f, int s, double *F, int lda)
{
  const nsdae_symbolic *t = &f->tree;
  for (int k = f->super.begin[s]; k < f->super.begin[s + 1]; k++) {
    int i = t->node[k];
    add_block(f, F, lda, f->graph.diagonal[i], k, k);
    for (int a = f->graph.first[i]; a < f->graph.first[i + 1]; a++) {
      int other = t->number[f->graph.index[a]];
      if (other < f->super.begin[s]) continue;
      add_block(f, F, lda, f->graph.at[a], other, k);
      if (other >= f->super.begin[s + 1] && !f->symmetric)
        add_block(f, F, lda, f->graph.at[f->graph.twin[a]], k, other);
    }
  }
}

/* Adds what a child left, rest x rest, to the front (of a symmetric matrix its lower triangle). */
static void add_child(const nsdae_multifrontal *f, int child, const double *left, double *F,
                      int lda)
{
  const nsdae_symbolic *t = &f->tree;
  int last = last_of(f, child), rest = f->super.rest[child];
  const double *column = left;
  for (size_t b = t->start[last]; b < t->start[last + 1]; b++)
    for (int c = 0; c < nsdae_multifrontal_size(f, t->row[b]); c++, column += rest) {
      double *to = F + (size_t)(f->work.local[t->row[b]] + c) * (size_t)lda;
      size_t from = f->symmetric ? b : t->start[last];
      int at = 0;
      for (size_t a = t->start[last]; a < from; a++) at += nsdae_multifrontal_size(f, t->row[a]);
      for (size_t a = from; a < t->start[last + 1]; a++) {
        int rows = nsdae_multifrontal_size(f, t->row[a]);
        double *place = to + f->work.local[t->row[a]];
        for (int r = 0; r < rows; r++) place[r] += column[at + r];
        at += rows;
      }
    }
}

static void copy(int rows, int columns, const double *from, int ldf, double *to, int ldt)
{
  for (int c = 0; c < columns; c++)
    memcpy(to + (size_t)c * (size_t)ldt, from + (size_t)c * (size_t)ldf, (size_t)rows * sizeof *to);
}

/* LAPACK may let a NaN pass. */
static int check_pivots(int p, const double *F, int lda)
{
  for (int i = 0; i < p; i++)
    if (!(fabs(F[(size_t)i * ((size_t)lda + 1)]) < INFINITY)) return i + 1;
  return 0;
}

/* Whether the pivot of row j of the permuted matrix is to be dropped. */
static int drops(nsdae_multifrontal *f, int j, double pivot)
{
  double own = f->work.vector[j];
  f->rank.part[j] = own > 0 ? pivot / own : 0;
  return f->rank.forced[j] || !(pivot > f->rank.drop * own);
}

/* The pivot block P = L L^T of rows from `at` on, in plain loops; a column of L that is dropped is
 * zero. */
static int factor_dropping(nsdae_multifrontal *f, int at, int p, double *P, int lda)
{
  for (int j = 0; j < p; j++) {
    double *column = P + (size_t)j * (size_t)lda, pivot = column[j];
    if (!isfinite(pivot)) return j + 1;
    f->rank.is_dropped[at + j] = drops(f, at + j, pivot);
    if (f->rank.is_dropped[at + j]) {
      memset(column + j, 0, (size_t)(p - j) * sizeof *column);
      column[j] = DROPPED;
      continue;
    }
    column[j] = sqrt(pivot);
    for (int i = j + 1; i < p; i++) column[i] /= column[j];
    for (int c = j + 1; c < p; c++) {
      double *to = P + (size_t)c * (size_t)lda;
      for (int i = c; i < p; i++) to[i] -= column[i] * column[c];
    }
  }
  return 0;
}

/* The pivot block of supernode s; large ones by LAPACK, and anew if a pivot is to be dropped. */
static int factor_pivots(nsdae_multifrontal *f, int s, int p, double *P, int lda)
{
  int at = f->place[f->super.begin[s]], dropping = f->rank.drop > 0;
  double *before = f->F + f->super.factor[s];
  if (dropping && p < NSDAE_SMALL) return factor_dropping(f, at, p, P, lda);
  if (dropping) copy(p, p, P, lda, before, p);
  int info = nsdae_la_cholesky_pivots(p, P, lda), keep = info == 0;
  if (!dropping) return info != 0 ? info : check_pivots(p, P, lda);
  for (int j = 0; j < p && info == 0; j++) {
    double root = P[(size_t)j * ((size_t)lda + 1)];
    keep &= !drops(f, at + j, root * root);
    f->rank.is_dropped[at + j] = 0;
  }
  if (keep) return check_pivots(p, P, lda);
  copy(p, p, before, p, P, lda);
  return factor_dropping(f, at, p, P, lda);
}

static int is_negative(const nsdae_multifrontal *f, int number)
{
  return f->negative > 0 && f->tree.node[number] >= f->negative;
}

/* The front of n rows in runs of columns of one sign s, one run if the matrix is definite: with
 * P = s L L^T, R := s R L^-T, S := S - s R R^T. */
static int factor_symmetric(nsdae_multifrontal *f, int s, int n, double *F)
{
  int info = 0, end = f->super.begin[s + 1];
  for (int k = f->super.begin[s]; k < end && info == 0;) {
    int from = f->work.local[k], p = 0, negative = is_negative(f, k);
    for (; k < end && is_negative(f, k) == negative; k++) p += nsdae_multifrontal_size(f, k);
    int r = n - from - p;
    double *P = F + (size_t)from * (size_t)(n + 1);
    for (int c = 0; c < p && negative; c++)
      for (int i = 0; i < n - from; i++) P[(size_t)c * (size_t)n + (size_t)i] *= -1;
    info = factor_pivots(f, s, p, P, n);
    if (info == 0 && r > 0) nsdae_la_eliminate_below(p, r, negative ? 1 : -1, P, n);
  }
  return info;
}

static int factor_general(int p, int n, double *F, int *exchange)
{
  int info = nsdae_la_lu_front(p, n, F, n, exchange);
  return info != 0 ? info : check_pivots(p, F, n);
}

/* One supernode; top is the number of doubles on the stack, waiting the supernodes that left them.
 */
static int factor_one(nsdae_multifrontal *f, int s, int *waiting, int *count, size_t *top)
{
  int p = f->super.pivots[s], r = f->super.rest[s], n = p + r;
  double *F = f->work.front, *to = f->F + f->super.factor[s];
  /* Where the numbers of the supernode and below it begin in its front. */
  const nsdae_symbolic *t = &f->tree;
  int at = 0, last = last_of(f, s);
  for (int k = f->super.begin[s]; k <= last; at += nsdae_multifrontal_size(f, k++))
    f->work.local[k] = at;
  for (size_t a = t->start[last]; a < t->start[last + 1]; a++) {
    f->work.local[t->row[a]] = at;
    at += nsdae_multifrontal_size(f, t->row[a]);
  }
  memset(F, 0, (size_t)n * (size_t)n * sizeof *F);
  add_entries(f, s, F, n);
  for (int c = 0; c < f->super.children[s]; c++) {
    int child = waiting[--*count];
    *top -= (size_t)f->super.rest[child] * (size_t)f->super.rest[child];
    add_child(f, child, f->work.stack + *top, F, n);
  }
  int info = f->symmetric ? factor_symmetric(f, s, n, F)
                          : factor_general(p, n, F, f->work.exchange + f->place[f->super.begin[s]]);
  if (info != 0) return info;
  copy(p, p, F, n, to, p);
  copy(r, p, F + p, n, to + (size_t)p * (size_t)p, r);
  if (!f->symmetric) copy(p, r, F + (size_t)p * (size_t)n, n, to + (size_t)p * (size_t)(p + r), p);
  if (r == 0) return 0;
  copy(r, r, F + (size_t)p * (size_t)n + p, n, f->work.stack + *top, r);
  *top += (size_t)r * (size_t)r;
  waiting[(*count)++] = s;
  return 0;
}

int nsdae_multifrontal_factor(nsdae_multifrontal *f, int symmetric)
{
  int count = 0;
  size_t top = 0;
  f->symmetric = symmetric;
  /* The diagonal of A in the order of elimination, in the vector, which is free meanwhile. */
  for (int k = 0; k < f->graph.n && f->rank.drop > 0; k++) {
    const double *entry = f->A + f->graph.diagonal[f->tree.node[k]];
    int n = nsdae_multifrontal_size(f, k);
    for (int j = 0; j < n; j++, entry += n + 1) f->work.vector[f->place[k] + j] = *entry;
  }
  for (int s = 0; s < f->super.count; s++)
    if (factor_one(f, s, f->work.waiting, &count, &top) != 0) return s + 1;
  return 0;
}

/* Entries of the permuted vector in the rows below the supernode, and back. */
static void gather_rest(const nsdae_multifrontal *f, int s, int add)
{
  const nsdae_symbolic *t = &f->tree;
  double *g = f->work.gather;
  for (size_t a = t->start[last_of(f, s)]; a < t->start[last_of(f, s) + 1]; a++) {
    double *x = f->work.vector + f->place[t->row[a]];
    int rows = nsdae_multifrontal_size(f, t->row[a]);
    for (int k = 0; k < rows; k++)
      if (add)
        x[k] += *g++;
      else
        *g++ = x[k];
  }
}

static void forward(const nsdae_multifrontal *f, int s)
{
  int p = f->super.pivots[s], r = f->super.rest[s], at = f->place[f->super.begin[s]];
  const double *P = f->F + f->super.factor[s], *R = P + (size_t)p * (size_t)p;
  double *x = f->work.vector + at;
  if (f->symmetric) {
    nsdae_la_solve_lower(p, 1, P, p, x, p);
  } else {
    nsdae_la_lu_forward(p, P, p, f->work.exchange + at, x);
  }
  if (r == 0) return;
  memset(f->work.gather, 0, (size_t)r * sizeof *x);
  nsdae_la_add_product(r, p, -1, R, r, x, f->work.gather);
  gather_rest(f, s, 1);
}

static void backward(const nsdae_multifrontal *f, int s)
{
  int p = f->super.pivots[s], r = f->super.rest[s];
  const double *P = f->F + f->super.factor[s], *R = P + (size_t)p * (size_t)p,
               *U = R + (size_t)p * (size_t)r;
  double *x = f->work.vector + f->place[f->super.begin[s]];
  if (r > 0) gather_rest(f, s, 0);
  if (r > 0 && f->symmetric)
    nsdae_la_multiply_transposed(r, p, 1, -1, R, r, f->work.gather, r, 1, x, p);
  else if (r > 0)
    nsdae_la_add_product(p, r, -1, U, p, f->work.gather, x);
  if (f->symmetric)
    nsdae_la_solve_lower_transposed(p, 1, P, p, x, p);
  else
    nsdae_la_lu_backward(p, P, p, x);
}

/* x in the order of the blocks into the vector in that of the elimination (in), or back. */
static void permute(const nsdae_multifrontal *f, double *x, int in)
{
  for (int i = 0; i < f->graph.n; x += f->graph.size[i++]) {
    double *part = f->work.vector + f->place[f->tree.number[i]];
    memcpy(in ? part : x, in ? x : part, (size_t)f->graph.size[i] * sizeof *x);
  }
}

void nsdae_multifrontal_solve(const nsdae_multifrontal *f, double *x)
{
  permute(f, x, 1);
  for (int s = 0; s < f->super.count; s++) forward(f, s);
  for (int k = 0; k < f->graph.n && f->negative > 0; k++) /* S^-1 */
    for (int r = f->place[k]; is_negative(f, k) && r < f->place[k + 1]; r++)
      f->work.vector[r] = -f->work.vector[r];
  for (int s = f->super.count - 1; s >= 0; s--) backward(f, s);
  permute(f, x, 0);
}

void nsdae_multifrontal_release(nsdae_multifrontal *f)
{
  nsdae_arena_release(&f->tree.of_nodes);
  nsdae_arena_release(&f->tree.of_rows);
  nsdae_arena_release(&f->of_graph);
  nsdae_arena_release(&f->of_numbers);
  f->graph.n = 0;
}
