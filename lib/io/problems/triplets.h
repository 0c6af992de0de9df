/* Sparse matrices in files of FCLIB: a group with m, n, nz, nzmax, p, i and x. */
#ifndef NSDAE_IO_TRIPLETS_H
#define NSDAE_IO_TRIPLETS_H

#include "errors.h"
#include "hdf5_read.h"

/* Entries in the order of the file; the same place may stand there more than once, and then counts
 * as their sum. */
typedef struct nsdae_triplets {
  int rows, columns, count;
  int *row, *column; /* count, from 0 */
  double *value;     /* count, finite */
} nsdae_triplets;

/* Reads any of the three forms: nz = -1 compressed columns, -2 compressed rows, >= 0 this number of
 * triplets. Refuses indices out of range and values that are not finite. */
int nsdae_triplets_read(nsdae_h5 *h5, const char *group, nsdae_triplets *t);

/* Writes triplets, with p the columns and i the rows. */
int nsdae_triplets_write(nsdae_h5 *h5, const char *group, const nsdae_triplets *t);

/* Room for count entries more; NSDAE_E_MEMORY. */
int nsdae_triplets_grow(nsdae_h5 *h5, nsdae_triplets *t, int count);
/* Adds an entry, for which there is room. */
void nsdae_triplets_add(nsdae_triplets *t, int row, int column, double value);
void nsdae_triplets_release(nsdae_triplets *t);

/* A vector of the file, of that length, finite; from malloc, NULL where it is not there and need
 * not be. */
int nsdae_h5_take_reals(nsdae_h5 *h5, const char *path, int needed, int length, double **values);
/* The same of integers. */
int nsdae_h5_take_ints(nsdae_h5 *h5, const char *path, int needed, int length, int **values);
/* Its length, at most most; -1 in *length where it is not there. */
int nsdae_h5_length(nsdae_h5 *h5, const char *path, long most, int *length);
/* Whether there is an object of that name, each group on the way looked at. */
int nsdae_h5_has(nsdae_h5 *h5, const char *path);

/* "cannot read 'FILE': ..." */
int nsdae_h5_refuse(nsdae_h5 *h5, const char *format, ...) NSDAE_PRINTF(2, 3);
/* NSDAE_E_MEMORY, "out of memory for 'FILE'" */
int nsdae_h5_no_memory(nsdae_h5 *h5);

#endif
