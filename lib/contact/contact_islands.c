#include "contact_islands.h"

#include <string.h>

#include "disjoint_sets.h"

void nsdae_contact_islands_layout(nsdae_contact_islands *islands, nsdae_arena *arena)
{
  long blocks = islands->blocks;
  islands->of = NSDAE_ARENA_INTS(arena, blocks);
  islands->parent = NSDAE_ARENA_INTS(arena, blocks);
  islands->block.first = NSDAE_ARENA_INTS(arena, blocks + 2);
  islands->block.of = NSDAE_ARENA_INTS(arena, blocks);
  islands->contact.first = NSDAE_ARENA_INTS(arena, blocks + 2);
  islands->row.first = NSDAE_ARENA_INTS(arena, blocks + 2);
  islands->row.of = NSDAE_ARENA_INTS(arena, islands->rows);
}

/* -1: in no set yet. */
static void join(int *parent, int a, int b)
{
  if (parent[a] < 0) parent[a] = a;
  if (parent[b] < 0) parent[b] = b;
  nsdae_sets_join(parent, a, b);
}

static int anchor(const int *pair)
{
  return pair[0] >= 0 ? pair[0] : pair[1];
}

static int join_all(nsdae_contact_islands *is, int contacts, const int *pair,
                    const nsdae_rows *rows)
{
  memset(is->parent, -1, (size_t)is->blocks * sizeof *is->parent);
  for (int a = 0; a < contacts; a++) {
    const int *p = pair + 2 * (size_t)a;
    join(is->parent, anchor(p), p[1] >= 0 ? p[1] : p[0]);
  }
  for (int i = 0; i < is->rows; i++) {
    if (rows->first[i] == rows->first[i + 1]) return i;
    for (int p = rows->first[i]; p < rows->first[i + 1]; p++)
      join(is->parent, rows->block[rows->first[i]], rows->block[p]);
  }
  return -1;
}

static void number(nsdae_contact_islands *is)
{
  is->count = 0;
  for (int b = 0; b < is->blocks; b++) {
    int root = is->parent[b] < 0 ? -1 : nsdae_sets_root(is->parent, b);
    is->of[b] = root < 0 ? -1 : root == b ? is->count++ : is->of[root];
  }
}

/* Lists members by counting: block_of says a block of member i, whose island is meant. */
static void list_members(nsdae_contact_islands *is, nsdae_members *m, int count,
                         int (*block_of)(const void *from, int i), const void *from)
{
  memset(m->first, 0, ((size_t)is->count + 2) * sizeof *m->first);
  for (int i = 0; i < count; i++) {
    int island = is->of[block_of(from, i)];
    if (island >= 0) m->first[island + 2]++;
  }
  for (int i = 0; i < is->count; i++) m->first[i + 2] += m->first[i + 1];
  for (int i = 0; i < count; i++) {
    int island = is->of[block_of(from, i)];
    if (island >= 0) m->of[m->first[island + 1]++] = i;
  }
}

static int itself(const void *from, int i)
{
  (void)from;
  return i;
}

static int block_of_pair(const void *pairs, int i)
{
  return anchor((const int *)pairs + 2 * (size_t)i);
}

static int block_of_row(const void *rows, int i)
{
  const nsdae_rows *r = rows;
  return r->block[r->first[i]];
}

int nsdae_contact_islands_find(nsdae_contact_islands *is, int contacts, const int *pair,
                               const nsdae_rows *rows)
{
  int loose = join_all(is, contacts, pair, rows);
  if (loose >= 0) return loose;
  number(is);
  list_members(is, &is->block, is->blocks, itself, NULL);
  list_members(is, &is->contact, contacts, block_of_pair, pair);
  list_members(is, &is->row, is->rows, block_of_row, rows);
  return -1;
}
