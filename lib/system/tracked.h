/* The contacts of a list near a smooth motion, each in a slot: its number among the k contacts of
 * the model. Terms of contacts are then by slot, as those of fixed contacts are by number; a slot
 * that is not used is an open contact far away. */
#ifndef NSDAE_SYSTEM_TRACKED_H
#define NSDAE_SYSTEM_TRACKED_H

#include <stddef.h>

/* Gap of a slot without a contact. Its cube is finite. */
#define NSDAE_FAR 1e100

typedef struct nsdae_tracked {
  long *id;     /* k */
  int *used;    /* k */
  int *block;   /* 2 k */
  double reach; /* within which lists are asked for */
  int wanted;   /* slots that the last update took, or would have taken */
} nsdae_tracked;

/* Slots up to the last one that is used. */
static inline int nsdae_tracked_count(const nsdae_tracked *tracked, int k)
{
  while (k > 0 && !tracked->used[k - 1]) k--;
  return k;
}

/* The slot of an id among k; -1: none. The search starts at `likely`. */
static inline int nsdae_tracked_find(const nsdae_tracked *tracked, int k, long id, int likely)
{
  for (int n = 0, i = likely; n < k; n++, i++) {
    if (i >= k) i = 0;
    if (tracked->used[i] && tracked->id[i] == id) return i;
  }
  return -1;
}

#endif
