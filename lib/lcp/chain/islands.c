/* Disjoint sets in a forest with path halving (Tarjan and van Leeuwen, J. ACM 31, 1984); the
 * smallest index is the root. */
#include "islands.h"

#include <stddef.h>

static int root_of(int *parent, int i)
{
  while (parent[i] != i) {
    parent[i] = parent[parent[i]];
    i = parent[i];
  }
  return i;
}

int nsdae_islands_find(int n, const double *A, int lda, int *label)
{
  int count = n;
  for (int i = 0; i < n; i++) label[i] = i;
  for (int j = 0; j < n && count > 1; j++) {
    const double *column = A + (size_t)j * (size_t)lda;
    int mine = root_of(label, j);
    for (int i = 0; i < n; i++) {
      if (label[i] == mine || column[i] == 0) continue;
      int other = root_of(label, i);
      if (other == mine) continue;
      label[other > mine ? other : mine] = other < mine ? other : mine;
      mine = other < mine ? other : mine;
      count--;
    }
  }
  for (int i = 0; i < n; i++) label[i] = root_of(label, i);
  return count;
}

int nsdae_islands_members(int n, const int *label, int island, int *member)
{
  int count = 0;
  for (int i = island; i < n; i++)
    if (label[i] == island) member[count++] = i;
  return count;
}
