#include "lu.h"

#include "dense.h"

void nsdae_lu_layout(nsdae_lu *lu, nsdae_arena *arena)
{
  lu->A = NSDAE_ARENA_DOUBLES(arena, (long)lu->most * lu->most);
  lu->pivot = NSDAE_ARENA_INTS(arena, lu->most);
  lu->sparse.n = lu->most;
  if (lu->is_sparse) nsdae_sparse_lu_layout(&lu->sparse, arena);
}

void nsdae_lu_forget(nsdae_lu *lu)
{
  if (lu->is_sparse) nsdae_sparse_lu_forget(&lu->sparse);
}

int nsdae_lu_factor(nsdae_lu *lu)
{
  if (!lu->is_sparse) return nsdae_la_lu(lu->n, lu->A, lu->n, lu->pivot);
  if (lu->sparse.n != lu->n) { /* no pattern is of another size */
    nsdae_sparse_lu_forget(&lu->sparse);
    lu->sparse.n = lu->n;
    nsdae_sparse_lu_forget(&lu->sparse);
  }
  return nsdae_sparse_lu_factor(&lu->sparse, lu->A, lu->n);
}

void nsdae_lu_solve(const nsdae_lu *lu, double *x)
{
  if (lu->is_sparse)
    nsdae_sparse_lu_solve(&lu->sparse, x);
  else
    nsdae_la_lu_solve(lu->n, lu->A, lu->n, lu->pivot, x);
}
