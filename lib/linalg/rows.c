#include "rows.h"

#include <math.h>

void nsdae_rows_gather(const nsdae_blocks *blocks, const nsdae_rows *rows, int i, const int *place,
                       double *out, size_t stride)
{
  for (int p = rows->first[i]; p < rows->first[i + 1]; p++) {
    int b = rows->block[p], n = nsdae_blocks_size(blocks, b);
    const double *value = rows->value + rows->at[p];
    double *to = out + (size_t)place[b] * stride;
    for (int j = 0; j < n; j++) to[(size_t)j * stride] = value[(size_t)j * rows->stride];
  }
}

double nsdae_rows_largest(const nsdae_blocks *blocks, const nsdae_rows *rows, int i)
{
  double most = 0;
  for (int p = rows->first[i]; p < rows->first[i + 1]; p++)
    for (int j = 0; j < nsdae_blocks_size(blocks, rows->block[p]); j++)
      most = fmax(most, fabs(rows->value[rows->at[p] + (size_t)j * rows->stride]));
  return most;
}

double nsdae_rows_dot_sizes(const nsdae_blocks *blocks, const nsdae_rows *rows, int i,
                            const double *x)
{
  double sum = 0;
  for (int p = rows->first[i]; p < rows->first[i + 1]; p++) {
    const double *value = rows->value + rows->at[p];
    int at = blocks->first[rows->block[p]], end = blocks->first[rows->block[p] + 1];
    for (int j = at; j < end; j++, value += rows->stride) sum += fabs(*value * (x ? x[j] : 1));
  }
  return sum;
}
