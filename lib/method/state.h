/* What a step starts from, and what a method may keep between steps.
 *
 * A step is a transaction: a method reads a state and fills a result (result.h); the simulation
 * commits the result, which then is the state, or drops it. Nothing else carries over: what a
 * method wants to know in the next step it leaves in the result's memory, a plain block of
 * numbers. What cannot be put into numbers, such as the history of an integrator, is a cache of
 * its own: it holds where the state's memory has the stamp that the method gave last, and is made
 * from the memory again where it has not, as after a step that was dropped or a state that was
 * set. So dropping a step takes nothing, and a state is one block of bytes. */
#ifndef NSDAE_STATE_H
#define NSDAE_STATE_H

#include <nsdae/sim.h>

#include "closed.h"

typedef struct nsdae_memory {
  size_t reals, wholes; /* sizes, fixed by the method */
  double *real;         /* finite or infinite, never NaN */
  int *whole;
  long stamp; /* of the method, which never gives one twice; 0: all zero, after an init; -1: set
                 from a block, of which it is no part */
} nsdae_memory;

/* Arrays in it, taken in turn; without one, how much they take: sizes are written once. */
typedef struct nsdae_memory_part {
  double *real; /* NULL: measuring */
  int *whole;
  size_t reals, wholes; /* taken */
} nsdae_memory_part;

static inline double *nsdae_memory_reals(nsdae_memory_part *part, size_t count)
{
  double *at = part->real ? part->real + part->reals : NULL;
  part->reals += count;
  return at;
}

static inline int *nsdae_memory_wholes(nsdae_memory_part *part, size_t count)
{
  int *at = part->whole ? part->whole + part->wholes : NULL;
  part->wholes += count;
  return at;
}

typedef struct nsdae_state {
  nsdae_terms *terms; /* at t, q, v, which no method moves; evaluated as far as needed */
  const nsdae_memory *memory;
  const nsdae_closed *closed;     /* contacts by list of the step before, */
  const nsdae_impulses *impulses; /* and what they did */
  double grid;                    /* steps end at this time and whole numbers of dt, mostly */
  double length;                  /* of the step: dt from one of these times to the next, though
                                     they are rounded; else the difference of its times */
} nsdae_state;

/* The start of every advance: the result's memory is what the state's is. */
void nsdae_memory_copy(nsdae_memory *to, const nsdae_memory *from);

#endif
