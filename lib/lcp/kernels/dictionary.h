/* A dictionary of the augmented problem y = A x + d z0 + b,
 *
 *   basic_i = q_i + sum_j C_ij nonbasic_j,   C = D + U V^T,
 *
 * condensed: the n x (n + 1) coefficients of the nonbasic variables alone. Exchanging basic_r and
 * nonbasic_e, with c the column e and w the row r of C, is of rank one:
 *
 *   C_ij -= c_i w_j / c_r,   C_rj = -w_j / c_r,   C_ie = c_i / c_r,   C_re = 1 / c_r.
 *
 * Small ones are brought up to date at once. In large ones the pivot makes a column of U and of V,
 * for which row r and column e of D, U and V become zero: no subtraction that is not in the
 * formula; when the block is full, D takes it all in one matrix product. */
#ifndef NSDAE_LCP_DICTIONARY_H
#define NSDAE_LCP_DICTIONARY_H

typedef struct nsdae_dictionary {
  int n, block, pending;        /* block 0: everything at once */
  double *D, *q;                /* n x (n + 1), n */
  double *U, *V;                /* n x block, (n + 1) x block */
  double *column, *row, *along; /* n, n + 1, block: of C; a row of U or V */
} nsdae_dictionary;

/* Doubles that it works in. */
int nsdae_dictionary_size(int n, int block);

/* y = A x + d z0 + b with y_r and z0 exchanged; d NULL: ones. Column j < n is that of x_j, n that
 * of y_r. Returns 0, or 1 where A has an entry that is not finite. */
int nsdae_dictionary_start(nsdae_dictionary *t, int n, int block, const double *a, int lda,
                           const double *b, const double *d, int r, double *work);

/* Column j of C [n]; valid until the next of these calls. */
const double *nsdae_dictionary_column(nsdae_dictionary *t, int j);
double nsdae_dictionary_entry(const nsdae_dictionary *t, int i, int j);

/* q after the exchange of row r with the column c. */
void nsdae_dictionary_move(nsdae_dictionary *t, int r, const double *c);

/* Exchanges basic_r and nonbasic_e; c is column e as just asked for. */
void nsdae_dictionary_pivot(nsdae_dictionary *t, int r, int e, const double *c);

/* ---- lemke.c: nsdae_dlemke with the number of pivots that the dictionary puts off (0: none). */

/* The block that nsdae_dlemke takes for n, where its work is long enough. */
int nsdae_lemke_block(int n);

/* The arguments are taken for right; work [nsdae_dictionary_size(n, block)]. */
int nsdae_lemke(int n, int block, const double *a, int lda, const double *b, const double *d,
                int max_pivots, double *x, int *basis, int *pivots, double *work, int *iwork);

#endif
