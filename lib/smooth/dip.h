/* A function that falls through zero and rises again between two points of an integrator has the
 * same sign at both: what looks for falls there (dip.c) does not see it. Its values and rates at
 * the ends and inside of a step bound how low it may come; where that is below zero, its
 * lowest point is where the rate changes its sign. */
#ifndef NSDAE_DIP_H
#define NSDAE_DIP_H

#include "arena.h"

enum { NSDAE_DIP_PIECES = 6 };

typedef struct nsdae_dip {
  int count;
  double *value, *rate; /* (pieces + 2) count: at the ends of the pieces of a step, of the most
                           pieces last; and where they were looked at last */
  double known;         /* the time of the end, or NaN */
  /* values and rates [count] at t; 0, or < 0 where it gave up */
  int (*look)(double t, double *value, double *rate, void *user);
  void *user;
} nsdae_dip;

void nsdae_dip_layout(nsdae_dip *dip, nsdae_arena *arena);

/* Nothing is known of a step before. */
void nsdae_dip_start(nsdae_dip *dip);

/* The first fall through zero in the step of 2 to 6 pieces between two times of a function that is
 * not out [count], and comes `deep` below: at *when, of *which; INFINITY where there is none. 0, or
 * what `look` gave up with. */
int nsdae_dip_find(nsdae_dip *dip, double from, double to, int pieces, const int *out, double deep,
                   double *when, int *which);

/* ---- The first fall through zero of several functions in a step, by the method of
 * Illinois on the one that falls deepest, as IDA looks for roots (Hiebert and Shampine, "Implicitly
 * defined output points for solutions of ODEs", SAND80-0180, 1980). */

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
