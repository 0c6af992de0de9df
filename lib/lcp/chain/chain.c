/* One stage after the other until the residual, computed afresh from A and b, is below the
 * tolerance.
 */
#include "chain.h"

#include <string.h>

#include "lcp_methods.h"
#include "proof.h"

/* b >= 0, and the active set of the caller: neither needs a search. */
static int try_trivial(nsdae_lcp_work *w)
{
  for (int i = 0; i < w->n; i++)
    if (w->scaled.b[i] < 0) return 0;
  memset(w->room.trial, 0, (size_t)w->n * sizeof *w->room.trial);
  memset(w->x, 0, (size_t)w->n * sizeof *w->x);
  return nsdae_lcp_judge(w, w->room.trial, NSDAE_LCP_TRIVIAL);
}

static int try_warm(nsdae_lcp_work *w)
{
  int any = 0;
  for (int i = 0; i < w->n; i++) any |= w->basis[i];
  return any && nsdae_lcp_judge_basis(w, w->basis, NSDAE_LCP_WARM);
}

/* With a solution at hand, if a doubted one, there is nothing to be proved. */
static int prove(nsdae_lcp_work *w)
{
  return w->info->outcome != NSDAE_OUTCOME_SOLVED && nsdae_lcp_prove(w);
}

static int enumerate(nsdae_lcp_work *w)
{
  if (w->n > w->options->enumerate_max) return 0;
  if (w->info->outcome != NSDAE_OUTCOME_SOLVED && nsdae_lcp_prove_all(w)) return 1;
  for (long set = 0; set < 1L << w->n; set++) {
    for (int i = 0; i < w->n; i++) w->room.trial[i] = (int)(set >> i & 1);
    if (nsdae_lcp_judge_basis(w, w->room.trial, NSDAE_LCP_ENUMERATE)) return 1;
  }
  return 0;
}

/* In the order of their bits. Each returns whether the chain ends with it: with a proof, or
 * settled.
 */
static int (*const stages[])(nsdae_lcp_work *) = {try_trivial,
                                                  try_warm,
                                                  nsdae_lcp_try_lemke,
                                                  nsdae_lcp_try_newton,
                                                  nsdae_lcp_try_coverings,
                                                  prove,
                                                  nsdae_lcp_try_further,
                                                  enumerate};

int nsdae_lcp_chain_run(nsdae_lcp_work *w)
{
  nsdae_lcp_work_scale(w);
  for (size_t k = 0; k < sizeof stages / sizeof *stages; k++)
    if ((w->options->stages & 1 << k) && stages[k](w)) break;
  int status = w->info->outcome == NSDAE_OUTCOME_SOLVED       ? NSDAE_OK
               : w->info->outcome == NSDAE_OUTCOME_INFEASIBLE ? NSDAE_E_INFEASIBLE
                                                              : NSDAE_E_LCP;
  if (status != NSDAE_OK && w->ray && w->n <= NSDAE_RAY_MAX) {
    /* The ray again, from which a later stage took the arrays. */
    int pivots;
    if (nsdae_lcp_lemke_once(w, NULL, &pivots) == 1) nsdae_lcp_read_ray(w);
  }
  nsdae_lcp_hand_over(w);
  return status;
}
