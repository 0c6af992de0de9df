/* Whether a point solves the problem: the only test of that. */
#ifndef NSDAE_LCP_JUDGE_H
#define NSDAE_LCP_JUDGE_H

#include "work.h"

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
