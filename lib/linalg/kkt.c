#include "kkt.h"

#include <string.h>

#include <nsdae/status.h>

#include "dense_kkt.h"

/* Velocities and rows of several blocks from which the sparse method is used. A factorisation and a
 * solution take the same time by both at 40 to 50 of chains and trees, of spherical and revolute
 * joints, and at 80 of ladders; at 80 further solutions still take half the time by the dense one.
 */
enum { SPARSE_FROM = 80 };

static int prefers_sparse(const nsdae_kkt *kkt)
{
  int rows = kkt->typical > 0 ? kkt->typical - 1 : kkt->m;
  return kkt->blocks->count > 1 && kkt->n + rows >= SPARSE_FROM;
}

static void lay_out_sparse(nsdae_kkt *kkt, int rows, nsdae_arena *arena)
{
  int most = rows > kkt->blocks->count ? rows : kkt->blocks->count;
  kkt->each = NSDAE_ARENA_INTS(arena, most);
  for (int i = 0; kkt->each && i < most; i++) kkt->each[i] = i;
}

void nsdae_kkt_layout(nsdae_kkt *kkt, nsdae_arena *arena)
{
  kkt->is_sparse = prefers_sparse(kkt);
  if (kkt->is_sparse)
    lay_out_sparse(kkt, kkt->m, arena);
  else
    nsdae_dense_kkt_layout(kkt, arena);
}

void nsdae_kkt_layout_most(nsdae_kkt *kkt, int rows, nsdae_arena *arena)
{
  int n = kkt->n, m = kkt->m;
  if (prefers_sparse(kkt)) {
    lay_out_sparse(kkt, rows, arena);
    if (n > SPARSE_FROM) kkt->n = SPARSE_FROM;
    if (m > SPARSE_FROM) kkt->m = SPARSE_FROM;
  }
  nsdae_dense_kkt_layout(kkt, arena);
  kkt->n = n;
  kkt->m = m;
}

void nsdae_kkt_turn_to(nsdae_kkt *kkt, const nsdae_blocks *blocks, int n, int m)
{
  kkt->blocks = blocks;
  kkt->n = n;
  kkt->m = m;
  kkt->is_sparse = kkt->each && n + m >= SPARSE_FROM;
}

void nsdae_kkt_release(nsdae_kkt *kkt)
{
  nsdae_sparse_kkt_release(&kkt->sparse);
}

/* ---- the sparse method, of all blocks and rows */

static nsdae_kkt_part whole(const nsdae_kkt *kkt, const nsdae_rows *J)
{
  return (nsdae_kkt_part){kkt->blocks, J, kkt->blocks->count, kkt->m, kkt->each, kkt->each};
}

int nsdae_kkt_reserve(nsdae_kkt *kkt, const nsdae_rows *J)
{
  const nsdae_kkt_part all = whole(kkt, J);
  return kkt->is_sparse ? nsdae_sparse_kkt_analyse(&kkt->sparse, &all) : NSDAE_OK;
}

static int factor_sparse(nsdae_kkt *kkt, const double *M, const nsdae_coupling *coupling,
                         const nsdae_rows *J, int fixed, const double *basis)
{
  nsdae_sparse_kkt *s = &kkt->sparse;
  const nsdae_kkt_part all = whole(kkt, J);
  s->rank_tol = kkt->rank_tol;
  int status = nsdae_sparse_kkt_analyse(s, &all);
  if (status == NSDAE_OK)
    status = coupling && coupling->count > 0
                 ? nsdae_sparse_kkt_factor_coupled(s, M, coupling, basis)
             : fixed ? nsdae_sparse_kkt_factor_in(s, M, basis)
                     : nsdae_sparse_kkt_factor(s, M);
  kkt->pivot = s->pivot > 0 ? kkt->blocks->first[s->bad_block] + s->pivot : 0;
  if (status < 0) return status;
  kkt->rank = s->rank.count;
  kkt->kept = s->rank.kept;
  kkt->left = s->rank.left;
  kkt->dependent = s->rank.dependent;
  return NSDAE_OK;
}

/* ---- either */

int nsdae_kkt_factor(nsdae_kkt *kkt, const double *M, const nsdae_rows *J)
{
  return kkt->is_sparse ? factor_sparse(kkt, M, NULL, J, 0, NULL)
                        : nsdae_dense_kkt_factor(kkt, M, J);
}

int nsdae_kkt_factor_coupled(nsdae_kkt *kkt, const double *A, const nsdae_coupling *coupling,
                             const nsdae_rows *J, const double *basis, int rank)
{
  return kkt->is_sparse ? factor_sparse(kkt, A, coupling, J, 1, basis)
                        : nsdae_dense_kkt_factor_in(kkt, A, coupling, J, basis, rank);
}

int nsdae_kkt_solve(const nsdae_kkt *kkt, int nrhs, double *R, int ldr, double *C, int ldc)
{
  int status = NSDAE_OK;
  if (!kkt->is_sparse) {
    nsdae_dense_kkt_solve(kkt, nrhs, R, ldr, C, ldc);
    return NSDAE_OK;
  }
  for (int j = 0; j < nrhs && status == NSDAE_OK; j++, R += ldr, C += ldc)
    status = nsdae_sparse_kkt_solve(&kkt->sparse, R, R, C);
  return status;
}

void nsdae_kkt_solve_mass(const nsdae_kkt *kkt, double *r)
{
  if (kkt->is_sparse)
    nsdae_sparse_kkt_solve_mass(&kkt->sparse, r);
  else
    nsdae_dense_kkt_solve_mass(kkt, r);
}

/* J^T l is M x + J^T l' with x = 0: the rest of l' is least. */
int nsdae_kkt_least_norm(const nsdae_kkt *kkt, const nsdae_rows *J, double *l, double *r)
{
  memset(r, 0, (size_t)kkt->n * sizeof *r);
  for (int i = 0; i < kkt->m; i++) nsdae_rows_add(kkt->blocks, J, i, l[i], r);
  memset(l, 0, (size_t)kkt->m * sizeof *l);
  return nsdae_kkt_solve(kkt, 1, r, kkt->n, l, kkt->m);
}

long nsdae_kkt_basis_size(const nsdae_kkt *kkt)
{
  return prefers_sparse(kkt) ? kkt->m : (long)kkt->m * kkt->m;
}

void nsdae_kkt_basis(const nsdae_kkt *kkt, double *basis)
{
  if (kkt->is_sparse)
    nsdae_sparse_kkt_kept(&kkt->sparse, basis);
  else
    nsdae_dense_kkt_basis(kkt, basis);
}

double nsdae_kkt_common(const nsdae_kkt *kkt, const double *basis)
{
  return kkt->is_sparse ? nsdae_sparse_kkt_common(&kkt->sparse, basis)
                        : nsdae_dense_kkt_common(kkt, basis);
}
