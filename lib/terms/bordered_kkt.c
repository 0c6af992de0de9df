#include "bordered_kkt.h"

#include <string.h>

#include "dense.h"

/* Relative error of a linear solution that Newton's iteration corrects as well: far below the share
 * of a third of rtol that it stops at, for rtol of 1e-9 and more. */
static const double ENOUGH = 1e-10;

void nsdae_bordered_layout(nsdae_bordered_kkt *b, const nsdae_system *system, int most,
                           double rank_tol, nsdae_arena *arena)
{
  const nsdae_dims *d = &system->dims;
  long n = d->nv, m = d->m;
  b->matrix.system = system;
  b->most = most;
  b->kkt.n = d->nv;
  b->kkt.m = d->m;
  b->kkt.blocks = &system->blocks;
  b->kkt.rank_tol = rank_tol;
  b->kkt.sparse.enough = ENOUGH;
  nsdae_newton_matrix_layout(&b->matrix, arena);
  nsdae_kkt_layout(&b->kkt, arena);
  b->V = NSDAE_ARENA_DOUBLES(arena, n * most);
  b->L = NSDAE_ARENA_DOUBLES(arena, m * most);
  b->G = NSDAE_ARENA_DOUBLES(arena, n * most);
  b->h = NSDAE_ARENA_DOUBLES(arena, most);
  b->B = NSDAE_ARENA_DOUBLES(arena, (long)most * most);
  b->row = NSDAE_ARENA_INTS(arena, most);
  b->pivot = NSDAE_ARENA_INTS(arena, most);
}

int nsdae_bordered_make(nsdae_bordered_kkt *b)
{
  b->started = 0;
  return nsdae_newton_matrix_make(&b->matrix);
}

void nsdae_bordered_release(nsdae_bordered_kkt *b)
{
  nsdae_newton_matrix_release(&b->matrix);
  nsdae_kkt_release(&b->kkt);
}

int nsdae_bordered_start(nsdae_bordered_kkt *b, nsdae_terms *T)
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

int nsdae_bordered_factor(nsdae_bordered_kkt *b, nsdae_terms *T, double cj, const double *basis,
                          int rank)
{
  b->count = 0;
  int status = nsdae_terms_newton_matrix(T, cj, &b->matrix);
  if (status < 0) return status;
  status = nsdae_kkt_factor_coupled(&b->kkt, b->matrix.A, &b->matrix.coupling, &T->by.jacobian,
                                    basis, rank);
  return status < 0 ? nsdae_terms_unsolved(T, &b->kkt, status) : NSDAE_OK;
}

int nsdae_bordered_add(nsdae_bordered_kkt *b, const nsdae_terms *T, const nsdae_rows *rows, int i)
{
  size_t n = (size_t)b->kkt.n;
  int a = b->count++;
  memset(b->V + (size_t)a * n, 0, n * sizeof *b->V);
  memset(b->G + (size_t)a * n, 0, n * sizeof *b->G);
  nsdae_rows_add(&T->system->blocks, rows, i, 1, b->V + (size_t)a * n);
  b->h[a] = 0;
  b->row[a] = -1;
  for (int c = 0; c <= a; c++) *nsdae_bordered_entry(b, a, c) = *nsdae_bordered_entry(b, c, a) = 0;
  return a;
}

void nsdae_bordered_depend(nsdae_bordered_kkt *b, const nsdae_terms *T, int a,
                           const nsdae_rows *rows, int i, double factor)
{
  nsdae_rows_add(&T->system->blocks, rows, i, factor, b->G + (size_t)a * (size_t)b->kkt.n);
}

int nsdae_bordered_finish(nsdae_bordered_kkt *b, const nsdae_terms *T)
{
  size_t n = (size_t)b->kkt.n, m = (size_t)b->kkt.m;
  if (b->count == 0) return NSDAE_OK;
  memset(b->L, 0, (size_t)b->count * m * sizeof *b->L);
  int status = nsdae_terms_solve(T, &b->kkt, b->count, b->V, b->L);
  if (status < 0) return status;
  for (int c = 0; c < b->count; c++)
    for (int a = 0; a < b->count; a++) {
      double *entry = nsdae_bordered_entry(b, a, c);
      *entry += nsdae_dot(b->kkt.n, b->G + (size_t)a * n, b->V + (size_t)c * n);
      if (b->row[a] >= 0) *entry += b->h[a] * b->L[(size_t)c * m + (size_t)b->row[a]];
    }
  return nsdae_la_lu(b->count, b->B, b->most, b->pivot) == 0 ? NSDAE_OK : NSDAE_E_CONVERGENCE;
}

int nsdae_bordered_solve(const nsdae_bordered_kkt *b, const nsdae_terms *T, double *dv, double *l,
                         double *phi)
{
  int n = b->kkt.n;
  int status = nsdae_terms_solve(T, &b->kkt, 1, dv, l);
  if (status < 0 || b->count == 0) return status;
  for (int a = 0; a < b->count; a++) {
    phi[a] -= nsdae_dot(n, b->G + (size_t)a * (size_t)n, dv);
    if (b->row[a] >= 0) phi[a] -= b->h[a] * l[b->row[a]];
  }
  nsdae_la_lu_solve(b->count, b->B, b->most, b->pivot, phi);
  nsdae_add_product(n, b->count, b->V, phi, dv);
  nsdae_add_product(b->kkt.m, b->count, b->L, phi, l);
  return NSDAE_OK;
}
