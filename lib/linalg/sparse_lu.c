#include "sparse_lu.h"

#include <limits.h>
#include <math.h>
#include <string.h>

#include <amd.h>

/* A pivot may be that much smaller than the largest of its column, if it keeps the factors sparse
 * (the row of the column's own number) or the pattern as it was. */
static const double threshold = 1e-3;

static void layout_triangle(nsdae_triangle *t, long n, nsdae_arena *arena)
{
  t->first = NSDAE_ARENA_INTS(arena, n + 1);
  t->row = NSDAE_ARENA_INTS(arena, n * (n + 1) / 2);
  t->value = NSDAE_ARENA_DOUBLES(arena, n * (n + 1) / 2);
}

void nsdae_sparse_lu_layout(nsdae_sparse_lu *lu, nsdae_arena *arena)
{
  long n = lu->n;
  if (n > 0 && n > INT_MAX / n) arena->overflow = 1; /* AMD counts in int */
  lu->first = NSDAE_ARENA_INTS(arena, n + 1);
  lu->row = NSDAE_ARENA_INTS(arena, n * n);
  lu->seen = nsdae_arena_take(arena, n * n, sizeof *lu->seen);
  lu->column = NSDAE_ARENA_INTS(arena, n + 1);
  lu->position = NSDAE_ARENA_INTS(arena, n);
  layout_triangle(&lu->L, n, arena);
  layout_triangle(&lu->U, n, arena);
  lu->stack = NSDAE_ARENA_INTS(arena, n);
  lu->at = NSDAE_ARENA_INTS(arena, n);
  lu->mark = NSDAE_ARENA_INTS(arena, n);
  lu->x = NSDAE_ARENA_DOUBLES(arena, n);
  lu->work = NSDAE_ARENA_INTS(arena, n * n + 9 * n);
}

void nsdae_sparse_lu_forget(nsdae_sparse_lu *lu)
{
  memset(lu->seen, 0, (size_t)lu->n * (size_t)lu->n);
  lu->ordered = lu->factored = 0;
}

/* A pattern that grows by what was ever not zero settles; a new one is ordered anew. */
static void grow_pattern(nsdae_sparse_lu *lu, const double *A, int lda)
{
  size_t n = (size_t)lu->n;
  for (size_t j = 0; j < n; j++)
    for (size_t i = 0; i < n; i++) {
      if (A[j * (size_t)lda + i] == 0 || lu->seen[j * n + i]) continue;
      lu->seen[j * n + i] = 1;
      lu->ordered = lu->factored = 0;
    }
}

static void gather_pattern(nsdae_sparse_lu *lu)
{
  size_t n = (size_t)lu->n;
  int count = 0;
  for (size_t j = 0; j < n; j++) {
    lu->first[j] = count;
    for (size_t i = 0; i < n; i++)
      if (lu->seen[j * n + i]) lu->row[count++] = (int)i;
  }
  lu->first[n] = count;
}

/* AMD's own entry for those who bring memory: the pattern of A + A^T without its diagonal by
 * columns, which it destroys, and eight arrays of n. */
static void order(nsdae_sparse_lu *lu)
{
  size_t n = (size_t)lu->n;
  int count = 0, *start = lu->work, *length = start + n, *pattern = length + 7 * n;
  gather_pattern(lu);
  for (size_t j = 0; j < n; j++) {
    start[j] = count;
    for (size_t i = 0; i < n; i++)
      if (i != j && (lu->seen[j * n + i] || lu->seen[i * n + j])) pattern[count++] = (int)i;
    length[j] = count - start[j];
  }
  size_t room = n * n + n; /* of the pattern */
  amd_2(lu->n, start, pattern, length, room < INT_MAX ? (int)room : INT_MAX, count, length + n,
        length + 2 * n, lu->column, length + 3 * n, length + 4 * n, length + 5 * n, length + 6 * n,
        NULL, NULL);
  lu->ordered = 1;
}

/* The rows that row i leads to through the columns of L: those get a place in the order of U, the
 * last first, from the end of U's column on (a depth-first search without recursion). */
static int search(nsdae_sparse_lu *lu, int i, int k, int *found, int top)
{
  int depth = 0;
  lu->stack[0] = i;
  lu->mark[i] = k + 1;
  lu->at[0] = lu->position[i] < 0 ? 0 : lu->L.first[lu->position[i]];
  while (depth >= 0) {
    int row = lu->stack[depth], place = lu->position[row], next = -1;
    int end = place < 0 ? 0 : lu->L.first[place + 1];
    while (next < 0 && lu->at[depth] < end) {
      int below = lu->L.row[lu->at[depth]++];
      if (lu->mark[below] != k + 1) next = below;
    }
    if (next < 0) {
      found[--top] = row;
      depth--;
      continue;
    }
    lu->stack[++depth] = next;
    lu->mark[next] = k + 1;
    lu->at[depth] = lu->position[next] < 0 ? 0 : lu->L.first[lu->position[next]];
  }
  return top;
}

/* x := column q of A, at its pattern */
static void scatter(nsdae_sparse_lu *lu, const double *A, int lda, int q)
{
  for (int p = lu->first[q]; p < lu->first[q + 1]; p++)
    lu->x[lu->row[p]] = A[(size_t)q * (size_t)lda + (size_t)lu->row[p]];
}

/* x := x - L(:, place) x_place */
static void eliminate(nsdae_sparse_lu *lu, int place, double value)
{
  for (int p = lu->L.first[place]; p < lu->L.first[place + 1]; p++)
    lu->x[lu->L.row[p]] -= lu->L.value[p] * value;
}

