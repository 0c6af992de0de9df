#include "sparse_ldl.h"

#include <ldl.h>
#include <limits.h>
#include <math.h>
#include <nsdae/status.h>

/* Entries of L below block column k. */
static size_t rows_below(const nsdae_multifrontal *f, int k)
{
  size_t rows = 0;
  for (size_t a = f->tree.start[k]; a < f->tree.start[k + 1]; a++)
    rows += (size_t)nsdae_multifrontal_size(f, f->tree.row[a]);
  return rows;
}

static size_t fill_of(const nsdae_multifrontal *f)
{
  size_t fill = 0;
  for (int k = 0; k < f->graph.n; k++) {
    size_t n = (size_t)nsdae_multifrontal_size(f, k);
    fill += n * (n - 1) / 2 + n * rows_below(f, k);
  }
  return fill;
}

double nsdae_sparse_ldl_work(const nsdae_multifrontal *f)
{
  double work = 0;
  if (fill_of(f) > INT_MAX || f->values > INT_MAX) return HUGE_VAL; /* it counts in int */
  for (int k = 0; k < f->graph.n; k++) {
    double below = (double)rows_below(f, k);
    for (int j = 0; j < nsdae_multifrontal_size(f, k); j++)
      work += (below + j) * (below + j + 1) / 2;
  }
  return work;
}

static void lay_out_factor(void *object, nsdae_arena *arena)
{
  nsdae_sparse_ldl *l = object;
  nsdae_ldl_tree *t = &l->tree;
  long n = l->order, entries = (long)l->entries, fill = (long)l->fill;
  nsdae_arena_ints(
      arena, n + 1,
      (int **[]){&l->first, &l->begin, &t->parent, &t->count, &t->mark, &t->path, NULL});
  l->row = NSDAE_ARENA_INTS(arena, entries);
  l->from = nsdae_arena_take(arena, entries, sizeof *l->from);
  l->A = NSDAE_ARENA_DOUBLES(arena, entries);
  l->below = NSDAE_ARENA_INTS(arena, fill);
  l->L = NSDAE_ARENA_DOUBLES(arena, fill);
  nsdae_arena_doubles(arena, n, (double **[]){&l->D, &l->x, NULL});
}

int nsdae_sparse_ldl_analyse(nsdae_sparse_ldl *l, const nsdae_multifrontal *f)
{
  l->order = f->order;
  l->fill = fill_of(f);
  l->entries = f->values; /* both triangles: more than enough */
  if (nsdae_arena_fit(&l->memory, lay_out_factor, l) != NSDAE_OK) return NSDAE_E_MEMORY;
  /* ---- column r of block number k above its diagonal, which is its last entry */
  int at = l->first[0] = 0;
  for (int k = 0; k < f->graph.n; k++) {
    int i = f->tree.node[k], n = f->graph.size[i];
    for (int r = 0; r < n; r++) {
      for (int a = f->graph.first[i]; a < f->graph.first[i + 1]; a++) {
        int other = f->tree.number[f->graph.index[a]];
        size_t block = f->graph.at[f->graph.twin[a]]; /* the rows of i */
        for (int c = 0; other < k && c < nsdae_multifrontal_size(f, other); c++) {
          l->row[at] = f->place[other] + c;
          l->from[at++] = block + (size_t)c * (size_t)n + (size_t)r;
        }
      }
      for (int c = 0; c <= r; c++) {
        l->row[at] = f->place[k] + c;
        l->from[at++] = f->graph.diagonal[i] + (size_t)c * (size_t)n + (size_t)r;
      }
      l->first[f->place[k] + r + 1] = at;
    }
  }
  ldl_symbolic(l->order, l->first, l->row, l->begin, l->tree.parent, l->tree.count, l->tree.mark,
               NULL, NULL);
  return NSDAE_OK;
}

int nsdae_sparse_ldl_factor(nsdae_sparse_ldl *l, const nsdae_multifrontal *f, double drop)
{
  int n = l->order;
  for (int e = 0; e < l->first[n]; e++) l->A[e] = f->A[l->from[e]];
  if (ldl_numeric(n, l->first, l->row, l->A, l->begin, l->tree.parent, l->tree.count, l->below,
                  l->L, l->D, l->x, l->tree.path, l->tree.mark, NULL, NULL) != n)
    return 1;
  l->smallest = 1;
  for (int j = 0; j < n; j++) {
    double part = l->D[j] / l->A[l->first[j + 1] - 1];
    if (!(part > drop)) return 1;
    l->smallest = fmin(l->smallest, part);
  }
  return 0;
}

void nsdae_sparse_ldl_solve(const nsdae_sparse_ldl *l, const nsdae_multifrontal *f, double *x)
{
  nsdae_multifrontal_permute(f, x, l->x, 1);
  ldl_lsolve(l->order, l->x, l->begin, l->below, l->L);
  ldl_dsolve(l->order, l->x, l->D);
  ldl_ltsolve(l->order, l->x, l->begin, l->below, l->L);
  nsdae_multifrontal_permute(f, x, l->x, 0);
}

void nsdae_sparse_ldl_release(nsdae_sparse_ldl *l)
{
  nsdae_arena_release(&l->memory);
}
