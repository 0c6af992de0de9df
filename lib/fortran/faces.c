/* The kernels for any Fortran: all arguments by reference, info last, names with the underscore
 * that its compilers append. Arguments and info are those of <nsdae/kernels.h>. */
#include <nsdae/kernels.h>

#define FACE(name, arguments, call) \
  NSDAE_API void name arguments;    \
  void name arguments               \
  {                                 \
    *info = call;                   \
  }

FACE(nsdae_dlcpres_,
     (const int *n, const double *a, const int *lda, const double *b, const double *x, double *y,
      double *residual, double *work, int *info),
     nsdae_dlcpres(*n, a, *lda, b, x, y, residual, work))

FACE(nsdae_dlemke_,
     (const int *n, const double *a, const int *lda, const double *b, const double *d,
      const int *max_pivots, double *x, int *basis, int *pivots, double *work, const int *lwork,
      int *iwork, int *info),
     nsdae_dlemke(*n, a, *lda, b, d, *max_pivots, x, basis, pivots, work, *lwork, iwork))

FACE(nsdae_dlcppgs_,
     (const int *n, const double *a, const int *lda, const double *b, const double *omega,
      const double *tol, const int *max_iter, double *x, int *iterations, double *residual,
      double *work, const int *lwork, int *info),
     nsdae_dlcppgs(*n, a, *lda, b, *omega, *tol, *max_iter, x, iterations, residual, work, *lwork))

FACE(nsdae_dlcpppm_,
     (const int *n, const double *a, const int *lda, const double *b, const double *tol,
      const int *block, const int *max_pivots, double *x, int *basis, int *pivots, double *residual,
      double *work, const int *lwork, int *iwork, int *info),
     nsdae_dlcpppm(*n, a, *lda, b, *tol, *block, *max_pivots, x, basis, pivots, residual, work,
                   *lwork, iwork))

FACE(nsdae_dlcpenum_,
     (const int *n, const double *a, const int *lda, const double *b, const double *tol, int *set,
      double *x, double *residual, double *work, const int *lwork, int *iwork, int *info),
     nsdae_dlcpenum(*n, a, *lda, b, *tol, set, x, residual, work, *lwork, iwork))

FACE(nsdae_dfcres_,
     (const int *nc, const int *rows, const double *a, const int *lda, const double *q,
      const double *mu, const double *r, double *u, double *residual, int *info),
     nsdae_dfcres(*nc, rows, a, *lda, q, mu, r, u, residual))

FACE(nsdae_dfccon_,
     (const int *rows, const double *a, const int *lda, const double *q, const double *mu,
      double *r, double *u, double *residual, int *info),
     nsdae_dfccon(*rows, a, *lda, q, *mu, r, u, residual))

FACE(nsdae_dfcbgs_,
     (const int *nc, const int *rows, const double *a, const int *lda, const double *q,
      const double *mu, const double *tol, const int *max_iter, double *r, int *iterations,
      double *residual, double *work, const int *lwork, int *info),
     nsdae_dfcbgs(*nc, rows, a, *lda, q, mu, *tol, *max_iter, r, iterations, residual, work,
                  *lwork))

FACE(nsdae_dfcnwt_,
     (const int *nc, const int *rows, const double *a, const int *lda, const double *q,
      const double *mu, const double *alpha, const double *tol, const int *max_iter, double *r,
      int *iterations, double *residual, double *work, const int *lwork, int *iwork, int *info),
     nsdae_dfcnwt(*nc, rows, a, *lda, q, mu, *alpha, *tol, *max_iter, r, iterations, residual, work,
                  *lwork, iwork))
