/* Seeded families of complementarity problems, each with a solution that is known or with the proof
 * that it has none.
 *
 * With a chosen x, y >= 0, x'y = 0, the problem (A, y - A x) has the solution x. Contacts: bodies
 * in the plane (3 degrees of freedom) or in space (6) with random masses, W = J M^-1 J^T; for
 * chosen modes (open, slide, stick) with relative velocities v and impulses Lambda the free
 * velocities are v - W Lambda. */
#ifndef NSDAE_TESTS_LCP_FAMILIES_H
#define NSDAE_TESTS_LCP_FAMILIES_H

#include <stdint.h>

enum lcp_family {
  FAMILY_DEFINITE,     /* B B^T + D + skew, D > 0 */
  FAMILY_SEMIDEFINITE, /* B B^T of half rank + skew */
  FAMILY_FRICTIONLESS, /* W_N with rows that are there twice or more */
  FAMILY_PLANAR_3,     /* Coulomb in the plane, 3 rows for each contact */
  FAMILY_PLANAR_4,     /* the same in 4 rows: normal, two directions, slip */
  FAMILY_PYRAMID_4,    /* friction pyramids in space, 6 rows */
  FAMILY_PYRAMID_8,    /* 10 rows */
  FAMILY_RESTITUTION,  /* b = (1 + e) W v of an impact, in one of the last four forms */
  FAMILY_SCALED,       /* one of the above, rows and columns by 10^-8 .. 10^8 */
  FAMILY_DEGENERATE,   /* one of the above with many x_i = y_i = 0, integer data where it has no
                          contacts */
  FAMILY_INFEASIBLE,   /* u > 0 with A^T u < 0, b^T u < 0 built in */
  FAMILY_ANY,          /* entries in [-1, 1]: a solution or none, for enumeration to say */
  FAMILIES
};

enum { FAMILY_NO_SOLUTION, FAMILY_SOLUTION, FAMILY_OPEN };

typedef struct lcp_sample {
  int n; /* rows: at most what was asked for, in whole contacts */
  int capacity;
  int known;            /* FAMILY_SOLUTION, FAMILY_NO_SOLUTION, or FAMILY_OPEN */
  double *A;            /* n x n */
  double *b;            /* n */
  double *x;            /* n: the solution known, else zero */
  double *row, *column; /* n: what rows and columns were multiplied by */
  uint64_t state;       /* of the random numbers */
} lcp_sample;

const char *lcp_family_name(int family);

/* Smallest n of the family. */
int lcp_family_least(int family);

/* Room for problems of up to n rows; ends the program where there is none. */
lcp_sample lcp_sample_create(int n, unsigned long long seed);
void lcp_sample_release(lcp_sample *s);

/* The next problem of a family with at most n rows. */
void lcp_sample_draw(lcp_sample *s, int family, int n);

/* Uniform in [0, 1), [low, high), and {0 .. count - 1}. */
double lcp_sample_uniform(lcp_sample *s, double low, double high);
int lcp_sample_pick(lcp_sample *s, int count);

#endif
