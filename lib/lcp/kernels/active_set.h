/* The point that belongs to an active set. */
#ifndef NSDAE_LCP_ACTIVE_SET_H
#define NSDAE_LCP_ACTIVE_SET_H

/* index := F = {i: basis_i != 0}, lu := A_FF, column by column; returns the size of F. */
int nsdae_lcp_gather(int n, const double *A, int lda, const int *basis, double *lu, int *index);

/* A problem, a basis and its point; workspace. */
typedef struct nsdae_lcp_point {
  int n, lda;
  const double *a, *b;
  double *x, *lu, *y, *sizes; /* n, n x n, n, n; y and sizes of the residual */
  const int *basis;           /* n */
  int *pivot, *index;         /* n */
} nsdae_lcp_point;

/* x: A_FF x_F = -b_F on the active set F = {i: basis_i != 0}, zero elsewhere; signs are not
 * judged. Returns the size of F, whose members are in index; -1 (and x = 0) if a pivot is zero. */
int nsdae_lcp_active_set(const nsdae_lcp_point *p);

/* Of the factors of that size, the least pivot relative to its column of U: 1 for an empty set, of
 * rounding size if A_FF is singular to rounding. */
double nsdae_lcp_least_pivot(const nsdae_lcp_point *p, int size);

/* nsdae_dlcpres of the point. */
int nsdae_lcp_point_residual(const nsdae_lcp_point *p, double *residual);

#endif
