/* Vectors in all directions. */
#ifndef NSDAE_LCP_SCATTER_H
#define NSDAE_LCP_SCATTER_H

/* x [n]: entries in (0, 1] from a linear congruential generator (Knuth's MMIX), always the same
 * ones for the same seed, which goes on. */
static inline void nsdae_lcp_scatter(int n, double *x, unsigned long long *seed)
{
  for (int i = 0; i < n; i++) {
    *seed = *seed * 6364136223846793005ull + 1442695040888963407ull;
    x[i] = ((double)(*seed >> 40) + 1) / 16777216.0;
  }
}

#endif
