#include "newton_kkt.h"

#include <string.h>

/* Relative error of a linear solution that Newton's iteration corrects as well: far below the share
 * of a third of rtol that it stops at, for rtol of 1e-9 and more. */
static const double ENOUGH = 1e-10;

void nsdae_newton_kkt_layout(nsdae_newton_kkt *b, const nsdae_system *system, int most,
                             double rank_tol, nsdae_arena *arena)
{
  b->matrix.system = system;
  b->kkt.n = system->dims.nv;
  b->kkt.m = system->dims.m;
  b->kkt.blocks = &system->blocks;
  b->kkt.rank_tol = rank_tol;
  b->kkt.sparse.enough = ENOUGH;
  b->border.kkt = &b->kkt;
  nsdae_newton_matrix_layout(&b->matrix, arena);
  nsdae_kkt_layout(&b->kkt, arena);
  nsdae_border_layout(&b->border, &system->dims, most, arena);
}

int nsdae_newton_kkt_make(nsdae_newton_kkt *b)
{
  b->started = 0;
  return nsdae_newton_matrix_make(&b->matrix);
}

void nsdae_newton_kkt_release(nsdae_newton_kkt *b)
{
  nsdae_newton_matrix_release(&b->matrix);
  nsdae_kkt_release(&b->kkt);
}

int nsdae_newton_kkt_start(nsdae_newton_kkt *b, nsdae_terms *T)
{
  nsdae_newton_matrix *N = &b->matrix;
  if (b->started || T->system->blocks.count == 1) return NSDAE_OK;
  int status = nsdae_newton_matrix_start(N, T);
  if (status == NSDAE_OK) status = nsdae_terms_need(T, NSDAE_TERM_MASS | NSDAE_TERM_JACOBIAN);
  if (status < 0) return status;
  memset(N->pairs.value, 0, N->pairs.values * sizeof *N->pairs.value);
  status = nsdae_kkt_factor_coupled(&b->kkt, T->M, &N->coupling, &T->by.jacobian, NULL, b->kkt.m);
  if (status == NSDAE_E_MEMORY) return nsdae_terms_unsolved(T, &b->kkt, status);
  b->started = 1; /* dependent rows do not matter here */
  return NSDAE_OK;
}

int nsdae_newton_kkt_factor(nsdae_newton_kkt *b, nsdae_terms *T, double cj, const double *basis,
                            int rank)
{
  b->border.count = 0;
  int status = nsdae_terms_newton_matrix(T, cj, &b->matrix);
  if (status < 0) return status;
  status = nsdae_kkt_factor_coupled(&b->kkt, b->matrix.A, &b->matrix.coupling, &T->by.jacobian,
                                    basis, rank);
  return status < 0 ? nsdae_terms_unsolved(T, &b->kkt, status) : NSDAE_OK;
}
