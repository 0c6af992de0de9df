/* The certificate on plain arrays: velocities in twice the precision, natural map contact by
 * contact. */
#include <math.h>
#include <nsdae/kernels.h>
#include <stddef.h>

#include "cone.h"
#include "arguments.h"
#include "double_double.h"
#include "vector.h"

int nsdae_dfcres(int nc, const int *rows, const double *a, int lda, const double *q,
                 const double *mu, const double *r, double *u, double *residual)
{
  const nsdae_fc_arguments p = {nc, rows, a, lda, q, mu};
  int m, info = nsdae_fc_arguments_check(&p, 0, &m);
  if (info != 0) return info;
  if (!r && m > 0) return -7;
  if (!u && m > 0) return -8;
  if (!residual) return -9;
  double worst = 0, scale = nsdae_largest(m, q), sum = 0;
  if (!(scale > 0)) scale = 1;
  for (int i = 0; i < m; i++) {
    double low = 0;
    u[i] = q[i];
    for (int j = 0; j < m; j++)
      nsdae_dd_add(a[(size_t)j * (size_t)lda + (size_t)i], r[j], u + i, &low);
    u[i] += low;
    sum += fabs(u[i]) + fabs(q[i]); /* fmax passes over a NaN */
  }
  for (int c = 0, i = 0; c < nc; i += nsdae_fc_arguments_rows(&p, c++)) {
    double D[9], d = nsdae_fc_arguments_diagonal(&p, c, i, D), x[3] = {0}, y[3] = {0};
    for (int k = 0; k < nsdae_fc_arguments_rows(&p, c); k++) {
      x[k] = r[i + k] * (d / scale);
      y[k] = u[i + k] / scale;
    }
    double one = nsdae_fc_natural(nsdae_fc_arguments_kind(&p, c), mu[c], x, NULL, y);
    if (!(one <= worst) && !isnan(worst)) worst = one;
  }
  *residual = isfinite(sum) && isfinite(worst) ? worst : NAN;
  return isnan(*residual) ? 1 : 0;
}
