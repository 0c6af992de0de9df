/* Parts of a problem that have nothing to do with each other. */
#ifndef NSDAE_LCP_ISLANDS_H
#define NSDAE_LCP_ISLANDS_H

/* label[i] = label[j] where unknowns i and j are joined by entries of A that are not zero: the
 * smallest index of those joined. Returns how many islands there are. */
int nsdae_islands_find(int n, const double *A, int lda, int *label);

/* The members of the island of that label, in order; returns how many. */
int nsdae_islands_members(int n, const int *label, int island, int *member);

#endif
