#include "block_list.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "arena.h"
#include "errors.h"

/* ---- the pattern */

int nsdae_block_pairs_make(nsdae_block_pairs *p, int blocks)
{
  const nsdae_array first[] = {NSDAE_ARRAY(p->first, 1)};
  p->blocks = blocks;
  if (nsdae_arrays_grow(first, 1, (size_t)blocks + 1) < 0) return NSDAE_E_MEMORY;
  memset(p->first, 0, ((size_t)blocks + 1) * sizeof *p->first);
  return NSDAE_OK;
}

void nsdae_block_pairs_release(nsdae_block_pairs *p)
{
  const nsdae_array all[] = {NSDAE_ARRAY(p->first, 1), NSDAE_ARRAY(p->pair, 2),
                             NSDAE_ARRAY(p->at, 1),    NSDAE_ARRAY(p->neighbour, 2),
                             NSDAE_ARRAY(p->slot, 2),  NSDAE_ARRAY(p->missing, 2),
                             NSDAE_ARRAY(p->value, 1)};
  nsdae_arrays_release(all, sizeof all / sizeof *all);
  *p = (nsdae_block_pairs){0};
}

int nsdae_block_pairs_find(nsdae_block_pairs *p, int i, int j)
{
  int row = i > j ? i : j, column = i > j ? j : i;
  int low = p->first[row], high = p->first[row + 1];
  while (low < high) {
    int middle = low + (high - low) / 2;
    if (p->neighbour[middle] == column) return p->slot[middle];
    if (p->neighbour[middle] < column)
      low = middle + 1;
    else
      high = middle;
  }
  if (p->missed < p->room) {
    p->missing[2 * p->missed] = row;
    p->missing[2 * p->missed + 1] = column;
  }
  p->missed++;
  return -1;
}

static int by_row(const void *a, const void *b)
{
  const int *p = a, *q = b;
  return p[0] != q[0] ? (p[0] > q[0]) - (p[0] < q[0]) : (p[1] > q[1]) - (p[1] < q[1]);
}

/* Neighbours of every block from the pairs: those below it first, so that each list ascends. */
static void list_neighbours(nsdae_block_pairs *p)
{
  memset(p->first, 0, ((size_t)p->blocks + 1) * sizeof *p->first);
  for (int e = 0; e < 2 * p->count; e++) p->first[p->pair[e] + 1]++;
  for (int b = 0; b < p->blocks; b++) p->first[b + 1] += p->first[b];
  for (int side = 0; side < 2; side++)
    for (int e = 0; e < p->count; e++) {
      int to = p->first[p->pair[2 * e + side]]++;
      p->neighbour[to] = p->pair[2 * e + 1 - side];
      p->slot[to] = e;
    }
  for (int b = p->blocks; b > 0; b--) p->first[b] = p->first[b - 1];
  p->first[0] = 0;
}

static size_t pair_values(const nsdae_block_pairs *p, const nsdae_blocks *blocks, int e)
{
  return (size_t)nsdae_blocks_size(blocks, p->pair[2 * e]) *
         (size_t)nsdae_blocks_size(blocks, p->pair[2 * e + 1]);
}

int nsdae_block_pairs_grow(nsdae_block_pairs *p, const nsdae_blocks *blocks)
{
  int recorded = p->missed < p->room ? p->missed : p->room, total = p->count + recorded;
  const nsdae_array each[] = {NSDAE_ARRAY(p->pair, 2), NSDAE_ARRAY(p->at, 1),
                              NSDAE_ARRAY(p->neighbour, 2), NSDAE_ARRAY(p->slot, 2)};
  const nsdae_array missing[] = {NSDAE_ARRAY(p->missing, 2)}, value[] = {NSDAE_ARRAY(p->value, 1)};
  /* ---- room for all, before the pattern changes */
  if (nsdae_arrays_grow(each, 4, (size_t)total) < 0) return NSDAE_E_MEMORY;
  if (recorded > 0) memcpy(p->pair + 2 * p->count, p->missing, 2 * sizeof(int) * (size_t)recorded);
  size_t values = 0;
  for (int e = 0; e < total; e++) values += pair_values(p, blocks, e);
  if (nsdae_arrays_grow(value, 1, values) < 0) return NSDAE_E_MEMORY;
  if (p->missed > p->room) {
    if (nsdae_arrays_grow(missing, 1, (size_t)p->missed) < 0) return NSDAE_E_MEMORY;
    p->room = p->missed;
  }
  p->missed = 0;
  /* ---- the union, in ascending order */
  if (total > 0) qsort(p->pair, (size_t)total, 2 * sizeof(int), by_row);
  p->count = 0;
  for (int e = 0; e < total; e++) {
    int *last = p->pair + 2 * p->count;
    if (p->count > 0 && by_row(p->pair + 2 * e, last - 2) == 0) continue;
    memmove(last, p->pair + 2 * e, 2 * sizeof(int));
    p->count++;
  }
  p->values = 0;
  for (int e = 0; e < p->count; e++) {
    p->at[e] = p->values;
    p->values += pair_values(p, blocks, e);
  }
  list_neighbours(p);
  return NSDAE_OK;
}

/* ---- the list */

static int refuse_block(nsdae_block_list *l, int status, const char *argument, int row, int column,
                        const char *why)
{
  if (l->status < 0) return status; /* the first is reported */
  l->status = status;
  nsdae_error_set(l->error, status, "nsdae_block_add", argument, "%s: block (%d, %d): %s",
                  l->callback, row, column, why);
  return status;
}

int nsdae_block_add(nsdae_block_list *l, int row, int column, const double *value)
{
  if (!l) return NSDAE_E_ARGUMENT;
  const nsdae_blocks *blocks = &l->system->blocks;
  if (row < 0 || row >= blocks->count || column < 0 || column >= blocks->count)
    return refuse_block(l, NSDAE_E_ARGUMENT, row < 0 || row >= blocks->count ? "row" : "column",
                        row, column, "there is no such block");
  if (!value) return refuse_block(l, NSDAE_E_ARGUMENT, "value", row, column, "value is NULL");
  int size = nsdae_blocks_size(blocks, row) * nsdae_blocks_size(blocks, column);
  for (int i = 0; i < size; i++)
    if (!isfinite(value[i]))
      return refuse_block(l, NSDAE_E_NONFINITE, "value", row, column, "an entry is not finite");
  const int *first = blocks->first;
  for (int j = first[column]; l->x && j < first[column + 1]; j++) /* product += X_ij x_j */
    for (int i = first[row]; i < first[row + 1]; i++) l->product[i] += *value++ * l->x[j];
  if (l->x) return NSDAE_OK;
  size_t m = (size_t)nsdae_blocks_size(blocks, row), n = (size_t)nsdae_blocks_size(blocks, column);
  double half = l->scale / 2;
  if (row == column) { /* A_bb += scale (X + X^T) / 2 */
    double *A = l->diagonal + blocks->square[row];
    for (size_t j = 0; j < n; j++)
      for (size_t i = 0; i < n; i++) A[i + j * n] += half * (value[i + j * n] + value[j + i * n]);
    return NSDAE_OK;
  }
  /* A_ij of i > j takes half of X_ij, or half of X_ji transposed. */
  int e = nsdae_block_pairs_find(l->pairs, row, column);
  double *A = e < 0 ? NULL : l->pairs->value + l->pairs->at[e];
  for (size_t j = 0; j < n && A; j++)
    for (size_t i = 0; i < m; i++) A[row > column ? i + j * m : j + i * n] += half * *value++;
  return NSDAE_OK;
}
