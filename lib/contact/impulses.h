/* What contacts and frictional joints did in a step or instant: the results of a contact problem,
 * or of an integration over forces. Zero where a contact is open. */
#ifndef NSDAE_IMPULSES_H
#define NSDAE_IMPULSES_H

#include <nsdae/system.h>

#include "arena.h"

typedef struct nsdae_impulses {
  int *impact;                 /* k: contacts that hit, as the method decided */
  double *before, *before_t;   /* v_N(-), v_T(-): k, k nt */
  double *after, *after_t;     /* v_N(+), v_T(+) */
  double *normal, *tangential; /* Lambda_N, Lambda_T */
  double *linear;              /* 3 k: of bodies W Lambda, nsdae_terms_add_linear */
  int *mode;                   /* enum nsdae_mode */

  double *slide_before, *slide_after; /* f: sliding velocity */
  double *frictional_joint_impulse;   /* f: Lambda_T */
  int *frictional_joint_mode;         /* f */
} nsdae_impulses;

/* Of k = 0 those of the frictional joints alone: a list has the others. */
void nsdae_impulses_layout(nsdae_impulses *impulses, const nsdae_dims *dims, nsdae_arena *arena);
void nsdae_impulses_clear(nsdae_impulses *impulses, const nsdae_dims *dims);

/* Those of the first contacts, and of the frictional joints, of impulses of other dimensions; of
 * the rest none. */
void nsdae_impulses_carry(nsdae_impulses *to, const nsdae_dims *dims, int count,
                          const nsdae_impulses *from);

/* sum of Lambda (v(+) + v(-)) / 2 over contacts and frictional joints of these numbers. */
double nsdae_impulses_work(const nsdae_impulses *impulses, int nt, int contacts, const int *contact,
                           int joints, const int *joint);

/* Impulses, and velocities before and after: += share (from - to) */
void nsdae_impulses_blend(nsdae_impulses *to, const nsdae_dims *dims, double share,
                          const nsdae_impulses *from);

/* The contacts of a step: who they are. What they did is in the impulses of the same step, by the
 * same places; of a list the next step begins with it, by id. Fixed contacts are there always, also
 * open ones, and are not counted: contact i has the id i and no blocks. */

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
