#include "rank_revealing.h"

#include <math.h>
#include <string.h>

#include "vector.h"

void nsdae_rank_revealing_layout(nsdae_rank_revealing *d, long n, nsdae_arena *arena)
{
  nsdae_arena_ints(arena, n, (int **[]){&d->taken, &d->dependent, &d->before, &d->seen, NULL});
  nsdae_arena_doubles(arena, n * n, (double **[]){&d->factor, &d->combination, NULL});
}

void nsdae_rank_revealing_start(nsdae_rank_revealing *d, int n, const double *G)
{
  d->n = n;
  d->G = G;
  d->taken_count = d->dependent_count = 0;
  memset(d->seen, 0, (size_t)n * sizeof *d->seen);
}

/* The row of the factor after those taken, and what it leaves of the diagonal entry. */
static double factor_row(nsdae_rank_revealing *d, int column)
{
  const double *G = d->G + (size_t)column * (size_t)d->n;
  double *row = nsdae_rank_revealing_row(d, d->factor, column), rest = G[column];
  for (int j = 0; j < d->taken_count; j++) {
    const double *other = nsdae_rank_revealing_row(d, d->factor, d->taken[j]);
    row[j] = (G[d->taken[j]] - nsdae_dot(j, row, other)) / other[j];
    rest -= row[j] * row[j];
  }
  return rest;
}

static double entry(const nsdae_rank_revealing *d, int column)
{
  return d->G[(size_t)column * (size_t)(d->n + 1)];
}

double nsdae_rank_revealing_rest(nsdae_rank_revealing *d, int column)
{
  return factor_row(d, column) / entry(d, column);
}

int nsdae_rank_revealing_take(nsdae_rank_revealing *d, int column)
{
  double rest = factor_row(d, column);
  d->seen[column] = 1;
  d->before[column] = d->taken_count;
  if (!(rest > d->sine * d->sine * entry(d, column))) {
    d->dependent[d->dependent_count++] = column;
    return 0;
  }
  nsdae_rank_revealing_row(d, d->factor, column)[d->taken_count] = sqrt(rest);
  d->taken[d->taken_count++] = column;
  return 1;
}

/* c by L^T c = row p of the factor. */
void nsdae_rank_revealing_combine(nsdae_rank_revealing *d)
{
  for (int k = 0; k < d->dependent_count; k++) {
    int p = d->dependent[k];
    double *c = nsdae_rank_revealing_row(d, d->combination, p);
    const double *row = nsdae_rank_revealing_row(d, d->factor, p);
    memset(c, 0, (size_t)d->n * sizeof *c);
    for (int l = d->before[p] - 1; l >= 0; l--) {
      double sum = row[l];
      for (int i = l + 1; i < d->before[p]; i++)
        sum -= nsdae_rank_revealing_row(d, d->factor, d->taken[i])[l] * c[d->taken[i]];
      c[d->taken[l]] = sum / nsdae_rank_revealing_row(d, d->factor, d->taken[l])[l];
    }
  }
}
