#include "rows.h"

#include <math.h>
#include <string.h>

void nsdae_rows_times_transposed(const nsdae_blocks *blocks, const nsdae_rows *rows, double scale,
                                 const double *x, double *work, double *y)
{
  int nv = blocks->first[blocks->count];
  if (rows->count == 0) return;
  memset(work, 0, (size_t)nv * sizeof *work);
  for (int i = 0; i < rows->count; i++) nsdae_rows_add(blocks, rows, i, x[i], work);
  for (int j = 0; j < nv; j++) y[j] += scale * work[j];
}

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
