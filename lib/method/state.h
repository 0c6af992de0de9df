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

#include "impulses.h"

typedef struct nsdae_memory {
  size_t reals, wholes; /* sizes, fixed by the method */
  double *real;         /* finite or infinite, never NaN */
  int *whole;
  long stamp; /* of the method, which never gives one twice; 0: all zero, after an init; -1: set
                 from a block, of which it is no part */
  int slots;  /* of tracked contacts: up to the last that is used */
} nsdae_memory;

/* Arrays in it, taken in turn, of the contacts slot by slot: a method's function that takes them
 * measures, lays out, and copies to a memory of another number of slots. */
typedef struct nsdae_memory_part {
  double *real; /* NULL: measuring */
  int *whole;
  size_t reals, wholes;           /* taken */
  size_t slots;                   /* contacts */
  struct nsdae_memory_part *from; /* another memory, which is copied: of the slots of both */
} nsdae_memory_part;

/* The length of an array: some numbers, and some for every slot and every pair of them. Pairs are
 * in an order in which those of fewer slots come first. */
typedef struct nsdae_memory_length {
  size_t fixed, slot, pair;
} nsdae_memory_length;

#define NSDAE_OF_ALL(count)  ((nsdae_memory_length){.fixed = (count)})
#define NSDAE_BY_SLOT(count) ((nsdae_memory_length){.slot = (count)})
#define NSDAE_BY_PAIR(count) ((nsdae_memory_length){.pair = (count)})

double *nsdae_memory_reals(nsdae_memory_part *part, nsdae_memory_length length);
int *nsdae_memory_wholes(nsdae_memory_part *part, nsdae_memory_length length);

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
