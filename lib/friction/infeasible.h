/* The proof that an island has no solution, whatever the friction: see the file itself. */
#ifndef NSDAE_FRICTION_INFEASIBLE_H
#define NSDAE_FRICTION_INFEASIBLE_H

#include "island.h"

typedef struct nsdae_fc_proof {
  const nsdae_fc *fc;
  int n, m;           /* entries of v (local form: of r) and one; directions */
  int *item;          /* m: of the whole, whose normal or bilateral row it is */
  double *sign;       /* m: 1, or -1 where a bilateral row counts the other way */
  double *columns;    /* n x m: (H e; w) of each, as given */
  double *scaled;     /* the same, by powers of two */
  double *row, *size; /* n, m: those of rows and columns */
  double *target;     /* n */
  double *l, *rest;   /* m, n: the combination, what it leaves */
  double *gram, *factor, *s;
  int *allowed, *order, *state;
  int *chosen;       /* n: the directions of the combination */
  double *exact;     /* 2 n: work of the check: a row and its factors */
  double *inverse;   /* n x n */
  int *pivot, *kept; /* n: work of the inverse; rows that are not all zeros */
  nsdae_arena memory;
} nsdae_fc_proof;

enum { NSDAE_FC_PROVED = 1, NSDAE_FC_NOT_PROVED = 0, NSDAE_FC_NO_MEMORY = -1 };

/* Looks for it; l [m of the whole] is as it was, or the proof, as the public header says. */
int nsdae_fc_prove(nsdae_fc_proof *proof, const nsdae_fc *fc, double *l);

void nsdae_fc_proof_release(nsdae_fc_proof *proof);

#endif