/* The row of the pivot among those found without a place: the largest, but the column's own where
 * that is large enough. -1: all are zero, or one is not a number. */
static int choose(const nsdae_sparse_lu *lu, const int *found, int count, int own)
{
  double most = 0;
  int pivot = -1, has_own = 0;
  for (int p = 0; p < count; p++) {
    double size = fabs(lu->x[found[p]]);
    if (lu->position[found[p]] >= 0) continue;
    if (!isfinite(size)) return -1;
    has_own |= found[p] == own;
    if (!(size > most)) continue;
    most = size;
    pivot = found[p];
  }
  return has_own && pivot >= 0 && fabs(lu->x[own]) >= threshold * most ? own : pivot;
}

/* Column k of L and U, with its pattern; found [n] is room for the rows. */
static int new_column(nsdae_sparse_lu *lu, const double *A, int lda, int k, int *found)
{
  int q = lu->column[k], n = lu->n, top = n, l = lu->L.first[k], u = lu->U.first[k];
  for (int p = lu->first[q]; p < lu->first[q + 1]; p++)
    if (lu->mark[lu->row[p]] != k + 1) top = search(lu, lu->row[p], k, found, top);
  for (int p = top; p < n; p++) lu->x[found[p]] = 0;
  scatter(lu, A, lda, q);
  for (int p = top; p < n; p++) {
    int place = lu->position[found[p]];
    if (place < 0) continue;
    lu->U.row[u] = place;
    lu->U.value[u++] = lu->x[found[p]];
    eliminate(lu, place, lu->x[found[p]]);
  }
  int pivot = choose(lu, found + top, n - top, q);
  if (pivot < 0) return k + 1;
  lu->U.row[u] = k;
  lu->U.value[u++] = lu->x[pivot];
  for (int p = top; p < n; p++) {
    if (lu->position[found[p]] >= 0 || found[p] == pivot) continue;
    lu->L.row[l] = found[p];
    lu->L.value[l++] = lu->x[found[p]] / lu->x[pivot];
  }
  lu->position[pivot] = k;
  lu->L.first[k + 1] = l;
  lu->U.first[k + 1] = u;
  return 0;
}

static int factor_anew(nsdae_sparse_lu *lu, const double *A, int lda)
{
  if (!lu->ordered) order(lu);
  for (int i = 0; i < lu->n; i++) {
    lu->position[i] = -1;
    lu->mark[i] = 0;
  }
  lu->factored = 0;
  lu->L.first[0] = lu->U.first[0] = 0;
  for (int k = 0; k < lu->n; k++)
    if (new_column(lu, A, lda, k, lu->work) != 0) return k + 1;
  lu->factored = 1;
  return 0;
}

/* Column k of the same pattern, pivot as before; 0, or 1 where that is too small now. pivot_row: of
 * place k, the row of A. */
static int same_column(nsdae_sparse_lu *lu, const double *A, int lda, int k, const int *pivot_row)
{
  int u_end = lu->U.first[k + 1] - 1, pivot = pivot_row[k];
  double most = 0;
  for (int p = lu->U.first[k]; p <= u_end; p++) lu->x[pivot_row[lu->U.row[p]]] = 0;
  for (int p = lu->L.first[k]; p < lu->L.first[k + 1]; p++) lu->x[lu->L.row[p]] = 0;
  scatter(lu, A, lda, lu->column[k]);
  for (int p = lu->U.first[k]; p < u_end; p++) {
    int place = lu->U.row[p];
    lu->U.value[p] = lu->x[pivot_row[place]];
    eliminate(lu, place, lu->U.value[p]);
  }
  double value = lu->x[pivot];
  lu->U.value[u_end] = value;
  for (int p = lu->L.first[k]; p < lu->L.first[k + 1]; p++) {
    most = fmax(most, fabs(lu->x[lu->L.row[p]]));
    lu->L.value[p] = lu->x[lu->L.row[p]] / value;
  }
  return !(fabs(value) > 0 && isfinite(value) && fabs(value) >= threshold * most);
}

int nsdae_sparse_lu_factor(nsdae_sparse_lu *lu, const double *A, int lda)
{
  int lost = 0;
  grow_pattern(lu, A, lda);
  for (int i = 0; lu->factored && i < lu->n; i++) lu->work[lu->position[i]] = i;
  for (int k = 0; lu->factored && !lost && k < lu->n; k++)
    lost = same_column(lu, A, lda, k, lu->work);
  return lu->factored && !lost ? 0 : factor_anew(lu, A, lda);
}

void nsdae_sparse_lu_solve(const nsdae_sparse_lu *lu, double *b)
{
  int n = lu->n;
  double *x = lu->x;
  /* L y = P b: x by places; L's rows are those of A, so b is still wanted by rows */
  for (int i = 0; i < n; i++) lu->work[lu->position[i]] = i;
  for (int k = 0; k < n; k++) {
    x[k] = b[lu->work[k]];
    for (int p = lu->L.first[k]; p < lu->L.first[k + 1]; p++)
      b[lu->L.row[p]] -= lu->L.value[p] * x[k];
  }
  for (int k = n - 1; k >= 0; k--) {
    int last = lu->U.first[k + 1] - 1;
    x[k] /= lu->U.value[last];
    for (int p = lu->U.first[k]; p < last; p++) x[lu->U.row[p]] -= lu->U.value[p] * x[k];
  }
  for (int k = 0; k < n; k++) b[lu->column[k]] = x[k];
}
