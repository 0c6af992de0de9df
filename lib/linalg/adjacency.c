#include "adjacency.h"

#include <nsdae/status.h>
#include <string.h>

static void lay_out_lists(void *object, nsdae_arena *arena)
{
  nsdae_adjacency *g = object;
  g->first = NSDAE_ARENA_INTS(arena, g->n + 2L);
  g->mark = NSDAE_ARENA_INTS(arena, g->n);
  g->by_entry = NSDAE_ARENA_INTS(arena, g->entries + 2L);
  g->list = NSDAE_ARENA_INTS(arena, g->joined);
}

static void lay_out_edges(void *object, nsdae_arena *arena)
{
  nsdae_adjacency *g = object;
  g->index = NSDAE_ARENA_INTS(arena, g->first[g->n + 1]);
}

/* begin [n + 2] with counts from 2 on: those of i begin at begin[i + 1], which then goes to their
 * end (counting sort). */
static void add_counts(int n, int *begin)
{
  for (int i = 0; i < n; i++) begin[i + 2] += begin[i + 1];
}

/* Counts the neighbours of each node (index NULL), or enters each node for its neighbours: in turn,
 * so that their lists ascend. */
static void visit(const nsdae_adjacency *g, const nsdae_joined *of, const nsdae_joined *back,
                  int *at, int *index)
{
  for (int i = 0; i < g->n; i++) g->mark[i] = -1;
  for (int i = 0; i < g->n; i++) {
    g->mark[i] = i;
    for (int e = of->first[i]; e < of->first[i + 1]; e++)
      for (int k = back->first[of->entry[e]]; k < back->first[of->entry[e] + 1]; k++) {
        int other = back->entry[k];
        if (g->mark[other] == i) continue;
        g->mark[other] = i;
        if (index) index[at[other]] = i;
        at[other]++;
      }
  }
}

int nsdae_adjacency_build(nsdae_adjacency *g, const nsdae_joined *lists, int entries, int of_lists)
{
  g->n = of_lists ? lists->count : entries;
  g->entries = entries;
  g->joined = lists->first[lists->count];
  if (nsdae_arena_fit(&g->of_lists, lay_out_lists, g) != NSDAE_OK) return NSDAE_E_MEMORY;
  memset(g->by_entry, 0, ((size_t)entries + 2) * sizeof *g->by_entry);
  for (int e = 0; e < g->joined; e++) g->by_entry[lists->entry[e] + 2]++;
  add_counts(entries, g->by_entry);
  for (int i = 0; i < lists->count; i++)
    for (int e = lists->first[i]; e < lists->first[i + 1]; e++)
      g->list[g->by_entry[lists->entry[e] + 1]++] = i;
  const nsdae_joined back = {entries, g->by_entry, g->list};
  const nsdae_joined *of = of_lists ? lists : &back, *other = of_lists ? &back : lists;
  memset(g->first, 0, ((size_t)g->n + 2) * sizeof *g->first);
  visit(g, of, other, g->first + 2, NULL);
  add_counts(g->n, g->first);
  if (nsdae_arena_fit(&g->of_edges, lay_out_edges, g) != NSDAE_OK) return NSDAE_E_MEMORY;
  visit(g, of, other, g->first + 1, g->index);
  return NSDAE_OK;
}

void nsdae_adjacency_release(nsdae_adjacency *g)
{
  nsdae_arena_release(&g->of_lists);
  nsdae_arena_release(&g->of_edges);
}
