#include <stdlib.h>

#include <LCP_Solvers.h>
#include <LinearComplementarityProblem.h>
#include <NumericsMatrix.h>
#include <SolverOptions.h>
#include <lcp_cst.h>

#include "lcp_rival.h"

struct rival {
  LinearComplementarityProblem problem;
  NumericsMatrix *M;
  SolverOptions *options;
};

rival *rival_create(int n, double *A, double *b)
{
  rival *r = malloc(sizeof *r);
  if (!r) return NULL;
  r->M = NM_new();
  NM_fill(r->M, NM_DENSE, n, n, A);
  r->problem = (LinearComplementarityProblem){.size = n, .M = r->M, .q = b};
  r->options = solver_options_create(SICONOS_LCP_LEMKE);
  r->options->iparam[SICONOS_IPARAM_MAX_ITER] = 50 * n + 100;
  return r;
}

void rival_destroy(rival *r)
{
  if (!r) return;
  solver_options_delete(r->options);
  free(r->options);
  r->M->matrix0 = NULL; /* the caller's */
  NM_clear(r->M);
  free(r->M);
  free(r);
}

int rival_solve(rival *r, double *x, double *y)
{
  int info = 1;
  lcp_lexicolemke(&r->problem, x, y, &info, r->options);
  return info;
}
