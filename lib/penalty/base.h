/* Where the integrator started last, and the contacts of then: the method's part of the memory. The
 * same start and the same number of steps lead to the same point, bit by bit. */
#ifndef NSDAE_PENALTY_BASE_H
#define NSDAE_PENALTY_BASE_H

#include "stepper.h"
#include "tracking.h"

typedef struct nsdae_penalty_base {
  double *t, *qv;                    /* 1, nq + nv */
  double *first;                     /* 1: length of the first step, or 0 */
  double *since, *start_rate, *mass; /* k: when it closed, d'_0, effective mass */
  double *impulse, *impulse_t;       /* k, k nt: from then to t */
  double *peak;                      /* k: largest force until t */
  int *closed;                       /* k: in contact */
  int *steps, *is_stiff;             /* 1: of the integrator, since t; IDA is at work */
} nsdae_penalty_base;

/* Takes the memory of the method: a base. */
void nsdae_penalty_base_lay(const nsdae_stepper *stepper, nsdae_memory_part *part);
/* Lays the base, and what is kept of tracked contacts, over the memory of a step. */
void nsdae_penalty_base_find(nsdae_penalty_base *base, nsdae_tracking *tracking,
                             const nsdae_stepper *stepper, nsdae_memory *memory);

#endif
