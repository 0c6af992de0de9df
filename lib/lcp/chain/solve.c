/* The solver as it is called: arguments, workspace, names. */
#include <math.h>
#include <nsdae/lcp.h>
#include <stdlib.h>

#include "chain.h"
#include "finite.h"

void nsdae_lcp_options_default(nsdae_lcp_options *options)
{
  if (!options) return;
  *options = (nsdae_lcp_options){.tol = 1e-10, .stages = NSDAE_LCP_ALL, .enumerate_max = 12};
}

const char *nsdae_lcp_stage_name(int stage)
{
  switch (stage) {
  case NSDAE_LCP_NONE:
    return "none";
#define NAME(name, value, word, text) \
  case value:                         \
    return word;
    NSDAE_LCP_STAGE_LIST(NAME)
#undef NAME
  default:
    return "unknown";
  }
}

const char *nsdae_lcp_ray_name(int ray)
{
  static const char *const name[] = {"nothing", "not copositive", "not strictly copositive"};
  return ray >= 0 && ray <= NSDAE_LCP_RAY_NOT_STRICTLY_COPOSITIVE ? name[ray] : "unknown";
}

/* Status of what both ways of calling take. */
static int check_solve(const nsdae_lcp_problem *p, const nsdae_lcp_options *o, const double *x,
                       const double *y)
{
  if (!p || p->n < 0 || p->n > NSDAE_LCP_LARGEST || p->lda < 1 || p->lda < p->n)
    return NSDAE_E_ARGUMENT;
  if (p->n > 0 && (!p->A || !p->b || !x || !y)) return NSDAE_E_ARGUMENT;
  if (!(o->tol > 0 && o->tol <= 1) || o->max_pivots < 0 || o->stages < 0 ||
      o->stages > NSDAE_LCP_ALL || o->enumerate_max < 0 || o->enumerate_max > 24)
    return NSDAE_E_ARGUMENT;
  int finite = nsdae_lcp_finite(p->n, 1, p->b, 1) && nsdae_lcp_finite(p->n, p->n, p->A, p->lda);
  return finite ? NSDAE_OK : NSDAE_E_NONFINITE;
}

int nsdae_lcp_solve_in(const nsdae_lcp_problem *problem, const nsdae_lcp_options *options,
                       int *basis, double *x, double *y, nsdae_lcp_info *info, double *work,
                       int lwork, int *iwork, int liwork)
{
  nsdae_lcp_options defaults;
  nsdae_lcp_info own;
  int need, ineed;
  nsdae_lcp_options_default(&defaults);
  nsdae_lcp_work w = {.problem = problem,
                      .options = options ? options : &defaults,
                      .info = info ? info : &own,
                      .basis = basis,
                      .x = x,
                      .y = y};
  *w.info = (nsdae_lcp_info){.residual = INFINITY};
  int status = check_solve(problem, w.options, x, y);
  if (status != NSDAE_OK) return status;
  w.n = problem->n;
  nsdae_lcp_workspace(w.n, &need, &ineed);
  if (!work || lwork < need || !iwork || liwork < ineed || (w.n > 0 && !basis))
    return NSDAE_E_ARGUMENT;
  nsdae_lcp_work_lay_out(&w, work, iwork);
  return nsdae_lcp_islands_run(&w, work, lwork, iwork);
}

int nsdae_lcp_solve(const nsdae_lcp_problem *problem, const nsdae_lcp_options *options, double *x,
                    double *y, nsdae_lcp_info *info)
{
  nsdae_lcp_options defaults;
  int lwork, liwork;
  if (info) *info = (nsdae_lcp_info){.residual = INFINITY};
  nsdae_lcp_options_default(&defaults);
  int status = check_solve(problem, options ? options : &defaults, x, y);
  if (status != NSDAE_OK) return status;
  size_t n = (size_t)problem->n;
  nsdae_lcp_workspace(problem->n, &lwork, &liwork);
  char *block = malloc((size_t)lwork * sizeof(double) + ((size_t)liwork + n) * sizeof(int));
  if (!block) return NSDAE_E_MEMORY;
  double *work = (double *)(void *)block;
  int *iwork = (int *)(void *)(block + (size_t)lwork * sizeof(double)), *basis = iwork + liwork;
  for (size_t i = 0; i < n; i++) basis[i] = x[i] > 0;
  status = nsdae_lcp_solve_in(problem, options, basis, x, y, info, work, lwork, iwork, liwork);
  free(block);
  return status;
}
