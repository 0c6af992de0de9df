/* Damped Newton on the semismooth equations from several starts; what it takes for positive is
 * solved at once, or else where Lemke's method starts. */
#include <math.h>
#include <nsdae/kernels.h>
#include <string.h>

#include "lcp_methods.h"
#include "vector.h"

/* Starts of the semismooth Newton method. */
enum { STARTS = 24, EARLY = 4, ITERATIONS = 60, LARGE = 100 };

/* Lemke's method from the active set in w->room.trial, which need not be right: on the problem in
 * which its x and y have changed places. */
static int lemke_from_trial(nsdae_lcp_work *w, int stage)
{
  int n = w->n, pivots = 0;
  int most = w->options->max_pivots > 0 ? w->options->max_pivots : 50 * n + 100;
  int *set = w->room.allowed;
  double *T = w->room.wide, *t = w->room.point;
  memcpy(set, w->room.trial, (size_t)n * sizeof *set);
  if (nsdae_lcp_transform(n, w->scaled.A, w->scaled.b, set, T, t, T + (size_t)n * (size_t)n,
                          w->room.pivot, w->room.index) != 0)
    return 0;
  int info = nsdae_dlemke(n, T, n, t, NULL, most, w->x, w->room.trial, &pivots, w->room.lemke,
                          w->room.lemke_size, w->room.index);
  w->info->pivots += pivots;
  if (info != 0) return 0;
  for (int i = 0; i < n; i++) w->room.trial[i] = w->room.trial[i] != (set[i] != 0);
  return nsdae_lcp_judge_basis(w, w->room.trial, stage);
}

/* The method from the starts first .. end - 1: x = 0, the size of b, then at random up to it. What
 * an iterate takes for positive is solved at once, then the iterate itself is judged. */
static int run_starts(nsdae_lcp_work *w, int first, int end, int stage)
{
  unsigned long long seed = 7 + (unsigned long long)first;
  double *x = w->room.point, *y = w->room.point + w->n, most = nsdae_largest(w->n, w->scaled.b);
  for (int k = first; k < end; k++) {
    nsdae_lcp_scatter(w->n, w->room.cover, &seed);
    for (int i = 0; i < w->n; i++)
      x[i] = k == 0 ? 0 : k == 1 ? fmax(-w->scaled.b[i], 0) : most * w->room.cover[i];
    int memory = k % 2 == 0 ? 1 : NSDAE_FISCHER_MEMORY;
    nsdae_fischer(w->n, w->scaled.A, w->scaled.b, ITERATIONS, memory, x, y, w->room.wide);
    for (int i = 0; i < w->n; i++) w->room.trial[i] = x[i] > y[i];
    if (nsdae_lcp_judge_basis(w, w->room.trial, stage)) return 1;
    for (int i = 0; i < w->n; i++) w->x[i] = fmax(x[i], 0);
    if (nsdae_lcp_judge(w, w->room.trial, stage) || lemke_from_trial(w, stage)) return 1;
  }
  return 0;
}

/* Of a large problem, the first starts before all that takes as many runs of Lemke's method. */
int nsdae_lcp_try_newton(nsdae_lcp_work *w)
{
  return w->n >= LARGE && run_starts(w, 0, EARLY, NSDAE_LCP_NEWTON);
}

/* Those that are left. */
int nsdae_lcp_try_further(nsdae_lcp_work *w)
{
  int tried = w->n >= LARGE && (w->options->stages & NSDAE_LCP_NEWTON);
  return run_starts(w, tried ? EARLY : 0, STARTS, NSDAE_LCP_FURTHER);
}
