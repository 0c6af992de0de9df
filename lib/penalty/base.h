/* Where the integrator started last, and the contacts of then: the method's part of the memory. The
 * same start and the same ends of steps lead to the same point, bit by bit. */
#ifndef NSDAE_PENALTY_BASE_H
#define NSDAE_PENALTY_BASE_H

#include "stepper.h"

enum {
  NSDAE_REPLAY_MAX = 256 /* ends of steps since the integrator started; then it starts anew */
};

typedef struct nsdae_penalty_base {
  double *t, *y;                     /* 1, n */
  double *since, *start_rate, *mass; /* k: when it closed, d'_0, effective mass */
  double *impulse, *impulse_t;       /* k, k nt: I_N, I_T at closing */
  double *peak;                      /* k: largest force since */
  double *end;                       /* NSDAE_REPLAY_MAX: steps since then ended there, */
  int *ends;                         /* 1: so many */
  int *closed;                       /* k: in contact */
} nsdae_penalty_base;

/* The memory of the method: what implicit keeps, then a base with n numbers at its point. */
void nsdae_penalty_base_sizes(const nsdae_stepper *stepper, size_t *reals, size_t *wholes);
/* Lays the base over the memory of a step. */
void nsdae_penalty_base_find(nsdae_penalty_base *base, const nsdae_stepper *stepper,
                             nsdae_memory *memory);

#endif
