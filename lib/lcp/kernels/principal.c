/* Principal pivoting: blocks (Kostreva, Linear Algebra Appl. 21 (1978) 213; Judice and Pires,
 * Comput. Oper. Res. 21 (1994) 587), then the least index (Murty). */
#include <limits.h>
#include <math.h>
#include <nsdae/kernels.h>

#include "active_set.h"
#include "finite.h"
#include "residual.h"

typedef struct pivoting {
  int n, lda;
  const double *a, *b;
  double tol;
  double *x, *lu, *y, *sizes;
  int *basis, *pivot, *index;
  double *residual;
} pivoting;

/* x and y of the basis; 0, or 1 where there is no finite one. */
static int evaluate_basis(pivoting *p)
{
  double least =
      nsdae_lcp_active_set(p->n, p->a, p->lda, p->b, p->basis, p->x, p->lu, p->pivot, p->index);
  int info = nsdae_dlcpres(p->n, p->a, p->lda, p->b, p->x, p->y, p->residual, p->sizes);
  return !(least > 0) || info != 0;
}

/* Whether x_i, or y_i where x_i is not basic, is below zero by more than tol. */
static int negative(const pivoting *p, int i)
{
  const double *column = p->a + (size_t)i * (size_t)p->lda;
  return (p->basis[i] ? p->x[i] : p->y[i]) < 0 &&
         nsdae_lcp_entry_error(p->n, column, i, p->x[i], p->y[i], p->sizes) < -p->tol;
}

static int pivot_to_the_end(pivoting *p, int block, int max_pivots, int *pivots)
{
  int fewest = p->n + 1, left = block;
  for (*pivots = 0;; ++*pivots) {
    if (evaluate_basis(p) != 0) return 1;
    if (*p->residual <= p->tol) return 0;
    /* The indices that are negative, into index; their number. */
    int count = 0;
    for (int i = 0; i < p->n; i++)
      if (negative(p, i)) p->index[count++] = i;
    if (count == 0) return 1;
    if (*pivots == max_pivots) return 2;
    if (count < fewest) {
      fewest = count;
      left = block;
    } else if (left > 0)
      left--;
    if (left == 0) count = 1;
    for (int k = 0; k < count; k++) p->basis[p->index[k]] ^= 1;
  }
}

/* Rounding below zero off; the residual is that of what is returned. */
static int clear_rounding(pivoting *p)
{
  for (int i = 0; i < p->n; i++) p->x[i] = fmax(0, p->x[i]);
  nsdae_dlcpres(p->n, p->a, p->lda, p->b, p->x, p->y, p->residual, p->sizes);
  return *p->residual <= p->tol ? 0 : 1;
}

static int zero_or_one(int n, const int *basis)
{
  if (n > 0 && !basis) return 0;
  for (int i = 0; i < n; i++)
    if (basis[i] != 0 && basis[i] != 1) return 0;
  return 1;
}

static int check_dlcpppm(int n, const double *a, int lda, const double *b, double tol, int block,
                         int max_pivots, const double *x, const int *basis, const int *pivots,
                         const double *residual, const double *work, int lwork, const int *iwork)
{
  if (n < 0 || n > 32000) return -1; /* n (n + 2) is an int */
  if (!work) return -12;
  if (lwork == -1) return 0;
  if (lda < 1 || lda < n) return -3;
  if (!nsdae_lcp_finite(n, n, a, lda)) return -2;
  if (!nsdae_lcp_finite(n, 1, b, n)) return -4;
  if (!(tol >= 0)) return -5;
  if (block < 0) return -6;
  if (max_pivots < 0) return -7;
  if (!x && n > 0) return -8;
  if (!zero_or_one(n, basis)) return -9;
  if (!pivots) return -10;
  if (!residual) return -11;
  if (lwork < n * (n + 2)) return -13;
  return iwork ? 0 : -14;
}

int nsdae_dlcpppm(int n, const double *a, int lda, const double *b, double tol, int block,
                  int max_pivots, double *x, int *basis, int *pivots, double *residual,
                  double *work, int lwork, int *iwork)
{
  int info = check_dlcpppm(n, a, lda, b, tol, block, max_pivots, x, basis, pivots, residual, work,
                           lwork, iwork);
  if (info != 0) return info;
  if (lwork == -1) {
    work[0] = (double)n * (n + 2);
    return 0;
  }
  size_t square = (size_t)n * (size_t)n;
  pivoting p = {.n = n,
                .lda = lda,
                .a = a,
                .b = b,
                .tol = tol,
                .x = x,
                .lu = work,
                .y = work + square,
                .sizes = work + square + n,
                .basis = basis,
                .pivot = iwork,
                .index = iwork + n,
                .residual = residual};
  info = pivot_to_the_end(&p, block, max_pivots, pivots);
  return info != 0 ? info : clear_rounding(&p);
}
