/* The analysis of sparse_kkt.h: the graph of S, its order of elimination, the backend. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include <nsdae/status.h>

#include "dynamic_array.h"
#include "sparse_kkt.h"

static int reserve(nsdae_kkt_pattern *p, const nsdae_kkt_part *part)
{
  int entries = part->J->first[part->J->count];
  int room = 2 + part->blocks->count + part->J->count + entries, numbers = part->blocks->count;
  const nsdae_array lists[] = {NSDAE_ARRAY(p->list, 1), NSDAE_ARRAY(p->next, 1)};
  const nsdae_array number[] = {NSDAE_ARRAY(p->number, 1)};
  int status = room > p->room ? nsdae_arrays_grow(lists, 2, (size_t)room) : NSDAE_OK;
  if (status < 0) return status;
  if (room > p->room) p->room = room;
  status = numbers > p->numbers ? nsdae_arrays_grow(number, 1, (size_t)numbers) : NSDAE_OK;
  if (status == NSDAE_OK && numbers > p->numbers) p->numbers = numbers;
  return status;
}

/* Into next; returns its length. */
static int write_pattern(nsdae_kkt_pattern *p, const nsdae_kkt_part *part)
{
  int used = 0;
  const nsdae_rows *J = part->J;
  p->next[used++] = part->block_count;
  p->next[used++] = part->row_count;
  for (int i = 0; i < part->block_count; i++) {
    p->number[part->block[i]] = i;
    p->next[used++] = nsdae_blocks_size(part->blocks, part->block[i]);
  }
  for (int i = 0; i < part->row_count; i++) {
    int row = part->row[i];
    p->next[used++] = J->first[row + 1] - J->first[row];
    for (int e = J->first[row]; e < J->first[row + 1]; e++)
      p->next[used++] = p->number[J->block[e]];
  }
  return used;
}

static void lay_out_part(void *object, nsdae_arena *arena)
{
  nsdae_sparse_kkt *k = object;
  nsdae_kkt_nodes *n = &k->nodes;
  nsdae_kkt_values *a = &k->at;
  long blocks = k->part.block_count, rows = k->part.row_count, parts = n->parts;
  long squares = 0, order = 0;
  for (int b = 0; b < blocks; b++) {
    long size = k->pattern.list[2 + b];
    order += size;
    squares += size * size;
  }
  int **by_row[] = {&n->row, &n->part, &n->size, &n->first, &n->mark};
  for (size_t i = 0; i < sizeof by_row / sizeof *by_row; i++)
    *by_row[i] = NSDAE_ARENA_INTS(arena, rows + 1);
  n->block = NSDAE_ARENA_INTS(arena, parts);
  n->of_block = NSDAE_ARENA_INTS(arena, parts);
  n->by_block = NSDAE_ARENA_INTS(arena, blocks + 2);
  n->at = nsdae_arena_take(arena, parts, sizeof *n->at);
  a->blocks.first = NSDAE_ARENA_INTS(arena, blocks + 1);
  a->blocks.square = nsdae_arena_take(arena, blocks + 1, sizeof *a->blocks.square);
  a->M = NSDAE_ARENA_DOUBLES(arena, squares);
  a->L = NSDAE_ARENA_DOUBLES(arena, squares);
  a->J = NSDAE_ARENA_DOUBLES(arena, n->values);
  a->Y = NSDAE_ARENA_DOUBLES(arena, n->values);
  double **by_velocity[] = {&a->x, &a->r, &a->g, &a->z, &a->size};
  for (size_t i = 0; i < sizeof by_velocity / sizeof *by_velocity; i++)
    *by_velocity[i] = NSDAE_ARENA_DOUBLES(arena, order);
  double **by_multiplier[] = {&a->l, &a->c, &a->d, &a->h, &a->u, &a->p};
  for (size_t i = 0; i < sizeof by_multiplier / sizeof *by_multiplier; i++)
    *by_multiplier[i] = NSDAE_ARENA_DOUBLES(arena, rows);
}

