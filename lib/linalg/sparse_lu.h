/* LU factors of a sparse matrix in memory of their own: A with its columns ordered by COLAMD
 * (Davis, Gilbert, Larimore and Ng, ACM TOMS 30, 2004) and its rows by threshold pivoting,
 *
 *     P A Q = L U,   column k of L and U from  L x = P A q_k,
 *
 * column by column, each in time proportional to its operations (Gilbert and Peierls, SIAM J. Sci.
 * Stat. Comput. 9, 1988). A matrix of a pattern that was factored before keeps Q, P and the
 * patterns of L and U while its pivots allow it. No call allocates: there is room for factors
 * without a zero, which KLU, of the same method, allocates as it goes. */
#ifndef NSDAE_LINALG_SPARSE_LU_H
#define NSDAE_LINALG_SPARSE_LU_H

#include "arena.h"

/* A triangle by columns. */
typedef struct nsdae_triangle {
  int *first, *row; /* n + 1, n (n + 1) / 2 */
  double *value;    /* n (n + 1) / 2 */
} nsdae_triangle;

typedef struct nsdae_sparse_lu {
  int n;
  int *first, *row;       /* n + 1, n^2: pattern of A by columns, all entries ever not zero */
  unsigned char *seen;    /* n^2: the same, as a matrix */
  int *column, *position; /* n: Q; the place of a row of A in P, -1 while it has none */
  nsdae_triangle L, U;    /* L without its ones, rows of A; U with places, its diagonal last */
  int *stack, *at, *mark; /* n: of the search */
  double *x;              /* n: the column at work, by rows of A */
  int *work;              /* of AMD; places to rows of A */
  int ordered, factored;  /* Q belongs to the pattern; P and the patterns of L and U do */
} nsdae_sparse_lu;

/* Takes the arrays; n is set before. */
void nsdae_sparse_lu_layout(nsdae_sparse_lu *lu, nsdae_arena *arena);

/* Forgets every pattern: what follows is as after the layout, to the last bit. */
void nsdae_sparse_lu_forget(nsdae_sparse_lu *lu);

/* Factors A [n x n], dense with its zeros. Returns 0, or i > 0 where the i-th pivot is zero or not
 * a number. */
int nsdae_sparse_lu_factor(nsdae_sparse_lu *lu, const double *A, int lda);

/* b [n] := A^-1 b. */
void nsdae_sparse_lu_solve(const nsdae_sparse_lu *lu, double *b);

#endif
