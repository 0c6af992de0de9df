/* Sparse matrices in files of FCLIB: a group with m, n, nz, nzmax, p, i and x. */
#ifndef NSDAE_IO_TRIPLETS_H
#define NSDAE_IO_TRIPLETS_H

#include "hdf5_data.h"

/* Entries in the order of the file; the same place may stand there more than once, and then counts
 * as their sum. */
typedef struct nsdae_triplets {
  int rows, columns, count;
  int *row, *column; /* count, from 0 */
  double *value;     /* count, finite */
} nsdae_triplets;

/* Reads the group ROOT/NAME in any of the three forms: nz = -1 compressed columns, -2 compressed
 * rows, >= 0 this number of triplets. Refuses indices out of range and values that are not finite.
 * Empty if it is neither needed nor there. */
void nsdae_triplets_read(nsdae_h5 *h5, const char *root, const char *name, int needed,
                         nsdae_triplets *t);

/* Writes ROOT/NAME as triplets, with p the columns and i the rows. */
int nsdae_triplets_write(nsdae_h5 *h5, const char *root, const char *name, const nsdae_triplets *t);

/* Room for count entries more. */
int nsdae_triplets_grow(nsdae_h5 *h5, nsdae_triplets *t, int count);
/* Adds an entry, for which there is room. */
void nsdae_triplets_add(nsdae_triplets *t, int row, int column, double value);
void nsdae_triplets_release(nsdae_triplets *t);

#endif
