/* Whether a point solves the problem: the one place where that is said. */
#ifndef NSDAE_LCP_JUDGE_H
#define NSDAE_LCP_JUDGE_H

#include "chain.h"

/* Residual of c->x, in equilibrated rows and columns; c->y := A x + b. Infinite where an x_i or y_i
 * of the problem as given is not a finite number, and where b is out of range. */
double nsdae_chain_residual(nsdae_chain *c);

/* Judges the point c->x and keeps it where it is the best so far; where it solves the problem,
 * outcome, stage and the caller's basis are set. Returns whether the problem is settled. */
int nsdae_chain_judge(nsdae_chain *c, const int *basis, int stage);

/* The same for the point of an active set, A_BB x_B = -b_B and all else zero. */
int nsdae_chain_judge_basis(nsdae_chain *c, const int *basis, int stage);

/* Whether a solution is at hand that no other stage is likely to better. */
int nsdae_chain_is_settled(const nsdae_chain *c);

#endif
