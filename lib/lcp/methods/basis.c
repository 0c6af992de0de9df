/* Active sets that need no search. */
#include <string.h>

#include "judge.h"
#include "lcp_methods.h"

int nsdae_lcp_try_trivial(nsdae_lcp_work *w)
{
  for (int i = 0; i < w->n; i++)
    if (w->scaled.b[i] < 0) return 0;
  memset(w->room.trial, 0, (size_t)w->n * sizeof *w->room.trial);
  memset(w->x, 0, (size_t)w->n * sizeof *w->x);
  return nsdae_lcp_judge(w, w->room.trial, NSDAE_LCP_TRIVIAL);
}

int nsdae_lcp_try_warm(nsdae_lcp_work *w)
{
  int any = 0;
  for (int i = 0; i < w->n; i++) any |= w->basis[i];
  return any && nsdae_lcp_judge_basis(w, w->basis, NSDAE_LCP_WARM);
}
