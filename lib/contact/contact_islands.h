/* Islands: the parts of a system that closed contacts, rows of constraints and frictional joints
 * join, by disjoint sets over the blocks (Tarjan, J. ACM 22 (1975) 215). Their blocks, contacts,
 * rows and joints are listed island by island, each in its own order; what belongs to none moves
 * freely. A system of one block has one island, which needs no search. */
#ifndef NSDAE_CONTACT_ISLANDS_H
#define NSDAE_CONTACT_ISLANDS_H

#include "arena.h"
#include "terms.h"

/* Members of island i: of[first[i]] .. of[first[i + 1] - 1]. */
typedef struct nsdae_members {
  int *first; /* blocks + 1 */
  int *of;
} nsdae_members;

typedef struct nsdae_contact_islands {
  int blocks, rows, count;
  int joints, *joint_number; /* frictional joints that can rub, and their numbers */
  int *of;                   /* blocks: the island of each; -1: none */
  int *parent;               /* blocks */
  nsdae_members block, contact, row, joint;
} nsdae_contact_islands;

/* contact.of is the caller's, with room for every contact. */
void nsdae_contact_islands_layout(nsdae_contact_islands *islands, const nsdae_system *system,
                                  nsdae_arena *arena);

/* Finds them at the terms' point, of contacts with these numbers. */
void nsdae_contact_islands_find(nsdae_contact_islands *islands, const nsdae_terms *terms,
                                int contacts, const int *number);

/* The island of a contact, a row, a joint. */
int nsdae_island_of_contact(const nsdae_contact_islands *islands, const nsdae_terms *terms, int i);
int nsdae_island_of_row(const nsdae_contact_islands *islands, const nsdae_terms *terms, int i);
int nsdae_island_of_joint(const nsdae_contact_islands *islands, const nsdae_terms *terms, int i);

static inline int nsdae_members_count(const nsdae_members *members, int island)
{
  return members->first[island + 1] - members->first[island];
}

#endif
