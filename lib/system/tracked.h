/* The contacts of a list near a smooth motion, each in a slot: its number among the k contacts of
 * the model. Terms of contacts are then by slot, as those of fixed contacts are by number; a slot
 * that is not used is an open contact far away. Slots are taken as contacts come near. Sums and
 * eliminations take contacts in the order of their ids, as fixed ones in that of their numbers, so
 * that their rounding does not depend on which came first. */
#ifndef NSDAE_SYSTEM_TRACKED_H
#define NSDAE_SYSTEM_TRACKED_H

/* Gap of a slot without a contact. Its cube is finite. */
#define NSDAE_FAR 1e100

typedef struct nsdae_tracked {
  long *id;     /* k */
  int *used;    /* k */
  int *block;   /* 2 k */
  int *order;   /* k: slots by id, then those that are not used */
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

/* The order of contacts in sums and eliminations: their numbers, whatever their slots. */
static inline int nsdae_tracked_precedes(const nsdae_tracked *tracked, int slot, int other)
{
  if (!tracked->used[slot] || !tracked->used[other])
    return tracked->used[slot] != tracked->used[other] ? tracked->used[slot] : slot < other;
  return tracked->id[slot] < tracked->id[other];
}

/* Sorts `order`, when slots are taken or freed: by insertion, most have their places. */
static inline void nsdae_tracked_sort(const nsdae_tracked *tracked, int k)
{
  for (int n = 0; n < k; n++) {
    int slot = tracked->order[n], p = n;
    for (; p > 0 && nsdae_tracked_precedes(tracked, slot, tracked->order[p - 1]); p--)
      tracked->order[p] = tracked->order[p - 1];
    tracked->order[p] = slot;
  }
}

#endif
