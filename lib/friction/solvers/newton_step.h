/* One step of Newton's method on the natural map of an island, or on a smooth neighbour of it, with
 * a proximal term. With F and its derivatives B in r and A in u, and u = J^T y + q + C r + alpha (r
 * - centre),
 *
 *   (B + A (C + alpha)) dr + A J^T dy = -F,   dy = J dr      (see newton_system.h) */
#ifndef NSDAE_FRICTION_NEWTON_STEP_H
#define NSDAE_FRICTION_NEWTON_STEP_H

#include "newton_system.h"

typedef struct nsdae_fc_newton {
  nsdae_fc_scaled *fc;
  nsdae_fc_system *system;
  double alpha;          /* of the proximal term alpha (r - centre) that is added to u */
  double epsilon;        /* of the smoothed map; 0: the natural map */
  int search;            /* line search: a step is halved until the map decreases */
  double *centre;        /* 3 n */
  double *E, *A;         /* 9 n: derivatives of the map in r and u, both with the proximal term */
  double *F;             /* 3 n: the map */
  double *dr;            /* 3 n */
  double *trial, *y, *u; /* 3 n, ny, 3 n: a point, and its velocities */
} nsdae_fc_newton;

/* Takes the arrays; fc is set before. */
void nsdae_fc_newton_layout(nsdae_fc_newton *newton, nsdae_arena *arena);

/* dr [3 n] of b [3 n], by the factors of E and A, refined; neither of them is trial, y or u. */
void nsdae_fc_newton_solve(nsdae_fc_newton *newton, const double *b, double *dr);

#endif
