/* The allocator under the library's feet: counts every allocation of the linked objects and fails
 * the one that is asked for. A test that uses it is linked with --wrap of the four functions. */
#ifndef NSDAE_TESTS_ALLOCATOR_H
#define NSDAE_TESTS_ALLOCATOR_H

#include "call_places.h"

typedef struct allocator {
  long calls;   /* malloc, calloc, realloc so far */
  long live;    /* allocated and not freed */
  long fail_at; /* the call of this number, from 0, returns NULL; < 0: none */
  int listing;  /* addresses that tell a place (call_places.h) of those to note; 0: none */
} allocator;

extern allocator the_allocator;

/* Of the calls since the last allocator_list. */
extern call_places the_allocations;

/* Counts from 0 again. */
void allocator_reset(long fail_at);

/* The same, without a failure; the place of each call is noted. */
void allocator_list(int addresses);

#endif
