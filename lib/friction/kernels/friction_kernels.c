/* Semismooth Newton on the natural map of all contacts at once (Alart and Curnier, Comput. Methods
 * Appl. Mech. Eng. 92 (1991) 353; De Saxce and Feng 1998; Qi and Sun, Math. Program. 58 (1993)
 * 353). With rho_c the mean diagonal entry of a contact, K being a cone,
 *
 *   F(r) = rho r - P(rho r - u^),   u = W r + q + alpha rho (r - z),   z = r of the step before,
 *   (B rho + A (W + alpha rho)) dr = -F,   B = dF/d(rho r),  A = dF/du */
#include <limits.h>
#include <math.h>
#include <nsdae/kernels.h>
#include <stddef.h>
#include <string.h>

#include "cone.h"
#include "dense.h"
#include "finite.h"
#include "natural_map.h"
#include "one_contact.h"

/* The first six arguments of each kernel. */
typedef struct arguments {
  int nc;
  const int *rows; /* NULL: three each */
  const double *a;
  int lda;
  const double *q, *mu;
} arguments;

static int arguments_rows(const arguments *p, int c)
{
  return p->rows ? p->rows[c] : 3;
}

/* ---- arguments */

/* 0, or -i for the i-th argument; m: the rows of all contacts. With finite, entries of a and q are
 * looked at, too. */
