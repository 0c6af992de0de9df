/* Enumeration of all 2^n bases of an LCP, for small n. */
#include <float.h>
#include <math.h>
#include <nsdae/kernels.h>

#include "active_set.h"
#include "finite.h"

enum { LARGEST = 20 };

typedef struct enumeration {
  int n, lda;
  const double *a, *b;
  double *lu, *x, *y, *sizes;
  int *basis, *pivot, *index;
  int singular; /* whether some A_FF was singular to rounding */
} enumeration;

static double residual_of(enumeration *e)
{
  double residual;
  int info = nsdae_dlcpres(e->n, e->a, e->lda, e->b, e->x, e->y, &residual, e->sizes);
  return info == 0 ? residual : INFINITY;
}

/* Residual of the point of the active set; where it is not above tol, of what remains of the point
 * without its rounding below zero. A set with a negative x_i is no solution even where x_i = 0
 * makes one: that one belongs to another set. */
static double try_set(enumeration *e, int set, double tol)
{
  for (int i = 0; i < e->n; i++) e->basis[i] = set >> i & 1;
  double least =
      nsdae_lcp_active_set(e->n, e->a, e->lda, e->b, e->basis, e->x, e->lu, e->pivot, e->index);
  e->singular |= !(least > 64 * e->n * DBL_EPSILON);
  double residual = residual_of(e);
  if (!(residual <= tol)) return residual;
  for (int i = 0; i < e->n; i++) e->x[i] = fmax(0, e->x[i]);
  return residual_of(e);
}

static int check_dlcpenum(int n, const double *a, int lda, const double *b, double tol,
                          const int *set, const double *x, const double *residual,
                          const double *work, int lwork, const int *iwork)
{
  if (n < 0 || n > LARGEST) return -1;
  if (!work) return -9;
  if (lwork == -1) return 0;
  if (lda < 1 || lda < n) return -3;
  if (!nsdae_lcp_finite(n, n, a, lda)) return -2;
  if (!nsdae_lcp_finite(n, 1, b, n)) return -4;
  if (!(tol >= 0)) return -5;
  if (!set || *set < 0 || *set > 1 << n) return -6;
  if (!x && n > 0) return -7;
  if (!residual) return -8;
  if (lwork < n * (n + 2)) return -10;
  return iwork ? 0 : -11;
}

int nsdae_dlcpenum(int n, const double *a, int lda, const double *b, double tol, int *set,
                   double *x, double *residual, double *work, int lwork, int *iwork)
{
  int info = check_dlcpenum(n, a, lda, b, tol, set, x, residual, work, lwork, iwork);
  if (info != 0) return info;
  if (lwork == -1) {
    work[0] = (double)n * (n + 2);
    return 0;
  }
  enumeration e = {.n = n, .lda = lda, .a = a, .b = b, .lu = work};
  e.x = x;
  e.y = work + (size_t)n * (size_t)n;
  e.sizes = e.y + n;
  e.basis = iwork;
  e.pivot = e.basis + n;
  e.index = e.pivot + n;
  *residual = INFINITY;
  for (; *set < 1 << n; ++*set) {
    double fresh = try_set(&e, *set, tol);
    if (fresh < *residual) *residual = fresh;
    if (fresh <= tol) return 0;
  }
  return e.singular ? 2 : 1;
}
