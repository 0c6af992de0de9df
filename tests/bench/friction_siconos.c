#include <stdlib.h>

#include <FrictionContactProblem.h>
#include <Friction_cst.h>
#include <NonSmoothDrivers.h>
#include <NumericsMatrix.h>
#include <SolverOptions.h>
#include <SparseBlockMatrix.h>

#include "friction_rival.h"

/* Proximal point with a semismooth Newton method inside, the one to beat, and block Gauss-Seidel.
 */
static const struct {
  const char *name;
  int id, blocks, iterations;
} peers[] = {{"Siconos PROX", SICONOS_FRICTION_3D_PROX, 0, 1000},
             {"Siconos NSGS", SICONOS_FRICTION_3D_NSGS, 1, 1000000}};

int friction_rivals(void)
{
  return (int)(sizeof peers / sizeof *peers);
}

const char *friction_rival_name(int peer)
{
  return peers[peer].name;
}

static NumericsMatrix *sparse(const nsdae_friction_problem *p)
{
  int n = 3 * p->contacts;
  NumericsMatrix *M = NM_create(NM_SPARSE, n, n);
  NM_triplet_alloc(M, 9 * p->first[p->contacts]);
  for (int i = 0; i < p->contacts; i++)
    for (int k = p->first[i]; k < p->first[i + 1]; k++)
      for (int e = 0; e < 9; e++)
        if (p->value[9 * (size_t)k + (size_t)e] != 0)
          NM_entry(M, 3 * p->block[k] + e % 3, 3 * i + e / 3, p->value[9 * (size_t)k + (size_t)e]);
  NM_csc(M);
  return M;
}

/* By blocks of three, which its Gauss-Seidel is made for. */
static NumericsMatrix *by_blocks(NumericsMatrix *from)
{
  NumericsMatrix *M = NM_new();
  SparseBlockStructuredMatrix *blocks = SBM_new();
  SBM_from_csparse(3, NM_csc(from), blocks);
  NM_fill(M, NM_SPARSE_BLOCK, from->size0, from->size1, blocks);
  return M;
}

/* The process ends after it: nothing is freed. */
int friction_rival_solve(int peer, const nsdae_friction_problem *local, double tol, double *r)
{
  NumericsMatrix *M = sparse(local);
  double *u = calloc(3 * (size_t)local->contacts + 1, sizeof *u);
  FrictionContactProblem problem = {.dimension = 3,
                                    .numberOfContacts = local->contacts,
                                    .M = peers[peer].blocks ? by_blocks(M) : M,
                                    .q = (double *)local->w,
                                    .mu = (double *)local->mu};
  SolverOptions *options = solver_options_create(peers[peer].id);
  options->dparam[SICONOS_DPARAM_TOL] = tol;
  options->iparam[SICONOS_IPARAM_MAX_ITER] = peers[peer].iterations;
  return fc3d_driver(&problem, r, u, options);
}
