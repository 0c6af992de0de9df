/* A small island whose contacts are frictionless or planar is a linear complementarity problem, and
 * pivoting solves that exactly. */
#ifndef NSDAE_FRICTION_AS_LCP_H
#define NSDAE_FRICTION_AS_LCP_H

#include "scaled_island.h"

typedef struct nsdae_fc_as_lcp {
  int m;         /* rows that take part; 0: the island is no such problem */
  int bilateral; /* of these, the first */
  int n;         /* unknowns of the complementarity problem */
  int *row;      /* m: 3 k + j for row j of item k */
  double *W;     /* m x (m + 1): W + C of these rows, and q */
  double *A, *b; /* n x n, n */
  double *x, *y; /* n */
  int *basis;    /* n */
  double *work;
  int *iwork;
  int lwork, liwork;
} nsdae_fc_as_lcp;

/* Takes the arrays for the island fc. */
void nsdae_fc_as_lcp_layout(nsdae_fc_as_lcp *s, const nsdae_fc_scaled *fc, nsdae_arena *arena);

#endif
