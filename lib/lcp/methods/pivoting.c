/* Lemke's method, with the covering vector of ones and with others. */
#include <nsdae/kernels.h>
#include <stddef.h>

#include "lcp_methods.h"

enum { COVERINGS = 12 };

/* Residual of a solution that cannot be better. */
static const double ROUNDING = 1e-15;

int nsdae_lcp_lemke_once(nsdae_lcp_work *w, const double *cover, int *pivots)
{
  int n = w->n;
  int most = w->options->max_pivots > 0 ? w->options->max_pivots : 50 * n + 100;
  return nsdae_dlemke(n, w->scaled.A, n, w->scaled.b, cover, most, w->x, w->room.trial, pivots,
                      w->room.lemke, w->room.lemke_size, w->room.index);
}

static int lemke_with(nsdae_lcp_work *w, const double *cover, int stage)
{
  int pivots = 0, info = nsdae_lcp_lemke_once(w, cover, &pivots);
  w->info->pivots += pivots;
  if (!cover) w->ray = info == 1;
  if (info != 0) return 0;
  nsdae_lcp_judge(w, w->room.trial, stage);
  /* the basis solved at once has less rounding than its pivots */
  if (!(w->info->residual < ROUNDING)) nsdae_lcp_judge_basis(w, w->room.trial, stage);
  return nsdae_lcp_is_settled(w);
}

int nsdae_lcp_try_lemke(nsdae_lcp_work *w)
{
  return lemke_with(w, NULL, NSDAE_LCP_LEMKE);
}

int nsdae_lcp_try_coverings(nsdae_lcp_work *w)
{
  unsigned long long seed = 1;
  for (int k = 0; k < COVERINGS; k++) {
    nsdae_lcp_scatter(w->n, w->room.cover, &seed);
    if (lemke_with(w, w->room.cover, NSDAE_LCP_COVERING)) return 1;
  }
  return 0;
}
