#include "symbolic.h"

#include <amd.h>
#include <nsdae/status.h>
#include <string.h>

/* ---- adjacency */

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

static void lay_out_nodes(void *object, nsdae_arena *arena)
{
  nsdae_symbolic *e = object;
  nsdae_arena_ints(arena, e->n, (int **[]){&e->node, &e->number, &e->parent, &e->count, NULL});
  e->start = nsdae_arena_take(arena, e->n + 1L, sizeof(size_t));
  e->work = NSDAE_ARENA_INTS(arena, 3L * e->n);
}

static void lay_out_rows(void *object, nsdae_arena *arena)
{
  nsdae_symbolic *e = object;
  e->row = NSDAE_ARENA_INTS(arena, e->start[e->n]);
}

/* Of number i, every neighbour that goes before it: visit(k) for all k on the paths from those
 * towards i in the tree, each once; the rows of L are these subtrees. With the tree unknown yet
 * (ancestor not NULL) it is built by the way, with paths compressed. */
static void build_tree(nsdae_symbolic *e)
{
  int *ancestor = e->work;
  for (int i = 0; i < e->n; i++) {
    e->parent[i] = ancestor[i] = e->n;
    for (int a = e->first[e->node[i]]; a < e->first[e->node[i] + 1]; a++) {
      int k = e->number[e->index[a]];
      while (k < i) {
        int next = ancestor[k];
        ancestor[k] = i;
        if (next == e->n) e->parent[k] = i;
        if (next >= i) break;
        k = next;
      }
    }
  }
}

/* Counts (row NULL) or lists the entries of all columns. */
static void list_rows(nsdae_symbolic *e, int *row)
{
  int *mark = e->work;
  for (int k = 0; k < e->n; k++) {
    mark[k] = -1;
    e->count[k] = 0;
  }
  for (int i = 0; i < e->n; i++) {
    mark[i] = i;
    for (int a = e->first[e->node[i]]; a < e->first[e->node[i] + 1]; a++)
      for (int k = e->number[e->index[a]]; k < i && mark[k] != i; k = e->parent[k]) {
        mark[k] = i;
        if (row) row[e->start[k] + (size_t)e->count[k]] = i;
        e->count[k]++;
      }
  }
}

/* Children before their parent and next to it, so that what they leave can lie on a stack. */
static void postorder(nsdae_symbolic *e)
{
  int n = e->n, *child = e->work, *sibling = child + n, *stack = sibling + n, placed = 0;
  for (int k = 0; k < n; k++) child[k] = -1;
  for (int k = n - 1; k >= 0; k--)
    if (e->parent[k] < n) {
      sibling[k] = child[e->parent[k]];
      child[e->parent[k]] = k;
    }
  for (int root = 0; root < n; root++) {
    int top = 0;
    if (e->parent[root] < n) continue;
    stack[top++] = root;
    while (top > 0) {
      int k = stack[top - 1];
      if (child[k] >= 0) {
        stack[top++] = child[k];
        child[k] = sibling[child[k]];
      } else {
        e->count[placed++] = e->node[k];
        top--;
      }
    }
  }
  for (int k = 0; k < n; k++) e->node[k] = e->count[k];
}

static void invert(nsdae_symbolic *e)
{
  for (int k = 0; k < e->n; k++) e->number[e->node[k]] = k;
}

/* The order with, before each negative node that has no other neighbour before it, the first of
 * those that are not negative. */
static void lead(nsdae_symbolic *e, int negative)
{
  int *placed = e->work, *order = e->count, used = 0;
  for (int k = 0; k < e->n; k++) placed[k] = 0;
  for (int k = 0; k < e->n; k++) {
    int node = e->node[k], first = -1, led = node < negative;
    if (placed[node]) continue;
    for (int a = e->first[node]; a < e->first[node + 1] && !led; a++) {
      int other = e->index[a];
      if (other >= negative) continue;
      led = placed[other];
      if (first < 0 || e->number[other] < e->number[first]) first = other;
    }
    if (!led && first >= 0) placed[order[used++] = first] = 1;
    placed[order[used++] = node] = 1;
  }
  for (int k = 0; k < e->n; k++) e->node[k] = order[k];
  invert(e);
}

int nsdae_symbolic_analyse(nsdae_symbolic *e, int n, const int *first, const int *index,
                           int negative)
{
  e->n = n;
  e->first = first;
  e->index = index;
  if (nsdae_arena_fit(&e->of_nodes, lay_out_nodes, e) != NSDAE_OK) return NSDAE_E_MEMORY;
  int status = amd_order(n, first, index, e->node, NULL, NULL);
  if (status != AMD_OK && status != AMD_OK_BUT_JUMBLED) return NSDAE_E_MEMORY;
  invert(e);
  if (negative > 0) lead(e, negative);
  build_tree(e);
  postorder(e);
  invert(e);
  build_tree(e);
  list_rows(e, NULL);
  e->start[0] = 0;
  for (int k = 0; k < n; k++) e->start[k + 1] = e->start[k] + (size_t)e->count[k];
  if (nsdae_arena_fit(&e->of_rows, lay_out_rows, e) != NSDAE_OK) return NSDAE_E_MEMORY;
  list_rows(e, e->row);
  e->first = e->index = NULL;
  return NSDAE_OK;
}