static void lay_out_graph(void *object, nsdae_arena *arena)
{
  nsdae_kkt_nodes *n = object;
  n->index = NSDAE_ARENA_INTS(arena, n->neighbours);
}

/* Entries and values of J. */
static void measure_rows(nsdae_sparse_kkt *k)
{
  const int *size = k->pattern.list + 2, *row = size + k->part.block_count;
  k->nodes.parts = 0;
  k->nodes.values = 0;
  for (int i = 0; i < k->part.row_count; i++, row += *row + 1) {
    k->nodes.parts += *row;
    for (int e = 1; e <= *row; e++) k->nodes.values += (size_t)size[row[e]];
  }
}

static void place_blocks(nsdae_sparse_kkt *k)
{
  nsdae_blocks *b = &k->at.blocks;
  b->count = k->part.block_count;
  b->first[0] = 0;
  b->square[0] = 0;
  for (int i = 0; i < b->count; i++) {
    int size = k->pattern.list[2 + i];
    b->first[i + 1] = b->first[i] + size;
    b->square[i + 1] = b->square[i] + (size_t)size * (size_t)size;
  }
}

static int same_blocks(const int *a, const int *b)
{
  return a[0] == b[0] && memcmp(a + 1, b + 1, (size_t)*a * sizeof *a) == 0;
}

static void find_nodes(nsdae_sparse_kkt *k)
{
  nsdae_kkt_nodes *n = &k->nodes;
  const int *row = k->pattern.list + 2 + k->part.block_count, *last = NULL;
  n->count = n->part[0] = 0;
  for (int i = 0; i < k->part.row_count; i++, last = row, row += *row + 1) {
    if (last && same_blocks(last, row)) continue;
    n->row[n->count] = i;
    memcpy(n->block + n->part[n->count], row + 1, (size_t)*row * sizeof *row);
    n->part[n->count + 1] = n->part[n->count] + *row;
    n->count++;
  }
  n->row[n->count] = k->part.row_count;
  size_t used = 0;
  for (int i = 0; i < n->count; i++) {
    n->size[i] = n->row[i + 1] - n->row[i];
    for (int p = n->part[i]; p < n->part[i + 1]; p++) {
      n->at[p] = used;
      used += (size_t)n->size[i] * (size_t)nsdae_blocks_size(&k->at.blocks, n->block[p]);
    }
  }
}

/* Nodes by the blocks that they touch. */
static void nodes_by_block(nsdae_sparse_kkt *k)
{
  nsdae_kkt_nodes *n = &k->nodes;
  memset(n->by_block, 0, ((size_t)k->part.block_count + 2) * sizeof *n->by_block);
  for (int p = 0; p < n->part[n->count]; p++) n->by_block[n->block[p] + 2]++;
  for (int b = 0; b < k->part.block_count; b++) n->by_block[b + 2] += n->by_block[b + 1];
  for (int i = 0; i < n->count; i++)
    for (int p = n->part[i]; p < n->part[i + 1]; p++)
      n->of_block[n->by_block[n->block[p] + 1]++] = i;
}

int nsdae_kkt_ascending(const void *a, const void *b)
{
  int x = *(const int *)a, y = *(const int *)b;
  return (x > y) - (x < y);
}

/* Lists the neighbours of all nodes, those that share a block with it; index NULL: counts them. */
static int list_neighbours(nsdae_kkt_nodes *n, int *index)
{
  int count = 0;
  for (int i = 0; i < n->count; i++) n->mark[i] = -1;
  for (int i = 0; i < n->count; i++) {
    n->first[i] = count;
    n->mark[i] = i;
    for (int p = n->part[i]; p < n->part[i + 1]; p++)
      for (int e = n->by_block[n->block[p]]; e < n->by_block[n->block[p] + 1]; e++) {
        int other = n->of_block[e];
        if (n->mark[other] == i) continue;
        n->mark[other] = i;
        if (index) index[count] = other;
        count++;
      }
    if (index)
      qsort(index + n->first[i], (size_t)(count - n->first[i]), sizeof *index, nsdae_kkt_ascending);
  }
  n->first[n->count] = count;
  return count;
}

