/* Which columns w of a matrix, of which only the Gram matrix G = W^T P W is known, depend on
 * others. They are taken in turn, in an order that the caller decides; one whose pivot in the
 * Cholesky factor of G is none is a combination of those taken before it, w_p = sum c_l w_l. */
#ifndef NSDAE_LINALG_DEPENDENCE_H
#define NSDAE_LINALG_DEPENDENCE_H

#include "arena.h"

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
