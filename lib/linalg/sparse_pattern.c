/* The analysis of sparse_kkt.h: the graph of S, its order of elimination. */
#include <string.h>

#include <nsdae/status.h>

#include "dynamic_array.h"
#include "sparse_kkt.h"

/* Enters a number of the pattern; returns whether it was there. */
static int put(nsdae_kkt_pattern *p, int *at, int value)
{
  int same = *at < p->used && p->list[*at] == value;
  p->list[(*at)++] = value;
  return same;
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
  nsdae_arena_ints(arena, rows + 1, (int **[]){&n->row, &n->part, &n->size, &n->of_row, NULL});
  n->block = NSDAE_ARENA_INTS(arena, parts);
  n->at = nsdae_arena_take(arena, parts, sizeof *n->at);
  a->blocks.first = NSDAE_ARENA_INTS(arena, blocks + 1);
  a->blocks.square = nsdae_arena_take(arena, blocks + 1, sizeof *a->blocks.square);
  nsdae_arena_doubles(arena, squares, (double **[]){&a->M, &a->L, NULL});
  nsdae_arena_doubles(arena, (long)n->values, (double **[]){&a->J, &a->Y, NULL});
  nsdae_arena_doubles(arena, order, (double **[]){&a->x, &a->r, &a->g, &a->z, &a->size, NULL});
  nsdae_arena_doubles(arena, rows, (double **[]){&a->l, &a->c, &a->d, &a->h, &a->u, &a->p, NULL});
}

static void find_nodes(nsdae_sparse_kkt *k)
{
  nsdae_kkt_nodes *n = &k->nodes;
  const int *row = k->pattern.list + 2 + k->part.block_count, *last = NULL;
  n->count = n->part[0] = 0;
  for (int i = 0; i < k->part.row_count; i++, last = row, row += *row + 1) {
    n->of_row[i] = n->count - 1;
    if (last && *last == *row && memcmp(last, row, ((size_t)*row + 1) * sizeof *row) == 0) continue;
    n->of_row[i] = n->count;
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

static int analyse(nsdae_sparse_kkt *k)
{
  nsdae_kkt_nodes *n = &k->nodes;
  nsdae_blocks *b = &k->at.blocks;
  /* ---- entries and values of J */
  const int *size = k->pattern.list + 2, *row = size + k->part.block_count;
  n->parts = 0;
  n->values = 0;
  for (int i = 0; i < k->part.row_count; i++, row += *row + 1) {
    n->parts += *row;
    for (int e = 1; e <= *row; e++) n->values += (size_t)size[row[e]];
  }
  if (nsdae_arena_fit(&k->pattern.memory, lay_out_part, k) != NSDAE_OK) return NSDAE_E_MEMORY;
  b->count = k->part.block_count;
  b->first[0] = 0;
  b->square[0] = 0;
  for (int i = 0; i < b->count; i++) {
    b->first[i + 1] = b->first[i] + size[i];
    b->square[i + 1] = b->square[i] + (size_t)size[i] * (size_t)size[i];
  }
  find_nodes(k);
  const nsdae_joined touched = {n->count, n->part, n->block};
  int status = nsdae_adjacency_build(&k->graph, &touched, k->part.block_count, 1);
  return status < 0 ? status
                    : nsdae_multifrontal_analyse(&k->schur, n->count, n->size, k->graph.first,
                                                 k->graph.index);
}

int nsdae_sparse_kkt_analyse(nsdae_sparse_kkt *k, const nsdae_kkt_part *part)
{
  nsdae_kkt_pattern *p = &k->pattern;
  int room = 2 + part->blocks->count + part->J->count + part->J->first[part->J->count];
  const nsdae_array lists[] = {NSDAE_ARRAY(p->list, 1), NSDAE_ARRAY(p->number, 1)};
  if (room > p->room && nsdae_arrays_grow(lists, 2, (size_t)room) < 0) return NSDAE_E_MEMORY;
  if (room > p->room) p->room = room;
  k->part = *part;
  /* ---- the pattern; same: it is that of the last call */
  int at = 0, same = put(p, &at, part->block_count);
  const nsdae_rows *J = part->J;
  same &= put(p, &at, part->row_count);
  for (int i = 0; i < part->block_count; i++) {
    p->number[part->block[i]] = i;
    same &= put(p, &at, nsdae_blocks_size(part->blocks, part->block[i]));
  }
  for (int i = 0; i < part->row_count; i++) {
    int row = part->row[i];
    same &= put(p, &at, J->first[row + 1] - J->first[row]);
    for (int e = J->first[row]; e < J->first[row + 1]; e++)
      same &= put(p, &at, p->number[J->block[e]]);
  }
  p->used = at;
  if (same && k->ready) return NSDAE_OK;
  k->whole.ready = 0;
  int status = analyse(k);
  k->ready = status == NSDAE_OK;
  return status;
}

void nsdae_sparse_kkt_release(nsdae_sparse_kkt *k)
{
  nsdae_kkt_pattern *p = &k->pattern;
  const nsdae_array all[] = {NSDAE_ARRAY(p->list, 1), NSDAE_ARRAY(p->number, 1)};
  nsdae_arrays_release(all, 2);
  nsdae_arena_release(&k->pattern.memory);
  nsdae_adjacency_release(&k->graph);
  nsdae_multifrontal_release(&k->schur);
  nsdae_multifrontal_release(&k->whole.fronts);
  nsdae_adjacency_release(&k->whole.graph);
  nsdae_arena_release(&k->whole.arena);
}
