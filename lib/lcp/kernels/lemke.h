/* nsdae_dlemke with the number of pivots that the dictionary puts off (0: none). */
#ifndef NSDAE_LCP_LEMKE_H
#define NSDAE_LCP_LEMKE_H

/* The block that nsdae_dlemke takes for n, where its work is long enough. */
int nsdae_lemke_block(int n);

/* The arguments are taken for right; work [nsdae_dictionary_size(n, block)]. */
int nsdae_lemke(int n, int block, const double *a, int lda, const double *b, const double *d,
                int max_pivots, double *x, int *basis, int *pivots, double *work, int *iwork);

#endif
