#include "symbolic.h"

#include <amd.h>
#include <nsdae/status.h>

static void lay_out_nodes(void *object, nsdae_arena *arena)
{
  nsdae_symbolic *e = object;
  e->node = NSDAE_ARENA_INTS(arena, e->n);
  e->number = NSDAE_ARENA_INTS(arena, e->n);
  e->parent = NSDAE_ARENA_INTS(arena, e->n);
  e->count = NSDAE_ARENA_INTS(arena, e->n);
  e->start = nsdae_arena_take(arena, e->n + 1L, sizeof(size_t));
  e->work = NSDAE_ARENA_INTS(arena, e->room);
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

/* Matches a negative node to a neighbour that is not, which no other one has; then these have one
 * choice less. */
static int match_one(const nsdae_symbolic *e, int node, int negative, int *match, int *choices,
                     int *ready, int top)
{
  int a = e->first[node];
  while (e->index[a] >= negative || match[e->index[a]] >= 0) a++;
  match[node] = e->index[a];
  match[match[node]] = node;
  for (a = e->first[match[node]]; a < e->first[match[node] + 1]; a++)
    if (e->index[a] >= negative && --choices[e->index[a]] == 1) ready[top++] = e->index[a];
  return top;
}

/* A neighbour of its own for each negative node, those with one choice first (Karp and Sipser, FOCS
 * 22 (1981) 364), which is a perfect matching of trees; -1: none. */
static void match_nodes(const nsdae_symbolic *e, int negative, int *match)
{
  int *choices = e->work + e->n, *ready = choices + e->n, top = 0;
  for (int i = 0; i < e->n; i++) {
    match[i] = -1;
    choices[i] = e->first[i + 1] - e->first[i];
    if (i >= negative && choices[i] == 1) ready[top++] = i;
  }
  for (int next = negative; next < e->n; next++) {
    while (top > 0) {
      int node = ready[--top];
      if (match[node] < 0 && choices[node] > 0)
        top = match_one(e, node, negative, match, choices, ready, top);
    }
    if (match[next] < 0 && choices[next] > 0)
      top = match_one(e, next, negative, match, choices, ready, top);
  }
}

/* The node that stands for this one: of a negative node its match. */
static int owner(const int *match, int node, int negative)
{
  return node >= negative && match[node] >= 0 ? match[node] : node;
}

/* The graph with each negative node and its match as one, in first [n + 1] and index. */
static void merge(const nsdae_symbolic *e, int negative, const int *match, int *first, int *index)
{
  int used = 0;
  for (int i = 0; i < e->n; i++) {
    int part[2] = {i, i < negative ? match[i] : -1};
    first[i] = used;
    for (int p = 0; p < 2 && owner(match, i, negative) == i; p++)
      for (int a = part[p] < 0 ? 0 : e->first[part[p]]; part[p] >= 0 && a < e->first[part[p] + 1];
           a++)
        if (owner(match, e->index[a], negative) != i)
          index[used++] = owner(match, e->index[a], negative);
  }
  first[e->n] = used;
}

/* Of the neighbours of a negative node that are not, the first in the order, or -1 if one is
 * placed. */
static int leader(const nsdae_symbolic *e, int node, int negative, const int *placed)
{
  int best = -1;
  for (int a = e->first[node]; a < e->first[node + 1]; a++) {
    int other = e->index[a];
    if (other >= negative) continue;
    if (placed[other]) return -1;
    if (best < 0 || e->number[other] < e->number[best]) best = other;
  }
  return best;
}

static void place(const int *match, int node, int negative, int *placed, int *order, int *used)
{
  if (placed[node]) return;
  placed[order[(*used)++] = node] = 1;
  if (node < negative && match[node] >= 0) placed[order[(*used)++] = match[node]] = 1;
}

/* The order with each negative node after its match, or after a neighbour. */
static void lead(nsdae_symbolic *e, int negative)
{
  int *match = e->work, *placed = match + e->n, *order = e->count, used = 0;
  for (int k = 0; k < e->n; k++) placed[k] = 0;
  for (int k = 0; k < e->n; k++) {
    int node = e->node[k], first = node < negative ? -1 : leader(e, node, negative, placed);
    if (owner(match, node, negative) != node) continue;
    if (first >= 0) place(match, first, negative, placed, order, &used);
    place(match, node, negative, placed, order, &used);
  }
  for (int k = 0; k < e->n; k++) e->node[k] = order[k];
}

/* Order of least degree, or AMD's status. */
static int find_order(nsdae_symbolic *e, int negative)
{
  if (negative == 0) return amd_order(e->n, e->first, e->index, e->node, NULL, NULL);
  int *first = e->work + 3 * (size_t)e->n;
  match_nodes(e, negative, e->work);
  merge(e, negative, e->work, first, first + e->n + 1);
  int status = amd_order(e->n, first, first + e->n + 1, e->node, NULL, NULL);
  if (status != AMD_OK && status != AMD_OK_BUT_JUMBLED) return status;
  invert(e);
  lead(e, negative);
  return status;
}

int nsdae_symbolic_analyse(nsdae_symbolic *e, int n, const int *first, const int *index,
                           int negative)
{
  e->n = n;
  e->first = first;
  e->index = index;
  e->room = 3L * n + (negative > 0 ? 1L + n + first[n] : 0);
  if (nsdae_arena_fit(&e->of_nodes, lay_out_nodes, e) != NSDAE_OK) return NSDAE_E_MEMORY;
  int status = find_order(e, negative);
  if (status != AMD_OK && status != AMD_OK_BUT_JUMBLED) return NSDAE_E_MEMORY;
  invert(e);
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

void nsdae_symbolic_release(nsdae_symbolic *e)
{
  nsdae_arena_release(&e->of_nodes);
  nsdae_arena_release(&e->of_rows);
}
