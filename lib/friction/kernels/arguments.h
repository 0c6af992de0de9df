/* A problem on plain arrays, u = W r + q with contacts of 1, 2 or 3 rows, and what its kernels ask
 * of their arguments. */
#ifndef NSDAE_FRICTION_ARGUMENTS_H
#define NSDAE_FRICTION_ARGUMENTS_H

/* The first six arguments of each kernel. */
typedef struct nsdae_fc_arguments {
  int nc;
  const int *rows; /* NULL: three each */
  const double *a;
  int lda;
  const double *q, *mu;
} nsdae_fc_arguments;

static inline int nsdae_fc_arguments_rows(const nsdae_fc_arguments *p, int c)
{
  return p->rows ? p->rows[c] : 3;
}

/* 0, or -i for the i-th argument; m: the rows of all contacts. With finite, entries of a and q are
 * looked at, too. */
int nsdae_fc_arguments_check(const nsdae_fc_arguments *p, int finite, int *m);

/* enum nsdae_fc_kind of contact c: without friction it is a normal row and others that do nothing.
 */
int nsdae_fc_arguments_kind(const nsdae_fc_arguments *p, int c);

/* D [9], row-major: the symmetric part of the diagonal block of contact c, whose first row is i, in
 * three rows (those that it has not are those of their mean); the mean of its diagonal is returned.
 */
double nsdae_fc_arguments_diagonal(const nsdae_fc_arguments *p, int c, int i, double *D);

#endif