/* Predicted time of the fronts, in multiplications of LDL: 600 for each front, and an eighth for
 * each of LAPACK's. Half or twice of either number makes no member of bench_chains slower by more
 * than 15 %. */
static double work_of_fronts(const nsdae_supernodes *s)
{
  double work = 0;
  for (int i = 0; i < s->count; i++) {
    double p = s->pivots[i], r = s->rest[i];
    work += 600 + p * (p * p / 6 + p * r / 2 + r * r / 2) / 8;
  }
  return work;
}

/* Fronts of two signs are factored in runs of a few columns: twice the time (chains, trees). */
static const double SIGNED = 2;

int nsdae_sparse_kkt_choose(const nsdae_sparse_kkt *k, const nsdae_multifrontal *f,
                            nsdae_sparse_ldl *ldl, int *by_ldl)
{
  double entries = k->backend == NSDAE_KKT_SCHUR ? HUGE_VAL : nsdae_sparse_ldl_work(f);
  double fronts = k->backend == NSDAE_KKT_LDL ? HUGE_VAL : work_of_fronts(&f->super);
  if (f->negative > 0) fronts *= SIGNED;
  *by_ldl = entries < fronts;
  return *by_ldl ? nsdae_sparse_ldl_analyse(ldl, f) : NSDAE_OK;
}

static int analyse(nsdae_sparse_kkt *k)
{
  nsdae_kkt_nodes *n = &k->nodes;
  measure_rows(k);
  if (nsdae_arena_fit(&k->pattern.memory, lay_out_part, k) != NSDAE_OK) return NSDAE_E_MEMORY;
  place_blocks(k);
  find_nodes(k);
  nodes_by_block(k);
  n->neighbours = list_neighbours(n, NULL);
  if (nsdae_arena_fit(&k->nodes.memory, lay_out_graph, n) != NSDAE_OK) return NSDAE_E_MEMORY;
  list_neighbours(n, n->index);
  int status = nsdae_multifrontal_analyse(&k->schur, n->count, n->size, n->first, n->index);
  return status < 0 ? status : nsdae_sparse_kkt_choose(k, &k->schur, &k->ldl, &k->ldl_first);
}

int nsdae_sparse_kkt_analyse(nsdae_sparse_kkt *k, const nsdae_kkt_part *part)
{
  nsdae_kkt_pattern *p = &k->pattern;
  if (reserve(p, part) != NSDAE_OK) return NSDAE_E_MEMORY;
  int used = write_pattern(p, part);
  k->part = *part;
  if (k->ready && used == p->used && memcmp(p->list, p->next, (size_t)used * sizeof *p->list) == 0)
    return NSDAE_OK;
  int *list = p->list;
  p->list = p->next;
  p->next = list;
  p->used = used;
  k->whole.ready = 0;
  int status = analyse(k);
  k->ready = status == NSDAE_OK;
  return status;
}

void nsdae_sparse_kkt_release(nsdae_sparse_kkt *k)
{
  nsdae_kkt_pattern *p = &k->pattern;
  const nsdae_array all[] = {NSDAE_ARRAY(p->list, 1), NSDAE_ARRAY(p->next, 1),
                             NSDAE_ARRAY(p->number, 1)};
  nsdae_arrays_release(all, sizeof all / sizeof *all);
  nsdae_arena_release(&k->pattern.memory);
  nsdae_arena_release(&k->nodes.memory);
  nsdae_multifrontal_release(&k->schur);
  nsdae_sparse_ldl_release(&k->ldl);
  nsdae_multifrontal_release(&k->whole.fronts);
  nsdae_sparse_ldl_release(&k->whole.ldl);
  nsdae_arena_release(&k->whole.arena);
}
