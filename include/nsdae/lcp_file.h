/* nsdae: complementarity problems in HDF5 files. BSD-3-Clause.
 *
 * A file has two datasets of numbers: /A [n, n], A(i, j) at [i, j] as NumPy writes a matrix, and
 * /b [n]. Optional attributes of the root say where it comes from: time [s], step, method, and tol,
 * the residual that was asked for. */
#ifndef NSDAE_LCP_FILE_H
#define NSDAE_LCP_FILE_H

#include <nsdae/lcp.h>

#ifdef __cplusplus
extern "C" {
#endif

/* Where a problem comes from. */
typedef struct nsdae_lcp_origin {
  double time;        /* [s] */
  long step;          /* that failed, from 1 */
  double tol;         /* bound on the residual, > 0 */
  const char *method; /* its name */
} nsdae_lcp_origin;

/* A problem as read. */
typedef struct nsdae_lcp_file {
  int n;      /* rows */
  double *A;  /* n x n, column-major, lda = max(1, n) */
  double *b;  /* n; both from malloc, freed by nsdae_lcp_file_release */
  double tol; /* of the attribute; 0 where there is none */
} nsdae_lcp_file;

/* Writes the problem, replacing a file of that name; origin may be NULL.
 * NSDAE_E_IO: the text says why; NSDAE_E_ARGUMENT; NSDAE_E_MEMORY; NSDAE_E_UNSUPPORTED: built
 * without HDF5. error may be NULL. */
NSDAE_API int nsdae_lcp_write(const char *path, const nsdae_lcp_problem *problem,
                              const nsdae_lcp_origin *origin, nsdae_error *error);

/* Reads a problem, n at most 20000; on an error the struct holds nothing. As above; NSDAE_E_IO
 * also where a dataset is missing or is not of this shape. */
NSDAE_API int nsdae_lcp_read(const char *path, nsdae_lcp_file *file, nsdae_error *error);

/* Releases what was read; NULL is allowed. */
NSDAE_API void nsdae_lcp_file_release(nsdae_lcp_file *file);

#ifdef __cplusplus
}
#endif
#endif
