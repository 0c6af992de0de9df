/* The problem at work: what the stages of the chain share. */
#ifndef NSDAE_LCP_WORK_H
#define NSDAE_LCP_WORK_H

#include <nsdae/lcp.h>

/* The problem in rows and columns of like size, R A C and R b. */
typedef struct nsdae_lcp_scaled {
  double *A, *b;        /* n x n, n */
  double *row, *column; /* n: R and C, powers of two */
  int out_of_range;     /* no scale brings b to the middle of the range: nothing is judged */
} nsdae_lcp_scaled;

/* What a stage works in; nothing in it outlives the stage, except the vector of a proof in point.
 */
typedef struct nsdae_lcp_room {
  double *cover;  /* n */
  double *sizes;  /* n: of the residual */
  double *rhs;    /* n */
  double *lu;     /* n x n */
  double *point;  /* 2 n: x and y of a stage */
  double *wide;   /* 2 n^2 + 4 n */
  double *lemke;  /* lemke_size */
  int lemke_size; /* what nsdae_dlemke asks for */
  int *trial;     /* n: a basis */
  int *pivot;     /* n */
  int *index;     /* 2 n + 1 */
  int *allowed;   /* 2 n */
} nsdae_lcp_room;

typedef struct nsdae_lcp_work {
  const nsdae_lcp_problem *problem;
  const nsdae_lcp_options *options;
  nsdae_lcp_info *info;
  int n;
  int *basis;    /* n: the caller's */
  double *x, *y; /* n: the caller's; at work C^-1 x and R y of the point being judged */
  double *best;  /* n: C^-1 x of the best point so far */
  nsdae_lcp_scaled scaled;
  nsdae_lcp_room room;
  int ray; /* Lemke's method with the vector of ones ended on one */
} nsdae_lcp_work;

/* Doubles and ints that the chain works in on one island. */
double nsdae_lcp_work_doubles(int n);
int nsdae_lcp_work_ints(int n);

void nsdae_lcp_work_lay_out(nsdae_lcp_work *w, double *work, int *iwork);

/* Fills w->scaled. */
void nsdae_lcp_work_scale(nsdae_lcp_work *w);

/* ---- equilibrate.c: Powers of two that make the rows and columns of a matrix alike in size. */

/* A [n x n] := R A C, b [n] := R b, R and C diagonal in row [n] and column [n]: with them, the
 * complementarity problem has the solution C^-1 x, R y. No rounding is added. Where the largest
 * entries of all rows and columns that are not zero are in [1/256, 256], A stays; where b is
 * moderate too, R = C = 1. work [2 n], iwork [4 n]. */
void nsdae_equilibrate(int n, double *A, double *b, double *row, double *column, double *work,
                       int *iwork);

/* ---- Whether a point solves the problem: the only test of that. */

/* Judges the point w->x and keeps it where it is the best so far; where it solves the problem,
 * outcome, stage and the caller's basis are set. Returns whether the problem is settled. */
int nsdae_lcp_judge(nsdae_lcp_work *w, const int *basis, int stage);

/* The same for the point of an active set, A_BB x_B = -b_B and all else zero. */
int nsdae_lcp_judge_basis(nsdae_lcp_work *w, const int *basis, int stage);

/* Whether a solution is at hand that no other stage is likely to better. */
int nsdae_lcp_is_settled(const nsdae_lcp_work *w);

/* x and y of the best point as the problem was given, or where there is none, of zero; of a proof
 * by a vector, y is that vector. Below DBL_MIN doubles lie 2^-1074 apart: x is then what is nearest
 * to a point that was judged, not a solution itself to more than that. */
void nsdae_lcp_hand_over(nsdae_lcp_work *w);

#endif
