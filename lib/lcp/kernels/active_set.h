/* The point that belongs to an active set. */
#ifndef NSDAE_LCP_ACTIVE_SET_H
#define NSDAE_LCP_ACTIVE_SET_H

/* index := F = {i: basis_i != 0}, lu := A_FF, column by column; returns the size of F. */
int nsdae_lcp_gather(int n, const double *A, int lda, const int *basis, double *lu, int *index);

/* x [n]: A_FF x_F = -b_F on the active set F = {i: basis_i != 0}, zero elsewhere; signs are not
 * judged. lu is [n x n], pivot and index [n]. Returned is the least pivot relative to its column
 * of U: 1 for an empty set, of rounding size where A_FF is singular to rounding, 0 (and x = 0)
 * where a pivot is zero. */
double nsdae_lcp_active_set(int n, const double *a, int lda, const double *b, const int *basis,
                            double *x, double *lu, int *pivot, int *index);

#endif
