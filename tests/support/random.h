/* Numbers that are the same in every run and on every machine, for all tests: SplitMix64 (Steele,
 * Lea and Flood, OOPSLA 2014; the code is Vigna's, in the public domain). One word of state; no
 * seed is a bad one. */
#ifndef NSDAE_TESTS_RANDOM_H
#define NSDAE_TESTS_RANDOM_H

#include <stdint.h>

static inline uint64_t random_next(uint64_t *state)
{
  uint64_t z = *state += 0x9e3779b97f4a7c15u;
  z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9u;
  z = (z ^ (z >> 27)) * 0x94d049bb133111ebu;
  return z ^ (z >> 31);
}

/* In 0 .. 1, without 1. */
static inline double random_uniform(uint64_t *state)
{
  return (double)(random_next(state) >> 11) * 0x1p-53;
}

static inline double random_between(uint64_t *state, double low, double high)
{
  return low + (high - low) * random_uniform(state);
}

/* One of 0 .. n - 1. */
static inline int random_below(uint64_t *state, int n)
{
  return (int)(random_next(state) % (uint64_t)n);
}

/* ---- of linear algebra */

typedef struct random_state {
  uint64_t seed;
} random_state;

static inline uint64_t random_bits(random_state *r)
{
  return random_next(&r->seed);
}

/* In -1 .. 1. */
static inline double random_number(random_state *r)
{
  return (double)(random_bits(r) >> 11) * 0x1p-52 - 1;
}

static inline int random_int(random_state *r, int low, int high)
{
  return low + random_below(&r->seed, high - low + 1);
}

/* A [rows x columns]. */
static inline void random_matrix(random_state *r, int rows, int columns, double *A, int lda)
{
  for (int j = 0; j < columns; j++)
    for (int i = 0; i < rows; i++) A[j * lda + i] = random_number(r);
}

#endif
