/* The first fall through zero of several functions in a step, by the method of Illinois on the one
 * that falls deepest, as IDA looks for roots (Hiebert and Shampine, "Implicitly defined
 * output points for solutions of ODEs", SAND80-0180, 1980). */
#ifndef NSDAE_FALL_H
#define NSDAE_FALL_H

#include "arena.h"

typedef struct nsdae_fall {
  int count;
  double *low, *high, *middle; /* count: values at the ends of the bracket, and in it */
  /* g [count] at t; 0, or < 0 where it gave up */
  int (*values)(double t, double *g, void *user);
  void *user;
} nsdae_fall;

void nsdae_fall_layout(nsdae_fall *fall, nsdae_arena *arena);

/* With low filled at `from`: fills high, at *to; where functions that were above zero are not
 * there, *to becomes the first time when any is not, to rounding of it, and found [count] says
 * which are. Returns how many, or what `values` gave up with. */
int nsdae_fall_find(nsdae_fall *fall, double from, double *to, int *found);

#endif
