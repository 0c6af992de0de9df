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

/* nsdae_dlcpres of the point. */
int nsdae_lcp_point_residual(const nsdae_lcp_point *p, double *residual);

/* ---- One entry of the natural residual that nsdae_dlcpres takes the largest of. */

/* The terms of a row count for its size up to this multiple of the largest b: larger ones would
 * hide b in their rounding, and any null vector of A that is long enough would pass for a solution.
 */
#define NSDAE_LCP_FAR 1e6

/* min(x / sx, y / sy) with its sign, x and y being the i-th of theirs; column is that of A, sizes
 * [n] is sy as nsdae_dlcpres leaves it in work. NaN where something is not finite. */
double nsdae_lcp_entry_error(int n, const double *column, int i, double x, double y,
                             const double *sizes);

#endif
