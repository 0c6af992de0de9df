#include "to_blocks.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "disjoint_sets.h"

enum { MOST = 256 }; /* numbers for each entry, row and column */

/* Of the root of its two diagonal entries, a difference of W_ij and W_ji that is rounding. */
static const double ROUNDING = 1e-12;

/* ---- partitions */

int nsdae_partition_create(nsdae_h5 *h5, int n, int parts, nsdae_partition *p)
{
  *p = (nsdae_partition){.n = n, .parts = parts};
  p->of = nsdae_h5_allocate(h5, (size_t)n, sizeof *p->of);
  p->at = nsdae_h5_allocate(h5, (size_t)n, sizeof *p->at);
  p->size = nsdae_h5_allocate(h5, (size_t)n, sizeof *p->size);
  return h5->status;
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
  for (int i = 0; i < p->n; i++) p->at[i] = p->size[p->of[i]]++;
}

void nsdae_partition_make(nsdae_h5 *h5, int n, int parts, const int *size, nsdae_partition *p)
{
  int i = 0;
  nsdae_partition_create(h5, n, parts, p);
  for (int k = 0; k < parts && h5->status == NSDAE_OK; k++) {
    if (size[k] < 1 || size[k] > n - i)
      nsdae_h5_refuse(h5, "read", "part %d has %d of %d rows, of which %d are left", k, size[k], n,
                      n - i);
    for (int end = i + size[k]; h5->status == NSDAE_OK && i < end; i++) p->of[i] = k;
  }
  if (i < n) nsdae_h5_refuse(h5, "read", "its parts have %d of %d rows", i, n);
  if (h5->status == NSDAE_OK) count_places(p);
}

/* Whether every entry stays in a part of that size. */
static int all_alike(const nsdae_triplets *M, int alike)
{
  if (M->rows % alike != 0) return 0;
  for (int k = 0; k < M->count; k++)
    if (M->row[k] / alike != M->column[k] / alike) return 0;
  return 1;
}

void nsdae_partition_find(nsdae_h5 *h5, const nsdae_triplets *M, int alike, nsdae_partition *p)
{
  if (nsdae_partition_create(h5, M->rows, 0, p) < 0) return;
  int same = all_alike(M, alike);
  for (int i = 0; i < p->n; i++) p->of[i] = same ? i - i % alike : i;
  for (int k = 0; k < M->count; k++) nsdae_sets_join(p->of, M->row[k], M->column[k]);
  for (int i = 0; i < p->n; i++) { /* roots come before what they hold */
    int root = nsdae_sets_root(p->of, i);
    p->at[i] = root == i ? p->parts++ : p->at[root];
  }
  memcpy(p->of, p->at, (size_t)p->n * sizeof *p->of);
  count_places(p);
}

/* ---- entries by item and block */

/* Lists of the entries 0 .. count - 1 of each of n parts, in ascending order: the first of part i
 * is first[i], the one after entry k next[k] with next = first + n, -1: none. The part of entry k
 * is index[k], or of[index[k]]. */
static int *list_entries(nsdae_h5 *h5, int n, int count, const int *index, const int *of)
{
  int *first = nsdae_h5_allocate(h5, (size_t)n + (size_t)count, sizeof *first);
  int *next = first ? first + n : NULL;
  for (int i = 0; first && i < n; i++) first[i] = -1;
  for (int k = count; first && k-- > 0;) {
    int part = of ? of[index[k]] : index[k];
    if (part < 0) continue;
    next[k] = first[part];
    first[part] = k;
  }
  return first;
}

static void check_numbers(nsdae_h5 *h5, const nsdae_triplets *A, size_t numbers)
{
  if ((double)numbers <= MOST * ((double)A->count + A->rows + A->columns)) return;
  nsdae_h5_refuse(h5, "read",
                  "its blocks would take %.3g numbers for %d entries: too few of them are not zero",
                  (double)numbers, A->count);
}

/* The blocks of each item into first and block, and the place of each entry in their values;
 * returns how many values there are. */
static size_t place_entries(nsdae_h5 *h5, const nsdae_triplets *A, const nsdae_partition *rows,
                            const nsdae_partition *items, int *first, int *block, size_t *place)
{
  int blocks = 0, n = items->parts;
  size_t numbers = 0;
  int *list = list_entries(h5, n, A->count, A->column, items->of), *next = list ? list + n : NULL;
  int *stamp = nsdae_h5_allocate(h5, (size_t)rows->parts, sizeof *stamp); /* 1 + last item */
  size_t *home = nsdae_h5_allocate(h5, (size_t)rows->parts, sizeof *home);
  for (int i = 0; i < n && h5->status == NSDAE_OK; i++) {
    for (int k = list[i]; k >= 0; k = next[k]) {
      int row = A->row[k], b = rows->of[row];
      if (b < 0) continue;
      size_t size = (size_t)rows->size[b];
      if (stamp[b] != i + 1) {
        stamp[b] = i + 1;
        home[b] = numbers;
        block[blocks++] = b;
        numbers += size * (size_t)items->size[i];
      }
      place[k] = home[b] + (size_t)items->at[A->column[k]] * size + (size_t)rows->at[row];
    }
    first[i + 1] = blocks;
  }
  free(list);
  free(stamp);
  free(home);
  return numbers;
}

