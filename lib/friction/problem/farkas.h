/* The proof that an island has no solution, whatever the friction: see the file itself. */
#ifndef NSDAE_FRICTION_FARKAS_H
#define NSDAE_FRICTION_FARKAS_H

#include "scaled_island.h"
#include "proof.h"

typedef struct nsdae_fc_farkas {
  const nsdae_fc_scaled *fc;
  nsdae_cone cone;   /* of the scaled columns; n: entries of v (local form: of r) and one */
  int *item;         /* m: of the whole, whose normal or bilateral row it is */
  double *sign;      /* m: 1, or -1: the second column of a bilateral row */
  double *columns;   /* n x m: (H e; w) of each, as given */
  double *scaled;    /* the same, by powers of two */
  double *row, *by;  /* n, m: those of rows and columns */
  double *target;    /* n */
  int *chosen;       /* n: the directions of the combination */
  double *exact;     /* 2 n: work of the check: a row and its factors */
  double *inverse;   /* n x n */
  int *pivot, *kept; /* n: work of the inverse; rows that are not all zeros */
  nsdae_arena memory;
} nsdae_fc_farkas;

/* Looks for it; l [m of the global problem] is as it was, or the proof, as the public header says.
 * 1 proved, 0 not; NSDAE_E_MEMORY. */
int nsdae_fc_farkas_find(nsdae_fc_farkas *proof, const nsdae_fc_scaled *fc, double *l);

#endif
