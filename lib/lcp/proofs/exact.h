/* Signs of sums of products, without rounding. */
#ifndef NSDAE_LCP_EXACT_H
#define NSDAE_LCP_EXACT_H

enum { NSDAE_SIGN_UNKNOWN = 2 };

/* Sign -1, 0 or 1 of the exact value of sum_i a_i u_i, i < n, with the entries of a stride apart;
 * NSDAE_SIGN_UNKNOWN where products are too far apart in size for it, or a factor is not finite. */
int nsdae_exact_sign(int n, const double *a, int stride, const double *u);

#endif
