/* Powers of two that make the rows and columns of a matrix alike in size. */
#ifndef NSDAE_LCP_EQUILIBRATE_H
#define NSDAE_LCP_EQUILIBRATE_H

/* A [n x n] := R A C, b [n] := R b, R and C diagonal in row [n] and column [n]: with them, the
 * complementarity problem has the solution C^-1 x, R y. No rounding is added. Where the largest
 * entries of all rows and columns that are not zero are in [1/256, 256], A stays; where b is
 * moderate too, R = C = 1. work [2 n], iwork [4 n]. */
void nsdae_equilibrate(int n, double *A, double *b, double *row, double *column, double *work,
                       int *iwork);

#endif
