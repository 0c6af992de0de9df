/* Disjoint sets of 0 .. n - 1 in a forest, with path halving (Tarjan and van Leeuwen, J. ACM 31,
 * 1984). The smallest member is the root: sets come in the order of their first members. */
#ifndef NSDAE_BASE_DISJOINT_SETS_H
#define NSDAE_BASE_DISJOINT_SETS_H

/* Each of n alone. */
static inline void nsdae_sets_begin(int *parent, int n)
{
  for (int i = 0; i < n; i++) parent[i] = i;
}

static inline int nsdae_sets_root(int *parent, int i)
{
  while (parent[i] != i) i = parent[i] = parent[parent[i]];
  return i;
}

/* One set of those of a and b; its root. */
static inline int nsdae_sets_join(int *parent, int a, int b)
{
  a = nsdae_sets_root(parent, a);
  b = nsdae_sets_root(parent, b);
  return a < b ? (parent[b] = a) : (parent[a] = b);
}

#endif
