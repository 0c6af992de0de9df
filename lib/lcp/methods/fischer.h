/* Damped Newton on the semismooth equations of Fischer and Burmeister. */
#ifndef NSDAE_LCP_FISCHER_H
#define NSDAE_LCP_FISCHER_H

enum { NSDAE_FISCHER_MEMORY = 10 };

/* memory: how many norms back a step may rise to, in [1, NSDAE_FISCHER_MEMORY]; 1: always lower.
 * x, y [n] in: the start (y is made from x); out: the last iterate. A is n x n with leading
 * dimension n; work has 2 n^2 + 4 n. Returns the norm of the residual. */
double nsdae_fischer(int n, const double *A, const double *b, int iterations, int memory, double *x,
                     double *y, double *work);

#endif
