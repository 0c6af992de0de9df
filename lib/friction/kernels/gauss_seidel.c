/* Kernels that solve one contact at a time. */
#include <math.h>
#include <nsdae/kernels.h>
#include <string.h>

#include "cone.h"
#include "one_contact.h"
#include "finite.h"
#include "arguments.h"

/* One contact in its own frame. */
typedef struct own {
  double D[9], turn[2], slip;
} own;

enum { OWN = sizeof(own) / sizeof(double) };

/* Returns 0, or 1 if the diagonal block is not positive definite: both tangents, and the normal
 * that they leave. */
static int prepare_contact(const nsdae_fc_arguments *p, int c, int i, own *o)
{
  nsdae_fc_arguments_diagonal(p, c, i, o->D);
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
static void solve_contact(const nsdae_fc_arguments *p, int c, own *o, const double *old,
                          const double *u, double *r)
{
  double q[3] = {u[0], u[1], u[2]}, from[3] = {old[0], old[1], old[2]};
  nsdae_fc_turn(o->turn, 1, from);
  if (nsdae_fc_arguments_kind(p, c) == NSDAE_FC_NORMAL) { /* the rest of its impulse goes */
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
  const nsdae_fc_arguments p = {1, &rows, a, lda, q, &mu};
  static const int place[] = {0, 0, -1, -2, -3, -4, -5};
  int m, info = nsdae_fc_arguments_check(&p, 1, &m);
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
static void sweep(const nsdae_fc_arguments *p, int m, own *all, double *r, double *u)
{
  for (int c = 0, i = 0; c < p->nc; c++) {
    int rows = nsdae_fc_arguments_rows(p, c);
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
  const nsdae_fc_arguments p = {nc, rows, a, lda, q, mu};
  int m, info = nsdae_fc_arguments_check(&p, lwork != -1, &m);
  if (info == -1 || info == -2) return info;
  if (!work) return -12;
  if (lwork == -1) {
    work[0] = (double)m + OWN * (double)nc;
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
  for (int c = 0, i = 0; c < nc; i += nsdae_fc_arguments_rows(&p, c++))
    if (prepare_contact(&p, c, i, all + c) != 0) return 2;
  for (*iterations = 0;; ++*iterations) {
    if (nsdae_dfcres(nc, rows, a, lda, q, mu, r, u, residual) != 0) return 3;
    if (*residual <= tol) return 0;
    if (*iterations == max_iter) return 1;
    sweep(&p, m, all, r, u);
  }
}
