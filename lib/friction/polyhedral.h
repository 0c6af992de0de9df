/* A small island whose contacts are frictionless or planar is a linear complementarity problem, and
 * pivoting solves that exactly. */
#ifndef NSDAE_FRICTION_POLYHEDRAL_H
#define NSDAE_FRICTION_POLYHEDRAL_H

#include "island.h"

typedef struct nsdae_fc_polyhedral {
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
} nsdae_fc_polyhedral;

/* Takes the arrays for the island, where it is one; fc has its numbers of items. */
void nsdae_fc_polyhedral_layout(nsdae_fc_polyhedral *s, const nsdae_fc *fc, nsdae_arena *arena);

/* Solves the island into fc->r; y [ny] is work. Returns 0 where there is nothing to be had: it is
 * no such problem, its bilateral rows depend on each other, or no solution was found. */
int nsdae_fc_polyhedral_solve(nsdae_fc_polyhedral *s, nsdae_fc *fc, double tol, double *y);

#endif
