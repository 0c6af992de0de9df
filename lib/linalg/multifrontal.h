/* Sparse matrices of dense blocks whose pattern is symmetric, factored by fronts (multifrontal
 * method: Duff and Reid, ACM Trans. Math. Softw. 9 (1983) 302): the columns of a supernode and what
 * they leave of the rest are dense matrices, so that the work is LAPACK's. A symmetric positive
 * definite matrix is L L^T, a quasi-definite one L S L^T with signs S (Vanderbei, SIAM J. Optim. 5
 * (1995) 100), any other L U with rows exchanged inside a supernode alone: it is for matrices that
 * need no more than that. */
#ifndef NSDAE_LINALG_FRONTS_H
#define NSDAE_LINALG_FRONTS_H

#include "symbolic.h"

/* The matrix: its blocks, kept to see whether the next one has the same. */
typedef struct nsdae_multifrontal_graph {
  int n;            /* blocks */
  int *size;        /* n: rows of each */
  int *first;       /* n + 1: where the neighbours of each begin in index */
  int *index;       /* first[n] */
  size_t *at;       /* first[n]: in A, the block in row index[a] of column i, column-major */
  int *twin;        /* first[n]: the entry of the transposed block */
  size_t *diagonal; /* n: the block (i, i) */
} nsdae_multifrontal_graph;

/* The supernodes of its tree. */
typedef struct nsdae_supernodes {
  int count;
  int *begin;     /* count + 1: first number of each */
  int *pivots;    /* count: its columns */
  int *rest;      /* count: its rows below */
  size_t *factor; /* count + 1: where its part of F begins: pivot block, rows, columns */
  int *children;  /* count: how many leave something to it */
  size_t most_front, most_stack;
  int most_rest;
} nsdae_supernodes;

/* Of a symmetric matrix that is positive semidefinite up to rounding: a pivot of at most `drop`
 * times its diagonal entry is dropped. Its entry of every solution is zero. */
typedef struct nsdae_multifrontal_rank {
  double drop;     /* set before the factorisation; 0: none is dropped */
  int *forced;     /* order, permuted: set to 1 before, it is dropped in any case */
  int *is_dropped; /* order, permuted: was by the last factorisation */
  double *part;    /* order, permuted: pivots, as parts of their diagonal entries */
} nsdae_multifrontal_rank;

typedef struct nsdae_multifrontal_work {
  double *front;  /* largest front */
  double *stack;  /* contributions of children */
  double *vector; /* order: permuted right-hand side */
  double *gather; /* largest rest */
  int *exchange;  /* order: of rows */
  int *local;     /* n: where a number begins in the front at hand */
  int *waiting;   /* n: supernodes whose rest is on the stack */
} nsdae_multifrontal_work;

typedef struct nsdae_multifrontal {
  int negative; /* set before: blocks from this on have negative pivots; 0: none */
  nsdae_symbolic tree;
  nsdae_multifrontal_graph graph;
  nsdae_supernodes super;
  int order;     /* rows */
  int symmetric; /* of the last factorisation */
  double *A;     /* the matrix, to be filled by the caller */
  size_t values; /* of A */
  int *place;    /* n + 1: first row of number k in the permuted vectors */
  double *F;     /* the factors */
  nsdae_multifrontal_work work;
  nsdae_multifrontal_rank rank;
  nsdae_arena of_graph, of_numbers;
} nsdae_multifrontal;

/* Analyses the graph (neighbours of block i, without i, ascending, in both directions) of n blocks
 * of these sizes; nothing is done where it is the one of the last call. Then A holds graph.at[] and
 * graph.diagonal[]. NSDAE_OK or NSDAE_E_MEMORY. A struct of zeros is one without memory. */
int nsdae_multifrontal_analyse(nsdae_multifrontal *f, int n, const int *size, const int *first,
                               const int *index);

/* Where in A the block in this row and column is; the two share an edge or are the same. */
size_t nsdae_multifrontal_block(const nsdae_multifrontal *f, int row, int column);

/* Factors what is in A. Returns 0, or > 0 where a pivot is zero or not positive. */
int nsdae_multifrontal_factor(nsdae_multifrontal *f, int symmetric);

/* Rows of the block with this number. */
static inline int nsdae_multifrontal_size(const nsdae_multifrontal *f, int number)
{
  return f->graph.size[f->tree.node[number]];
}

/* Place of row r of block i in the permuted vectors. */
static inline int nsdae_multifrontal_place(const nsdae_multifrontal *f, int i, int r)
{
  return f->place[f->tree.number[i]] + r;
}

/* x [order] := A^-1 x; the rows of the blocks in the order of the blocks. */
void nsdae_multifrontal_solve(const nsdae_multifrontal *f, double *x);

void nsdae_multifrontal_release(nsdae_multifrontal *f);

#endif
