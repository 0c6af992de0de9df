/* Semismooth Newton on the natural map of all contacts at once (Alart and Curnier, Comput. Methods
 * Appl. Mech. Eng. 92 (1991) 353; De Saxce and Feng 1998; Qi and Sun, Math. Program. 58 (1993)
 * 353). With rho_c the mean diagonal entry of a contact, K being a cone,
 *
 *   F(r) = rho r - P(rho r - u^),   u = W r + q + alpha rho (r - z),   z = r of the step before,
 *   (B rho + A (W + alpha rho)) dr = -F,   B = dF/d(rho r),  A = dF/du */
#include <math.h>
#include <nsdae/kernels.h>
#include <string.h>

#include "dense.h"
#include "finite.h"
#include "natural_map.h"
#include "arguments.h"

/* Rows i, ... of the matrix [m x m] and of F, those of contact c. */
static void fill_contact(const nsdae_fc_arguments *p, int m, int c, int i, double alpha,
                         const double *r, const double *u, double *matrix, double *F)
{
  double D[9], rho = nsdae_fc_arguments_diagonal(p, c, i, D);
  double x[3] = {0}, y[3] = {0}, f[3], B[9], A[9];
  int rows = nsdae_fc_arguments_rows(p, c);
  for (int k = 0; k < rows; k++) {
    x[k] = rho * r[i + k];
    y[k] = u[i + k];
  }
  nsdae_fc_natural_map(nsdae_fc_arguments_kind(p, c), p->mu[c], x, NULL, y, f, B, A);
  for (int k = 0; k < rows; k++) {
    double *row = matrix + i + k;
    F[i + k] = f[k];
    for (size_t j = 0; j < (size_t)m; j++) {
      row[j * (size_t)m] = 0;
      for (int l = 0; l < rows; l++)
        row[j * (size_t)m] += A[3 * k + l] * p->a[j * (size_t)p->lda + (size_t)(i + l)];
    }
    for (int l = 0; l < rows; l++)
      row[(size_t)(i + l) * (size_t)m] += rho * (B[3 * k + l] + alpha * A[3 * k + l]);
  }
}

/* Steps until the residual is below tol; the best point is left in r, its residual returned in
 * *residual. Returns info. */
static int iterate(const nsdae_fc_arguments *p, int m, double alpha, double tol, int max_iter,
                   double *r, int *iterations, double *residual, double *work, int *pivot)
{
  double *u = work, *F = work + m, *best = work + 2 * (size_t)m, *matrix = work + 3 * (size_t)m;
  double least = INFINITY, now = INFINITY;
  int info = 0;
  for (*iterations = 0;; ++*iterations) {
    if (nsdae_dfcres(p->nc, p->rows, p->a, p->lda, p->q, p->mu, r, u, &now) != 0) info = 3;
    if (info == 0 && now < least) {
      least = now;
      memcpy(best, r, (size_t)m * sizeof *r);
    }
    if (info == 0 && least <= tol) break;
    if (info == 0 && *iterations == max_iter) info = 1;
    if (info != 0) break;
    for (int c = 0, i = 0; c < p->nc; i += nsdae_fc_arguments_rows(p, c++))
      fill_contact(p, m, c, i, alpha, r, u, matrix, F);
    info = nsdae_la_lu(m, matrix, m, pivot) != 0 ? 2 : 0;
    if (info != 0) break;
    nsdae_la_lu_solve(m, matrix, m, pivot, F);
    for (int i = 0; i < m; i++) r[i] -= F[i];
  }
  if (least < INFINITY) memcpy(r, best, (size_t)m * sizeof *r);
  *residual = least < INFINITY ? least : NAN;
  return info;
}

int nsdae_dfcnwt(int nc, const int *rows, const double *a, int lda, const double *q,
                 const double *mu, double alpha, double tol, int max_iter, double *r,
                 int *iterations, double *residual, double *work, int lwork, int *iwork)
{
  const nsdae_fc_arguments p = {nc, rows, a, lda, q, mu};
  int m, info = nsdae_fc_arguments_check(&p, lwork != -1, &m);
  if (info == -1 || info == -2) return info;
  if (!work) return -13;
  double need = (double)m * (m + 3.0);
  if (lwork == -1) {
    work[0] = need;
    return 0;
  }
  if (info != 0) return info;
  if (!(alpha >= 0 && alpha < INFINITY)) return -7;
  if (!(tol >= 0)) return -8;
  if (max_iter < 0) return -9;
  if (!nsdae_lcp_finite(m, 1, r, m)) return -10;
  if (!iterations) return -11;
  if (!residual) return -12;
  if (lwork < need) return -14;
  if (!iwork && m > 0) return -15;
  return iterate(&p, m, alpha, tol, max_iter, r, iterations, residual, work, iwork);
}
