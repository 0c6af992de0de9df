/* Islands: the parts of a system that closed contacts and rows of constraints join, by disjoint
 * sets over the blocks (Tarjan, J. ACM 22 (1975) 215). Their blocks, contacts and rows are listed
 * island by island, each in its own order; what belongs to none moves freely. */
#ifndef NSDAE_CONTACT_ISLANDS_H
#define NSDAE_CONTACT_ISLANDS_H

#include "arena.h"
#include "rows.h"

/* Members of island i: of[first[i]] .. of[first[i + 1] - 1]. */
typedef struct nsdae_members {
  int *first; /* blocks + 1 */
  int *of;
} nsdae_members;

typedef struct nsdae_contact_islands {
  int blocks, rows, count;
  int *of;     /* blocks: the island of each; -1: none */
  int *parent; /* blocks */
  nsdae_members block, contact, row;
} nsdae_contact_islands;

/* blocks and rows are set before; contact.of is the caller's, with room for every contact. */
void nsdae_contact_islands_layout(nsdae_contact_islands *islands, nsdae_arena *arena);

/* Finds them, from the pairs of blocks of contacts (-1: the ground) and the rows of Phi_q. Returns
 * -1, or a row that touches no block. */
int nsdae_contact_islands_find(nsdae_contact_islands *islands, int contacts, const int *pair,
                               const nsdae_rows *rows);

static inline int nsdae_members_count(const nsdae_members *members, int island)
{
  return members->first[island + 1] - members->first[island];
}

#endif
