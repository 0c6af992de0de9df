/* Cottle, Pang, Stone, "The Linear Complementarity Problem", 1992, section 2.3. Column by column: a
 * column (A_B, A_N) that stays becomes (-X, A_N - A_NB X) with X = A_BB^-1 A_B, one that changes
 * places (X, A_NB X) with X = A_BB^-1 e_k. */
#include "lcp_methods.h"

#include <stddef.h>

#include "active_set.h"
#include "dense.h"

typedef struct split {
  int n, size; /* rows, of which this number are in the set */
  const double *A;
  const int *basis;
  double *lu, *part; /* size x size, size */
  int *pivot, *index;
} split;

static const double *basis_column(const split *s, int j)
{
  return s->A + (size_t)j * (size_t)s->n;
}

/* out := (sign X, start_N + sign A_NB X), X = A_BB^-1 part; start NULL: zero. */
static void transform_back(split *s, const double *start, double sign, double *out)
{
  nsdae_la_lu_solve(s->size, s->lu, s->size, s->pivot, s->part);
  for (int i = 0; i < s->n; i++) out[i] = start ? start[i] : 0;
  for (int k = 0; k < s->size; k++) {
    const double *column = basis_column(s, s->index[k]);
    double factor_of = sign * s->part[k];
    for (int i = 0; i < s->n; i++) out[i] += factor_of * column[i];
  }
  for (int k = 0; k < s->size; k++) out[s->index[k]] = sign * s->part[k];
}

int nsdae_lcp_transform(int n, const double *A, const double *b, const int *basis, double *T,
                        double *t, double *work, int *pivot, int *index)
{
  split s = {.n = n,
             .A = A,
             .basis = basis,
             .lu = work,
             .part = work + (size_t)n * (size_t)n,
             .pivot = pivot,
             .index = index};
  s.size = nsdae_lcp_gather(n, A, n, basis, s.lu, index);
  if (nsdae_la_lu(s.size, s.lu, s.size, pivot) != 0) return 1;
  for (int j = 0; j <= n; j++) {
    const double *from = j < n ? basis_column(&s, j) : b;
    int changes = j < n && basis[j];
    for (int k = 0; k < s.size; k++) s.part[k] = changes ? index[k] == j : from[index[k]];
    transform_back(&s, changes ? NULL : from, changes ? 1 : -1,
                   j < n ? T + (size_t)j * (size_t)n : t);
  }
  return 0;
}
