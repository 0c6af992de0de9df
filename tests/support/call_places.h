/* Where calls come from: of many calls, one at each place of the code can be made to fail. */
#ifndef NSDAE_TESTS_CALL_PLACES_H
#define NSDAE_TESTS_CALL_PLACES_H

enum { CALL_PLACES = 8192 };

typedef struct call_places {
  long count;
  unsigned long at[CALL_PLACES];
} call_places;

/* A number of the addresses that a call returns to, without those of the function that counts and
 * of its caller: 1 address is that of the line, more tell what led to it too. */
unsigned long call_place(int addresses);

/* Adds the place. 0 if it is there. */
int call_places_add(call_places *places, unsigned long place);

#endif
