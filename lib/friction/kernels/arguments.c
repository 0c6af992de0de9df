#include "arguments.h"

#include <limits.h>
#include <math.h>
#include <stddef.h>

#include "cone.h"
#include "finite.h"

int nsdae_fc_arguments_check(const nsdae_fc_arguments *p, int finite, int *m)
{
  if (p->nc < 0) return -1;
  *m = 0;
  for (int c = 0; c < p->nc; c++) {
    int rows = nsdae_fc_arguments_rows(p, c);
    if (rows < 1 || rows > 3 || *m > INT_MAX / 16) return -2; /* or they are too many */
    *m += rows;
  }
  if (!p->a && *m > 0) return -3;
  if (p->lda < 1 || p->lda < *m) return -4;
  if (!p->q && *m > 0) return -5;
  if (!p->mu && p->nc > 0) return -6;
  if (finite && !nsdae_lcp_finite(*m, *m, p->a, p->lda)) return -3;
  if (finite && !nsdae_lcp_finite(*m, 1, p->q, *m)) return -5;
  for (int c = 0; c < p->nc; c++)
    if (nsdae_fc_arguments_rows(p, c) > 1 && !(p->mu[c] >= 0 && p->mu[c] < INFINITY)) return -6;
  return 0;
}

int nsdae_fc_arguments_kind(const nsdae_fc_arguments *p, int c)
{
  return nsdae_fc_arguments_rows(p, c) > 1 && p->mu[c] > 0 ? NSDAE_FC_CONE : NSDAE_FC_NORMAL;
}

double nsdae_fc_arguments_diagonal(const nsdae_fc_arguments *p, int c, int i, double *D)
{
  int rows = nsdae_fc_arguments_rows(p, c);
  size_t lda = (size_t)p->lda, at = (size_t)i;
  double sum = 0;
  for (size_t k = 0; k < (size_t)rows; k++) sum += p->a[(at + k) * lda + at + k];
  for (size_t k = 0; k < 3; k++)
    for (size_t l = 0; l < 3; l++)
      if (k < (size_t)rows && l < (size_t)rows)
        D[3 * k + l] = (p->a[(at + l) * lda + at + k] + p->a[(at + k) * lda + at + l]) / 2;
      else
        D[3 * k + l] = k == l ? sum / rows : 0;
  return sum / rows;
}
