/* One entry of the natural residual that nsdae_dlcpres takes the largest of. */
#ifndef NSDAE_LCP_RESIDUAL_H
#define NSDAE_LCP_RESIDUAL_H

/* The terms of a row count for its size up to this multiple of the largest b: larger ones would
 * hide b in their rounding, and any null vector of A that is long enough would pass for a solution.
 */
#define NSDAE_LCP_FAR 1e6

/* min(x / sx, y / sy) with its sign, x and y being the i-th of theirs; column is that of A, sizes
 * [n] is sy as nsdae_dlcpres leaves it in work. NaN where something is not finite. */
double nsdae_lcp_entry_error(int n, const double *column, int i, double x, double y,
                             const double *sizes);

#endif
