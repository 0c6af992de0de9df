/* The graph of a matrix of blocks that lists join: entries of one list are neighbours, or lists
 * with an entry in common are. */
#ifndef NSDAE_LINALG_ADJACENCY_H
#define NSDAE_LINALG_ADJACENCY_H

#include "arena.h"

/* List i is entry[first[i]] to entry[first[i + 1] - 1]. */
typedef struct nsdae_joined {
  int count;
  const int *first, *entry;
} nsdae_joined;

typedef struct nsdae_adjacency {
  int n;              /* nodes */
  int *first, *index; /* n + 1: neighbours of each node, ascending, without itself */
  int entries, joined;
  int *by_entry, *list; /* entries + 2, joined: of each entry, the lists that have it */
  int *mark;            /* n */
  nsdae_arena of_lists, of_edges;
} nsdae_adjacency;

/* Nodes are the lists (of_lists) or their entries, which are below `entries`. NSDAE_OK or
 * NSDAE_E_MEMORY. A struct of zeros has no memory. */
int nsdae_adjacency_build(nsdae_adjacency *adjacency, const nsdae_joined *lists, int entries,
                          int of_lists);
void nsdae_adjacency_release(nsdae_adjacency *adjacency);

#endif
