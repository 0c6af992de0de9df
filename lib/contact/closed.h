/* The contacts of a step: who they are. What they did is in the impulses of the same step, by the
 * same places; of a list the next step begins with it, by id. Fixed contacts are there always, also
 * open ones, and are not counted: contact i has the id i and no blocks. */
#ifndef NSDAE_CLOSED_H
#define NSDAE_CLOSED_H

#include "impulses.h"

typedef struct nsdae_closed {
  int count, room, nt,
      rows; /* count: of a list; rows: of a contact in a complementarity problem, at most */
  long *id;
  int *block;  /* 2 count */
  double *gap; /* count; of fixed contacts those of the end */
  int *fresh;  /* no impulse in the step before */
  int *basis;  /* rows count */
} nsdae_closed;

/* Places of ids: a table of twice as many and more, each holding a place or -1. */
typedef struct nsdae_ids {
  const long *id; /* of whom the table is */
  int *slot;
  size_t slots; /* a power of two */
} nsdae_ids;

/* Room for this number of contacts, with their impulses; NSDAE_OK or NSDAE_E_MEMORY. */
int nsdae_closed_grow(nsdae_closed *closed, nsdae_impulses *impulses, int room);
/* Not for impulses of numbered contacts, which are in an arena. */
void nsdae_closed_release(nsdae_closed *closed, nsdae_impulses *impulses);
/* Impulses of all that are closed now: none yet. */
void nsdae_closed_clear(const nsdae_closed *closed, nsdae_impulses *impulses);

int nsdae_ids_grow(nsdae_ids *ids, int room);
void nsdae_ids_release(nsdae_ids *ids);
/* Fills the table; returns -1, or the first place of an id that comes
 * again. */
int nsdae_ids_fill(nsdae_ids *ids, int count, const long *id);
/* The place of an id; -1: not there. */
int nsdae_ids_find(const nsdae_ids *ids, long id);

#endif
