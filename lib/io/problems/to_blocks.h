/* From sparse matrices to rows by blocks: on arrays alone. */
#ifndef NSDAE_IO_GATHER_H
#define NSDAE_IO_GATHER_H

#include <nsdae/friction.h>
#include "hdf5_data.h"

/* ---- triplets.c: Sparse matrices in files of FCLIB: a group with m, n, nz, nzmax, p, i and x. */

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

/* ---- to_blocks.c */

/* Indices 0 .. n - 1 in parts. */
typedef struct nsdae_partition {
  int n, parts;
  int *of;   /* n: the part of an index, -1: none */
  int *at;   /* n: its place in it */
  int *size; /* parts, of which there is room for n */
} nsdae_partition;

/* Memory, with zeros. */
int nsdae_partition_create(nsdae_h5 *h5, int n, int parts, nsdae_partition *p);
/* The parts that entries of M join, in the order of their first index; or if none leaves it, all of
 * the same size `alike`, if that divides n. */
void nsdae_partition_find(nsdae_h5 *h5, const nsdae_triplets *M, int alike, nsdae_partition *p);
/* Parts of these sizes, one after another. */
void nsdae_partition_make(nsdae_h5 *h5, int n, int parts, const int *size, nsdae_partition *p);
void nsdae_partition_release(nsdae_partition *p);

/* Fills first, block and value of the problem: for each item (part of the columns) its blocks
 * (parts of the rows), in the order in which its entries come. Refuses entries outside the parts,
 * and more than 256 numbers for each entry, row and column of the matrix: memory is bounded by the
 * file. */
void nsdae_to_blocks(nsdae_h5 *h5, const nsdae_triplets *A, const nsdae_partition *rows,
                     const nsdae_partition *items, nsdae_friction_problem *problem);

/* The dense blocks of M on its parts, one after another; the same bound. */
double *nsdae_to_blocks_diagonal(nsdae_h5 *h5, const nsdae_triplets *M, const nsdae_partition *p);

/* A := (A + A^T) / 2, the entries of A before those of A^T; largest |A_ij - A_ji| / largest |A_ij|
 * comes back. If they differ by rounding alone A keeps its values, and 0 comes back. */
double nsdae_symmetrise(nsdae_h5 *h5, nsdae_triplets *A);

#endif
