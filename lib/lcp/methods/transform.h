/* The principal pivot transform of a problem. */
#ifndef NSDAE_LCP_TRANSFORM_H
#define NSDAE_LCP_TRANSFORM_H

/* T [n x n], t [n] := the problem in which x_i and y_i have changed places where basis[i] is not 0:
 *   T = [A_BB^-1  -A_BB^-1 A_BN;  A_NB A_BB^-1  A_NN - A_NB A_BB^-1 A_BN]
 *   t = [-A_BB^-1 b_B;  b_N - A_NB A_BB^-1 b_B]
 * A is n x n with leading dimension n. Returns 0, or 1 where A_BB is singular. work [n^2 + n],
 * pivot [n], index [n] */
int nsdae_lcp_transform(int n, const double *A, const double *b, const int *basis, double *T,
                        double *t, double *work, int *pivot, int *index);

#endif
