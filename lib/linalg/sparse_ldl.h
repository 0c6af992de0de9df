/* L D L^T of the symmetric positive definite matrix of a multifrontal analysis, entry by entry, by
 * SuiteSparse's LDL (Davis, ACM Trans. Math. Softw. 31 (2005) 587), in the same order: for matrices
 * whose fronts are too small for LAPACK. Without LDL its work is infinite. */
#ifndef NSDAE_LINALG_SPARSE_LDL_H
#define NSDAE_LINALG_SPARSE_LDL_H

#include "multifrontal.h"

/* The elimination tree and work space of LDL, of `order` entries each. */
typedef struct nsdae_ldl_tree {
  int *parent, *count, *mark, *path;
} nsdae_ldl_tree;

/* Numbers are those of the elimination. */
typedef struct nsdae_sparse_ldl {
  int order;
  int *first, *row;      /* upper triangle by columns: order + 1, entries */
  size_t *from;          /* entries: place in the matrix A of the analysis */
  int *begin, *below;    /* L by columns: order + 1, fill */
  double *A, *L, *D, *x; /* entries, fill, order, order */
  size_t entries, fill;
  double smallest; /* pivot of the last factorisation, in parts of its diagonal entry */
  nsdae_ldl_tree tree;
  nsdae_arena memory;
} nsdae_sparse_ldl;

/* Multiplications of a factorisation; HUGE_VAL: it is not possible. */
double nsdae_sparse_ldl_work(const nsdae_multifrontal *analysed);

/* NSDAE_OK or NSDAE_E_MEMORY. */
int nsdae_sparse_ldl_analyse(nsdae_sparse_ldl *ldl, const nsdae_multifrontal *analysed);

/* Factors the matrix A of the analysis. 0, or 1 if a pivot is at most `drop` times its diagonal
 * entry. */
int nsdae_sparse_ldl_factor(nsdae_sparse_ldl *ldl, const nsdae_multifrontal *analysed, double drop);

/* x := A^-1 x, as nsdae_multifrontal_solve. */
void nsdae_sparse_ldl_solve(const nsdae_sparse_ldl *ldl, const nsdae_multifrontal *analysed,
                            double *x);

void nsdae_sparse_ldl_release(nsdae_sparse_ldl *ldl);

#endif