static int arguments_check(const arguments *p, int finite, int *m)
{
  if (p->nc < 0) return -1;
  *m = 0;
  for (int c = 0; c < p->nc; c++) {
    int rows = arguments_rows(p, c);
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
    if (arguments_rows(p, c) > 1 && !(p->mu[c] >= 0 && p->mu[c] < INFINITY)) return -6;
  return 0;
}

/* enum nsdae_fc_kind of contact c: without friction it is a normal row and others that do nothing.
 */
static int arguments_kind(const arguments *p, int c)
{
  return arguments_rows(p, c) > 1 && p->mu[c] > 0 ? NSDAE_FC_CONE : NSDAE_FC_NORMAL;
}

/* D [9], row-major: the symmetric part of the diagonal block of contact c, whose first row is i, in
 * three rows (those that it has not are those of their mean); the mean of its diagonal is returned.
 */
static double arguments_diagonal(const arguments *p, int c, int i, double *D)
{
  int rows = arguments_rows(p, c);
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

/* Rows i, ... of the matrix [m x m] and of F, those of contact c. */
static void fill_contact(const arguments *p, int m, int c, int i, double alpha, const double *r,
                         const double *u, double *matrix, double *F)
{
  double D[9], rho = arguments_diagonal(p, c, i, D);
  double x[3] = {0}, y[3] = {0}, f[3], B[9], A[9];
  int rows = arguments_rows(p, c);
  for (int k = 0; k < rows; k++) {
    x[k] = rho * r[i + k];
    y[k] = u[i + k];
  }
  nsdae_fc_natural_map(arguments_kind(p, c), p->mu[c], x, NULL, y, f, B, A);
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
static int iterate(const arguments *p, int m, double alpha, double tol, int max_iter, double *r,
                   int *iterations, double *residual, double *work, int *pivot)
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
    for (int c = 0, i = 0; c < p->nc; i += arguments_rows(p, c++))
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
  const arguments p = {nc, rows, a, lda, q, mu};
  int m, info = arguments_check(&p, lwork != -1, &m);
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

/* Kernels that solve one contact at a time. */

/* One contact in its own frame. */
typedef struct own {
  double D[9], turn[2], slip;
} own;

enum { OWN = sizeof(own) / sizeof(double) };

/* Returns 0, or 1 if the diagonal block is not positive definite: both tangents, and the normal
 * that they leave. */
static int prepare_contact(const arguments *p, int c, int i, own *o)
{
  arguments_diagonal(p, c, i, o->D);
  nsdae_fc_turn_matrix(o->D, o->turn);
  o->slip = 0;
  return !(o->D[0] > 0 && o->D[4] > 0 && o->D[8] > 0 &&
           o->D[0] - o->D[1] * o->D[1] / o->D[4] - o->D[2] * o->D[2] / o->D[8] > 0);
}

/* The power of two next below the largest of three sizes; 1 if they are zero. */
static double size_of(double a, double b, double c)
{
  double most = fmax(fabs(a), fmax(fabs(b), fabs(c)));
  return most > 0 ? ldexp(1, ilogb(most)) : 1;
}

/* The r [3] that obeys the law of contact c, if with the impulse old [3] its velocity is u [3]. */
static void solve_contact(const arguments *p, int c, own *o, const double *old, const double *u,
                          double *r)
{
  double q[3] = {u[0], u[1], u[2]}, from[3] = {old[0], old[1], old[2]};
  nsdae_fc_turn(o->turn, 1, from);
  if (arguments_kind(p, c) == NSDAE_FC_NORMAL) { /* the rest of its impulse goes */
    r[0] = fmax(0, old[0] - (u[0] - o->D[1] * from[1] - o->D[2] * from[2]) / o->D[0]);
    r[1] = r[2] = 0;
    return;
  }
  nsdae_fc_turn(o->turn, 1, q);
  for (int j = 0; j < 3; j++)
    for (int k = 0; k < 3; k++) q[j] -= o->D[3 * j + k] * from[k];
  /* In its frame, in numbers about one, so that squares stay in range: with D = d D' and q = s q',
   * r = s r' / d. */
  double d = size_of(o->D[0], o->D[4], o->D[8]), s = size_of(q[0], q[1], q[2]);
  double D[9], slip = o->slip / d, scaled[3] = {q[0] / s, q[1] / s, q[2] / s};
  for (int j = 0; j < 9; j++) D[j] = o->D[j] / d;
  nsdae_fc_solve_contact(D, scaled, p->mu[c], 1e-15, &slip, r);
  for (int j = 0; j < 3; j++) r[j] = r[j] / d * s;
  o->slip = slip * d;
  nsdae_fc_turn(o->turn, -1, r);
}

int nsdae_dfccon(int rows, const double *a, int lda, const double *q, double mu, double *r,
                 double *u, double *residual)
{
  const arguments p = {1, &rows, a, lda, q, &mu};
  static const int place[] = {0, 0, -1, -2, -3, -4, -5};
  int m, info = arguments_check(&p, 1, &m);
  if (info != 0) return place[-info];
  if (!r) return -6;
  if (!u) return -7;
  if (!residual) return -8;
  double zero[3] = {0}, v[3] = {0}, x[3];
  own o;
  memcpy(v, q, (size_t)rows * sizeof *v);
  if (prepare_contact(&p, 0, 0, &o) != 0) return 1;
  solve_contact(&p, 0, &o, zero, v, x);
  memcpy(r, x, (size_t)rows * sizeof *r);
  return nsdae_dfcres(1, &rows, a, lda, q, &mu, r, u, residual) == 0 ? 0 : 2;
}

/* One sweep; u = W r + q is updated with r. */
static void sweep(const arguments *p, int m, own *all, double *r, double *u)
{
  for (int c = 0, i = 0; c < p->nc; c++) {
    int rows = arguments_rows(p, c);
    double old[3] = {0}, v[3] = {0}, next[3];
    memcpy(old, r + i, (size_t)rows * sizeof *old);
    memcpy(v, u + i, (size_t)rows * sizeof *v);
    solve_contact(p, c, all + c, old, v, next);
    for (int k = 0; k < rows; k++, i++) {
      const double *column = p->a + (size_t)i * (size_t)p->lda;
      double change = next[k] - old[k];
      for (int j = 0; j < m && change != 0; j++) u[j] += change * column[j];
      r[i] = next[k];
    }
  }
}

int nsdae_dfcbgs(int nc, const int *rows, const double *a, int lda, const double *q,
                 const double *mu, double tol, int max_iter, double *r, int *iterations,
                 double *residual, double *work, int lwork)
{
  const arguments p = {nc, rows, a, lda, q, mu};
  int m, info = arguments_check(&p, lwork != -1, &m);
  if (info == -1 || info == -2) return info;
  if (!work) return -12;
  if (lwork == -1) {
    work[0] = (double)m + (double)OWN * (double)nc;
    return 0;
  }
  if (info != 0) return info;
  if (!(tol >= 0)) return -7;
  if (max_iter < 0) return -8;
  if (!nsdae_lcp_finite(m, 1, r, m)) return -9;
  if (!iterations) return -10;
  if (!residual) return -11;
  if (lwork < m + OWN * nc) return -13;
  own *all = (own *)(void *)work;
  double *u = work + (size_t)OWN * (size_t)nc;
  for (int c = 0, i = 0; c < nc; i += arguments_rows(&p, c++))
    if (prepare_contact(&p, c, i, all + c) != 0) return 2;
  for (*iterations = 0;; ++*iterations) {
    if (nsdae_dfcres(nc, rows, a, lda, q, mu, r, u, residual) != 0) return 3;
    if (*residual <= tol) return 0;
    if (*iterations == max_iter) return 1;
    sweep(&p, m, all, r, u);
  }
}

/* The certificate on plain arrays: velocities in twice the precision, natural map contact by
 * contact. */

int nsdae_dfcres(int nc, const int *rows, const double *a, int lda, const double *q,
                 const double *mu, const double *r, double *u, double *residual)
{
  const arguments p = {nc, rows, a, lda, q, mu};
  int m, info = arguments_check(&p, 0, &m);
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
  for (int c = 0, i = 0; c < nc; i += arguments_rows(&p, c++)) {
    double D[9], d = arguments_diagonal(&p, c, i, D), x[3] = {0}, y[3] = {0};
    for (int k = 0; k < arguments_rows(&p, c); k++) {
      x[k] = r[i + k] * (d / scale);
      y[k] = u[i + k] / scale;
    }
    double one = nsdae_fc_natural(arguments_kind(&p, c), mu[c], x, NULL, y);
    if (!(one <= worst) && !isnan(worst)) worst = one;
  }
  *residual = isfinite(sum) && isfinite(worst) ? worst : NAN;
  return isnan(*residual) ? 1 : 0;
}