void nsdae_to_blocks(nsdae_h5 *h5, const nsdae_triplets *A, const nsdae_partition *rows,
                     const nsdae_partition *items, nsdae_friction_problem *problem)
{
  /* What belongs to no part must be zero: rows of zeros that stand for none. */
  for (int k = 0; k < A->count && h5->status == NSDAE_OK; k++)
    if (A->value[k] != 0 && (rows->of[A->row[k]] < 0 || items->of[A->column[k]] < 0))
      nsdae_h5_refuse(h5, "read", "entry (%d, %d) = %g is in a row that its contact does not have",
                      A->row[k], A->column[k], A->value[k]);
  int *first = nsdae_h5_allocate(h5, (size_t)items->parts, sizeof *first);
  int *block = nsdae_h5_allocate(h5, (size_t)A->count, sizeof *block);
  size_t *place = nsdae_h5_allocate(h5, (size_t)A->count, sizeof *place);
  size_t numbers = place_entries(h5, A, rows, items, first, block, place);
  check_numbers(h5, A, numbers);
  double *value = nsdae_h5_allocate(h5, numbers, sizeof *value);
  for (int k = 0; value && k < A->count; k++) value[place[k]] += A->value[k];
  free(place);
  problem->first = first;
  problem->block = block;
  problem->value = value;
}

/* ---- block-diagonal matrices */

double *nsdae_to_blocks_diagonal(nsdae_h5 *h5, const nsdae_triplets *M, const nsdae_partition *p)
{
  size_t numbers = 0, *home = nsdae_h5_allocate(h5, (size_t)p->parts, sizeof *home);
  for (int b = 0; home && b < p->parts; b++) {
    home[b] = numbers;
    numbers += (size_t)p->size[b] * (size_t)p->size[b];
  }
  check_numbers(h5, M, numbers);
  double *blocks = nsdae_h5_allocate(h5, numbers, sizeof *blocks);
  for (int k = 0; k < M->count && h5->status == NSDAE_OK; k++) {
    int i = M->row[k], j = M->column[k], b = p->of[i];
    if (p->of[j] != b)
      nsdae_h5_refuse(h5, "read", "M(%d, %d) joins two blocks", i, j);
    else
      blocks[home[b] + (size_t)p->at[j] * (size_t)p->size[b] + (size_t)p->at[i]] += M->value[k];
  }
  free(home);
  return blocks;
}

/* ---- symmetry */

/* x, y := sums of column j and of row j. Of each place in the column the entry, and the difference
 * of mirror images, make the largest ones greater; in most[2] the difference over the root of the
 * two diagonal entries. */
static void compare_column(const nsdae_triplets *A, int j, const int *column, const int *row,
                           double *x, double most[3])
{
  double *y = x + A->rows, *diagonal = y + A->rows;
  const int *below = column + A->rows, *right = row + A->rows;
  for (int k = column[j]; k >= 0; k = below[k]) x[A->row[k]] += A->value[k];
  for (int k = row[j]; k >= 0; k = right[k]) y[A->column[k]] += A->value[k];
  for (int k = column[j]; k >= 0; k = below[k]) {
    int i = A->row[k];
    double between = fabs(x[i] - y[i]), size = sqrt(fabs(diagonal[i])) * sqrt(fabs(diagonal[j]));
    most[0] = fmax(most[0], fabs(x[i]));
    most[1] = fmax(most[1], between);
    if (between > 0) most[2] = fmax(most[2], size > 0 ? between / size : INFINITY);
  }
  for (int k = column[j]; k >= 0; k = below[k]) x[A->row[k]] = 0;
  for (int k = row[j]; k >= 0; k = right[k]) y[A->column[k]] = 0;
}

double nsdae_symmetrise(nsdae_h5 *h5, nsdae_triplets *A)
{
  int count = A->count, n = A->rows;
  double most[3] = {0};
  int *column = list_entries(h5, n, count, A->column, NULL);
  int *row = list_entries(h5, n, count, A->row, NULL);
  double *x = nsdae_h5_allocate(h5, 3 * (size_t)n, sizeof *x); /* x, y and the diagonal */
  for (int k = 0; x && k < count; k++)
    if (A->row[k] == A->column[k]) x[2 * (size_t)n + (size_t)A->row[k]] += A->value[k];
  for (int j = 0; x && j < n; j++) compare_column(A, j, column, row, x, most);
  free(column);
  free(row);
  free(x);
  double asymmetry = most[2] > ROUNDING ? most[1] / most[0] : 0;
  nsdae_triplets_grow(h5, A, count);
  for (int k = 0; k < count && h5->status == NSDAE_OK; k++) {
    if (asymmetry > 0) A->value[k] /= 2;
    /* else as it is, to the last bit, but both places stand there */
    nsdae_triplets_add(A, A->column[k], A->row[k], asymmetry > 0 ? A->value[k] : 0);
  }
  return asymmetry;
}
