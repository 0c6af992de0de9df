#include "to_blocks.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "disjoint_sets.h"

enum { MOST = 256 }; /* numbers for each entry, row and column */

/* Of the root of its two diagonal entries, a difference of W_ij and W_ji that is rounding. */
static const double ROUNDING = 1e-12;

/* ---- partitions */

static int *integers(size_t count)
{
  return calloc(count + 1, sizeof(int));
}

/* Parts. */

static int create_partition(nsdae_h5 *h5, int n, nsdae_partition *p)
{
  size_t count = (size_t)n;
  *p = (nsdae_partition){
      .n = n, .of = integers(count), .at = integers(count), .size = integers(count)};
  return p->of && p->at && p->size ? NSDAE_OK : nsdae_h5_no_memory(h5);
}

void nsdae_partition_release(nsdae_partition *p)
{
  free(p->of);
  free(p->at);
  free(p->size);
  *p = (nsdae_partition){0};
}

/* Places and sizes from p->of. */
static void count_places(nsdae_partition *p)
{
  for (int i = 0; i < p->n; i++)
    if (p->of[i] >= 0) p->at[i] = p->size[p->of[i]]++;
}

int nsdae_partition_make(nsdae_h5 *h5, int n, int parts, const int *size, nsdae_partition *p)
{
  int status = create_partition(h5, n, p), i = 0;
  if (status < 0) return status;
  p->parts = parts;
  for (int k = 0; k < parts; k++) {
    if (size[k] < 1 || size[k] > n - i)
      return nsdae_h5_refuse(h5, "part %d has %d of %d rows, of which %d are left", k, size[k], n,
                             n - i);
    for (int end = i + size[k]; i < end; i++) p->of[i] = k;
  }
  if (i < n) return nsdae_h5_refuse(h5, "its parts have %d of %d rows", i, n);
  count_places(p);
  return NSDAE_OK;
}

/* Whether every entry stays in a part of that size. */
static int all_alike(const nsdae_triplets *M, int alike)
{
  if (M->rows % alike != 0) return 0;
  for (int k = 0; k < M->count; k++)
    if (M->row[k] / alike != M->column[k] / alike) return 0;
  return 1;
}

int nsdae_partition_find(nsdae_h5 *h5, const nsdae_triplets *M, int alike, nsdae_partition *p)
{
  int status = create_partition(h5, M->rows, p);
  if (status < 0) return status;
  int same = all_alike(M, alike);
  for (int i = 0; i < p->n; i++) p->of[i] = same ? i - i % alike : i;
  for (int k = 0; k < M->count; k++) nsdae_sets_join(p->of, M->row[k], M->column[k]);
  for (int i = 0; i < p->n; i++) { /* roots come before what they hold */
    int root = nsdae_sets_root(p->of, i);
    p->at[i] = root == i ? p->parts++ : p->at[root];
  }
  memcpy(p->of, p->at, (size_t)p->n * sizeof *p->of);
  count_places(p);
  return NSDAE_OK;
}

/* Rows by blocks. */

/* ---- entries by item and block */

/* Entries in the order of their items, those of one item as they come. */
static int sort_by_item(nsdae_h5 *h5, const nsdae_triplets *A, const nsdae_partition *items,
                        int **start, int **order)
{
  *start = integers((size_t)items->parts + 1);
  *order = integers((size_t)A->count);
  if (!*start || !*order) return nsdae_h5_no_memory(h5);
  int *next = *start + 1; /* counts, then starts of the items one further on */
  for (int k = 0; k < A->count; k++)
    if (items->of[A->column[k]] >= 0) next[items->of[A->column[k]]]++;
  for (int i = 1; i < items->parts; i++) next[i] += next[i - 1];
  for (int k = A->count; k-- > 0;) {
    int item = items->of[A->column[k]];
    if (item >= 0) (*order)[--next[item]] = k;
  }
  for (int i = 0; i < items->parts; i++) next[i - 1] = next[i];
  (*start)[items->parts] = 0;
  for (int k = 0; k < A->count; k++) (*start)[items->parts] += items->of[A->column[k]] >= 0;
  return NSDAE_OK;
}

