/* The problem at work: what the stages of the solver share. */
#ifndef NSDAE_LCP_CHAIN_H
#define NSDAE_LCP_CHAIN_H

#include <nsdae/lcp.h>

typedef struct nsdae_chain {
  const nsdae_lcp_problem *problem;
  const nsdae_lcp_options *options;
  nsdae_lcp_info *info;
  int n;
  int *basis;           /* n: the caller's */
  double *x, *y;        /* n: the caller's; at work C^-1 x and R y of the point being judged */
  double *A, *b;        /* n x n, n: R A C, R b */
  double *row, *column; /* n: R and C */
  double *cover;        /* n */
  double *best;         /* n: the best point so far */
  double *sizes;        /* n: workspace of the residual */
  double *rhs;          /* n */
  double *lu;           /* n x n */
  double *point;        /* 2 n: x and y of a stage */
  double *wide;         /* 2 n^2 + 4 n: workspace of a stage */
  double *lemke;        /* lemke_size */
  int lemke_size;
  int *trial, *pivot;  /* n, n */
  int *index;          /* 2 n + 1 */
  int *allowed;        /* 2 n */
  int *label, *member; /* n, n: islands */
  int out_of_range;    /* no scale brings b to the middle of the range: nothing is judged */
  int ray;             /* Lemke's method with the vector of ones ended on one */
} nsdae_chain;

/* Doubles that the chain works in, without islands. */
double nsdae_chain_size(int n);

/* Sizes of the workspace, with room for the problem of an island beside it as far as an int can say
 * so, and its arrays. */
int nsdae_chain_sizes(int n, int *lwork, int *liwork);
void nsdae_chain_lay_out(nsdae_chain *c, double *work, int *iwork);

/* c->A, c->b: the problem in rows and columns of like size. */
void nsdae_chain_equilibrate(nsdae_chain *c);

/* Runs the stages that the options name; returns the status of the solver. */
int nsdae_chain_run_whole(nsdae_chain *c);

/* x and y of the best point as the problem was given, or where there is none, of zero; of a proof
 * by a vector, y is that vector. Below DBL_MIN doubles lie 2^-1074 apart: x is then what is nearest
 * to a point that was judged, not a solution itself to more than that. */
void nsdae_chain_hand_over(nsdae_chain *c);

/* The same for each island of the problem by itself, where it has more than one; work and iwork are
 * those that c was laid out in. */
int nsdae_chain_run(nsdae_chain *c, double *work, int lwork, int *iwork);

#endif
