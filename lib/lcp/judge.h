/* Whether a point solves the problem: the one place where that is said. */
#ifndef NSDAE_LCP_JUDGE_H
#define NSDAE_LCP_JUDGE_H

#include "chain.h"

/* Residual of c->x in equilibrated rows and columns; c->y := A x + b. Infinite where an x_i or y_i
 * is not a finite number, and where b is out of range. */
double nsdae_chain_residual(nsdae_chain *c);

/* Judges the point c->x and keeps it where it is the best so far. Returns whether it solves the
 * problem; outcome and stage are then set. */
int nsdae_chain_judge(nsdae_chain *c, int stage);

/* The same for the point of an active set, A_BB x_B = -b_B and all else zero; where it solves the
 * problem, the set becomes the caller's basis. */
int nsdae_chain_judge_basis(nsdae_chain *c, const int *basis, int stage);

#endif
