/* nsdae_dlemke with the number of pivots that the dictionary puts off (0: none). */
#ifndef NSDAE_LCP_LEMKE_H
#define NSDAE_LCP_LEMKE_H

/* The lwork that nsdae_dlemke wants. */
int nsdae_lemke_work(int n);

/* The block that it takes. */
int nsdae_lemke_block(int n);

/* As nsdae_dlemke; the arguments are taken for right, work for nsdae_lemke_size long. */
int nsdae_lemke_size(int n, int block);
int nsdae_lemke(int n, int block, const double *a, int lda, const double *b, const double *d,
                int max_pivots, double *x, int *basis, int *pivots, double *work, int *iwork);

#endif
