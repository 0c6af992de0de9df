/* LU factors of a matrix that is filled anew each time, of a size that changes: dense and in its
 * place, or sparse ones in memory of their own. */
#ifndef NSDAE_LINALG_LU_H
#define NSDAE_LINALG_LU_H

#include "sparse_lu.h"

typedef struct nsdae_lu {
  int most, is_sparse; /* the largest n; which */
  int n;               /* of the matrix at hand */
  double *A;           /* n x n, within most x most: to be filled; where dense, then its factors */
  int *pivot;          /* n, where dense */
  nsdae_sparse_lu sparse;
} nsdae_lu;

/* Takes the arrays; most and is_sparse are set before. */
void nsdae_lu_layout(nsdae_lu *lu, nsdae_arena *arena);

/* What follows is as after the layout, to the last bit, whatever was factored before. */
void nsdae_lu_forget(nsdae_lu *lu);

/* Factors A [n x n]. Returns 0, or not 0 where a pivot is zero or not a number. */
int nsdae_lu_factor(nsdae_lu *lu);

/* x [n] := A^-1 x. */
void nsdae_lu_solve(const nsdae_lu *lu, double *x);

#endif
