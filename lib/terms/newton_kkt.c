#include "newton_kkt.h"

#include <string.h>

#include "vector.h"

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
  nsdae_border_layout(&b->border, system, most, arena);
  b->border.coupling = &b->matrix.coupling;
}

int nsdae_newton_kkt_make(nsdae_newton_kkt *b)
{
  b->started = 0;
  return nsdae_newton_matrix_make(&b->matrix);
}

void nsdae_newton_kkt_release(nsdae_newton_kkt *b)
{
  nsdae_block_pairs_release(&b->matrix.pairs);
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

/* ---- the equations */

int nsdae_newton_kkt_move(nsdae_terms *T, double t, const double *y, const double *ydot, double cj,
                          double *room, double *r)
{
  int nq = T->system->dims.nq;
  nsdae_terms_at(T, t, y, y + nq);
  int status = nsdae_kinematics_at(T, T->v, room);
  for (int i = 0; i < nq; i++) r[i] = ydot[i] - room[i];
  nsdae_move(nq, y, -1 / cj, r, room);
  memcpy(room + nq, y + nq, (size_t)T->system->dims.nv * sizeof *y);
  return status;
}

void nsdae_newton_kkt_residual(const nsdae_terms *T, double alpha, double beta, const double *y,
                               const double *ydot, double *r)
{
  const nsdae_blocks *blocks = &T->system->blocks;
  const nsdae_dims *d = &T->system->dims;
  const double *lambda = y + d->nq + d->nv, *acceleration = ydot + d->nq;
  double *v = r + d->nq, *of = v + d->nv;
  for (int i = 0; i < d->nv; i++) v[i] = -T->F[i];
  nsdae_blocks_add_product(blocks, T->M, acceleration, v);
  for (int i = 0; i < d->m; i++) {
    nsdae_rows_add(blocks, &T->by.jacobian, i, lambda[i], v);
    of[i] = nsdae_terms_rate(T, &T->by.jacobian, T->constraint.omega, i, acceleration) +
            2 * alpha * nsdae_terms_constraint_rate(T, i, T->v) +
            beta * beta * T->constraint.phi[i];
  }
}

int nsdae_newton_kkt_solve(const nsdae_newton_kkt *b, nsdae_terms *T, double cj, double alpha,
                           double beta, const double *r, double *x, double *phi)
{
  const nsdae_dims *d = &T->system->dims;
  double *dv = x + d->nq, *l = dv + d->nv;
  for (int i = 0; i < d->nv; i++) dv[i] = r[d->nq + i] / cj;
  for (int i = 0; i < d->m; i++) l[i] = r[d->nq + d->nv + i] / (cj + 2 * alpha + beta * beta / cj);
  int status = nsdae_border_solve(&b->border, T, dv, l, phi);
  if (status == NSDAE_OK) status = nsdae_kinematics_at(T, dv, x);
  for (int i = 0; i < d->m; i++) l[i] *= cj;
  for (int i = 0; i < d->nq; i++) x[i] = (x[i] + r[i]) / cj;
  return status;
}
