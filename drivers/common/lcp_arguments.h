/* Complementarity problems from text files.
 *
 * A file is numbers separated by blanks; text after the last is a comment:
 *
 *   n  matrix  q [n]                          y = A x + q
 *   2  k  matrix  q [2 k]  mu [k]             k planar contacts with Coulomb friction: Delassus
 *                                             matrix and free velocity, normal and tangential
 *                                             interleaved
 *   matrix := 0 rows columns rows columns values        dense, column-major
 *           | 1 rows columns blocks                     square blocks of dense values
 *           | 2 rows columns origin text                compressed columns, as CSparse prints them
 *   blocks := number, block rows, block columns, ends of the block rows, ends of the block columns,
 *             sizes of two indices, row pointers, block columns, then for each block its number
 *             and its values, column-major
 *
 * Planar contacts become the problem with x = [Lambda_N, Lambda_R, xi_L] for each. */
#ifndef NSDAE_DRIVER_LCP_FILE_H
#define NSDAE_DRIVER_LCP_FILE_H

#include <nsdae/nsdae.h>

typedef struct lcp_file {
  int n;        /* rows of the complementarity problem */
  double *A;    /* n x n, column-major */
  double *b;    /* n */
  int contacts; /* k; 0 where the file holds a complementarity problem itself */
} lcp_file;

/* NSDAE_OK, NSDAE_E_IO (no such file, or not of this form), NSDAE_E_MEMORY, NSDAE_E_UNSUPPORTED
 * (spatial contacts). On an error the struct holds nothing and error says what and where. */
int lcp_file_read(const char *path, lcp_file *file, nsdae_error *error);

void lcp_file_release(lcp_file *file);

#endif
