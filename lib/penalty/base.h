/* Where the integrator started last, and the contacts of then: the method's part of the memory. The
 * same start and the same ends of steps lead to the same point, bit by bit. */
#ifndef NSDAE_PENALTY_BASE_H
#define NSDAE_PENALTY_BASE_H

#include "stepper.h"

/* Steps since the integrator started, and stretches of a grid that they are on; then it starts
 * anew, which costs as much as some 40 steps. */
enum { NSDAE_ENDS_MAX = 4096, NSDAE_STRETCHES_MAX = 128 };

/* Steps that ended at origin + number dt, origin + (number + 1) dt and so on. One that ended off
 * the grid has an origin of its own. */
typedef struct nsdae_stretches {
  double *origin, *number; /* NSDAE_STRETCHES_MAX */
  int *steps;              /* NSDAE_STRETCHES_MAX */
  int *count, *ends;       /* 1: stretches; steps of all of them */
} nsdae_stretches;

/* When step i of a stretch ended. */
static inline double nsdae_stretches_end(const nsdae_stretches *s, int stretch, int i, double dt)
{
  return s->origin[stretch] + (s->number[stretch] + i) * dt;
}

/* A step to t_end, of the grid from `grid` on or not; the same as the last one is none more. 0: no
 * room for it. */
int nsdae_stretches_add(nsdae_stretches *stretches, double grid, double dt, double t_end);

typedef struct nsdae_penalty_base {
  double *t, *y;                     /* 1, n */
  double *since, *start_rate, *mass; /* k: when it closed, d'_0, effective mass */
  double *impulse, *impulse_t;       /* k, k nt: I_N, I_T at closing */
  double *peak;                      /* k: largest force since */
  nsdae_stretches since_then;        /* steps */
  int *closed;                       /* k: in contact */
} nsdae_penalty_base;

/* The memory of the method: what implicit keeps, then a base with n numbers at its point. */
void nsdae_penalty_base_sizes(const nsdae_stepper *stepper, size_t *reals, size_t *wholes);
/* Lays the base over the memory of a step. */
void nsdae_penalty_base_find(nsdae_penalty_base *base, const nsdae_stepper *stepper,
                             nsdae_memory *memory);

#endif
