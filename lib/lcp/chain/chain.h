/* The stages on a problem as a whole, and on its islands. */
#ifndef NSDAE_LCP_CHAIN_H
#define NSDAE_LCP_CHAIN_H

#include "work.h"

/* Runs the stages that the options name; returns the status of the solver. */
int nsdae_lcp_chain_run(nsdae_lcp_work *w);

/* Rows of the largest problem. */
enum { NSDAE_LCP_LARGEST = 20000 };

/* ---- the problem as it is given, before the chain */

/* b >= 0: x = 0, as far as the options name that stage. Returns whether that solved it. */
int nsdae_lcp_guess_nothing(nsdae_lcp_work *w);

/* The solution with the active set w->basis, as far as the options name that stage. Returns whether
 * it solves the problem, whatever it is scaled by and whatever islands it has; if so the residual
 * that it leaves in w->info is a bound to that of any of these. */
int nsdae_lcp_guess_basis(nsdae_lcp_work *w);

/* ---- Parts of a problem that have nothing to do with each other. */

/* label[i] = label[j] where unknowns i and j are joined by entries of A that are not zero: the
 * smallest index of those joined. Returns how many islands there are. */
int nsdae_islands_find(int n, const double *A, int lda, int *label);

/* The members of the island of that label, in order; returns how many. */
int nsdae_islands_members(int n, const int *label, int island, int *member);

#endif
