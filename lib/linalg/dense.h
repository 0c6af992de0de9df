/* Dense factorisations and products, column-major. Below SMALL rows (LU: more) plain loops, which
 * are as fast as a call into a BLAS there, and as a BLAS with threads faster; above it BLAS and
 * LAPACK, by one thread. */
#ifndef NSDAE_LINALG_DENSE_H
#define NSDAE_LINALG_DENSE_H

#include "arena.h"

enum { NSDAE_SMALL = 32 };

/* Whether nothing stands below the diagonal of A [n x n]. */
static inline int nsdae_la_is_diagonal(int n, const double *A, int lda)
{
  for (int below = n - 1; below > 0; below--, A += lda + 1)
    for (int i = 1; i <= below; i++)
      if (A[i] != 0) return 0;
  return 1;
}

/* A := L with A = L L^T, in the lower triangle of A [n x n]; the upper one is not touched.
 * Returns 0, or i > 0 when the i-th pivot is not above rounding relative to its diagonal entry
 * (A is not positive definite, or has a NaN). */
int nsdae_la_cholesky(int n, double *A, int lda);
/* The same, of a matrix whose pivots are only to be positive. */
int nsdae_la_cholesky_pivots(int n, double *A, int lda);

/* B [n x nrhs] := L^-1 B, and B := L^-T B. */
void nsdae_la_solve_lower(int n, int nrhs, const double *L, int ldl, double *B, int ldb);
void nsdae_la_solve_lower_transposed(int n, int nrhs, const double *L, int ldl, double *B, int ldb);
/* b [n] := L^-T L^-1 b, with L [n x n]. */
void nsdae_la_solve_cholesky(int n, const double *L, double *b);

/* Of a front of p + r rows, whose first p have the factor L: R := R L^-T and, in its lower
 * triangle, S := S + sign R R^T, with R below L and S beside R. */
void nsdae_la_eliminate_below(int p, int r, double sign, double *L, int lda);

/* A [n x n] := its LU factors with partial pivoting, rows exchanged as pivot [n] says (from 1).
 * Returns 0, or i > 0 when the i-th pivot is zero (or NaN). */
int nsdae_la_lu(int n, double *A, int lda, int *pivot);
/* b [n] := A^-1 b. */
void nsdae_la_lu_solve(int n, const double *A, int lda, const int *pivot, double *b);

/* The same of the first p of the n rows and columns of a front (P U; R S), which exchange among
 * themselves: P := its factors, R := R U_P^-1, U := L_P^-1 X^T U, S := S - R U. */
int nsdae_la_lu_front(int p, int n, double *A, int lda, int *pivot);
/* b [n] := L^-1 X^T b, and b := U^-1 b. */
void nsdae_la_lu_forward(int n, const double *A, int lda, const int *pivot, double *b);
void nsdae_la_lu_backward(int n, const double *A, int lda, double *b);

/* b [n] := U^-T b. */
void nsdae_la_solve_upper_transposed(int n, const double *U, int ldu, double *b);

/* C [p x r] := alpha A [n x p]^T B [n x r] + beta C. */
void nsdae_la_multiply_transposed(int n, int p, int r, double alpha, const double *A, int lda,
                                  const double *B, int ldb, double beta, double *C, int ldc);

/* y [n] := y + alpha A [n x p] x. */
void nsdae_la_add_product(int n, int p, double alpha, const double *A, int lda, const double *x,
                          double *y);

/* C [n x r] := C + alpha A [n x p] B [p x r]. */
void nsdae_la_add_products(int n, int r, int p, double alpha, const double *A, int lda,
                           const double *B, int ldb, double *C, int ldc);

/* C [n x r] := C + A [n x p] B [r x p]^T. */
void nsdae_la_add_outer(int n, int r, int p, const double *A, int lda, const double *B, int ldb,
                        double *C, int ldc);

/* Which columns w of a matrix, of which only the Gram matrix G = W^T P W is known, depend on
 * others. They are taken in turn, in an order that the caller decides; one whose pivot in the
 * Cholesky factor of G is none is a combination of those taken before it, w_p = sum c_l w_l. */

typedef struct nsdae_rank_revealing {
  int n;           /* of G, which may be smaller than the arrays */
  const double *G; /* n x n */
  double sine;     /* of the angle to those taken below which a column is none of its own */
  int taken_count, dependent_count;
  int *taken, *dependent, *before, *seen; /* in turn; taken before it; 1: was its turn */
  double *factor, *combination; /* n x n, by rows: of the factor; c of those that depend */
} nsdae_rank_revealing;

/* Takes the arrays for up to n columns. */
void nsdae_rank_revealing_layout(nsdae_rank_revealing *dependence, long n, nsdae_arena *arena);

/* Starts with G [n x n]; nothing is taken yet. */
void nsdae_rank_revealing_start(nsdae_rank_revealing *dependence, int n, const double *G);

/* What part of w_column, squared, those taken leave: 1 where it is orthogonal to them. */
double nsdae_rank_revealing_rest(nsdae_rank_revealing *dependence, int column);

/* Its turn. 1: it is independent. */
int nsdae_rank_revealing_take(nsdae_rank_revealing *dependence, int column);

/* Fills the combinations of all that depend. */
void nsdae_rank_revealing_combine(nsdae_rank_revealing *dependence);

/* Row `column` of one of the matrices. */
static inline double *nsdae_rank_revealing_row(const nsdae_rank_revealing *d, double *matrix,
                                               int column)
{
  return matrix + (size_t)column * (size_t)d->n;
}

#endif
