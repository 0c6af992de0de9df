#include "call_places.h"

#include <execinfo.h>

enum { SKIPPED = 3, MOST = 8 }; /* this function, the one that counts, and its caller */

__attribute__((noinline)) unsigned long call_place(int addresses)
{
  void *at[SKIPPED + MOST];
  int n = backtrace(at, SKIPPED + (addresses < MOST ? addresses : MOST));
  unsigned long sum = 0;
  for (int i = SKIPPED; i < n; i++) sum = 31 * sum + (unsigned long)at[i];
  return sum;
}

int call_places_add(call_places *places, unsigned long place)
{
  for (long i = 0; i < places->count; i++)
    if (places->at[i] == place) return 0;
  if (places->count < CALL_PLACES) places->at[places->count++] = place;
  return 1;
}