/* What belongs to no part must be zero: rows of zeros that stand for none. */
static int check_outside(nsdae_h5 *h5, const nsdae_triplets *A, const nsdae_partition *rows,
                         const nsdae_partition *items)
{
  for (int k = 0; k < A->count; k++)
    if (A->value[k] != 0 && (rows->of[A->row[k]] < 0 || items->of[A->column[k]] < 0))
      return nsdae_h5_refuse(h5, "entry (%d, %d) = %g is in a row that its contact does not have",
                             A->row[k], A->column[k], A->value[k]);
  return NSDAE_OK;
}

/* One pass over the entries: the blocks of each item, and where their values begin. */
typedef struct pass {
  const nsdae_triplets *A;
  const nsdae_partition *rows, *items;
  const int *start, *order;
  int *stamp;   /* rows->parts: 1 + the item that it was met in last */
  size_t *home; /* rows->parts: where its values begin in that item */
} pass;

/* Blocks and numbers in all; fills g as far as it has room. */
static void go(const pass *p, nsdae_blocked_problem *g, size_t *blocks, size_t *numbers)
{
  *blocks = *numbers = 0;
  memset(p->stamp, 0, (size_t)p->rows->parts * sizeof *p->stamp);
  for (int i = 0; i < p->items->parts; i++) {
    if (g->first) g->first[i] = (int)*blocks;
    for (int e = p->start[i]; e < p->start[i + 1]; e++) {
      int k = p->order[e], row = p->A->row[k], b = p->rows->of[row];
      if (b < 0) continue;
      if (p->stamp[b] != i + 1) {
        if (g->block) g->block[*blocks] = b;
        p->stamp[b] = i + 1;
        p->home[b] = *numbers;
        ++*blocks;
        *numbers += (size_t)p->rows->size[b] * (size_t)p->items->size[i];
      }
      size_t column = (size_t)p->items->at[p->A->column[k]] * (size_t)p->rows->size[b];
      if (g->value) g->value[p->home[b] + column + (size_t)p->rows->at[row]] += p->A->value[k];
    }
  }
  if (g->first) g->first[p->items->parts] = (int)*blocks;
}

static int too_many(nsdae_h5 *h5, const nsdae_triplets *A, size_t numbers)
{
  double most = MOST * ((double)A->count + A->rows + A->columns);
  if ((double)numbers <= most) return NSDAE_OK;
  return nsdae_h5_refuse(h5,
                         "its blocks would take %.3g numbers for %d entries: too few of them are "
                         "not zero",
                         (double)numbers, A->count);
}

static int fill(nsdae_h5 *h5, const pass *p, nsdae_blocked_problem *g)
{
  size_t blocks, numbers;
  go(p, g, &blocks, &numbers);
  int status = too_many(h5, p->A, numbers);
  if (status < 0) return status;
  g->first = integers((size_t)p->items->parts);
  g->block = integers(blocks);
  g->value = calloc(numbers + 1, sizeof *g->value);
  if (!g->first || !g->block || !g->value) return nsdae_h5_no_memory(h5);
  go(p, g, &blocks, &numbers);
  return NSDAE_OK;
}

int nsdae_to_blocks(nsdae_h5 *h5, const nsdae_triplets *A, const nsdae_partition *rows,
                    const nsdae_partition *items, nsdae_blocked_problem *g)
{
  int *start = NULL, *order = NULL;
  *g = (nsdae_blocked_problem){0};
  int status = check_outside(h5, A, rows, items);
  if (status == NSDAE_OK) status = sort_by_item(h5, A, items, &start, &order);
  pass p = {.A = A, .rows = rows, .items = items, .start = start, .order = order};
  p.stamp = integers((size_t)rows->parts);
  p.home = calloc((size_t)rows->parts + 1, sizeof *p.home);
  if (status == NSDAE_OK) status = p.stamp && p.home ? fill(h5, &p, g) : nsdae_h5_no_memory(h5);
  free(p.stamp);
  free(p.home);
  free(start);
  free(order);
  return status;
}

void nsdae_blocked_problem_release(nsdae_blocked_problem *g)
{
  free(g->first);
  free(g->block);
  free(g->value);
  *g = (nsdae_blocked_problem){0};
}

/* ---- block-diagonal matrices */

