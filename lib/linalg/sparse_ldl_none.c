/* A build without SuiteSparse's LDL. */
#include <math.h>
#include <nsdae/status.h>

#include "sparse_ldl.h"

double nsdae_sparse_ldl_work(const nsdae_multifrontal *f)
{
  (void)f;
  return HUGE_VAL;
}

int nsdae_sparse_ldl_analyse(nsdae_sparse_ldl *l, const nsdae_multifrontal *f)
{
  (void)l, (void)f;
  return NSDAE_E_UNSUPPORTED;
}

int nsdae_sparse_ldl_factor(nsdae_sparse_ldl *l, const nsdae_multifrontal *f, double drop)
{
  (void)l, (void)f, (void)drop;
  return 1;
}

void nsdae_sparse_ldl_solve(const nsdae_sparse_ldl *l, const nsdae_multifrontal *f, double *x)
{
  (void)l, (void)f, (void)x;
}

void nsdae_sparse_ldl_release(nsdae_sparse_ldl *l)
{
  (void)l;
}
