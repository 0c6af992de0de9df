#include "chain.h"

#include <stddef.h>

#include "disjoint_sets.h"

int nsdae_islands_find(int n, const double *A, int lda, int *label)
{
  int count = n;
  nsdae_sets_begin(label, n);
  for (int j = 0; j < n && count > 1; j++) {
    const double *column = A + (size_t)j * (size_t)lda;
    int mine = nsdae_sets_root(label, j);
    for (int i = 0; i < n; i++) {
      if (label[i] == mine || column[i] == 0) continue;
      if (nsdae_sets_root(label, i) == mine) continue;
      mine = nsdae_sets_join(label, i, mine);
      count--;
    }
  }
  for (int i = 0; i < n; i++) label[i] = nsdae_sets_root(label, i);
  return count;
}

int nsdae_islands_members(int n, const int *label, int island, int *member)
{
  int count = 0;
  for (int i = island; i < n; i++)
    if (label[i] == island) member[count++] = i;
  return count;
}