int nsdae_to_blocks_diagonal(nsdae_h5 *h5, const nsdae_triplets *M, const nsdae_partition *p,
                             double **blocks)
{
  size_t numbers = 0, *home = calloc((size_t)p->parts + 1, sizeof *home);
  if (!home) return nsdae_h5_no_memory(h5);
  for (int b = 0; b < p->parts; b++) {
    home[b] = numbers;
    numbers += (size_t)p->size[b] * (size_t)p->size[b];
  }
  int status = too_many(h5, M, numbers);
  if (status == NSDAE_OK) *blocks = calloc(numbers + 1, sizeof **blocks);
  if (status == NSDAE_OK && !*blocks) status = nsdae_h5_no_memory(h5);
  for (int k = 0; k < M->count && status == NSDAE_OK; k++) {
    int i = M->row[k], j = M->column[k], b = p->of[i];
    if (p->of[j] != b)
      status = nsdae_h5_refuse(h5, "M(%d, %d) joins two blocks", i, j);
    else
      (*blocks)[home[b] + (size_t)p->at[j] * (size_t)p->size[b] + (size_t)p->at[i]] += M->value[k];
  }
  free(home);
  return status;
}

/* Symmetry. */

typedef struct entry {
  int row, column;
  double value, mirrored; /* sums at the place and at its mirror image */
} entry;

/* ---- symmetry */

static int compare_entries(const void *a, const void *b)
{
  const entry *x = a, *y = b;
  if (x->row != y->row) return x->row < y->row ? -1 : 1;
  return (x->column > y->column) - (x->column < y->column);
}

/* The largest difference of mirror images, of sorted entries of A and A^T, and the largest entry;
 * in rounding how much of it, at the most, a difference is of the root of its two diagonal entries.
 */
static double difference(size_t count, const entry *e, const double *diagonal, double *largest,
                         double *rounding)
{
  double worst = 0;
  for (size_t k = 0; k < count;) {
    double value = 0, mirrored = 0;
    size_t first = k;
    for (; k < count && compare_entries(&e[k], &e[first]) == 0; k++) {
      value += e[k].value;
      mirrored += e[k].mirrored;
    }
    double between = fabs(value - mirrored);
    double size = sqrt(fabs(diagonal[e[first].row])) * sqrt(fabs(diagonal[e[first].column]));
    *largest = fmax(*largest, fabs(value));
    worst = fmax(worst, between);
    if (between > 0) *rounding = fmax(*rounding, size > 0 ? between / size : INFINITY);
  }
  return worst;
}

/* How unsymmetric A is; 0 where it is by no more than rounding. */
static int measure_asymmetry(nsdae_h5 *h5, const nsdae_triplets *A, double *asymmetry)
{
  double largest = 0, rounding = 0;
  /* Sorted entries of A and of its transpose. */
  size_t count = (size_t)A->count;
  entry *e = calloc(2 * count + 1, sizeof *e);
  for (size_t k = 0; e && k < count; k++) {
    e[2 * k] = (entry){A->row[k], A->column[k], A->value[k], 0};
    e[2 * k + 1] = (entry){A->column[k], A->row[k], 0, A->value[k]};
  }
  if (e) qsort(e, 2 * count, sizeof *e, compare_entries);
  double *diagonal = calloc((size_t)A->rows + 1, sizeof *diagonal);
  int status = e && diagonal ? NSDAE_OK : nsdae_h5_no_memory(h5);
  for (int k = 0; k < A->count && status == NSDAE_OK; k++)
    if (A->row[k] == A->column[k]) diagonal[A->row[k]] += A->value[k];
  *asymmetry = 0;
  if (status == NSDAE_OK) {
    double worst = difference(2 * (size_t)A->count, e, diagonal, &largest, &rounding);
    if (rounding > ROUNDING) *asymmetry = worst / largest;
  }
  free(e);
  free(diagonal);
  return status;
}

int nsdae_symmetrise(nsdae_h5 *h5, nsdae_triplets *A, double *asymmetry)
{
  int count = A->count, status = measure_asymmetry(h5, A, asymmetry);
  if (status == NSDAE_OK) status = nsdae_triplets_grow(h5, A, count);
  for (int k = 0; k < count && status == NSDAE_OK; k++) {
    if (*asymmetry > 0) A->value[k] /= 2;
    /* else as it is, to the last bit, but both places stand there */
    nsdae_triplets_add(A, A->column[k], A->row[k], *asymmetry > 0 ? A->value[k] : 0);
  }
  return status;
}
