/* Complementarity problems at random, seeded. */
#ifndef NSDAE_BENCH_LCP_FAMILIES_H
#define NSDAE_BENCH_LCP_FAMILIES_H

#include "../support/random.h"

enum { LCP_DEFINITE, LCP_FRICTIONLESS, LCP_FRICTION, LCP_FAMILIES };

extern const char *const lcp_family_names[LCP_FAMILIES];

typedef struct lcp_case {
  int n;
  double *A, *b; /* n x n, n */
  double *near;  /* n: b of a neighbouring problem, relative distance 1e-4 */
} lcp_case;

/* Drawn again until x = 0 is no solution. Friction needs n divisible by 3. */
lcp_case lcp_case_create(int family, int n, random_state *r);
void lcp_case_destroy(lcp_case *c);

#endif
