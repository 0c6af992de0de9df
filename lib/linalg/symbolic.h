/* What the elimination of a sparse matrix of symmetric pattern will fill, before any number: the
 * nodes are rows and columns or, here, dense blocks of several. Order of least degree (AMD:
 * Amestoy, Davis, Duff, ACM Trans. Math. Softw. 30 (2004) 381), elimination tree (Liu, SIAM J.
 * Matrix Anal. Appl. 11 (1990) 134), structure of each column of the factor. */
#ifndef NSDAE_LINALG_ELIMINATION_H
#define NSDAE_LINALG_ELIMINATION_H

#include "arena.h"

/* The graph of a matrix of blocks that lists join: entries of one list are neighbours, or lists
 * with an entry in common are. */

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

typedef struct nsdae_symbolic {
  int n;
  const int *first, *index; /* the graph: neighbours of node i, without i, in both directions */
  int *node;                /* n: the node eliminated as number k */
  int *number;              /* n: its inverse */
  int *parent;              /* n: of number k in the tree; n: a root */
  int *count;               /* n: entries of column k below the diagonal */
  size_t *start;            /* n + 1: where they begin in row */
  int *row;                 /* start[n]: their numbers, ascending */
  int *work;                /* 3 n */
  nsdae_arena of_nodes, of_rows;
} nsdae_symbolic;

/* Analyses the graph given by n, first [n + 1] and index [first[n]], which is not kept. If negative
 * > 0, each node from that on is eliminated after one of its neighbours before that. NSDAE_OK or
 * NSDAE_E_MEMORY. The arrays of a former call are used again where they are large enough; a struct
 * of zeros has none. */
int nsdae_symbolic_analyse(nsdae_symbolic *e, int n, const int *first, const int *index,
                           int negative);

#endif
