/* Siconos's lexicographic Lemke, so that it can be timed on the same problems in the same run; all
 * but its call is done beforehand. Where Siconos is not there, rival_create returns NULL. */
#ifndef NSDAE_BENCH_LCP_RIVAL_H
#define NSDAE_BENCH_LCP_RIVAL_H

typedef struct rival rival;

/* A [n x n] and b [n] are kept as they are: the caller's, for as long as the rival is used. */
rival *rival_create(int n, double *A, double *b);
void rival_destroy(rival *r);

/* x [n]; returns its info, 0 for what it takes for solved. */
int rival_solve(rival *r, double *x, double *y);

#endif
